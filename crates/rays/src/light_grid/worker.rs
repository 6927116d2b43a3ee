use super::candidates::CandidateBatch;
use super::face::Block;
use super::parts::TileParts;
use super::points::TILE_BLOCKS;
use super::set_up::Extent;
use crate::shot::Counts;

/// A thread's buffers and results.
#[derive(Debug, Default)]
pub(crate) struct ShadowWorker {
    pub(crate) tile: ShadowTile,
    pub(crate) parts: TileParts,
    pub(crate) batch: CandidateBatch,
    /// Pairs of a point's index and a triangle that the filter couldn't decide.
    pub(crate) undecided: Vec<[u32; 2]>,
    /// Pixels whose points belong to the face and can't be mapped.
    pub(crate) outliers: Vec<u32>,
    pub(crate) counts: Counts,
    /// The traced tiles, and for each the shadowed points.
    tiles: Vec<u32>,
    found: Vec<u16>,
}

/// The points of a tile, and their shadow bits.
#[derive(Debug)]
pub(crate) struct ShadowTile {
    /// The index of the tile's first pixel.
    pub(crate) first: usize,
    pub(crate) extent: Extent,
    pub(crate) blocks: Box<[Block; TILE_BLOCKS]>,
    pub(crate) shadowed: Box<[u16; TILE_BLOCKS]>,
}

impl Default for ShadowTile {
    fn default() -> Self {
        Self {
            first: 0,
            extent: Extent::default(),
            blocks: Box::new([Block::EMPTY; TILE_BLOCKS]),
            shadowed: Box::new([0; TILE_BLOCKS]),
        }
    }
}

impl ShadowWorker {
    pub(crate) fn bytes(&self) -> usize {
        size_of::<[Block; TILE_BLOCKS]>()
            + size_of::<[u16; TILE_BLOCKS]>()
            + self.parts.bytes()
            + self.batch.bytes()
            + self.undecided.capacity() * size_of::<[u32; 2]>()
            + self.outliers.capacity() * size_of::<u32>()
    }

    /// Forgets the results of another face.
    pub(crate) fn start(&mut self) {
        self.outliers.clear();
        self.counts = Counts::default();
        self.tiles.clear();
        self.found.clear();
    }

    /// Keeps the results of the tile that was traced last.
    pub(crate) fn keep(&mut self, tile: usize) {
        self.tiles.push(tile as u32);
        self.found.extend_from_slice(&*self.tile.shadowed);
    }

    /// The traced tiles, and the words of their shadowed points.
    pub(crate) fn found(&self) -> impl Iterator<Item = (usize, &[u16])> {
        let found = self.found.chunks_exact(TILE_BLOCKS);
        self.tiles.iter().map(|&tile| tile as usize).zip(found)
    }
}

/// Gives every worker the largest room that any of them has needed: each gets other tiles from frame to frame, and a frame
/// like the last shouldn't allocate.
pub(crate) fn share_evenly(workers: &mut [ShadowWorker]) {
    let most = |of: fn(&ShadowWorker) -> usize| workers.iter().map(of).max().unwrap_or_default();
    let [parts, fragments, rest] = [
        most(|worker| worker.parts.parts.capacity()),
        most(|worker| worker.parts.room()[0]),
        most(|worker| worker.parts.room()[1]),
    ];
    let batch = workers
        .iter()
        .map(|worker| worker.batch.room())
        .fold([0; 3], |most, room| std::array::from_fn(|list| most[list].max(room[list])));
    let [undecided, outliers, tiles, found] = [
        most(|worker| worker.undecided.capacity()),
        most(|worker| worker.outliers.capacity()),
        most(|worker| worker.tiles.capacity()),
        most(|worker| worker.found.capacity()),
    ];
    for worker in workers {
        make_room(&mut worker.parts.parts, parts);
        worker.parts.make_room([fragments, rest]);
        worker.batch.make_room(batch);
        make_room(&mut worker.undecided, undecided);
        make_room(&mut worker.outliers, outliers);
        make_room(&mut worker.tiles, tiles);
        make_room(&mut worker.found, found);
    }
}

/// Makes room for `count` elements in a list.
pub(crate) fn make_room<T>(list: &mut Vec<T>, count: usize) {
    list.reserve_exact(count.saturating_sub(list.len()));
}
