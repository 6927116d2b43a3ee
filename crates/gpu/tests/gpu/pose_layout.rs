//! What Rust writes for the stage `pose` is what it reads.

use umbrage_gpu::pose::{Influences, PosePart, PoseShape, PoseSize};

use crate::layout::{constant, differences, layout, module};

/// The declarations, whose functions need what the shader imports.
fn declarations() -> naga::Module {
    let text = include_str!("../../src/pose/pose.wgsl");
    module(text.split_once("@compute").map_or(text, |(before, _)| before))
}

#[test]
fn structs_are_those_of_the_shader() {
    let shader = declarations();
    let layouts = [
        layout!(PoseSize { places, parts, matrix_word, normal_word, tangent_word }),
        layout!(PosePart { first_place, first_vertex, shape, first_weight, matrix, is_skinned }),
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
    let shader = declarations();
    for (name, value) in [
        ("NO_ATTRIBUTE", PoseShape::NO_ATTRIBUTE),
        ("DENSE_DELTAS", PoseShape::DENSE_DELTAS),
        ("TARGET_WORDS", PoseShape::TARGET_WORDS),
        ("INFLUENCE_WORDS", (size_of::<Influences>() / 4) as u32),
        ("MATRIX_WORDS", glam::Affine3A::IDENTITY.to_cols_array().len() as u32),
    ] {
        assert_eq!(constant(&shader, name), Some(value), "{name}");
    }
}
