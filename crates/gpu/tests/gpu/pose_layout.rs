//! What Rust writes for the stage `pose` is what it reads.

use umbrage_gpu::internals::link_with;
use umbrage_gpu::pose::{Influences, PosePart, PoseShape, PoseSize};

use crate::layout::{differences, layout, module, other_constants};

#[test]
fn structs_are_those_of_the_shader() {
    let shader = module(&link_with(&[], "pose::pose"));
    let layouts = [
        layout!(PoseSize { vertices, parts, matrix_word, normal_word, tangent_word }),
        layout!(PosePart { first_posed, first_vertex, shape, first_weight, matrix, is_skinned }),
        layout!(PoseShape {
            position_word,
            normal_word,
            tangent_word,
            influence_word,
            influence_words,
            influence_sets,
            target_word,
            targets,
        }),
    ];
    for of_rust in layouts {
        assert_eq!(differences(&shader, &of_rust), [""; 0]);
    }
}

#[test]
fn constants_are_those_of_the_shader() {
    let shader = module(&link_with(&[], "pose::pose"));
    let constants = [
        ("NO_ATTRIBUTE", PoseShape::NO_ATTRIBUTE),
        ("DENSE_DELTAS", PoseShape::DENSE_DELTAS),
        ("TARGET_WORDS", PoseShape::TARGET_WORDS),
        ("INFLUENCE_WORDS", (size_of::<Influences>() / 4) as u32),
        ("MATRIX_WORDS", glam::Affine3A::IDENTITY.to_cols_array().len() as u32),
    ];
    assert_eq!(other_constants(&shader, &constants), [""; 0]);
}
