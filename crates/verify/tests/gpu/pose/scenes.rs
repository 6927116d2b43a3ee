//! Real scenes.

use umbrage::Scene;
use umbrage::scene::rig::Pose;
use umbrage::scene::{Clip, Frame, OpenOptions};
use umbrage_verify::real_scene;

use super::compare::Difference;
use super::posing::Posing;
use crate::common::gpu;

fn compare_moments(posing: &mut Posing, scene: &Scene, name: &str) {
    let (mut frame, mut bare, mut pose) = (Frame::default(), Frame::default(), Pose::default());
    let mut sum = Difference::default();
    let mut milliseconds = Vec::new();
    // The last moment is the first again, with all moving vertices back in place.
    for part in [0.0, 0.13, 0.5, 0.77, 0.0] {
        let seconds = part * scene.duration_seconds();
        scene.pose(seconds, &mut frame).unwrap_or_else(|error| panic!("{error}"));
        let rig = scene.pose_rig(seconds, &mut bare, &mut pose).expect("a pose").expect("a rig");
        let posed = posing.pose(&rig, &pose).unwrap_or_else(|error| panic!("{error}"));
        let difference = Difference::between(&frame, &posed);
        difference.expect_rounding(&format!("{name} at {part}"));
        assert_eq!((bare.lights.len(), bare.cameras.len()), (frame.lights.len(), frame.cameras.len()), "{name}");
        assert!(bare.positions.is_empty() && bare.normals.is_empty() && bare.tangents.is_empty(), "{name}");
        sum = Difference {
            normal: sum.normal.max(difference.normal),
            tangent: sum.tangent.max(difference.tangent),
            ..difference
        };
        milliseconds.push(posed.milliseconds);
    }
    println!("{name}: {sum:?} {milliseconds:.2?} ms");
}

/// Tests that take long, which `cargo run -p ci` runs with `--all` alone.
mod long {
    use super::*;

    #[test]
    fn real_scenes_are_posed_alike() {
        let Some(gpu) = gpu() else { return };
        let mut posing = Posing::new(gpu);
        let names = [
            "cesium_man.glb",
            "robot_expressive.glb",
            "robot_arm.glb",
            "vintage_fan.glb",
            "elephant_gallop.glb",
            "chess_board.glb",
            "issum.glb",
            "dispersion_test.glb",
            "conformance/Fox.glb",
            "conformance/BoxAnimated.glb",
            "conformance/RiggedSimple.glb",
            "conformance/SimpleSkin.gltf",
            "conformance/AnimatedMorphCube.glb",
            "conformance/AnimatedMorphSphere/AnimatedMorphSphere.gltf",
            "conformance/SimpleMorph/SimpleMorph.gltf",
            "conformance/MorphPrimitivesTest/MorphPrimitivesTest.gltf",
            "conformance/MorphStressTest.glb",
            "conformance/InterpolationTest.glb",
            "conformance/TransmissionRoughnessTest.glb",
        ];
        for name in names {
            let Some(path) = real_scene(name) else { continue };
            let clips = umbrage::open(&path).unwrap_or_else(|error| panic!("{error}")).animations().len();
            for clip in 0..clips.max(1) {
                let clip = if clips == 0 { Clip::Rest } else { Clip::Named(clip.to_string()) };
                let options = OpenOptions { clip, ..OpenOptions::default() };
                let scene = umbrage::open_with(&path, &options).unwrap_or_else(|error| panic!("{error}"));
                compare_moments(&mut posing, &scene, &format!("{name}, {:?}", options.clip));
            }
        }
    }
}
