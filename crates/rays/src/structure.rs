use crate::shot::{Bytes, LightMask, PixelWork, SeenPixels, Shot, Work};
use crate::{ImageTooLarge, LightCells, LightSource, Omitted, Patches, SingleRays, Triangles};

/// A structure that finds the triangles that rays hit. All structures give the predicate's answers, the same bit for bit on
/// any number of threads and at every SIMD level.
///
/// For a structure that answers single rays, each method without a default is one line with
/// [`ray_by_ray`](crate::ray_by_ray).
pub trait Structure: std::fmt::Debug + Send + Sync {
    /// Rebuilds the parts that serve all shots of a frame, on the threads of the current rayon pool. Structures made for the
    /// rays of one shot are rebuilt by the methods that trace them.
    fn build(&mut self, triangles: Triangles<'_>);

    /// As [`build`](Self::build), with a hint of the triangles that move together. Only structures that outlive a frame use
    /// it.
    fn build_parts(&mut self, triangles: Triangles<'_>, _parts: Parts<'_>) {
        self.build(triangles);
    }

    /// Finds the triangle that each pixel of `shot` sees; the shot's triangles are those of the last [`build`](Self::build).
    ///
    /// # Errors
    /// If the image is larger than the structure can sort.
    fn see(&mut self, shot: &Shot<'_>, seen: &mut SeenPixels) -> Result<Work, ImageTooLarge>;

    /// Finds which of the points seen by the pixels of `shot` each light reaches: a mask for each light, in the order of
    /// `lights`.
    ///
    /// A point is lit unless a triangle other than its own blocks the light there, by
    /// [`ShadowRay::blocked_by`](crate::predicate::ShadowRay::blocked_by) and by the shot's `shadow_opacity`. A spot lights
    /// no point outside of its cone.
    ///
    /// # Panics
    /// If there are more or fewer masks than lights, or `seen` isn't of the size of the shot's view. Structures that hold
    /// triangles may panic if the last [`build`](Self::build) was of others.
    fn shadow(&mut self, shot: &Shot<'_>, seen: &SeenPixels, lights: &[LightSource], masks: &mut [LightMask]) -> Work;

    /// The work of each light at the last [`shadow`](Self::shadow), in the order of the lights; empty where it isn't
    /// counted.
    fn work_of_lights(&self) -> &[Work] {
        &[]
    }

    /// The triangles that were left out because no ray can hit them.
    fn omitted(&self) -> &Omitted;

    /// Bytes held.
    fn bytes(&self) -> Bytes;

    /// Checks the structure built for the last shot against its triangles, and the one built for each of the `lights`. It
    /// asks the predicate about every triangle and sample or point, so it takes long for large images.
    ///
    /// # Errors
    /// Describes the first fault.
    fn validate(&mut self, shot: &Shot<'_>, seen: &SeenPixels, lights: &[LightSource]) -> Result<(), String>;

    /// The patches of the triangles of the last [`build`](Self::build), for light on [any points](crate::Scanner::lit_with);
    /// `None` where the structure has none.
    fn patches(&self) -> Option<&Patches> {
        None
    }

    /// The structure's answers to single rays; `None` where it is made for a shot.
    fn single_rays(&self) -> Option<&dyn SingleRays> {
        None
    }

    /// The structure's cells and work, to be shown; `None` where it isn't made for a shot.
    fn specialised(&mut self) -> Option<&mut dyn Specialised> {
        None
    }
}

/// A hint of the triangles of a frame that move together, for structures that outlive a frame.
///
/// No answer depends on it.
#[derive(Clone, Copy, Debug, Default)]
pub struct Parts<'a> {
    /// The part of each triangle: about one affine map takes all triangles of a part from one frame to the next. Empty where
    /// nothing is known: then all triangles are one part.
    pub of_triangle: &'a [u32],
    /// The object of each part. An object's parts deform together, as those of one skin do. Empty where each part is an
    /// object.
    pub objects: &'a [u32],
}

impl Parts<'_> {
    /// The part of a triangle.
    #[must_use]
    pub fn part_of(&self, triangle: u32) -> u32 {
        self.of_triangle.get(triangle as usize).copied().unwrap_or(0)
    }

    /// The object of a triangle.
    #[must_use]
    pub fn object_of(&self, triangle: u32) -> u32 {
        let part = self.part_of(triangle);
        self.objects.get(part as usize).copied().unwrap_or(part)
    }
}

/// A structure that is made for the rays of one camera and each light, whose cells and work can be shown.
pub trait Specialised {
    /// As [`Structure::see`], and counts each pixel's work.
    ///
    /// # Errors
    /// If the image is larger than the structure can sort.
    fn see_counting(
        &mut self,
        shot: &Shot<'_>,
        seen: &mut SeenPixels,
        work: &mut PixelWork,
    ) -> Result<Work, ImageTooLarge>;

    /// Finds the cell of the grid for `light` that each point seen by the pixels of `shot` is in.
    ///
    /// # Panics
    /// If `seen` isn't of the size of the shot's view.
    fn locate(&mut self, shot: &Shot<'_>, seen: &SeenPixels, light: &LightSource, cells: &mut LightCells);
}
