//! STL files, text and binary.

use glam::{Vec3, Vec4};
use umbrage_scene::{Frame, Material};

use crate::solids::{self, CUBE_POSITIONS, CUBE_TRIANGLES, corners, cube_stl_binary, frame, open, warning};

const FACET: &str = "facet normal nan -nan(ind) 0\n outer loop\n  vertex 0 0 0\n  vertex 1 0 0\n  vertex 0 1 0\n \
                     endloop\nendfacet\n";

/// A binary file with these corners.
fn binary(header: &[u8], triangles: &[[[f32; 3]; 3]]) -> Vec<u8> {
    let mut bytes = header.to_vec();
    bytes.resize(80, 0);
    bytes.extend((triangles.len() as u32).to_le_bytes());
    for triangle in triangles {
        bytes.extend(solids::floats(&[f32::NAN; 3], false));
        bytes.extend(solids::floats(triangle.as_flattened(), false));
        bytes.extend([0xff, 0xff]);
    }
    bytes
}

#[test]
fn a_text_is_flat_and_its_normals_are_not_read() {
    let text = format!("solid a vertex facet\n{FACET}endsolid\n");
    let frame = frame("a.stl", text.as_bytes());
    assert_eq!(frame.positions, [Vec3::ZERO, Vec3::X, Vec3::Y]);
    assert_eq!(frame.mesh.triangles, [[0, 1, 2]]);
    assert!(frame.normals.is_empty());
}

#[test]
fn texts_may_have_several_solids_in_any_case_and_crlf() {
    let text = format!("solid a\n{FACET}endsolid a\nsolid b\n{FACET}endsolid b\n").to_uppercase().replace('\n', "\r\n");
    let frame = frame("a.STL", text.as_bytes());
    assert_eq!(frame.mesh.triangles, [[0, 1, 2]; 2]);
}

#[test]
fn equal_corners_are_welded_and_no_others() {
    let cube = frame("a.stl", &cube_stl_binary());
    assert_eq!(cube.positions.len(), 8);
    let expected: Vec<_> =
        CUBE_TRIANGLES.iter().map(|triangle| triangle.map(|vertex| CUBE_POSITIONS[vertex])).collect();
    assert_eq!(corners(&cube), expected);

    let near = 1.0 + f32::EPSILON;
    let triangles = [[[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0; 3]], [[-0.0, 0.0, 1.0], [near, 0.0, 0.0], [0.0; 3]]];
    assert_eq!(frame("a.stl", &binary(b"", &triangles)).mesh.triangles, [[0, 1, 2], [0, 3, 2]]);

    let nan = f32::NAN;
    let triangles = [[[nan, 0.0, 0.0], [1.0; 3], [2.0; 3]], [[nan, 0.0, 0.0], [3.0; 3], [4.0; 3]]];
    let broken = frame("a.stl", &binary(b"", &triangles));
    assert_eq!(broken.mesh.triangles, [[0, 1, 2], [0, 3, 4]]);
    assert_eq!(broken.triangles().omitted().not_finite.count, 2);
}

#[test]
fn a_binary_file_may_begin_like_a_text() {
    let triangle = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let mut bytes = binary(b"solid facet normal 0 0 0", &[triangle; 3]);
    assert_eq!(frame("a.stl", &bytes).mesh.triangles, [[0, 1, 2]; 3]);
    // With bytes behind the triangles, the content decides the format.
    bytes[..80].fill(b' ');
    bytes[..10].copy_from_slice(b"solid cube");
    bytes.extend([1, 2, 3]);
    assert!(warning("a.stl", &bytes).contains("left out 3 bytes"));
}

#[test]
fn a_text_without_an_end_or_without_anything_is_a_warning() {
    let unfinished = warning("a.stl", format!("solid\n{FACET}").as_bytes());
    assert!(unfinished.contains("without `endsolid`"), "{unfinished}");
    assert!(warning("a.stl", b"solid\nendsolid\n").contains("no triangles"));
    assert!(warning("a.stl", &binary(b"", &[])).contains("no triangles"));
}

#[test]
fn faults_name_the_file_the_place_and_the_cause() {
    let triangle = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let short = &binary(b"", &[triangle; 3])[..84 + 120];
    let lines = |lines: &[&str]| lines.join("\n").into_bytes();
    for (bytes, expected) in [
        (short.to_vec(), "byte 204: the file ends here, after 2 of the 3 triangles"),
        (b"".to_vec(), "byte 0: the file ends here, before the count"),
        (lines(&["solid", "facet", "vertex 1 2 3", "vertex 1 2 x"]), "line 4: `x` is not a number"),
        (lines(&["solid", "facet", "vertex 1 2"]), "line 3: a vertex has 3 coordinates"),
        (lines(&["solid", "facet", "vertex 1 2 3", "endfacet"]), "line 4: a facet of 1 vertices instead of 3"),
        (lines(&["solid", "facet", "vertex 1 2 3"]), "line 3: the file ends inside a facet"),
        (lines(&["solid", "vertex 1 2 3"]), "line 2: `vertex` is out of place"),
        (lines(&["solid", "facet", "facet"]), "line 3: `facet` is out of place"),
        (lines(&["solid", "facet", "endsolid"]), "line 3: `endsolid` is out of place"),
        (lines(&["solid", "surprise"]), "line 2: `surprise` is out of place"),
    ] {
        let error = open("broken.stl", &bytes).unwrap_err();
        assert!(error.contains("broken.stl: ") && error.contains(expected), "{expected}: {error}");
    }
}

/// Two facets as text.
fn words(before: &str, behind: &str) -> String {
    format!("{before}\n{FACET}{FACET}{behind}\n")
}

#[test]
fn texts_are_read_word_by_word() {
    for text in
        [words("solid a", "endsolid a"), words("solid", "endsolid"), words("solid my part", "end solid my part")]
    {
        for end in ["\n", "\r\n", "\r", " "] {
            let text = text.replace('\n', end);
            assert_eq!(frame("a.stl", text.as_bytes()).mesh.triangles, [[0, 1, 2]; 2], "{text:?}");
        }
    }
    let several = words("solid a", "endsolid a") + &words("solid b", "endsolid a solid part");
    for end in ["\n", " "] {
        let text = several.replace('\n', end);
        assert_eq!(frame("a.stl", text.as_bytes()).mesh.triangles, [[0, 1, 2]; 4], "{text:?}");
    }
    let odd = words("solid", "endsolid").replace("nan -nan(ind) 0", "x 1.#IND 0").replace("endfacet", "end facet");
    assert_eq!(frame("a.stl", odd.as_bytes()).mesh.triangles, [[0, 1, 2]; 2]);
}

#[test]
fn comments_and_marks_may_come_before_a_text() {
    let long = "x".repeat(3000);
    for before in ["; a comment".to_owned(), "# a\n\n// b".to_owned(), format!("! {long}"), "\u{feff}".to_owned()] {
        let text = format!("{before}\nsolid a # name\n{FACET}; within\nendsolid a\n");
        assert_eq!(frame("a.stl", text.as_bytes()).mesh.triangles, [[0, 1, 2]], "{before:.20}");
    }
}

/// The frame of a binary file of adjacent triangles with these attribute bytes.
fn colored(header: &[u8], attributes: &[u16]) -> Frame {
    let triangle = |x: f32| [[x, 0.0, 0.0], [x + 1.0, 0.0, 0.0], [x, 1.0, 0.0]];
    let triangles: Vec<_> = (0..attributes.len()).map(|x| triangle(x as f32)).collect();
    let mut bytes = binary(header, &triangles);
    for (triangle, attribute) in bytes[84..].chunks_exact_mut(50).zip(attributes) {
        triangle[48..].copy_from_slice(&attribute.to_le_bytes());
    }
    frame("a.stl", &bytes)
}

/// The colour of a triangle with equal colours at its corners.
fn color(frame: &Frame, triangle: usize) -> Vec4 {
    let [a, b, c] = frame.mesh.triangles[triangle].map(|vertex| frame.mesh.colors[vertex as usize]);
    assert!(a == b && b == c);
    a
}

#[test]
fn triangles_have_the_colours_of_viscam_or_magics() {
    let (red, green, blue) =
        (Vec4::new(1.0, 0.0, 0.0, 1.0), Vec4::new(0.0, 1.0, 0.0, 1.0), Vec4::new(0.0, 0.0, 1.0, 1.0));
    let viscam = colored(b"", &[0x8000 | 31 << 10, 0x8000 | 31, 31 << 5]);
    assert_eq!([0, 1].map(|triangle| color(&viscam, triangle)), [red, blue]);
    assert_eq!(color(&viscam, 2), Material::clay().base_color);
    let magics = colored(b"made by hand COLOR=\x00\xff\x00\xff,MATERIAL=", &[31, 31 << 10, 0x8000]);
    assert_eq!([0, 1, 2].map(|triangle| color(&magics, triangle)), [red, blue, green]);
    assert!(colored(b"", &[0, 31, 7]).mesh.colors.is_empty(), "nothing says that these are colours");
    assert_eq!(magics.materials.materials[0].base_color, Vec4::ONE);
    // A shared vertex is split by colour.
    let viscam = colored(b"", &[0x8000, 0x8000, 0x801f]);
    assert_eq!(viscam.positions.len(), 4 + 3 + 1);
}
