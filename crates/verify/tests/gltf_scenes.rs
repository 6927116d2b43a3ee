//! Real glTF files: what they hold, and that their animations stay sane.

use std::time::Instant;

use glam::Vec3;
use umbrage_rays::Bounds;
use umbrage_scene::{Clip, Frame, OpenOptions, Scene};
use umbrage_verify::real_scene;

/// File, triangles, cameras, animations.
const SCENES: [(&str, usize, usize, usize); 29] = [
    ("country_kitchen.glb", 1_021_815, 1, 0),
    ("dream_apartment.glb", 177_934, 0, 0),
    ("issum.glb", 192_286, 0, 0),
    ("chess_board.glb", 178_848, 0, 0),
    ("elephant_gallop.glb", 84_638, 0, 1),
    ("robot_arm.glb", 9_760, 0, 1),
    ("vintage_fan.glb", 21_080, 0, 4),
    ("robot_expressive.glb", 3_237, 0, 14),
    ("cesium_man.glb", 4_672, 0, 1),
    ("dispersion_test.glb", 51_827, 0, 0),
    ("tree_alphamask.glb", 4_222, 0, 0),
    ("conformance/AnimatedMorphCube.glb", 12, 0, 1),
    ("conformance/AnimatedMorphSphere/AnimatedMorphSphere.gltf", 0, 0, 1),
    ("conformance/AttenuationTest.glb", 0, 0, 0),
    ("conformance/BoxAnimated.glb", 0, 0, 1),
    ("conformance/Cameras.gltf", 2, 2, 0),
    ("conformance/Cubes_pointlight.glb", 0, 0, 0),
    ("conformance/Fox.glb", 0, 0, 3),
    ("conformance/InterpolationTest.glb", 0, 0, 9),
    ("conformance/MorphPrimitivesTest/MorphPrimitivesTest.gltf", 0, 0, 0),
    ("conformance/MorphStressTest.glb", 0, 0, 3),
    ("conformance/RiggedSimple.glb", 0, 0, 1),
    ("conformance/SimpleMorph/SimpleMorph.gltf", 1, 0, 1),
    ("conformance/SimpleSkin.gltf", 8, 0, 1),
    ("conformance/TransmissionRoughnessTest.glb", 0, 0, 0),
    ("conformance/cornellBox.glb", 0, 0, 0),
    ("teapots_galore/TeapotsGalore.gltf", 7_656_770, 1, 0),
    ("teapots_galore/TeapotsGalore_nodes.gltf", 7_656_770, 1, 0),
    ("x", 0, 0, 0),
];

#[test]
fn survey() {
    for (name, triangles, cameras, animations) in SCENES {
        let Some(path) = real_scene(name) else { continue };
        let start = Instant::now();
        let scene = Scene::open(&path).unwrap();
        let opened = start.elapsed();
        let mut frame = scene.at(0.0).unwrap();
        let start = Instant::now();
        scene.pose(0.3, &mut frame).unwrap();
        let posed = start.elapsed();
        let bounds = frame.triangles().bounds();
        println!(
            "{name}: {} of {triangles} tris, {} verts, {} cams of {cameras}, {} anims of {animations}, {} lights, {} materials {} textures, {:?} {:?} s; open {opened:?} pose {posed:?} n{} t{} uv{} c{}; {:?}",
            frame.mesh.triangles.len(),
            frame.positions.len(),
            frame.cameras.len(),
            scene.animations().len(),
            frame.lights.len(),
            frame.materials.materials.len(),
            frame.materials.textures.len(),
            bounds,
            scene.duration_seconds(),
            frame.normals.len(),
            frame.tangents.len(),
            frame.mesh.tex_coords[0].len(),
            frame.mesh.colors.len(),
            scene.warnings(),
        );
    }
}
