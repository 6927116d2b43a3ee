//! How long opening a file of a million triangles takes, bounds and all.
#![allow(missing_docs, reason = "the benchmark macros make undocumented items")]

use std::path::Path;

use divan::Bencher;
use divan::counter::ItemsCount;
use tempfile::TempDir;
use umbrage_scene::Scene;

/// Squares along a side of the wavy sheet that every format holds.
const SIDE: u32 = 708;
const TRIANGLES: u32 = 2 * SIDE * SIDE;

fn main() {
    divan::main();
}

fn position(vertex: u32) -> [f32; 3] {
    let (x, y) = ((vertex % (SIDE + 1)) as f32, (vertex / (SIDE + 1)) as f32);
    [0.01 * x, (0.05 * x).sin() * (0.03 * y).cos(), 0.01 * y]
}

fn vertices() -> impl Iterator<Item = [f32; 3]> {
    (0..(SIDE + 1) * (SIDE + 1)).map(position)
}

fn triangles() -> impl Iterator<Item = [u32; 3]> {
    let corners = |y, x| {
        let first = y * (SIDE + 1) + x;
        [first, first + 1, first + SIDE + 1, first + SIDE + 2]
    };
    let squares = (0..SIDE).flat_map(move |y| (0..SIDE).map(move |x| corners(y, x)));
    squares.flat_map(|[a, b, c, d]| [[a, b, c], [b, d, c]])
}

fn ply_header(format: &str) -> String {
    let vertices = (SIDE + 1) * (SIDE + 1);
    format!(
        "ply\nformat {format} 1.0\nelement vertex {vertices}\nproperty float x\nproperty float y\nproperty float z\n\
         element face {TRIANGLES}\nproperty list uchar int vertex_indices\nend_header\n"
    )
}

fn binary_ply() -> Vec<u8> {
    let mut bytes = ply_header("binary_little_endian").into_bytes();
    bytes.extend(vertices().flatten().flat_map(f32::to_le_bytes));
    for triangle in triangles() {
        bytes.push(3);
        bytes.extend(triangle.into_iter().flat_map(u32::to_le_bytes));
    }
    bytes
}

fn text_ply() -> Vec<u8> {
    let mut text = ply_header("ascii");
    text.extend(vertices().map(|[x, y, z]| format!("{x} {y} {z}\n")));
    text.extend(triangles().map(|[a, b, c]| format!("3 {a} {b} {c}\n")));
    text.into_bytes()
}

fn binary_stl() -> Vec<u8> {
    let mut bytes = vec![0; 80];
    bytes.extend(TRIANGLES.to_le_bytes());
    for triangle in triangles() {
        bytes.extend([0; 12]);
        bytes.extend(triangle.map(position).as_flattened().iter().flat_map(|value| value.to_le_bytes()));
        bytes.extend([0; 2]);
    }
    bytes
}

fn obj() -> Vec<u8> {
    let mut text = String::new();
    text.extend(vertices().map(|[x, y, z]| format!("v {x} {y} {z}\n")));
    text.extend(triangles().map(|[a, b, c]| format!("f {} {} {}\n", a + 1, b + 1, c + 1)));
    text.into_bytes()
}

fn open(bencher: Bencher<'_, '_>, name: &str, bytes: &[u8]) {
    let folder = TempDir::new().expect("a temporary folder");
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).expect("room for a file");
    let open = |path: &Path| Scene::open(path).expect("a readable file");
    bencher.counter(ItemsCount::new(TRIANGLES)).bench_local(|| open(&path));
}

#[divan::bench(sample_count = 10)]
fn open_binary_ply(bencher: Bencher<'_, '_>) {
    open(bencher, "sheet.ply", &binary_ply());
}

#[divan::bench(sample_count = 10)]
fn open_text_ply(bencher: Bencher<'_, '_>) {
    open(bencher, "sheet.ply", &text_ply());
}

#[divan::bench(sample_count = 10)]
fn open_binary_stl(bencher: Bencher<'_, '_>) {
    open(bencher, "sheet.stl", &binary_stl());
}

#[divan::bench(sample_count = 10)]
fn open_obj(bencher: Bencher<'_, '_>) {
    open(bencher, "sheet.obj", &obj());
}
