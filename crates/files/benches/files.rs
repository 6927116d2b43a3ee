//! Times to open files of a million triangles, including their bounds, and to pose glTF scenes.
#![allow(clippy::unwrap_used, reason = "a benchmark may fail")]
#![allow(missing_docs, reason = "the benchmark macros make undocumented items")]

use std::path::PathBuf;

use divan::Bencher;
use divan::counter::ItemsCount;
use serde_json::{Value, json};
use tempfile::TempDir;
use umbrage_scene::rig::Pose;
use umbrage_scene::{Frame, Scene};

#[path = "../tests/files/builder.rs"]
#[allow(dead_code, reason = "shared with the reader's tests, which use more of it")]
mod builder;

use builder::Builder;

fn main() {
    divan::main();
}

/// A file on disk, removed at the end.
struct SceneFile {
    path: PathBuf,
    _folder: TempDir,
}

impl SceneFile {
    fn new(name: &str, bytes: &[u8]) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        Self { path, _folder: folder }
    }

    fn open(&self) -> Scene {
        umbrage_files::open(&self.path).unwrap()
    }
}

/// A wavy square of vertices.
struct Sheet {
    positions: Vec<[f32; 3]>,
    triangles: Vec<[u32; 3]>,
}

impl Sheet {
    /// 999,698 triangles.
    const MILLION: u32 = 708;

    fn new(side: u32) -> Self {
        let place = |vertex: u32| [(vertex % side) as f32, (vertex / side) as f32];
        let positions = (0..side * side).map(place).map(|[x, y]| [x, y, (0.05 * x).sin() * (0.03 * y).cos()]);
        let corners = (0..side * (side - 1)).filter(|corner| corner % side < side - 1);
        let triangles = corners.flat_map(|a| [[a, a + 1, a + side], [a + side, a + 1, a + side + 1]]);
        Self { positions: positions.collect(), triangles: triangles.collect() }
    }

    fn ply_header(&self, format: &str) -> String {
        let (vertices, faces) = (self.positions.len(), self.triangles.len());
        format!(
            "ply\nformat {format} 1.0\nelement vertex {vertices}\nproperty float x\nproperty float y\nproperty float z\n\
             element face {faces}\nproperty list uchar int vertex_indices\nend_header\n"
        )
    }

    fn binary_ply(&self) -> Vec<u8> {
        let mut bytes = self.ply_header("binary_little_endian").into_bytes();
        bytes.extend(self.positions.iter().flatten().flat_map(|value| value.to_le_bytes()));
        for triangle in &self.triangles {
            bytes.push(3);
            bytes.extend(triangle.iter().flat_map(|vertex| vertex.to_le_bytes()));
        }
        bytes
    }

    fn text_ply(&self) -> Vec<u8> {
        let mut text = self.ply_header("ascii");
        text.extend(self.positions.iter().map(|[x, y, z]| format!("{x} {y} {z}\n")));
        text.extend(self.triangles.iter().map(|[a, b, c]| format!("3 {a} {b} {c}\n")));
        text.into_bytes()
    }

    fn binary_stl(&self) -> Vec<u8> {
        let mut bytes = vec![0; 80];
        bytes.extend((self.triangles.len() as u32).to_le_bytes());
        for triangle in &self.triangles {
            bytes.extend([0; 12]);
            let corners = triangle.map(|vertex| self.positions[vertex as usize]);
            bytes.extend(corners.as_flattened().iter().flat_map(|value| value.to_le_bytes()));
            bytes.extend([0; 2]);
        }
        bytes
    }

    fn obj(&self) -> Vec<u8> {
        let mut text = String::new();
        text.extend(self.positions.iter().map(|[x, y, z]| format!("v {x} {y} {z}\n")));
        text.extend(self.triangles.iter().map(|[a, b, c]| format!("f {} {} {}\n", a + 1, b + 1, c + 1)));
        text.into_bytes()
    }

    /// Adds the mesh's accessors; returns its attributes, with normals and texture coordinates, and its indices.
    fn add_to(&self, file: &mut Builder) -> (Value, usize) {
        let positions = file.floats(&self.positions);
        let normals = file.floats(&vec![[0.0, 0.0, 1.0]; self.positions.len()]);
        let coords: Vec<_> = self.positions.iter().map(|&[x, y, _]| [x, y]).collect();
        let coords = file.floats(&coords);
        let indices: Vec<u8> = self.triangles.iter().flatten().flat_map(|vertex| vertex.to_le_bytes()).collect();
        let indices = file.accessor(builder::U32, "SCALAR", indices.len() / 4, &indices);
        (json!({ "POSITION": positions, "NORMAL": normals, "TEXCOORD_0": coords }), indices)
    }

    /// A file in which the sheet doesn't move.
    fn glb(&self) -> Vec<u8> {
        let mut file = Builder::new();
        let (attributes, indices) = self.add_to(&mut file);
        file.mesh(attributes, json!({ "indices": indices }));
        file.push("nodes", json!({ "mesh": 0 }));
        file.glb()
    }
}

/// 99,458 triangles whose vertices follow four of 64 turning joints each.
fn character() -> SceneFile {
    const SIDE: u32 = 224;
    const JOINTS: u32 = 64;
    let mut file = Builder::new();
    let (mut attributes, indices) = Sheet::new(SIDE).add_to(&mut file);
    let joints: Vec<u8> = (0..SIDE * SIDE)
        .flat_map(|vertex| [0, 1, 2, 3].map(|next| ((vertex / SIDE * JOINTS / SIDE + next) % JOINTS) as u8))
        .collect();
    attributes["JOINTS_0"] = json!(file.accessor(builder::U8, "VEC4", (SIDE * SIDE) as usize, &joints));
    attributes["WEIGHTS_0"] = json!(file.floats(&vec![[0.4, 0.3, 0.2, 0.1]; (SIDE * SIDE) as usize]));
    let mesh = file.mesh(attributes, json!({ "indices": indices }));
    file.push("nodes", json!({ "mesh": mesh, "skin": 0 }));
    for joint in 1..=JOINTS {
        let children: Vec<_> = (joint < JOINTS).then_some(joint + 1).into_iter().collect();
        file.push("nodes", json!({ "children": children, "translation": [0, 1, 0] }));
        let turned = [0.0, 0.0, 0.05, 0.998_75];
        file.animate(joint as usize, "rotation", "LINEAR", &[0.0, 1.0], &[[0.0, 0.0, 0.0, 1.0], turned]);
    }
    file.push("skins", json!({ "joints": (1..=JOINTS).collect::<Vec<_>>() }));
    SceneFile::new("character.glb", &file.glb())
}

#[divan::bench(args = ["binary.ply", "text.ply", "binary.stl", "text.obj", "binary.glb"], sample_count = 10)]
fn open_one_million_triangles(bencher: Bencher<'_, '_>, name: &str) {
    let sheet = Sheet::new(Sheet::MILLION);
    let bytes = match name {
        "binary.ply" => sheet.binary_ply(),
        "text.ply" => sheet.text_ply(),
        "binary.stl" => sheet.binary_stl(),
        "text.obj" => sheet.obj(),
        _ => sheet.glb(),
    };
    let file = SceneFile::new(name, &bytes);
    bencher.counter(ItemsCount::new(sheet.triangles.len())).bench_local(|| file.open());
}

#[divan::bench]
fn pose_one_million_rigid_triangles(bencher: Bencher<'_, '_>) {
    pose(bencher, &SceneFile::new("sheet.glb", &Sheet::new(Sheet::MILLION).glb()));
}

#[divan::bench]
fn pose_a_hundred_thousand_skinned_triangles(bencher: Bencher<'_, '_>) {
    pose(bencher, &character());
}

/// The CPU's share where a GPU poses the vertices.
#[divan::bench]
fn pose_the_rig_of_a_hundred_thousand_skinned_triangles(bencher: Bencher<'_, '_>) {
    let scene = character().open();
    let (mut frame, mut pose) = (Frame::default(), Pose::default());
    let mut seconds = 0.0;
    bencher.bench_local(|| {
        seconds += 0.01;
        scene.pose_rig(seconds, &mut frame, &mut pose).unwrap().unwrap();
    });
}

fn pose(bencher: Bencher<'_, '_>, file: &SceneFile) {
    let scene = file.open();
    let mut frame = Frame::default();
    let mut seconds = 0.0;
    bencher.bench_local(|| {
        seconds += 0.01;
        scene.pose(seconds, &mut frame).unwrap();
    });
}
