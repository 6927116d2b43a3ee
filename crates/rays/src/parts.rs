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
