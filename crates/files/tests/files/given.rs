//! Files in memory, as in a browser.

use umbrage_files::OpenOptions;
use umbrage_scene::Scene;

use crate::builder::Builder;

const SQUARE: &str = "mtllib paints/square.mtl\nusemtl red\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n";
const PAINTS: &str = "newmtl red\nKd 1 0 0\n";

fn open(name: &str, files: &[(&str, &[u8])]) -> Result<Scene, String> {
    let files = files.iter().map(|&(path, bytes)| (path, bytes));
    umbrage_files::open_files(name, files, &OpenOptions::default()).map_err(|error| error.to_string())
}

#[test]
fn what_a_file_names_is_among_those_that_are_given() {
    let files = [("a/square.obj", SQUARE.as_bytes()), ("a/paints/square.mtl", PAINTS.as_bytes())];
    let scene = open("a/square.obj", &files).unwrap();
    assert_eq!(scene.warnings(), [""; 0]);
    assert_eq!(scene.files(), ["a/paints/square.mtl", "a/square.obj"].map(std::path::PathBuf::from));
    assert_eq!(scene.at(0.0).unwrap().materials.materials[0].name, "red");

    // Without folders, the library is found by its name alone.
    let scene = open("square.obj", &[("square.obj", SQUARE.as_bytes()), ("square.mtl", PAINTS.as_bytes())]).unwrap();
    assert_eq!(scene.warnings(), [""; 0]);
    let scene = open("square.obj", &[("square.obj", SQUARE.as_bytes())]).unwrap();
    assert!(scene.warnings()[0].contains("square.mtl"), "{:?}", scene.warnings());
}

#[test]
fn no_file_of_the_disk_is_read() {
    let folder = crate::solids::folder(&[("square.mtl", PAINTS.as_bytes()), ("square.obj", SQUARE.as_bytes())]);
    let path = folder.path().join("square.obj");
    let path = path.to_str().unwrap();
    assert!(umbrage_files::open(path).unwrap().warnings().is_empty());
    assert!(open(path, &[("other.obj", SQUARE.as_bytes())]).unwrap_err().starts_with(path));
    assert!(!open(path, &[(path, SQUARE.as_bytes())]).unwrap().warnings().is_empty(), "the library isn't given");
}

#[test]
fn bytes_are_opened_as_a_file_with_them_is() {
    let mut builder = Builder::new();
    let mesh = builder.triangle();
    builder.push("nodes", serde_json::json!({ "mesh": mesh }));
    let glb = builder.glb();
    let folder = crate::solids::folder(&[("a.glb", &glb)]);
    let [given, read] =
        [umbrage_files::open_bytes("a.glb", glb.clone()), umbrage_files::open(folder.path().join("a.glb"))]
            .map(|scene| scene.unwrap().at(0.0).unwrap());
    assert!(!given.positions.is_empty());
    assert_eq!((given.positions, &given.mesh.triangles), (read.positions, &read.mesh.triangles));
    let error = umbrage_files::open_bytes("a.glb", &glb[..glb.len() / 2]).unwrap_err().to_string();
    assert!(error.starts_with("a.glb: "), "{error}");
    let error = umbrage_files::open_bytes("a.fbx", glb).unwrap_err().to_string();
    assert!(error.contains("FBX"), "{error}");
}
