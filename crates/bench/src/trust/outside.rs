//! Names in a scene's file, and links beside it, that lead out of its folder.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::Result;
use umbrage::Image;
use umbrage::output::{BitDepth, write_png};
use umbrage::scene::OpenOptions;

use super::{Effort, Finding};

/// Files outside of the scene's folder: a triangle, a picture, materials.
const TRIANGLE: &str = "triangle.bin";
const PICTURE: &str = "picture.png";
const PAINT: &str = "paint.mtl";

/// Writes a scene into a folder that names a file; its path.
type Writer = fn(&Path, &str) -> Result<PathBuf>;

const WRITERS: [(&str, Writer); 4] = [
    (TRIANGLE, |folder, name| gltf(folder, name, "")),
    (PICTURE, |folder, name| {
        let texture = r#""textures": [{"source": 0}],
            "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}]"#;
        gltf(folder, TRIANGLE, &format!(r#", "images": [{{"uri": "{name}"}}], {texture}"#))
    }),
    (PAINT, |folder, name| obj(folder, name)),
    (PICTURE, |folder, name| {
        fs::write(folder.join(PAINT), format!("newmtl paint\nmap_Kd {name}\n"))?;
        obj(folder, PAINT)
    }),
];

/// A triangle whose corners are in a file.
fn gltf(folder: &Path, buffer: &str, more: &str) -> Result<PathBuf> {
    let material = if more.is_empty() { "" } else { r#", "material": 0"# };
    let text = format!(
        r#"{{"asset": {{"version": "2.0"}}, "scene": 0, "scenes": [{{"nodes": [0]}}], "nodes": [{{"mesh": 0}}],
            "buffers": [{{"uri": "{buffer}", "byteLength": 36}}], "bufferViews": [{{"buffer": 0, "byteLength": 36}}],
            "accessors": [{{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0],
            "max": [1, 1, 0]}}, {{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC2"}}],
            "meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0, "TEXCOORD_0": 1}}{material}}}]}}]{more}}}"#
    );
    let path = folder.join("a.gltf");
    fs::write(&path, text)?;
    Ok(path)
}

/// A triangle whose material is in a file.
fn obj(folder: &Path, library: &str) -> Result<PathBuf> {
    let path = folder.join("a.obj");
    let corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nf 1/1 2/1 3/1\n";
    fs::write(&path, format!("mtllib {library}\nusemtl paint\n{corners}"))?;
    Ok(path)
}

/// Makes links in the scene's folder that lead out of it, where the system has them; returns their prefixes of a file's
/// name.
fn link(scene: &Path) -> Result<&'static [&'static str]> {
    #[cfg(unix)]
    {
        use std::os::unix::fs::symlink;

        symlink("..", scene.join("up"))?;
        for file in [TRIANGLE, PICTURE, PAINT] {
            symlink(Path::new("..").join(file), scene.join(format!("link-{file}")))?;
            symlink(format!("link-{file}"), scene.join(format!("second-{file}")))?;
        }
        Ok(&["up/", "link-", "second-"])
    }
    #[cfg(not(unix))]
    Ok(&[])
}

pub(super) fn names(_: &Effort) -> Result<Finding> {
    let outer = tempfile::tempdir()?;
    let scene = outer.path().join("scene");
    fs::create_dir_all(scene.join("below"))?;
    let corners = [0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    for folder in [outer.path(), &scene] {
        fs::write(folder.join(TRIANGLE), corners.map(f32::to_le_bytes).as_flattened())?;
    }
    let picture = Image { width: 1, height: 1, pixels: vec![[u16::MAX, 0, 0]], ..Image::default() };
    write_png(&picture, &outer.path().join(PICTURE), BitDepth::Eight)?;
    fs::write(outer.path().join(PAINT), "newmtl paint\nKd 1 0 0\n")?;
    let links = link(&scene)?;
    let (mut asked, mut followed) = (0, [0; 2]);
    for (file, write) in WRITERS {
        let whole = outer.path().join(file).to_string_lossy().replace('\\', "/");
        let by_name = [format!("../{file}"), format!("below/../../{file}"), whole];
        for name in by_name.into_iter().chain(links.iter().map(|link| format!("{link}{file}"))) {
            let path = write(&scene, &name)?;
            asked += 1;
            for (followed, allow_outside) in followed.iter_mut().zip([false, true]) {
                let opened = umbrage::open_with(&path, &OpenOptions { allow_outside, ..OpenOptions::default() });
                // A name that isn't followed is an error or a warning.
                *followed += u64::from(opened.is_ok_and(|scene| scene.warnings().is_empty()));
            }
        }
    }
    let ways = if links.is_empty() { "" } else { ", and by symbolic links of files and folders" };
    let text = format!(
        "{} of {asked} names that lead out of a scene's folder are followed, by `..` and by whole paths{ways}: in buffers and \
         pictures of glTF files, and in materials and textures of OBJ files. With `--allow-outside`, {} are.",
        followed[0], followed[1],
    );
    Ok(Finding::new(followed == [0, asked], text))
}
