//! Numbered files as an animation: which are found, in which order, and when each shows.

use std::path::Path;

use tempfile::TempDir;
use umbrage_files::OpenOptions;
use umbrage_scene::{Frame, Scene};

use crate::solids::{cube_ply_text, cube_stl_binary};

/// A triangle whose first vertex has x = `number`, which identifies the file of a frame.
fn numbered_obj(number: usize) -> String {
    format!("v {number} 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
}

/// A folder of OBJ files with these names, each numbered by its index in the list.
fn folder(names: &[&str]) -> TempDir {
    let folder = TempDir::new().expect("a temporary folder");
    for (number, name) in names.iter().enumerate() {
        std::fs::write(folder.path().join(name), numbered_obj(number)).expect("room for a file");
    }
    folder
}

fn open(path: impl AsRef<Path>, fps: f64) -> Result<Scene, String> {
    umbrage_files::open_with(path, &OpenOptions { sequence_fps: fps, ..OpenOptions::default() })
        .map_err(|error| error.to_string())
}

/// The numbers of the files in display order, found by frame times.
fn order(scene: &Scene, fps: f64) -> Vec<usize> {
    let count = (scene.duration_seconds() * fps).round() as usize;
    (0..count).map(|place| number(scene, place as f64 / fps)).collect()
}

fn number(scene: &Scene, seconds: f64) -> usize {
    scene.at(seconds).expect("a readable file").positions[0].x as usize
}

#[test]
fn a_printf_pattern_finds_its_files_in_the_order_of_their_numbers() {
    let folder = folder(&["a_0010.obj", "a_0009.obj", "a_011.obj", "a_0011.obj", "b_0012.obj", "a_0012.txt"]);
    let scene = open(folder.path().join("a_%04d.obj"), 24.0).unwrap();
    assert_eq!(order(&scene, 24.0), [1, 0, 3]);
    assert_eq!(scene.warnings(), [""; 0]);
}

#[test]
fn a_pattern_without_width_counts_as_a_person_does() {
    let folder = folder(&["10.obj", "9.obj", "1.obj", "010.obj"]);
    let scene = open(folder.path().join("%d.obj"), 10.0).unwrap();
    assert_eq!(order(&scene, 10.0), [2, 1, 0]);
    assert_eq!(scene.warnings().len(), 1);
    let warning = &scene.warnings()[0];
    assert!(warning.contains("7 numbers have no file, the first being 2"), "{warning}");
}

#[test]
fn wildcards_find_files_in_natural_order() {
    let folder = folder(&["a10.obj", "a9.obj", "b1.obj", "a9.txt"]);
    let scene = open(folder.path().join("a*"), 24.0).unwrap();
    assert_eq!(order(&scene, 24.0), [1, 0]);
    let scene = open(folder.path().join("?9.obj"), 24.0).unwrap();
    assert_eq!(order(&scene, 24.0), [1]);
    let scene = open(folder.path().join("*.obj"), 24.0).unwrap();
    assert_eq!(order(&scene, 24.0), [1, 0, 2]);
    assert!(scene.warnings()[0].contains("differ in more than one number"), "{:?}", scene.warnings());
}

#[test]
fn patterns_match_what_printf_writes_and_what_wildcards_mean() {
    let stars = format!("{}b", "*a".repeat(50));
    let long = format!("{}.obj", "a".repeat(200));
    for (pattern, name, matches) in [
        ("a_%04d.obj", "a_12345.obj", true),
        ("a_%04d.obj", "a_007.obj", false),
        ("a_%04d.obj", "a_00007.obj", false),
        ("%d.obj", "0.obj", true),
        ("%d.obj", "042.obj", false),
        ("%d.obj", "+4.obj", false),
        // Prefix and suffix may not share characters.
        ("ab%db.obj", "ab.obj", false),
        ("a*.obj", "a.obj", true),
        ("a*.obj", "b_12.obj", false),
        ("a?.obj", "a1.obj", true),
        ("a?.obj", "a12.obj", false),
        ("*a*b*", "xxaxxbxx.obj", true),
        ("*a*b", "xxaxxbxx.obj", false),
        ("é?.obj", "éü.obj", true),
        // The time must not grow with the stars' combinations.
        (stars.as_str(), long.as_str(), false),
    ] {
        let folder = folder(&[name]);
        assert_eq!(open(folder.path().join(pattern), 24.0).is_ok(), matches, "{pattern} {name}");
    }
}

#[test]
fn names_are_ordered_as_a_person_counts() {
    let folder =
        folder(&["a10.obj", "a9.obj", "b1.obj", "a010.obj", "a9b.obj", "a99999999999999999999999.obj", "é1.obj"]);
    let scene = open(folder.path().join("*.obj"), 1.0).unwrap();
    assert_eq!(order(&scene, 1.0), [1, 4, 3, 0, 5, 2, 6]);
}

#[test]
fn a_folder_shows_its_largest_family_and_says_what_it_left_out() {
    let folder =
        folder(&["run_3_v2.obj", "run_1_v2.obj", "walk_1.obj", "walk_2.obj", "run_2_v2.obj", "hat.obj", "notes.txt"]);
    let scene = open(folder.path(), 24.0).unwrap();
    assert_eq!(order(&scene, 24.0), [1, 4, 0]);
    let [warning] = scene.warnings() else { panic!("{:?}", scene.warnings()) };
    assert!(warning.contains("left out 3 files") && warning.contains("hat.obj"), "{warning}");
}

#[test]
fn two_files_with_the_same_number_both_show() {
    let folder = folder(&["a1.obj", "a01.obj", "a2.obj"]);
    let scene = open(folder.path(), 24.0).unwrap();
    assert_eq!(order(&scene, 24.0), [1, 0, 2]);
    assert!(scene.warnings()[0].contains("the number 1 has more than one file"), "{:?}", scene.warnings());
}

#[test]
fn frame_k_shows_from_its_start_to_the_next_one_for_any_frequency() {
    let names: Vec<String> = (0..50).map(|number| format!("{number}.obj")).collect();
    let folder = folder(&names.iter().map(String::as_str).collect::<Vec<_>>());
    for fps in [1.0, 24.0, 29.97, 49.0, 60.0, 0.1] {
        let scene = open(folder.path(), fps).unwrap();
        assert!((scene.duration_seconds() - 50.0 / fps).abs() < 1e-9);
        assert_eq!(order(&scene, fps), (0..50).collect::<Vec<_>>(), "{fps}");
        for (seconds, expected) in [(-1.0, 0), (0.999 / fps, 0), (1.5 / fps, 1), (49.999 / fps, 49), (50.5 / fps, 0)] {
            assert_eq!(number(&scene, seconds), expected, "{seconds} s at {fps}");
        }
        // The very end is still the last frame, and one turn later everything is the same.
        assert_eq!(number(&scene, scene.duration_seconds()), 49);
    }
}

#[test]
fn each_file_has_its_own_shape_and_format_and_is_read_when_its_moment_comes() {
    let folder = folder(&["a1.obj", "a2.obj", "a3.obj"]);
    std::fs::write(folder.path().join("b1.ply"), cube_ply_text()).unwrap();
    std::fs::write(folder.path().join("b2.stl"), cube_stl_binary()).unwrap();
    let scene = open(folder.path().join("?*"), 1.0).unwrap();
    let mut frame = Frame::default();
    let mut triangles = |seconds: f64| {
        scene.pose(seconds, &mut frame).unwrap();
        frame.mesh.triangles.len()
    };
    assert_eq!([0.0, 3.0, 4.0, 1.0].map(&mut triangles), [1, 12, 12, 1]);

    std::fs::write(folder.path().join("a3.obj"), "v 0 0\n").unwrap();
    let error = scene.at(2.5).unwrap_err().to_string();
    assert!(error.contains("a3.obj: line 1"), "{error}");
    // A fault passes: the next moment is posed as usual.
    assert_eq!(number(&scene, 1.5), 1);
    std::fs::write(folder.path().join("a3.obj"), numbered_obj(7)).unwrap();
    assert_eq!(number(&scene, 2.5), 7);
}

#[test]
fn the_last_two_files_are_kept() {
    let folder = folder(&["1.obj", "2.obj", "3.obj"]);
    let scene = open(folder.path(), 1.0).unwrap();
    assert_eq!((number(&scene, 0.0), number(&scene, 1.0)), (0, 1));
    for name in ["1.obj", "2.obj", "3.obj"] {
        std::fs::remove_file(folder.path().join(name)).unwrap();
    }
    assert_eq!((number(&scene, 0.0), number(&scene, 1.0), number(&scene, 0.5)), (0, 1, 0));
    assert!(scene.at(2.0).unwrap_err().to_string().contains("3.obj"));
}

#[test]
fn materials_and_textures_are_read_once_for_all_frames() {
    let folder = TempDir::new().unwrap();
    std::fs::write(folder.path().join("a.mtl"), "newmtl red\nKd 1 0 0\n").unwrap();
    for number in 0..3 {
        let text = format!("mtllib a.mtl\nusemtl red\n{}", numbered_obj(number));
        std::fs::write(folder.path().join(format!("{number}.obj")), text).unwrap();
    }
    let scene = open(folder.path(), 1.0).unwrap();
    let (first, last) = (scene.at(0.0).unwrap(), scene.at(2.0).unwrap());
    assert_eq!(first.materials.materials[0].base_color.x, 1.0);
    assert!(std::sync::Arc::ptr_eq(&first.materials, &last.materials));
}

#[test]
fn the_first_file_speaks_for_the_others() {
    let folder = folder(&["1.obj"]);
    std::fs::write(folder.path().join("0.obj"), numbered_obj(0) + "curv 0 1\n").unwrap();
    let scene = open(folder.path(), 1.0).unwrap();
    assert!(scene.warnings()[0].contains("0.obj: left out 1 unknown statements"), "{:?}", scene.warnings());
}

#[test]
fn a_file_whose_name_looks_like_a_pattern_is_that_file() {
    let folder = folder(&["100%d.obj", "1001.obj"]);
    let scene = open(folder.path().join("100%d.obj"), 1.0).unwrap();
    assert_eq!((scene.duration_seconds(), number(&scene, 0.0)), (0.0, 0));
}

#[test]
fn addresses_without_a_sequence_say_what_was_looked_for() {
    let empty = TempDir::new().unwrap();
    let unnumbered = folder(&["hat.obj", "notes.txt"]);
    let numbered = folder(&["1.obj"]);
    let uncountable = folder(&["99999999999999999999999.obj"]);
    let gltf = folder(&["a1.glb", "a2.glb"]);
    let broken = TempDir::new().unwrap();
    std::fs::write(broken.path().join("1.ply"), "no").unwrap();
    for (path, fps, expected) in [
        (empty.path().to_owned(), 24.0, "looked for numbered .obj, .ply or .stl files"),
        (unnumbered.path().to_owned(), 24.0, "open `hat.obj`"),
        (numbered.path().join("b%d.obj"), 24.0, "matches no .obj, .ply or .stl file"),
        (numbered.path().join("*.txt"), 24.0, "matches no .obj, .ply or .stl file"),
        (numbered.path().join("%x.obj"), 24.0, "after `%`, write `d`"),
        (numbered.path().join("a%4d.obj"), 24.0, "with a zero before it"),
        (numbered.path().join("%099999999999999999999d.obj"), 24.0, "a width of up to 20 digits"),
        (numbered.path().join("%d%d.obj"), 24.0, "a pattern has one `%d`"),
        (numbered.path().join("*%d.obj"), 24.0, "a pattern has one `%d`"),
        (numbered.path().join("%d?.obj"), 24.0, "a pattern has one `%d`"),
        (uncountable.path().to_owned(), 24.0, "no file of the folder has a number"),
        (numbered.path().join("no/%d.obj"), 24.0, "there is no folder"),
        (numbered.path().join("*/1*.obj"), 24.0, "wildcards may only be in the file's name"),
        (numbered.path().to_owned(), 0.0, "give a number above 0"),
        (numbered.path().to_owned(), -24.0, "give a number above 0"),
        (numbered.path().to_owned(), f64::NAN, "give a number above 0"),
        (numbered.path().to_owned(), f64::INFINITY, "give a number above 0"),
        (gltf.path().to_owned(), 24.0, "glTF in a sequence of files is not supported"),
        (gltf.path().join("a%d.glb"), 24.0, "glTF in a sequence of files is not supported"),
        (broken.path().to_owned(), 24.0, "1.ply: line 1: not a PLY file"),
        (numbered.path().join("gone.obj"), 24.0, "gone.obj"),
    ] {
        let error = open(&path, fps).map(|scene| scene.duration_seconds()).unwrap_err();
        assert!(error.contains(expected), "{}: {error}", path.display());
    }
}
