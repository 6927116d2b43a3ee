// The projection of a space that a stage declares in `spaces`: origin, matrix rows, and terms added to x and y.

import package::exact::double::{F64};
import package::exact::vector::{F64Vector};
import package::exact::wide::{Wide, WideVector, wide_from_f64};
import stage::{spaces};

fn projection_term(face: u32, term: u32) -> F64 {
    let pair = spaces[face].projection[term >> 1u];
    return select(pair.xy, pair.zw, (term & 1u) == 1u);
}

fn projection_vector(face: u32, first: u32) -> F64Vector {
    return F64Vector(projection_term(face, first), projection_term(face, first + 1u), projection_term(face, first + 2u));
}

fn wide_projection_term(face: u32, term: u32) -> Wide {
    return wide_from_f64(projection_term(face, term));
}

fn wide_projection_vector(face: u32, first: u32) -> WideVector {
    return WideVector(
        wide_projection_term(face, first), wide_projection_term(face, first + 1u), wide_projection_term(face, first + 2u));
}
