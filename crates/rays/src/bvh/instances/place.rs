use glam::{DAffine3, DMat3, DVec3};
use rayon::prelude::*;

use super::{InstancedTriangles, Mesh, Placement};
use crate::Ray;
use crate::bvh::line::Line;
use crate::bvh::split::{Extent, Item};
use crate::bvh::{Bvh, Child, Kind, WIDTH};

/// A placement prepared for rays: 12 bytes. The inverse is computed again for each ray.
///
/// **How far a mesh may be off.** Let M be the matrix of the placement, t its translation, B the computed inverse of M, R the
/// residual 1 − B M with rounding, norms those of the largest row, u = 2⁻⁵³, and ρ a little more than |R| and some u. The
/// inverse maps a vector v to B v up to ρ |B| |v|, as (1 − R)⁻¹ B is the inverse. A ray's direction d becomes B d, up to
/// ρ |B| |d|, or ρ κ in parts of its largest component, where κ = |B| |M|; its origin o becomes B (o − t), up to
/// ρ |B| (|o| + |t|). So near a mesh that reaches as far as m, the line is off by hardly more than
/// ρ |B| (|o| + |t|) + 2 ρ κ (|B| (|o| + |t|) + m), and depths by ρ κ of themselves, which is less than intervals grow by.
/// A corner in the world is rounded to f32, by 2⁻²⁴ of the largest coordinate w there or 2⁻¹⁵⁰, and before that in f64;
/// in the mesh's space that is |B| times as much. All of these are added to the uncertainty of boxes and corners.
#[derive(Clone, Copy)]
pub(super) struct Placed {
    /// The id of the first triangle.
    pub(super) first: u32,
    /// The uncertainty of the mesh's corners for a ray from the world's zero; NaN if the placement is flattened.
    off: f32,
    /// What each unit of the largest coordinate of an origin adds.
    off_by_origin: f32,
}

/// The largest ρ κ of a placement that isn't flattened.
const LARGEST_SKEW: f64 = 1.0 / (1 << 28) as f64;
/// The largest uncertainty of a mesh, in parts of its size: with more, rays have too many candidates.
const MOST_OFF: f64 = 1.0 / 256.0;
/// The largest coordinate in the tree of placements.
const FARTHEST: f64 = (1_u64 << 40) as f64;

/// Prepares all placements, and collects the boxes of those in the tree.
///
/// # Panics
/// If there are more triangles than ids.
pub(super) fn place_all(
    scene: &InstancedTriangles<'_>,
    meshes: &[Mesh],
    placed: &mut Vec<Placed>,
    items: &mut Vec<Item>,
) {
    let placements = scene.placements.par_iter().with_min_len(64).enumerate();
    let place = |(index, placement): (usize, &Placement)| {
        let (placed, extent) = Placed::new(placement, &meshes[placement.mesh as usize]);
        (placed, Item::new(extent, index as u32))
    };
    placements.map(place).unzip_into_vecs(placed, items);
    items.retain(|item| item.extent().low.x <= item.extent().high.x);
    let mut first = 0_u32;
    for (placed, placement) in placed.iter_mut().zip(scene.placements) {
        placed.first = first;
        let next = u32::try_from(scene.mesh(placement).len()).ok().and_then(|count| first.checked_add(count));
        first = next.expect("at most 2³² − 1 triangles in the world");
    }
}

/// The largest sum of a row's magnitudes.
fn norm(matrix: DMat3) -> f64 {
    let DMat3 { x_axis, y_axis, z_axis } = matrix;
    (x_axis.abs() + y_axis.abs() + z_axis.abs()).max_element()
}

impl Placed {
    /// Also the box in the world: an inverted one if nothing is there or the placement is flattened.
    fn new(placement: &Placement, mesh: &Mesh) -> (Self, Extent) {
        const TINY: f64 = 1.0 / (1_u64 << 49) as f64;
        const HALF_ULP: f64 = 1.0 / (1 << 24) as f64;
        let DAffine3 { matrix3: matrix, translation } = placement.world_from_mesh;
        let inverse = matrix.inverse();
        let (stretch, shrink) = (norm(matrix), norm(inverse));
        let residual = norm(DMat3::IDENTITY - inverse * matrix) + TINY * stretch * shrink;
        let rho = 1.1 * residual + TINY;
        let skew = rho * stretch * shrink;
        let [low, high] = world_box(placement, &mesh.hierarchy);
        let reach = low.abs().max(high.abs()).max_element();
        let by_origin = 1.1 * rho * shrink * (1.0 + 2.2 * stretch * shrink);
        let far = translation.abs().max_element();
        let rounding = HALF_ULP * reach + f64::from(f32::from_bits(1)) + TINY * (stretch * mesh.reach + far);
        let off = 1.1 * (shrink * rounding + 2.2 * skew * mesh.reach) + by_origin * far;
        let is_sound = skew <= LARGEST_SKEW && off <= MOST_OFF * mesh.size && reach <= FARTHEST && mesh.is_plain();
        let is_empty = mesh.hierarchy.nodes.is_empty();
        let extent = if is_sound && !is_empty {
            Extent {
                low: low.as_vec3().map(f32::next_down).extend(0.0),
                high: high.as_vec3().map(f32::next_up).extend(0.0),
            }
        } else {
            Extent::EMPTY
        };
        let off = if is_sound || is_empty { (off as f32).next_up().min(f32::MAX) } else { f32::NAN };
        (Self { first: 0, off, off_by_origin: (by_origin as f32).next_up() }, extent)
    }

    /// Whether its triangles are taken one by one.
    pub(super) fn is_flattened(&self) -> bool {
        self.off.is_nan()
    }

    /// A ray's line in the mesh's space, wide enough for all that rounding may do; `None` where f32 can't hold it.
    #[inline(always)]
    pub(super) fn line(&self, placement: &Placement, ray: &Ray) -> Option<Line> {
        let DAffine3 { matrix3, translation } = placement.world_from_mesh;
        let inverse = matrix3.inverse();
        let (origin, direction) = (inverse * (ray.origin - translation), inverse * ray.direction);
        let line = Line::new(&Ray { origin, direction, ..*ray }, 1.0)?;
        let off = self.off_by_origin.mul_add(ray.origin.abs().max_element() as f32, self.off);
        Some(line.widened(off * 1.001))
    }
}

impl Mesh {
    /// Whether all of its triangles are in one hierarchy, in coordinates as they are.
    fn is_plain(&self) -> bool {
        self.hierarchy.scale == 1.0 && self.hierarchy.far.is_none()
    }
}

/// The box of a placed mesh: around the boxes of the children of the root, each transformed.
fn world_box(placement: &Placement, hierarchy: &Bvh) -> [DVec3; 2] {
    let mut bounds = [DVec3::INFINITY, DVec3::NEG_INFINITY];
    let Kind::Node(root) = hierarchy.root.kind() else { return bounds };
    let Some(node) = hierarchy.nodes.get(root) else { return bounds };
    let DAffine3 { matrix3, .. } = placement.world_from_mesh;
    let sizes = DMat3 { x_axis: matrix3.x_axis.abs(), y_axis: matrix3.y_axis.abs(), z_axis: matrix3.z_axis.abs() };
    for slot in (0..WIDTH).filter(|&slot| node.children[slot] != Child::NONE) {
        let corner = |side: usize| DVec3::from_array([0, 1, 2].map(|axis| node.bounds[2 * axis + side][slot].into()));
        let [low, high] = [corner(0), corner(1)];
        let middle = placement.world_from_mesh.transform_point3(0.5 * (low + high));
        let half = sizes * (0.5 * (high - low));
        // More than the roundings of both, and of posed corners in f64.
        let half =
            half + 1e-14 * (middle.abs() + half + placement.world_from_mesh.translation.abs() + sizes * low.abs());
        bounds = [bounds[0].min(middle - half), bounds[1].max(middle + half)];
    }
    bounds
}
