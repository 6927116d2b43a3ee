/// Cuts a polygon, given corner by corner, into the triangles around its first corner.
///
/// Exact for convex polygons; the fan of a concave one may reach outside its outline.
#[derive(Default)]
pub(crate) struct Fan {
    first: Option<u32>,
    last: Option<u32>,
    corners: usize,
}

impl Fan {
    /// Takes the next corner; from the third on, each completes a triangle.
    pub(crate) fn corner(&mut self, vertex: u32) -> Option<[u32; 3]> {
        self.corners += 1;
        let Some(first) = self.first else {
            self.first = Some(vertex);
            return None;
        };
        self.last.replace(vertex).map(|last| [first, last, vertex])
    }

    /// Whether the corners so far enclose nothing: fewer than three.
    pub(crate) fn is_empty(&self) -> bool {
        self.corners < 3
    }
}
