//! Files that are cut off, altered, random or lie about their size give an error or a documented omission.

use std::time::{Duration, Instant};

use proptest::prelude::*;
use tempfile::TempDir;

use crate::solids::{
    self, corners, cube_obj, cube_ply_binary, cube_ply_text, cube_stl_binary, cube_stl_text, frame, open,
};

/// The cube in every format.
fn cubes() -> [(&'static str, Vec<u8>); 6] {
    [
        ("cube.obj", cube_obj()),
        ("text.ply", cube_ply_text()),
        ("little.ply", cube_ply_binary(false)),
        ("big.ply", cube_ply_binary(true)),
        ("text.stl", cube_stl_text()),
        ("binary.stl", cube_stl_binary()),
    ]
}

thread_local! {
    /// One folder for each test, because making one takes longer than reading a small file.
    static FOLDER: TempDir = TempDir::new().expect("a temporary folder");
}

/// Opens arbitrary bytes, checks the frame's invariants if they are accepted, and returns whether they are.
fn open_anything(name: &str, bytes: &[u8]) -> bool {
    let path = FOLDER.with(|folder| folder.path().join(name));
    // Some file systems wait for the disk when a file is overwritten, but not when it is created.
    let _not_there_at_first = std::fs::remove_file(&path);
    std::fs::write(&path, bytes).expect("room for a file");
    let result = solids::open_path(&path);
    let accepted = result.is_ok();
    match result {
        Ok((frame, _)) => {
            let (mesh, vertices) = (&frame.mesh, frame.positions.len());
            assert!(mesh.triangles.as_flattened().iter().all(|&vertex| (vertex as usize) < vertices));
            assert_eq!(mesh.material_of_triangle.len(), mesh.triangles.len());
            let materials = frame.materials.materials.len();
            assert!(mesh.material_of_triangle.iter().all(|&place| (place as usize) < materials));
            for length in [frame.normals.len(), mesh.tex_coords[0].len(), mesh.colors.len()] {
                assert!(length == 0 || length == vertices);
            }
            assert!(vertices <= bytes.len() && mesh.triangles.len() <= bytes.len());
        }
        Err(error) => {
            assert!(error.contains(name), "{error}");
            assert!(error.len() < 500, "an error for a person, not the file: {error}");
        }
    }
    accepted
}

#[test]
fn the_cube_is_the_same_in_every_format() {
    let expected = corners(&frame("cube.obj", &cube_obj()));
    assert_eq!(expected.len(), 12);
    for (name, bytes) in cubes() {
        let cube = frame(name, &bytes);
        assert_eq!(corners(&cube), expected, "{name}");
        assert_eq!(cube.positions.len(), 8, "{name}");
    }
}

#[test]
fn every_truncation_is_an_error_or_a_whole_number_of_lines() {
    for (name, bytes) in cubes() {
        for length in 0..bytes.len() {
            let cut = &bytes[..length];
            let accepted = open_anything(name, cut);
            let may_be_accepted = match name {
                // The rest of an OBJ is still a shape or part of one. So are complete facets of an STL, with a warning for
                // the missing `endsolid`.
                "cube.obj" | "text.stl" => true,
                // The last line break, or the end of the last number, may be missing.
                "text.ply" => length + 2 >= bytes.len(),
                _ => false,
            };
            assert!(!accepted || may_be_accepted, "{name} cut to {length} of {} bytes", bytes.len());
        }
    }
}

#[test]
fn a_text_stl_cut_within_a_facet_is_an_error() {
    let bytes = cube_stl_text();
    let text = std::str::from_utf8(&bytes).expect("room for a file");
    for (place, _) in text.match_indices("endloop") {
        let error = open("cut.stl", &bytes[..place]).unwrap_err();
        assert!(error.contains("inside a facet"), "{error}");
    }
    for (place, _) in text.match_indices("endfacet") {
        let end = place + "endfacet".len();
        let (_, warnings) = open("cut.stl", &bytes[..end]).unwrap();
        assert!(warnings[0].contains("cut off"), "{warnings:?}");
    }
}

/// Peak address space of this process in bytes, where the system reports it.
fn peak_bytes() -> Option<usize> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmPeak:"))?;
    line.trim().strip_suffix("kB")?.trim().parse::<usize>().ok().map(|kilobytes| kilobytes * 1024)
}

#[test]
fn counts_that_lie_fail_fast_and_take_no_memory() {
    const VERTICES: &str = "property float x\nproperty float y\nproperty float z\n";
    const FACES: &str = "property list uchar int vertex_indices\n";
    const LONG_FACES: &str = "property list uint uchar vertex_indices\n";
    let peak_before = peak_bytes();
    let start = Instant::now();
    for encoding in ["ascii", "binary_little_endian", "binary_big_endian"] {
        for count in ["4000000000", "4294967295", "4294967296", "18446744073709551615", "18446744073709551616"] {
            let zeros = [0; 64];
            let claim = |elements: String, body: &[u8]| {
                let mut bytes = format!("ply\nformat {encoding} 1.0\n{elements}end_header\n").into_bytes();
                bytes.extend(body);
                assert!(open("huge.ply", &bytes).is_err(), "{encoding} {count}");
            };
            claim(format!("element vertex {count}\n{VERTICES}"), &zeros);
            claim(format!("element vertex {count}\n"), &zeros);
            claim(format!("element vertex 1\n{VERTICES}element face {count}\n{FACES}"), &zeros);
            claim(format!("element vertex 1\n{VERTICES}element dog {count}\nproperty char age\n"), &zeros);
            claim(format!("element face {count}\n{FACES}element vertex {count}\n{VERTICES}"), &zeros);
            // One list longer than the file.
            let list: &[u8] = if encoding == "ascii" { b"4000000000 0 1 2" } else { &[0xfe; 20] };
            claim(format!("element face 1\n{LONG_FACES}element vertex 1\n{VERTICES}"), list);
        }
    }
    for count in [2_u32, 4_000_000_000, u32::MAX] {
        let mut bytes = vec![0; 80];
        bytes.extend(count.to_le_bytes());
        bytes.extend([0; 99]);
        assert!(open("huge.stl", &bytes).unwrap_err().contains("after 1 of the"));
    }
    assert!(start.elapsed() < Duration::from_secs(2), "{:?}", start.elapsed());
    if let (Some(before), Some(after)) = (peak_before, peak_bytes()) {
        // Other tests run meanwhile; 4 billion of anything here is at least 4 GB.
        assert!(after - before < 2 << 30, "{} MB", (after - before) >> 20);
    }
}

#[test]
fn one_position_with_very_many_normals_takes_no_longer_than_many_positions() {
    const NORMALS: usize = 20_000;
    let mut text = "v 0 0 0\nv 1 0 0\nv 0 1 0\n".to_owned();
    text.extend((0..NORMALS).map(|x| format!("vn {x} 1 0\n")));
    text.extend((1..=NORMALS).map(|normal| format!("f 1//{normal} 2//{normal} 3//{normal}\n")));
    let start = Instant::now();
    assert_eq!(frame("fan.obj", text.as_bytes()).positions.len(), 3 * NORMALS);
    assert!(start.elapsed() < Duration::from_secs(2), "{:?}", start.elapsed());
}

/// A cube with one to five bytes replaced.
fn altered() -> impl Strategy<Value = (&'static str, Vec<u8>)> {
    let changes = proptest::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..=5);
    (0..cubes().len(), changes).prop_map(|(format, changes)| {
        let (name, mut bytes) = cubes()[format].clone();
        for (place, value) in changes {
            let length = bytes.len();
            bytes[place.index(length)] = value;
        }
        (name, bytes)
    })
}

/// Keywords of the formats in random order, which get further than random bytes.
fn babble() -> impl Strategy<Value = Vec<u8>> {
    const WORDS: &[&str] = &[
        "v",
        "vt",
        "vn",
        "f",
        "usemtl",
        "mtllib",
        "1",
        "-1",
        "0",
        "1/1",
        "2//-1",
        "3/1/1",
        "1e999",
        "-0.5",
        "nan",
        "\\",
        "\n",
        "\n",
        "\n",
        "\r\n",
        "#",
        "solid",
        "facet",
        "vertex",
        "endfacet",
        "endsolid",
        "ply\n",
        "format ascii 1.0\n",
        "format binary_big_endian 1.0\n",
        "element vertex 3\n",
        "element face 2\n",
        "property float x\n",
        "property list uchar int vertex_index\n",
        "property double y\n",
        "property char z\n",
        "end_header\n",
        "9999999999",
    ];
    let words = proptest::collection::vec(prop::sample::select(WORDS), 0..60);
    words.prop_map(|words| words.join(" ").into_bytes())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn random_bytes_never_panic(bytes in proptest::collection::vec(any::<u8>(), 0..400)) {
        for name in ["a.obj", "a.ply", "a.stl"] {
            open_anything(name, &bytes);
        }
    }

    #[test]
    fn altered_files_never_panic((name, bytes) in altered()) {
        open_anything(name, &bytes);
    }

    #[test]
    fn words_in_any_order_never_panic(bytes in babble()) {
        for name in ["a.obj", "a.ply", "a.stl"] {
            open_anything(name, &bytes);
        }
        let header = [b"ply\nformat ascii 1.0\n".as_slice(), &bytes].concat();
        open_anything("a.ply", &header);
        open_anything("a.stl", &[b"solid\nfacet\n".as_slice(), &bytes].concat());
    }

    #[test]
    fn words_in_a_library_never_panic(
        words in proptest::collection::vec(prop::sample::select(&[
            "newmtl a\n", "Kd", "Ks", "Ns", "d", "Tr", "map_Kd", "map_d", "norm", "-s", "-o", "-bm", "-clamp", "on", "1",
            "-0.5", "nan", "1e40", "t.png", "\\", "/", "..", "\n", "\n", "\"", "map_Pr", "Pr", "map_Ke", "#",
        ][..]), 0..60)
    ) {
        let library = words.join(" ");
        let obj = b"mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\n";
        let folder = solids::folder(&[("a.obj", obj), ("a.mtl", library.as_bytes()), ("t.png", b"no image")]);
        if let Err(error) = solids::open_path(&folder.path().join("a.obj")) {
            prop_assert!(error.contains("a.mtl: line "), "{}", error);
        }
    }
}

#[test]
fn what_is_not_what_its_name_says_is_called_what_it_is() {
    let version_1 = br#"{"asset": {"version": "1.0"}, "meshes": {"box": {}}, "nodes": {}}"#;
    for (name, bytes, part) in [
        ("a.glb", &b"\x89PNG\r\n\x1a\n"[..], "this is a PNG image; a scene is a .gltf"),
        (
            "a.gltf",
            b"version https://git-lfs.github.com/spec/v1\noid sha256:0\n",
            "a pointer of Git LFS; `git lfs pull`",
        ),
        ("b.ply", b"version https://git-lfs.github.com/spec/v1\noid sha256:0\n", "a pointer of Git LFS"),
        ("c.stl", b"version https://git-lfs.github.com/spec/v1\noid sha256:0\n", "a pointer of Git LFS"),
        ("b.gltf", b"<!DOCTYPE html><title>Log in</title>", "a page of a web site"),
        ("d.ply", b"PK\x03\x04", "a ZIP archive; unpack it"),
        ("e.ply", b"glTF\x02\0\0\0", "binary glTF; call it .glb"),
        ("c.gltf", version_1, "glTF 1.0 is not supported"),
        ("d.gltf", b"\xEF\xBB\xBF{\"accessors\":{},\"asset\":{}}", "glTF 1.0 is not supported"),
        ("d.gltf", b"{", "JSON: "),
        ("f.ply", b"ply\nformat none\n", "line 2"),
    ] {
        let path = FOLDER.with(|folder| folder.path().join(name));
        std::fs::write(&path, bytes).expect("room for a file");
        let error = solids::open_path(&path).expect_err(name);
        assert!(error.contains(name) && error.contains(part), "{error}");
    }
}
