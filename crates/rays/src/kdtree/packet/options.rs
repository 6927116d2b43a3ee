/// Most rays that are led to leaves together.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum KdPacketWidth {
    /// 4 rays.
    Four,
    /// 8 rays.
    Eight,
    /// 16 rays.
    #[default]
    Sixteen,
    /// 256 rays, inside a shaft that is led to leaves in their place, where they agree about the sign of an axis and none
    /// runs almost across it; else 16 rays. Restarts and short stacks are for the other widths: shafts have a stack.
    Shaft,
}

impl KdPacketWidth {
    /// All widths, the smallest first.
    pub const ALL: [Self; 4] = [Self::Four, Self::Eight, Self::Sixteen, Self::Shaft];
}

/// Where packets' way through the tree begins. Other ways than from the root are found once for up to 256 rays in a row, where
/// they agree about the sign of an axis and none runs almost across it.
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

/// Which triangles of a leaf are left out for all rays of a [shaft](KdPacketWidth::Shaft) at once.
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

/// Which triangles a packet remembers to have tested.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum KdMailbox {
    /// None.
    None,
    /// The last eight, in a ring (Shevtsov et al. 2007: inverse mailboxing).
    Ring,
    /// The last one of each hash.
    #[default]
    Hashed,
}

impl KdMailbox {
    /// All kinds.
    pub const ALL: [Self; 3] = [Self::None, Self::Ring, Self::Hashed];
}

/// How packets of rays are led through a [`KdTree`](super::super::KdTree). Nothing of it changes what they hit.
///
/// The defaults measured best in all. Nanoseconds of one busy core for each ray, for 512² camera rays, the diffuse bounces of
/// those that hit, and shadow rays from there to a point light, on the Bunny (69 K triangles) and in Sibenik (80 K):
///
/// | | Bunny: camera | bounce | shadow | Sibenik: camera | bounce | shadow |
/// |---|---|---|---|---|---|---|
/// | single rays | 478 | 1418 | 507 | 373 | 736 | 259 |
/// | 4 | 322 | 1066 | 294 | 213 | 816 | 130 |
/// | 8 | 275 | 961 | 214 | 172 | 855 | 100 |
/// | 16 | 244 | 1036 | 187 | 138 | 839 | 101 |
/// | shafts | 257 | 1068 | 679 | 172 | 828 | 307 |
/// | 16 with a short stack of 3 | 274 | 1280 | 235 | 164 | 1048 | 100 |
/// | 16, MLRTA | 289 | 1195 | 240 | 198 | 870 | 129 |
/// | 16, AEPSA | 230 | 947 | 213 | 198 | 894 | 108 |
///
/// Times of equal work differ by a tenth or more from run to run. What bounces have in common pays for no packets in Sibenik.
/// Shafts go on until all of their rays have ended, for which shadow rays pay. Nor do entry points pay: MLRTA spares 0.4 of
/// 2.5 node visits a ray on the Bunny and 0.8 of 2.2 in Sibenik, but looks at 0.29 and 0.21 nodes, AEPSA at 0.18 and 0.16.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct KdPacketOptions {
    /// How many rays are led to leaves together.
    pub width: KdPacketWidth,
    /// Where their way begins.
    pub entry: KdEntry,
    /// What shafts leave out.
    pub culling: KdCulling,
    /// What packets remember.
    pub mailbox: KdMailbox,
}
