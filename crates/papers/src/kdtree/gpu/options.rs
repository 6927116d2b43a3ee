use umbrage_gpu::rays::{RayTracerOptions, Walk};

use crate::KdTraversal;

/// How rays traverse the tree.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct KdTracerOptions {
    /// The way back up the tree. A short stack has at most [`KdTracerOptions::MOST_ENTRIES`] entries; packets have no
    /// full stack, but one of that many.
    pub traversal: KdTraversal,
    /// Rays of a packet: a power of two up to 64. `None` traces each ray alone.
    pub packet: Option<u32>,
    /// Whether visits are counted, which takes time.
    pub counts: bool,
    /// Whether rays may start at points of triangles.
    pub from_triangles: bool,
}

impl KdTracerOptions {
    /// Most entries of a short stack: all that fit the workgroup memory that every device has.
    pub const MOST_ENTRIES: u8 = 15;

    /// Single rays with a short stack of four entries.
    pub const DEFAULT: Self =
        Self { traversal: KdTraversal::ShortStack(4), packet: None, counts: false, from_triangles: false };

    /// Rays of a packet, or one.
    #[must_use]
    pub fn lanes(&self) -> u32 {
        self.packet.map_or(1, |lanes| lanes.clamp(1, 64))
    }

    fn walk(&self) -> Walk {
        let (entries, pushes_down) = match self.traversal {
            KdTraversal::Stack => (Self::MOST_ENTRIES, true),
            KdTraversal::Restart => (0, false),
            KdTraversal::PushDown => (0, true),
            KdTraversal::ShortStack(entries) => (entries.min(Self::MOST_ENTRIES), true),
        };
        let mut constants =
            vec![("KD_ENTRIES", f64::from(entries)), ("KD_PUSHES_DOWN", f64::from(u8::from(pushes_down)))];
        let packet = self.packet.map(|_| self.lanes());
        let (path, entry) = match (packet, self.traversal) {
            (Some(lanes), _) => {
                constants.push(("KD_PACKET", f64::from(lanes)));
                ("kdtree::packet", "by_packet")
            }
            (None, KdTraversal::Stack) => {
                constants.clear();
                ("kdtree::stack", "by_stack")
            }
            _ => ("kdtree::trail", "by_trail"),
        };
        Walk { modules: super::MODULES, path, entry, constants, packet }
    }
}

impl Default for KdTracerOptions {
    fn default() -> Self {
        Self::DEFAULT
    }
}

impl From<KdTracerOptions> for RayTracerOptions {
    fn from(options: KdTracerOptions) -> Self {
        let KdTracerOptions { counts, from_triangles, .. } = options;
        Self { walk: options.walk(), counts, from_triangles }
    }
}
