use crate::KdMailbox;

/// How shafts are used. No option changes the hits.
///
/// Nanoseconds of one busy core for each ray, as in [`KdPacketOptions`](crate::KdPacketOptions):
///
/// | | Bunny: camera | bounce | shadow | Sibenik: camera | bounce | shadow |
/// |---|---|---|---|---|---|---|
/// | packets of 16 | 244 | 1036 | 187 | 138 | 839 | 101 |
/// | shafts | 257 | 1068 | 679 | 172 | 828 | 307 |
/// | 16, MLRTA | 289 | 1195 | 240 | 198 | 870 | 129 |
/// | 16, AEPSA | 230 | 947 | 213 | 198 | 894 | 108 |
///
/// A shaft goes on until all of its rays have ended, which costs shadow rays most. Entry points don't pay either: MLRTA
/// saves 0.4 of 2.5 node visits a ray on the Bunny and 0.8 of 2.2 in Sibenik, but visits 0.29 and 0.21 nodes itself,
/// AEPSA 0.18 and 0.16.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ShaftOptions {
    /// Start of the traversal.
    pub entry: KdEntry,
    /// Traversal from there on.
    pub lead: ShaftLead,
    /// How a shaft remembers tested triangles.
    pub mailbox: KdMailbox,
}

/// Traversal from the entry that a shaft has found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ShaftLead {
    /// Packets, by the tree's packet options.
    Packets,
    /// The shaft instead of its rays, with a stack. Leaves cull triangles by this method.
    Shaft(KdCulling),
}

impl Default for ShaftLead {
    fn default() -> Self {
        Self::Shaft(KdCulling::default())
    }
}

/// Start of the traversal of up to 256 rays.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum KdEntry {
    /// At the root.
    #[default]
    Root,
    /// At the lowest node above all leaves with triangles that a shaft around the rays meets (Reshetov et al.,
    /// *Multi-Level Ray Tracing Algorithm*, 2005: MLRTA).
    MultiLevel,
    /// As `MultiLevel` with only the leaves that hold a triangle in the shaft, searched from above (Fowler et al.,
    /// *Accelerated Entry Point Search Algorithm for Real-Time Ray-Tracing*, 2009: AEPSA).
    Accelerated,
}

impl KdEntry {
    /// All entries.
    pub const ALL: [Self; 3] = [Self::Root, Self::MultiLevel, Self::Accelerated];
}

/// How triangles of a leaf are culled for all rays of a shaft at once.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum KdCulling {
    /// Not at all.
    None,
    /// Triangles whose boxes the rays miss by interval arithmetic (Boulos et al., *Geometric and Arithmetic Culling
    /// Methods for Entire Ray Packets*, 2006).
    Intervals,
    /// Triangles that all corner rays of the shaft miss on the same edge (Dmitriev et al., *Faster Ray Tracing with
    /// SIMD Shaft Culling*, 2004).
    CornerRays,
    /// Triangles with all corners outside of one of the shaft's faces (Reshetov, *Faster Ray Packets – Triangle
    /// Intersection through Vertex Culling*, 2007).
    #[default]
    Vertices,
    /// As `Vertices`, with a shaft made in each leaf around the rays that get there (Reshetov 2007).
    TransientFrustum,
}

impl KdCulling {
    /// All methods.
    pub const ALL: [Self; 5] = [Self::None, Self::Intervals, Self::CornerRays, Self::Vertices, Self::TransientFrustum];
}
