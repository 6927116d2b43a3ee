//! Packets through the uniform grid against the perspective grid, the light grid and the predicate.

use glam::{DVec2, Vec3};
use umbrage_rays::{
    Camera, Hit, LightGrid, LightSource, PacketSide, PerspectiveGrid, Projection, SeenImage, SeenPixels, SimdLevel,
    UniformGrid, UniformOptions, Unmasked, View,
};

use crate::support::{self, Mesh, Random, assert_exact, is_same, view};

const MIDDLE: DVec2 = DVec2::splat(0.5);

fn grid(mesh: &Mesh, packet: PacketSide) -> UniformGrid {
    grid_of(mesh, UniformOptions { packet, ..UniformOptions::DEFAULT })
}

/// A coarse grid, in which many cells hold grids.
fn nested(mesh: &Mesh, packet: PacketSide) -> UniformGrid {
    let nested = UniformOptions { cells_per_triangle: 0.3, nested_above: Some(8), ..UniformOptions::DEFAULT };
    grid_of(mesh, UniformOptions { packet, ..nested })
}

fn grid_of(mesh: &Mesh, options: UniformOptions) -> UniformGrid {
    let mut grid = UniformGrid::default();
    grid.set_options(options).expect("possible options");
    grid.build(mesh.triangles());
    grid.check(mesh.triangles()).expect("a valid grid");
    grid
}

/// Sees `mesh` with packets of each size, and compares with the predicate and the perspective grid.
fn check_seen(mesh: &Mesh, view: &View, offset: DVec2) -> SeenPixels {
    let mut expected = SeenPixels::default();
    let mut perspective = PerspectiveGrid::default();
    perspective.build(mesh.triangles(), view, offset, |_| false).expect("a small image");
    perspective.trace(mesh.triangles(), Unmasked, &mut expected);
    let mut seen = SeenPixels::default();
    let forms = [grid, nested].map(|form| PacketSide::ALL.map(|packet| (packet, form)));
    for (place, (packet, form)) in forms.into_iter().flatten().enumerate() {
        form(mesh, packet).see(mesh.triangles(), view, offset, |_| true, Unmasked, &mut seen);
        assert_eq!(seen.order(), expected.order());
        let order = seen.order();
        let wrong = (0..order.places()).find(|&place| seen.triangle[place] != expected.triangle[place]);
        if let Some(place) = wrong {
            let (found, expected) = (seen.triangle[place], expected.triangle[place]);
            panic!("pixel {:?} shows {found} instead of {expected}, {packet:?}, {view:?}", order.pixel(place));
        }
        if place == 2 {
            assert_exact(mesh.triangles(), view, offset, &seen, |_| true);
        }
        let nowhere = |place: &usize| seen.triangle[*place] == SeenPixels::NONE;
        assert!((0..order.places()).filter(nowhere).all(|place| seen.inverse_depth[place].is_nan()));
        let off = |place: usize| (seen.inverse_depth[place] - expected.inverse_depth[place]).abs();
        let most = |place: usize| 2.0 * SeenPixels::RELATIVE_ERROR * expected.inverse_depth[place].abs();
        assert!((0..order.places()).all(|place| off(place).is_nan() || off(place) <= most(place)), "{packet:?}");
    }
    seen
}

/// Lights what `view` shows of `mesh` with packets of some sizes, and compares with the light grid.
fn check_lit(name: &str, mesh: &Mesh, view: &View, lights: &[LightSource]) -> [u32; 2] {
    let mut seen = SeenPixels::default();
    let mut perspective = PerspectiveGrid::default();
    perspective.build(mesh.triangles(), view, MIDDLE, |_| false).expect("a small image");
    perspective.trace(mesh.triangles(), Unmasked, &mut seen);
    let image = SeenImage { triangles: mesh.triangles(), view: *view, offset_pixels: MIDDLE, seen: &seen };
    let mut light_grid = LightGrid::default();
    light_grid.survey(&image);
    let (mut expected, mut lit) = (vec![0; seen.triangle.len() / 16], vec![u16::MAX; seen.triangle.len() / 16]);
    let forms = [grid, nested].map(|form| PacketSide::ALL.map(|packet| form(mesh, packet)));
    let mut grids: Vec<_> = forms.into_iter().flatten().collect();
    let mut counts = [0; 2];
    for (place, light) in lights.iter().enumerate() {
        light_grid.shadow(&image, light, |_| true, &Unmasked, &mut expected);
        for grid in [place % 5, 2, 5 + (place + 1) % 5, 7] {
            grids[grid].shadow(&image, light, |_| true, &Unmasked, &mut lit);
            let wrong = lit.iter().zip(&expected).position(|(lit, expected)| lit != expected);
            if let Some(block) = wrong {
                let (lit, expected) = (lit[block], expected[block]);
                let pixel = seen.order().column_and_row(block * 16);
                panic!("{name}: {light:?}: {lit:016b} instead of {expected:016b} at {pixel:?}, {grid}");
            }
        }
        counts[0] += lit.iter().map(|word| word.count_ones()).sum::<u32>();
    }
    counts[1] = seen.triangle.iter().filter(|&&id| id != SeenPixels::NONE).count() as u32 * lights.len() as u32;
    counts
}

#[test]
fn soups_of_all_sizes_are_seen_exactly() {
    let mut random = Random(1);
    for (width, height) in [(1, 1), (7, 3), (64, 64), (65, 30), (90, 70)] {
        for smallest in [1.0, 0.1, 0.001] {
            check_seen(&Mesh::soup(&mut random, 150, smallest), &view(width, height), MIDDLE);
        }
    }
}

#[test]
fn any_number_of_triangles_is_seen_exactly() {
    let mut random = Random(2);
    for count in 0..40 {
        check_seen(&Mesh::soup(&mut random, count, 0.1), &view(20, 20), DVec2::new(0.1, 0.9));
    }
}

#[test]
fn a_finely_meshed_ball_is_seen_exactly() {
    let mut mesh = Mesh::bumpy_ball(Vec3::new(0.0, 1.0, 0.0), 1.0, 40);
    mesh.append(&Mesh::floor(8, 3.0));
    check_seen(&mesh, &view(67, 45), MIDDLE);
}

#[test]
fn balls_in_stadiums_are_seen_and_lit_exactly() {
    for smallness in [1e-2, 1e-4, 1e-6] {
        let mesh = support::stadium(14, smallness);
        assert!(nested(&mesh, PacketSide::Eight).nested_grids() > 0);
        // From all over the room, and from where the ball fills the view.
        for away in [0.8, 3.0 * smallness] {
            let eye = support::BALL_PLACE + Vec3::new(0.4, 0.5, 0.7) * away;
            let camera = Camera::look_at(eye, support::BALL_PLACE, Vec3::Y, 0.8);
            let view = View { camera, width: 50, height: 40 };
            check_seen(&mesh, &view, MIDDLE);
            let at = |place: Vec3| LightSource::Point { position: support::BALL_PLACE + place };
            let sun = LightSource::Directional { direction: Vec3::new(0.3, -1.0, 0.2).normalize() };
            let lights = [at(Vec3::new(0.2, 0.5, 0.3)), at(Vec3::new(-1.0, 2.0, 1.0) * smallness), sun];
            let [lit, all] = check_lit("stadium", &mesh, &view, &lights);
            assert!(lit > all / 10 && lit < all, "{lit} of {all} from {away}");
        }
    }
}

#[test]
fn cameras_inside_and_wide_views_see_exactly() {
    let mut random = Random(3);
    for look in 0..6 {
        let mesh = Mesh::soup(&mut random, 200, 0.3);
        let camera = Camera::look_at(random.point() * 0.5, random.point(), Vec3::Y, 0.5 + 0.5 * look as f32);
        check_seen(&mesh, &View { camera, width: 70, height: 66 }, MIDDLE);
    }
    // Along the axes, from where planes of the scene are edge-on.
    for look in [Vec3::X, Vec3::NEG_Y, Vec3::NEG_Z] {
        let mut mesh = Mesh::floor(5, 2.0);
        mesh.append(&Mesh::bumpy_ball(Vec3::ZERO, 1.0, 12));
        let camera = Camera::look_at(-look * 4.0, Vec3::ZERO, Vec3::new(0.1, 1.0, 0.3), 0.8);
        check_seen(&mesh, &View { camera, width: 48, height: 40 }, MIDDLE);
    }
}

#[test]
fn triangles_that_cover_the_view_or_lie_behind_are_seen_exactly() {
    let camera = Camera::look_at(Vec3::ZERO, Vec3::NEG_Z, Vec3::Y, 1.0);
    let view = View { camera, width: 70, height: 40 };
    for far in [1e2, 1e4, 1e7] {
        let mut mesh = Mesh::default();
        mesh.push([Vec3::new(-far, -far, -5.0), Vec3::new(far, -far, -5.0), Vec3::new(0.0, far, -5.0)]);
        mesh.push([Vec3::new(-far, -1.0, far), Vec3::new(far, -1.0, far), Vec3::new(0.0, -1.0, -far)]);
        mesh.push([Vec3::new(-far, 0.0, far), Vec3::new(far, 0.0, far), Vec3::new(0.0, 0.0, -far)]);
        mesh.push([Vec3::new(-far, -far, 5.0), Vec3::new(far, -far, 5.0), Vec3::new(0.0, far, 5.0)]);
        let seen = check_seen(&mesh, &view, MIDDLE);
        let order = seen.order();
        let mut inside = (0..order.places()).filter(|&place| order.pixel(place).is_some());
        assert!(inside.all(|place| seen.triangle[place] < 2));
    }
}

#[test]
fn orthographic_views_see_exactly() {
    let (mesh, views) = support::seen_from_both_sides();
    for view in views {
        check_seen(&mesh, &view, MIDDLE);
    }
    let mut random = Random(5);
    let mesh = Mesh::soup(&mut random, 200, 0.05);
    // Some start inside the scene.
    for half_height in [0.5, 2.0, 30.0] {
        for place in [0.2, 3.0] {
            let camera = Camera::look_at(random.point() * place, Vec3::ZERO, Vec3::Y, 1.0);
            let camera = Camera { projection: Projection::Orthographic { half_height }, ..camera };
            check_seen(&mesh, &View { camera, width: 50, height: 37 }, MIDDLE);
        }
    }
}

#[test]
fn orthographic_views_from_far_away_see_exactly() {
    let mut random = Random(14);
    let mut mesh = Mesh::soup(&mut random, 60, 0.05);
    mesh.append(&Mesh::bumpy_ball(Vec3::ZERO, 1.0, 8));
    for far in [1e7, 1e8, 1e9] {
        for _ in 0..2 {
            let direction = random.point().normalize();
            let camera = Camera::look_at(Vec3::ZERO, direction, Vec3::Y, 1.0);
            let projection = Projection::Orthographic { half_height: 1.3 };
            let camera = Camera { position: direction * -far, projection, ..camera };
            check_seen(&mesh, &View { camera, width: 24, height: 21 }, MIDDLE);
        }
    }
}

#[test]
fn huge_offsets_and_scales_are_seen_exactly() {
    let mut random = Random(4);
    let mut mesh = Mesh::soup(&mut random, 100, 0.05);
    mesh.append(&Mesh::bumpy_ball(Vec3::ZERO, 1.0, 8));
    for (scale, offset) in [
        (1e-6, Vec3::ZERO),
        (1.0, Vec3::new(148_376.0, 1234.0, -223_423.0)),
        (1e6, Vec3::ZERO),
        (1e-25, Vec3::ZERO),
        (1e25, Vec3::ZERO),
        (1e-36, Vec3::ZERO),
        (1e35, Vec3::ZERO),
    ] {
        let mut view = view(48, 40);
        view.camera.position = view.camera.position * scale + offset;
        check_seen(&mesh.moved(scale, offset), &view, MIDDLE);
    }
    // From far away, with a narrow view.
    for far in [1e3, 1e6] {
        let camera = Camera::look_at(Vec3::new(0.6, 0.3, 0.7) * far, Vec3::ZERO, Vec3::Y, 4.0 / far);
        check_seen(&mesh, &View { camera, width: 40, height: 40 }, MIDDLE);
    }
}

#[test]
fn masks_are_seen_through() {
    let mut random = Random(6);
    let mut mesh = Mesh::soup(&mut random, 150, 0.3);
    mesh.append(&Mesh::bumpy_ball(Vec3::ZERO, 1.0, 10));
    let view = view(60, 40);
    let is_opaque = |id: u32| !id.is_multiple_of(3);
    let mask = |hit: &Hit| (hit.barycentric[0] * 7.0) as u32 & 1 == 0;
    let mut seen = SeenPixels::default();
    grid(&mesh, PacketSide::Eight).see(mesh.triangles(), &view, MIDDLE, is_opaque, mask, &mut seen);
    assert_exact(mesh.triangles(), &view, MIDDLE, &seen, |hit| is_opaque(hit.triangle) || mask(hit));
}

fn lights(scale: f32, offset: Vec3) -> Vec<LightSource> {
    let at = |x: f32, y: f32, z: f32| LightSource::Point { position: Vec3::new(x, y, z) * scale + offset };
    let sun = |x: f32, y: f32, z: f32| LightSource::Directional { direction: Vec3::new(x, y, z).normalize() };
    let spot = LightSource::Spot {
        position: Vec3::new(2.0, 3.0, 1.0) * scale + offset,
        direction: Vec3::new(-2.0, -3.0, -1.0).normalize(),
        inner_radians: 0.2,
        outer_radians: 0.4,
    };
    vec![
        at(3.0, 5.0, 2.0),
        at(0.3, 0.2, 0.1),
        at(0.0, -1.0, 0.0),
        at(-0.6, -0.999, 0.7),
        at(500.0, 900.0, 300.0),
        at(0.0, 1.7, -6.0),
        spot,
        sun(0.3, -1.0, 0.2),
        sun(0.0, -1.0, 0.0),
        sun(1.0, -0.01, 0.0),
    ]
}

/// A bumpy ball above a floor.
fn room() -> Mesh {
    let mut mesh = Mesh::default();
    mesh.ball(Vec3::new(0.0, 0.1, 0.0), 0.8, 14, 0.1);
    mesh.append(&Mesh::floor(3, 4.0).moved(1.0, Vec3::NEG_Y));
    mesh
}

fn camera() -> Camera {
    Camera::look_at(Vec3::new(1.0, 1.5, 4.0), Vec3::new(0.0, -0.2, 0.0), Vec3::Y, 0.8)
}

#[test]
fn a_ball_above_a_floor_is_lit_exactly() {
    for (width, height) in [(1, 1), (37, 29), (64, 3), (90, 70)] {
        let [lit, all] =
            check_lit("room", &room(), &View { camera: camera(), width, height }, &lights(1.0, Vec3::ZERO));
        assert!(all < 100 || (lit > all / 10 && lit < all), "{lit} of {all}");
    }
}

#[test]
fn scales_and_offsets_are_lit_exactly() {
    let far = Vec3::new(148_376.0, 1_234.0, -223_423.0);
    for (scale, offset) in [(1e-6, Vec3::ZERO), (1e6, Vec3::ZERO), (1.0, far), (300.0, far)] {
        let mut camera = camera();
        camera.position = camera.position * scale + offset;
        let view = View { camera, width: 41, height: 33 };
        check_lit(&format!("room × {scale}"), &room().moved(scale, offset), &view, &lights(scale, offset));
    }
}

#[test]
fn soups_are_lit_exactly() {
    let mut random = Random(7);
    for size in [0, 1, 2, 17, 65, 300] {
        let mesh = Mesh::soup(&mut random, size, 0.02);
        let mut all = lights(1.0, Vec3::ZERO);
        all.extend((0..6).map(|_| LightSource::Point { position: random.point() * 1.5 }));
        all.extend((0..3).map(|_| LightSource::Directional { direction: random.point().normalize() }));
        let view = View { camera: camera(), width: 66, height: 40 };
        check_lit(&format!("{size} triangles"), &mesh, &view, &all);
        let projection = Projection::Orthographic { half_height: 1.8 };
        let view = View { camera: Camera { projection, ..camera() }, ..view };
        check_lit(&format!("{size} triangles, orthographic"), &mesh, &view, &all);
    }
}

#[test]
fn coincident_surfaces_and_lights_on_surfaces_are_lit_exactly() {
    let mut mesh = room();
    mesh.append(&room());
    mesh.append(&room().moved(1.0, Vec3::new(1e-6, 0.0, 0.0)));
    let view = View { camera: camera(), width: 50, height: 40 };
    let mut all = lights(1.0, Vec3::ZERO);
    all.extend([0, 40, 99].map(|vertex| LightSource::Point { position: mesh.positions[vertex] }));
    check_lit("three rooms", &mesh, &view, &all);
}

#[test]
fn masks_let_light_through() {
    let mesh = room();
    let view = View { camera: camera(), width: 60, height: 44 };
    let mut seen = SeenPixels::default();
    grid(&mesh, PacketSide::Eight).see(mesh.triangles(), &view, MIDDLE, |_| true, Unmasked, &mut seen);
    let image = SeenImage { triangles: mesh.triangles(), view, offset_pixels: MIDDLE, seen: &seen };
    let is_opaque = |id: u32| id.is_multiple_of(4);
    let mask = |id: u32, [b, c]: [f32; 2]| (b * 5.0 + c * 3.0 + id as f32) as u32 & 1 == 0;
    let mut light_grid = LightGrid::default();
    light_grid.survey(&image);
    let [mut expected, mut lit, mut unmasked] = [0; 3].map(|_| vec![0; seen.triangle.len() / 16]);
    let mut changed = 0;
    for light in lights(1.0, Vec3::ZERO) {
        light_grid.shadow(&image, &light, is_opaque, &mask, &mut expected);
        grid(&mesh, PacketSide::Four).shadow(&image, &light, is_opaque, &mask, &mut lit);
        assert!(lit == expected, "{light:?}");
        light_grid.shadow(&image, &light, |_| true, &Unmasked, &mut unmasked);
        changed += usize::from(unmasked != lit);
    }
    assert!(changed > 5, "{changed}");
}

#[test]
fn images_are_the_same_on_any_number_of_threads_and_instructions() {
    let mut random = Random(8);
    let mut mesh = Mesh::soup(&mut random, 3000, 0.01);
    mesh.append(&room());
    let view = View { camera: camera(), width: 200, height: 150 };
    let light = LightSource::Point { position: Vec3::new(2.0, 4.0, 1.0) };
    let run = |options: UniformOptions, level: SimdLevel, threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        pool.install(|| {
            let mut grid = UniformGrid::with_level(level);
            grid.set_options(options).expect("possible options");
            grid.build(mesh.triangles());
            let mut seen = SeenPixels::default();
            let counts = grid.see(mesh.triangles(), &view, MIDDLE, |_| true, Unmasked, &mut seen);
            let mut lit = vec![0; seen.triangle.len() / 16];
            let image = SeenImage { triangles: mesh.triangles(), view, offset_pixels: MIDDLE, seen: &seen };
            grid.shadow(&image, &light, |_| true, &Unmasked, &mut lit);
            assert!(grid.bytes() > 100_000);
            (seen, lit, counts)
        })
    };
    let nested = UniformOptions { cells_per_triangle: 0.3, nested_above: Some(8), ..UniformOptions::DEFAULT };
    let mut images = Vec::new();
    for options in [UniformOptions::DEFAULT, nested] {
        let (seen, lit, counts) = run(options, SimdLevel::default(), 1);
        for level in SimdLevel::available() {
            for threads in [1, 3] {
                let other = run(options, level, threads);
                assert!(is_same(&seen, &other.0) && lit == other.1 && counts == other.2, "{level}, {threads} threads");
            }
        }
        let is_counting = cfg!(feature = "statistics");
        assert!(
            counts.named().iter().all(|&(name, count)| (count > 0) == is_counting || name == "asked"),
            "{counts:?}"
        );
        images.push((seen.triangle, lit));
    }
    assert!(images[0] == images[1]);
}
