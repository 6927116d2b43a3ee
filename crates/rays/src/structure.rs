use crate::shot::{Bytes, LightMask, PixelWork, SeenPixels, Shot, Work};
use crate::{ImageTooLarge, LightCells, LightSource, Omitted, Parts, Patches, SingleRays, Triangles};

/// What finds the triangles that rays hit. Every structure gives the same answers, which are the predicate's: bit for bit
/// the same on any number of threads and at every SIMD level.
///
/// A structure that answers single rays is whole with [`ray_by_ray`](crate::ray_by_ray): each method that has no default is
/// then a line.
pub trait Structure: std::fmt::Debug + Send + Sync {
    /// Rebuilds what serves all shots of a frame, on the threads of the current rayon pool. Structures that are made for the
    /// rays of one shot are rebuilt by the methods that trace these.
    fn build(&mut self, triangles: Triangles<'_>);

    /// The same, where it is known which triangles move together. Only structures that outlive a frame use that.
    fn build_parts(&mut self, triangles: Triangles<'_>, _parts: Parts<'_>) {
        self.build(triangles);
    }

    /// Finds what each pixel of `shot` sees; its triangles are those of the last [`build`](Self::build).
    ///
    /// # Errors
    /// Where the image is larger than the structure can sort.
    fn see(&mut self, shot: &Shot<'_>, seen: &mut SeenPixels) -> Result<Work, ImageTooLarge>;

    /// Finds which of the points that the pixels of `shot` have `seen` each light reaches: a mask for each light, in their
    /// order.
    ///
    /// A point is lit unless some triangle but its own shadows it as
    /// [`ShadowRay::blocked_by`](crate::predicate::ShadowRay::blocked_by) says, where the shot's `shadow_opacity` says that
    /// it stops rays; and a spot lights no point outside of its cone.
    ///
    /// # Panics
    /// If there are more or fewer masks than lights, or `seen` isn't of the size of the shot's view. Structures that hold
    /// triangles may, if the last [`build`](Self::build) was of others.
    fn shadow(&mut self, shot: &Shot<'_>, seen: &SeenPixels, lights: &[LightSource], masks: &mut [LightMask]) -> Work;

    /// What each light took at the last [`shadow`](Self::shadow), in their order; empty where that isn't counted.
    fn work_of_lights(&self) -> &[Work] {
        &[]
    }

    /// The triangles that were left out because no ray can hit them.
    fn omitted(&self) -> &Omitted;

    /// Bytes held.
    fn bytes(&self) -> Bytes;

    /// Checks what was built for the last shot against its triangles, and what is built for each of the `lights`. It asks the
    /// predicate about every triangle and sample or point, so it takes long for large images.
    ///
    /// # Errors
    /// With what is wrong first.
    fn validate(&mut self, shot: &Shot<'_>, seen: &SeenPixels, lights: &[LightSource]) -> Result<(), String>;

    /// The patches that it has of the triangles of the last [`build`](Self::build), for light on
    /// [any points](crate::Scanner::lit_with); `None` where it has none.
    fn patches(&self) -> Option<&Patches> {
        None
    }

    /// The structure as one for single rays; `None` where it is made for a shot.
    fn single_rays(&self) -> Option<&dyn SingleRays> {
        None
    }

    /// The structure as one whose cells can be shown; `None` where it isn't made for a shot.
    fn specialised(&mut self) -> Option<&mut dyn Specialised> {
        None
    }
}

/// A structure that is made for the rays of one camera and each light, whose cells and work can be shown.
pub trait Specialised {
    /// As [`Structure::see`], and counts the work that each pixel is.
    ///
    /// # Errors
    /// Where the image is larger than the structure can sort.
    fn see_counting(
        &mut self,
        shot: &Shot<'_>,
        seen: &mut SeenPixels,
        work: &mut PixelWork,
    ) -> Result<Work, ImageTooLarge>;

    /// Finds in which cell of the grid for `light` each point is that the pixels of `shot` have `seen`.
    ///
    /// # Panics
    /// If `seen` isn't of the size of the shot's view.
    fn locate(&mut self, shot: &Shot<'_>, seen: &SeenPixels, light: &LightSource, cells: &mut LightCells);
}
