//! Small files written and opened.

use std::path::Path;

use glam::Vec3;
use tempfile::TempDir;
use umbrage_scene::Frame;

/// A folder with these files, deleted when dropped.
pub(crate) fn folder(files: &[(&str, &[u8])]) -> TempDir {
    let folder = TempDir::new().expect("a temporary folder");
    for (name, bytes) in files {
        std::fs::write(folder.path().join(name), bytes).expect("room for a file");
    }
    folder
}

/// A PNG file of these texels.
pub(crate) fn png([width, height]: [u32; 2], color: png::ColorType, texels: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(color);
    encoder.write_header().and_then(|mut writer| writer.write_image_data(texels)).expect("texels for all of it");
    bytes
}

/// The rest pose of a file and the scene's warnings, or the error's message.
pub(crate) fn open_path(path: &Path) -> Result<(Frame, Vec<String>), String> {
    let scene = umbrage_files::open(path).map_err(|error| error.to_string())?;
    let frame = scene.at(0.0).map_err(|error| error.to_string())?;
    Ok((frame, scene.warnings().to_vec()))
}

/// As [`open_path`], of a file called `name` with content `bytes`.
pub(crate) fn open(name: &str, bytes: &[u8]) -> Result<(Frame, Vec<String>), String> {
    let folder = folder(&[(name, bytes)]);
    open_path(&folder.path().join(name))
}

/// The frame of a file without warnings.
pub(crate) fn frame(name: &str, bytes: &[u8]) -> Frame {
    let (frame, warnings) = open(name, bytes).expect("a readable file");
    assert_eq!(warnings, [""; 0]);
    assert_eq!(frame.mesh.material_of_triangle.len(), frame.mesh.triangles.len());
    frame
}

/// The only warning of a readable file.
pub(crate) fn warning(name: &str, bytes: &[u8]) -> String {
    let (_, warnings) = open(name, bytes).expect("a readable file");
    assert_eq!(warnings.len(), 1, "{warnings:?}");
    warnings[0].clone()
}

/// The corners of every triangle.
pub(crate) fn corners(frame: &Frame) -> Vec<[[f32; 3]; 3]> {
    (0..frame.triangles().len() as u32)
        .map(|id| frame.triangles().corners(id).map(|corner| corner.to_array()))
        .collect()
}

/// Total area of all triangles.
pub(crate) fn area(frame: &Frame) -> f32 {
    let of_triangle = |[a, b, c]: [Vec3; 3]| 0.5 * (b - a).cross(c - a).length();
    corners(frame).into_iter().map(|triangle| of_triangle(triangle.map(Vec3::from_array))).sum()
}

/// The corners of a C of area 10; its fan around the first corner would have area 13.
pub(crate) const C_OUTLINE: [[u8; 2]; 8] = [[0, 0], [4, 0], [4, 1], [1, 1], [1, 3], [4, 3], [4, 4], [0, 4]];

/// The concatenated bytes of numbers, little-endian or big-endian.
pub(crate) fn floats(values: &[f32], big_endian: bool) -> Vec<u8> {
    values.iter().flat_map(|value| if big_endian { value.to_be_bytes() } else { value.to_le_bytes() }).collect()
}

/// The eight corners of the unit cube and its twelve triangles, counted from 0.
pub(crate) const CUBE_POSITIONS: [[f32; 3]; 8] = [
    [0.0, 0.0, 0.0],
    [1.0, 0.0, 0.0],
    [1.0, 1.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, 0.0, 1.0],
    [1.0, 0.0, 1.0],
    [1.0, 1.0, 1.0],
    [0.0, 1.0, 1.0],
];
pub(crate) const CUBE_TRIANGLES: [[usize; 3]; 12] = [
    [0, 2, 1],
    [0, 3, 2],
    [4, 5, 6],
    [4, 6, 7],
    [0, 1, 5],
    [0, 5, 4],
    [1, 2, 6],
    [1, 6, 5],
    [2, 3, 7],
    [2, 7, 6],
    [3, 0, 4],
    [3, 4, 7],
];

pub(crate) fn cube_obj() -> Vec<u8> {
    let mut text = String::new();
    for [x, y, z] in CUBE_POSITIONS {
        text += &format!("v {x} {y} {z}\n");
    }
    for [a, b, c] in CUBE_TRIANGLES {
        text += &format!("f {} {} {}\n", a + 1, b + 1, c + 1);
    }
    text.into_bytes()
}

pub(crate) fn cube_ply_text() -> Vec<u8> {
    let mut text = "ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\n\
                    element face 12\nproperty list uchar int vertex_indices\nend_header\n"
        .to_owned();
    for [x, y, z] in CUBE_POSITIONS {
        text += &format!("{x} {y} {z}\n");
    }
    for [a, b, c] in CUBE_TRIANGLES {
        text += &format!("3 {a} {b} {c}\n");
    }
    text.into_bytes()
}

pub(crate) fn cube_ply_binary(big_endian: bool) -> Vec<u8> {
    let endian = if big_endian { "big" } else { "little" };
    let mut bytes = format!(
        "ply\nformat binary_{endian}_endian 1.0\nelement vertex 8\nproperty float x\nproperty float y\n\
         property float z\nelement face 12\nproperty list uchar int vertex_indices\nend_header\n"
    )
    .into_bytes();
    for position in CUBE_POSITIONS {
        bytes.extend(floats(&position, big_endian));
    }
    for triangle in CUBE_TRIANGLES {
        bytes.push(3);
        for vertex in triangle {
            let vertex = vertex as i32;
            bytes.extend(if big_endian { vertex.to_be_bytes() } else { vertex.to_le_bytes() });
        }
    }
    bytes
}

pub(crate) fn cube_stl_text() -> Vec<u8> {
    let mut text = "solid cube\n".to_owned();
    for triangle in CUBE_TRIANGLES {
        text += "facet normal 0 0 0\n outer loop\n";
        for [x, y, z] in triangle.map(|vertex| CUBE_POSITIONS[vertex]) {
            text += &format!("  vertex {x} {y} {z}\n");
        }
        text += " endloop\nendfacet\n";
    }
    (text + "endsolid cube\n").into_bytes()
}

pub(crate) fn cube_stl_binary() -> Vec<u8> {
    let mut bytes = vec![b' '; 80];
    bytes.extend((CUBE_TRIANGLES.len() as u32).to_le_bytes());
    for triangle in CUBE_TRIANGLES {
        bytes.extend(floats(&[0.0; 3], false));
        for vertex in triangle {
            bytes.extend(floats(&CUBE_POSITIONS[vertex], false));
        }
        bytes.extend([0, 0]);
    }
    bytes
}
