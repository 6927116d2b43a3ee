/// The largest number of rays that are led to leaves together.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum KdPacketWidth {
    /// 4 rays.
    Four,
    /// 8 rays.
    Eight,
    /// 16 rays.
    #[default]
    Sixteen,
}

/// The triangles that a packet remembers to have tested.
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

/// Options for leading packets of rays through a [`KdTree`](super::super::KdTree). None changes the hits.
///
/// The defaults measured best in all. Nanoseconds of one busy core for each ray, for 512² camera rays, the diffuse
/// bounces of those that hit, and shadow rays from there to a point light, on the Bunny (69 K triangles) and in Sibenik
/// (80 K):
///
/// | | Bunny: camera | bounce | shadow | Sibenik: camera | bounce | shadow |
/// |---|---|---|---|---|---|---|
/// | single rays | 478 | 1418 | 507 | 373 | 736 | 259 |
/// | 4 | 322 | 1066 | 294 | 213 | 816 | 130 |
/// | 8 | 275 | 961 | 214 | 172 | 855 | 100 |
/// | 16 | 244 | 1036 | 187 | 138 | 839 | 101 |
/// | 16 with a short stack of 3 | 274 | 1280 | 235 | 164 | 1048 | 100 |
///
/// Times of equal work differ by a tenth or more from run to run. In Sibenik, bounces have too little in common for packets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct KdPacketOptions {
    /// The largest number of rays that are led to leaves together.
    pub width: KdPacketWidth,
    /// The triangles that packets remember.
    pub mailbox: KdMailbox,
}

impl KdPacketOptions {
    /// Sixteen rays, which remember triangles by a hash.
    pub const DEFAULT: Self = Self { width: KdPacketWidth::Sixteen, mailbox: KdMailbox::Hashed };
}

impl Default for KdPacketOptions {
    fn default() -> Self {
        Self::DEFAULT
    }
}
