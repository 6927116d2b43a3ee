//! Points and lines in pictures.

use std::f32::consts::PI;
use std::sync::Arc;

use glam::{Vec3, Vec4};
use umbrage::rays::{Camera, Choice as _, Projection};
use umbrage::scene::{Alpha, Frame, Marks, Material, Materials, Mesh};
use umbrage::{Background, Film, Layer, Layers, Renderer, Settings, ToneMap};
use umbrage_papers::structures;

const SIDE: u32 = 40;
const RED: Vec3 = Vec3::new(0.8, 0.1, 0.05);
const BLUE: Vec3 = Vec3::new(0.05, 0.1, 0.8);
const GREEN: Vec3 = Vec3::new(0.0, 0.5, 0.0);

/// A material that is shown as it is.
fn unlit(color: Vec3) -> Material {
    Material { base_color: color.extend(1.0), unlit: true, double_sided: true, ..Material::clay() }
}

/// Squares from the middle of the picture to its right, of an unlit green, each at a z with an opacity; then points and lines in
/// red.
fn frame(squares: &[(f32, f32)], points: &[[f32; 3]], lines: &[[[f32; 3]; 2]]) -> Frame {
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    let mut materials = vec![unlit(RED)];
    for &(z, opacity) in squares {
        let first = positions.len() as u32;
        positions.extend([[0.0, -9.0], [9.0, -9.0], [9.0, 9.0], [0.0, 9.0]].map(|[x, y]| Vec3::new(x, y, z)));
        triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
        let alpha = if opacity < 1.0 { Alpha::Blend } else { Alpha::Opaque };
        materials.push(Material { base_color: GREEN.extend(opacity), alpha, ..unlit(GREEN) });
    }
    let mut marks = Marks::default();
    let first = positions.len() as u32;
    positions.extend(points.iter().map(|&point| Vec3::from(point)));
    let first_of_lines = positions.len() as u32;
    positions.extend(lines.as_flattened().iter().map(|&end| Vec3::from(end)));
    let ends = |line: u32| [first_of_lines + 2 * line, first_of_lines + 2 * line + 1];
    marks.add(first..first_of_lines, (0..lines.len() as u32).map(ends), 0);
    let material_of_triangle = (0..triangles.len() as u32).map(|triangle| 1 + triangle / 2).collect();
    Frame {
        positions,
        mesh: Arc::new(Mesh { triangles, material_of_triangle, marks, ..Mesh::default() }),
        materials: Arc::new(Materials { materials, textures: Vec::new() }),
        ..Frame::default()
    }
}

/// Seen from (0, 0, 5), −1 to 1 at z = 0.
fn settings(projection: Projection) -> Settings {
    let camera = Camera { projection, ..Camera::look_at(Vec3::new(0.0, 0.0, 5.0), Vec3::ZERO, Vec3::Y, 1.0) };
    let background = Background::Color(BLUE);
    Settings { width: SIDE, height: SIDE, camera: camera.into(), background, ..Settings::default() }
}

const PARALLEL: Projection = Projection::Orthographic { half_height: 1.0 };
const PERSPECTIVE: Projection = Projection::Perspective { tan_half_height: 0.2 };

fn film(frame: &Frame, settings: &Settings) -> Film {
    Renderer::default().render_frame(frame, settings).expect("a picture").clone()
}

/// The colour of the pixel at x and y from −1 to 1, to four digits: means of several samples have fewer than floats.
fn color(film: &Film, x: f32, y: f32) -> Vec3 {
    let index = |at: f32| ((at + 1.0) * 0.5 * SIDE as f32) as u32;
    (film.color[(index(-y) * SIDE + index(x)) as usize].truncate() * 1e4).round() / 1e4
}

/// How many pixels red covers.
fn area(film: &Film) -> f32 {
    film.color.iter().map(|color| (color.x - BLUE.x) / (RED.x - BLUE.x)).sum()
}

#[test]
fn points_and_lines_cover_their_sizes_as_they_are() {
    for projection in [PARALLEL, PERSPECTIVE] {
        let point = frame(&[], &[[0.31, 0.22, 0.0]], &[]);
        let line = frame(&[], &[], &[[[-0.5, -0.3, 0.0], [0.4, 0.37, 0.0]]]);
        let length = (0.9_f32).hypot(0.67) * SIDE as f32 / 2.0;
        for samples in [64, 50] {
            for (size, tolerance) in [(1.5, 0.15), (6.0, 0.03), (13.0, 0.02)] {
                let settings = Settings { samples, point_size: size, line_width: size, ..settings(projection) };
                let disk = 0.25 * PI * size * size;
                for (frame, expected) in [(&point, disk), (&line, disk + length * size)] {
                    let covered = area(&film(frame, &settings));
                    assert!((covered - expected).abs() < tolerance * expected, "{covered} of {expected} at {size}");
                }
            }
        }
        for (samples, exposure_stops, tone_map) in [(1, 2.0, ToneMap::PbrNeutral), (4, -1.0, ToneMap::Clip)] {
            let settings = Settings { samples, exposure_stops, tone_map, point_size: 6.0, ..settings(projection) };
            let film = film(&point, &settings);
            assert_eq!(color(&film, 0.31, 0.22), RED);
            let shown = film.develop(&settings).pixels[(SIDE * 15 + 26) as usize];
            assert_eq!(shown.map(|level| level >> 8), [232, 89, 63], "whatever the exposure");
        }
    }
}

#[test]
fn surfaces_hide_what_is_behind_them() {
    let points = [[-0.5, 0.5, -1.0], [0.5, 0.5, -1.0], [0.5, -0.5, 1.0], [0.6, 0.0, 0.0]];
    let scene = frame(&[(0.0, 1.0)], &points, &[]);
    for samples in [1, 4, 9] {
        let film = film(&scene, &Settings { samples, point_size: 6.0, ..settings(PARALLEL) });
        assert_eq!([color(&film, -0.5, 0.5), color(&film, 0.5, 0.5), color(&film, 0.5, -0.5)], [RED, GREEN, RED]);
        assert_eq!(color(&film, 0.6, 0.0), RED, "on the surface itself");
        assert_eq!([color(&film, -0.9, -0.9), color(&film, 0.9, -0.9)], [BLUE, GREEN]);
    }
    // A line through the surface, with colours from red to black.
    let mut through = frame(&[(0.0, 1.0)], &[], &[[[0.1, 0.3, 3.0], [0.9, 0.3, -2.0]]]);
    let mut colors = vec![Vec4::ONE; through.positions.len()];
    colors[5] = Vec4::new(0.0, 0.0, 0.0, 1.0);
    Arc::make_mut(&mut through.mesh).colors = colors;
    for (projection, is_perspective) in [(PARALLEL, false), (PERSPECTIVE, true)] {
        let film = film(&through, &Settings { samples: 4, line_width: 4.0, ..settings(projection) });
        let (mut last, mut shown) = (f32::MAX, 0);
        for part in (0..=100).map(|step| step as f32 / 100.0) {
            let [x, y, z] = [0.1 + 0.8 * part, 0.3, 3.0 - 5.0 * part];
            let scale = if is_perspective { 5.0 / (5.0 - z) } else { 1.0 };
            // A pixel that is beside the line shows another part of it.
            if x * scale >= 1.0 || z.abs() < 0.9 {
                continue;
            }
            let color = color(&film, x * scale, y * scale);
            if z < 0.0 {
                assert_eq!(color, GREEN, "{part} is behind it");
            } else {
                assert!((color.x - RED.x * (1.0 - part)).abs() < 0.06 && color.x <= last, "{color} at {part}");
                (last, shown) = (color.x, shown + 1);
            }
        }
        assert!(shown > 30);
    }
}

#[test]
fn the_nearest_point_counts_and_of_equal_ones_the_first() {
    let points = [[0.1, 0.0, 0.0], [-0.1, 0.0, 0.5], [0.3, 0.0, 0.5]];
    let mut scene = frame(&[], &points, &[]);
    Arc::make_mut(&mut scene.mesh).colors =
        vec![Vec4::new(1.0, 0.0, 0.0, 1.0), Vec4::ONE, Vec4::new(0.5, 0.5, 0.5, 1.0)];
    let film = film(&scene, &Settings { point_size: 12.0, ..settings(PARALLEL) });
    assert_eq!([color(&film, -0.2, 0.0), color(&film, 0.07, 0.0), color(&film, 0.4, 0.0)], [RED, RED, RED * 0.5]);
}

#[test]
fn lines_end_before_the_camera_and_reach_out_of_the_picture() {
    // From behind the camera, through its plane, along the image; and one that is far longer than that.
    let lines = [
        [[-0.3, 0.0, 20.0], [-0.3, -0.2, -20.0]],
        [[-1e6, 0.5, 0.0], [1e6, 0.5, 0.0]],
        [[0.0, 0.0, 6.0], [0.0, 0.0, 9.0]],
    ];
    for projection in [PARALLEL, PERSPECTIVE] {
        let film = film(&frame(&[], &[[0.0, 0.0, 5.5]], &lines), &Settings { line_width: 3.0, ..settings(projection) });
        assert_eq!([color(&film, -0.95, 0.5), color(&film, 0.95, 0.5)], [RED; 2]);
        assert_eq!(color(&film, 0.0, 0.0), BLUE, "what is behind the camera");
        assert!(area(&film) > 2.5 * SIDE as f32 + 2.0, "the first line is seen");
    }
    let nowhere = frame(&[], &[[f32::NAN, 0.0, 0.0], [f32::MAX; 3]], &[[[0.0; 3], [f32::INFINITY; 3]], [[0.3; 3]; 2]]);
    let film = film(&nowhere, &Settings { samples: 64, ..settings(PARALLEL) });
    assert!((area(&film) - PI).abs() < 0.3, "a line without a length is a disk");
}

#[test]
fn what_is_behind_panes_is_seen_through_them() {
    let points = [[0.5, 0.5, 0.5], [0.5, -0.5, -2.0], [-0.5, -0.5, -2.0], [0.3, 0.0, 2.0]];
    let scene = frame(&[(1.0, 0.5), (0.0, 0.5), (-1.0, 1.0)], &points, &[]);
    let unseen = frame(&[(1.0, 0.5), (0.0, 0.5), (-1.0, 1.0)], &[], &[]);
    for structure in structures().iter() {
        for samples in [1, 4] {
            let settings = Settings { samples, structure: structure.clone(), point_size: 6.0, ..settings(PERSPECTIVE) };
            let film = film(&scene, &settings);
            let between = color(&film, 0.5 * 5.0 / 4.5, 0.5 * 5.0 / 4.5);
            assert!(between.abs_diff_eq(GREEN.lerp(RED, 0.5), 1e-4), "{between}");
            assert!(color(&film, 0.36, -0.36).abs_diff_eq(GREEN, 1e-6), "behind what is opaque");
            assert_eq!([color(&film, -0.36, -0.36), color(&film, 0.5, 0.0)], [RED; 2], "before everything");
        }
    }
    // The triangles' own layers stay the same.
    let layers: Layers = Layer::all().filter(|&layer| layer != Layer::Motion).collect();
    let settings = Settings { samples: 4, layers, point_size: 9.0, ..settings(PERSPECTIVE) };
    let (with, without) = (film(&scene, &settings), film(&unseen, &settings));
    assert_ne!(with.color, without.color);
    assert_eq!((with.depth, with.normal, with.triangle), (without.depth, without.normal, without.triangle));
    assert_eq!(format!("{:?}", with.layers), format!("{:?}", without.layers));
}

#[test]
fn pictures_depend_on_neither_threads_nor_structure() {
    let random = |number: u32| (number.wrapping_mul(2_654_435_761) >> 8) as f32 / (1 << 23) as f32 - 1.0;
    let spot = |number: u32| [0, 1, 2].map(|axis| random(3 * number + axis));
    let points: Vec<_> = (0..400).map(spot).collect();
    let lines: Vec<_> = (0..60).map(|line| [spot(1000 + 2 * line), spot(1001 + 2 * line)]).collect();
    let scene = frame(&[(0.2, 0.6), (-0.3, 1.0)], &points, &lines);
    let plain = Settings { samples: 4, width: 70, height: 67, point_size: 3.0, bounces: 2, ..settings(PERSPECTIVE) };
    let expected = film(&scene, &plain);
    for structure in structures().iter() {
        for threads in [1, 3] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
            let found = pool.install(|| film(&scene, &Settings { structure: structure.clone(), ..plain.clone() }));
            assert_eq!(found.color, expected.color, "{structure:?} on {threads}");
            assert_eq!(found.flat, expected.flat, "{structure:?} on {threads}");
        }
    }
}

#[test]
fn transparent_pictures_are_opaque_where_points_are() {
    let transparent = Settings { background: Background::Transparent, point_size: 6.0, ..settings(PARALLEL) };
    let film = film(&frame(&[], &[[0.5, 0.5, 0.0]], &[]), &transparent);
    let image = film.develop(&transparent);
    assert_eq!([image.alpha[(SIDE * 10 + 30) as usize], image.alpha[0]], [u16::MAX, 0]);
}

#[test]
fn points_are_blurred_by_a_lens() {
    let scene = frame(&[], &[[0.0, 0.0, -5.0]], &[]);
    let sharp = Settings { samples: 64, point_size: 4.0, ..settings(PERSPECTIVE) };
    let wide = Settings { aperture: 2.0, focus: Some(5.0), ..sharp.clone() };
    let [sharp, wide] = [sharp, wide].map(|settings| film(&scene, &settings));
    assert_eq!(color(&sharp, 0.0, 0.0), RED);
    assert!(color(&wide, 0.0, 0.0).x < 0.5 * RED.x);
    assert!((area(&sharp) - area(&wide)).abs() < 0.05 * area(&sharp), "{} and {}", area(&sharp), area(&wide));
}

#[test]
fn sizes_that_are_none_are_refused() {
    for size in [0.0, 0.49, 101.0, f32::NAN] {
        let points = Settings { point_size: size, ..settings(PARALLEL) };
        let lines = Settings { line_width: size, ..settings(PARALLEL) };
        for (settings, part) in [(points, "points of"), (lines, "lines of")] {
            let error = Renderer::default().render_frame(&frame(&[], &[], &[]), &settings).unwrap_err().to_string();
            assert!(error.contains(part) && error.contains("0.5 to 100"), "{error}");
        }
    }
}

#[test]
fn any_number_of_panes_is_seen_through() {
    let panes = |count: u32, opacity: f32| -> Vec<(f32, f32)> {
        let behind = std::iter::once((-1.0, 1.0));
        behind.chain((0..count).map(|pane| (1.0 + pane as f32 * 0.01, opacity))).collect()
    };
    for count in [31, 32, 40, 200, 300] {
        let mut scene = frame(&panes(count, 0.01), &[], &[]);
        // Panes are black, and the surface behind them is green.
        for material in &mut Arc::make_mut(&mut scene.materials).materials[2..] {
            material.base_color = Vec4::new(0.0, 0.0, 0.0, 0.01);
        }
        let seen = color(&film(&scene, &settings(PARALLEL)), 0.5, 0.5);
        // Behind 256, the next surface that is opaque is seen.
        let expected = GREEN * 0.99_f32.powi(count.min(256) as i32);
        assert!(seen.abs_diff_eq(expected, 1e-4), "{seen} through {count} panes, rather than {expected}");
    }
}
