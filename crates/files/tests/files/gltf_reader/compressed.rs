//! Compressed files (made by `tools/test-files`) against the same scene uncompressed, and errors of broken ones.

use std::path::PathBuf;

use glam::{Vec2, Vec3, Vec4};
use serde_json::{Value, json};
use umbrage_scene::{ColorSpace, Frame, Scene};

use crate::builder::{Builder, open_bytes};

/// The bytes of a file of the corpus.
fn file(name: &str) -> Vec<u8> {
    std::fs::read(path(name)).unwrap()
}

fn path(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../verify/corpus/glb").join(format!("{name}.glb"))
}

pub(super) fn scene(name: &str) -> Scene {
    umbrage_files::open(path(name)).unwrap()
}

/// Tolerances by the file's quantization.
#[derive(Clone, Copy)]
struct Allowed {
    position: f32,
    normal: f32,
    coords: f32,
    color: f32,
}

#[derive(Clone, Copy, Debug)]
struct Corner {
    position: Vec3,
    normal: Vec3,
    coords: Vec2,
    color: Vec4,
}

impl Corner {
    fn is_near(&self, other: &Self, allowed: Allowed) -> bool {
        self.position.distance(other.position) <= allowed.position
            && self.normal.distance(other.normal) <= allowed.normal
            && self.coords.distance(other.coords) <= allowed.coords
            && self.color.distance(other.color) <= allowed.color
    }
}

fn triangles(frame: &Frame) -> Vec<[Corner; 3]> {
    let corner = |vertex: u32| {
        let vertex = vertex as usize;
        Corner {
            position: frame.positions[vertex],
            normal: frame.normals.get(vertex).copied().unwrap_or(Vec3::ZERO),
            coords: frame.mesh.tex_coords[0].get(vertex).copied().unwrap_or(Vec2::ZERO),
            color: frame.mesh.colors.get(vertex).copied().unwrap_or(Vec4::ONE),
        }
    };
    frame.mesh.triangles.iter().map(|corners| corners.map(corner)).collect()
}

/// Whether both have the same triangles, in any order and with any first corner.
fn are_alike(expected: &[[Corner; 3]], found: &[[Corner; 3]], allowed: Allowed) -> bool {
    let mut left = found.to_vec();
    expected.len() == found.len()
        && expected.iter().all(|expected| {
            let is_it = |found: &[Corner; 3]| {
                (0..3).any(|first| (0..3).all(|at| expected[at].is_near(&found[(first + at) % 3], allowed)))
            };
            left.iter().position(is_it).map(|at| left.swap_remove(at)).is_some()
        })
}

/// Maximum error in x, y or z of the vase's positions, by their number of bits; the longest side is 1.2.
fn step(bits: i32) -> f32 {
    1.2 * 0.5_f32.powi(bits)
}

const DRACO: Allowed = Allowed { position: 1e-4, normal: 4e-3, coords: 3e-4, color: 1e-6 };

#[test]
fn compressed_files_have_the_triangles_of_the_plain_one() {
    let meshopt = Allowed { position: 2.0 * step(14), normal: 0.03, coords: 5e-4, color: 1e-6 };
    for (name, allowed) in [
        ("draco-edgebreaker", DRACO),
        ("draco-sequential", DRACO),
        ("meshopt-medium", meshopt),
        ("meshopt-high", meshopt),
    ] {
        let (plain, compressed) = (scene("plain"), scene(name));
        assert_eq!(compressed.warnings(), plain.warnings(), "{name}");
        assert_eq!(compressed.duration_seconds(), 1.0, "{name}");
        for seconds in [0.0, 0.4, 1.0] {
            let (plain, compressed) = (plain.at(seconds).unwrap(), compressed.at(seconds).unwrap());
            assert_eq!(plain.mesh.triangles.len(), 160, "the scene that was made");
            // Rotations of meshopt have 16 bits.
            let allowed = Allowed { position: allowed.position + 1e-4, ..allowed };
            assert!(are_alike(&triangles(&plain), &triangles(&compressed), allowed), "{name} at {seconds} s");
        }
    }
}

#[test]
fn the_comparison_sees_differences() {
    let plain = triangles(&scene("plain").at(0.0).unwrap());
    let changed = |change: fn(&mut Vec<[Corner; 3]>)| {
        let mut triangles = plain.clone();
        change(&mut triangles);
        are_alike(&plain, &triangles, DRACO)
    };
    assert!(changed(|triangles| triangles.reverse()) && changed(|triangles| triangles[3].rotate_left(1)));
    assert!(!changed(|triangles| triangles[3].swap(0, 1)));
    assert!(!changed(|triangles| triangles[9][2].position.y += 2e-4));
    assert!(!changed(|triangles| triangles[9][2].normal.y += 5e-3));
    assert!(!changed(|triangles| triangles[9][2].coords.y += 4e-4));
    assert!(!changed(|triangles| triangles[9][2].color.y += 0.004));
    assert!(!changed(|triangles| triangles.truncate(159)));
}

/// Every mode and filter: the vase twice, with 8 and 16 bits for normals and 8 and 12 for colours.
#[test]
fn every_mode_and_filter_of_meshopt_gives_what_was_put_in() {
    let all = scene("plain").at(0.0).unwrap();
    let vase: Vec<_> = triangles(&all).into_iter().take(144).collect();
    for (name, color) in [("meshopt-modes", 1e-4), ("meshopt-modes-khr", 0.012)] {
        let file = scene(name);
        let compressed = triangles(&file.at(0.0).unwrap());
        assert_eq!(compressed.len(), 288, "{name}");
        let (first, second) = compressed.split_at(144);
        let moved: Vec<_> = vase.iter().map(|corners| corners.map(|corner| moved(corner, 1.8))).collect();
        let coarse = Allowed { position: step(14), normal: 0.02, coords: 0.0, color: color + 1e-6 };
        assert!(are_alike(&vase, first, coarse), "{name}, of triangles");
        let fine = Allowed { normal: 1e-3, color: color / 8.0 + 1e-6, ..coarse };
        assert!(are_alike(&moved, second, fine), "{name}, of indices in sequence");
        // By two radians a second around y: the largest component is w at first, then y. Rotations have 12 bits.
        for (seconds, radians) in [(0.5, 1.0), (1.0, 2.0)] {
            let turned = triangles(&file.at(seconds).unwrap());
            let turn = glam::Quat::from_rotation_y(radians);
            let axis = Vec3::new(-0.9, 0.0, 0.0);
            let expected = |corner: Corner| turn * (corner.position - axis) + axis;
            let is_turned = |(before, after): (&[Corner; 3], &[Corner; 3])| {
                (0..3).all(|at| expected(before[at]).distance(after[at].position) < 1e-3)
            };
            assert!(first.iter().zip(&turned[..144]).all(is_turned), "{name}, turned by {radians}");
        }
    }
}

fn moved(corner: Corner, x: f32) -> Corner {
    Corner { position: corner.position + Vec3::new(x, 0.0, 0.0), ..corner }
}

#[test]
fn pictures_in_other_formats_have_the_texels_of_the_png() {
    let texels = |name: &str| {
        let frame = scene(name).at(0.0).unwrap();
        let [texture] = frame.materials.textures.as_slice() else { panic!("{name}: one texture") };
        assert_eq!((texture.size(), texture.space()), ([16, 16], ColorSpace::Srgb), "{name}");
        texture.levels().next().unwrap().into_owned()
    };
    let plain = texels("plain");
    assert_eq!(
        [plain[0], plain[15], plain[240], plain[255]],
        [[230, 60, 40, 255], [250, 220, 60, 255], [40, 160, 90, 255], [60, 90, 200, 128]]
    );
    for (name, most) in [("webp", 0), ("avif", 0), ("basisu-uastc", 4), ("basisu-zstd", 4), ("basisu-etc1s", 12)] {
        if name == "avif" && cfg!(not(feature = "avif")) {
            continue;
        }
        let far = |(a, b): (&[u8; 4], &[u8; 4])| a.iter().zip(b).any(|(a, b)| a.abs_diff(*b) > most);
        assert!(!plain.iter().zip(&texels(name)).any(far), "{name}");
    }
}

/// A file with changed JSON and the same bytes.
fn changed(name: &str, change: impl Fn(&mut Value)) -> Vec<u8> {
    let glb = file(name);
    let length = u32::from_le_bytes(*glb[12..].first_chunk().unwrap()) as usize;
    let mut json = serde_json::from_slice(&glb[20..20 + length]).unwrap();
    change(&mut json);
    Builder { json, bytes: glb[28 + length..].to_vec() }.glb_with_buffers()
}

fn error(name: &str, change: impl Fn(&mut Value)) -> String {
    open_bytes("broken.glb", &changed(name, change), Default::default()).expect_err(name).to_string()
}

/// Changes the count of the first primitive's index accessor.
fn set_index_count(json: &mut Value, change: impl Fn(u64) -> u64) {
    let index = json["meshes"][0]["primitives"][0]["indices"].as_u64().unwrap();
    let count = &mut json["accessors"][index as usize]["count"];
    *count = json!(change(count.as_u64().unwrap()));
}

#[test]
fn numbers_of_a_draco_stream_count_before_those_of_its_accessors() {
    for name in ["draco-edgebreaker", "draco-sequential"] {
        let expected = scene(name).at(0.0).unwrap();
        let all_points = |json: &mut Value, change: fn(u64) -> u64| {
            let attributes = json["meshes"][0]["primitives"][0]["attributes"].as_object().unwrap().clone();
            for index in attributes.values().filter_map(Value::as_u64) {
                let count = &mut json["accessors"][index as usize]["count"];
                *count = json!(change(count.as_u64().unwrap()));
            }
        };
        let changes: [&dyn Fn(&mut Value); 4] = [
            &|json| set_index_count(json, |count| count / 9),
            &|json| set_index_count(json, |count| 2 * count),
            &|json| all_points(json, |count| count / 8),
            &|json| all_points(json, |count| count + 1),
        ];
        for change in changes {
            let scene = open_bytes("a.glb", &changed(name, change), Default::default()).unwrap();
            let frame = scene.at(0.0).unwrap();
            assert_eq!((&frame.positions, &frame.mesh.triangles), (&expected.positions, &expected.mesh.triangles));
            let warning = "other than its accessors say; it counts";
            assert!(scene.warnings().iter().any(|found| found.ends_with(warning)), "{:?}", scene.warnings());
        }
    }
}

#[test]
fn broken_draco_is_an_error_that_says_where() {
    const EXTENSION: &str = "/meshes/0/primitives/0/extensions/KHR_draco_mesh_compression";
    let of_first = "meshes[0].primitives[0].extensions.KHR_draco_mesh_compression";
    let name = "draco-edgebreaker";
    let attributes = format!("{EXTENSION}/attributes");
    let cut = error(name, |json| {
        let view = json.pointer(&format!("{EXTENSION}/bufferView")).unwrap().as_u64().unwrap();
        json["bufferViews"][view as usize]["byteLength"] = json!(100);
    });
    assert!(cut.contains(&format!("{of_first}: a broken Draco stream")), "{cut}");
    let text = error(name, |json| *json.pointer_mut(EXTENSION).unwrap() = json!({ "bufferView": "none" }));
    assert!(text.contains(of_first), "{text}");
    let missing = error(name, |json| json.pointer_mut(EXTENSION).unwrap()["bufferView"] = json!(99));
    assert!(missing.contains(&format!("{of_first}.bufferView: index 99 is out of range")), "{missing}");
    let other = error(name, |json| json.pointer_mut(&attributes).unwrap()["NORMAL"] = json!(77));
    assert!(other.contains(&format!("{of_first}.attributes.NORMAL: the stream has no attribute 77")), "{other}");
    for count in [3, 1_000_000_000_u64] {
        let wrong = error(name, |json| set_index_count(json, |_| count));
        assert!(wrong.contains("the stream has more in it") || wrong.contains("would take"), "{wrong}");
    }
    let kind = error(name, |json| {
        let index = json["meshes"][0]["primitives"][0]["attributes"]["POSITION"].as_u64().unwrap();
        json["accessors"][index as usize]["type"] = json!("VEC2");
    });
    assert!(kind.contains("attributes.POSITION: the stream has 3 components where 2 are needed"), "{kind}");
}

#[test]
fn broken_meshopt_is_an_error_that_says_where() {
    for (name, extension) in
        [("meshopt-modes", "EXT_meshopt_compression"), ("meshopt-modes-khr", "KHR_meshopt_compression")]
    {
        let change = |view: usize, member: &str, value: Value| {
            let location = format!("bufferViews[{view}].extensions.{extension}");
            let text = error(name, |json| json["bufferViews"][view]["extensions"][extension][member] = value.clone());
            assert!(text.contains(&location), "{name}: {member} {value}: {text}");
            text
        };
        let views = 0..9;
        for view in views {
            change(view, "byteLength", json!(9));
            change(view, "byteLength", json!(1_u64 << 40));
            change(view, "byteOffset", json!(1));
            change(view, "count", json!(600));
            change(view, "count", json!(1_u64 << 61));
            change(view, "mode", json!("POINTS"));
            change(view, "byteStride", json!(3));
            change(view, "filter", json!("SEPIA"));
            change(view, "buffer", json!(7));
        }
        assert!(change(0, "count", json!(431)).contains("triangles have three indices each"));
        assert!(change(2, "count", json!(80)).contains("bytes"));
        assert!(change(2, "count", json!(1_u64 << 38)).contains("would take"));
    }
}

/// Arbitrary bytes cause no panic, and errors name the file.
#[test]
fn garbage_in_compressed_bytes_is_an_error_or_another_scene() {
    for name in [
        "draco-edgebreaker",
        "draco-sequential",
        "meshopt-modes",
        "meshopt-modes-khr",
        "basisu-etc1s",
        "basisu-zstd",
        "webp",
        "avif",
    ] {
        let glb = file(name);
        let binary = 28 + u32::from_le_bytes(*glb[12..].first_chunk().unwrap()) as usize;
        for at in (binary..glb.len()).step_by(37) {
            let mut mutant = glb.clone();
            mutant[at] ^= 0xa5;
            if let Err(error) = open_bytes("mutant.glb", &mutant, Default::default()) {
                assert!(error.to_string().contains("mutant.glb: "), "{error}");
            }
        }
        for length in (0..glb.len()).step_by(101) {
            let error = open_bytes("cut.glb", &glb[..length], Default::default()).expect_err(name).to_string();
            assert!(error.contains("cut.glb: "), "{error}");
        }
    }
}

#[test]
fn broken_pictures_are_left_out_with_a_warning_that_says_where() {
    let warning = |name: &str, change: fn(&mut [u8])| {
        let mut glb = file(name);
        // AVIF begins with a box of 28 bytes; tests change the next one.
        let avif = glb.windows(8).position(|bytes| bytes == b"ftypavif").map(|name| name + 24);
        let first = avif.or_else(|| glb.windows(8).position(|bytes| bytes == b"\xABKTX 20\xBB")).unwrap();
        change(&mut glb[first..]);
        let scene = open_bytes("picture.glb", &glb, Default::default()).unwrap();
        assert!(scene.at(0.0).unwrap().materials.textures.is_empty(), "{name}");
        scene.warnings().join("; ")
    };
    for (cause, change) in [
        ("it says that it has 99 levels", (|bytes| bytes[40] = 99) as fn(&mut [u8])),
        ("it is not one picture", |bytes| bytes[36] = 6),
        ("it is not one picture", |bytes| bytes[20] = 0),
        ("16777232x16 texels, where 16384x16384 are the most", |bytes| bytes[23] = 1),
        ("the data format descriptor", |bytes| bytes[51] = 1),
        ("the supercompression global data", |bytes| bytes[70] = 1),
        ("the first level", |bytes| bytes[87] = 0xff),
        ("another number of bytes than 32x16 texels take", |bytes| bytes[20] = 32),
        ("Vulkan's format 37", |bytes| bytes[12] = 37),
    ] {
        let text = warning("basisu-uastc", change);
        assert!(
            text.contains("a texture was left out: images[0]: not a usable image: KTX2: ") && text.contains(cause),
            "{text}"
        );
    }
    let zstd = warning("basisu-zstd", |bytes| {
        let level = u32::from_le_bytes(*bytes[80..].first_chunk().unwrap()) as usize;
        bytes[level + 2] ^= 0xff;
    });
    assert!(zstd.contains("images[0]: not a usable image: KTX2: its compressed texels are broken"), "{zstd}");
    if cfg!(feature = "avif") {
        let avif = warning("avif", |bytes| bytes[4..8].copy_from_slice(b"meat"));
        assert!(avif.contains("images[0]: not a usable image: AVIF: it has no box `meta`"), "{avif}");
    }
}

#[cfg(not(feature = "avif"))]
#[test]
fn avif_without_its_feature_is_named() {
    use umbrage_files::AVIF_LEFT_OUT;

    let required = error("avif", |_| ());
    assert!(required.contains("broken.glb: the glTF extension `EXT_texture_avif`"), "{required}");
    assert!(required.ends_with(AVIF_LEFT_OUT), "{required}");
    let warnings = |change: fn(&mut Value)| {
        let glb = changed("avif", |json| {
            json["extensionsRequired"] = json!([]);
            change(json);
        });
        let scene = open_bytes("picture.glb", &glb, Default::default()).unwrap();
        (scene.at(0.0).unwrap().materials.textures.len(), scene.warnings().to_vec())
    };
    let extension = format!("the glTF extension `EXT_texture_avif` is not supported and was left out: {AVIF_LEFT_OUT}");
    let texture = format!("a texture was left out: images[0]: {AVIF_LEFT_OUT}");
    assert_eq!(warnings(|_| ()), (0, vec![extension.clone(), texture]));
    // A plain picture beside it, meant for readers without the extension, is used.
    let beside = warnings(|json| {
        let png = "data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mP8z8BQDwAEhQGAhKmMIQAAAABJRU5ErkJggg==";
        json["images"].as_array_mut().unwrap().push(json!({ "uri": png }));
        json["textures"][0]["source"] = json!(1);
    });
    assert_eq!(beside, (1, vec![extension]));
}
