use std::collections::HashMap;

use glam::Vec3;
use umbrage_scene::Frame;

use crate::memory::Budget;

/// Recomputes the normals of moving vertices from the triangles around them, weighted by area.
///
/// Vertices with equal positions and normals at rest share their normal in all poses. So creases stay creases, and seams of
/// texture coordinates stay smooth.
#[derive(Debug)]
pub(super) struct Normals {
    /// For each vertex, the first one with the same position and normal.
    first_alike: Vec<u32>,
    /// Side of the normal at rest: 1 where the triangles are counter-clockwise as seen from it, −1 where they are clockwise,
    /// 0 without a normal.
    side: Vec<f32>,
}

impl Normals {
    /// Prepares for vertices at rest; `None` where these have no normals.
    ///
    /// # Errors
    /// A message, where memory is too small.
    pub(super) fn new(rest: &Frame, budget: &Budget) -> Result<Option<Self>, String> {
        if rest.normals.is_empty() {
            return Ok(None);
        }
        let count = rest.normals.len();
        budget.take_for::<f32>(count, "sides of normals")?;
        let mut normals = Self { first_alike: first_alike(rest, budget)?, side: vec![1.0; count] };
        budget.take_for::<Vec3>(count, "normals")?;
        let mut computed = Vec::with_capacity(count);
        normals.follow(&rest.mesh.triangles, &rest.positions, &mut computed);
        for (side, (computed, normal)) in normals.side.iter_mut().zip(computed.iter().zip(&rest.normals)) {
            *side = match *normal {
                Vec3::ZERO => 0.0,
                _ if computed.dot(*normal) < 0.0 => -1.0,
                _ => 1.0,
            };
        }
        Ok(Some(normals))
    }

    /// Computes normals for `positions`. A normal is zero, which means flat shading, where all triangles around are
    /// degenerate or not finite.
    pub(super) fn follow(&self, triangles: &[[u32; 3]], positions: &[Vec3], normals: &mut Vec<Vec3>) {
        normals.clear();
        normals.resize(self.first_alike.len(), Vec3::ZERO);
        for triangle in triangles {
            let [a, b, c] = triangle.map(|vertex| positions[vertex as usize]);
            // Its length is twice the area.
            let normal = (b - a).cross(c - a);
            if normal.is_finite() {
                triangle.iter().for_each(|&vertex| normals[self.first_alike[vertex as usize] as usize] += normal);
            }
        }
        // The first of equal vertices precedes the others.
        for (vertex, &first) in self.first_alike.iter().enumerate() {
            let first = first as usize;
            let sum = normals[first];
            normals[vertex] = if first == vertex { sum.normalize_or_zero() * self.side[vertex] } else { sum };
        }
    }
}

/// Maps each vertex to the first one with the same position and normal.
fn first_alike(rest: &Frame, budget: &Budget) -> Result<Vec<u32>, String> {
    let (mut first_alike, mut first_with) = (Vec::new(), HashMap::new());
    budget.reserve(&mut first_alike, rest.normals.len(), "vertices that are alike")?;
    for (vertex, (position, normal)) in (0..).zip(rest.positions.iter().zip(&rest.normals)) {
        budget.reserve_map(&mut first_with, 1, "vertices that are alike")?;
        // Adding zero turns -0 into 0.
        let key = [*position, *normal].map(|vector| (vector + Vec3::ZERO).to_array().map(f32::to_bits));
        first_alike.push(*first_with.entry(key).or_insert(vertex));
    }
    Ok(first_alike)
}
