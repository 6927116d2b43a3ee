//! Real OBJ scenes, read whole.

use glam::Vec3;
use umbrage::scene::OpenOptions;
use umbrage_verify::real_scene;

#[test]
fn files_sibenik_has_all_triangles_and_normals() {
    let Some(path) = real_scene("sibenik.obj") else { return };
    let scene = umbrage::open(path).unwrap();
    let frame = scene.at(0.0).unwrap();
    assert_eq!(frame.mesh.triangles.len(), 80_479);
    assert_eq!(frame.mesh.material_of_triangle.len(), 80_479);
    assert!(frame.positions.len() <= 79_596, "{}", frame.positions.len());
    assert_eq!(frame.normals.len(), frame.positions.len());
    // The file itself gives 1,504 vertices a zero normal.
    let zero = frame.normals.iter().filter(|normal| **normal == Vec3::ZERO).count();
    assert_eq!(zero, 1_504);
    assert!(frame.normals.iter().all(|normal| *normal == Vec3::ZERO || normal.is_normalized()));
    // Its materials are named, but it has no material library.
    assert_eq!(scene.warnings().len(), 1, "{:?}", scene.warnings());
    // One triangle more has no area, but three different corners.
    assert_eq!(frame.triangles().omitted().zero_area.count, 3_830);
}

#[test]
fn files_bunny_keeps_its_shared_vertices() {
    let Some(path) = real_scene("stanford_bunny.obj") else { return };
    let flat = OpenOptions { crease_degrees: 0.0, ..OpenOptions::default() };
    let scene = umbrage::open_with(&path, &flat).unwrap();
    let frame = scene.at(0.0).unwrap();
    assert_eq!(frame.mesh.triangles.len(), 69_451);
    // The scan has 1,113 vertices that no face uses.
    assert_eq!(frame.positions.len(), 35_947 - 1_113);
    assert!(frame.normals.is_empty());
    assert_eq!(scene.warnings(), [""; 0]);
    // Smoothed, hardly any vertex is at a crease.
    let smooth = umbrage::open(path).unwrap().at(0.0).unwrap();
    assert_eq!(smooth.normals.len(), smooth.positions.len());
    assert!((34_834..36_000).contains(&smooth.positions.len()), "{} vertices", smooth.positions.len());
}

#[test]
fn files_horse_gallops_through_48_frames() {
    const FPS: f64 = 24.0;
    let Some(path) = real_scene("horse_gallop_obj_sequence") else { return };
    let scene = umbrage::open(path).unwrap();
    assert_eq!(scene.duration_seconds(), 48.0 / FPS);
    assert_eq!(scene.warnings(), [""; 0]);
    let mut last = Vec::new();
    // Every fourth frame: reading all of them takes long without optimisation.
    for place in (0..48).step_by(4) {
        let frame = scene.at(f64::from(place) / FPS).unwrap();
        assert_eq!(frame.mesh.triangles.len(), 16_843, "frame {place}");
        assert_ne!(frame.positions, last, "frame {place}");
        last = frame.positions;
    }
}
