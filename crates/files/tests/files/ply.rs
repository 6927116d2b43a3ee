//! Contents of PLY files, in each of their encodings.

use glam::{Vec2, Vec3, Vec4};

use crate::solids::{
    self, C_OUTLINE, CUBE_POSITIONS, CUBE_TRIANGLES, area, corners, cube_ply_binary, frame, open, warning,
};

/// A text file of one triangle with these properties and values of vertices.
fn text(properties: &str, rows: [&str; 3]) -> Vec<u8> {
    let properties: String = properties.split(", ").map(|property| format!("property {property}\n")).collect();
    let rows = rows.join("\n");
    format!(
        "ply\nformat ascii 1.0\nelement vertex 3\n{properties}element face 1\n\
         property list uchar int vertex_indices\nend_header\n{rows}\n3 0 1 2\n"
    )
    .into_bytes()
}

const XYZ: &str = "float x, float y, float z";
const ROWS: [&str; 3] = ["0 0 0", "1 0 0", "0 1 0"];

/// A header, then rows of little-endian or big-endian bytes.
fn binary(header: &str, big_endian: bool, body: &[u8]) -> Vec<u8> {
    let endian = if big_endian { "big" } else { "little" };
    let mut bytes = format!("ply\nformat binary_{endian}_endian 1.0\n{header}end_header\n").into_bytes();
    bytes.extend(body);
    bytes
}

#[test]
fn a_text_gives_positions_and_nothing_else() {
    let frame = frame("a.ply", &text(XYZ, ROWS));
    assert_eq!(frame.positions, [Vec3::ZERO, Vec3::X, Vec3::Y]);
    assert_eq!(frame.mesh.triangles, [[0, 1, 2]]);
    assert!(frame.normals.is_empty() && frame.mesh.colors.is_empty() && frame.mesh.tex_coords[0].is_empty());
}

#[test]
fn properties_come_in_any_order_among_others() {
    let properties = "double z, list uchar short neighbours, uchar red, float nz, float ny, float nx, int quality, \
                      float x, double y, uchar green, uchar blue, uchar alpha, float t, float s";
    let row = |position: &str| format!("3 2 -5 -6 255 0 2 0 77 {position} 128 0 51 0.25 0.5");
    let rows = [row("1 2"), row("4 5"), row("6 7")];
    let frame = frame("a.ply", &text(properties, [&rows[0], &rows[1], &rows[2]]));
    assert_eq!(frame.positions, [Vec3::new(1.0, 2.0, 3.0), Vec3::new(4.0, 5.0, 3.0), Vec3::new(6.0, 7.0, 3.0)]);
    assert_eq!(frame.normals, [Vec3::Y; 3]);
    // (s, t) count upwards, a frame's texture coordinates downwards.
    assert_eq!(frame.mesh.tex_coords[0], [Vec2::new(0.5, 0.75); 3]);
    // IEC 61966-2-1: 128/255 encodes 0.215861.
    assert!(frame.mesh.colors[0].abs_diff_eq(Vec4::new(1.0, 0.215_861, 0.0, 0.2), 1e-5), "{}", frame.mesh.colors[0]);
}

#[test]
fn floating_point_colors_are_linear_and_texture_coordinates_have_three_names() {
    for (u, v) in [("u", "v"), ("s", "t"), ("texture_u", "texture_v")] {
        let properties = format!("{XYZ}, float red, float green, float blue, float {u}, float {v}");
        let rows = ROWS.map(|row| format!("{row} 0.25 0.5 2 0.125 1"));
        let frame = frame("a.ply", &text(&properties, [&rows[0], &rows[1], &rows[2]]));
        assert_eq!(frame.mesh.colors, [Vec4::new(0.25, 0.5, 2.0, 1.0); 3]);
        assert_eq!(frame.mesh.tex_coords[0], [Vec2::new(0.125, 0.0); 3]);
    }
}

#[test]
fn both_byte_orders_give_the_same_cube() {
    let expected: Vec<_> =
        CUBE_TRIANGLES.iter().map(|triangle| triangle.map(|vertex| CUBE_POSITIONS[vertex])).collect();
    for big_endian in [false, true] {
        assert_eq!(corners(&frame("a.ply", &cube_ply_binary(big_endian))), expected);
    }
}

#[test]
fn indices_have_any_type_and_faces_may_come_first() {
    let vertices = "element vertex 3\nproperty short x\nproperty char y\nproperty ushort z\n";
    for (name, bytes) in [("char", 1), ("uint8", 1), ("int16", 2), ("ushort", 2), ("int", 4), ("uint32", 4)] {
        for big_endian in [false, true] {
            let header = format!("element face 1\nproperty list int {name} vertex_index\n{vertices}");
            let number = |value: u8, bytes: usize| {
                let mut number = vec![0; bytes];
                number[if big_endian { bytes - 1 } else { 0 }] = value;
                number
            };
            let mut body = number(3, 4);
            body.extend([2, 1, 0].into_iter().flat_map(|vertex| number(vertex, bytes)));
            for y in 0..3 {
                body.extend(if big_endian { (-7_i16).to_be_bytes() } else { (-7_i16).to_le_bytes() });
                body.push(y);
                body.extend(number(9, 2));
            }
            let frame = frame("a.ply", &binary(&header, big_endian, &body));
            assert_eq!(frame.mesh.triangles, [[2, 1, 0]], "{name}");
            assert_eq!(frame.positions[2], Vec3::new(-7.0, 2.0, 9.0), "{name}");
        }
    }
}

#[test]
fn polygons_become_fans_and_other_elements_are_read_past() {
    let header = "comment made by hand\nobj_info x\nelement camera 2\nproperty list uchar double pose\n\
                  property uchar id\nelement nothing 4000000000\nelement vertex 5\nproperty uchar x\n\
                  property uchar y\nproperty uchar z\nelement face 2\nproperty uchar flags\n\
                  property list uchar uchar vertex_indices\nproperty list ushort float weights\n";
    let mut body = vec![1];
    body.extend(5.0_f64.to_le_bytes());
    body.extend([7, 0, 7]);
    body.extend([0, 0, 0, 1, 0, 0, 2, 1, 0, 1, 2, 0, 0, 1, 0]);
    body.extend([9, 5, 0, 1, 2, 3, 4, 1, 0]);
    body.extend(1.5_f32.to_le_bytes());
    body.extend([9, 3, 4, 3, 2, 0, 0]);
    let frame = frame("a.ply", &binary(header, false, &body));
    assert_eq!(frame.mesh.triangles, [[0, 1, 2], [0, 2, 3], [0, 3, 4], [4, 3, 2]]);
}

#[test]
fn notches_of_polygons_stay_open_also_before_their_vertices() {
    let vertices = "element vertex 8\nproperty uchar x\nproperty uchar y\nproperty uchar z\n";
    let faces = "element face 1\nproperty list uchar uchar vertex_indices\n";
    let positions: Vec<u8> = C_OUTLINE.iter().flat_map(|&[x, y]| [5, y, x]).collect();
    let face = [8, 0, 1, 2, 3, 4, 5, 6, 7];
    for (header, body) in
        [([vertices, faces], [&positions[..], &face[..]]), ([faces, vertices], [&face[..], &positions[..]])]
    {
        let frame = frame("a.ply", &binary(&header.concat(), false, &body.concat()));
        assert_eq!((area(&frame), frame.mesh.triangles.len()), (10.0, 6));
    }
}

#[test]
fn strips_turn_every_second_triangle_and_end_at_minus_one() {
    let header = "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\nproperty float z\n\
                  element tristrips 1\nproperty list int int vertex_indices\nend_header\n";
    let vertices = "0 0 0\n1 0 0\n0 1 0\n1 1 0\n0 2 0\n";
    let strips = format!("{header}{vertices}10 0 1 2 3 -1 2 3 3 4 0\n");
    // The last strip repeats vertex 3 to turn.
    assert_eq!(frame("a.ply", strips.as_bytes()).mesh.triangles, [[0, 1, 2], [2, 1, 3], [3, 4, 0]]);
}

#[test]
fn windows_line_ends_and_blank_lines_are_fine() {
    let text = String::from_utf8(text(XYZ, ROWS)).unwrap().replace('\n', "\r\n") + "\r\n  \r\n";
    assert_eq!(frame("a.ply", text.as_bytes()).mesh.triangles, [[0, 1, 2]]);
}

#[test]
fn values_that_are_no_finite_numbers_are_kept_for_the_count_of_omitted_triangles() {
    let frame = frame("a.ply", &text(XYZ, ["nan 0 0", "1 inf 0", "0 1 -inf"]));
    assert!(frame.positions[0].x.is_nan() && frame.positions[1].y == f32::INFINITY);
    assert_eq!(frame.triangles().omitted().not_finite.count, 1);
}

#[test]
fn what_is_left_out_is_a_warning() {
    let mut more = text(XYZ, ROWS);
    more.extend(b"9 9 9\n");
    assert!(warning("a.ply", &more).contains("left out 6 bytes after the last element"));
    let nothing = b"ply\nformat ascii 1.0\nelement vertex 0\nproperty float x\nproperty float y\nproperty float z\n\
                   end_header\n";
    assert!(warning("a.ply", nothing).contains("neither faces nor points"));
    let header = "element vertex 3\nproperty uchar x\nproperty uchar y\nproperty uchar z\nelement face 3\n\
                  property list uchar uchar vertex_indices\nproperty list uchar float texcoord\n";
    let body = [0, 0, 0, 1, 0, 0, 0, 1, 0, 3, 0, 1, 2, 0, 2, 0, 1, 0, 0, 0];
    let (frame, warnings) = open("a.ply", &binary(header, false, &body)).unwrap();
    assert_eq!(frame.mesh.triangles.len(), 1);
    assert!(warnings[0].contains("2 faces with fewer than three corners"), "{warnings:?}");
    assert!(warnings[1].contains("`texcoord`") && warnings.len() == 2, "{warnings:?}");
}

#[test]
fn faults_name_the_file_the_element_and_the_cause() {
    let face = |row: &str| {
        let text = String::from_utf8(text(XYZ, ROWS)).unwrap();
        text.replace("3 0 1 2", row).into_bytes()
    };
    for (bytes, expected) in [
        (text(XYZ, ["0 0 0", "1 0", "0 1 0"]), "vertex 1: `z`: the line has too few values"),
        (text(XYZ, ["0 0 0", "1 0 x", "0 1 0"]), "vertex 1: `z`: `x` is not a number"),
        (text("float x, float z", ["0 0", "0 0", "0 0"]), "header: the element `vertex` has no number `y`"),
        (text("float x, float y, list uchar int z", ROWS), "header: the element `vertex` has no number `z`"),
        (text("float x, float y, uchar z", ["0 0 0", "0 0 256", "0 0 0"]), "vertex 1: `z`: `256` is not a whole"),
        (face("3 0 1 3"), "face 0: vertex 3 is not there: the file has 3"),
        (face("3 0 1 -1"), "face 0: vertex -1 is not there"),
        (face("3 0 1 1.5"), "face 0: `1.5` is not a whole number"),
        (face("4 0 1 2"), "face 0: a list of 4 values where at most 3 are left"),
        (face("200 0 1 2"), "face 0: a list of 200 values where at most 3 are left"),
        (face(""), "face 0: the file ends here"),
        (b"ply\nformat ascii 1.0\nelement face 0\nend_header\n".to_vec(), "header: no element `vertex`"),
    ] {
        let error = open("broken.ply", &bytes).unwrap_err();
        assert!(error.contains("broken.ply: ") && error.contains(expected), "{expected}: {error}");
    }
}

#[test]
fn broken_headers_name_their_line() {
    for (text, expected) in [
        ("", "line 1"),
        ("plyx\n", "line 1"),
        ("ply\nformat ascii 1.0\n", "line 2: the file ends before `end_header`"),
        ("ply\nformat utf7 1.0\n", "line 2: unknown format `utf7`"),
        ("ply\nelement vertex -3\n", "line 2: `-3` is not a number"),
        ("ply\nelement vertex\n", "line 2: an element without a count"),
        ("ply\nproperty float x\n", "line 2: a property before the first element"),
        ("ply\nelement vertex 1\nproperty half x\n", "line 3: unknown type `half`"),
        ("ply\nelement vertex 1\nproperty list uchar x\n", "line 3: unknown type `x`"),
        ("ply\nelement vertex 1\nproperty float\n", "line 3: a property without a name"),
        ("ply\nend_header\n", "header: no `format` line"),
        ("ply\nsur\u{1}prise\n", "line 2: `sur\u{fffd}prise` is no header line"),
    ] {
        let error = open("broken.ply", text.as_bytes()).unwrap_err();
        assert!(error.contains(expected), "{text:?}: {error}");
    }
}

#[test]
fn an_endless_header_is_given_up() {
    let comments = format!("ply\n{}", "comment\n".repeat(200_000));
    let error = open("a.ply", comments.as_bytes()).unwrap_err();
    assert!(error.contains("no `end_header` in the first 1048576 bytes"), "{error}");
    let one_line = format!("ply\ncomment {}", "x".repeat(2_000_000));
    let error = open("a.ply", one_line.as_bytes()).unwrap_err();
    assert!(error.contains("no `end_header`") && error.len() < 300, "{error}");
}

#[test]
fn indices_of_floating_point_type_have_to_be_whole() {
    let header = "element vertex 3\nproperty uchar x\nproperty uchar y\nproperty uchar z\nelement face 1\n\
                  property list uchar float vertex_indices\n";
    let with = |last: f32| {
        let mut body = vec![0, 0, 0, 1, 0, 0, 0, 1, 0, 3];
        body.extend(solids::floats(&[0.0, 1.0, last], false));
        open("a.ply", &binary(header, false, &body))
    };
    assert_eq!(with(2.0).unwrap().0.mesh.triangles, [[0, 1, 2]]);
    for last in [1.5, -1.0, 3.0, f32::NAN, f32::INFINITY, 1e30] {
        assert!(with(last).unwrap_err().contains("face 0: vertex"), "{last}");
    }
}

#[test]
fn faces_have_colours_where_vertices_have_none() {
    let colors = "property uchar red\nproperty uchar green\nproperty uchar blue\n";
    let header = |of_vertex: &str| {
        format!(
            "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\nproperty float z\n{of_vertex}\
             element face 2\nproperty list uchar int vertex_indices\n{colors}end_header\n"
        )
    };
    let faces = "4 0 1 2 3 255 0 0\n3 0 3 4 0 0 255\n";
    let text = header("") + "0 0 0\n1 0 0\n1 1 0\n0 1 0\n-1 1 0\n" + faces;
    let frame = frame("a.ply", text.as_bytes());
    let of_triangle = |triangle: usize| frame.mesh.triangles[triangle].map(|vertex| frame.mesh.colors[vertex as usize]);
    let (red, blue) = (Vec4::new(1.0, 0.0, 0.0, 1.0), Vec4::new(0.0, 0.0, 1.0, 1.0));
    assert_eq!([of_triangle(0), of_triangle(1), of_triangle(2)], [[red; 3], [red; 3], [blue; 3]]);
    assert_eq!(frame.positions.len(), 7, "two vertices are of both colours");
    assert_eq!(frame.materials.materials[0].base_color, Vec4::ONE);
    // The vertices' own colours are finer.
    let rows = "0 0 0 0 255 0\n1 0 0 0 255 0\n1 1 0 0 255 0\n0 1 0 0 255 0\n-1 1 0 0 255 0\n";
    let both = solids::frame("a.ply", (header(colors) + rows + faces).as_bytes());
    assert_eq!(both.mesh.colors, [Vec4::new(0.0, 1.0, 0.0, 1.0); 5]);
}

#[test]
fn a_byte_order_mark_and_old_line_ends_are_fine() {
    let text = format!("\u{feff}{}", String::from_utf8(text(XYZ, ROWS)).unwrap());
    for text in [text.clone(), text.replace('\n', "\r")] {
        assert_eq!(frame("a.ply", text.as_bytes()).mesh.triangles, [[0, 1, 2]]);
    }
    // The first value is a line feed.
    let header = "element vertex 3\nproperty uchar x\nproperty uchar y\nproperty uchar z\nelement face 1\n\
                  property list uchar uchar vertex_indices\n";
    let body = [10, 0, 0, 1, 0, 0, 0, 1, 0, 3, 0, 1, 2];
    let bytes = binary(header, false, &[]);
    for end in ["\n", "\r\n", "\r"] {
        let mut bytes = String::from_utf8(bytes.clone()).unwrap().replace('\n', end).into_bytes();
        bytes.extend(body);
        assert_eq!(frame("a.ply", &bytes).positions[0], Vec3::new(10.0, 0.0, 0.0));
    }
}
