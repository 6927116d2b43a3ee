//! Shading of an empty scene, and images of a few pixels.

use std::time::Instant;

use glam::{DVec2, Vec3};
use umbrage_gpu::shade::{
    Attributes, Develop, FilmKeeps, FilmPlanes, Layer, Shade, ShadeInputs, ShadeSample, ShadeSurroundings, Texels,
    ToneMap,
};
use umbrage_gpu::{Buffer, GpuError, Groups, Recorder};
use umbrage_rays::{Camera, SeenPixels, TileOrder, View};

use crate::common;

const COLOR: Vec3 = Vec3::new(0.25, 0.5, 0.0);

#[test]
fn a_scene_without_triangles_shows_its_surroundings() {
    let Some(gpu) = common::gpu() else { return };
    let start = Instant::now();
    let mut shade = Shade::new(&gpu).expect("room");
    println!("the kernels are ready after {:.2} s", start.elapsed().as_secs_f64());
    let level = |level: usize| ((level.max(1) as f32 - 0.5) / 255.0 + 0.055) / 1.055;
    // The lower levels aren't on the real curve, and aren't used.
    let levels = std::array::from_fn(|index| if index == 0 { 0.0 } else { level(index).powf(2.4) });
    let mut develop = Develop::new(&gpu, &levels).expect("room");
    let mut planes = FilmPlanes::new(&gpu);
    let texels = Texels::new(&[0.0; 256], &[[[0.0; 2]; Texels::ALBEDO_SIDE]; Texels::ALBEDO_SIDE], None);
    shade.set_materials(&gpu, &[], &texels).expect("room");
    shade.set_attributes(&gpu, &Attributes::default(), false).expect("room");
    shade.set_lights(&gpu, &[], 0).expect("room");
    let surroundings =
        ShadeSurroundings { kind: ShadeSurroundings::COLOR, color: COLOR.to_array(), ..ShadeSurroundings::default() };
    shade.set_surroundings(surroundings);
    let [mut seen, lit, positions, indices] =
        ["seen", "lit", "positions", "indices"].map(|name| Buffer::storage(&gpu, name));
    let camera = Camera::look_at(Vec3::ZERO, Vec3::NEG_Z, Vec3::Y, 1.0);
    // The smaller image comes after the larger one, in the same memory.
    for (width, height) in [(1, 1), (130, 70), (3, 5)] {
        let view = View { camera, width, height };
        seen.write(&gpu, &vec![SeenPixels::NONE; TileOrder::new(width, height).slots()]).expect("room");
        planes.prepare(&gpu, [width, height], FilmKeeps { first: true, ..FilmKeeps::default() }).expect("room");
        let inputs = ShadeInputs { seen: &seen, lit: &lit, positions: &positions, triangles: &indices };
        for sample in 0..2 {
            let rays = ShadeSample::new(&view, DVec2::splat(0.5));
            shade.prepare(&gpu, &rays, Layer::only(sample == 0), &planes).expect("room");
            let mut recorder = Recorder::new(&gpu);
            let start = Instant::now();
            recorder.stage("shade", |pass| shade.record(&gpu, pass, &inputs, &planes, Groups::Flat(shade.groups())));
            recorder.submit_and_wait().expect("done");
            println!("{width}x{height} pixels are shaded after {:.3} s", start.elapsed().as_secs_f64());
        }
        develop.prepare(&gpu, &planes, 2, 0.0, ToneMap::Clip).expect("room");
        let mut recorder = Recorder::new(&gpu);
        recorder.stage("develop", |pass| develop.record(&gpu, pass, &planes));
        let fetched = [
            planes.fetch_color(&mut recorder),
            planes.fetch_first(&mut recorder),
            planes.fetch_triangle(&mut recorder),
        ];
        let done = recorder.submit_and_wait().expect("done");

        let pixels = (width * height) as usize;
        assert_eq!(
            done.read::<[f32; 4]>(fetched[0]).expect("read"),
            vec![(2.0 * COLOR).extend(0.0).to_array(); pixels]
        );
        assert_eq!(done.read::<[f32; 4]>(fetched[1]).expect("read"), vec![[0.0, 0.0, 0.0, f32::INFINITY]; pixels]);
        assert_eq!(done.read::<u32>(fetched[2]).expect("read"), vec![SeenPixels::NONE; pixels]);
        // 0.25 and 0.5 are 137 and 188 in sRGB.
        let image: Vec<u32> = develop.read_image(&gpu).expect("read");
        assert_eq!(image, vec![u32::from_le_bytes([137, 188, 0, 255]); pixels]);
    }
}

#[test]
fn a_film_that_has_no_room_says_so() {
    let Some(gpu) = common::gpu() else { return };
    let mut planes = FilmPlanes::new(&gpu);
    assert!(planes.prepare(&gpu, [1920, 1080], FilmKeeps { first: true, through: true, flat: true, ways: 0 }).is_ok());
    let error = planes.prepare(&gpu, [8192, 8192], FilmKeeps::default()).expect_err("a film of 1 GiB");
    assert!(matches!(error, GpuError::TooLarge { bytes: 1_073_741_824, .. }), "{error}");
}
