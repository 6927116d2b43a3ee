use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, mask32x16, u32x16};
use umbrage_rays::simd::lanes::bits_of;
use umbrage_scene::Frame;

use super::lanes::{Each, LANES};

/// The triangles that a block's lanes show: neighbours often show the same one, and each is read once.
pub(crate) struct BlockTriangles {
    pub(crate) of_lanes: Each<u32>,
    /// The number of different triangles.
    count: usize,
    ids: Each<u32>,
    /// The lanes of each triangle, the first in the lowest bit.
    lanes: Each<u16>,
    /// The vertices of each triangle.
    vertices: Each<[u32; 3]>,
}

/// The most triangles whose values are spread to their lanes by a vector's selection each. Above it, lane by lane is faster.
const MOST_SPREAD: usize = 8;

impl BlockTriangles {
    /// Sorts the lanes by their triangles.
    #[inline(always)]
    pub(super) fn new<S: Simd>(simd: S, frame: &Frame, of_lanes: Each<u32>) -> Self {
        let mut triangles = Self { of_lanes, count: 0, ids: [0; LANES], lanes: [0; LANES], vertices: [[0; 3]; LANES] };
        let all = u32x16::simd_from(simd, of_lanes);
        let mut left = u16::MAX;
        while left != 0 {
            let id = of_lanes[left.trailing_zeros() as usize % LANES];
            let lanes = all.simd_eq(id).to_bitmask() as u16;
            let to = triangles.count % LANES;
            (triangles.ids[to], triangles.lanes[to]) = (id, lanes);
            triangles.vertices[to] = frame.mesh.triangles[id as usize];
            triangles.count += 1;
            left &= !lanes;
        }
        triangles
    }

    /// Each triangle's id, with its lanes.
    pub(super) fn with_lanes(&self) -> impl Iterator<Item = (u32, u16)> {
        self.ids.iter().copied().zip(self.lanes).take(self.count)
    }

    /// The values that vertices have, corner by corner.
    #[inline(always)]
    pub(super) fn corners<S: Simd, const N: usize>(
        &self,
        simd: S,
        of_vertex: impl Fn(u32) -> [f32; N],
    ) -> [[f32x16<S>; N]; 3] {
        if self.count > MOST_SPREAD {
            return self.corners_by_lane(simd, of_vertex);
        }
        let mut corners = [[f32x16::splat(simd, 0.0); N]; 3];
        for (&lanes, vertices) in self.lanes.iter().zip(&self.vertices).take(self.count) {
            let lanes = mask32x16::from_bitmask(simd, lanes.into());
            for (corner, &vertex) in corners.iter_mut().zip(vertices) {
                for (to, value) in corner.iter_mut().zip(of_vertex(vertex)) {
                    *to = lanes.select(f32x16::splat(simd, value), *to);
                }
            }
        }
        corners
    }

    #[inline(always)]
    fn corners_by_lane<S: Simd, const N: usize>(
        &self,
        simd: S,
        of_vertex: impl Fn(u32) -> [f32; N],
    ) -> [[f32x16<S>; N]; 3] {
        let mut numbers = [[[0.0; LANES]; N]; 3];
        for (&lanes, vertices) in self.lanes.iter().zip(&self.vertices).take(self.count) {
            for (corner, &vertex) in numbers.iter_mut().zip(vertices) {
                let values = of_vertex(vertex);
                for lane in bits_of(lanes) {
                    for (to, value) in corner.iter_mut().zip(values) {
                        to[lane % LANES] = value;
                    }
                }
            }
        }
        let mut corners = [[f32x16::splat(simd, 0.0); N]; 3];
        for (to, numbers) in corners.as_flattened_mut().iter_mut().zip(numbers.as_flattened()) {
            *to = f32x16::from_slice(simd, numbers);
        }
        corners
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use umbrage_rays::{SimdLevel, dispatch};
    use umbrage_scene::Mesh;

    use super::*;

    #[test]
    fn each_lane_has_the_values_of_its_triangle() {
        let triangles = (0..20).map(|id| [id, 2 * id + 1, 40 - id]).collect();
        let frame = Frame { mesh: Arc::new(Mesh { triangles, ..Mesh::default() }), ..Frame::default() };
        let value = |vertex: u32| [vertex as f32, -0.5 * vertex as f32];
        for different in 1..=LANES as u32 {
            let of_lanes: Each<u32> = std::array::from_fn(|lane| 3 + lane as u32 * 7 % different);
            for level in SimdLevel::available() {
                let (triangles, corners) = dispatch!(level, simd => {
                    let triangles = BlockTriangles::new(simd, &frame, of_lanes);
                    let corners = triangles.corners(simd, value).map(|corner| corner.map(Each::<f32>::from));
                    (triangles, corners)
                });
                let mut ids = of_lanes.to_vec();
                ids.sort_unstable();
                ids.dedup();
                assert_eq!(triangles.with_lanes().count(), ids.len());
                for (id, lanes) in triangles.with_lanes() {
                    assert!((0..LANES).all(|lane| (lanes >> lane & 1 == 1) == (of_lanes[lane] == id)), "{id}");
                }
                for (lane, id) in of_lanes.iter().enumerate() {
                    let vertices = frame.mesh.triangles[*id as usize];
                    let expected = vertices.map(value);
                    assert_eq!(
                        corners.map(|corner| corner.map(|number| number[lane])),
                        expected,
                        "{different} in {level}"
                    );
                }
            }
        }
    }
}
