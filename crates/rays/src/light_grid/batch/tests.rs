//! Lists of slots compared with loops over all points, on all SIMD levels.

use super::*;
use crate::SimdLevel;
use crate::dispatch;
use crate::light_grid::boxes::SixteenBoxes;
use crate::light_grid::face::Block;
use crate::random::Random;

const TRIALS: usize = 1000;

/// Some parts of a tile.
struct Tile {
    blocks: Box<[Block; TILE_BLOCKS]>,
    parts: Vec<TilePart>,
    shadowed: [u16; TILE_BLOCKS],
}

/// A number from −1 to 1 with few digits, so that bounds and points coincide.
fn coarse(random: &mut Random) -> f32 {
    (random.signed() * 8.0).round() as f32 / 8.0
}

fn bits(random: &mut Random) -> u16 {
    let word = |random: &mut Random| (random.unit() * 65536.0) as u16;
    [0, u16::MAX, word(random), word(random) & word(random) & word(random)][(random.unit() * 4.0) as usize]
}

impl Tile {
    fn new(random: &mut Random) -> Self {
        let mut blocks = Box::new([Block::EMPTY; TILE_BLOCKS]);
        for block in &mut *blocks {
            let middle = [(); 3].map(|()| coarse(random));
            let mut lanes = |axis: usize| [(); LANES].map(|()| middle[axis] + 0.25 * coarse(random));
            *block = Block { x: lanes(0), y: lanes(1), nearness: lanes(2) };
        }
        let parts = (0..1 + (random.unit() * 20.0) as u8).map(|number| {
            let mut part = TilePart::EMPTY;
            let slots = bits(random);
            for slot in bits_of(slots) {
                let number = number.wrapping_mul(37).wrapping_add(slot as u8);
                (part.blocks[slot], part.points[slot]) = (number, bits(random));
                let of = |values: [f32; LANES]| {
                    let points = bits_of(part.points[slot]).map(|lane| values[lane]);
                    points.fold([f32::INFINITY, f32::NEG_INFINITY], |[low, high], at| [low.min(at), high.max(at)])
                };
                let Block { x, y, nearness } = blocks[usize::from(number)];
                part.boxes.set(slot, FaceBox { x: of(x), y: of(y), nearness: of(nearness)[0] });
            }
            part
        });
        Self { parts: parts.collect(), blocks, shadowed: [(); TILE_BLOCKS].map(|()| bits(random) & bits(random)) }
    }

    /// Whether a point of a slot is in a box and not yet in shadow.
    fn is_inside(&self, part: &TilePart, slot: usize, lane: usize, around: &FaceBox) -> bool {
        let Block { x, y, nearness } = &self.blocks[usize::from(part.blocks[slot])];
        let is_untested = (part.points[slot] & !self.shadowed[usize::from(part.blocks[slot])]) >> lane & 1 == 1;
        let holds = |[low, high]: [f32; 2], at: f32| low <= at && at <= high;
        is_untested && holds(around.x, x[lane]) && holds(around.y, y[lane]) && nearness[lane] <= around.nearness
    }
}

/// Whether bounds of points, among sixteen, overlap a box.
fn overlaps(boxes: &SixteenBoxes, slot: usize, around: &FaceBox) -> bool {
    let FaceBox { x, y, nearness } = boxes.get(slot);
    let overlap = |one: [f32; 2], other: [f32; 2]| one[0] <= other[1] && one[1] >= other[0];
    overlap(x, around.x) && overlap(y, around.y) && nearness <= around.nearness
}

#[test]
fn slots_are_listed_that_have_points_in_a_box() {
    let mut random = Random::new(1);
    let mut counts = [0; 3];
    for _ in 0..TRIALS {
        let tile = Tile::new(&mut random);
        let own = vec![0; TILE_BLOCKS * LANES];
        let mut range = || {
            let ends = [(); 2].map(|()| coarse(&mut random));
            [ends[0].min(ends[1]), ends[0].max(ends[1])]
        };
        let around = FaceBox { x: range(), y: range(), nearness: range()[1] };
        let among: Vec<_> = (0..tile.parts.len()).map(|part| (part, bits(&mut random))).collect();
        let most_searched = (random.unit() * 6.0) as u32;
        let expected = |slot_has: &dyn Fn(&TilePart, usize) -> bool| {
            let slots = |(part, slots): (usize, u16)| {
                let has = bits_of(slots).filter(|&slot| slot_has(&tile.parts[part], slot));
                (part, has.fold(0, |all, slot| all | 1_u16 << slot))
            };
            among.iter().map(|&entry| slots(entry)).filter(|&(_, slots)| slots != 0).collect::<Vec<_>>()
        };
        let is_alive = |part: &TilePart, slot| part.points[slot] & !tile.shadowed[usize::from(part.blocks[slot])] != 0;
        let overlapping = expected(&|part, slot| is_alive(part, slot) && overlaps(&part.boxes, slot, &around));
        let count: u32 = overlapping.iter().map(|(_, slots)| slots.count_ones()).sum();
        let reached = expected(&|part, slot| (0..LANES).any(|lane| tile.is_inside(part, slot, lane, &around)));
        counts[if count > most_searched { 0 } else { 1 + usize::from(reached != overlapping) }] += 1;
        let expected = if count > most_searched { overlapping } else { reached };
        for level in SimdLevel::available() {
            let (mut undecided, mut counts) = (Vec::new(), Counts::default());
            let points = TilePoints::new(0, &tile.blocks, &own);
            let batch = BatchPoints::new(points, &tile.parts, &tile.shadowed, &mut undecided, &mut counts);
            let mut list = SlotList::EMPTY;
            let among = among.iter().copied();
            dispatch!(level, simd => batch.list_reached(simd, &around, among, most_searched, &mut list));
            assert_eq!(list.iter().collect::<Vec<_>>(), expected, "at {level}");
        }
    }
    assert!(counts.iter().all(|&count| count > 30), "not searched, all reached, fewer: {counts:?}");
}

#[test]
fn points_in_shadow_are_noted_and_kept() {
    let mut random = Random::new(2);
    for _ in 0..TRIALS {
        let tile = Tile::new(&mut random);
        let own = vec![0; TILE_BLOCKS * LANES];
        let (mut undecided, mut counts) = (Vec::new(), Counts::default());
        let points = TilePoints::new(0, &tile.blocks, &own);
        let mut batch = BatchPoints::new(points, &tile.parts, &tile.shadowed, &mut undecided, &mut counts);
        let part = (random.unit() * tile.parts.len() as f64) as usize;
        let slot = (random.unit() * LANES as f64) as usize;
        let [possible, certain] = [(); 2].map(|()| bits(&mut random) & !batch.done(part, slot));
        batch.note((part, slot), 7, possible, certain & possible);
        let is_alive = batch.alive(part) >> slot & 1 == 1;
        assert_eq!(is_alive, batch.done(part, slot) != u16::MAX);
        let (mut kept, block) = (tile.shadowed, usize::from(tile.parts[part].blocks[slot]));
        batch.keep(&mut kept);
        let mut expected = tile.shadowed;
        expected[block] |= certain & possible;
        assert_eq!(kept, expected);
        let pending = bits_of(possible & !certain).map(|lane| [(block * LANES + lane) as u32, 7]);
        assert_eq!(undecided, pending.collect::<Vec<_>>());
    }
}
