use std::fmt::Debug;
use std::mem;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use bytesize::ByteSize;
use glam::Vec3;
use umbrage_rays::{Bounds, Camera, LightSource};

use crate::folder::Files;
use crate::formats::{self, Format};
use crate::gltf::{GltfScene, variants};
use crate::ground::Grounded;
use crate::hidden::Hidden;
use crate::memory::{Budget, DEFAULT_BYTES, Limits};
use crate::rig::{Pose, Rig};
use crate::smooth::{self, FlatTriangles};
use crate::survey::{Survey, begin};
use crate::{Error, Frame, Ground, GroundChoice, Light, foreign};
use crate::{obj, obj::SharedMaterials, ply, point_cache::PointCache, sequence::Sequence, still::Still, stl};

/// Source of a scene's content at every moment: a file's, or your own. [`Scene::new`] makes a scene of it.
pub trait Animated: Debug + Send + Sync {
    /// Duration of the animation, after which it repeats; zero for motionless content.
    fn duration_seconds(&self) -> f64;

    /// The moment of a still picture by default: the middle, unless another one shows more.
    fn still_seconds(&self) -> f64 {
        0.5 * self.duration_seconds()
    }

    /// Fills `frame` for the moment `seconds`, from 0 to [`Animated::duration_seconds`]. Positions, normals, tangents,
    /// mesh and materials still hold an earlier frame's; lights and cameras are empty.
    ///
    /// # Errors
    /// Where the moment can't be posed, as from a file that is gone.
    fn pose(&self, seconds: f64, frame: &mut Frame) -> Result<(), Error>;

    /// Origin of all coordinates, as a point of the world: [`Scene::origin`].
    fn origin(&self) -> [f64; 3] {
        [0.0; 3]
    }

    /// The rig that makes the vertices of all moments, if there is one.
    fn rig(&self) -> Option<&Arc<Rig>> {
        None
    }

    /// As [`Animated::pose`], but leaves the frame without vertices and fills `pose` for the rig. Only called where there
    /// is a rig.
    ///
    /// # Errors
    /// As [`Animated::pose`].
    fn pose_rig(&self, _seconds: f64, _frame: &mut Frame, _pose: &mut Pose) -> Result<(), Error> {
        Ok(())
    }

    /// The animations to choose from; empty where there is just one without a name, or none.
    fn animations(&self) -> &[Animation] {
        &[]
    }

    /// Names of the material variants to choose from ([`OpenOptions::variant`]).
    fn variants(&self) -> &[String] {
        &[]
    }

    /// Messages about content that was left out or guessed.
    fn warnings(&self) -> &[String] {
        &[]
    }
}

/// A scene with content at every moment: a file, a sequence of files or a procedural scene.
#[derive(Debug)]
pub struct Scene {
    source: Arc<dyn Animated>,
    animation_bounds: Bounds,
    /// See [`size`](Self::size).
    size: f32,
    /// Lights the frames of a file that has no light of its own.
    sun: Light,
    /// The names of the objects that its first moment has.
    objects: Vec<Arc<str>>,
    /// Whether its first moment has neither lights nor a floor.
    lacks_floor: bool,
    /// Whether its first moment has points or lines.
    has_marks: bool,
    hidden: Option<Hidden>,
    ground: Option<Grounded>,
    files: Vec<PathBuf>,
}

/// How a scene is opened.
#[derive(Clone, Debug)]
pub struct OpenOptions {
    /// Which of a file's animations play.
    pub clip: Clip,
    /// Which of a file's variants has its materials shown, by name; `None` for the file's default ones.
    pub variant: Option<String>,
    /// Files a second of a numbered sequence, or frames a second of a PC2 point cache; 24 by default.
    pub sequence_fps: f64,
    /// Whether a file may name others outside of its own folder: for files that you trust.
    pub allow_outside: bool,
    /// Maximum memory for opening, in bytes: for all files that are read, and for the data made of them. Allocations that
    /// files ask for are compared with the remainder first. Temporary memory, as much again at worst, isn't counted. Each
    /// file of a sequence has this limit of its own.
    ///
    /// The default is half of the memory that the process may have, or 4 GiB where that isn't known.
    pub max_memory: u64,
    /// Maximum memory for texels at a time, in bytes, at least [`OpenOptions::MIN_TEXTURE_MEMORY`]; `None` for all
    /// texels.
    ///
    /// With a limit, texels are decoded one image at a time into a temporary file, and tiles of 32×32 are loaded when
    /// they are read; colours and masks are the same. The file is in the system's folder for temporary files (`TMPDIR`,
    /// else `/tmp` on Unix), which should be on a disk: some systems have it in memory. Four bytes a tile, a thousandth
    /// of all texels, stay in memory. Each file of a sequence has this limit of its own. A texture counts towards
    /// [`OpenOptions::max_memory`] only while it is made.
    pub texture_memory: Option<u64>,
    /// The names of objects that aren't shown ([`Scene::hiding`]).
    pub hidden: Vec<String>,
    /// Crease angle in degrees, 0 to 180: in files without normals (OBJ, PLY, STL), the surface between neighbouring
    /// triangles is smooth up to this angle; with 0, all triangles are flat. 60 by default.
    pub crease_degrees: f32,
    /// A floor under the scene.
    pub ground: GroundChoice,
}

impl Default for OpenOptions {
    fn default() -> Self {
        Self {
            clip: Clip::Auto,
            variant: None,
            sequence_fps: 24.0,
            allow_outside: false,
            max_memory: *DEFAULT_BYTES,
            texture_memory: None,
            hidden: Vec::new(),
            crease_degrees: smooth::DEFAULT_CREASE_DEGREES,
            ground: GroundChoice::None,
        }
    }
}

impl OpenOptions {
    /// Options for pictures: files that need a ground have one.
    #[must_use]
    pub fn for_pictures() -> Self {
        Self { ground: GroundChoice::Auto, ..Self::default() }
    }

    /// The fewest bytes of texels that may be in memory: fifteen tiles.
    pub const MIN_TEXTURE_MEMORY: u64 = 64 << 10;

    /// # Errors
    /// Where an option is out of its range.
    fn check(&self, address: &Path) -> Result<(), Error> {
        if !(0.0..=180.0).contains(&self.crease_degrees) {
            let cause = format!("creases of {} degrees: give 0 to 180 (--crease)", self.crease_degrees);
            return Err(Error::address(address.display().to_string(), cause));
        }
        let Some(bytes) = self.texture_memory.filter(|&bytes| bytes < Self::MIN_TEXTURE_MEMORY) else { return Ok(()) };
        let [bytes, least] = [bytes, Self::MIN_TEXTURE_MEMORY].map(ByteSize::b);
        let cause = format!("textures in {bytes} of memory: give {least} or more (--texture-memory)");
        Err(Error::address(address.display().to_string(), cause))
    }

    pub(crate) fn limits(&self, files: Files) -> Limits {
        Limits { files, bytes: self.max_memory, texture_bytes: self.texture_memory }
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
    /// Opens a scene: a file's path, or a sequence's pattern or folder.
    ///
    /// # Errors
    /// Where the file can't be read, breaks its format or needs something unsupported.
    pub fn open(address: impl AsRef<Path>) -> Result<Self, Error> {
        Self::open_with(address, &OpenOptions::default())
    }

    /// Opens a scene with options.
    ///
    /// # Errors
    /// As [`Scene::open`], and where `options` name a clip that the file doesn't have or allow less memory than it takes, or
    /// there is no room for textures on demand.
    pub fn open_with(address: impl AsRef<Path>, options: &OpenOptions) -> Result<Self, Error> {
        let address = address.as_ref();
        options.check(address)?;
        match Sequence::find(address, options)? {
            Some(sequence) => {
                let files = sequence.files()?;
                Self::of_source(address, Box::new(sequence), files, options)
            }
            None => Self::open_file(address, Files::OnDisk, options),
        }
    }

    /// Opens a scene from a single file in memory. `name` stands for it in messages, and its extension gives the format.
    /// [`Scene::from_files`] takes several files.
    ///
    /// ```
    /// let triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    /// let scene = umbrage_scene::Scene::from_bytes("triangle.obj", triangle)?;
    /// assert_eq!(scene.at(0.0)?.triangles().len(), 1);
    /// # Ok::<(), umbrage_scene::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`Scene::open`].
    pub fn from_bytes(name: impl AsRef<Path>, bytes: impl Into<Vec<u8>>) -> Result<Self, Error> {
        let name = name.as_ref();
        Self::from_files(name, [(name, bytes)], &OpenOptions::default())
    }

    /// Opens the scene `name`, one of `files`, each a path and its content. A file that the scene names is looked up by
    /// its path, or else by its file name where only one file has it. No other file is read.
    ///
    /// # Errors
    /// As [`Scene::open_with`].
    pub fn from_files<P: Into<PathBuf>, B: Into<Vec<u8>>>(
        name: impl AsRef<Path>,
        files: impl IntoIterator<Item = (P, B)>,
        options: &OpenOptions,
    ) -> Result<Self, Error> {
        options.check(name.as_ref())?;
        let files = Files::given(files.into_iter().map(|(path, bytes)| (path.into(), bytes.into())));
        Self::open_file(name.as_ref(), files, options)
    }

    /// Opens a single file, not a sequence.
    fn open_file(path: &Path, files: Files, options: &OpenOptions) -> Result<Self, Error> {
        let format = Format::of(path);
        let mut shared = SharedMaterials::new(options, files);
        if let Some(Format::Gltf | Format::PointCache) = format {
            let limits = shared.limits.clone();
            let mut read = |budget: &Budget| -> Result<Box<dyn Animated>, Error> {
                Ok(match format {
                    Some(Format::Gltf) => Box::new(GltfScene::open(path, options, budget)?),
                    _ => Box::new(PointCache::read(path, options.sequence_fps, &mut shared, budget)?),
                })
            };
            let (scene, files) = within(path, limits, |budget| Ok((read(budget)?, budget.files())))?;
            return Self::of_source(path, scene, files, options);
        }
        let mut still = read_still(path, &mut shared)?;
        let files = mem::take(&mut still.files);
        Self::of_source(path, Box::new(still), files, options)
    }

    /// Makes a scene of an opened source, with the ground and the hidden objects of `options`.
    fn of_source(
        address: &Path,
        source: Box<dyn Animated>,
        files: impl IntoIterator<Item = PathBuf>,
        options: &OpenOptions,
    ) -> Result<Self, Error> {
        if let Some(variant) = options.variant.as_deref().filter(|_| source.variants().is_empty()) {
            return Err(variants::unknown(address, variant, &[]));
        }
        let mut scene = Self { files: files.into_iter().collect(), ..Self::new(source)? };
        scene.choose_ground(options.ground);
        scene.hiding(&options.hidden).map_err(|cause| Error::address(address.to_string_lossy(), cause))
    }

    /// Makes a scene of a source.
    ///
    /// # Errors
    /// Where the source can't be posed at one of the few moments that its bounds are found from.
    pub fn new(source: Box<dyn Animated>) -> Result<Self, Error> {
        let Survey { bounds: animation_bounds, size, objects, lacks_floor, has_marks } = Survey::of(&*source)?;
        Ok(Self {
            source: source.into(),
            animation_bounds,
            size,
            sun: sun_above(),
            objects,
            lacks_floor,
            has_marks,
            hidden: None,
            ground: None,
            files: Vec::new(),
        })
    }

    /// The names of the scene's objects, as far as its first moment has them: nodes of glTF files, objects and groups of OBJ
    /// files, parts of built-in scenes. Empty where triangles are of one object without a name.
    #[must_use]
    pub fn objects(&self) -> &[Arc<str>] {
        &self.objects
    }

    /// The same scene without the objects of these names, in which `*` stands for any characters and `?` for any one.
    /// Hidden objects cast no shadow and are in no mirror; cameras and a ground are placed as if they were there. Both
    /// scenes share the data that was read.
    ///
    /// ```
    /// let two = "v 0 0 0\nv 1 0 0\nv 0 1 0\no roof\nf 1 2 3\no floor\nf 1 3 2\n";
    /// let house = umbrage_scene::Scene::from_bytes("house.obj", two)?;
    /// let open = house.hiding(&["roof".to_owned()]).expect("there is one");
    /// assert_eq!((house.at(0.0)?.triangles().len(), open.at(0.0)?.triangles().len()), (2, 1));
    /// # Ok::<(), umbrage_scene::Error>(())
    /// ```
    ///
    /// # Errors
    /// Where a name is none of the scene's [objects](Self::objects), with the names that there are.
    pub fn hiding(&self, names: &[String]) -> Result<Self, String> {
        let unknown = |unknown: &str| unknown_object(unknown, &self.objects);
        let hidden = if names.is_empty() { None } else { Some(Hidden::new(names, &self.objects).map_err(unknown)?) };
        let mut scene = Self {
            source: Arc::clone(&self.source),
            animation_bounds: self.animation_bounds,
            size: self.size,
            sun: self.sun.clone(),
            objects: self.objects.clone(),
            lacks_floor: self.lacks_floor,
            has_marks: self.has_marks,
            hidden,
            ground: None,
            files: self.files.clone(),
        };
        scene.set_ground(self.ground());
        Ok(scene)
    }

    /// Whether the scene's first moment has points or lines.
    #[must_use]
    pub fn has_marks(&self) -> bool {
        self.has_marks
    }

    /// Whether an object isn't shown.
    #[must_use]
    pub fn is_hidden(&self, object: &str) -> bool {
        self.hidden.as_ref().is_some_and(|hidden| hidden.has(object))
    }

    /// Puts a ground under the scene, in place of the last one, or takes that away.
    pub fn set_ground(&mut self, ground: Option<Ground>) {
        let [_, level, _] = self.origin();
        self.ground = ground.map(|ground| Grounded::new(ground, self.animation_bounds, level));
    }

    /// As [`set_ground`](Self::set_ground), by a choice.
    pub fn choose_ground(&mut self, choice: GroundChoice) {
        let is_file = !self.files.is_empty();
        self.set_ground(match choice {
            GroundChoice::None => None,
            GroundChoice::Auto => (is_file && self.lacks_floor).then(Ground::default),
            GroundChoice::Own(ground) => Some(ground),
        });
    }

    /// The ground that was put under the scene.
    #[must_use]
    pub fn ground(&self) -> Option<Ground> {
        self.ground.as_ref().map(|grounded| grounded.ground)
    }

    /// The scene at a moment. Moments after the end play the animation again from its start.
    ///
    /// # Errors
    /// Where `seconds` isn't finite, the moment's file of a numbered sequence can't be read, or a light or a camera of
    /// the file is invalid at that moment.
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
        if !seconds.is_finite() {
            return Err(Error::Moment(seconds));
        }
        begin(frame);
        self.source.pose(self.looped(seconds), frame)?;
        self.finish(seconds, frame);
        if let Some(grounded) = &self.ground {
            grounded.put_under(frame);
        }
        Ok(())
    }

    /// As [`Scene::pose`], but without vertices: fills `pose` for the scene's rig, which stays the same, and leaves the
    /// frame without positions, normals and tangents. [`Rig::pose`] computes these.
    ///
    /// `None`, and nothing is done, for scenes without a rig.
    ///
    /// # Errors
    /// As [`Scene::at`].
    pub fn pose_rig(&self, seconds: f64, frame: &mut Frame, pose: &mut Pose) -> Result<Option<Arc<Rig>>, Error> {
        let Some(rig) = self.source.rig() else { return Ok(None) };
        if !seconds.is_finite() {
            return Err(Error::Moment(seconds));
        }
        begin(frame);
        self.source.pose_rig(self.looped(seconds), frame, pose)?;
        self.finish(seconds, frame);
        Ok(Some(match &self.ground {
            Some(grounded) => grounded.put_under_rig(rig, frame, pose),
            None => Arc::clone(rig),
        }))
    }

    /// The moment within the animation that is shown at `seconds`.
    #[must_use]
    pub fn looped(&self, seconds: f64) -> f64 {
        let duration = self.duration_seconds();
        if seconds > duration && duration > 0.0 { seconds % duration } else { seconds.max(0.0) }
    }

    /// Completes a frame with the scene's own data and a light if it has none, and takes hidden objects out.
    fn finish(&self, seconds: f64, frame: &mut Frame) {
        frame.seconds = seconds;
        frame.origin = self.origin();
        frame.animation_bounds = self.animation_bounds;
        frame.light_is_made = frame.lights.is_empty();
        if frame.light_is_made {
            frame.lights.push(self.made_light(frame.cameras.first().map(|named| &named.camera)));
        }
        if let Some(hidden) = &self.hidden {
            hidden.take_out(&mut frame.mesh);
        }
    }

    /// The light of frames without lights: a sun above the left of the [framing camera](Frame::framing_camera), or a lamp
    /// beside `camera` where that is inside the scene's bounds, since walls would block the sun.
    #[must_use]
    pub fn made_light(&self, camera: Option<&Camera>) -> Light {
        let mut light = self.sun.clone();
        let diagonal = diagonal(self.animation_bounds);
        let inside = camera.filter(|camera| {
            let Bounds { min, max } = self.animation_bounds;
            camera.position.cmpge(min).all() && camera.position.cmple(max).all()
        });
        if let Some(camera) = inside {
            let position = camera.position + (camera.up + camera.right * 0.5) * (0.03 * diagonal);
            light.source = LightSource::Point { position: somewhere(position) };
            // Finite and above zero for scenes of any size.
            light.intensity = (NEARLY_WHITE * (0.3 * diagonal).powi(2)).clamp(f32::MIN_POSITIVE, f32::MAX);
        }
        light
    }

    /// Size of the scene: the diagonal of its bounds at its first moment, in world units, without a ground; zero where
    /// nothing can be hit.
    #[must_use]
    pub fn size(&self) -> f32 {
        self.size
    }

    /// The point of the world that coordinates of frames, cameras and lights count from: zero, unless the coordinates of the
    /// scene's first moment reach beyond 512 diagonals of its box. Then it is the middle of that box, in whole numbers or, of
    /// scenes smaller than 1, in powers of two, so that f32 holds shapes as well as near zero. All moments have the same one.
    #[must_use]
    pub fn origin(&self) -> [f64; 3] {
        self.source.origin()
    }

    /// Duration of the scene's animation, after which it repeats; zero for a motionless scene.
    #[must_use]
    pub fn duration_seconds(&self) -> f64 {
        self.source.duration_seconds()
    }

    /// The moment of a still picture by default: the one that shows a demo best, else the middle.
    #[must_use]
    pub fn still_seconds(&self) -> f64 {
        self.source.still_seconds()
    }

    /// The animations that the file holds; empty for scenes that have just one without a name, or none.
    #[must_use]
    pub fn animations(&self) -> &[Animation] {
        self.source.animations()
    }

    /// The names of the variants that the file has for its materials; empty where there are none.
    #[must_use]
    pub fn variants(&self) -> &[String] {
        self.source.variants()
    }

    /// The files that the scene was opened from, in the order of their paths: its own and those that it names. For a
    /// numbered sequence, all of its files, those that the first one names, and material libraries with the name of a
    /// file. Empty for scenes that aren't from files.
    #[must_use]
    pub fn files(&self) -> &[PathBuf] {
        &self.files
    }

    /// Messages about content that opening the scene left out or guessed.
    #[must_use]
    pub fn warnings(&self) -> &[String] {
        self.source.warnings()
    }
}

/// Says that there is no such object.
fn unknown_object(wanted: &str, objects: &[Arc<str>]) -> String {
    const MOST: usize = 20;
    if objects.is_empty() {
        return format!("there is no object `{wanted}`, as the scene names none");
    }
    let names: Vec<_> = objects.iter().take(MOST).map(|name| format!("`{name}`")).collect();
    let others = if objects.len() > MOST { format!(" and {} others", objects.len() - MOST) } else { String::new() };
    format!("there is no object `{wanted}`; the scene has {}{others}", names.join(", "))
}

/// Reads a file whose triangles don't move; its materials may be shared with the last one's.
pub(crate) fn read_still(path: &Path, shared: &mut SharedMaterials) -> Result<Still, Error> {
    let (limits, crease_degrees) = (shared.limits.clone(), shared.crease_degrees);
    let mut read = |budget: &Budget| match Format::of(path) {
        Some(Format::Obj) => obj::read(path, shared, budget),
        Some(Format::Ply) => ply::read(path, shared.origin, budget),
        Some(Format::Stl) => stl::read(path, shared.origin, budget),
        Some(Format::Gltf | Format::PointCache) | None => Err(formats::unread(path)),
    };
    within(path, limits, |budget| {
        let mut still = read(budget)?;
        smooth::smooth(&mut still.frame, crease_degrees, FlatTriangles::Shared, budget)
            .map_err(|cause| Error::malformed(path, "the normals", cause))?;
        Ok(Still { files: budget.files(), ..still })
    })
}

/// Reads a file within limits. An exceeded limit is the error, in place of the result of `read`.
fn within<T>(path: &Path, limits: Limits, read: impl FnOnce(&Budget) -> Result<T, Error>) -> Result<T, Error> {
    let budget = Budget::new(limits);
    let result = read(&budget);
    if let Some(cause) = budget.refusal() {
        return Err(Error::Memory { path: path.to_owned(), cause: cause.to_owned() });
    }
    match budget.texture_failure() {
        Some(cause) => Err(Error::TextureFile(cause.to_owned())),
        None => result.map_err(|error| foreign::or_what_it_is(error, path, &budget)),
    }
}

/// A sun above the viewer's left. No size and no distance changes it.
fn sun_above() -> Light {
    const TOWARDS_LIGHT: Vec3 = Vec3::new(-0.45, 1.0, 0.65);
    let source = LightSource::Directional { direction: -TOWARDS_LIGHT.normalize() };
    Light { name: "made for the scene".into(), ..Light::new(source, NEARLY_WHITE) }
}

/// The illuminance, in lux, that makes a white surface nearly as bright as a screen can show, with the light of the sky.
const NEARLY_WHITE: f32 = 0.65 * std::f32::consts::PI;

/// The length of a box's diagonal, as far as a float holds it.
pub(crate) fn diagonal(bounds: Bounds) -> f32 {
    (bounds.max.as_dvec3() - bounds.min.as_dvec3()).length().min(f32::MAX.into()) as f32
}

/// Clamps a position to finite coordinates: a lamp beside a huge scene may overflow.
fn somewhere(position: Vec3) -> Vec3 {
    position.clamp(Vec3::MIN, Vec3::MAX)
}
