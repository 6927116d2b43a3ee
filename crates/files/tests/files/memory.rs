//! Files that exceed the memory budget.

use std::fs::File;
use std::path::Path;

use serde_json::json;
use umbrage_files::OpenOptions;
use umbrage_scene::{Error, Scene};

use crate::builder::Builder;
use crate::solids::{folder, png};

fn open_within(path: &Path, max_memory: u64) -> Result<Scene, Error> {
    umbrage_files::open_with(path, &OpenOptions { max_memory, ..OpenOptions::default() })
}

/// Asserts that a file opens with `enough` bytes, and that with `too_few` bytes the error names `what`.
#[track_caller]
fn assert_bounded(path: &Path, enough: u64, too_few: u64, what: &str) {
    open_within(path, enough).expect("a scene that fits");
    assert_refused(path, too_few, what);
}

#[track_caller]
fn assert_refused(path: &Path, too_few: u64, what: &str) {
    let error = open_within(path, too_few).expect_err("a scene that doesn't fit");
    let words = error.to_string();
    assert!(matches!(error, Error::Memory { .. }), "{words}");
    assert!(words.starts_with(&path.display().to_string()), "{words}");
    assert!(words.contains(what) && words.contains("would take") && words.contains("--max-memory"), "{words}");
}

#[track_caller]
fn assert_file_bounded(name: &str, bytes: &[u8], enough: u64, too_few: u64, what: &str) {
    let folder = folder(&[(name, bytes)]);
    assert_bounded(&folder.path().join(name), enough, too_few, what);
}

/// As [`assert_bounded`], with the buffer in a separate file, so that it isn't part of the JSON.
#[track_caller]
fn assert_gltf_bounded(mut file: Builder, enough: u64, too_few: u64, what: &str) {
    file.json["buffers"] = json!([{ "byteLength": file.bytes.len(), "uri": "a.bin" }]);
    let folder = folder(&[("a.gltf", file.json.to_string().as_bytes()), ("a.bin", &file.bytes)]);
    assert_bounded(&folder.path().join("a.gltf"), enough, too_few, what);
}

const KB: u64 = 1000;
const MB: u64 = 1000 * KB;

#[test]
fn files_that_are_too_long_are_not_read() {
    let folder = folder(&[]);
    for name in ["a.glb", "a.gltf", "a.obj", "a.ply", "a.stl", "a.pc2", "a.mdd"] {
        let path = folder.path().join(name);
        // A sparse file takes no room on the disk.
        File::create(&path).unwrap().set_len(1 << 40).unwrap();
        assert_refused(&path, 1 << 30, name);
    }
}

/// A triangle with an image.
fn textured(image: &[u8]) -> Builder {
    let mut file = Builder::new();
    let mesh = file.triangle();
    file.json["meshes"][mesh]["primitives"][0]["material"] = json!(0);
    file.push("nodes", json!({ "mesh": mesh }));
    let view = file.view(image);
    file.push("images", json!({ "bufferView": view }));
    file.push("textures", json!({ "source": 0 }));
    file.push("materials", json!({ "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } } }));
    file
}

#[cfg(feature = "avif")]
#[test]
fn images_that_are_decoded_elsewhere_take_what_that_takes() {
    let picture = crate::textures_avif::of_width(16_000);
    let folder = folder(&[("a.gltf", &textured(&picture).gltf())]);
    let path = folder.path().join("a.gltf");
    assert_refused(&path, MB, "an image of 16000x13 texels would take 1.6 MiB");
    assert_refused(&path, 3 * MB, "decoding an AVIF image of 16000x13 texels would take 2.4 MiB");
}

#[test]
fn images_take_their_texels() {
    let image = |width, height| png([width, height], png::ColorType::Grayscale, &vec![0; (width * height) as usize]);
    let png = image(2048, 2048);
    assert!(png.len() < 100_000);
    assert_gltf_bounded(textured(&png), 36 * MB, 33 * MB, "an image of 2048x2048 texels would take 32.0 MiB");
    // Each of two long images is small, but not their combination.
    let folder = folder(&[
        ("a.obj", b"mtllib a.mtl\nusemtl a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"),
        ("a.mtl", b"newmtl a\nmap_Kd wide.png\nmap_d high.png\n"),
        ("wide.png", &image(2000, 1)),
        ("high.png", &image(1, 2000)),
    ]);
    assert_bounded(&folder.path().join("a.obj"), 33 * MB, 30 * MB, "an image of 2000x2000 texels");
}

#[test]
fn polygons_take_their_triangles() {
    let corners = |count: usize| (0..count).map(|_| " 1 2 3").collect::<String>();
    let obj = format!("v 0 0 0\nv 1 0 0\nv 0 1 0\nf{}\n", corners(100_000));
    assert_file_bounded("a.obj", obj.as_bytes(), 28 * MB, 4 * MB, "triangles");
    assert_file_bounded("a.obj", obj.as_bytes(), 28 * MB, 9 * MB, "smooth normals, which --crease 0 leaves out,");
    let obj: String = (0..100_000).map(|number| format!("v {number} 0 0\nvt 0\nvn 0 0 1\n")).collect();
    assert_file_bounded("a.obj", obj.as_bytes(), 16 * MB, 5 * MB, "vertices");
    let header = |element: &str| {
        let vertex = "element vertex 3\nproperty char x\nproperty char y\nproperty char z\n";
        format!("ply\nformat binary_little_endian 1.0\n{vertex}{element}\nend_header\n").into_bytes()
    };
    let mut ply = header("element face 1\nproperty list uint uchar vertex_indices");
    ply.extend([0; 9]);
    ply.extend(1_000_000_u32.to_le_bytes());
    ply.extend((0..1_000_000).map(|corner| (corner % 3) as u8));
    assert_file_bounded("a.ply", &ply, 90 * MB, 15 * MB, "triangles");
    let mut ply = header("element tristrips 1\nproperty list uint uchar vertex_indices");
    ply.extend([0; 9]);
    ply.extend(1_000_000_u32.to_le_bytes());
    ply.extend((0..1_000_000).map(|corner| (corner % 3) as u8));
    assert_file_bounded("a.ply", &ply, 90 * MB, 10 * MB, "triangles");
    let mut stl = [&[0; 80][..], &100_000_u32.to_le_bytes()].concat();
    stl.resize(84 + 50 * 100_000, 0);
    assert_file_bounded("a.stl", &stl, 20 * MB, 6 * MB, "triangles");
}

#[test]
fn accessors_take_what_they_claim_each_time_they_are_read() {
    // Zeros without bytes.
    let mut file = Builder::new();
    let zeros = file.push("accessors", json!({ "componentType": 5126, "type": "VEC3", "count": 1 << 20 }));
    let indices = file.indices(&[0, 1, 2]);
    let target = json!({ "POSITION": zeros });
    let mesh = file.mesh(json!({ "POSITION": zeros }), json!({ "indices": indices, "targets": vec![target; 20] }));
    file.push("nodes", json!({ "mesh": mesh }));
    let zeros = file.json["accessors"][zeros].clone();
    let sparse = file.view(&[0; 4 << 10]);
    let values = file.view(&[0; 12 << 10]);
    let mut replaced = zeros;
    replaced["sparse"] = json!({
        "count": 1, "indices": { "bufferView": sparse, "componentType": 5125 }, "values": { "bufferView": values }
    });
    let replaced = file.push("accessors", replaced);
    // Read once for each animation.
    let channel = json!({ "sampler": 0, "target": { "node": 0, "path": "scale" } });
    let times = file.floats(&[[0.0]]);
    let one = file.floats(&[[1.0, 1.0, 1.0]]);
    let samplers = json!([{ "input": times, "output": one }]);
    file.push("animations", json!({ "channels": [channel], "samplers": samplers }));
    assert_gltf_bounded(file.clone(), MB, 18 * KB, "would take");
    // Every vertex is used.
    let mesh = &mut file.json["meshes"][mesh]["primitives"][0];
    mesh.as_object_mut().unwrap().remove("indices");
    mesh["attributes"]["POSITION"] = json!(replaced);
    mesh["targets"] = json!([]);
    assert_gltf_bounded(file, 200 * MB, 10 * MB, "accessors[");
}

#[test]
fn copies_take_what_they_hold() {
    let mut file = Builder::new();
    let translations = file.floats(&vec![[0.0; 3]; 10_000]);
    let mesh = file.triangle();
    let instances = json!({ "EXT_mesh_gpu_instancing": { "attributes": { "TRANSLATION": translations } } });
    file.json["nodes"] = json!(vec![json!({ "mesh": mesh, "extensions": instances }); 20]);
    assert_gltf_bounded(file, 150 * MB, 40 * MB, "would take");
}

#[test]
fn json_takes_more_than_its_words() {
    let mut file = Builder::new();
    let mesh = file.triangle();
    file.push("nodes", json!({ "mesh": mesh }));
    file.json["materials"] = json!(vec![json!({}); 20_000]);
    assert_gltf_bounded(file, 25 * MB, 10 * MB, "the JSON");
    let mut file = Builder::new();
    let mesh = file.triangle();
    file.push("nodes", json!({ "mesh": mesh }));
    file.bytes.resize(1_000_000, 0);
    let folder = folder(&[("a.gltf", &file.gltf())]);
    assert_bounded(&folder.path().join("a.gltf"), 20 * MB, 8 * MB, "a URI's bytes");
}

#[test]
fn each_file_of_a_sequence_has_its_own() {
    let triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    let large: String = (0..1000).map(|_| triangle).collect();
    let folder =
        folder(&[("a1.obj", triangle.as_bytes()), ("a2.obj", triangle.as_bytes()), ("a3.obj", large.as_bytes())]);
    let path = folder.path().join("a%d.obj");
    // The budget is shared by all files.
    assert!(open_within(&path, 10 * MB).is_ok());
    let words = open_within(&path, 50 * KB).expect_err("a large file").to_string();
    assert!(words.contains("a3.obj") && words.contains("--max-memory"), "{words}");
}

#[test]
fn points_lines_and_their_runs_are_counted() {
    let vertex = "v 0 0 0\n";
    let points = format!("{vertex}{}", "p 1\n".repeat(20_000));
    assert_file_bounded("a.obj", points.as_bytes(), 400 * KB, 120 * KB, "points");
    let lines = format!("{vertex}{vertex}{}", "l 1 2\n".repeat(20_000));
    assert_file_bounded("a.obj", lines.as_bytes(), 600 * KB, 220 * KB, "lines");
    // Another material for each point.
    let runs = format!("{vertex}{}", "usemtl a\np 1\nusemtl b\np 1\n".repeat(5_000));
    assert_file_bounded("a.obj", runs.as_bytes(), MB, 300 * KB, "points and lines");
    let edges = "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\n\
                 element edge 20000\nproperty int vertex1\nproperty int vertex2\nend_header\n0 0 0\n1 1 1\n";
    let edges = format!("{edges}{}", "0 1\n".repeat(20_000));
    assert_file_bounded("a.ply", edges.as_bytes(), 400 * KB, 200 * KB, "lines");
}
