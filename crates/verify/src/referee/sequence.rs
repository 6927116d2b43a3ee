//! Compares renderers that are kept over changing frames with the referee.

use std::sync::Arc;

use glam::Vec3;
use rayon::{ThreadPool, ThreadPoolBuilder};
use umbrage::scene::{Frame, Light, Material, Materials, Mesh};
use umbrage::{CameraChoice, OptionValues, Renderer, Settings, Sides, Structure, StructureOption};
use umbrage_papers::structures;
use umbrage_rays::{LightSource, SimdLevel};

use super::{compare, random_case};
use crate::{Case, MIXED_SIDES, Random, TestMesh, Truth};

/// Successive frames: each a structure, and a case that changes the one before.
///
/// The same on every machine. In half of the frames the structure stays.
#[must_use]
pub fn random_sequence(seed: u64) -> Vec<(Structure, Case)> {
    let random = &mut Random::new(seed ^ 0x5e9e_9ce5);
    let mut structure = random_structure(random);
    let mut frames = vec![(structure.clone(), random_case(seed))];
    for number in 0..2 + random.below(5) as u64 {
        let (_, last) = frames.last().expect("a frame");
        let case = changed(random, last, &frames[0].1, seed.wrapping_add(number << 32));
        if random.below(2) == 0 {
            structure = random_structure(random);
        }
        frames.push((structure.clone(), case));
    }
    frames
}

/// A random structure; about every third option has a random value.
///
/// Options that exclude each other may be chosen: a [`Renderer`] refuses these.
pub fn random_structure(random: &mut Random) -> Structure {
    let known = structures();
    let number = random.below(known.iter().len());
    let mut structure = known.iter().nth(number).cloned().unwrap_or_default();
    for option in structure.options() {
        if random.below(3) == 0 {
            // Some values don't go with those set before.
            let _ = structure.set_option(option.name, &random_value(random, option));
        }
    }
    structure
}

fn random_value(random: &mut Random, option: &StructureOption) -> String {
    let one_of = |random: &mut Random, values: &[&str]| values[random.below(values.len())].to_owned();
    let whole = |random: &mut Random, first: u32, last: u32| {
        // The first values, and multiples of 16, the size of ray blocks.
        let number =
            if random.below(2) == 0 { first + random.below(8) as u32 } else { 16 * (1 + random.below(8) as u32) };
        number.clamp(first, last).to_string()
    };
    match &option.values {
        OptionValues::Names(names) => {
            let names: Vec<_> = names().into_iter().map(|(name, _)| name).collect();
            one_of(random, &names)
        }
        OptionValues::Whole(range) | OptionValues::WholeOrAuto(range) => whole(random, *range.start(), *range.end()),
        OptionValues::Rectangle => {
            one_of(random, &["auto", "-30:30:-20:20.5", "-180:180:-180:180", "100:180:-180:-100"])
        }
        OptionValues::Positive => one_of(random, &["0.001", "0.25", "3", "40"]),
        OptionValues::Share => one_of(random, &["0", "0.3", "1"]),
        OptionValues::Switch => one_of(random, &["true", "false"]),
    }
}

/// Another frame after `last`; most differ in one thing.
fn changed(random: &mut Random, last: &Case, first: &Case, seed: u64) -> Case {
    let mut case = copy(last);
    let mesh = &mut case.mesh;
    let vertex = random.below(mesh.positions.len().max(1));
    let what = match random.below(13) {
        0 => "nothing new",
        1 => {
            let amount = 10.0_f32.powi(-(random.below(7) as i32));
            for position in &mut mesh.positions {
                *position += *position * random.point() * amount;
            }
            "all vertices moved"
        }
        2 | 3 => {
            let value = [f32::NAN, f32::INFINITY, -1e38, 0.0][random.below(4)];
            if let Some(position) = mesh.positions.get_mut(vertex) {
                position[random.below(3)] = value;
            }
            "one coordinate changed"
        }
        4 => {
            mesh.positions.fill(Vec3::NAN);
            "all vertices NaN"
        }
        5 => {
            mesh.indices.truncate(random.below(mesh.indices.len().max(1)));
            "fewer triangles"
        }
        6 => {
            mesh.indices.iter_mut().for_each(|corners| corners.reverse());
            "triangles turned around"
        }
        7 => {
            mesh.indices.reverse();
            "triangles in the reverse order"
        }
        8 => {
            case.view.width = 1 + random.below(20) as u32;
            case.view.height = 1 + random.below(20) as u32;
            "another size of the image"
        }
        9 => {
            case.lights = random_case(seed).lights;
            "other lights"
        }
        10 => {
            case.sides = [umbrage_rays::Sides::Both, umbrage_rays::Sides::Front, MIXED_SIDES][random.below(3)];
            "other sides"
        }
        11 => {
            case = random_case(seed);
            "another scene"
        }
        _ => {
            case = copy(first);
            "the first frame again"
        }
    };
    case.name = format!("{}; {what}", case.name);
    case
}

/// Copies a case, which must be opaque.
fn copy(case: &Case) -> Case {
    let mesh = TestMesh { positions: case.mesh.positions.clone(), indices: case.mesh.indices.clone() };
    Case {
        offset_pixels: case.offset_pixels,
        sides: case.sides,
        ..Case::new(case.name.clone(), mesh, case.view, &case.lights)
    }
}

/// A renderer for every SIMD level of the machine, each with threads of its own, kept from frame to frame.
pub struct KeptRenderers {
    renderers: Vec<(SimdLevel, ThreadPool, Renderer)>,
    /// Number of answers so far: for a pixel, or for a point and a light.
    pub answers: u64,
    /// Number of refused frames: with options that exclude each other, or a camera or light that isn't finite.
    pub refused: u64,
}

impl KeptRenderers {
    /// Renderers without a frame.
    ///
    /// # Panics
    /// If the machine can't start threads.
    #[must_use]
    pub fn new() -> Self {
        let renderer = |(number, &level): (usize, &SimdLevel)| {
            let threads = [1, 2, 5][number % 3];
            let pool = ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
            (level, pool, Renderer::with_simd_level(level))
        };
        Self { renderers: SimdLevel::available().iter().enumerate().map(renderer).collect(), answers: 0, refused: 0 }
    }

    /// Compares the next frame of all renderers with its truth; returns the disagreements.
    pub fn disagreements(&mut self, structure: &Structure, case: &Case, truth: &Truth) -> Vec<String> {
        let mut wrong = Vec::new();
        for (level, pool, renderer) in &mut self.renderers {
            match pool.install(|| check_frame(renderer, structure, case, truth)) {
                Ok(true) => self.answers += ((1 + case.lights.len()) * truth.triangle.len()) as u64,
                Ok(false) => self.refused += 1,
                Err(how) => wrong.push(format!("{structure}, {level}, {} threads: {how}", pool.current_num_threads())),
            }
        }
        wrong
    }
}

impl Default for KeptRenderers {
    fn default() -> Self {
        Self::new()
    }
}

/// Renders a case and compares hits and lit points with the truth. Returns false for a case that a renderer refuses:
/// options that exclude each other, or a camera or light that isn't finite.
///
/// # Errors
/// With the first pixel that differs, or why there is no frame.
pub fn check_frame(renderer: &mut Renderer, structure: &Structure, case: &Case, truth: &Truth) -> Result<bool, String> {
    let mut frame = Frame::from_triangles(case.mesh.positions.clone(), case.mesh.indices.clone());
    let of_one_side = Material { double_sided: false, ..Material::clay() };
    frame.materials = Arc::new(Materials { materials: vec![of_one_side, Material::clay()], ..Materials::default() });
    let material_of_triangle = (0..case.mesh.indices.len() as u32).map(|id| case.sides.has_back(id).into()).collect();
    frame.mesh = Arc::new(Mesh { material_of_triangle, ..(*frame.mesh).clone() });
    frame.lights = case.lights.iter().map(|&source| Light::new(source, 1.0)).collect();
    let settings = Settings {
        structure: structure.clone(),
        width: case.view.width,
        height: case.view.height,
        camera: CameraChoice::Own(case.view.camera),
        sides: Sides::File,
        ..Settings::default()
    };
    match renderer.render_frame(&frame, &settings) {
        Ok(_) => compare(case, truth, renderer.seen(), renderer.light_masks()).map(|()| true),
        Err(error) if error.is_of_settings() || !case.lights.iter().all(is_finite) => Ok(false),
        Err(error) => Err(error.to_string()),
    }
}

fn is_finite(light: &LightSource) -> bool {
    match *light {
        LightSource::Point { position } => position.is_finite(),
        LightSource::Spot { position, direction, .. } => position.is_finite() && direction.is_finite(),
        LightSource::Directional { direction } => direction.is_finite(),
    }
}
