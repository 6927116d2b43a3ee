//! The same question has the same answer: after any earlier frames, on any number of threads, with any instruction set,
//! and by the definitions in exact arithmetic.

use std::collections::HashSet;
use std::hash::{DefaultHasher, Hash as _, Hasher as _};

use anyhow::Result;
use glam::Vec3;
use rayon::ThreadPoolBuilder;
use umbrage::rays::{LightMask, SeenPixels, SimdLevel, Structure};
use umbrage::{Renderer, Settings};
use umbrage_verify::lights::{point, sun};
use umbrage_verify::referee::{self, KeptRenderers, Trial, random_case, random_sequence};
use umbrage_verify::structures::STRUCTURES;
use umbrage_verify::views::{camera, view};
use umbrage_verify::{Case, Random, TestMesh};

use super::rays::number;
use super::surfaces::choices;
use super::{Effort, Finding};

/// A change from one frame to the next.
type Update = fn(&mut Case, &mut Random);

const UPDATES: [(&str, Update); 16] = [
    ("nothing", |_, _| {}),
    ("vertices move", |case, random| case.mesh.positions.iter_mut().for_each(|at| *at += random.point() * 0.02)),
    ("one vertex moves far", |case, random| {
        if let Some(at) = case.mesh.positions.last_mut() {
            *at = random.point() * 1e6;
        }
    }),
    ("all shrinks", |case, _| case.mesh.positions.iter_mut().for_each(|at| *at *= 1e-3)),
    ("all grows", |case, _| case.mesh.positions.iter_mut().for_each(|at| *at *= 10.0)),
    ("fewer triangles", |case, _| case.mesh.indices.truncate(case.mesh.indices.len() / 2)),
    ("more triangles", |case, random| case.mesh.append(&TestMesh::soup(random, 60, 0.01))),
    ("no triangles", |case, _| case.mesh.indices.clear()),
    ("another scene", |case, random| case.mesh = TestMesh::bad_shapes(random)),
    ("other order", |case, _| case.mesh.indices.reverse()),
    ("other windings", |case, _| case.mesh.indices.iter_mut().for_each(|corners| corners.swap(0, 1))),
    ("vertices become NaN", |case, random| {
        let count = case.mesh.positions.len().max(1);
        if let Some(at) = case.mesh.positions.get_mut(random.below(count)) {
            at.x = f32::NAN;
        }
    }),
    ("the camera moves", |case, random| case.view.camera.position += random.point()),
    ("another image size", |case, random| {
        (case.view.width, case.view.height) = (1 + random.below(70) as u32, 1 + random.below(40) as u32);
    }),
    ("the lights move", |case, random| case.lights = vec![point(random.point() * 3.0), sun(0.2, -1.0, random.unit())]),
    ("more and fewer lights", |case, random| case.lights.truncate(random.below(3))),
];

struct Asked {
    structure: Box<dyn Structure>,
    seen: SeenPixels,
    masks: Vec<LightMask>,
}

impl Asked {
    fn new(make: umbrage_verify::structures::Make) -> Self {
        Self { structure: make(SimdLevel::default()), seen: SeenPixels::default(), masks: Vec::new() }
    }

    fn answer(&mut self, case: &Case) -> Result<()> {
        let Self { structure, seen, masks } = self;
        let shot = case.shot();
        structure.build(shot.triangles);
        structure.see(&shot, seen)?;
        masks.resize_with(case.lights.len(), LightMask::default);
        structure.shadow(&shot, seen, &case.lights, masks);
        Ok(())
    }

    fn is_as(&self, other: &Self) -> bool {
        let depths = |asked: &Self| asked.seen.inverse_depth.iter().map(|depth| depth.to_bits()).collect::<Vec<_>>();
        self.seen.triangle == other.seen.triangle && depths(self) == depths(other) && self.masks == other.masks
    }
}

pub(super) fn updates(effort: &Effort) -> Result<Finding> {
    let (mut random, frames) = (effort.random(), effort.of(640).max(16));
    let mut case = Case::new("updates", TestMesh::room(), view(camera(), 40, 30), &[point(Vec3::new(2.0, 3.0, 1.0))]);
    let mut kept: Vec<Asked> = STRUCTURES.iter().map(|&(_, make)| Asked::new(make)).collect();
    let mut wrong = Vec::new();
    for frame in 0..frames {
        // Each once in turn, between others by chance.
        let which = if frame % 2 == 0 { frame as usize / 2 % UPDATES.len() } else { random.below(UPDATES.len()) };
        let (name, update) = UPDATES[which];
        update(&mut case, &mut random);
        if case.mesh.indices.len() > 3000 || frame % 40 == 39 {
            case.mesh = TestMesh::room();
        }
        for (kept, &(structure, make)) in kept.iter_mut().zip(STRUCTURES) {
            let mut fresh = Asked::new(make);
            kept.answer(&case)?;
            fresh.answer(&case)?;
            if !kept.is_as(&fresh) {
                wrong.push(format!("{structure} after \"{name}\""));
            }
        }
    }
    let first = wrong.first().map_or_else(String::new, |first| format!(" The first: {first}."));
    let text = format!(
        "{} of {} answers of structures that were used again and again differ from those of new ones, over {} kinds of changes \
         from frame to frame: {}.{first}",
        wrong.len(),
        number(frames * STRUCTURES.len() as u64),
        UPDATES.len(),
        UPDATES.map(|(name, _)| name).join(", ")
    );
    Ok(Finding::new(wrong.is_empty(), text))
}

pub(super) fn hashes(effort: &Effort) -> Result<Finding> {
    const SCENES: [&str; 4] = ["demo:cloth", "demo:forest", "demo:glass", "demo:shatter"];
    let (triangles, side) = (effort.of(20_000).max(500), effort.side(256, 24));
    let (mut pictures, mut different) = (0, Vec::new());
    for name in SCENES {
        let frame = umbrage::open(format!("{name}?triangles={triangles}"))?.at(0.4)?;
        let mut found = HashSet::new();
        for level in SimdLevel::available() {
            for threads in [1, 2, 3, 8] {
                let pool = ThreadPoolBuilder::new().num_threads(threads).build()?;
                for (_, structure) in choices() {
                    let settings = Settings { width: side, height: side, structure, ..Settings::default() };
                    let mut renderer = Renderer::with_simd_level(level);
                    pool.install(|| renderer.render_frame(&frame, &settings).map(|_| ()))?;
                    found.insert(hash(&renderer));
                    pictures += 1;
                }
            }
        }
        if found.len() != 1 {
            different.push(format!("{name} has {}", found.len()));
        }
    }
    let levels = SimdLevel::available().iter().map(ToString::to_string).collect::<Vec<_>>().join(", ");
    let text = format!(
        "{pictures} pictures of {} scenes, on 1, 2, 3 and 8 threads, by {levels} and through all structures: each scene has one \
         hash of its radiances, triangles and shadows{}.",
        SCENES.len(),
        if different.is_empty() { String::new() } else { format!(", but {}", different.join(", ")) }
    );
    Ok(Finding::new(different.is_empty(), text))
}

/// Hash of every bit of a picture.
fn hash(renderer: &Renderer) -> u64 {
    let mut hasher = DefaultHasher::new();
    let film = renderer.film();
    film.color.iter().for_each(|color| color.to_array().map(f32::to_bits).hash(&mut hasher));
    film.triangle.hash(&mut hasher);
    renderer.light_masks().iter().for_each(|mask| mask.blocks().hash(&mut hasher));
    hasher.finish()
}

pub(super) fn referee(effort: &Effort) -> Result<Finding> {
    let (scenes, mut trial, mut wrong) = (effort.of(5000), Trial::new(), Vec::new());
    for seed in effort.seed..effort.seed + scenes {
        let case = random_case(seed);
        let found = trial.disagreements(&case, &referee::truth(&case));
        wrong.extend(found.first().map(|first| format!("seed {seed}: {first}")));
    }
    let first = wrong.first().map_or_else(String::new, |first| format!(" The first: {first}."));
    let text = format!(
        "{} disagreements with definitions in exact arithmetic that share no code with the predicate, in {} answers about {} \
         random scenes, at scales from 1e-37 to 1e37 and reaches up to 1e9, through {} structures and options, by every \
         instruction set, on 1, 2 and 5 threads.{first}",
        wrong.len(),
        number(trial.answers),
        number(scenes),
        STRUCTURES.len()
    );
    Ok(Finding::new(wrong.is_empty(), text))
}

pub(super) fn kept_renderers(effort: &Effort) -> Result<Finding> {
    let (scenes, mut kept, mut wrong, mut frames) = (effort.of(5000), KeptRenderers::new(), Vec::new(), 0);
    for seed in effort.seed..effort.seed + scenes {
        for (number, (structure, case)) in random_sequence(seed).iter().enumerate() {
            let found = kept.disagreements(structure, case, &referee::truth(case));
            wrong.extend(found.first().map(|first| format!("seed {seed}, frame {number}: {first}")));
            frames += 1;
        }
    }
    let first = wrong.first().map_or_else(String::new, |first| format!(" The first: {first}."));
    let text = format!(
        "{} disagreements with the referee in {} answers about {} frames: {} scenes that change from frame to frame (moved, \
         NaN, fewer triangles or none, turned around, in another order, other images, lights and sides) while renderers are \
         kept, with any structure and options in any combination, by every instruction set.{first}",
        wrong.len(),
        number(kept.answers),
        number(frames),
        number(scenes),
    );
    Ok(Finding::new(wrong.is_empty(), text))
}
