//! Scene files and images, from the corpus of small ones in `crates/verify/corpus`.

use std::fs;
use std::path::Path;

use anyhow::{Context as _, Result, ensure};
use glam::Vec2;
use umbrage::scene::rig::Pose;
use umbrage::scene::{ColorSpace, Filter, Frame, OpenOptions, Scene, Wrap, decode_texture};
use umbrage::{Background, Error, Renderer, Settings};
use umbrage_verify::Random;

use super::{Answer, Target, check_film};
use crate::mutate::{REAL, any, changed_words, mutate};
use crate::worker::Workplace;

/// A file's name and contents.
type Seed = (String, Vec<u8>);

/// Memory budget of readers: below the worker's limit.
const MAX_MEMORY: u64 = 1 << 29;

/// Opens the scene of one or several files within that budget.
fn open(path: &Path) -> Result<Scene, umbrage::scene::Error> {
    umbrage::open_with(path, &OpenOptions { max_memory: MAX_MEMORY, ..OpenOptions::default() })
}

/// The files of one of the corpus's folders, by name.
fn corpus(folder: &str) -> Result<Vec<Seed>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus").join(folder);
    let mut seeds = Vec::new();
    for entry in fs::read_dir(&folder).with_context(|| folder.display().to_string())? {
        let entry = entry?;
        seeds.push((entry.file_name().to_string_lossy().into_owned(), fs::read(entry.path())?));
    }
    seeds.sort();
    Ok(seeds)
}

/// A small picture of a frame.
pub(super) fn render(frame: &Frame, settings: &Settings) -> Result<()> {
    match Renderer::default().render_frame(frame, &Settings { width: 6, height: 5, ..settings.clone() }) {
        // The frame is so large that no camera can see all of it.
        Err(Error::Camera(_)) => Ok(()),
        film => check_film(film?, frame),
    }
}

/// Poses a scene at some moments, and renders it.
fn look_at(random: &mut Random, scene: &Scene) -> Result<()> {
    let (mut frame, mut pose) = (Frame::default(), Pose::default());
    for _ in 0..3 {
        let seconds = match random.below(3) {
            0 => *any(random, &REAL),
            _ => 2.0 * f64::from(random.unit()) * scene.duration_seconds(),
        };
        let is_posed = scene.pose(seconds, &mut frame).is_ok();
        ensure!(!is_posed || seconds.is_finite(), "posed at {seconds} s");
        if is_posed {
            frame.check().with_context(|| format!("at {seconds} s"))?;
        }
        let is_rig_posed = scene.pose_rig(seconds, &mut Frame::default(), &mut pose).is_ok_and(|rig| rig.is_some());
        ensure!(!is_rig_posed || is_posed, "a rig is posed at {seconds} s, but no frame");
    }
    match scene.at(0.0) {
        Ok(frame) if random.below(4) == 0 => render(&frame, &Settings::default()),
        _ => Ok(()),
    }
}

/// The reader of a kind of scene files.
pub(crate) struct Reader {
    seeds: Vec<Seed>,
    /// Indices of the scene files; the others are files that these name.
    scenes: Vec<usize>,
    /// Index of the last changed file, which stays until the next.
    changed: usize,
}

impl Reader {
    pub(crate) fn open(kind: &str, place: &Workplace<'_>) -> Result<Self> {
        let seeds = corpus(kind)?;
        seeds.iter().try_for_each(|(name, bytes)| place.write(name, bytes))?;
        let scenes = (0..seeds.len()).filter(|&seed| seeds[seed].0.ends_with(kind)).collect();
        Ok(Self { seeds, scenes, changed: 0 })
    }
}

impl Target for Reader {
    fn run(&mut self, random: &mut Random, place: &mut Workplace<'_>) -> Result<Answer> {
        let (name, bytes) = &self.seeds[self.changed];
        place.write(name, bytes)?;
        let scene = *any(random, &self.scenes);
        let path = place.folder.join(&self.seeds[scene].0);
        // Sometimes the changed file is one with the same name and another extension.
        let beside = (0..self.seeds.len()).filter(|&seed| seed != scene && random.below(2) == 0);
        let is_its = |&seed: &usize| Path::new(&self.seeds[seed].0).file_stem() == path.file_stem();
        self.changed = beside.filter(is_its).last().unwrap_or(scene);
        let ((name, bytes), (_, other)) = (&self.seeds[self.changed], &self.seeds[*any(random, &self.scenes)]);
        place.write_mutant(name, &mutate(random, name, bytes, other))?;
        match open(&path) {
            Ok(scene) => look_at(random, &scene).map(|()| Answer::Accepted),
            Err(error) => {
                let words = error.to_string();
                let names_file = words.starts_with(&*place.folder.to_string_lossy());
                ensure!(names_file && words.len() < 1_000, "no error for a person: {words}");
                Ok(Answer::Refused)
            }
        }
    }
}

/// Three numbered files, one of them a mutant, and names for the sequence.
pub(crate) struct Sequence {
    seeds: Vec<Seed>,
}

impl Sequence {
    pub(crate) fn open(place: &Workplace<'_>) -> Result<Self> {
        fs::create_dir(place.folder.join("all"))?;
        Ok(Self { seeds: [corpus("ply")?, corpus("stl")?].concat() })
    }
}

impl Target for Sequence {
    fn run(&mut self, random: &mut Random, place: &mut Workplace<'_>) -> Result<Answer> {
        let ((name, bytes), (_, other)) = (any(random, &self.seeds), any(random, &self.seeds));
        let mutant = mutate(random, name, bytes, other);
        place.write_mutant(name, &mutant)?;
        let mutated = random.below(3);
        for (file, number) in ["08", "9", "10"].iter().enumerate() {
            place.write(&format!("all/{number}{name}"), if file == mutated { &mutant } else { bytes })?;
        }
        let pattern = match random.below(3) {
            0 => String::new(),
            1 => format!("%{}d{name}", any(random, &["", "0", "9", "02", "099999999999"])),
            _ => format!("{}{name}", any(random, &["#", "##", "##########################"])),
        };
        let scene = open(&place.folder.join("all").join(pattern));
        let answer = scene.map_or(Ok(Answer::Refused), |scene| look_at(random, &scene).map(|()| Answer::Accepted));
        for number in ["08", "9", "10"] {
            fs::remove_file(place.folder.join(format!("all/{number}{name}")))?;
        }
        answer
    }
}

/// Textures and backgrounds.
pub(crate) struct Images {
    seeds: Vec<Seed>,
}

impl Images {
    pub(crate) fn open() -> Result<Self> {
        Ok(Self { seeds: corpus("images")? })
    }
}

impl Target for Images {
    fn run(&mut self, random: &mut Random, place: &mut Workplace<'_>) -> Result<Answer> {
        let ((name, bytes), (_, other)) = (any(random, &self.seeds), any(random, &self.seeds));
        let mutant = mutate(random, name, bytes, other);
        place.write_mutant(name, &mutant)?;
        let wrap = [*any(random, &[Wrap::Repeat, Wrap::MirroredRepeat, Wrap::ClampToEdge]); 2];
        let filter = *any(random, &[Filter::Linear, Filter::Nearest]);
        let texture = decode_texture("", &mutant, ColorSpace::Srgb, filter, wrap);
        if let Ok(texture) = &texture {
            let coords = Vec2::new(*any(random, &REAL) as f32, random.unit() * 4.0 - 2.0);
            let color = texture.sample(coords, *any(random, &REAL) as f32);
            ensure!(color.is_finite() || !(coords * 1e6).is_finite(), "{color} at {coords}");
        }
        let background = Background::open_within(&place.folder.join(name), MAX_MEMORY);
        let is_accepted = texture.is_ok() || background.is_ok();
        if let Ok(background) = background {
            let nothing = Frame::from_triangles(Vec::new(), Vec::new());
            render(&nothing, &Settings { background, ..Settings::default() })?;
        }
        Ok(if is_accepted { Answer::Accepted } else { Answer::Refused })
    }
}

/// Whole scenes at any moment, and scenes of the gallery by any address.
pub(crate) struct Poses {
    scenes: Vec<Scene>,
}

impl Poses {
    pub(crate) fn open() -> Result<Self> {
        Ok(Self { scenes: scenes()? })
    }
}

/// The scenes of the corpus that move.
pub(super) fn scenes() -> Result<Vec<Scene>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus");
    let files = corpus("glb")?.into_iter().map(|(name, _)| folder.join("glb").join(name));
    let scenes = files.chain([folder.join("gltf/room.gltf")]).map(umbrage::open);
    // Some are refused, as the corpus intends.
    Ok(scenes.filter_map(Result::ok).collect())
}

impl Target for Poses {
    fn run(&mut self, random: &mut Random, _: &mut Workplace<'_>) -> Result<Answer> {
        if random.below(8) > 0 {
            let scene = any(random, &self.scenes);
            return look_at(random, scene).map(|()| Answer::Accepted);
        }
        let mut address = format!("demo:{}?triangles={}", any(random, umbrage::gallery::DEMOS).name, random.below(500));
        if random.below(2) == 0 {
            address = String::from_utf8_lossy(&changed_words(random, address.as_bytes(), b"demo:?=&")).into_owned();
        }
        // Without a number, or with a large one, the scene would be large.
        let number = address.rsplit_once('=').map(|(_, number)| number.parse());
        if number.is_none_or(|number| number.is_ok_and(|number: u64| number > 999)) {
            return Ok(Answer::Refused);
        }
        match umbrage::open(&address) {
            Ok(scene) => look_at(random, &scene).context(address).map(|()| Answer::Accepted),
            Err(_) => Ok(Answer::Refused),
        }
    }
}
