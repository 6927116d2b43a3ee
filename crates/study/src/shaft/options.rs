use umbrage_rays::KdMailbox;

/// How shafts are used. Nothing of it changes what rays hit.
///
/// Nanoseconds of one busy core for each ray, as in [`KdPacketOptions`](umbrage_rays::KdPacketOptions):
///
/// | | Bunny: camera | bounce | shadow | Sibenik: camera | bounce | shadow |
/// |---|---|---|---|---|---|---|
/// | packets of 16 | 244 | 1036 | 187 | 138 | 839 | 101 |
/// | shafts | 257 | 1068 | 679 | 172 | 828 | 307 |
/// | 16, MLRTA | 289 | 1195 | 240 | 198 | 870 | 129 |
/// | 16, AEPSA | 230 | 947 | 213 | 198 | 894 | 108 |
///
/// A shaft goes on until all of its rays have ended, which costs shadow rays most. Entry points don't pay either: MLRTA saves 0.4
/// of 2.5 node visits a ray on the Bunny and 0.8 of 2.2 in Sibenik, but looks at 0.29 and 0.21 nodes, AEPSA at 0.18 and 0.16.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ShaftOptions {
    /// Where the way through the tree begins.
    pub entry: KdEntry,
    /// How it goes on.
    pub lead: ShaftLead,
    /// Which triangles a shaft remembers to have tested.
    pub mailbox: KdMailbox,
}

/// What is led to leaves, from where a shaft has found that rays begin.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ShaftLead {
    /// Packets, as the tree's packet options say.
    Packets,
    /// The shaft instead of its rays, with a stack. Leaves leave out triangles as this says.
    Shaft(KdCulling),
}

impl Default for ShaftLead {
    fn default() -> Self {
        Self::Shaft(KdCulling::default())
    }
}

/// Where the way of up to 256 rays through the tree begins.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum KdEntry {
    /// At the root.
    #[default]
    Root,
    /// At the lowest node below which are all leaves with triangles that a shaft around the rays meets (Reshetov et al.,
    /// *Multi-Level Ray Tracing Algorithm*, 2005: MLRTA).
    MultiLevel,
    /// As `MultiLevel` with only those leaves that hold a triangle in the shaft, and looking from above (Fowler et al.,
    /// *Accelerated Entry Point Search Algorithm for Real-Time Ray-Tracing*, 2009: AEPSA).
    Accelerated,
}

impl KdEntry {
    /// All ways to begin.
    pub const ALL: [Self; 3] = [Self::Root, Self::MultiLevel, Self::Accelerated];
}

/// Which triangles of a leaf are left out for all rays of a shaft at once.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum KdCulling {
    /// None.
    None,
    /// Those whose boxes the rays miss by interval arithmetic (Boulos et al., *Geometric and Arithmetic Culling Methods for
    /// Entire Ray Packets*, 2006).
    Intervals,
    /// Those that all corner rays of the shaft miss on the same edge (Dmitriev et al., *Faster Ray Tracing with SIMD Shaft
    /// Culling*, 2004).
    CornerRays,
    /// Those with all corners outside of one of the shaft's faces (Reshetov, *Faster Ray Packets – Triangle Intersection
    /// through Vertex Culling*, 2007).
    #[default]
    Vertices,
    /// As `Vertices`, with a shaft that is made in each leaf around the rays that get there (Reshetov 2007).
    TransientFrustum,
}

impl KdCulling {
    /// All ways to leave triangles out.
    pub const ALL: [Self; 5] = [Self::None, Self::Intervals, Self::CornerRays, Self::Vertices, Self::TransientFrustum];
}
