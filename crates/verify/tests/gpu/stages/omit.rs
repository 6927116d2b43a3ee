//! Triangles that no ray can hit are those that the CPU leaves out.

use glam::Vec3;
use umbrage_gpu::{Geometry, Gpu, Omit, Recorder};
use umbrage_rays::{Omitted, Triangles};

use super::numbers;
use crate::common;

fn omitted(gpu: &Gpu, omit: &mut Omit, triangles: Triangles<'_>) -> Omitted {
    let mut geometry = Geometry::new(gpu);
    geometry.write(gpu, triangles, |_| 0).expect("room");
    omit.prepare(gpu, &geometry).expect("room");
    let mut recorder = Recorder::new(gpu);
    omit.record(gpu, &mut recorder, &geometry);
    omit.omitted(&recorder.submit_and_wait().expect("done")).expect("read")
}

#[test]
fn omit_counts_what_the_cpu_leaves_out() {
    let Some(gpu) = common::gpu() else { return };
    let mut omit = Omit::new(&gpu).expect("room for a few words");
    // Zeros of both signs compare equal, as do some of the others.
    let special = [0.0, -0.0, 1.0, f32::NAN, f32::INFINITY, f32::MAX, f32::from_bits(1), -1.0];
    for (seed, size) in [0, 1, 2, 7, 8, 9, 63, 64, 65, 5_000, 200_000].into_iter().enumerate() {
        let seed = 2 * seed as u32;
        // Few vertices for many triangles, and some indices out of range.
        let vertices = 40 + size / 3;
        let positions: Vec<Vec3> = numbers(vertices, seed)
            .iter()
            .enumerate()
            .map(|(index, &number)| {
                let at = special.get(number as usize).copied().unwrap_or(index as f32);
                Vec3::new(at, [0.0, -0.0][index % 2], [at, 3.0][index / 2 % 2])
            })
            .collect();
        let corners = numbers(3 * size, seed + 1);
        let range = vertices as u32 + vertices as u32 / 30;
        let indices: Vec<[u32; 3]> = corners.as_chunks().0.iter().map(|corners| corners.map(|of| of % range)).collect();
        let triangles = Triangles { positions: &positions, indices: &indices };
        let expected = triangles.omitted();
        assert_eq!(omitted(&gpu, &mut omit, triangles), expected, "{size} triangles");
        assert!(
            size < 5_000
                || [&expected.not_finite, &expected.zero_area, &expected.index_out_of_range]
                    .iter()
                    .all(|kind| kind.count > 8)
        );
    }
}

#[test]
fn omit_keeps_the_lowest_of_all_ids() {
    let Some(gpu) = common::gpu() else { return };
    let mut omit = Omit::new(&gpu).expect("room for a few words");
    let indices = vec![[0, 0, 0]; 300_000];
    let triangles = Triangles { positions: &[Vec3::ONE], indices: &indices };
    let found = omitted(&gpu, &mut omit, triangles);
    assert_eq!(found.zero_area.count, 300_000);
    assert_eq!(found.zero_area.first_ids, [0, 1, 2, 3, 4, 5, 6, 7]);
}
