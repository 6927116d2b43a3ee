//! A triangle as linear functions of a position in an image, or on a face of a light, in f64.

use glam::DVec3;

/// The edge functions of a triangle with homogeneous corners (x, y, w), as factors of (X, Y, 1) for the position X = x / w,
/// Y = y / w. Each belongs to the corner that its edge is opposite to.
///
/// They need no clipping where a triangle reaches behind w = 0 (Olano and Greer, *Triangle Scan Conversion using 2D
/// Homogeneous Coordinates*, 1997). Over the determinant, all three are positive where the triangle is hit at a positive w.
#[derive(Clone, Copy, Debug)]
pub(crate) struct EdgeFunctions {
    pub(crate) edges: [DVec3; 3],
    pub(crate) determinant: f64,
}

impl EdgeFunctions {
    pub(crate) fn new([a, b, c]: [DVec3; 3]) -> Self {
        let edges = [b.cross(c), c.cross(a), a.cross(b)];
        Self { edges, determinant: a.dot(edges[0]) }
    }

    /// The linear function that is `values[corner] / w` at each corner.
    pub(crate) fn through(&self, values: [f64; 3]) -> DVec3 {
        let Self { edges, determinant } = self;
        (edges[0] * values[0] + edges[1] * values[1] + edges[2] * values[2]) / *determinant
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn functions_go_through_the_corners_of_triangles_behind_the_eye_too() {
        let corners = [DVec3::new(1.0, 2.0, 1.0), DVec3::new(-3.0, 1.0, 2.0), DVec3::new(2.0, 1.0, -0.5)];
        let functions = EdgeFunctions::new(corners);
        let values = [3.0, -1.0, 2.0];
        let through = functions.through(values);
        for (corner, (&at, value)) in corners.iter().zip(values).enumerate() {
            assert!((through.dot(at) - value).abs() < 1e-12, "{corner}");
            for (edge, factors) in functions.edges.iter().enumerate() {
                let expected = if edge == corner { functions.determinant } else { 0.0 };
                assert!((factors.dot(at) - expected).abs() < 1e-12, "edge {edge} at corner {corner}");
            }
        }
    }
}
