//! Frames whose rays are made on the GPU.

use glam::{DVec3, Vec3};
use umbrage_gpu::{Geometry, Gpu, Recorder};
use umbrage_papers::gpu_kdtree::{KdFrame, KdMaterial, KdPrimary, KdScenery};
use umbrage_papers::{KdTracerOptions, KdTraversal, KdTreeOptions};
use umbrage_rays::predicate::ShadowRay;
use umbrage_rays::{Camera, Hit, LightSource, Projection, SingleRays as _, View};

use super::support::{Mesh, Random, blocks};
use super::{Device, Scene, bits, device, walks};

const MATERIALS: [KdMaterial; 2] =
    [KdMaterial { color: [0.8, 0.5, 0.3], mirror: 0.0 }, KdMaterial { color: [0.7, 0.9, 1.0], mirror: 0.6 }];

pub(crate) const SCENERY: KdScenery = KdScenery {
    light: LightSource::Point { position: Vec3::new(2.0, 4.0, 3.0) },
    light_color: Vec3::new(1.0, 0.9, 0.8),
    ambient: Vec3::splat(0.1),
    sky: Vec3::new(0.2, 0.3, 0.4),
    bounces: 0,
    primary: KdPrimary::Traced,
};

/// Every other triangle mirrors.
fn mirrored(gpu: &Gpu, mesh: Mesh) -> Scene {
    let mut scene = Scene::new(gpu, mesh, KdTreeOptions::DEFAULT);
    let mut geometry = Geometry::new(gpu);
    geometry.write(gpu, scene.mesh.triangles(), |id| id / 2 % 2).expect("room");
    scene.geometry = geometry;
    scene
}

fn things(gpu: &Gpu) -> Scene {
    let mut random = Random(3);
    let mut mesh = Mesh::bumpy_ball(Vec3::ZERO, 1.0, 12);
    mesh.append(&Mesh::floor(4, 3.0).moved(1.0, Vec3::NEG_Y));
    mesh.append(&blocks(&mut random, 12).moved(0.25, Vec3::ZERO));
    mesh.append(&Mesh::soup(&mut random, 20, 0.1));
    mirrored(gpu, mesh)
}

fn view(width: u32, height: u32) -> View {
    let camera = Camera::look_at(Vec3::new(2.5, 1.5, 3.5), Vec3::ZERO, Vec3::Y, 0.9);
    View { camera, width, height }
}

/// Renders a frame and returns its pixels' colours.
pub(crate) fn render(
    gpu: &Gpu,
    frame: &mut KdFrame,
    scene: &Scene,
    view: &View,
    scenery: &KdScenery,
    materials: &[KdMaterial],
) -> Vec<[f32; 4]> {
    loop {
        frame.prepare(gpu, &scene.nodes, view, scenery, materials).expect("room");
        let mut recorder = Recorder::new(gpu);
        frame.record(gpu, &mut recorder, &scene.geometry, &scene.nodes);
        let done = recorder.submit_and_wait().expect("done");
        if frame.finish(gpu, &done).expect("done") {
            return frame.film().read(gpu, (view.width * view.height) as usize).expect("read");
        }
    }
}

/// Compares the hits of the last bounce's rays, and the shadows of their points, with the CPU; returns their numbers.
fn check_last(gpu: &Gpu, frame: &KdFrame, scene: &Scene, traced: bool) -> [usize; 2] {
    let triangles = scene.mesh.triangles();
    let questions = frame.last_shadows().read_shadows(gpu).expect("read");
    let answers = frame.tracer().read_shadows(gpu, questions.len()).expect("read");
    for ((light, point, own), answer) in questions.iter().zip(&answers) {
        let shadow = ShadowRay::new(light, *point);
        assert_eq!(*answer, scene.tree.blocked(triangles, &shadow, *own, &|_, _| true), "{point:?}");
    }
    let rays = frame.last_rays().read_rays(gpu).expect("read");
    let hits = frame.tracer().read_hits(gpu, rays.len()).expect("read");
    if traced {
        for ((ray, own), hit) in rays.iter().zip(&hits) {
            let expected = scene.tree.nearest(triangles, ray, &|hit| Some(hit.triangle) != *own);
            assert_eq!(bits(*hit), bits(expected), "{ray:?} without {own:?}");
        }
    }
    [hits.iter().flatten().count(), answers.iter().filter(|&&blocked| blocked).count()]
}

pub(crate) fn triangle(hit: &Option<Hit>) -> Option<u32> {
    hit.map(|hit| hit.triangle)
}

#[test]
fn every_bounce_is_answered_as_by_the_cpu() {
    let Some(mut device) = device() else { return };
    let Device { gpu, frame } = &mut *device;
    let scene = things(gpu);
    // Some pixels are outside of whole blocks.
    let view = view(50, 42);
    let mut before = usize::MAX;
    for bounces in 0..4 {
        render(gpu, frame, &scene, &view, &KdScenery { bounces, ..SCENERY }, &MATERIALS);
        let [hits, shadowed] = check_last(gpu, frame, &scene, true);
        assert!(hits > 5 && hits < before && shadowed > 2, "{hits} and {shadowed} at {bounces}");
        before = hits;
    }
    // Each stage has a time if the device has timestamps.
    frame
        .prepare(gpu, &scene.nodes, &view, &KdScenery { primary: KdPrimary::Rasterised, ..SCENERY }, &MATERIALS)
        .expect("room");
    let mut recorder = Recorder::new(gpu);
    frame.record(gpu, &mut recorder, &scene.geometry, &scene.nodes);
    let times = recorder.submit_and_wait().expect("done").times;
    let names: Vec<_> = times.iter().map(|stage| stage.name).collect();
    let expected = ["eye", "raster", "surface", "bounce", "line", "blocked", "settle", "lighten"];
    assert!(!gpu.has_timestamps() || names == expected, "{names:?}");
    // The camera's rays are those of the view.
    render(gpu, frame, &scene, &view, &SCENERY, &MATERIALS);
    let rays = frame.last_rays().read_rays(gpu).expect("read");
    assert_eq!(rays.len(), 64 * 7 * 6);
    let seen = rays.iter().filter(|(ray, _)| ray.t_max > ray.t_min);
    let expected =
        (0..6 * 7).flat_map(|block| (0..64).map(move |lane| (block % 7 * 8 + lane % 8, block / 7 * 8 + lane / 8)));
    let expected = expected.filter(|&(column, row)| column < 50 && row < 42);
    assert!(seen.map(|(ray, _)| *ray).eq(expected.map(|(x, y)| view.ray(f64::from(x) + 0.5, f64::from(y) + 0.5))));
}

#[test]
fn each_way_through_the_tree_gives_the_same_image() {
    let Some(mut device) = device() else { return };
    let Device { gpu, frame } = &mut *device;
    let scene = things(gpu);
    let scenery = KdScenery { bounces: 2, ..SCENERY };
    let expected = render(gpu, frame, &scene, &view(40, 40), &scenery, &MATERIALS);
    let sky = expected.iter().filter(|pixel| pixel[..3] == SCENERY.sky.to_array()).count();
    assert!(sky > 100 && sky < 1000, "{sky}");
    for options in walks() {
        frame.set_options(gpu, options);
        let found = render(gpu, frame, &scene, &view(40, 40), &scenery, &MATERIALS);
        assert!(found == expected, "{options:?}");
    }
}

#[test]
fn rasterised_primary_hits_differ_only_at_edges() {
    let Some(mut device) = device() else { return };
    let Device { gpu, frame } = &mut *device;
    let scene = things(gpu);
    let mut parallel = view(100, 80);
    parallel.camera.projection = Projection::Orthographic { half_height: 1.6 };
    for view in [view(100, 80), parallel] {
        let mut found = [KdPrimary::Traced, KdPrimary::Rasterised].map(|primary| {
            let image = render(gpu, frame, &scene, &view, &KdScenery { primary, ..SCENERY }, &MATERIALS);
            check_last(gpu, frame, &scene, primary == KdPrimary::Traced);
            let rays = frame.last_rays().read_rays(gpu).expect("read");
            let hits = frame.tracer().read_hits(gpu, rays.len()).expect("read");
            (image, hits)
        });
        let pairs = found[0].1.iter().zip(&found[1].1);
        let differ = pairs.clone().filter(|(traced, drawn)| triangle(traced) != triangle(drawn)).count();
        // Of coincident triangles, either may be drawn.
        println!("{differ} of {} pixels show another triangle", found[0].1.len());
        assert!(differ < found[0].1.len() / 50, "{differ}");
        for (traced, drawn) in pairs.filter_map(|(traced, drawn)| traced.zip(*drawn)) {
            assert!(
                traced.triangle != drawn.triangle || traced.t.to_bits() == drawn.t.to_bits(),
                "{traced:?} {drawn:?}"
            );
        }
        let [traced, drawn] = &mut found;
        let colors = traced.0.iter().zip(&drawn.0).filter(|(traced, drawn)| traced != drawn).count();
        assert!(colors <= differ, "{colors} of {differ}");
    }
    // With mirrors, about as many differ as in the first hits.
    let [traced, drawn] = [KdPrimary::Traced, KdPrimary::Rasterised].map(|primary| {
        render(gpu, frame, &scene, &view(100, 80), &KdScenery { primary, bounces: 3, ..SCENERY }, &MATERIALS)
    });
    let differ = traced.iter().zip(&drawn).filter(|(traced, drawn)| traced != drawn).count();
    assert!(differ < 160, "{differ}");
}

#[test]
fn light_shadows_and_mirrors_have_the_colours_of_the_formula() {
    let Some(mut device) = device() else { return };
    let Device { gpu, frame } = &mut *device;
    // A plate over a part of a floor, above the camera.
    const EDGE: f32 = 1.875;
    const SIDE: u32 = 96;
    let mut mesh = Mesh::default();
    mesh.quad([
        Vec3::new(-9.0, 0.0, -9.0),
        Vec3::new(9.0, 0.0, -9.0),
        Vec3::new(9.0, 0.0, 9.0),
        Vec3::new(-9.0, 0.0, 9.0),
    ]);
    mesh.quad([
        Vec3::new(EDGE, 5.0, -9.0),
        Vec3::new(9.0, 5.0, -9.0),
        Vec3::new(9.0, 5.0, 9.0),
        Vec3::new(EDGE, 5.0, 9.0),
    ]);
    let mut scene = Scene::new(gpu, mesh, KdTreeOptions::DEFAULT);
    let camera = Camera::look_at(Vec3::new(0.0, 3.0, 0.0), Vec3::ZERO, Vec3::Z, 1.2);
    let view = View { camera, width: SIDE, height: SIDE };
    let slanted = Vec3::new(0.0, -0.8, 0.6);
    frame.set_options(gpu, KdTracerOptions { traversal: KdTraversal::PushDown, ..KdTracerOptions::DEFAULT });
    for floor in 0..2 {
        scene.geometry.write(gpu, scene.mesh.triangles(), |id| if id < 2 { floor } else { 0 }).expect("room");
        let scenery = KdScenery { light: LightSource::Directional { direction: slanted }, bounces: floor, ..SCENERY };
        let image = render(gpu, frame, &scene, &view, &scenery, &MATERIALS);
        let [plate, floor] = [MATERIALS[0], MATERIALS[floor as usize]];
        let [plate_color, floor_color] = [plate, floor].map(|material| Vec3::from(material.color));
        for (place, found) in image.iter().enumerate() {
            let [column, row] = [place as u32 % SIDE, place as u32 / SIDE].map(|at| f64::from(at) + 0.5);
            let ray = view.ray(column, row);
            let on_floor: DVec3 = ray.origin + ray.direction * (ray.origin.y / -ray.direction.y);
            let is_shaded = on_floor.x > EDGE.into();
            let diffuse = floor_color * (1.0 - floor.mirror);
            let lit = if is_shaded { Vec3::ZERO } else { diffuse * SCENERY.light_color * 0.8 };
            // The mirrored ray meets the plate at a distance from the floor's point that follows from the plate's height.
            let at_plate = on_floor.x + ray.direction.x / -ray.direction.y * 5.0;
            let beyond = if at_plate > EDGE.into() { plate_color * SCENERY.ambient } else { SCENERY.sky };
            let mirrored = beyond * floor_color * floor.mirror;
            let expected = diffuse * SCENERY.ambient + lit + mirrored;
            let found = Vec3::new(found[0], found[1], found[2]);
            assert!(found.distance(expected) < 1e-5, "pixel {place}: {found}, not {expected}");
        }
    }
}

#[test]
fn frames_of_one_device_do_not_disturb_each_other() {
    let Some(mut device) = device() else { return };
    let Device { gpu, frame } = &mut *device;
    let scene = things(gpu);
    let scenery = |primary| KdScenery { bounces: 1, primary, ..SCENERY };
    let expected = render(gpu, frame, &scene, &view(96, 96), &scenery(KdPrimary::Traced), &MATERIALS);
    for options in [KdTracerOptions::DEFAULT, walks()[1]] {
        let mut other = KdFrame::new(gpu, options);
        for primary in [KdPrimary::Traced, KdPrimary::Rasterised, KdPrimary::Traced] {
            let found = render(gpu, &mut other, &scene, &view(96, 96), &scenery(primary), &MATERIALS);
            let differ = found.iter().zip(&expected).filter(|(found, expected)| found != expected).count();
            // Rasterised ones may differ only at edges.
            assert!(differ < if primary == KdPrimary::Traced { 1 } else { 150 }, "{options:?}, {primary:?}: {differ}");
        }
    }
}
