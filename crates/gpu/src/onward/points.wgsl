// Hit points, in a buffer `points` declared by the stage.

import package::exact::double::{F64};
import package::exact::shadow::{ExactPoint};
import package::exact::vector::{F64Vector};
import stage::{points};

// Words of a point: position and error (F64), triangle, pixel, and the ray's t (F64).
const POINT_T: u32 = 10u;
const POINT_TRIANGLE: u32 = 8u;
const POINT_PIXEL: u32 = 9u;
const POINT_WORDS: u32 = 12u;

fn point_number(word: u32) -> F64 {
    return F64(points[word], points[word + 1u]);
}

fn read_exact_point(number: u32) -> ExactPoint {
    let word = number * POINT_WORDS;
    let position = F64Vector(point_number(word), point_number(word + 2u), point_number(word + 4u));
    return ExactPoint(position, point_number(word + 6u));
}
