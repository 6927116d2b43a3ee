//! How long glTF scenes take to open and to pose.
#![allow(clippy::unwrap_used, reason = "a benchmark may fail")]

use std::path::PathBuf;

use serde_json::json;
use tempfile::TempDir;
use umbrage_scene::rig::Pose;
use umbrage_scene::{Frame, Scene};

#[path = "../tests/scene/builder.rs"]
#[allow(dead_code, reason = "shared with the reader's tests, which use more of it")]
mod builder;

use builder::Builder;

fn main() {
    divan::main();
}

/// A GLB on disk, removed at the end.
struct SceneFile {
    path: PathBuf,
    _folder: TempDir,
}

impl SceneFile {
    fn new(file: &Builder) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("scene.glb");
        std::fs::write(&path, file.glb()).unwrap();
        Self { path, _folder: folder }
    }
}

/// A square of `side` × `side` vertices with normals and texture coordinates, and the attributes of its mesh.
fn sheet(file: &mut Builder, side: u32) -> (serde_json::Value, usize) {
    let places: Vec<_> = (0..side * side).map(|vertex| [(vertex % side) as f32, (vertex / side) as f32]).collect();
    let positions: Vec<_> = places.iter().map(|[x, y]| [*x, *y, (x * 0.1).sin()]).collect();
    let positions = file.floats(&positions);
    let normals = file.floats(&vec![[0.0, 0.0, 1.0]; places.len()]);
    let coords = file.floats(&places);
    let mut indices: Vec<u8> = Vec::new();
    for corner in (0..side * (side - 1)).filter(|corner| corner % side < side - 1) {
        let square = [corner, corner + 1, corner + side, corner + side, corner + 1, corner + side + 1];
        indices.extend(square.iter().flat_map(|vertex| vertex.to_le_bytes()));
    }
    let indices = file.accessor(builder::U32, "SCALAR", indices.len() / 4, &indices);
    (json!({ "POSITION": positions, "NORMAL": normals, "TEXCOORD_0": coords }), indices)
}

/// 999,698 triangles that don't move.
fn million() -> SceneFile {
    let mut file = Builder::new();
    let (attributes, indices) = sheet(&mut file, 708);
    file.mesh(attributes, json!({ "indices": indices }));
    file.push("nodes", json!({ "mesh": 0 }));
    SceneFile::new(&file)
}

/// 99,904 triangles whose vertices follow four of 64 turning joints each.
fn character() -> SceneFile {
    const SIDE: u32 = 224;
    const JOINTS: u32 = 64;
    let mut file = Builder::new();
    let (mut attributes, indices) = sheet(&mut file, SIDE);
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
    SceneFile::new(&file)
}

#[divan::bench(sample_count = 10)]
fn open_one_million_triangles(bencher: divan::Bencher<'_, '_>) {
    let file = million();
    bencher.bench_local(|| Scene::open(&file.path).unwrap());
}

#[divan::bench]
fn pose_one_million_rigid_triangles(bencher: divan::Bencher<'_, '_>) {
    let file = million();
    pose(bencher, &file);
}

#[divan::bench]
fn pose_a_hundred_thousand_skinned_triangles(bencher: divan::Bencher<'_, '_>) {
    let file = character();
    pose(bencher, &file);
}

/// What is left to the CPU where a GPU poses the vertices.
#[divan::bench]
fn pose_the_rig_of_a_hundred_thousand_skinned_triangles(bencher: divan::Bencher<'_, '_>) {
    let file = character();
    let scene = Scene::open(&file.path).unwrap();
    let (mut frame, mut pose) = (Frame::default(), Pose::default());
    let mut seconds = 0.0;
    bencher.bench_local(|| {
        seconds += 0.01;
        scene.pose_rig(seconds, &mut frame, &mut pose).unwrap();
    });
}

fn pose(bencher: divan::Bencher<'_, '_>, file: &SceneFile) {
    let scene = Scene::open(&file.path).unwrap();
    let mut frame = Frame::default();
    let mut seconds = 0.0;
    bencher.bench_local(|| {
        seconds += 0.01;
        scene.pose(seconds, &mut frame).unwrap();
    });
}
