//! Point caches: an OBJ file whose vertices move.

use glam::{Mat3, Vec3};
use umbrage_files::OpenOptions;
use umbrage_scene::Scene;

use crate::pose_allocations::assert_later_poses_allocate_nothing;
use crate::solids::{self, CUBE_POSITIONS, cube_obj, floats, folder};

/// Two triangles that share an edge, with one normal and a seam of texture coordinates along it: 6 vertices at 4 positions.
const FLAG: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 9 9 9\nvt 0 0\nvt 1 1\nvn 0 0 1\no cloth\n\
                    f 1/1/1 2/1/1 3/1/1\nf 1/2/1 3/2/1 4/2/1\n";
const FLAG_POINTS: [Vec3; 5] = [Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::Y, Vec3::splat(9.0)];

type Sample = Vec<Vec3>;

fn points(samples: &[Sample], big_endian: bool) -> Vec<u8> {
    let coordinates: Vec<f32> = samples.iter().flatten().flat_map(Vec3::to_array).collect();
    floats(&coordinates, big_endian)
}

fn pc2(rate: f32, samples: &[Sample]) -> Vec<u8> {
    let count = |count: usize| (count as i32).to_le_bytes();
    let header = [1_i32.to_le_bytes(), count(samples[0].len()), 5_f32.to_le_bytes(), rate.to_le_bytes()].concat();
    [b"POINTCACHE2\0".as_slice(), &header, &count(samples.len()), &points(samples, false)].concat()
}

fn mdd(times: &[f32], samples: &[Sample]) -> Vec<u8> {
    let header = [samples.len(), samples[0].len()].map(|count| (count as i32).to_be_bytes()).concat();
    [header, floats(times, true), points(samples, true)].concat()
}

fn moved(by: Vec3) -> Sample {
    FLAG_POINTS.map(|point| point + by).to_vec()
}

/// At rest; 2 up; 2 up and 4 to the right.
fn flag_samples() -> [Sample; 3] {
    [Vec3::ZERO, 2.0 * Vec3::Z, Vec3::new(4.0, 0.0, 2.0)].map(moved)
}

fn given(name: &str, cache: &[u8], obj: &str, fps: f64) -> Result<Scene, String> {
    let mesh = name.rsplit_once('.').unwrap().0.to_owned() + ".obj";
    let files = [(name, cache), (&mesh, obj.as_bytes())];
    let options = OpenOptions { sequence_fps: fps, ..OpenOptions::default() };
    umbrage_files::open_files(name, files, &options).map_err(|error| error.to_string())
}

fn opened(name: &str, cache: &[u8], obj: &str) -> Scene {
    given(name, cache, obj, 24.0).unwrap()
}

/// Displacement of the first vertex.
fn offset(scene: &Scene, seconds: f64) -> Vec3 {
    scene.at(seconds).unwrap().positions[0]
}

#[test]
fn both_formats_move_the_vertices_of_the_mesh_beside_them() {
    let caches = [("a/flag.pc2", pc2(12.0, &flag_samples())), ("a/flag.MDD", mdd(&[0.0, 0.5, 1.0], &flag_samples()))];
    for (name, cache) in caches {
        let scene = opened(name, &cache, FLAG);
        assert_eq!((scene.duration_seconds(), scene.warnings()), (1.0, &[][..]), "{name}");
        let mut files = [name, "a/flag.obj"].map(std::path::PathBuf::from);
        files.sort();
        assert_eq!(scene.files(), files);
        let rest = opened("flag.obj", FLAG.as_bytes(), FLAG).at(0.0).unwrap();
        for (seconds, by) in
            [(0.0, [0.0; 3]), (0.125, [0.0, 0.0, 0.5]), (0.5, [0.0, 0.0, 2.0]), (0.75, [2.0, 0.0, 2.0])]
        {
            let frame = scene.at(seconds).unwrap();
            frame.check().unwrap();
            let expected: Sample = rest.positions.iter().map(|position| *position + Vec3::from(by)).collect();
            assert_eq!(frame.positions, expected, "{name} at {seconds}");
            assert_eq!(frame.mesh.triangles, rest.mesh.triangles);
            assert_eq!(frame.mesh.tex_coords, rest.mesh.tex_coords);
            assert_eq!(frame.mesh.objects.names(), rest.mesh.objects.names());
        }
        // The end is the last sample; later times start again.
        assert_eq!(offset(&scene, 1.0), Vec3::new(4.0, 0.0, 2.0));
        assert_eq!(offset(&scene, 1.125), Vec3::new(0.0, 0.0, 0.5));
    }
}

#[test]
fn files_on_disk_are_opened_too() {
    let folder = folder(&[("flag.mdd", &mdd(&[0.0, 1.0, 2.0], &flag_samples())), ("flag.obj", FLAG.as_bytes())]);
    let scene = umbrage_files::open(folder.path().join("flag.mdd")).unwrap();
    assert_eq!(offset(&scene, 0.5), Vec3::Z);
}

#[test]
fn sequences_are_of_meshes_alone() {
    let cache = pc2(12.0, &flag_samples());
    let mesh = FLAG.as_bytes();
    let folder = folder(&[("a1.obj", mesh), ("a1.pc2", &cache), ("a2.obj", mesh), ("a2.pc2", &cache)]);
    let scene = umbrage_files::open(folder.path()).unwrap();
    assert_eq!((scene.duration_seconds(), scene.warnings()), (2.0 / 24.0, &[][..]));
}

#[test]
fn frames_of_pc2_last_as_long_as_the_options_say_and_times_of_mdd_as_the_file_says() {
    let cache = pc2(2.0, &flag_samples());
    for (fps, seconds) in [(24.0, 4.0 / 24.0), (1.0, 4.0), (0.5, 8.0)] {
        assert_eq!(given("a.pc2", &cache, FLAG, fps).unwrap().duration_seconds(), seconds);
    }
    for fps in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let error = given("a.pc2", &cache, FLAG, fps).unwrap_err();
        assert!(error.starts_with("a.pc2: ") && error.contains("frames a second"), "{error}");
    }
    // Uneven times, counted from the first.
    let scene = given("a.mdd", &mdd(&[-1.0, 0.0, 3.0], &flag_samples()), FLAG, f64::NAN).unwrap();
    assert_eq!(scene.duration_seconds(), 4.0);
    assert_eq!([0.0, 0.5, 2.5].map(|seconds| offset(&scene, seconds)), [Vec3::ZERO, Vec3::Z, Vec3::new(2.0, 0.0, 2.0)]);
    let scene = opened("a.pc2", &pc2(0.0, &[moved(Vec3::X)]), FLAG);
    assert_eq!((scene.duration_seconds(), offset(&scene, 7.0)), (0.0, Vec3::X));
}

#[test]
fn a_cache_of_another_mesh_or_none_is_refused() {
    let samples = flag_samples();
    let short: Vec<Sample> = samples.iter().map(|sample| sample[1..].to_vec()).collect();
    for (name, cache) in [("a.pc2", pc2(1.0, &short)), ("a.mdd", mdd(&[0.0, 1.0, 2.0], &short))] {
        let error = given(name, &cache, FLAG, 24.0).unwrap_err();
        assert_eq!(error, format!("{name}: the number of points: it moves 4 points, but a.obj has 5 vertices (`v`)"));
        let error = umbrage_files::open_bytes(name, cache).unwrap_err().to_string();
        assert_eq!(error, format!("{name}: a point cache moves a mesh: it needs a.obj beside it"));
        let error = given(name, &mdd(&[0.0, 1.0, 2.0], &samples), "v 0 0", 24.0).unwrap_err();
        assert!(error.starts_with(if name == "a.mdd" { "a.obj: line 1" } else { "a.pc2: byte 0" }), "{error}");
    }
}

#[test]
fn cut_files_are_errors_and_longer_ones_warnings() {
    let samples = flag_samples();
    for (name, cache) in [("a.pc2", pc2(1.0, &samples)), ("a.mdd", mdd(&[0.0, 1.0, 2.0], &samples))] {
        for length in 0..cache.len() {
            let error = given(name, &cache[..length], FLAG, 24.0).unwrap_err();
            let location = if name == "a.pc2" && length < 12 { 0 } else { length };
            assert!(error.starts_with(&format!("{name}: byte {location}: ")), "{error}");
        }
        let error = given(name, &cache[..cache.len() - 1], FLAG, 24.0).unwrap_err();
        assert!(error.ends_with("after 2 of the 3 samples of 5 points it claims"), "{error}");
        let longer = [cache, vec![0; 7]].concat();
        assert_eq!(opened(name, &longer, FLAG).warnings(), ["left out 7 bytes after the last sample"]);
    }
}

#[test]
fn headers_that_make_no_sense_say_where() {
    let samples = flag_samples();
    let (small, big) = (pc2(1.0, &samples), mdd(&[0.0, 1.0, 2.0], &samples));
    let (max, nan) = (i32::MAX.to_le_bytes(), f32::NAN.to_le_bytes());
    for (name, cache, at, word, cause) in [
        ("a.pc2", &small, 0, *b"pOIN", "begins with `POINTCACHE2`"),
        ("a.pc2", &small, 12, 2_i32.to_le_bytes(), "version 2"),
        ("a.pc2", &small, 16, (-5_i32).to_le_bytes(), "-5 points"),
        ("a.pc2", &small, 16, [0; 4], "0 points"),
        ("a.pc2", &small, 24, nan, "sample 1 is at NaN seconds"),
        ("a.pc2", &small, 24, [0; 4], "sample 1 isn't later"),
        ("a.pc2", &small, 24, (-1_f32).to_le_bytes(), "sample 1 isn't later"),
        ("a.pc2", &small, 28, [255; 4], "-1 samples"),
        ("a.pc2", &small, 28, max, "after 3 of the 2147483647 samples"),
        ("a.mdd", &big, 0, [255; 4], "-1 samples"),
        ("a.mdd", &big, 0, [127, 255, 255, 255], "after 0 of the 2147483647 samples"),
        ("a.mdd", &big, 4, [128, 0, 0, 0], "-2147483648 points"),
        ("a.mdd", &big, 4, [127, 255, 255, 255], "samples of 2147483647 points"),
        ("a.mdd", &big, 12, [0; 4], "sample 1 isn't later"),
        ("a.mdd", &big, 16, f32::INFINITY.to_be_bytes(), "sample 2 is at inf seconds"),
    ] {
        let mut cache = cache.clone();
        cache[at..at + 4].copy_from_slice(&word);
        let error = given(name, &cache, FLAG, 24.0).unwrap_err();
        let location = if cause.contains("of the") || cause.contains("samples of") { cache.len() } else { at };
        assert!(error.starts_with(&format!("{name}: byte {location}: ")) && error.contains(cause), "{error}");
    }
    // Both counts are maximal: their product exceeds 64 bits.
    let mut both = small.clone();
    both[16..20].copy_from_slice(&max);
    both[28..32].copy_from_slice(&max);
    assert!(given("a.pc2", &both, FLAG, 24.0).unwrap_err().contains("of 2147483647 points it claims"));
    let error = given("a.pc2", &small, FLAG, 1e-308).unwrap_err();
    assert!(error.contains("no moment"), "{error}");
}

/// A quarter turn in two steps, around an axis that no face of a cube is perpendicular to.
fn turns() -> [Mat3; 3] {
    [0.0, 0.5, 1.0].map(|part| Mat3::from_axis_angle(Vec3::new(1.0, 2.0, 3.0).normalize(), part * 1.6))
}

/// The cube of [`cube_obj`] with `normals`; `of_corner` gives the normal's index for a triangle's number and corner.
fn cube_with_normals(normals: &[Vec3], of_corner: impl Fn(usize, usize) -> usize) -> String {
    let mut text: String = CUBE_POSITIONS.iter().map(|[x, y, z]| format!("v {x} {y} {z}\n")).collect();
    text.extend(normals.iter().map(|normal| format!("vn {} {} {}\n", normal.x, normal.y, normal.z)));
    for (face, triangle) in solids::CUBE_TRIANGLES.iter().enumerate() {
        let corners = triangle.map(|corner| format!("{}//{}", corner + 1, of_corner(face, corner) + 1));
        text += &format!("f {}\n", corners.join(" "));
    }
    text
}

fn turned_cube(obj: &str) -> Scene {
    let samples = turns().map(|turn| CUBE_POSITIONS.map(|corner| turn * Vec3::from(corner)).to_vec());
    opened("cube.mdd", &mdd(&[0.0, 1.0, 2.0], &samples), obj)
}

#[test]
fn normals_turn_with_a_mesh_that_turns_and_creases_stay() {
    // Two triangles per face with the face's normal, written once for each triangle, as by some exporters.
    let face_normal = |face: usize| {
        let [a, b, c] = solids::CUBE_TRIANGLES[face].map(|corner| Vec3::from(CUBE_POSITIONS[corner]));
        (b - a).cross(c - a).normalize()
    };
    let creased = cube_with_normals(&(0..12).map(face_normal).collect::<Vec<_>>(), |face, _| face);
    // The same with inverted normals.
    let inward = cube_with_normals(&(0..12).map(|face| -face_normal(face)).collect::<Vec<_>>(), |face, _| face);
    for obj in [creased, inward] {
        let scene = turned_cube(&obj);
        let rest = opened("cube.obj", obj.as_bytes(), &obj).at(0.0).unwrap();
        for (second, turn) in (0..).zip(turns()) {
            let frame = scene.at(f64::from(second)).unwrap();
            assert_eq!(frame.normals.len(), rest.normals.len());
            for (normal, rest) in frame.normals.iter().zip(&rest.normals) {
                assert!(normal.distance(turn * *rest) < 1e-5, "{normal} at {second} s");
            }
        }
    }
}

#[test]
fn smooth_normals_stay_one_at_each_position() {
    let of_corner: Vec<Vec3> = CUBE_POSITIONS.map(|corner| Vec3::from(corner) - 0.5).to_vec();
    let obj = cube_with_normals(&of_corner, |_, corner| corner);
    let frame = turned_cube(&obj).at(2.0).unwrap();
    assert_eq!(frame.positions.len(), 8);
    for (normal, position) in frame.normals.iter().zip(&frame.positions) {
        let outwards = *position - turns()[2] * Vec3::splat(0.5);
        // Normals lean to faces with two triangles at the corner, since triangles weigh by area.
        assert!(normal.is_normalized() && normal.dot(outwards.normalize()) > 0.9, "{normal} at {position}");
    }
}

#[test]
fn normals_bend_where_the_mesh_does_on_both_sides_of_a_seam() {
    let mut bent = moved(Vec3::ZERO);
    bent[1].z = 1.0;
    let frame = opened("a.mdd", &mdd(&[0.0], &[bent]), FLAG).at(0.0).unwrap();
    let [first, second] = [Vec3::new(-1.0, 1.0, 1.0), Vec3::Z];
    let [at_edge, at_first, at_second] = [first + second, first, second].map(Vec3::normalize);
    let expected = [at_edge, at_first, at_edge, at_edge, at_edge, at_second];
    assert_eq!(frame.normals.len(), expected.len());
    for (normal, expected) in frame.normals.iter().zip(expected) {
        assert!(normal.distance(expected) < 1e-6, "{:?}", frame.normals);
    }
}

#[test]
fn what_is_flat_stays_flat() {
    let flat = String::from_utf8(cube_obj()).unwrap();
    let frame = turned_cube(&flat).at(1.0).unwrap();
    for (id, triangle) in (0..).zip(&frame.mesh.triangles) {
        let [a, b, c] = frame.triangles().corners(id);
        let own = (b - a).cross(c - a).normalize();
        assert!(triangle.iter().all(|&vertex| frame.normals[vertex as usize].distance(own) < 1e-5));
    }
    // Only some corners have normals.
    let some = FLAG.replace("f 1/2/1 3/2/1 4/2/1", "f 1/2 3/2 4/2");
    let frame = opened("a.mdd", &mdd(&[0.0], &[moved(Vec3::ZERO)]), &some).at(0.0).unwrap();
    assert_eq!(frame.normals, [[Vec3::Z; 3], [Vec3::ZERO; 3]].concat());
}

#[test]
fn positions_that_are_no_numbers_stay_and_spoil_no_other_normals() {
    let mut broken = moved(Vec3::ZERO);
    broken[3].y = f32::NAN;
    let frame = opened("a.pc2", &pc2(1.0, &[broken]), FLAG).at(0.0).unwrap();
    frame.check().unwrap();
    assert!(frame.positions[5].is_nan());
    assert_eq!(frame.normals, [[Vec3::Z; 5].as_slice(), &[Vec3::ZERO]].concat());
}

#[test]
fn memory_is_taken_before_it_is_allocated() {
    let cache = pc2(1.0, &vec![moved(Vec3::ZERO); 1000]);
    let files = || [("a.pc2", cache.clone()), ("a.obj", FLAG.as_bytes().to_vec())];
    let open =
        |max_memory| umbrage_files::open_files("a.pc2", files(), &OpenOptions { max_memory, ..OpenOptions::default() });
    // 60 bytes of positions and 8 of a time for each sample.
    open(72_000).unwrap();
    for (max_memory, what) in [(59_000, "reading a.pc2"), (67_000, "samples' times")] {
        let error = open(max_memory).unwrap_err().to_string();
        assert!(error.starts_with("a.pc2: ") && error.contains(what) && error.contains("--max-memory"), "{error}");
    }
}

#[test]
fn later_poses_allocate_nothing() {
    // Enough for many parallel tasks.
    let strip: Sample =
        (0..20_000_u16).map(|point| Vec3::new(f32::from(point / 2), f32::from(point % 2), 0.0)).collect();
    let mut obj: String = strip.iter().map(|point| format!("v {} {} 0\n", point.x, point.y)).collect();
    obj += "vn 0 0 1\n";
    obj.extend((1..19_999).map(|point| format!("f {point}//1 {}//1 {}//1\n", point + 1, point + 2)));
    let lifted = strip.iter().map(|point| *point + Vec3::Z).collect();
    let scene = opened("strip.pc2", &pc2(12.0, &[strip, lifted]), &obj);
    assert_later_poses_allocate_nothing(&scene);
}

#[test]
fn normals_are_made_where_the_mesh_has_none_and_follow_the_cache() {
    // Flat at rest, so that normals equal their triangle's; then folded along the diagonal by less than a crease.
    let folded = [Vec3::ZERO, Vec3::new(1.0, 0.0, 0.3), Vec3::new(1.0, 1.0, 0.0), Vec3::new(0.0, 1.0, 0.3), Vec3::ZERO];
    let mesh = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 9 9 9\nf 1 2 3\nf 1 3 4\n";
    let cache = mdd(&[0.0, 1.0], &[moved(Vec3::ZERO), folded.to_vec()]);
    let scene = opened("flag.mdd", &cache, mesh);
    let normals = |seconds: f64| scene.at(seconds).unwrap().normals;
    assert!(normals(0.0).iter().all(|normal| normal.distance(Vec3::Z) < 1e-6));
    let [first, second] = [[0, 1, 2], [0, 2, 3]].map(|corners: [usize; 3]| {
        let [a, b, c] = corners.map(|corner| folded[corner]);
        (b - a).cross(c - a).normalize()
    });
    let at_end = normals(1.0);
    for vertex in [0, 2] {
        assert!(at_end[vertex].distance((first + second).normalize()) < 1e-6, "{}", at_end[vertex]);
    }
    assert!(at_end[1].distance(first) < 1e-6 && at_end[3].distance(second) < 1e-6);

    // Each vertex of a tin's rim has two normals; its copies follow the same point.
    let tin = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 -1\nv 9 9 9\nf 1 2 3\nf 1 4 2\n";
    let rest = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::NEG_Z, Vec3::splat(9.0)];
    let up = rest.map(|point| point + Vec3::Y);
    let scene = opened("tin.mdd", &mdd(&[0.0, 1.0], &[rest.to_vec(), up.to_vec()]), tin);
    let frame = scene.at(1.0).unwrap();
    frame.check().unwrap();
    assert_eq!((frame.positions.len(), frame.normals.len()), (6, 6));
    assert_eq!(frame.triangles().corners(0), [Vec3::Y, Vec3::X + Vec3::Y, 2.0 * Vec3::Y]);
    assert_eq!(frame.triangles().corners(1), [Vec3::Y, Vec3::new(0.0, 1.0, -1.0), Vec3::X + Vec3::Y]);
}
