// Reads rays and shadow questions from `records`.

import package::exact::double::{F64};
import package::exact::predicate::{ExactRay};
import package::exact::shadow::{ExactPoint, ExactShadow, exact_shadow};
import package::exact::vector::{F64Vector};
import package::rays::records::{RAY_DIRECTION, SHADOW_ERROR, SHADOW_IS_DIRECTIONAL, SHADOW_LIGHT};
import stage::{records};

fn read_number(word: u32) -> F64 {
    return F64(records[word], records[word + 1u]);
}

fn read_vector(word: u32) -> F64Vector {
    return F64Vector(read_number(word), read_number(word + 2u), read_number(word + 4u));
}

fn read_ray(word: u32) -> ExactRay {
    return ExactRay(read_vector(word), read_vector(word + RAY_DIRECTION));
}

// The point of a question.
fn read_point(word: u32) -> ExactPoint {
    return ExactPoint(read_vector(word), read_number(word + SHADOW_ERROR));
}

// The shadow ray of a question with its point.
fn read_shadow(word: u32, point: ExactPoint) -> ExactShadow {
    let light = vec3(
        records[word + SHADOW_LIGHT], records[word + SHADOW_LIGHT + 1u], records[word + SHADOW_LIGHT + 2u],
    );
    return exact_shadow(records[word + SHADOW_IS_DIRECTIONAL] != 0u, light, point);
}
