//! Boxes moved from a face to a tile and back, compared with f64, whose own error is negligible.

use super::*;
use crate::random::Random;

const TRIALS: u64 = 30_000;

/// A box, and a tile's origin and its points' errors, of sizes from many orders of magnitude.
fn random_box(random: &mut Random) -> (FaceBox, Extent) {
    let mut range = |most: f64| {
        let ends = [0; 2]
            .map(|_| (random.signed() * most * if random.unit() < 0.7 { 1.0 } else { random.power(-6.0, 0.0) }) as f32);
        [ends[0].min(ends[1]), ends[0].max(ends[1])]
    };
    let (x, y) = (range(2.0), range(2.0));
    let origin = [range(1.0)[0], range(1.0)[1], 0.0];
    let size = random.power(-6.0, 6.0);
    let mut nearness = || (random.signed() * size) as f32;
    let one = FaceBox { x, y, nearness: nearness() };
    let origin = [origin[0], origin[1], nearness()];
    let errors = [1.0 / 4096.0, size].map(|most| (most * random.unit().round() * random.power(-6.0, 0.0)) as f32);
    (one, Extent { origin, errors, ..Extent::default() })
}

/// Whether a box holds another that is moved by `sign` times a tile's origin and grown by `error`.
fn holds(outer: &FaceBox, inner: &FaceBox, extent: &Extent, sign: f64, error: f32) -> bool {
    let [x, y, _] = extent.origin.map(|at| sign * f64::from(at));
    let error = f64::from(error);
    let holds = |outer: [f32; 2], inner: [f32; 2], by: f64| {
        f64::from(outer[0]) <= f64::from(inner[0]) + by - error
            && f64::from(outer[1]) >= f64::from(inner[1]) + by + error
    };
    holds(outer.x, inner.x, x) && holds(outer.y, inner.y, y)
}

#[test]
fn boxes_in_a_tile_hold_what_may_be_found_in_those_on_the_face() {
    let mut random = Random::new(1);
    for _ in 0..TRIALS {
        let (on_face, extent) = random_box(&mut random);
        let moved = in_tile(&extent, &on_face);
        let [error, nearness_error] = extent.errors;
        let nearest = f64::from(on_face.nearness) - f64::from(extent.origin[2]) + f64::from(nearness_error);
        assert!(holds(&moved, &on_face, &extent, -1.0, error), "{moved:?} of {on_face:?}, {extent:?}");
        assert!(f64::from(moved.nearness) >= nearest, "{moved:?} of {on_face:?}, {extent:?}");
    }
}

#[test]
fn boxes_on_the_face_hold_those_in_a_tile() {
    let mut random = Random::new(2);
    let mut boxes = Vec::new();
    for _ in 0..TRIALS {
        let (in_tile, extent) = random_box(&mut random);
        let mut part = TilePart::EMPTY;
        part.whole = in_tile;
        let all = boxes_on_face(&extent, &[part], &mut boxes);
        let farthest = f64::from(in_tile.nearness) + f64::from(extent.origin[2]);
        for moved in [all, boxes[0].get(0)] {
            assert!(holds(&moved, &in_tile, &extent, 1.0, 0.0), "{moved:?} of {in_tile:?}, {extent:?}");
            assert!(f64::from(moved.nearness) <= farthest, "{moved:?} of {in_tile:?}, {extent:?}");
        }
    }
}
