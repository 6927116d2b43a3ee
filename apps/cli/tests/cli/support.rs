//! Runs the built command on a small scene in a folder of its own.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

/// A folder with `scene.gltf` in it, in which commands run; it is removed in the end.
pub(crate) struct Workplace {
    folder: tempfile::TempDir,
}

impl Workplace {
    pub(crate) fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("scene.bin"), buffer()).unwrap();
        fs::write(folder.path().join("scene.gltf"), SCENE).unwrap();
        Self { folder }
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// All names in the folder but the scene's, sorted.
    pub(crate) fn names(&self) -> Vec<String> {
        let entries = fs::read_dir(self.folder.path()).unwrap();
        let mut names: Vec<String> = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.retain(|name| !name.starts_with("scene."));
        names.sort();
        names
    }

    pub(crate) fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_umbrage"));
        command.current_dir(self.folder.path()).args(arguments).stdin(Stdio::null());
        command
    }

    pub(crate) fn run(&self, arguments: &[&str]) -> Output {
        self.command(arguments).output().unwrap()
    }

    /// Runs a command that must succeed, and returns its standard output and standard error.
    pub(crate) fn succeed(&self, arguments: &[&str]) -> (String, String) {
        let output = self.run(arguments);
        let (stdout, stderr) = (text(&output.stdout), text(&output.stderr));
        assert!(output.status.success(), "{arguments:?}: {:?}\n{stderr}", output.status);
        (stdout, stderr)
    }

    /// Runs a command that must fail with an exit code, and returns its standard error.
    pub(crate) fn fail(&self, code: i32, arguments: &[&str]) -> String {
        let output = self.run(arguments);
        let stderr = text(&output.stderr);
        assert_eq!(output.status.code(), Some(code), "{arguments:?}\n{stderr}");
        assert!(stderr.starts_with("error: "), "{arguments:?}\n{stderr}");
        stderr
    }

    /// Runs a command that must fail for its flags, and returns its standard error, warnings included.
    pub(crate) fn fail_said(&self, arguments: &[&str]) -> String {
        let output = self.run(arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        text(&output.stderr)
    }

    /// Makes `bin/ffmpeg`, a script that knows the file to write as `$to`.
    #[cfg(unix)]
    pub(crate) fn stand_in_for_ffmpeg(&self, script: &str) {
        use std::os::unix::fs::PermissionsExt;

        let folder = self.path("bin");
        fs::create_dir_all(&folder).unwrap();
        let script = format!("#!/bin/sh\nfor to; do :; done\nto=${{to#file:}}\n{script}\n");
        fs::write(folder.join("ffmpeg"), script).unwrap();
        fs::set_permissions(folder.join("ffmpeg"), fs::Permissions::from_mode(0o755)).unwrap();
    }

    /// The search path for programs with the stand-in before all others.
    #[cfg(unix)]
    pub(crate) fn path_with_stand_in(&self) -> String {
        format!("{}:{}", self.path("bin").display(), std::env::var("PATH").unwrap_or_default())
    }

    /// Renders the scene at 16 by 12 pixels with further flags, and gives the pixels.
    pub(crate) fn picture(&self, flags: &[&str]) -> Vec<[u8; 3]> {
        let arguments = [&["render", "scene.gltf", "--size", "16x12", "-o", "picture.png"], flags].concat();
        self.succeed(&arguments);
        decode_png(&self.path("picture.png"))
    }
}

/// The pixels of a PNG of 8 bits.
pub(crate) fn decode_png(path: &Path) -> Vec<[u8; 3]> {
    let mut reader = png::Decoder::new(std::io::BufReader::new(fs::File::open(path).unwrap())).read_info().unwrap();
    let mut rows = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut rows).unwrap();
    assert_eq!((info.color_type, info.bit_depth), (png::ColorType::Rgb, png::BitDepth::Eight));
    rows.chunks(3).map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect()
}

pub(crate) fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

/// A triangle of corners (−1, −1, 0), (1, −1, 0) and (0, 1, 0), and its way from 0 to (3, 0, 0) in half a second.
fn buffer() -> Vec<u8> {
    let corners = [-1.0, -1.0, 0.0, 1.0, -1.0, 0.0, 0.0, 1.0, 0.0];
    let times = [0.0, 0.5];
    let places = [0.0, 0.0, 0.0, 3.0, 0.0, 0.0];
    let numbers = corners.into_iter().chain(times).chain(places);
    numbers.flat_map(|number: f32| number.to_le_bytes()).collect()
}

const SCENE: &str = r#"{
  "asset": {"version": "2.0"},
  "extensionsUsed": ["KHR_lights_punctual"],
  "extensions": {"KHR_lights_punctual": {"lights": [{"name": "lamp", "type": "point", "intensity": 60}]}},
  "scene": 0,
  "scenes": [{"nodes": [0, 1, 2, 3]}],
  "nodes": [
    {"name": "wing", "mesh": 0},
    {"name": "front", "camera": 0, "translation": [0, 0, 5]},
    {"name": "far", "camera": 0, "translation": [0, 0, 25]},
    {"translation": [1, 2, 3], "extensions": {"KHR_lights_punctual": {"light": 0}}}
  ],
  "cameras": [{"type": "perspective", "perspective": {"yfov": 0.9, "znear": 0.1}}],
  "materials": [{"name": "paint", "pbrMetallicRoughness": {"baseColorFactor": [0.8, 0.2, 0.1, 1], "metallicFactor": 0}}],
  "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "material": 0}]}],
  "animations": [{
    "name": "slide",
    "samplers": [{"input": 1, "output": 2}],
    "channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}}]
  }],
  "buffers": [{"uri": "scene.bin", "byteLength": 68}],
  "bufferViews": [{"buffer": 0, "byteLength": 68}],
  "accessors": [
    {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [-1, -1, 0], "max": [1, 1, 0]},
    {"bufferView": 0, "byteOffset": 36, "componentType": 5126, "count": 2, "type": "SCALAR", "min": [0], "max": [0.5]},
    {"bufferView": 0, "byteOffset": 44, "componentType": 5126, "count": 2, "type": "VEC3"}
  ]
}"#;
