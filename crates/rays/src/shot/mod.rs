//! What a question to a structure is about, and what the answer is.

mod camera_rays;
mod eight_points;
mod opacity;
mod seen;
mod seen_image;
mod tile_order;
pub(crate) mod work;

pub(crate) use camera_rays::CameraRays;
pub(crate) use eight_points::{EightPoints, EightTriangles, cross};
pub use opacity::{Mask, MaskAnswers, MaskPoints, ShadowMask, Unmasked};
pub use seen::SeenPixels;
pub use seen_image::SeenImage;
pub use tile_order::TileOrder;
pub use work::{PixelWork, Work};
