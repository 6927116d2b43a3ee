use glam::Vec3;

use super::Sweep;
use crate::curve_order::CurveOrder;
use crate::hilbert::along_hilbert_curve;
use crate::simd::lanes::LANES;

/// The largest number of lines in a tile.
pub(super) const TILE_LINES: usize = 256;

/// The growth of neighbours' angles, since lines were sorted, at which they are sorted again.
const MOST_SPREAD: f32 = 1.2;

/// About so many blocks of neighbours are looked at to tell whether their order may stay.
const LOOKED_AT: usize = 256;

/// The lines of sweeps in an order in which neighbours follow each other. It stays from call to call while neighbours stay
/// about as near each other: for a sensor's directions that are the same ones, or all turned. 8 bytes a line, and 16 for
/// sorting the lines of a sweep.
#[derive(Debug, Default)]
pub(super) struct Spread {
    sweeps: Vec<SortedSweep>,
    /// The indices of each sweep's lines in its order, sweep after sweep.
    order: Vec<u32>,
    /// The place of each line in its sweep's order.
    places: Vec<u32>,
    tiles: Vec<LineTile>,
    curve: CurveOrder,
}

#[derive(Debug)]
struct SortedSweep {
    lines: usize,
    /// The [`spread`] of its lines when they were sorted; `None` if they weren't.
    spread: Option<f32>,
}

/// Up to [`TILE_LINES`] lines that follow each other in a sweep's order.
#[derive(Clone, Copy, Debug)]
pub(super) struct LineTile {
    /// Number of the sweep.
    pub(super) sweep: usize,
    /// The number of lines of the sweeps before it.
    pub(super) before: usize,
    /// The first one's index in the order of all sweeps.
    first: usize,
    pub(super) lines: usize,
}

impl Spread {
    /// Brings the lines of sweeps into an order.
    pub(super) fn update(&mut self, sweeps: &[Sweep<'_>]) {
        let counts = || sweeps.iter().map(|sweep| sweep.directions.len());
        if !counts().eq(self.sweeps.iter().map(|of| of.lines)) {
            self.clear(counts());
        }
        let mut first = 0;
        for (of, Sweep { directions, .. }) in self.sweeps.iter_mut().zip(sweeps) {
            let range = first..first + of.lines;
            first = range.end;
            let (order, places) = (&mut self.order[range.clone()], &mut self.places[range]);
            if of.spread.is_some_and(|sorted| spread(directions, order) <= MOST_SPREAD * sorted) {
                continue;
            }
            let sorted = self.curve.sort(of.lines, |line| code(directions[line as usize]));
            for ((place, to), key) in (0..).zip(order.iter_mut()).zip(sorted) {
                *to = *key as u32;
                places[*to as usize] = place;
            }
            of.spread = Some(spread(directions, order));
        }
    }

    /// Makes tiles for sweeps with these numbers of lines, in no order yet.
    fn clear(&mut self, counts: impl Iterator<Item = usize>) {
        let Self { sweeps, order, places, tiles, .. } = self;
        sweeps.clear();
        tiles.clear();
        let mut first = 0;
        for (sweep, lines) in counts.enumerate() {
            sweeps.push(SortedSweep { lines, spread: None });
            let end = first + lines;
            let before = first;
            tiles.extend((before..end).step_by(TILE_LINES).map(|start| LineTile {
                sweep,
                before,
                first: start,
                lines: (end - start).min(TILE_LINES),
            }));
            first = end;
        }
        order.resize(first, 0);
        places.resize(first, 0);
    }

    pub(super) fn tiles(&self) -> &[LineTile] {
        &self.tiles
    }

    /// The indices of a tile's lines in their sweep.
    pub(super) fn lines(&self, tile: &LineTile) -> &[u32] {
        &self.order[tile.first..tile.first + tile.lines]
    }

    /// For each sweep, the place of each of its lines in its order.
    pub(super) fn places(&self) -> impl Iterator<Item = &[u32]> {
        let mut rest = &self.places[..];
        self.sweeps.iter().map(move |sweep| {
            let (of_sweep, others) = rest.split_at(sweep.lines);
            rest = others;
            of_sweep
        })
    }

    pub(super) fn bytes(&self) -> usize {
        (self.order.capacity() + self.places.capacity()) * size_of::<u32>()
            + self.tiles.capacity() * size_of::<LineTile>()
            + self.sweeps.capacity() * size_of::<SortedSweep>()
            + self.curve.bytes()
    }
}

/// The direction of unit length; NaN where a line's direction is zero or not finite.
fn unit(direction: Vec3) -> Vec3 {
    // Scaled first, so that its square neither overflows nor underflows.
    (direction / direction.abs().max_element()).normalize()
}

/// The position of a direction along Hilbert's curve through the cube around the unit sphere.
fn code(direction: Vec3) -> u32 {
    const HALF: f32 = 511.99;
    let unit = unit(direction);
    if unit.is_nan() {
        return CurveOrder::NOWHERE;
    }
    along_hilbert_curve((unit * HALF + HALF).to_array().map(|at| at as u32))
}

/// The sum of the distances of some blocks' first lines from the farthest of their blocks, on the unit sphere.
fn spread(directions: &[Vec3], order: &[u32]) -> f32 {
    let blocks = order.chunks(LANES).step_by((order.len() / LANES / LOOKED_AT).max(1));
    let farthest = blocks.map(|block| {
        let at = |line: u32| unit(directions[line as usize]);
        let first = at(block[0]);
        // A NaN changes nothing.
        block.iter().map(|&line| at(line).distance_squared(first)).fold(0.0, f32::max).sqrt()
    });
    farthest.sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;
    use glam::{DVec3, Quat};

    fn spread_of(spread: &mut Spread, all: &[Vec<Vec3>]) -> Vec<u32> {
        let sweeps: Vec<_> = all.iter().map(|directions| Sweep { origin: DVec3::ZERO, directions }).collect();
        spread.update(&sweeps);
        let mut first = 0;
        for (directions, places) in all.iter().zip(spread.places()) {
            let order = &spread.order[first..first + directions.len()];
            assert!(places.iter().zip(0..).all(|(&place, line)| order[place as usize] == line), "not all lines, once");
            first += directions.len();
        }
        spread.order.clone()
    }

    #[test]
    fn lines_are_sorted_again_where_they_are_others() {
        let mut random = Random::new(62);
        let mut lines = |count: usize| -> Vec<Vec3> {
            (0..count).map(|_| Vec3::from([0; 3].map(|_| random.signed() as f32))).collect()
        };
        let mut spread = Spread::default();
        let mut all = vec![lines(20_000), lines(700)];
        all[0][5] = Vec3::NAN;
        let first = spread_of(&mut spread, &all);
        assert_eq!(first[19_999], 5, "what goes nowhere is last");
        let turn = Quat::from_rotation_y(1.0) * Quat::from_rotation_x(0.4);
        all.iter_mut().flatten().for_each(|direction| *direction = turn * *direction * 3.0);
        assert_eq!(spread_of(&mut spread, &all), first, "all turned");
        all[1] = lines(700);
        let second = spread_of(&mut spread, &all);
        assert_eq!(second[..20_000], first[..20_000], "the first sweep's are the same");
        assert_ne!(second[20_000..], first[20_000..], "the second sweep's are others");
        all[0].pop();
        assert_ne!(spread_of(&mut spread, &all)[..19_999], first[..19_999], "one fewer");
        // Sixteen evenly spread neighbours are within about 0.2; any sixteen lines are farther apart than 1.
        assert!(super::spread(&all[0], &spread.order[..19_999]) / (LOOKED_AT as f32) < 0.3);
    }
}
