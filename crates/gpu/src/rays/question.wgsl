// Writes shadow questions for the light `shadow_light` to the buffer `records`; a stage declares both.

import package::exact::cone::{exact_is_in_cone};
import package::exact::shadow::{ExactPoint};
import package::rays::records::{
    NO_TRIANGLE, RECORD_OWN, RECORD_TAG, SHADOW_ERROR, SHADOW_IS_DIRECTIONAL, SHADOW_LIGHT,
};
import package::rays::write::{put_number, put_vector};
import stage::{shadow_light, records};

// Writes an empty question, for a slot without a point.
fn put_no_question(word: u32) {
    records[word + RECORD_OWN] = NO_TRIANGLE;
    records[word + RECORD_TAG] = NO_TRIANGLE;
}

// Writes the question for a point of a triangle; an empty one if the point is outside of the light's cone.
fn put_question(word: u32, point: ExactPoint, triangle: u32, tag: u32) {
    records[word + RECORD_OWN] = triangle;
    records[word + RECORD_TAG] = NO_TRIANGLE;
    if shadow_light.has_cone != 0u
        && !exact_is_in_cone(point.position, shadow_light.vector, shadow_light.axis, shadow_light.squared_cosine) {
        return;
    }
    put_question_to(word, point, triangle, tag, shadow_light.vector, shadow_light.is_directional);
}

// Writes the question for a point of a triangle and a light of any position or direction.
fn put_question_to(word: u32, point: ExactPoint, triangle: u32, tag: u32, light: vec3<u32>, is_directional: u32) {
    records[word + RECORD_OWN] = triangle;
    put_vector(word, point.position);
    put_number(word + SHADOW_ERROR, point.error);
    for (var axis = 0u; axis < 3u; axis++) {
        records[word + SHADOW_LIGHT + axis] = light[axis];
    }
    records[word + SHADOW_IS_DIRECTIONAL] = is_directional;
    records[word + RECORD_TAG] = tag;
}
