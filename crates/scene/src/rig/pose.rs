//! A rig's vertices in a pose, on the CPU.

use std::ops::Range;
use umbrage_rays::parallel::both;

use glam::{Affine3A, Mat3A, Vec3, Vec3A, Vec4};

use super::{Deltas, Influences, Placement, Pose, Rig, RigPart, Shape};
use crate::Frame;

/// Vertices below which a piece of work is not worth sharing between threads.
const GRAIN: usize = 4096;

/// The vertices of a frame, or some of them. Normals and tangents may be absent.
struct Vertices<'a> {
    positions: &'a mut [Vec3],
    normals: &'a mut [Vec3],
    tangents: &'a mut [Vec4],
}

impl Rig {
    /// Replaces a frame's positions, normals and tangents by those of a pose, on the threads of the current rayon pool.
    ///
    /// # Panics
    /// If the pose is that of another rig.
    pub fn pose(&self, pose: &Pose, frame: &mut Frame) {
        let vertices = self.vertices;
        frame.positions.resize(vertices, Vec3::ZERO);
        frame.normals.resize(if self.has_normals { vertices } else { 0 }, Vec3::ZERO);
        frame.tangents.resize(if self.has_tangents { vertices } else { 0 }, Vec4::ZERO);
        let all =
            Vertices { positions: &mut frame.positions, normals: &mut frame.normals, tangents: &mut frame.tangents };
        self.pose_vertices(pose, 0..vertices, all);
    }

    /// Poses the frame's vertices `range`, of which `vertices` is that part.
    fn pose_vertices(&self, pose: &Pose, range: Range<usize>, mut vertices: Vertices<'_>) {
        if range.len() > GRAIN {
            let middle = range.start + range.len() / 2;
            let (left, right) = vertices.split_at(middle - range.start);
            both(
                || self.pose_vertices(pose, range.start..middle, left),
                || self.pose_vertices(pose, middle..range.end, right),
            );
            return;
        }
        // They have no gaps.
        let from = self.parts.partition_point(|part| part.first_vertex as usize <= range.start).saturating_sub(1);
        for part in self.parts[from..].iter().take_while(|part| (part.first_vertex as usize) < range.end) {
            let shape = &self.shapes[part.shape as usize];
            let first = part.first_vertex as usize;
            let start = range.start.max(first);
            let end = range.end.min(first + shape.positions.len()).max(start);
            let target = start - range.start..end - range.start;
            vertices.range(target).pose(pose, part, shape, start - first..end - first);
        }
    }
}

impl RigPart {
    /// Calls `visit` with posed positions until it returns false; returns whether it never did.
    pub fn positions(&self, pose: &Pose, shape: &Shape, mut visit: impl FnMut(Vec3) -> bool) -> bool {
        const AT_ONCE: usize = 64;
        let (mut positions, mut normals, mut tangents) =
            ([Vec3::ZERO; AT_ONCE], [Vec3::ZERO; AT_ONCE], [Vec4::ZERO; AT_ONCE]);
        let all = shape.positions.len();
        (0..all).step_by(AT_ONCE).all(|first| {
            let range = first..all.min(first + AT_ONCE);
            let mut vertices = Vertices { positions: &mut positions, normals: &mut normals, tangents: &mut tangents };
            let count = range.len();
            vertices.range(0..count).pose(pose, self, shape, range);
            positions[..count].iter().copied().all(&mut visit)
        })
    }
}

impl Vertices<'_> {
    fn split_at(self, middle: usize) -> (Self, Self) {
        let (positions, right_positions) = self.positions.split_at_mut(middle);
        let (normals, right_normals) = self.normals.split_at_mut(middle.min(self.normals.len()));
        let (tangents, right_tangents) = self.tangents.split_at_mut(middle.min(self.tangents.len()));
        let right = Self { positions: right_positions, normals: right_normals, tangents: right_tangents };
        (Self { positions, normals, tangents }, right)
    }

    fn range(&mut self, range: Range<usize>) -> Vertices<'_> {
        Vertices {
            positions: &mut self.positions[range.clone()],
            normals: self.normals.get_mut(range.clone()).unwrap_or_default(),
            tangents: self.tangents.get_mut(range).unwrap_or_default(),
        }
    }

    /// Poses the vertices `source` of a part's shape into these.
    fn pose(&mut self, pose: &Pose, part: &RigPart, shape: &Shape, source: Range<usize>) {
        self.copy_from(shape, source.clone());
        let weights = pose.weights[part.first_weight as usize..].iter().zip(&shape.morph_targets);
        for (&weight, target) in weights.filter(|&(&weight, _)| weight != 0.0) {
            let first = source.start;
            target.positions.add(weight, first, self.positions, |position, delta| *position += delta);
            if !shape.normals.is_empty() {
                target.normals.add(weight, first, self.normals, |normal, delta| *normal += delta);
            }
            if !shape.tangents.is_empty() {
                // W, a tangent's sign, stays as it is.
                target.tangents.add(weight, first, self.tangents, |tangent, delta| *tangent += delta.extend(0.0));
            }
        }
        match part.placement {
            Placement::Rigid { matrix } => self.transform(&pose.matrices[matrix as usize]),
            Placement::Skinned { first_matrix } => {
                self.bend(&pose.matrices[first_matrix as usize..], &shape.influences, source.start);
            }
        }
    }

    /// Copies the shape's vertices `source`; absent normals and tangents become zero.
    fn copy_from(&mut self, shape: &Shape, source: Range<usize>) {
        self.positions.copy_from_slice(&shape.positions[source.clone()]);
        match shape.normals.get(source.clone()) {
            Some(normals) => self.normals.copy_from_slice(normals),
            None => self.normals.fill(Vec3::ZERO),
        }
        match shape.tangents.get(source) {
            Some(tangents) => self.tangents.copy_from_slice(tangents),
            None => self.tangents.fill(Vec4::ZERO),
        }
    }

    /// Moves all vertices by one transform.
    fn transform(&mut self, world_from_mesh: &Affine3A) {
        for position in &mut *self.positions {
            *position = world_from_mesh.transform_point3(*position);
        }
        let normals = NormalTransform::of(&world_from_mesh.matrix3);
        for normal in &mut *self.normals {
            *normal = normals.apply(*normal);
        }
        for tangent in &mut *self.tangents {
            *tangent = apply_to_tangent(&world_from_mesh.matrix3, normals.side, *tangent);
        }
    }

    /// Moves each vertex by the joints that it follows (linear blend skinning); `first` is the first one's index in
    /// `influences`.
    fn bend(&mut self, joints: &[Affine3A], influences: &[Vec<Influences>], first: usize) {
        for (at, position) in self.positions.iter_mut().enumerate() {
            let mut world_from_mesh = Affine3A::ZERO;
            for set in influences {
                set[first + at].add_to(&mut world_from_mesh, joints);
            }
            *position = world_from_mesh.transform_point3(*position);
            let Some(normal) = self.normals.get_mut(at) else { continue };
            let normals = NormalTransform::of(&world_from_mesh.matrix3);
            *normal = normals.apply(*normal);
            if let Some(tangent) = self.tangents.get_mut(at) {
                *tangent = apply_to_tangent(&world_from_mesh.matrix3, normals.side, *tangent);
            }
        }
    }
}

/// Transforms normals like the planes that they are perpendicular to.
struct NormalTransform {
    /// The inverse transpose times the determinant's absolute value. Unlike the inverse it exists for flattening
    /// transforms too.
    matrix: Mat3A,
    /// −1 for a mirroring transform, else 1.
    side: f32,
}

impl NormalTransform {
    fn of(matrix: &Mat3A) -> Self {
        // Products of very small or large scales would leave the range of f32.
        let largest = matrix.x_axis.abs().max(matrix.y_axis.abs()).max(matrix.z_axis.abs()).max_element();
        let scaled = if largest > 0.0 && largest.is_finite() { *matrix * (1.0 / largest) } else { *matrix };
        let (x, y, z): (Vec3A, Vec3A, Vec3A) = (scaled.x_axis, scaled.y_axis, scaled.z_axis);
        let x_normal = y.cross(z);
        let side = if x.dot(x_normal) < 0.0 { -1.0 } else { 1.0 };
        Self { matrix: Mat3A::from_cols(x_normal * side, z.cross(x) * side, x.cross(y) * side), side }
    }

    fn apply(&self, normal: Vec3) -> Vec3 {
        Vec3::from(self.matrix * Vec3A::from(normal)).normalize_or_zero()
    }
}

fn apply_to_tangent(matrix: &Mat3A, side: f32, tangent: Vec4) -> Vec4 {
    let direction = Vec3::from(*matrix * Vec3A::from(tangent.truncate())).normalize_or_zero();
    // The bitangent is made from the normal and the tangent in the world, where a mirror turns their cross product.
    if direction == Vec3::ZERO { Vec4::ZERO } else { direction.extend(tangent.w * side) }
}

impl Influences {
    /// Adds the weighted transforms of this vertex's joints to `sum`; `joints` are the skin's.
    fn add_to(&self, sum: &mut Affine3A, joints: &[Affine3A]) {
        for (&joint, &weight) in self.joints.iter().zip(&self.weights) {
            let joint = &joints[usize::from(joint)];
            let weight = Vec3A::splat(weight);
            sum.matrix3.x_axis += joint.matrix3.x_axis * weight;
            sum.matrix3.y_axis += joint.matrix3.y_axis * weight;
            sum.matrix3.z_axis += joint.matrix3.z_axis * weight;
            sum.translation += joint.translation * weight;
        }
    }
}

impl Deltas {
    /// Calls `add` with each element of `values`, which belong to the vertices from `first` on, and `weight` times that
    /// vertex's difference.
    fn add<T>(&self, weight: f32, first: usize, values: &mut [T], add: impl Fn(&mut T, Vec3)) {
        match self {
            Self::Dense(deltas) => {
                for (value, &delta) in values.iter_mut().zip(&deltas[first..]) {
                    add(value, delta * weight);
                }
            }
            Self::Sparse { vertices, deltas } => {
                let end = first + values.len();
                let before = vertices.partition_point(|&vertex| (vertex as usize) < first);
                for (&vertex, &delta) in vertices[before..].iter().zip(&deltas[before..]) {
                    if vertex as usize >= end {
                        break;
                    }
                    add(&mut values[vertex as usize - first], delta * weight);
                }
            }
        }
    }
}
