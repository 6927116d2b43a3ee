//! Moving scenes, through kd-trees that outlive a frame.

use umbrage::rays::Choice as _;
use umbrage::scene::Frame;
use umbrage::{Renderer, Scene, Settings, Structure};
use umbrage_papers::{KdMoved, KdRebuild, KdTrees, TwoLevelKdTree};
use umbrage_verify::real_scene;

/// Scenes of the gallery with parts, and files with moving nodes and a skin.
fn scenes() -> Vec<(String, Scene)> {
    let gallery = ["demo:marbles?triangles=4000", "demo:hall?triangles=6000", "demo:gears?triangles=9000"];
    let files = ["vintage_fan.glb", "robot_arm.glb", "cesium_man.glb"].into_iter().filter_map(real_scene);
    let files = files.map(|path| path.to_string_lossy().into_owned());
    let all = gallery.into_iter().map(str::to_owned).chain(files);
    all.map(|address| (address.clone(), umbrage::open(&address).unwrap_or_else(|error| panic!("{error}")))).collect()
}

#[test]
fn every_rebuild_shows_the_same() {
    for (name, scene) in scenes() {
        let settings = |structure| Settings { width: 60, height: 44, structure, bounces: 1, ..Settings::default() };
        let mut direct = Renderer::default();
        let rebuilds = KdRebuild::CHOICES.iter().map(|&(name, rebuild, _)| (name, rebuild, Renderer::default()));
        let mut others: Vec<_> = rebuilds.collect();
        for step in 0..4 {
            let seconds = f64::from(step) / 24.0 + f64::from(step / 3) * 0.4 * scene.duration_seconds();
            let expected =
                direct.render(&scene, seconds, &settings(Structure::default())).expect("a picture").color.clone();
            for (rebuild_name, rebuild, renderer) in &mut others {
                let settings = settings(Structure::new(KdTrees { rebuild: *rebuild, ..KdTrees::default() }));
                let film = renderer.render(&scene, seconds, &settings).expect("a picture");
                assert!(film.color == expected, "{name}, {rebuild_name}, frame {step}");
            }
        }
    }
}

/// The parts of readers and gallery are rigid: one map brings a part back, unless a skin moves it.
#[test]
fn parts_move_as_a_whole() {
    for (name, scene) in scenes() {
        let has_skin = ["cesium_man.glb", "robot_arm.glb"].iter().any(|skinned| name.ends_with(skinned));
        let mut trees = TwoLevelKdTree::new(KdMoved::Transform);
        let mut frame = Frame::default();
        let mut moved = 0;
        for step in 0..4 {
            scene.pose(f64::from(step) * 0.2 * scene.duration_seconds(), &mut frame).expect("a moment");
            trees.update(frame.triangles(), frame.parts());
            let counts = trees.counts();
            let most_rebuilt = match step {
                0 => counts.objects,
                _ => u64::from(has_skin),
            };
            assert!(counts.rebuilt <= most_rebuilt, "{name}, frame {step}: {counts:?}");
            moved = moved.max(counts.moved);
        }
        let least = if name.ends_with("cesium_man.glb") { 0 } else { 2 };
        assert!(moved >= least, "{name}: {moved} objects moved");
    }
}
