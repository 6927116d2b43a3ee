use glam::Vec4;
use proptest::prelude::*;
use serde_json::json;
use umbrage_scene::Frame;

use crate::builder::{Builder, F32};

/// A mesh that faces z, with a normal map and a morph target that lifts only the last vertex.
fn bumpy(positions: &[[f32; 3]], coords: &[[f32; 2]], indices: &[u16]) -> Builder {
    let mut file = Builder::new();
    let last = positions.len() - 1;
    let [places, values] = [
        &(last as u16).to_le_bytes()[..],
        &[[0.0_f32, 0.0, 1.0]].as_flattened().iter().flat_map(|value| value.to_le_bytes()).collect::<Vec<_>>(),
    ]
    .map(|bytes| file.view(bytes));
    let lift = file.push(
        "accessors",
        json!({ "componentType": F32, "type": "VEC3", "count": positions.len(), "sparse": {
            "count": 1,
            "indices": { "bufferView": places, "componentType": crate::builder::U16 },
            "values": { "bufferView": values },
        } }),
    );
    let normals = file.floats(&vec![[0.0, 0.0, 1.0]; positions.len()]);
    let colors: Vec<_> = (0..positions.len()).map(|vertex| [vertex as f32 / 16.0, 0.0, 0.0]).collect();
    let attributes = json!({
        "POSITION": file.floats(positions),
        "NORMAL": normals,
        "TEXCOORD_0": file.floats(coords),
        "COLOR_0": file.floats(&colors),
    });
    let indices = file.indices(indices);
    let more = json!({ "indices": indices, "material": 0, "targets": [{ "POSITION": lift }] });
    let mesh = file.mesh(attributes, more);
    file.push("nodes", json!({ "mesh": mesh, "weights": [0.5] }));
    file.push("images", json!({ "uri": "data:," }));
    file.push("textures", json!({ "source": 0 }));
    file.push("materials", json!({ "normalTexture": { "index": 0 } }));
    file
}

const SQUARE: [[f32; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];

#[test]
fn tangents_follow_an_upright_texture() {
    // v grows downwards.
    let coords = [[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]];
    let frame = bumpy(&SQUARE, &coords, &[0, 1, 2, 0, 2, 3]).at(0.0);
    assert_eq!(frame.tangents, [Vec4::new(1.0, 0.0, 0.0, 1.0); 4]);
    assert_eq!(frame.mesh.triangles, [[0, 1, 2], [0, 2, 3]]);
}

#[test]
fn vertices_on_the_axis_of_a_mirrored_texture_are_split() {
    // Two squares beside each other share vertices 1 and 2; u grows from there to both sides.
    let positions = [SQUARE[0], SQUARE[1], SQUARE[2], SQUARE[3], [2.0, 0.0, 0.0], [2.0, 1.0, 0.0]];
    let coords = [[1.0, 1.0], [0.0, 1.0], [0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [1.0, 0.0]];
    let frame = bumpy(&positions, &coords, &[0, 1, 2, 0, 2, 3, 5, 2, 1, 5, 1, 4]).at(0.0);
    assert_eq!(frame.positions.len(), 8);
    let tangent_at = |corner: u32| frame.tangents[corner as usize];
    let [left, right] = [&frame.mesh.triangles[..2], &frame.mesh.triangles[2..]];
    assert!(left.as_flattened().iter().all(|&corner| tangent_at(corner) == Vec4::new(-1.0, 0.0, 0.0, -1.0)));
    assert!(right.as_flattened().iter().all(|&corner| tangent_at(corner) == Vec4::new(1.0, 0.0, 0.0, 1.0)));
    // Copies have all attributes of their vertices.
    for (corner, old) in frame.mesh.triangles.as_flattened().iter().zip([0, 1, 2, 0, 2, 3, 5, 2, 1, 5, 1, 4]) {
        let [x, y, _] = positions[old];
        let lifted = if old == 5 { 0.5 } else { 0.0 };
        assert_eq!(frame.positions[*corner as usize].to_array(), [x, y, lifted]);
        assert_eq!(frame.mesh.colors[*corner as usize].x, old as f32 / 16.0);
        assert_eq!(frame.mesh.tex_coords[0][*corner as usize].to_array(), coords[old]);
    }
}

#[test]
fn copies_of_morphed_vertices_are_morphed() {
    // As above, with one end of the axis as the last vertex.
    let positions = [SQUARE[0], SQUARE[1], [2.0, 1.0, 0.0], SQUARE[3], [2.0, 0.0, 0.0], SQUARE[2]];
    let coords = [[1.0, 1.0], [0.0, 1.0], [1.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 0.0]];
    let frame = bumpy(&positions, &coords, &[0, 1, 5, 0, 5, 3, 2, 5, 1, 2, 1, 4]).at(0.0);
    assert_eq!(frame.positions.iter().filter(|position| position.z == 0.5).count(), 2);
    frame.check().expect("a sound frame");
}

fn sound(frame: &Frame) {
    frame.check().expect("a sound frame");
    for tangent in &frame.tangents {
        assert!(*tangent == Vec4::ZERO || (tangent.truncate().length() - 1.0).abs() < 1e-3, "{tangent}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() })]

    /// Many vertices at few positions make triangles without area, in space or on the texture, and edges of many triangles.
    #[test]
    fn any_triangles_have_tangents_or_none(
        vertices in proptest::collection::vec(((0..3_u8, 0..3_u8, 0..2_u8), (0..3_u8, 0..3_u8)), 3..12),
        corners in proptest::collection::vec(any::<prop::sample::Index>(), 3..60),
    ) {
        let positions: Vec<_> = vertices.iter().map(|&((x, y, z), _)| [x, y, z].map(f32::from)).collect();
        let coords: Vec<_> = vertices.iter().map(|&(_, (u, v))| [u, v].map(f32::from)).collect();
        let indices: Vec<_> = corners.iter().map(|corner| corner.index(vertices.len()) as u16).collect();
        sound(&bumpy(&positions, &coords, &indices).at(0.0));
    }
}

#[test]
fn lacquer_and_stretched_highlights_need_tangents_too() {
    let coords = [[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]];
    let tangents = |material: serde_json::Value| {
        let mut file = bumpy(&SQUARE, &coords, &[0, 1, 2, 0, 2, 3]);
        file.json["materials"][0] = material;
        file.at(0.0).tangents.clone()
    };
    let coat = json!({ "clearcoatFactor": 1, "clearcoatNormalTexture": { "index": 0 } });
    let along_x = [Vec4::new(1.0, 0.0, 0.0, 1.0); 4];
    assert_eq!(tangents(json!({ "extensions": { "KHR_materials_clearcoat": coat } })), along_x);
    let stretched = json!({ "KHR_materials_anisotropy": { "anisotropyStrength": 0.5 } });
    assert_eq!(tangents(json!({ "extensions": stretched })), along_x);
    let round = json!({ "KHR_materials_anisotropy": { "anisotropyRotation": 0.5 } });
    assert_eq!(tangents(json!({ "extensions": round })), [Vec4::ZERO; 0]);
}
