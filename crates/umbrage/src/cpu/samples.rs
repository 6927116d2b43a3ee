//! One sample of each pixel, out of the image of all samples that were traced together.

use std::array;

use glam::UVec2;
use umbrage_rays::{LightMask, SeenPixels, TileOrder};

use crate::sampling::Samples;
use crate::shade::lanes::{Each, LANES};

/// Positions of one sample of each pixel in the image of all samples.
#[derive(Clone, Copy)]
pub(super) struct OneSample {
    /// The order of the image of all samples.
    order: TileOrder,
    /// Samples along a pixel's sides.
    side: u32,
    /// The sample's column and row in the pixel.
    quarter: [u32; 2],
}

/// Hits and light masks of the last of some samples alone.
pub(crate) fn last_alone(samples: &Samples, seen: &SeenPixels, masks: &[LightMask]) -> (SeenPixels, Vec<LightMask>) {
    let (width, height) = seen.order().size();
    let pixels = TileOrder::new(width / samples.side(), height / samples.side());
    OneSample::new(seen.order(), samples, samples.as_slice().len() - 1).alone(pixels, seen, masks)
}

/// The slots of one sample of each pixel of a block.
pub(super) enum Slots {
    /// Those of this block of samples: the image has one sample of each pixel.
    Block(usize),
    Apart(Each<usize>),
}

impl OneSample {
    /// Sample number `which` of those whose image has this order.
    pub(super) fn new(order: TileOrder, samples: &Samples, which: usize) -> Self {
        Self { order, side: samples.side(), quarter: samples.quarter(which) }
    }

    /// The slots of the pixels of the block with this corner, which is in the image.
    #[inline(always)]
    pub(super) fn slots(&self, UVec2 { x, y }: UVec2) -> Slots {
        let Self { order, side, quarter: [column, row] } = *self;
        if side == 1 {
            return Slots::Block(order.index(x, y) / LANES);
        }
        Slots::Apart(array::from_fn(|lane| {
            let (x, y) = (x + lane as u32 % TileOrder::BLOCK, y + lane as u32 / TileOrder::BLOCK);
            order.index(side * x + column, side * y + row)
        }))
    }

    /// The triangles and light masks of this sample alone, in the order of an image's `pixels`.
    fn alone(&self, pixels: TileOrder, seen: &SeenPixels, masks: &[LightMask]) -> (SeenPixels, Vec<LightMask>) {
        let (width, height) = pixels.size();
        let (mut alone, mut alone_masks) = (SeenPixels::default(), vec![LightMask::default(); masks.len()]);
        alone.resize(width, height);
        alone_masks.iter_mut().for_each(|mask| mask.resize(pixels));
        for block in 0..pixels.slots() / LANES {
            let (x, y) = pixels.column_and_row(block * LANES);
            let slots = (x < width && y < height).then(|| self.slots(UVec2::new(x, y)));
            let lanes = block * LANES..(block + 1) * LANES;
            let none = ([SeenPixels::NONE; LANES], [f32::NAN; LANES]);
            let of_block = |slots: &Slots| (slots.of(&seen.triangle), slots.of(&seen.inverse_depth));
            let (triangles, inverse_depths) = slots.as_ref().map_or(none, of_block);
            alone.triangle[lanes.clone()].copy_from_slice(&triangles);
            alone.inverse_depth[lanes].copy_from_slice(&inverse_depths);
            for (alone, mask) in alone_masks.iter_mut().zip(masks) {
                alone.blocks_mut()[block] = slots.as_ref().map_or(0, |slots| slots.lit(mask));
            }
        }
        (alone, alone_masks)
    }
}

impl Slots {
    /// These samples' values out of those of all samples.
    #[inline(always)]
    pub(super) fn of<T: Copy>(&self, all: &[T]) -> Each<T> {
        match self {
            Self::Block(block) => all.as_chunks().0[*block],
            Self::Apart(slots) => slots.map(|slot| all[slot]),
        }
    }

    /// A mask of the samples that a light reaches, the first in the lowest bit.
    #[inline(always)]
    pub(super) fn lit(&self, mask: &LightMask) -> u16 {
        let words = mask.blocks();
        match self {
            Self::Block(block) => words[*block],
            Self::Apart(slots) => {
                slots.iter().rev().fold(0, |bits, slot| bits << 1 | (words[slot / LANES] >> (slot % LANES) & 1))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use umbrage_rays::SimdLevel;

    use super::*;
    use crate::background::Surroundings;
    use crate::cpu::Cpu;
    use crate::engine::{Engine as _, Output, Staged};
    use crate::renderer::at_once;
    use crate::{Film, Settings, Stats, Structure};

    /// The triangles and light masks of a frame's samples, by the samples' numbers.
    type Shown = Vec<(SeenPixels, Vec<LightMask>)>;

    /// Renders a frame, four samples at once or one after the other.
    fn render(name: &str, settings: &Settings, by_four: bool) -> (Film, Shown, [u64; 2]) {
        let frame = crate::open(name).and_then(|scene| scene.at(0.4)).expect("a frame");
        let surroundings = Surroundings::new(&settings.background);
        let staged = settings.stage(&frame, &surroundings).expect("a camera");
        let (mut engine, mut film, mut stats) =
            (Cpu::with_level(SimdLevel::default()), Film::default(), Stats::default());
        film.resize([settings.width, settings.height], &staged).expect("little memory");
        engine.build(&staged, Output::Film).expect("a structure");
        let mut shown = vec![(SeenPixels::default(), Vec::new()); settings.samples as usize];
        for samples in Samples::all(settings.samples, by_four) {
            let staged = Staged { samples, ..staged };
            engine.see(&staged, &mut stats).expect("a small image");
            engine.shadow(&staged, &mut stats).expect("lights");
            at_once(engine.shade(&staged, None, &mut film, &mut stats)).expect("a film");
            let pixels = TileOrder::new(settings.width, settings.height);
            for (which, sample) in samples.as_slice().iter().enumerate() {
                let one = OneSample::new(engine.seen.order(), &samples, which);
                shown[sample.index as usize] = one.alone(pixels, &engine.seen, &engine.masks);
            }
        }
        let (seen, masks) = shown.last().expect("a sample");
        let (last, last_masks) = last_alone(&engine.last().samples, engine.last().seen, engine.last().light_masks);
        assert!(last.triangle == seen.triangle && last_masks == *masks, "the last sample's");
        let rays = [engine.shadow_rays, stats.stages.len() as u64];
        (film, shown, rays)
    }

    #[test]
    fn four_samples_at_once_show_what_four_do() {
        let scenes = ["demo:glass?triangles=600", "demo:statue?triangles=1000", "demo:forest?triangles=3000"];
        let structures = [Structure::bvh()];
        let of_scenes = scenes.into_iter().flat_map(|name| [4, 8].map(|samples| (name, Structure::default(), samples)));
        let of_structures = structures.into_iter().map(|structure| (scenes[2], structure, 4));
        for (name, structure, samples) in of_scenes.chain(of_structures) {
            let place = format!("{samples} samples of {name} through {structure}");
            // More than one tile along each axis, none of them whole.
            let settings = Settings { width: 70, height: 67, samples, structure, bounces: 1, ..Settings::default() };
            let settings = Settings { smooth_terminator: samples == 8, ..settings };
            let (film, shown, rays) = render(name, &settings, true);
            let (expected, expected_shown, expected_rays) = render(name, &settings, false);
            assert_eq!(rays, expected_rays, "{place}");
            for (index, (shown, expected)) in shown.iter().zip(&expected_shown).enumerate() {
                assert!(shown.0.triangle == expected.0.triangle, "{place}: other triangles at {index}");
                assert!(shown.1 == expected.1, "{place}: other shadows at {index}");
                assert!(shown.1.iter().any(|mask| mask.count() > 100), "{place}: dark");
            }
            assert_eq!((film.depth, film.triangle), (expected.depth, expected.triangle), "{place}");
            assert_eq!(film.normal, expected.normal, "{place}");
            if samples == 4 {
                assert_eq!(film.color, expected.color, "{place}");
            }
            // With more than four, sums are made in another order.
            let is_near = film.color.iter().zip(&expected.color).all(|(a, b)| a.abs_diff_eq(*b, 1e-5 * b.length()));
            assert!(is_near, "{place}: other colours");
        }
    }
}
