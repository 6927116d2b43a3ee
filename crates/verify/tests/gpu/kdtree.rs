//! The GPU's kd-tree shows the CPU's triangles and shadows, as the GPU's grids do.

use std::sync::Arc;
use std::sync::atomic::AtomicUsize;
use std::sync::atomic::Ordering::Relaxed;

use glam::{Vec3, Vec4};
use umbrage::gallery::DEMOS;
use umbrage::gpu::{Finder, Gpu, MakeFinder};
use umbrage::rays::{Camera, LightSource, Projection, SimdLevel};
use umbrage::scene::{Alpha, ColorSpace, Filter, Frame, Light, Material, Materials, Texture, TextureUse, Wrap};
use umbrage::{Error, GpuStructure, Renderer, Settings, Sides, Structure, StructureKind};
use umbrage_papers::{KdPacketOptions, KdPacketWidth, KdTraversal, KdTreeOptions, KdTrees, structures};
use umbrage_verify::{Differences, Random, real_scene};

use crate::common::{renderer, small_renderer};
use crate::frames::{compare, sized};

/// A kd-tree with another traversal for each number.
fn kd_tree(number: usize) -> Structure {
    let traversals = [KdTraversal::Stack, KdTraversal::ShortStack(3), KdTraversal::Restart, KdTraversal::PushDown];
    let widths = [KdPacketWidth::Sixteen, KdPacketWidth::Four, KdPacketWidth::Eight];
    let packets = KdPacketOptions { width: widths[number % 3], ..KdPacketOptions::DEFAULT };
    let options = KdTreeOptions { traversal: traversals[number % 4], packets, ..KdTreeOptions::FAST };
    Structure::new(KdTrees { options, ..KdTrees::default() })
}

fn with_tree(width: u32, height: u32) -> Settings {
    Settings { structure: Structure::of::<KdTrees>(), ..sized(width, height) }
}

#[test]
fn spots_and_several_lights() {
    let Some(mut gpu) = renderer() else { return };
    let scene = umbrage::open("demo:forest?triangles=3000").expect("a scene of the gallery");
    let middle = scene.at(0.0).expect("a frame").triangles().bounds().center();
    let light = |source, casts_shadow| Light { casts_shadow, ..Light::new(source, 20.0) };
    let position = middle + Vec3::new(0.4, 3.0, 0.7);
    let direction = (middle - position).normalize();
    let spot =
        |outer_radians| LightSource::Spot { position, direction, inner_radians: 0.5 * outer_radians, outer_radians };
    let sun = LightSource::Directional { direction: Vec3::new(0.3, -0.9, 0.2).normalize() };
    for lights in [
        vec![],
        vec![light(spot(0.2), true)],
        vec![light(sun, true), light(spot(0.9), true), light(LightSource::Point { position: middle }, true)],
        vec![light(sun, false), light(spot(0.3), false), light(LightSource::Point { position }, true)],
    ] {
        for sides in [Sides::Front, Sides::Both] {
            let settings = Settings { lights: Some(lights.clone()), sides, ..with_tree(60, 40) };
            compare("lights", &mut gpu, &scene, 0.0, &settings).expect_none(&format!("{lights:?}, {sides}"));
        }
    }
}

/// A cloud of triangles, some of them masked, one-sided or transparent.
fn cloud() -> Frame {
    let mut random = Random::new(7);
    let mut number = || random.below(2001) as f32 / 1000.0 - 1.0;
    let (mut positions, mut colors) = (Vec::new(), Vec::new());
    for _ in 0..400 {
        let middle = Vec3::new(number(), number(), number());
        for _ in 0..3 {
            positions.push(middle + 0.4 * Vec3::new(number(), number(), number()));
            colors.push(Vec4::new(0.9, 0.8, 0.7, 0.5 + 0.5 * number()));
        }
    }
    let texels = (0..64).map(|_| [200, 150, 100, random.below(256) as u8]).collect();
    let texture = Texture::new("holes", [8; 2], texels, ColorSpace::Srgb, Filter::Linear, [Wrap::Repeat; 2]);
    let material = |alpha, double_sided| Material { alpha, double_sided, ..Material::clay() };
    let holes = Some(TextureUse::new(0));
    let materials = vec![
        material(Alpha::Opaque, false),
        material(Alpha::Mask { cutoff: 0.5 }, true),
        Material { base_color_texture: holes, ..material(Alpha::Mask { cutoff: 0.2 }, false) },
        material(Alpha::Blend, true),
    ];
    let mut frame = Frame::from_triangles(positions, (0..400).map(|id| [3 * id, 3 * id + 1, 3 * id + 2]).collect());
    let mesh = Arc::make_mut(&mut frame.mesh);
    mesh.material_of_triangle = (0..400).map(|id| id % 4).collect();
    mesh.tex_coords[0] = frame.positions.iter().map(|position| position.truncate()).collect();
    mesh.colors = colors;
    frame.materials = Arc::new(Materials { materials, textures: vec![texture] });
    frame
}

#[test]
fn masks_sides_and_layers() {
    let Some(mut gpu) = renderer() else { return };
    let (frame, mut cpu) = (cloud(), Renderer::default());
    let light = |source| Light::new(source, 20.0);
    let sun = light(LightSource::Directional { direction: Vec3::new(0.3, -0.9, 0.2).normalize() });
    let lamp = light(LightSource::Point { position: Vec3::new(0.1, 0.2, 2.0) });
    for number in 0..3 {
        let lights = Some(vec![sun.clone(), lamp.clone()]);
        let settings = Settings { lights, structure: kd_tree(number), ..sized(60, 40) };
        for renderer in [&mut cpu, &mut *gpu] {
            renderer.render_frame(&frame, &settings).expect("a frame");
        }
        Differences::between(&cpu, &gpu, &settings).expect_none(&settings.structure.to_string());
    }
}

#[test]
fn nothing_and_much() {
    if let Some(mut gpu) = renderer() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("nothing.obj");
        std::fs::write(&path, "# nothing\n").expect("a file");
        let scene = umbrage::open(&path).expect("a scene");
        compare("nothing", &mut gpu, &scene, 0.0, &with_tree(70, 40)).expect_none("nothing");
    }
    // 100 columns make 128 · 96 bytes for each row: bands of 64 rows.
    let Some(mut gpu) = small_renderer() else { return };
    for name in ["shatter", "glass"] {
        let scene = umbrage::open(format!("demo:{name}?triangles=2000")).expect("a scene of the gallery");
        let settings = with_tree(100, 70);
        compare(name, &mut gpu, &scene, 0.3, &settings).expect_none(name);
    }
}

#[test]
fn what_a_gpu_would_ignore_is_refused() {
    let Some(mut gpu) = renderer() else { return };
    let scene = umbrage::open("demo:cloth?triangles=500").expect("a scene of the gallery");
    for option in ["lazy=64", "mailbox=ring"] {
        let structure = structures().parse(&format!("kdtree:{option}")).expect("a structure");
        let error = gpu.render(&scene, 0.0, &Settings { structure, ..sized(20, 20) }).expect_err("refused");
        assert!(error.is_of_settings() && error.to_string().contains(&option[..4]), "{error}");
    }
}

/// The kd-tree, whose finders are counted as they are made.
#[derive(Clone, Debug, Default, PartialEq)]
struct Counted(KdTrees);

static MADE: AtomicUsize = AtomicUsize::new(0);

impl StructureKind for Counted {
    const NAME: &'static str = "counted";
    const ABOUT: &'static str = "a kd-tree";

    fn make(&self, level: SimdLevel, onward: bool) -> Result<Box<dyn umbrage::rays::Structure>, Error> {
        self.0.make(level, onward)
    }

    fn on_gpu(&self) -> Result<Option<GpuStructure>, Error> {
        Ok(Some(GpuStructure::with_finder(self.clone())))
    }
}

impl MakeFinder for Counted {
    fn make(&self, gpu: &Gpu) -> Box<dyn Finder> {
        MADE.fetch_add(1, Relaxed);
        self.0.options.make(gpu)
    }

    fn set_options(&self, gpu: &Gpu, finder: &mut dyn Finder) -> bool {
        self.0.options.set_options(gpu, finder)
    }
}

#[test]
fn a_finder_is_made_once_for_all_options() {
    let Some(mut gpu) = renderer() else { return };
    let scene = umbrage::open("demo:cloth?triangles=500").expect("a scene of the gallery");
    let counted = |number| kd_tree(number).kind().map(|trees: &KdTrees| Structure::new(Counted(trees.clone())));
    for (name, structure) in [("a tree", counted(0)), ("grids", None), ("with other options", counted(1))] {
        let settings = Settings { structure: structure.unwrap_or_default(), ..sized(20, 20) };
        compare(name, &mut gpu, &scene, 0.0, &settings).expect_none(name);
    }
    // Another test's renderer may have one already.
    assert!(MADE.load(Relaxed) <= 1, "{MADE:?} finders");
}

/// Tests that take long, which `cargo run -p ci` runs with `--all` alone.
mod long {
    use super::*;

    #[test]
    fn gallery_scenes() {
        let Some(mut gpu) = renderer() else { return };
        for (number, demo) in DEMOS.iter().enumerate() {
            let scene = umbrage::open(format!("demo:{}?triangles=2000", demo.name)).expect("a scene of the gallery");
            let settings = Settings { structure: kd_tree(number), ..sized(60, 40) };
            compare(demo.name, &mut gpu, &scene, 0.4, &settings).expect_none(demo.name);
        }
    }

    /// Skins, morph targets, masks, textures, transparent layers, and sides.
    #[test]
    fn real_scenes() {
        let Some(mut gpu) = renderer() else { return };
        let names =
            ["cesium_man.glb", "robot_expressive.glb", "tree_alphamask.glb", "sibenik.obj", "dispersion_test.glb"];
        for (number, name) in names.into_iter().enumerate() {
            if let Some(path) = real_scene(name) {
                let scene = umbrage::open(&path).unwrap_or_else(|error| panic!("{error}"));
                let settings = Settings { structure: kd_tree(number), ..sized(60, 40) };
                compare(name, &mut gpu, &scene, 0.3, &settings).expect_none(name);
            }
        }
    }

    #[test]
    fn samples_sides_and_views() {
        let Some(mut gpu) = renderer() else { return };
        let scene = umbrage::open("demo:shatter?triangles=3000").expect("a scene of the gallery");
        let camera = scene.at(0.5).expect("a frame").framing_camera(1.5);
        let parallel = Camera { projection: Projection::Orthographic { half_height: 1.5 }, ..camera };
        for (name, settings) in [
            ("three samples", Settings { samples: 2, ..with_tree(60, 40) }),
            ("front faces alone", Settings { sides: Sides::Front, ..with_tree(60, 40) }),
            ("both sides", Settings { sides: Sides::Both, ..with_tree(60, 40) }),
            ("a parallel view", Settings { camera: parallel.into(), ..with_tree(60, 40) }),
            ("one pixel", with_tree(1, 1)),
            ("the grids again", sized(60, 40)),
            ("the tree again", with_tree(60, 40)),
        ] {
            compare(name, &mut gpu, &scene, 0.5, &settings).expect_none(name);
        }
    }
}
