/// Fineness of a scene, relative to its usual number of triangles.
#[derive(Clone, Copy, Debug)]
pub(super) struct Detail {
    /// Factor on the number of quads along a line.
    scale: f32,
}

impl Detail {
    /// The detail at which a scene that usually has `usual` triangles has `triangles`.
    pub(super) fn for_triangles(triangles: usize, usual: usize) -> Self {
        Self { scale: (triangles as f32 / usual as f32).sqrt() }
    }

    /// Quads along a line that usually has `usual`, at least `least`.
    pub(super) fn quads(self, usual: u32, least: u32) -> u32 {
        ((usual as f32 * self.scale).round() as u32).max(least)
    }

    /// Number of small things, usually `usual`: fewer in a coarse scene, no more in a fine one.
    pub(super) fn things(self, usual: u32) -> u32 {
        ((usual as f32 * (self.scale * self.scale).min(1.0)).round() as u32).min(usual)
    }

    /// Whether ornaments are worth their triangles.
    pub(super) fn is_ornate(self) -> bool {
        const PLAIN: f32 = 0.12;
        self.scale > PLAIN
    }

    /// Makes a part with this detail, or less until it has no more than `limit` triangles or can't be coarser.
    pub(super) fn within<T>(mut self, limit: usize, make: impl Fn(Self) -> T, triangles: impl Fn(&T) -> usize) -> T {
        const COARSEST: f32 = 0.01;
        let mut part = make(self);
        while triangles(&part) > limit && self.scale > COARSEST {
            self.scale *= 0.8;
            part = make(self);
        }
        part
    }
}
