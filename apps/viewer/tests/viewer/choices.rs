//! Choices that depend on files: animations, material variants, backgrounds.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use eframe::egui::{DroppedFile, Key};

use crate::window::Window;

/// A triangle that is red or, in the variant `leaf`, green; its two animations move it to the right, or up.
fn file_with_choices(folder: &Path) -> PathBuf {
    let corners = [0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    let times = [0.0, 1.0];
    let [right, up] = [[0.0, 0.0, 0.0, 0.5, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0, 0.5, 0.0]];
    let floats = corners.iter().chain(&times).chain(&right).chain(&up);
    let bytes: Vec<u8> = floats.flat_map(|float| float.to_le_bytes()).collect();
    std::fs::write(folder.join("choices.bin"), bytes).expect("a file");
    let json = r#"{
        "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": [0] }], "nodes": [{ "mesh": 0 }],
        "buffers": [{ "uri": "choices.bin", "byteLength": 92 }], "bufferViews": [{ "buffer": 0, "byteLength": 92 }],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0] },
            { "bufferView": 0, "byteOffset": 36, "componentType": 5126, "count": 2, "type": "SCALAR", "min": [0], "max": [1] },
            { "bufferView": 0, "byteOffset": 44, "componentType": 5126, "count": 2, "type": "VEC3" },
            { "bufferView": 0, "byteOffset": 68, "componentType": 5126, "count": 2, "type": "VEC3" }
        ],
        "materials": [
            { "pbrMetallicRoughness": { "baseColorFactor": [0.8, 0.1, 0.1, 1] } },
            { "pbrMetallicRoughness": { "baseColorFactor": [0.1, 0.8, 0.1, 1] } }
        ],
        "meshes": [{ "primitives": [{
            "attributes": { "POSITION": 0 }, "material": 0,
            "extensions": { "KHR_materials_variants": { "mappings": [{ "material": 1, "variants": [0] }] } }
        }] }],
        "animations": [
            { "name": "slide", "channels": [{ "sampler": 0, "target": { "node": 0, "path": "translation" } }],
              "samplers": [{ "input": 1, "output": 2 }] },
            { "name": "rise", "channels": [{ "sampler": 0, "target": { "node": 0, "path": "translation" } }],
              "samplers": [{ "input": 1, "output": 3 }] }
        ],
        "extensionsUsed": ["KHR_materials_variants"],
        "extensions": { "KHR_materials_variants": { "variants": [{ "name": "leaf" }] } }
    }"#;
    let path = folder.join("choices.gltf");
    std::fs::write(&path, json).expect("a file");
    path
}

#[test]
fn animations_and_variants_are_chosen_by_name() {
    let folder = tempfile::tempdir().expect("a folder");
    let Some(mut window) = Window::open(&file_with_choices(folder.path()).to_string_lossy()) else { return };
    window.press(Key::Space);
    window.press(Key::Home);
    (0..12).for_each(|_| window.press(Key::ArrowRight));
    let (from, to) = (window.in_picture(-150.0, 120.0), window.in_picture(-120.0, 120.0));
    window.drag(from, to);
    let slid = window.pixels();
    window.choose("Animation", "rise");
    let risen = window.pixels();
    assert!(slid != risen);
    // Numbers of clearly red and clearly green pixels; the sky is neither.
    let reds_and_greens = |pixels: &[u8]| {
        let excess = |one: u8, other: u8| u32::from(one > other.saturating_add(40));
        let colors = pixels.as_chunks::<4>().0.iter();
        colors.fold((0, 0), |(reds, greens), &[red, green, blue, _]| {
            (reds + excess(red, green.max(blue)), greens + excess(green, red.max(blue)))
        })
    };
    let (reds, greens) = reds_and_greens(&risen);
    assert!(reds > 500 && greens == 0, "{reds} red pixels, {greens} green ones");
    window.choose("Variant", "leaf");
    window.keep("variant");
    assert!(window.shows("Field of view"), "the camera stays");
    let (no_reds, greens) = reds_and_greens(&window.pixels());
    // Pixels at its edges mix it with the sky, so they may be clearly red but not clearly green, or vice versa.
    assert!(
        no_reds == 0 && greens.abs_diff(reds) <= reds / 1000,
        "{no_reds} red pixels, {greens} green ones of {reds}"
    );
}

#[test]
fn objects_are_shown_or_not() {
    let Some(mut window) = Window::open("demo:cloth?triangles=2000") else { return };
    window.press(Key::Space);
    let whole = window.pixels();
    assert!(!window.shows("silk"), "the list is closed at first");
    window.click_in_panel("Objects");
    window.click_in_panel("silk");
    let without_silk = window.pixels();
    window.keep("objects");
    assert!(window.shows("1 of 3 hidden") && without_silk != whole);
    window.press(Key::C);
    assert!(window.shows("--hide silk"));
    window.click_in_panel("Hide");
    assert!(window.shows("3 of 3 hidden") && window.pixels() != without_silk);
    window.click_in_panel("Show");
    assert!(window.pixels() == whole && !window.shows("of 3 hidden"));
}

#[derive(Debug)]
struct Dropped(PathBuf);

impl DroppedFile for Dropped {
    fn path(&self) -> &Path {
        &self.0
    }

    fn bytes(&self) -> Result<Vec<u8>, String> {
        std::fs::read(&self.0).map_err(|error| error.to_string())
    }
}

#[test]
fn an_image_that_is_dropped_is_around_the_scene() {
    let folder = tempfile::tempdir().expect("a folder");
    let image = folder.path().join("meadow.png");
    let mut encoder = png::Encoder::new(std::fs::File::create(&image).expect("a file"), 4, 2);
    encoder.set_color(png::ColorType::Rgb);
    let written = encoder.write_header().and_then(|mut writer| writer.write_image_data(&[10, 200, 30].repeat(8)));
    written.expect("an image");
    let Some(mut window) = Window::open("demo:gears?triangles=2000") else { return };
    window.press(Key::Space);
    let with_sky = window.pixels();
    let drop = |window: &mut Window, path: &Path| {
        window.harness.input_mut().dropped_files.push(Arc::new(Dropped(path.to_owned())));
        window.settle();
    };
    drop(&mut window, &image);
    window.keep("background");
    assert!(with_sky != window.pixels() && window.shows("meadow.png"));
    window.press(Key::C);
    assert!(window.shows("--background") && window.shows("meadow.png"));
    drop(&mut window, &folder.path().join("gone.hdr"));
    assert!(window.shows("gone.hdr"), "a message");
    assert!(with_sky == window.pixels(), "the sky is back");
}
