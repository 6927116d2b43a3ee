/// Cuts a polygon, given corner by corner, into the triangles around its first corner.
///
/// Exact for convex polygons; the fan of a concave one may reach outside its outline.
#[derive(Clone, Copy, Debug, Default)]
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pentagon_becomes_three_triangles_of_its_winding() {
        let mut fan = Fan::default();
        let triangles: Vec<_> = [4, 5, 6, 7, 8].into_iter().filter_map(|vertex| fan.corner(vertex)).collect();
        assert_eq!(triangles, [[4, 5, 6], [4, 6, 7], [4, 7, 8]]);
        assert!(!fan.is_empty());
    }

    #[test]
    fn two_corners_are_no_polygon() {
        let mut fan = Fan::default();
        assert_eq!((fan.corner(1), fan.corner(2)), (None, None));
        assert!(fan.is_empty());
    }
}
