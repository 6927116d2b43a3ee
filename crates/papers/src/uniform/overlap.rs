use glam::{DVec3, Vec3};

use super::lattice::Lattice;

/// A triangle in cell coordinates, for tests against cells that its box overlaps.
///
/// Akenine-Möller, *Fast 3D Triangle-Box Overlap Testing*, 2001: a triangle and a box are apart if an axis separates them.
/// The box's own axes are left out, since only cells of the triangle's box are tested. The others are the triangle's normal
/// and the nine products of its edges with the box's axes.
pub(super) struct ExactTriangle {
    corners: [DVec3; 3],
    axes: [DVec3; 10],
    /// Half a cell, grown by the boxes' margin and by rounding.
    half: f64,
}

impl ExactTriangle {
    /// Any vector may serve as an axis, so its rounding doesn't matter. Corners at up to r cells have an error of 3 · 2⁻⁵³
    /// r, and are less than r + 2¹² cells away from a cell. So with three roundings the error of projections is less than
    /// 2⁻⁴⁹ (r + 2¹²) of the axis' 1-norm, by which the half is multiplied.
    pub(super) fn new(lattice: &Lattice, corners: [Vec3; 3]) -> Self {
        let corners = corners.map(|corner| lattice.coordinates(corner.as_dvec3()));
        let reach = corners.iter().fold(0.0_f64, |reach, corner| reach.max(corner.abs().max_element()));
        let roundings = (reach + f64::from(Lattice::MOST_ON_A_SIDE)) / (1_u64 << 49) as f64;
        let [a, b, c] = corners;
        let edges = [b - a, c - b, a - c];
        let mut axes = [edges[0].cross(edges[2]); 10];
        for (index, axis) in axes[..9].iter_mut().enumerate() {
            *axis = edges[index / 3].cross(DVec3::AXES[index % 3]);
        }
        Self { corners, axes, half: 0.5 + Lattice::MARGIN + roundings }
    }

    /// Whether the triangle may overlap a grown cell of its box.
    pub(super) fn overlaps(&self, cell: [u32; 3]) -> bool {
        let middle = DVec3::from_array(cell.map(f64::from)) + 0.5;
        let corners = self.corners.map(|corner| corner - middle);
        !self.axes.iter().any(|axis| {
            let [a, b, c] = corners.map(|corner| axis.dot(corner));
            let radius = self.half * axis.abs().element_sum();
            a.min(b).min(c) > radius || a.max(b).max(c) < -radius
        })
    }
}
