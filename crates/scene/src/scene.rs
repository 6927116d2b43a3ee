use std::convert::Infallible;
use std::path::Path;
use std::sync::Arc;

use glam::Vec3;
use umbrage_rays::{Bounds, LightSource};

use crate::rig::{Pose, Rig};
use crate::{Error, Frame, Light};
use crate::{demo::Demo, gltf::GltfScene, obj, ply, sequence::Sequence, still::Still, stl};

/// Something that has a look at every moment: a file, a sequence of files or a procedural scene.
#[derive(Debug)]
pub struct Scene {
    source: Source,
    animation_bounds: Bounds,
    /// Lights the frames of a file that has no light of its own.
    light_above: Light,
}

#[derive(Debug)]
enum Source {
    Still(Still),
    Gltf(Box<GltfScene>),
    Sequence(Sequence),
    Demo(Demo),
}

/// How a scene is opened.
#[derive(Clone, Debug)]
pub struct OpenOptions {
    /// Which of a file's animations play.
    pub clip: Clip,
    /// How many files of a numbered sequence make a second.
    pub sequence_fps: f64,
}

impl Default for OpenOptions {
    fn default() -> Self {
        Self { clip: Clip::Auto, sequence_fps: 24.0 }
    }
}

/// Which of a file's animations play.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Clip {
    /// All of them where no two move the same thing, else the first.
    #[default]
    Auto,
    /// All of them, the last one winning where two move the same thing.
    All,
    /// None: the file's rest pose.
    Rest,
    /// The one with this name, or else this number, counted from 0.
    Named(String),
}

/// One of a scene's animations.
#[derive(Clone, Debug, PartialEq)]
pub struct Animation {
    /// Its name in the file; may be empty.
    pub name: String,
    /// How long it takes.
    pub seconds: f64,
    /// Whether it is among those that play.
    pub plays: bool,
}

impl Scene {
    /// Opens a scene: a file's path, a sequence's pattern or folder, or `demo:NAME?triangles=N`.
    ///
    /// # Errors
    /// Where the file can't be read, breaks its format or needs something unsupported.
    pub fn open(address: impl AsRef<Path>) -> Result<Self, Error> {
        Self::open_with(address, &OpenOptions::default())
    }

    /// Opens a scene with options.
    ///
    /// # Errors
    /// As [`Scene::open`], and where `options` name a clip that the file doesn't have.
    pub fn open_with(address: impl AsRef<Path>, options: &OpenOptions) -> Result<Self, Error> {
        let source = Source::open(address.as_ref(), options)?;
        let animation_bounds = source.animation_bounds()?;
        Ok(Self { source, animation_bounds, light_above: light_above(animation_bounds) })
    }

    /// The scene at a moment. Moments after the end play the animation again from its start.
    ///
    /// # Errors
    /// Where the moment's file of a numbered sequence can't be read; never for other scenes.
    pub fn at(&self, seconds: f64) -> Result<Frame, Error> {
        let mut frame = Frame::default();
        self.pose(seconds, &mut frame)?;
        Ok(frame)
    }

    /// As [`Scene::at`], in the memory of an earlier frame.
    ///
    /// # Errors
    /// As [`Scene::at`]; `frame` then holds no useful scene.
    pub fn pose(&self, seconds: f64, frame: &mut Frame) -> Result<(), Error> {
        self.pose_with(seconds, frame, |looped, frame| self.source.pose(looped, frame))
    }

    /// As [`Scene::pose`], but for vertices: `pose` is what moves those of the scene's rig, which stays the same, and the
    /// frame has no positions, normals and tangents. [`Rig::pose`] would fill these in.
    ///
    /// `None`, and nothing is done, for scenes that aren't moved by a rig: all but glTF files.
    pub fn pose_rig(&self, seconds: f64, frame: &mut Frame, pose: &mut Pose) -> Option<&Arc<Rig>> {
        let Source::Gltf(scene) = &self.source else { return None };
        let Ok(()) = self.pose_with(seconds, frame, |looped, frame| {
            scene.pose_rig(looped, frame, pose);
            Ok::<(), Infallible>(())
        });
        Some(scene.rig())
    }

    /// Makes a frame of which `pose` fills in what is in the scene's source, at a moment before its end.
    fn pose_with<E>(
        &self,
        seconds: f64,
        frame: &mut Frame,
        pose: impl FnOnce(f64, &mut Frame) -> Result<(), E>,
    ) -> Result<(), E> {
        let duration = self.duration_seconds();
        let looped = if seconds > duration && duration > 0.0 { seconds % duration } else { seconds.max(0.0) };
        frame.lights.clear();
        frame.cameras.clear();
        pose(looped, frame)?;
        frame.seconds = seconds;
        frame.animation_bounds = self.animation_bounds;
        if frame.lights.is_empty() {
            frame.lights.push(self.made_light(frame));
        }
        Ok(())
    }

    /// What lights a frame that has no light of its own: a lamp above and to one side of the whole scene, or beside a
    /// camera that is inside it, where walls would keep the light of that lamp away.
    fn made_light(&self, frame: &Frame) -> Light {
        let mut light = self.light_above.clone();
        let diagonal = self.animation_bounds.size().length();
        let inside = frame.cameras.first().map(|named| named.camera).filter(|camera| {
            let Bounds { min, max } = self.animation_bounds;
            camera.position.cmpge(min).all() && camera.position.cmple(max).all()
        });
        if let Some(camera) = inside {
            let position = camera.position + (camera.up + camera.right * 0.5) * (0.03 * diagonal);
            light.source = LightSource::Point { position };
            light.intensity = intensity_at(0.3 * diagonal);
        }
        light
    }

    /// How long the scene's animation takes before it starts again; zero for a motionless scene.
    #[must_use]
    pub fn duration_seconds(&self) -> f64 {
        self.source.duration_seconds()
    }

    /// The animations that the file holds; empty for scenes that have just one without a name, or none.
    #[must_use]
    pub fn animations(&self) -> &[Animation] {
        match &self.source {
            Source::Gltf(scene) => scene.animations(),
            Source::Still(_) | Source::Sequence(_) | Source::Demo(_) => &[],
        }
    }

    /// What opening the scene left out or guessed, in words.
    #[must_use]
    pub fn warnings(&self) -> &[String] {
        match &self.source {
            Source::Still(still) => &still.warnings,
            Source::Gltf(scene) => scene.warnings(),
            Source::Sequence(sequence) => sequence.warnings(),
            Source::Demo(_) => &[],
        }
    }
}

impl Source {
    fn open(address: &Path, options: &OpenOptions) -> Result<Self, Error> {
        let text = address.to_string_lossy();
        if let Some(demo) = text.strip_prefix("demo:") {
            return Demo::open(demo).map(Self::Demo);
        }
        if let Some(sequence) = Sequence::find(address, options.sequence_fps)? {
            return Ok(Self::Sequence(sequence));
        }
        let extension = address.extension().map(|extension| extension.to_string_lossy().to_ascii_lowercase());
        match extension.as_deref() {
            Some("gltf" | "glb") => GltfScene::open(address, &options.clip).map(|scene| Self::Gltf(Box::new(scene))),
            _ => read_still(address).map(Self::Still),
        }
    }

    fn pose(&self, seconds: f64, frame: &mut Frame) -> Result<(), Error> {
        match self {
            Self::Still(still) => still.pose(frame),
            Self::Gltf(scene) => scene.pose(seconds, frame),
            Self::Sequence(sequence) => sequence.pose(seconds, frame)?,
            Self::Demo(demo) => demo.pose(seconds, frame),
        }
        Ok(())
    }

    fn duration_seconds(&self) -> f64 {
        match self {
            Self::Still(_) => 0.0,
            Self::Gltf(scene) => scene.duration_seconds(),
            Self::Sequence(sequence) => sequence.duration_seconds(),
            Self::Demo(demo) => demo.duration_seconds(),
        }
    }

    /// Bounds over a few moments, which is enough for a view that doesn't cut much off.
    fn animation_bounds(&self) -> Result<Bounds, Error> {
        const MOMENTS: u32 = 5;
        let moments = if self.duration_seconds() > 0.0 { MOMENTS } else { 1 };
        let mut frame = Frame::default();
        let mut bounds = Bounds::EMPTY;
        for moment in 0..moments {
            self.pose(self.duration_seconds() * f64::from(moment) / f64::from(moments), &mut frame)?;
            bounds = bounds.union(frame.triangles().bounds());
        }
        Ok(bounds)
    }
}

/// Reads a file whose triangles don't move.
pub(crate) fn read_still(path: &Path) -> Result<Still, Error> {
    let extension = path.extension().map(|extension| extension.to_string_lossy().to_ascii_lowercase());
    match extension.as_deref() {
        Some("obj") => obj::read(path),
        Some("ply") => ply::read(path),
        Some("stl") => stl::read(path),
        other => {
            let what = other.map_or_else(|| "a file without an extension".to_owned(), |name| format!("`.{name}`"));
            Err(Error::unsupported(path, what, "use .gltf, .glb, .obj, .ply, .stl or demo:NAME"))
        }
    }
}

/// A light above and to one side of `bounds`.
fn light_above(bounds: Bounds) -> Light {
    const TOWARDS_LIGHT: Vec3 = Vec3::new(0.45, 1.0, 0.65);
    let radius = (0.5 * bounds.size().length()).clamp(f32::MIN_POSITIVE, f32::MAX);
    let offset = TOWARDS_LIGHT * (2.0 * radius);
    Light {
        name: "made from the bounds".into(),
        source: LightSource::Point { position: bounds.center() + offset },
        color: Vec3::ONE,
        intensity: intensity_at(offset.length()),
        range: None,
        casts_shadow: true,
    }
}

/// The intensity, in candela, that makes a white surface at a distance nearly as bright as a screen can show.
fn intensity_at(distance: f32) -> f32 {
    0.8 * std::f32::consts::PI * distance * distance
}
