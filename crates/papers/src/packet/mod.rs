//! Packets: rays that share an origin or a direction, traced together (Wald et al., *Ray Tracing Animated Scenes using
//! Coherent Grid Traversal*, 2006, §2).
//!
//! In coordinates that are sheared along the packet's middle ray, such rays are points (x, y) of a plane, and a triangle's
//! edge functions and nearness are linear in x and y, for a common origin and a common direction alike: that is [`Space`].
//! [`Planes`] holds 16 triangles in this form, with error bounds. `nearest` and `any_hit` are the two queries; both are a
//! [`Query`] of one traversal.

mod any_hit;
mod blocks;
mod mailbox;
mod nearest;
mod planes;
mod query;
mod space;

pub(crate) use any_hit::{AnyHit, AnyHitBlock};
pub(crate) use blocks::PacketRays;
pub(crate) use mailbox::Mailbox;
pub(crate) use nearest::{Nearest, NearestBlock, Undecided};
pub(crate) use planes::Planes;
pub(crate) use query::Query;
pub(crate) use space::{Common, Group, Points, Range, Space};

/// Rays, or triangles, handled at once.
pub(crate) const LANES: usize = 16;

/// The largest number of blocks of [`LANES`] rays in a packet.
pub(crate) const MOST_BLOCKS: usize = 64;

/// Half the distance from one to the next f32.
pub(crate) const HALF_ULP: f64 = 1.0 / (1 << 24) as f64;

/// Half the distance from one to the next f64.
use umbrage_rays::predicate::ROUNDING;
