//! Pictures with textures on demand are those with textures in memory, bit for bit.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use glam::{Vec3, Vec4};
use umbrage::scene::{Frame, OpenOptions, TextureTraffic};
use umbrage::{Film, Renderer, Settings, Stats};

/// A TGA image of noise, the upper row first.
fn noise([width, height]: [u16; 2], seed: u32) -> Vec<u8> {
    let mut bytes = vec![0, 0, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0];
    bytes.extend([width, height].map(u16::to_le_bytes).as_flattened());
    bytes.extend([32, 0x28]);
    for texel in 0..u32::from(width) * u32::from(height) {
        let number = (texel + seed).wrapping_mul(2_654_435_761);
        bytes.extend((number ^ number >> 15).to_le_bytes());
    }
    bytes
}

/// Writes an OBJ of leaning panes, one behind the other, with textures of all kinds, and masks with holes.
fn write_panes(folder: &Path) {
    const PANES: u32 = 7;
    let (mut obj, mut library) = ("mtllib a.mtl\nvt 0 0\nvt 1.4 0\nvt 1.4 1.4\nvt 0 1.4\n".to_owned(), String::new());
    for pane in 0..PANES {
        let (z, lean) = (-(pane as f32), 0.3 * pane as f32);
        for (x, y) in [(-2, -2), (2, -2), (2, 2), (-2, 2)] {
            writeln!(obj, "v {x} {y} {}", z + lean * y as f32).expect("a string");
        }
        let corners: Vec<_> = (1..=4).map(|corner| format!("{}/{corner}", 4 * pane + corner)).collect();
        writeln!(obj, "usemtl m{pane}\nf {}", corners.join(" ")).expect("a string");
        writeln!(library, "newmtl m{pane}\nPr 0.3\nmap_Kd c{pane}.tga\nmap_Pr r.tga\nnorm n.tga").expect("a string");
        if pane + 1 < PANES {
            writeln!(library, "map_d c{pane}.tga").expect("a string");
        }
        let size = [150 + 70 * pane as u16, 333 - 40 * pane as u16];
        fs::write(folder.join(format!("c{pane}.tga")), noise(size, pane)).expect("room for a file");
    }
    for (name, content) in [
        ("a.obj", obj.as_bytes()),
        ("a.mtl", library.as_bytes()),
        ("r.tga", &noise([257, 99], 7)),
        ("n.tga", &noise([64, 400], 8)),
    ] {
        fs::write(folder.join(name), content).expect("room for a file");
    }
}

/// A film's contents, as bits.
fn bits(film: &Film) -> impl PartialEq + use<> {
    let colors: Vec<[u32; 4]> = film.color.iter().map(|color: &Vec4| color.to_array().map(f32::to_bits)).collect();
    let normals: Vec<[u32; 3]> = film.normal.iter().map(|normal: &Vec3| normal.to_array().map(f32::to_bits)).collect();
    let depths: Vec<u32> = film.depth.iter().map(|depth| depth.to_bits()).collect();
    (colors, normals, depths, film.triangle.clone())
}

#[test]
fn pictures_are_the_same_for_all_pools_and_threads() {
    let folder = tempfile::tempdir().expect("what a test needs");
    write_panes(folder.path());
    let render = |texture_memory: Option<u64>, threads: usize, samples: u32| {
        let options = OpenOptions { texture_memory, ..OpenOptions::default() };
        let scene = umbrage::open_with(folder.path().join("a.obj"), &options).expect("what a test needs");
        let settings = Settings { width: 120, height: 90, samples, ..Settings::default() };
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("what a test needs");
        let mut renderer = Renderer::default();
        let film = pool.install(|| renderer.render(&scene, 0.0, &settings).expect("what a test needs").clone());
        let Stats { textures, frame_bytes, .. } = *renderer.stats();
        (bits(&film), textures, frame_bytes)
    };
    for samples in [1, 4] {
        let (truth, none, held_bytes) = render(None, 2, samples);
        assert_eq!(none, None);
        for (memory, threads) in
            [(OpenOptions::MIN_TEXTURE_MEMORY, 1), (OpenOptions::MIN_TEXTURE_MEMORY, 5), (1 << 18, 2), (1 << 30, 3)]
        {
            let (film, traffic, frame_bytes) = render(Some(memory), threads, samples);
            assert!(film == truth, "{memory} bytes, {threads} threads, {samples} samples");
            let TextureTraffic { found, loaded, resident_bytes, file_bytes } = traffic.expect("textures on demand");
            assert!(resident_bytes <= memory && found > loaded && loaded > 100, "{traffic:?}");
            assert!(memory > file_bytes || loaded > file_bytes / 4096, "some tiles were loaded again: {traffic:?}");
            assert!(frame_bytes as u64 <= resident_bytes + file_bytes / 1000 + 10_000 && frame_bytes < held_bytes);
        }
    }
}

#[test]
fn sequences_have_a_pool_for_each_file() {
    let folder = tempfile::tempdir().expect("what a test needs");
    write_panes(folder.path());
    let obj = fs::read_to_string(folder.path().join("a.obj")).expect("what a test needs");
    fs::copy(folder.path().join("a.mtl"), folder.path().join("b.mtl")).expect("what a test needs");
    fs::write(folder.path().join("f1.obj"), &obj).expect("room for a file");
    fs::write(folder.path().join("f2.obj"), obj.replace("a.mtl", "b.mtl")).expect("room for a file");
    let frames = |texture_memory: Option<u64>| -> [Frame; 2] {
        let options = OpenOptions { texture_memory, sequence_fps: 1.0, ..OpenOptions::default() };
        let scene = umbrage::open_with(folder.path().join("f%d.obj"), &options).expect("what a test needs");
        [0.0, 1.0].map(|seconds| scene.at(seconds).expect("what a test needs"))
    };
    let settings = Settings { width: 40, height: 30, ..Settings::default() };
    for (held, on_demand) in frames(None).iter().zip(&frames(Some(OpenOptions::MIN_TEXTURE_MEMORY))) {
        let [held, on_demand] = [held, on_demand]
            .map(|frame| bits(Renderer::default().render_frame(frame, &settings).expect("what a test needs")));
        assert!(held == on_demand);
    }
}
