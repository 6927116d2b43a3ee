//! A grid that has seen a frame of the same size takes nothing from the heap, and packets through a kd-tree never do.

use glam::{DVec2, DVec3, Vec3};
use umbrage_rays::{
    Camera, KdPacketOptions, KdPacketWidth, KdTree, LightGrid, LightSource, ListedGrid, ListedLightGrid, ListedOptions,
    PerspectiveGrid, Ray, SeenImage, SeenPixels, UniformGrid, UniformOptions, Unmasked, View,
};

use crate::support::{Mesh, Random, view};

#[test]
fn a_steady_perspective_grid_allocates_nothing() {
    let mut mesh = Mesh::soup(&mut Random(1), 2000, 0.01);
    mesh.append(&Mesh::bumpy_ball(Vec3::ZERO, 1.0, 40));
    mesh.append(&Mesh::floor(1, 100.0));
    mesh.positions[17].x = f32::NAN;
    let view = view(200, 150);
    // One thread does all the work, and is the one whose allocations are counted.
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
    let counted = pool.install(|| {
        let mut grid = PerspectiveGrid::default();
        let mut seen = SeenPixels::default();
        [0; 3].map(|_| {
            let before = allocations::on_this_thread();
            grid.build(mesh.triangles(), &view, DVec2::splat(0.5), |_| false).expect("a small image");
            grid.trace(mesh.triangles(), Unmasked, &mut seen);
            allocations::on_this_thread() - before
        })
    });
    assert!(counted[0] > 100, "the first frame is counted: {counted:?}");
    assert_eq!(counted[1..], [0, 0]);
}

#[test]
fn a_steady_listed_grid_allocates_nothing() {
    let mut mesh = Mesh::soup(&mut Random(1), 2000, 0.01);
    mesh.append(&Mesh::bumpy_ball(Vec3::ZERO, 1.0, 40));
    mesh.append(&Mesh::floor(1, 100.0));
    mesh.positions[17].x = f32::NAN;
    let view = view(200, 150);
    // One thread does all the work, and is the one whose allocations are counted.
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
    let counted = pool.install(|| {
        let mut grid = ListedGrid::default();
        let mut seen = SeenPixels::default();
        [0; 3].map(|_| {
            let before = allocations::on_this_thread();
            let options = ListedOptions::DEFAULT;
            grid.build(mesh.triangles(), &view, DVec2::splat(0.5), options, |_| false).expect("a small image");
            grid.trace(mesh.triangles(), Unmasked, &mut seen);
            allocations::on_this_thread() - before
        })
    });
    assert!(counted[0] > 20, "the first frame is counted: {counted:?}");
    assert_eq!(counted[1..], [0, 0]);
}

#[test]
fn a_steady_light_grid_allocates_nothing() {
    let mut mesh = Mesh::default();
    mesh.ball(Vec3::ZERO, 1.0, 12, 0.1);
    mesh.quad([(-3.0, -3.0), (3.0, -3.0), (3.0, 3.0), (-3.0, 3.0)].map(|(x, z)| Vec3::new(x, -1.2, z)));
    let mesh = mesh.moved(1.5, Vec3::Y);
    let camera = Camera::look_at(Vec3::new(1.0, 3.0, 6.0), Vec3::ZERO, Vec3::Y, 0.8);
    let view = View { camera, width: 150, height: 111 };
    let offset_pixels = DVec2::splat(0.5);
    let mut seen = SeenPixels::default();
    let mut camera_grid = PerspectiveGrid::default();
    camera_grid.build(mesh.triangles(), &view, offset_pixels, |_| false).expect("a small image");
    camera_grid.trace(mesh.triangles(), Unmasked, &mut seen);
    let image = SeenImage { triangles: mesh.triangles(), view, offset_pixels, seen: &seen };
    let place = Random(4).point() * 0.3 + Vec3::new(0.5, 4.0, 1.0);
    let lights = [
        LightSource::Point { position: place },
        LightSource::Point { position: Vec3::new(1.8, -0.5, 1.0) },
        LightSource::Directional { direction: Vec3::new(0.2, -1.0, 0.1) },
    ];
    let mut lit = vec![0; seen.triangle.len() / 16];
    // One thread, on which rayon takes no memory either.
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a pool");
    pool.install(|| {
        let mut grid = LightGrid::default();
        let mut frame = || {
            let before = allocations::on_this_thread();
            grid.survey(&image);
            lights.iter().for_each(|light| grid.shadow(&image, light, |_| true, &Unmasked, &mut lit));
            allocations::on_this_thread() - before
        };
        assert!(frame() > 0);
        assert_eq!([frame(), frame()], [0, 0]);
        let mut listed = ListedLightGrid::default();
        let mut frame = || {
            let before = allocations::on_this_thread();
            listed.survey(&image);
            lights.iter().for_each(|light| listed.shadow(&image, light, |_| true, &Unmasked, &mut lit));
            allocations::on_this_thread() - before
        };
        assert!(frame() > 0);
        assert_eq!([frame(), frame()], [0, 0]);
    });
}

#[test]
fn a_steady_uniform_grid_allocates_nothing() {
    let mut mesh = Mesh::soup(&mut Random(1), 2000, 0.01);
    mesh.append(&Mesh::bumpy_ball(Vec3::ZERO, 1.0, 40));
    mesh.append(&Mesh::floor(1, 100.0));
    mesh.append(&Mesh::bumpy_ball(Vec3::new(1.1, 0.2, 0.3), 1e-3, 30));
    mesh.positions[17].x = f32::NAN;
    let (view, offset_pixels) = (view(200, 150), DVec2::splat(0.5));
    let lights = [
        LightSource::Point { position: Vec3::new(2.0, 4.0, 1.0) },
        LightSource::Directional { direction: Vec3::new(0.2, -1.0, 0.1) },
    ];
    for nested_above in [None, Some(8)] {
        // One thread does all the work, and is the one whose allocations are counted.
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
        let counted = pool.install(|| {
            let mut grid = UniformGrid::default();
            grid.set_options(UniformOptions { nested_above, ..UniformOptions::DEFAULT }).expect("possible options");
            let mut seen = SeenPixels::default();
            seen.resize(200, 150);
            let mut lit = vec![0; seen.triangle.len() / 16];
            [0; 3].map(|_| {
                let before = allocations::on_this_thread();
                grid.build(mesh.triangles());
                assert_eq!(grid.nested_grids() > 50, nested_above.is_some(), "{grid:?}");
                grid.see(mesh.triangles(), &view, offset_pixels, |_| true, Unmasked, &mut seen);
                let image = SeenImage { triangles: mesh.triangles(), view, offset_pixels, seen: &seen };
                for light in &lights {
                    grid.shadow(&image, light, |_| true, &Unmasked, &mut lit);
                }
                allocations::on_this_thread() - before
            })
        });
        assert!(counted[0] > 5, "the first frame is counted: {counted:?}");
        assert_eq!(counted[1..], [0, 0]);
    }
}

#[test]
fn packets_through_a_kd_tree_allocate_nothing() {
    let mesh = Mesh::bumpy_ball(Vec3::ZERO, 1.0, 20);
    let mut random = Random(9);
    let rays: Vec<_> = (0..700)
        .map(|step| {
            let spread = if step < 400 { 0.1 } else { 1.0 };
            Ray::new(DVec3::new(0.0, 0.3, 4.0), DVec3::NEG_Z + (random.point() * spread).as_dvec3())
        })
        .collect();
    let mut tree = KdTree::default();
    tree.build(mesh.triangles());
    for width in KdPacketWidth::ALL {
        tree.set_packet_options(KdPacketOptions { width, ..KdPacketOptions::default() });
        let mut hits = vec![None; rays.len()];
        let before = allocations::on_this_thread();
        tree.nearest_of_packet(mesh.triangles(), &rays, |_| true, &mut hits);
        assert_eq!(allocations::on_this_thread() - before, 0, "{width:?}");
        assert!(hits.iter().flatten().count() > 300);
    }
}
