use glam::DVec3;

use super::slices::Scratch;
use crate::grid::TileOrder;
use crate::packet::{AnyHitBlock, Doubt, Group, LANES, NearestBlock, Range, RayBlock};

/// Pixels along an edge of a packet (Wald et al. 2006, §4.1).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PacketSide {
    /// 4 rays a packet.
    Two,
    /// 16 rays a packet.
    Four,
    /// 64 rays a packet.
    #[default]
    Eight,
    /// 256 rays a packet.
    Sixteen,
    /// 1024 rays a packet.
    ThirtyTwo,
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

    /// Blocks of 16 rays along an edge, or parts of one.
    fn blocks(self) -> usize {
        (self.pixels() / TileOrder::BLOCK).max(1) as usize
    }

    /// The packets of a tile: the first block in the tile's order, and which of each block's places belong to it.
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

/// Most blocks of a packet.
pub(super) const MOST_BLOCKS: usize = 64;

/// What one thread traces packets with.
pub(super) struct Worker {
    pub(super) bundle: Bundle,
    pub(super) rays: [RayBlock; MOST_BLOCKS],
    pub(super) nearest: [NearestBlock; MOST_BLOCKS],
    pub(super) any_hit: [AnyHitBlock; MOST_BLOCKS],
    pub(super) doubts: Vec<Doubt>,
    pub(super) shadow_doubts: Vec<(u16, u16, u32)>,
    pub(super) scratch: Scratch,
}

impl Default for Worker {
    fn default() -> Self {
        Self {
            bundle: Bundle::default(),
            rays: [RayBlock::default(); MOST_BLOCKS],
            nearest: [NearestBlock::EMPTY; MOST_BLOCKS],
            any_hit: [AnyHitBlock::EMPTY; MOST_BLOCKS],
            doubts: Vec::new(),
            shadow_doubts: Vec::new(),
            scratch: Scratch::default(),
        }
    }
}

impl Worker {
    pub(super) fn bytes(&self) -> usize {
        size_of::<Self>()
            + self.doubts.capacity() * size_of::<Doubt>()
            + self.shadow_doubts.capacity() * size_of::<(u16, u16, u32)>()
    }
}

/// The rays of a packet, of which some may have been traced already.
pub(super) struct Bundle {
    /// How many blocks there are.
    pub(super) count: usize,
    /// Where each block is in the tile's order.
    pub(super) blocks: [u16; MOST_BLOCKS],
    /// Rays that weren't traced yet.
    pub(super) remaining: [u16; MOST_BLOCKS],
    /// What the rays that are being traced have in common.
    pub(super) group: Group,
    /// Those rays.
    pub(super) members: [u16; MOST_BLOCKS],
    /// Directions of rays with a common origin, or where rays with a common direction are.
    pub(super) vectors: [[[f64; LANES]; 3]; MOST_BLOCKS],
    /// How wrong each ray's vector may be.
    pub(super) errors: [[f64; LANES]; MOST_BLOCKS],
    /// How wrong the predicate takes a shadow ray's point to be.
    pub(super) predicate_errors: [[f64; LANES]; MOST_BLOCKS],
    /// What is common in a group of rays besides their direction: hits are about as far away.
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

/// The places of a word's bits.
pub(super) fn lanes_of(mut bits: u16) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let lane = bits.trailing_zeros() as usize;
        bits &= bits.wrapping_sub(1);
        (lane < LANES).then_some(lane)
    })
}

impl Bundle {
    pub(super) fn vector(&self, block: usize, lane: usize) -> DVec3 {
        let [x, y, z] = &self.vectors[block];
        DVec3::new(x[lane], y[lane], z[lane])
    }

    /// The first block and lane that weren't traced yet.
    pub(super) fn first_remaining(&self) -> Option<(usize, usize)> {
        let block = self.remaining[..self.count].iter().position(|&remaining| remaining != 0)?;
        Some((block, self.remaining[block].trailing_zeros() as usize))
    }

    /// Starts a group of rays: those for which `belongs` says so, besides the first one.
    pub(super) fn start_group(
        &mut self,
        group: Group,
        first: (usize, usize),
        belongs: impl Fn(&Self, usize, usize) -> bool,
    ) {
        self.group = group;
        for block in 0..self.count {
            let mut members = 0;
            for lane in lanes_of(self.remaining[block]) {
                if (block, lane) == first || belongs(self, block, lane) {
                    members |= 1 << lane;
                }
            }
            self.members[block] = members;
            self.remaining[block] &= !members;
        }
    }

    /// Blocks and lanes of the group's rays.
    pub(super) fn members(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        let blocks = self.members[..self.count].iter().enumerate();
        blocks.flat_map(|(block, &members)| lanes_of(members).map(move |lane| (block, lane)))
    }

    /// How many rays the group has.
    pub(super) fn len(&self) -> u32 {
        self.members[..self.count].iter().map(|members| members.count_ones()).sum()
    }

    /// The ranges of three functions of the group's vectors, each of which is given along u, v and w.
    ///
    /// All lanes are looked at, so that they are handled together.
    #[inline(always)]
    pub(super) fn ranges(&self, of: impl Fn([f64; 3]) -> [f64; 3]) -> [Range; 3] {
        let mut lows = [[f64::INFINITY; LANES]; 3];
        let mut highs = [[f64::NEG_INFINITY; LANES]; 3];
        for block in 0..self.count {
            let members = self.members[block];
            let [u, v, w] = self.group.axes.map(|axis| &self.vectors[block][axis]);
            for lane in 0..LANES {
                let values = of([u[lane], v[lane], w[lane] * self.group.sign]);
                let is_member = members >> lane & 1 == 1;
                for (value, (lows, highs)) in values.into_iter().zip(lows.iter_mut().zip(&mut highs)) {
                    lows[lane] = lows[lane].min(if is_member { value } else { f64::INFINITY });
                    highs[lane] = highs[lane].max(if is_member { value } else { f64::NEG_INFINITY });
                }
            }
        }
        std::array::from_fn(|value| Range {
            low: lows[value].into_iter().fold(f64::INFINITY, f64::min),
            high: highs[value].into_iter().fold(f64::NEG_INFINITY, f64::max),
        })
    }

    /// Calls `visit` with the blocks of each packet of a tile, and the places of each block that are the packet's.
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
