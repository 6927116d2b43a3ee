use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, f64x8, mask64x8};
use glam::DVec3;

use super::slices::Scratch;
use crate::packet::{
    AnyHitBlock, Common, Group, LANES, MOST_BLOCKS, NearestBlock, PacketRays, Range, Space, Undecided,
};
use umbrage_rays::choices;
use umbrage_rays::shot::TileOrder;
use umbrage_rays::simd::lanes::bits_of;

/// Pixels along an edge of a packet (Wald et al. 2006, §4.1).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PacketSide {
    /// 4 rays a packet.
    Two,
    /// 16 rays a packet.
    Four,
    /// 64 rays a packet.
    Eight,
    /// 256 rays a packet.
    Sixteen,
    /// 1024 rays a packet: the fastest, or nearly so, in all scenes of the gallery, since few of their blocks are tested.
    #[default]
    ThirtyTwo,
}

choices! { PacketSide, "packet side":
    "2" => Two, "4 rays a packet";
    "4" => Four, "16 rays a packet";
    "8" => Eight, "64 rays a packet";
    "16" => Sixteen, "256 rays a packet";
    "32" => ThirtyTwo, "1024 rays a packet: nearly always the fastest";
}

impl PacketSide {
    /// All sizes, the smallest first.
    pub const ALL: [Self; 5] = [Self::Two, Self::Four, Self::Eight, Self::Sixteen, Self::ThirtyTwo];

    /// Pixels along an edge.
    #[must_use]
    pub fn pixels(self) -> u32 {
        match self {
            Self::Two => 2,
            Self::Four => 4,
            Self::Eight => 8,
            Self::Sixteen => 16,
            Self::ThirtyTwo => 32,
        }
    }

    /// Blocks of 16 rays, whole or in part, along an edge.
    fn blocks(self) -> usize {
        (self.pixels() / TileOrder::BLOCK).max(1) as usize
    }

    /// The packets of a tile: the index of the first block in the tile's order, and the mask of each block's pixels in the
    /// packet.
    fn packets(self) -> impl Iterator<Item = (usize, u16)> {
        const QUARTERS: [u16; 4] = [0x0033, 0x00cc, 0x3300, 0xcc00];
        let blocks = self.blocks();
        let parts: &[u16] = if self == Self::Two { &QUARTERS } else { &[u16::MAX] };
        let rows = (0..TILE_BLOCKS).step_by(blocks);
        let corners = rows.flat_map(move |row| (0..TILE_BLOCKS).step_by(blocks).map(move |column| (row, column)));
        corners.flat_map(|(row, column)| parts.iter().map(move |&part| (row * TILE_BLOCKS + column, part)))
    }
}

/// Blocks along an edge of a tile.
const TILE_BLOCKS: usize = (TileOrder::TILE / TileOrder::BLOCK) as usize;

/// The memory of a thread for tracing packets.
pub(super) struct PacketWorker {
    pub(super) bundle: Bundle,
    pub(super) rays: PacketRays,
    pub(super) nearest: [NearestBlock; MOST_BLOCKS],
    pub(super) any_hit: [AnyHitBlock; MOST_BLOCKS],
    pub(super) undecided: Vec<Undecided>,
    pub(super) undecided_shadows: Vec<(u16, u16, u32)>,
    pub(super) scratch: Scratch,
}

impl Default for PacketWorker {
    fn default() -> Self {
        Self {
            bundle: Bundle::default(),
            rays: PacketRays::default(),
            nearest: [NearestBlock::EMPTY; MOST_BLOCKS],
            any_hit: [AnyHitBlock::EMPTY; MOST_BLOCKS],
            undecided: Vec::new(),
            undecided_shadows: Vec::new(),
            scratch: Scratch::default(),
        }
    }
}

impl PacketWorker {
    pub(super) fn bytes(&self) -> usize {
        size_of::<Self>()
            + self.undecided.capacity() * size_of::<Undecided>()
            + self.undecided_shadows.capacity() * size_of::<(u16, u16, u32)>()
    }
}

/// The rays of a packet, some of which may have been traced already.
pub(super) struct Bundle {
    /// The number of blocks.
    pub(super) count: usize,
    /// The index of each block in the tile's order.
    pub(super) blocks: [u16; MOST_BLOCKS],
    /// Rays that aren't traced yet.
    pub(super) remaining: [u16; MOST_BLOCKS],
    /// The group of the rays being traced.
    pub(super) group: Group,
    /// The group's rays.
    pub(super) members: [u16; MOST_BLOCKS],
    /// Directions of rays with a common origin, or positions of rays with a common direction.
    pub(super) vectors: [[[f64; LANES]; 3]; MOST_BLOCKS],
    /// Error bound of each ray's vector.
    pub(super) errors: [[f64; LANES]; MOST_BLOCKS],
    /// The predicate's error of a shadow ray's end point.
    pub(super) predicate_errors: [[f64; LANES]; MOST_BLOCKS],
    /// Inverse depths, by which groups are split: the hits of a group are about as far away.
    pub(super) inverse_depths: [[f32; LANES]; MOST_BLOCKS],
}

impl Default for Bundle {
    fn default() -> Self {
        Self {
            count: 0,
            blocks: [0; MOST_BLOCKS],
            remaining: [0; MOST_BLOCKS],
            group: Group::of(DVec3::X),
            members: [0; MOST_BLOCKS],
            vectors: [[[0.0; LANES]; 3]; MOST_BLOCKS],
            errors: [[0.0; LANES]; MOST_BLOCKS],
            predicate_errors: [[0.0; LANES]; MOST_BLOCKS],
            inverse_depths: [[0.0; LANES]; MOST_BLOCKS],
        }
    }
}

/// Eight of a block's numbers.
#[inline(always)]
pub(super) fn eight<S: Simd>(simd: S, numbers: &[f64; LANES], half: usize) -> f64x8<S> {
    f64x8::from_slice(simd, &numbers[half * 8..half * 8 + 8])
}

/// The mask of members among eight of a block's rays.
#[inline(always)]
pub(super) fn members_of<S: Simd>(simd: S, members: u16, half: usize) -> mask64x8<S> {
    mask64x8::from_bitmask(simd, u64::from(members >> (8 * half) & 0xff))
}

/// The common property of a group's rays, which tells how they differ.
#[derive(Clone, Copy, Debug)]
pub(super) enum Shape {
    /// A common origin: rays have slopes u / w and v / w.
    Fan,
    /// A common direction of this slope: rays have coordinates, in units, at w = 0.
    Column { slope: [f64; 2], unit: f64 },
}

impl Shape {
    fn of(space: &Space) -> Self {
        match space.common {
            Common::Origin => Self::Fan,
            Common::Direction => Self::Column { slope: space.slope, unit: space.unit },
        }
    }
}

impl Bundle {
    pub(super) fn vector(&self, block: usize, lane: usize) -> DVec3 {
        let [x, y, z] = &self.vectors[block];
        DVec3::new(x[lane], y[lane], z[lane])
    }

    /// The first block and lane not traced yet.
    pub(super) fn first_remaining(&self) -> Option<(usize, usize)> {
        let block = self.remaining[..self.count].iter().position(|&remaining| remaining != 0)?;
        Some((block, self.remaining[block].trailing_zeros() as usize))
    }

    /// Starts a group: the first ray, and the remaining rays that agree with it. With `by_direction` they have its major
    /// axis; with `spread` their inverse depths differ from its by at most this fraction.
    #[inline(always)]
    pub(super) fn start_group<S: Simd>(
        &mut self,
        simd: S,
        group: Group,
        first: (usize, usize),
        by_direction: bool,
        spread: Option<f32>,
    ) {
        self.group = group;
        let depth = self.inverse_depths[first.0][first.1];
        for block in 0..self.count {
            let mut members = self.remaining[block];
            if members != 0 && by_direction {
                members &= self.agreeing(simd, block);
            }
            if members != 0
                && let Some(spread) = spread
            {
                let depths = f32x16::from_slice(simd, &self.inverse_depths[block]);
                let difference = (depths - f32x16::splat(simd, depth)).abs();
                members &= difference.simd_le(f32x16::splat(simd, spread * depth)).to_bitmask() as u16;
            }
            self.members[block] = members;
        }
        self.members[first.0] |= 1 << first.1;
        for block in 0..self.count {
            self.remaining[block] &= !self.members[block];
        }
    }

    /// The mask of a block's vectors that are directions of the [group](Group::has).
    #[inline(always)]
    fn agreeing<S: Simd>(&self, simd: S, block: usize) -> u16 {
        let mut agreeing = 0;
        for half in 0..2 {
            let [u, v, w] = self.turned(simd, block, half);
            let size = u.abs().max(v.abs()).max(w.abs());
            agreeing |= (w.simd_gt(size * Group::LEAST).to_bitmask() as u16) << (8 * half);
        }
        agreeing
    }

    /// Eight of a block's vectors along u, v and w.
    #[inline(always)]
    pub(super) fn turned<S: Simd>(&self, simd: S, block: usize, half: usize) -> [f64x8<S>; 3] {
        let [u, v, w] = self.group.axes;
        let vectors = &self.vectors[block];
        let [u, v, w] =
            [eight(simd, &vectors[u], half), eight(simd, &vectors[v], half), eight(simd, &vectors[w], half)];
        [u, v, w * self.group.sign]
    }

    /// Slopes or coordinates of eight of a block's rays along u and v, and the w of their vectors.
    #[inline(always)]
    fn shaped<S: Simd>(&self, simd: S, block: usize, half: usize, shape: Shape) -> [f64x8<S>; 3] {
        let [u, v, w] = self.turned(simd, block, half);
        match shape {
            Shape::Fan => [u / w, v / w, w],
            Shape::Column { slope, unit } => {
                let along = w * unit;
                [u * unit - along * slope[0], v * unit - along * slope[1], w]
            }
        }
    }

    /// Blocks and lanes of the group's rays.
    pub(super) fn members(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        let blocks = self.members[..self.count].iter().enumerate();
        blocks.flat_map(|(block, &members)| bits_of(members).map(move |lane| (block, lane)))
    }

    /// The number of rays in the group.
    pub(super) fn len(&self) -> u32 {
        self.members[..self.count].iter().map(|members| members.count_ones()).sum()
    }

    /// The ranges of slopes or coordinates of the group's rays along u and v, and of the w of their vectors.
    #[inline(always)]
    pub(super) fn ranges<S: Simd>(&self, simd: S, shape: Shape) -> [Range; 3] {
        let mut lows = [f64x8::splat(simd, f64::INFINITY); 3];
        let mut highs = [f64x8::splat(simd, f64::NEG_INFINITY); 3];
        for block in 0..self.count {
            for half in 0..2 {
                let is_member = members_of(simd, self.members[block], half);
                let values = self.shaped(simd, block, half, shape);
                for value in 0..3 {
                    lows[value] = is_member.select(lows[value].min(values[value]), lows[value]);
                    highs[value] = is_member.select(highs[value].max(values[value]), highs[value]);
                }
            }
        }
        [
            Range { low: lows[0].reduce_min(), high: highs[0].reduce_max() },
            Range { low: lows[1].reduce_min(), high: highs[1].reduce_max() },
            Range { low: lows[2].reduce_min(), high: highs[2].reduce_max() },
        ]
    }

    /// Transforms the group's members to coordinates in the packet's space.
    #[inline(always)]
    pub(super) fn place_rays<S: Simd>(&self, simd: S, space: &Space, rays: &mut PacketRays) {
        let shape = Shape::of(space);
        let (middle, scale) = space.middle_and_scale();
        rays.start(self.count);
        for block in 0..self.count {
            let low = self.shaped(simd, block, 0, shape);
            let high = self.shaped(simd, block, 1, shape);
            let x = ((low[0] - middle[0]) * scale[0]).narrow((high[0] - middle[0]) * scale[0]);
            let y = ((low[1] - middle[1]) * scale[1]).narrow((high[1] - middle[1]) * scale[1]);
            rays.set(simd, block, [x, y], self.members[block]);
        }
    }

    /// Calls `visit` with the blocks of each packet of a tile, and the mask of each block's pixels in the packet.
    #[inline(always)]
    pub(super) fn packets_of_tile(side: PacketSide, mut visit: impl FnMut(&[u16], u16)) {
        let along = side.blocks();
        let mut blocks = [0; MOST_BLOCKS];
        for (first, part) in side.packets() {
            for row in 0..along {
                for column in 0..along {
                    blocks[row * along + column] = (first + row * TILE_BLOCKS + column) as u16;
                }
            }
            visit(&blocks[..along * along], part);
        }
    }
}
