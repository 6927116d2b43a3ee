//! A scene in parts on disk, and a cache of parts in memory.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, BufWriter, Read as _, Seek as _, SeekFrom, Write as _};

use bytemuck::{Pod, Zeroable};
use glam::Vec3;
use umbrage_rays::Triangles;

use super::cut::{Item, Node, hierarchy};
use super::{Costs, Error};

/// The triangles of a scene, in parts of a temporary file, which is deleted with it.
#[derive(Debug)]
pub struct Scene {
    file: File,
    /// The boxes above the parts; each leaf is a part.
    pub(super) above: Vec<Node>,
    pub(super) parts: Vec<Part>,
    triangles: usize,
}

/// Location of a part.
#[derive(Clone, Copy, Debug)]
pub(super) struct Part {
    /// Offset in the file, in bytes.
    at: u64,
    nodes: usize,
    triangles: usize,
}

/// A triangle of a part. 40 bytes.
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
#[repr(C)]
pub(super) struct Stored {
    corners: [[f32; 3]; 3],
    pub(super) id: u32,
}

/// A part in memory: a hierarchy over its triangles.
#[derive(Debug)]
pub(super) struct Loaded {
    pub(super) nodes: Vec<Node>,
    pub(super) triangles: Vec<Stored>,
}

impl Stored {
    pub(super) fn corners(&self) -> [Vec3; 3] {
        self.corners.map(Vec3::from)
    }
}

impl Part {
    /// Bytes on disk and in memory.
    pub(super) fn bytes(&self) -> u64 {
        (self.nodes * size_of::<Node>() + self.triangles * size_of::<Stored>()) as u64
    }
}

impl Scene {
    /// Maximum number of triangles in a leaf of a part.
    const IN_LEAF: usize = 4;
    /// Maximum bytes of a triangle with its share of the boxes: leaves are at least half full, and there are fewer
    /// boxes above them than leaves.
    const BYTES_OF_TRIANGLE: usize = size_of::<Stored>() + size_of::<Node>();

    /// Writes `triangles` to a temporary file, in parts of no more than `part_bytes`, but at least one triangle. Leaves
    /// out triangles that no ray can hit.
    ///
    /// # Errors
    /// If there is no room for the file.
    pub fn write(triangles: Triangles<'_>, part_bytes: usize) -> io::Result<Self> {
        let ids = 0..triangles.len() as u32;
        let usable = ids.filter_map(|id| Some(Item::new(id, triangles.usable_corners(id).ok()?)));
        let mut items: Vec<Item> = usable.collect();
        let mut above = hierarchy(&mut items, part_bytes / Self::BYTES_OF_TRIANGLE);
        let mut file = BufWriter::new(tempfile::tempfile()?);
        let (mut parts, mut at) = (Vec::new(), 0);
        for leaf in above.iter_mut().filter(|node| node.count > 0) {
            let items = &mut items[leaf.first as usize..][..leaf.count as usize];
            let nodes = hierarchy(items, Self::IN_LEAF);
            let stored = |item: &Item| Stored { corners: triangles.corners(item.id).map(Into::into), id: item.id };
            let stored: Vec<Stored> = items.iter().map(stored).collect();
            file.write_all(bytemuck::cast_slice(&nodes))?;
            file.write_all(bytemuck::cast_slice(&stored))?;
            let part = Part { at, nodes: nodes.len(), triangles: stored.len() };
            *leaf = Node { first: parts.len() as u32, count: 1, ..*leaf };
            at += part.bytes();
            parts.push(part);
        }
        let file = file.into_inner().map_err(io::IntoInnerError::into_error)?;
        Ok(Self { file, above, parts, triangles: items.len() })
    }

    /// Bytes of all parts.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.parts.iter().map(Part::bytes).sum()
    }

    /// Bytes of the largest part, the least budget.
    #[must_use]
    pub fn largest(&self) -> u64 {
        self.parts.iter().map(Part::bytes).max().unwrap_or(0)
    }

    /// Number of parts.
    #[must_use]
    pub fn parts(&self) -> usize {
        self.parts.len()
    }

    /// Number of triangles in the parts.
    #[must_use]
    pub fn triangles(&self) -> usize {
        self.triangles
    }

    fn read(&self, part: Part) -> io::Result<Loaded> {
        let mut nodes = vec![Node::default(); part.nodes];
        let mut triangles = vec![Stored::default(); part.triangles];
        let mut file = &self.file;
        file.seek(SeekFrom::Start(part.at))?;
        file.read_exact(bytemuck::cast_slice_mut(&mut nodes))?;
        file.read_exact(bytemuck::cast_slice_mut(&mut triangles))?;
        Ok(Loaded { nodes, triangles })
    }
}

/// The parts in memory: the most recently used ones that fit.
#[derive(Debug)]
pub(super) struct Cache<'a> {
    scene: &'a Scene,
    budget: u64,
    bytes: u64,
    /// For each part the time of its last use and its contents; `None` if it isn't in memory.
    loaded: Vec<Option<(u64, Loaded)>>,
    /// The parts in memory, by time of their last use.
    by_use: BTreeMap<u64, usize>,
    uses: u64,
}

impl<'a> Cache<'a> {
    /// # Errors
    /// If the largest part doesn't fit.
    pub(super) fn new(scene: &'a Scene, budget: u64) -> Result<Self, Error> {
        let largest = scene.largest();
        if budget < largest {
            return Err(Error::TooLittleMemory { budget, largest });
        }
        let loaded = scene.parts.iter().map(|_| None).collect();
        Ok(Self { scene, budget, bytes: 0, loaded, by_use: BTreeMap::new(), uses: 0 })
    }

    pub(super) fn holds(&self, part: usize) -> bool {
        self.loaded[part].is_some()
    }

    /// Returns a part, and reads it if it isn't in memory.
    ///
    /// # Errors
    /// If the file can't be read.
    pub(super) fn get(&mut self, part: usize, costs: &mut Costs) -> io::Result<&Loaded> {
        self.uses += 1;
        let loaded = match self.loaded[part].take() {
            Some((last_use, loaded)) => {
                self.by_use.remove(&last_use);
                loaded
            }
            None => self.load(part, costs)?,
        };
        self.by_use.insert(self.uses, part);
        Ok(&self.loaded[part].insert((self.uses, loaded)).1)
    }

    fn load(&mut self, part: usize, costs: &mut Costs) -> io::Result<Loaded> {
        let bytes = self.scene.parts[part].bytes();
        while self.bytes + bytes > self.budget {
            let Some((_, oldest)) = self.by_use.pop_first() else { break };
            self.loaded[oldest] = None;
            self.bytes -= self.scene.parts[oldest].bytes();
        }
        let loaded = self.scene.read(self.scene.parts[part])?;
        self.bytes += bytes;
        costs.loads += 1;
        costs.bytes_read += bytes;
        costs.most_resident_bytes = costs.most_resident_bytes.max(self.bytes);
        Ok(loaded)
    }
}
