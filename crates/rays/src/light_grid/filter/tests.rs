//! Parts of the filter, on all SIMD levels. What it decides is compared with real numbers beside `set_up`.

use super::*;
use crate::SimdLevel;
use crate::dispatch;
use crate::light_grid::boxes::FaceBox;
use crate::random::Random;

const TRIALS: usize = 10_000;

/// A number of either sign from many orders of magnitude, sometimes zero.
fn any(random: &mut Random) -> f32 {
    let size = if random.unit() < 0.1 { 0.0 } else { random.power(-9.0, 3.0) };
    (random.signed().signum() * size) as f32
}

#[test]
fn the_most_of_a_function_is_at_the_ends_that_its_signs_name() {
    let mut random = Random::new(1);
    for _ in 0..TRIALS {
        let [a, b, c] = [(); 3].map(|()| any(&mut random));
        let c = if random.unit() < 0.1 { f32::INFINITY } else { c };
        let mut ranges = || {
            let ends = [(); LANES].map(|()| [any(&mut random), any(&mut random)]);
            [ends.map(|[p, q]| p.min(q)), ends.map(|[p, q]| p.max(q))]
        };
        let (x, y) = (ranges(), ranges());
        for level in SimdLevel::available() {
            let (found, named): ([f32; LANES], [f32; LANES]) = dispatch!(level, simd => {
                let (x, y) = ([load(simd, &x[0]), load(simd, &x[1])], [load(simd, &y[0]), load(simd, &y[1])]);
                let named = line(simd, [a, b, c], x[usize::from(a > 0.0)], y[usize::from(b > 0.0)]);
                (most(simd, [a, b, c], x, y).into(), named.into())
            });
            assert_eq!(found, named, "{a} x + {b} y + {c} in {x:?}, {y:?}");
        }
    }
}

#[test]
fn functions_without_numbers_touch_all_but_empty_slots() {
    let mut boxes = SixteenBoxes::NO_POINTS;
    for slot in 0..LANES / 2 {
        boxes.set(slot, FaceBox { x: [-1.0, 1.0], y: [-1.0, 1.0], nearness: 0.0 });
    }
    for level in SimdLevel::available() {
        for function in 0..4 {
            // Above zero everywhere, but for one that is NaN.
            let mut quads = [[0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 1.0, 1.0]];
            let [row, column] = if function < 3 { [function, 2] } else { [2, 3] };
            quads[row][column] = f32::NAN;
            let touched = dispatch!(level, simd => may_touch(simd, &quads, &boxes));
            assert_eq!(touched, 0xff, "{function} at {level}");
        }
    }
}
