//! Contents of OBJ files, vertex by vertex.

use glam::{Vec2, Vec3};
use umbrage_files::OpenOptions;
use umbrage_scene::Material;

use crate::solids::{self, C_OUTLINE, area, frame, open, warning};

const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

#[test]
fn faces_without_normals_or_materials_are_flat_clay() {
    let frame = frame("a.obj", format!("# a triangle\n{TRIANGLE}f 1 2 3\n").as_bytes());
    assert_eq!(frame.positions, [Vec3::ZERO, Vec3::X, Vec3::Y]);
    assert_eq!(frame.mesh.triangles, [[0, 1, 2]]);
    assert_eq!(frame.mesh.material_of_triangle, [0]);
    assert!(frame.normals.is_empty() && frame.tangents.is_empty() && frame.mesh.colors.is_empty());
    assert!(frame.mesh.tex_coords.iter().all(Vec::is_empty));
    let [material] = frame.materials.materials.as_slice() else { panic!("{:?}", frame.materials) };
    assert_eq!(*material, Material::clay());
}

#[test]
fn polygons_become_fans() {
    let text = "v 0 0 0\nv 1 0 0\nv 2 1 0\nv 1 2 0\nv 0 1 0\nf 1 2 3 4 5\n";
    assert_eq!(frame("a.obj", text.as_bytes()).mesh.triangles, [[0, 1, 2], [0, 2, 3], [0, 3, 4]]);
}

#[test]
fn notches_and_holes_of_polygons_stay_open() {
    let lines = |outline: &[[u8; 2]]| outline.iter().map(|[x, y]| format!("v {x} {y} 7\n")).collect::<String>();
    let c = lines(&C_OUTLINE);
    // Before its vertices and behind them, among other faces.
    for text in [format!("f 1 2 3 4 5 6 7 8\n{c}"), format!("{c}f 1 2 3 4 5 6 7 8\n")] {
        let frame = frame("a.obj", text.as_bytes());
        assert_eq!((area(&frame), frame.mesh.triangles.len()), (10.0, 6));
    }
    let hole = [[0, 0], [4, 0], [4, 4], [0, 4], [1, 1], [1, 3], [3, 3], [3, 1]];
    let text = lines(&hole) + "f 1 2 3 4 1 5 6 7 8 5\n";
    assert_eq!(area(&frame("a.obj", text.as_bytes())), 12.0);
}

#[test]
fn a_concave_polygon_keeps_its_triangles_together() {
    let c: String = C_OUTLINE.iter().map(|[x, y]| format!("v {x} {y} 0\n")).collect();
    let text = format!("o a\nf 9 10 11\no b\nf 1 2 3 4 5 6 7 8\no c\nf 9 10 11\n{c}{TRIANGLE}");
    let frame = frame("a.obj", text.as_bytes());
    let objects: Vec<_> = (0..8).map(|triangle| frame.mesh.objects.of_triangle(triangle)).collect();
    let [a, b, c] = [0, 1, 2].map(Some);
    assert_eq!(objects, [a, b, b, b, b, b, b, c]);
    assert_eq!(area(&frame), 11.0);
}

#[test]
fn negative_indices_count_back_from_where_they_stand() {
    let text = format!("{TRIANGLE}f -3 -2 -1\nv 5 0 0\nv 6 0 0\nv 5 1 0\nf -3 -2 -1\n");
    let frame = frame("a.obj", text.as_bytes());
    assert_eq!(frame.mesh.triangles, [[0, 1, 2], [3, 4, 5]]);
    assert_eq!(frame.positions[3], Vec3::new(5.0, 0.0, 0.0));
}

#[test]
fn positive_indices_may_point_ahead() {
    let frame = frame("a.obj", format!("f 1 2 3\n{TRIANGLE}f 3 2 1\n").as_bytes());
    assert_eq!(frame.mesh.triangles, [[0, 1, 2], [2, 1, 0]]);
}

#[test]
fn corners_are_shared_only_where_everything_is_the_same() {
    let text = format!(
        "{TRIANGLE}v 1 1 0\nvt 0 0\nvt 1 0.25\nvn 0 0 2\nvn 0 3 0\n\
         o one\nf 1/1/1 2/1/1 3/2/1\no two\ng three\nf 1/1/1 3/2/1 4/1/1\nf 1/1/2 3/1/1 4//1\nf 1 2/1 3\n"
    );
    let frame = frame("a.obj", text.as_bytes());
    assert_eq!(frame.mesh.triangles, [[0, 1, 2], [0, 2, 3], [4, 5, 6], [7, 8, 9]]);
    let normals = [Vec3::Z, Vec3::Z, Vec3::Z, Vec3::Z, Vec3::Y, Vec3::Z, Vec3::Z, Vec3::ZERO, Vec3::ZERO, Vec3::ZERO];
    assert_eq!(frame.normals, normals);
    // OBJ's (0, 0) is the lower left corner of the image, a frame's the upper left.
    let (lower, upper, none) = (Vec2::new(0.0, 1.0), Vec2::new(1.0, 0.75), Vec2::ZERO);
    let coords = [lower, lower, upper, lower, lower, lower, none, none, lower, none];
    assert_eq!(frame.mesh.tex_coords[0], coords);
    assert_eq!(frame.positions[6], Vec3::new(1.0, 1.0, 0.0));
}

#[test]
fn vertex_colors_are_srgb_and_missing_ones_white() {
    let text = "v 0 0 0\nv 1 0 0 1 0.5 0\nv 0 1 0\nv 9 9 9 1\nf 1 2 3\n";
    let colors = frame("a.obj", text.as_bytes()).mesh.colors.clone();
    assert_eq!(colors.len(), 3);
    assert_eq!((colors[0], colors[2]), (glam::Vec4::ONE, glam::Vec4::ONE));
    // IEC 61966-2-1: 0.5 encodes 0.214041.
    assert!(colors[1].abs_diff_eq(glam::Vec4::new(1.0, 0.214_041, 0.0, 1.0), 1e-6), "{}", colors[1]);
}

#[test]
fn lines_may_be_continued_and_end_in_crlf() {
    let text = format!("{}f 1 \\\r\n 2 \\\r\n 3 # and a comment\r\n", TRIANGLE.replace('\n', "\r\n"));
    assert_eq!(frame("a.obj", text.as_bytes()).mesh.triangles, [[0, 1, 2]]);
}

#[test]
fn what_is_left_out_is_counted() {
    let shape = format!("{TRIANGLE}f 1 2 3\n");
    let small = warning("a.obj", format!("{shape}f 1 2\nf\n").as_bytes());
    assert!(small.contains("2 faces with fewer than three corners"), "{small}");
    let unknown = warning("a.obj", format!("{shape}cstype bezier\ncurv 0 1\n").as_bytes());
    assert!(unknown.contains("2 unknown statements, the first being `cstype` on line 5"), "{unknown}");
    assert!(warning("a.obj", b"").contains("no faces"));
}

#[test]
fn nan_and_infinite_positions_are_kept_for_the_count_of_omitted_triangles() {
    let frame = frame("a.obj", format!("{TRIANGLE}v nan inf -inf\nf 1 2 3\nf 1 2 4\n").as_bytes());
    assert!(frame.positions[3].x.is_nan());
    assert_eq!(frame.triangles().omitted().not_finite.count, 1);
}

#[test]
fn faults_name_the_file_the_line_and_the_cause() {
    for (text, expected) in [
        ("v 0 0\n", "line 1: 2 numbers where 3 are needed"),
        ("v 0 zero 0\n", "line 1: `zero` is not a number"),
        ("\n\nvn 1 2\n", "line 3: 2 numbers where 3 are needed"),
        ("vt\n", "line 1: 0 numbers where 1 are needed"),
        ("v 0 0 0\nf 1 1 0\n", "line 2: vertex 0: indices count from 1"),
        ("v 0 0 0\nf 1 1 -2\n", "line 2: vertex -2 is not there: the file has 1 so far"),
        ("v 0 0 0\nf 1 1 2\n", "line 2: vertex 2 is not there: the file has 1"),
        ("v 0 0 0\nf 1 1 4294967295\n", "line 2: vertex 4294967295 is not there"),
        ("v 0 0 0\nf 1 1 4294967296\n", "line 2: vertex 4294967296 is not there"),
        ("v 0 0 0\nf 1 1 -9223372036854775808\n", "line 2: vertex -9223372036854775808 is not there"),
        ("v 0 0 0\nf 1 1 99999999999999999999\n", "line 2: `99999999999999999999` is not a number"),
        ("v 0 0 0\nf 1 1 1/x\n", "line 2: `x` is not a number"),
        ("v 0 0 0\nf 1//// 1 1\n", "line 2: `1////` has more than three indices"),
        ("v 0 0 0\nf one 1 1\n", "line 2: `one` is not a number"),
    ] {
        let error = open("broken.obj", text.as_bytes()).unwrap_err();
        assert!(error.contains("broken.obj: ") && error.contains(expected), "{text:?}: {error}");
    }
    assert!(solids::open_path("not/there.obj".as_ref()).unwrap_err().contains("there.obj"));
}

#[test]
fn objects_are_what_the_last_object_or_group_says() {
    let face = "f 1 2 3\n";
    let names = |text: &str| {
        let objects = frame("a.obj", text.as_bytes()).mesh.objects.clone();
        let name = |triangle| objects.of_triangle(triangle).map(|object| objects.names()[object as usize].to_string());
        (0..3).map(|triangle| name(triangle).unwrap_or_default()).collect::<Vec<_>>()
    };
    assert_eq!(names(&format!("{TRIANGLE}{face}{face}{face}")), ["", "", ""], "nothing has a name");
    assert_eq!(names(&format!("{TRIANGLE}{face}o left\n{face}o right one\n{face}")), ["default", "left", "right one"]);
    assert_eq!(names(&format!("g\n{TRIANGLE}{face}o a\ng b\n{face}g a\n{face}")), ["default", "b", "a"]);
    assert_eq!(names(&format!("o a\no b\n{TRIANGLE}{face}o a\n{face}o b\n{face}")), ["b", "a", "b"]);
}

#[test]
fn texture_coordinates_and_normals_that_are_not_there_are_left_out_alone() {
    for corners in ["1/1/1 2/2/2 3/3/3", "1/0/0 2/0/0 3/0/0", "1/-1/-1 2/-2/-2 3/-3/-3", "1//9 2/9 3/9/0"] {
        let (frame, warnings) = open("a.obj", format!("{TRIANGLE}f {corners}\n").as_bytes()).unwrap();
        assert_eq!(frame.mesh.triangles, [[0, 1, 2]]);
        assert!(frame.normals.is_empty() && frame.mesh.tex_coords[0].is_empty(), "{corners}");
        assert!(warnings[0].contains("texture coordinates and normals that faces name"), "{warnings:?}");
    }
    let text = format!("{TRIANGLE}vt 0.5 1\nvn 0 0 1\nf 1/1/1 2/2/1 3/1/2\n");
    let (frame, warnings) = open("a.obj", text.as_bytes()).unwrap();
    assert_eq!(frame.mesh.tex_coords[0], [Vec2::new(0.5, 0.0), Vec2::ZERO, Vec2::new(0.5, 0.0)]);
    assert_eq!(frame.normals, [Vec3::Z, Vec3::Z, Vec3::ZERO]);
    assert_eq!(warnings.len(), 1);
    assert!(warnings[0].starts_with("left out 2 texture coordinates"), "{warnings:?}");
}

#[test]
fn a_byte_order_mark_and_any_line_ends_are_fine() {
    let text = format!("{TRIANGLE}f 1 2 3\n");
    let expected = frame("a.obj", text.as_bytes());
    for end in ["\n", "\r\n", "\r"] {
        for mark in ["", "\u{feff}"] {
            let other = frame("a.obj", format!("{mark}{}", text.replace('\n', end)).as_bytes());
            assert_eq!((&other.positions, &other.mesh.triangles), (&expected.positions, &expected.mesh.triangles));
        }
    }
}

#[test]
fn files_that_are_no_text_are_named() {
    let utf16: Vec<u16> = format!("\u{feff}{TRIANGLE}f 1 2 3\n").encode_utf16().collect();
    for bytes in [
        utf16.iter().flat_map(|unit| unit.to_le_bytes()).collect::<Vec<u8>>(),
        utf16.iter().flat_map(|unit| unit.to_be_bytes()).collect(),
    ] {
        for bytes in [&bytes[..], &bytes[2..]] {
            for name in ["a.obj", "a.ply", "a.stl", "a.gltf"] {
                let error = open(name, bytes).unwrap_err();
                assert!(error.contains("UTF-16") && error.contains("UTF-8"), "{error}");
            }
        }
    }
    let error = open("a.obj", b"\x1f\x8b\x08\x00rest").unwrap_err();
    assert!(error.contains("gzip") && error.contains("gunzip"), "{error}");
}

#[test]
fn names_and_comments_may_end_in_a_backslash() {
    let text = format!("# C:\\models\\\n{TRIANGLE}usemtl red\\\nf 1 2 3\no a\\\nf 1 2 \\\n 3\n");
    let (frame, _) = open("a.obj", text.as_bytes()).unwrap();
    assert_eq!(frame.mesh.triangles, [[0, 1, 2]; 2]);
    assert_eq!(frame.materials.materials[0].name, "red\\");
}

#[test]
fn numbers_that_are_none_are_read_as_microsofts_libraries_write_them() {
    let text = format!("{TRIANGLE}vn -nan(ind) -1.#IND 1.#QNAN\nv 1.#INF 0 0\nf 1//1 2//1 3//1\nf 1 2 4\n");
    let frame = frame("a.obj", text.as_bytes());
    assert_eq!(frame.normals[0], Vec3::ZERO);
    assert_eq!(frame.triangles().omitted().not_finite.count, 1);
}

#[test]
fn objects_and_groups_are_hidden_by_their_names() {
    let room = format!("{TRIANGLE}o Floor\nf 1 2 3\ng Lamp.left\nf 3 2 1\no Floor\nf 1 3 2\n");
    let open = |hidden: &str| {
        let options = OpenOptions { hidden: vec![hidden.into()], ..OpenOptions::default() };
        umbrage_files::open_files("a.obj", [("a.obj", room.as_bytes())], &options).map_err(|error| error.to_string())
    };
    let scene = open("Fl*").unwrap();
    assert_eq!(scene.objects().iter().map(|name| &**name).collect::<Vec<_>>(), ["Floor", "Lamp.left"]);
    assert_eq!(scene.at(0.0).unwrap().mesh.triangles, [[2, 1, 0]]);
    let refused = open("roof*").unwrap_err();
    assert!(refused.starts_with("a.obj: there is no object `roof*`"), "{refused}");
}
