// Writes to a buffer `points` declared by the stage.

import package::exact::double::{F64};
import package::exact::shadow::{ExactPoint};
import package::onward::points::{POINT_PIXEL, POINT_T, POINT_TRIANGLE, POINT_WORDS};
import stage::{points};

fn put_point_number(word: u32, number: F64) {
    points[word] = number.x;
    points[word + 1u] = number.y;
}

fn put_point(number: u32, point: ExactPoint, t: F64, triangle: u32, pixel: u32) {
    let word = number * POINT_WORDS;
    put_point_number(word, point.position.x);
    put_point_number(word + 2u, point.position.y);
    put_point_number(word + 4u, point.position.z);
    put_point_number(word + 6u, point.error);
    put_point_number(word + POINT_T, t);
    points[word + POINT_TRIANGLE] = triangle;
    points[word + POINT_PIXEL] = pixel;
}
