//! Formats by file extension, and converters for formats that aren't read.

use std::path::Path;

use umbrage_scene::Error;

/// A format that is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Format {
    /// Opened alone, but not in a sequence.
    Gltf,
    Obj,
    Ply,
    Stl,
    /// Opened alone, with the OBJ file beside it.
    PointCache,
}

impl Format {
    /// The format of a file's extension; `None` for other extensions.
    pub(crate) fn of(path: &Path) -> Option<Self> {
        match extension(path)?.as_str() {
            "gltf" | "glb" => Some(Self::Gltf),
            "obj" => Some(Self::Obj),
            "ply" => Some(Self::Ply),
            "stl" => Some(Self::Stl),
            "pc2" | "mdd" => Some(Self::PointCache),
            _ => None,
        }
    }
}

/// A file's extension in lower case.
fn extension(path: &Path) -> Option<String> {
    Some(path.extension()?.to_str()?.to_ascii_lowercase())
}

/// Scene formats that aren't read: their extensions, their name, and a free tool that converts them.
const CONVERTED: &[(&[&str], &str, &str)] = &[
    (
        &["usd", "usda", "usdc", "usdz"],
        "Universal Scene Description",
        "Blender imports it (File > Import > Universal Scene Description) and exports .glb (File > Export > glTF 2.0)",
    ),
    (&["fbx"], "FBX", "Blender imports it (File > Import > FBX) and exports .glb (File > Export > glTF 2.0)"),
    (&["blend"], "Blender's own format", "Blender opens it and exports .glb (File > Export > glTF 2.0)"),
    (
        &["abc"],
        "Alembic",
        "Blender imports it (File > Import > Alembic) and exports .glb, or numbered .obj files where the mesh changes \
         (File > Export > Wavefront, Animation)",
    ),
    (
        &["dae", "3ds", "x", "x3d", "wrl", "ac", "lwo", "lxo", "ase", "ms3d", "md5mesh", "off"],
        "a format of other programs",
        "assimp makes .glb of it: `assimp export FILE OUT.glb`",
    ),
    (&["3mf", "amf"], "a format for printers", "PrusaSlicer and MeshLab make .stl of it"),
    (&["step", "stp", "iges", "igs", "brep", "fcstd"], "a CAD format", "FreeCAD opens it and exports .gltf or .stl"),
    (&["ifc"], "a format of buildings", "Blender with the add-on Bonsai imports it and exports .glb"),
    (&["vrm"], "an avatar", "it is glTF: give its name the end .glb"),
    (
        &["las", "laz", "e57", "pcd", "xyz", "splat", "spz"],
        "a cloud of points without surfaces",
        "CloudCompare and MeshLab make a mesh of it, as .ply",
    ),
    (&["zip", "7z", "rar", "gz", "tar"], "a compressed folder", "unpack it first"),
];

/// Makes the error for a file whose format isn't read.
pub(crate) fn unread(path: &Path) -> Error {
    const READ: &str = "use .gltf, .glb, .obj, .ply, .stl, .pc2, .mdd or demo:NAME";
    let Some(end) = extension(path) else {
        return Error::unsupported(path, "a file without an extension", READ);
    };
    match CONVERTED.iter().find(|(ends, ..)| ends.contains(&end.as_str())) {
        Some((_, name, tool)) => Error::unsupported(path, format!("`.{end}`, {name},"), *tool),
        None => Error::unsupported(path, format!("`.{end}`"), READ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_read_names_what_converts_it() {
        for (name, tool) in [
            ("a.USDZ", "Blender"),
            ("a.usdc", "Universal Scene Description"),
            ("b.fbx", "Blender"),
            ("c.blend", "glTF 2.0"),
            ("d.abc", "numbered .obj files"),
            ("e.dae", "assimp export"),
            ("f.step", "FreeCAD"),
            ("g.vrm", ".glb"),
            ("h.txt", "use .gltf"),
            ("i", "without an extension"),
        ] {
            assert_eq!(Format::of(Path::new(name)), None);
            let error = unread(Path::new(name)).to_string();
            assert!(error.starts_with(&format!("{name}: ")) && error.contains(tool), "{error}");
        }
    }

    #[test]
    fn what_is_read_is_not_converted() {
        let ends = CONVERTED.iter().flat_map(|(ends, ..)| *ends);
        assert!(ends.clone().all(|end| Format::of(&Path::new("a").with_extension(end)).is_none()));
        let mut all: Vec<_> = ends.collect();
        let count = all.len();
        all.sort_unstable();
        all.dedup();
        assert_eq!(all.len(), count, "each once");
    }
}
