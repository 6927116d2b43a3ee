//! A small animated file with a camera and a light.

use std::path::{Path, PathBuf};

use serde_json::json;

/// Writes `moving.gltf`: a triangle that moves sideways over a floor, seen from a camera that looks along −Z at a light.
pub(crate) fn write(folder: &Path) -> PathBuf {
    let floor: [[f32; 3]; 4] = [[-6.0, -1.0, -12.0], [6.0, -1.0, -12.0], [6.0, -1.0, 0.0], [-6.0, -1.0, 0.0]];
    let triangle: [[f32; 3]; 3] = [[-0.6, -0.8, -5.0], [0.6, -0.8, -5.0], [0.0, 0.3, -5.0]];
    let times: [f32; 3] = [0.0, 1.0, 2.0];
    let places: [[f32; 3]; 3] = [[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]];
    let indices: [u16; 6] = [0, 2, 1, 0, 3, 2];
    let floats = floor.iter().chain(&triangle).flatten().chain(&times).chain(places.iter().flatten());
    let mut bytes: Vec<u8> = floats.flat_map(|number| number.to_le_bytes()).collect();
    bytes.extend(indices.iter().flat_map(|index| index.to_le_bytes()));
    std::fs::write(folder.join("moving.bin"), &bytes).expect("a file");
    let floats = |view: u32, count: u32, kind: &str| json!({ "bufferView": view, "componentType": 5126, "count": count, "type": kind });
    let bounded = |view: u32, count: u32, min: [f32; 3], max: [f32; 3]| json!({ "bufferView": view, "componentType": 5126, "count": count, "type": "VEC3", "min": min, "max": max });
    let view = |offset: u32, length: u32| json!({ "buffer": 0, "byteOffset": offset, "byteLength": length });
    let file = json!({
        "asset": { "version": "2.0" },
        "extensionsUsed": ["KHR_lights_punctual"],
        "extensions": { "KHR_lights_punctual": { "lights": [{ "type": "point", "intensity": 60.0, "name": "lamp" }] } },
        "scene": 0,
        "scenes": [{ "nodes": [0, 1, 2, 3] }],
        "nodes": [
            { "mesh": 0 },
            { "mesh": 1 },
            { "camera": 0 },
            { "translation": [0.0, 0.0, -4.0], "extensions": { "KHR_lights_punctual": { "light": 0 } } },
        ],
        "cameras": [{ "type": "perspective", "perspective": { "yfov": 0.9, "znear": 0.1 } }],
        "meshes": [
            { "primitives": [{ "attributes": { "POSITION": 0 }, "indices": 4, "material": 0 }] },
            { "primitives": [{ "attributes": { "POSITION": 1 }, "material": 1 }] },
        ],
        "materials": [
            { "name": "floor", "pbrMetallicRoughness": { "baseColorFactor": [0.7, 0.7, 0.6, 1.0], "roughnessFactor": 0.9 } },
            { "name": "sail", "doubleSided": true, "pbrMetallicRoughness": { "baseColorFactor": [0.8, 0.2, 0.1, 1.0] } },
        ],
        "animations": [{
            "channels": [{ "sampler": 0, "target": { "node": 1, "path": "translation" } }],
            "samplers": [{ "input": 2, "output": 3 }],
        }],
        "accessors": [
            bounded(0, 4, [-6.0, -1.0, -12.0], [6.0, -1.0, 0.0]),
            bounded(1, 3, [-0.6, -0.8, -5.0], [0.6, 0.3, -5.0]),
            { "bufferView": 2, "componentType": 5126, "count": 3, "type": "SCALAR", "min": [0.0], "max": [2.0] },
            floats(3, 3, "VEC3"),
            { "bufferView": 4, "componentType": 5123, "count": 6, "type": "SCALAR" },
        ],
        "bufferViews": [view(0, 48), view(48, 36), view(84, 12), view(96, 36), view(132, 12)],
        "buffers": [{ "uri": "moving.bin", "byteLength": bytes.len() }],
    });
    let path = folder.join("moving.gltf");
    std::fs::write(&path, file.to_string()).expect("a file");
    path
}
