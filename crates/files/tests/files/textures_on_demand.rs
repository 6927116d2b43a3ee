//! Textures on demand give the same values as textures in memory.

use std::path::Path;
use std::sync::Arc;
use std::thread;

use glam::{Vec2, Vec4};
use serde_json::json;
use umbrage_files::OpenOptions;
use umbrage_rays::{MaskPoints, Opacity as _};
use umbrage_scene::{Alpha, Error, Frame, Material, Materials, Texture, TextureUse};

use crate::builder::Builder;
use crate::solids::{folder, png};

/// A PNG of noise with opacity of 0 or 1 in half of its texels.
fn noise([width, height]: [u32; 2]) -> Vec<u8> {
    let texel = |x: u32, y: u32| {
        let noise = (x << 16 | y).wrapping_add(width).wrapping_mul(2_654_435_761);
        let [red, green, blue, alpha] = (noise ^ noise >> 13).to_be_bytes();
        [red, green, blue, if alpha % 4 < 2 { 255 * (alpha % 2) } else { alpha }]
    };
    let texels: Vec<_> = (0..height).flat_map(|y| (0..width).flat_map(move |x| texel(x, y))).collect();
    png([width, height], png::ColorType::Rgba, &texels)
}

/// A file with textures of these sizes, each with several filters and wrap modes.
fn textured(sizes: &[[u32; 2]]) -> Builder {
    let mut file = Builder::new();
    for &size in sizes {
        let view = file.view(&noise(size));
        let image = file.push("images", json!({ "bufferView": view, "mimeType": "image/png" }));
        for (filter, wraps) in [(9728, [10497, 33071]), (9729, [33648, 10497]), (9729, [33071, 33648])] {
            let sampler = file.push("samplers", json!({ "magFilter": filter, "wrapS": wraps[0], "wrapT": wraps[1] }));
            let texture = file.push("textures", json!({ "source": image, "sampler": sampler }));
            let used = json!({ "index": texture });
            // Each is read both as colours and as quantities.
            let pbr = json!({ "baseColorTexture": used, "metallicRoughnessTexture": used });
            file.push("materials", json!({ "pbrMetallicRoughness": pbr }));
        }
    }
    let mesh = file.triangle();
    file.push("nodes", json!({ "mesh": mesh }));
    file
}

fn open(path: &Path, texture_memory: Option<u64>) -> Frame {
    let options = OpenOptions { texture_memory, ..OpenOptions::default() };
    let scene = umbrage_files::open_with(path, &options).unwrap();
    assert_eq!(scene.warnings(), [""; 0]);
    scene.at(0.0).unwrap()
}

/// The textures of a file in memory, and on demand with the smallest pool.
fn both(file: &Builder) -> [Arc<Materials>; 2] {
    let folder = folder(&[("a.glb", &file.glb())]);
    let path = folder.path().join("a.glb");
    [None, Some(OpenOptions::MIN_TEXTURE_MEMORY)].map(|memory| open(&path, memory).materials)
}

const SIZES: [[u32; 2]; 6] = [[77, 130], [1, 1], [32, 32], [33, 31], [1, 200], [300, 260]];

#[test]
fn colours_and_opacities_are_the_same() {
    let [held, on_demand] = both(&textured(&SIZES));
    assert_eq!(held.textures.len(), 2 * 3 * SIZES.len());
    let read = |textures: &[Texture], step: u32| {
        let number = step.wrapping_mul(2_654_435_761);
        let texture = &textures[number as usize % textures.len()];
        let coords = Vec2::new((number >> 7) as f32, (number >> 3) as f32) / (1 << 23) as f32 - 1.5;
        let footprint = (step % 13) as f32 * 0.7;
        (texture.sample(coords, footprint).to_array().map(f32::to_bits), texture.opacity(coords).to_bits())
    };
    // Several threads compete for the same few slots.
    thread::scope(|scope| {
        for thread in 0..4 {
            let (held, on_demand) = (&held.textures, &on_demand.textures);
            scope.spawn(move || {
                for step in (0..20_000).map(|step| step + 7_000 * thread) {
                    assert_eq!(read(on_demand, step), read(held, step), "step {step}");
                }
            });
        }
    });
    let traffic = on_demand.texture_traffic().expect("textures on demand");
    assert!(traffic.loaded > 10_000 && traffic.found > 10_000, "{traffic:?}");
    assert!(traffic.resident_bytes <= OpenOptions::MIN_TEXTURE_MEMORY, "{traffic:?}");
    assert!(traffic.file_bytes > 20 * OpenOptions::MIN_TEXTURE_MEMORY, "{traffic:?}");
    assert!(on_demand.check_textures().is_ok());
    assert_eq!(held.texture_traffic(), None);
}

#[test]
fn levels_are_the_same() {
    let [held, on_demand] = both(&textured(&SIZES));
    for (held, on_demand) in held.textures.iter().zip(&on_demand.textures) {
        assert_eq!((held.size(), held.levels().len()), (on_demand.size(), on_demand.levels().len()));
        assert!(held.levels().eq(on_demand.levels()), "{:?}", held.size());
        assert!(on_demand.bytes() < held.bytes() / 4 || held.bytes() < 100, "{:?}", held.size());
    }
}

#[test]
fn masks_are_the_same() {
    let of = |materials: &Materials, texture: u32| {
        let material = Material {
            base_color: Vec4::ONE,
            base_color_texture: Some(TextureUse::new(texture)),
            alpha: Alpha::Mask { cutoff: 0.4 },
            ..Material::default()
        };
        let mut frame = Frame::from_triangles(vec![glam::Vec3::ZERO; 3], vec![[0, 1, 2]]);
        let materials = Materials { materials: vec![material], textures: materials.textures.clone() };
        frame.materials = Arc::new(materials);
        Arc::make_mut(&mut frame.mesh).tex_coords[0] = vec![Vec2::ZERO, Vec2::new(1.7, 0.1), Vec2::new(0.2, 1.4)];
        frame
    };
    let [held, on_demand] = both(&textured(&[[77, 130], [33, 31]]));
    let mut answers = [0; 3];
    for texture in 0..held.textures.len() as u32 {
        let frames = [of(&held, texture), of(&on_demand, texture)];
        for step in 0..200 {
            let (v, error) = (0.0025 * step as f32, [1e-6, 1e-4, 1e-2][step % 3]);
            let points = MaskPoints {
                barycentric: [[v; 16], std::array::from_fn(|lane| lane as f32 / 40.0)],
                error: [error; 16],
                lanes: u16::MAX,
            };
            let [of_held, of_demanded] = frames.each_ref().map(|frame| {
                let at = frame.camera_opacity().which_stop(0, &points);
                (at.opaque, at.cut, frame.camera_opacity().stops(0, [v, 0.3]))
            });
            assert_eq!(of_held, of_demanded, "texture {texture}, step {step}");
            let (opaque, cut, _) = of_held;
            let counts = [opaque, cut, !(opaque | cut)].map(u16::count_ones);
            answers = [0, 1, 2].map(|index| answers[index] + counts[index]);
        }
    }
    assert!(answers.into_iter().all(|count| count > 100), "each answer is given: {answers:?}");
}

#[test]
fn a_pool_that_is_too_small_is_refused() {
    let folder = folder(&[("a.glb", &textured(&[[2, 2]]).glb())]);
    let options = OpenOptions { texture_memory: Some(OpenOptions::MIN_TEXTURE_MEMORY - 1), ..OpenOptions::default() };
    let error = umbrage_files::open_with(folder.path().join("a.glb"), &options).unwrap_err();
    assert!(matches!(error, Error::Address { .. }), "{error}");
    assert!(error.to_string().contains("textures in 64.0 KiB of memory: give 64.0 KiB or more"), "{error}");
}

#[test]
fn images_take_memory_one_at_a_time() {
    const MB: u64 = 1_000_000;
    // Making each takes 4.2 MB.
    let images: Vec<_> = (0..6).map(|number| (format!("{number}.png"), noise([724, 724]))).collect();
    let mut file = Builder::new();
    for (name, _) in &images {
        let image = file.push("images", json!({ "uri": name }));
        let texture = file.push("textures", json!({ "source": image }));
        file.push("materials", json!({ "pbrMetallicRoughness": { "baseColorTexture": { "index": texture } } }));
    }
    let mesh = file.triangle();
    file.push("nodes", json!({ "mesh": mesh }));
    let glb = file.glb();
    let library: String = images.iter().map(|(name, _)| format!("newmtl m{name}\nmap_Kd {name}\n")).collect();
    let faces: String = images.iter().map(|(name, _)| format!("usemtl m{name}\nf 1 2 3\n")).collect();
    let obj = format!("mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\n{faces}");
    let files = [("a.glb", &glb[..]), ("a.obj", obj.as_bytes()), ("a.mtl", library.as_bytes())];
    let folder = folder(&files);
    for (name, bytes) in &images {
        std::fs::write(folder.path().join(name), bytes).unwrap();
    }
    for name in ["a.glb", "a.obj"] {
        let open = |max_memory: u64, texture_memory: Option<u64>| {
            let options = OpenOptions { max_memory, texture_memory, ..OpenOptions::default() };
            umbrage_files::open_with(folder.path().join(name), &options).map_err(|error| error.to_string())
        };
        let scene = open(8 * MB, Some(1 << 20)).unwrap();
        let textures = &scene.at(0.0).unwrap().materials.textures;
        assert_eq!((textures.len(), textures[5].size()), (6, [724, 724]), "{name}");
        assert!(open(8 * MB, None).unwrap_err().contains("(--max-memory)"), "{name}");
        assert!(open(4 * MB, Some(1 << 20)).unwrap_err().contains("(--max-memory)"), "{name}");
    }
}
