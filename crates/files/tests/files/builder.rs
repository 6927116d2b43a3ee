//! Small glTF files, made in memory.

use std::fmt::Write as _;
use std::path::Path;

use serde_json::{Value, json};
use umbrage_files::{Clip, OpenOptions};
use umbrage_scene::{Error, Frame, Scene};

/// Component types of accessors.
pub(crate) const I8: u32 = 5120;
pub(crate) const U8: u32 = 5121;
pub(crate) const I16: u32 = 5122;
pub(crate) const U16: u32 = 5123;
pub(crate) const U32: u32 = 5125;
pub(crate) const F32: u32 = 5126;

/// A glTF file with one buffer. Its JSON may be changed at will.
#[derive(Clone)]
pub(crate) struct Builder {
    pub(crate) json: Value,
    pub(crate) bytes: Vec<u8>,
}

impl Builder {
    pub(crate) fn new() -> Self {
        Self { json: json!({ "asset": { "version": "2.0" } }), bytes: Vec::new() }
    }

    /// Appends to one of the JSON's arrays and returns the new element's index.
    pub(crate) fn push(&mut self, list: &str, element: Value) -> usize {
        let root = self.json.as_object_mut().unwrap();
        let list = root.entry(list).or_insert_with(|| json!([])).as_array_mut().unwrap();
        list.push(element);
        list.len() - 1
    }

    /// Appends a buffer view with these bytes.
    pub(crate) fn view(&mut self, bytes: &[u8]) -> usize {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let first = self.bytes.len();
        self.bytes.extend_from_slice(bytes);
        self.push("bufferViews", json!({ "buffer": 0, "byteOffset": first, "byteLength": bytes.len() }))
    }

    /// Appends an accessor to these bytes.
    pub(crate) fn accessor(&mut self, component: u32, kind: &str, count: usize, bytes: &[u8]) -> usize {
        let view = self.view(bytes);
        self.push("accessors", json!({ "bufferView": view, "componentType": component, "type": kind, "count": count }))
    }

    /// Appends an accessor to floats.
    pub(crate) fn floats<const N: usize>(&mut self, values: &[[f32; N]]) -> usize {
        let kind = match N {
            1 => "SCALAR",
            2 => "VEC2",
            3 => "VEC3",
            4 => "VEC4",
            _ => "MAT4",
        };
        let bytes: Vec<u8> = values.as_flattened().iter().flat_map(|value| value.to_le_bytes()).collect();
        self.accessor(F32, kind, values.len(), &bytes)
    }

    /// Appends an accessor to indices.
    pub(crate) fn indices(&mut self, values: &[u16]) -> usize {
        let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
        self.accessor(U16, "SCALAR", values.len(), &bytes)
    }

    /// Appends a mesh of one primitive with these attributes, `more` being merged into the primitive.
    pub(crate) fn mesh(&mut self, attributes: Value, more: Value) -> usize {
        let Value::Object(mut primitive) = more else { panic!("`more` has members") };
        primitive.insert("attributes".to_owned(), attributes);
        self.push("meshes", json!({ "primitives": [primitive] }))
    }

    /// Appends a mesh of one triangle with corners at the origin, at x = 1 and at y = 1.
    pub(crate) fn triangle(&mut self) -> usize {
        let positions = self.floats(&TRIANGLE);
        self.mesh(json!({ "POSITION": positions }), json!({}))
    }

    /// Appends an animation of one channel.
    pub(crate) fn animate<const N: usize>(
        &mut self,
        node: usize,
        path: &str,
        interpolation: &str,
        times: &[f32],
        values: &[[f32; N]],
    ) -> usize {
        let times: Vec<_> = times.iter().map(|&time| [time]).collect();
        let (input, output) = (self.floats(&times), self.floats(values));
        self.push(
            "animations",
            json!({
                "channels": [{ "sampler": 0, "target": { "node": node, "path": path } }],
                "samplers": [{ "input": input, "output": output, "interpolation": interpolation }],
            }),
        )
    }

    /// The file as GLB.
    pub(crate) fn glb(&self) -> Vec<u8> {
        let mut with_buffer = self.clone();
        if !self.bytes.is_empty() {
            with_buffer.json["buffers"] = json!([{ "byteLength": self.bytes.len() }]);
        }
        with_buffer.glb_with_buffers()
    }

    /// The file as GLB, with the buffers of its JSON.
    pub(crate) fn glb_with_buffers(&self) -> Vec<u8> {
        let json = &self.json;
        let mut text = json.to_string().into_bytes();
        text.resize(text.len().next_multiple_of(4), b' ');
        let mut binary = self.bytes.clone();
        binary.resize(binary.len().next_multiple_of(4), 0);
        let length = 12 + 8 + text.len() + 8 + binary.len();
        let mut glb = b"glTF".to_vec();
        for word in [2, length as u32, text.len() as u32] {
            glb.extend_from_slice(&word.to_le_bytes());
        }
        glb.extend_from_slice(b"JSON");
        glb.extend_from_slice(&text);
        glb.extend_from_slice(&(binary.len() as u32).to_le_bytes());
        glb.extend_from_slice(b"BIN\0");
        glb.extend_from_slice(&binary);
        glb
    }

    /// The file as text, with its buffer as a data URI.
    pub(crate) fn gltf(&self) -> Vec<u8> {
        let mut json = self.json.clone();
        json["buffers"] = json!([{ "byteLength": self.bytes.len(), "uri": data_uri(&self.bytes) }]);
        json.to_string().into_bytes()
    }

    pub(crate) fn open(&self) -> Result<Scene, Error> {
        self.open_clip(Clip::Auto)
    }

    pub(crate) fn open_clip(&self, clip: Clip) -> Result<Scene, Error> {
        open_bytes("scene.glb", &self.glb(), clip)
    }

    pub(crate) fn at(&self, seconds: f64) -> Frame {
        self.open().unwrap().at(seconds).unwrap()
    }

    /// The message of the error on opening the file.
    pub(crate) fn error(&self) -> String {
        self.open().expect_err("the file should be refused").to_string()
    }
}

pub(crate) const TRIANGLE: [[f32; 3]; 3] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];

/// Opens a file with this content.
pub(crate) fn open_bytes(name: &str, bytes: &[u8], clip: Clip) -> Result<Scene, Error> {
    let folder = tempfile::tempdir().unwrap();
    open_in(folder.path(), name, bytes, clip)
}

/// Opens a file with this content in a folder that may contain others.
pub(crate) fn open_in(folder: &Path, name: &str, bytes: &[u8], clip: Clip) -> Result<Scene, Error> {
    let path = folder.join(name);
    std::fs::write(&path, bytes).unwrap();
    umbrage_files::open_with(path, &OpenOptions { clip, ..OpenOptions::default() })
}

/// The bytes as a `data:` URI.
pub(crate) fn data_uri(bytes: &[u8]) -> String {
    let mut uri = String::from("data:application/octet-stream,");
    for byte in bytes {
        write!(uri, "%{byte:02x}").unwrap();
    }
    uri
}
