use std::fmt::Debug;
use std::path::PathBuf;
use std::sync::Arc;

use glam::{DVec3, Vec3};
use umbrage_rays::{Bounds, Camera, LightSource};

use crate::ground::{self, Grounded};
use crate::hidden::Hidden;
use crate::rig::{Pose, Rig};
use crate::{Error, Frame, Ground, GroundChoice, Light};

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

    /// Names of the material variants to choose from when the scene is opened.
    fn variants(&self) -> &[String] {
        &[]
    }

    /// Messages about content that was left out or guessed.
    fn warnings(&self) -> &[String] {
        &[]
    }
}

/// A motionless scene, with the frame's own lights and cameras.
impl Animated for Frame {
    fn duration_seconds(&self) -> f64 {
        0.0
    }

    fn pose(&self, _seconds: f64, frame: &mut Frame) -> Result<(), Error> {
        frame.copy_surfaces(self);
        if !self.light_is_made {
            frame.lights.extend_from_slice(&self.lights);
        }
        frame.cameras.extend_from_slice(&self.cameras);
        Ok(())
    }

    fn origin(&self) -> [f64; 3] {
        self.origin
    }
}

/// A scene with content at every moment: a file, a sequence of files or a procedural scene.
#[derive(Debug)]
pub struct Scene {
    source: Arc<dyn Animated>,
    survey: Arc<Survey>,
    /// Lights the frames of a file that has no light of its own.
    sun: Light,
    hidden: Option<Hidden>,
    ground: Option<Grounded>,
    files: Vec<PathBuf>,
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
    /// Makes a scene of a source.
    ///
    /// # Errors
    /// Where the source can't be posed at one of the few moments that its bounds are found from.
    pub fn new(source: Box<dyn Animated>) -> Result<Self, Error> {
        let survey = Arc::new(Survey::of(&*source)?);
        Ok(Self { source: source.into(), survey, sun: sun_above(), hidden: None, ground: None, files: Vec::new() })
    }

    /// The same scene, opened from these files ([`Scene::files`]), its own first.
    #[must_use]
    pub fn with_files(self, files: impl IntoIterator<Item = PathBuf>) -> Self {
        Self { files: files.into_iter().collect(), ..self }
    }

    /// The names of the scene's objects, as far as its first moment has them: nodes of glTF files, objects and groups of OBJ
    /// files, parts of built-in scenes. Empty where triangles are of one object without a name.
    #[must_use]
    pub fn objects(&self) -> &[Arc<str>] {
        &self.survey.objects
    }

    /// The same scene without the objects of these names, in which `*` stands for any characters and `?` for any one.
    /// Hidden objects cast no shadow and are in no mirror; cameras and a ground are placed as if they were there. Both
    /// scenes share the data that was read.
    ///
    /// ```
    /// use std::sync::Arc;
    ///
    /// use glam::Vec3;
    /// use umbrage_scene::{Frame, Scene};
    ///
    /// let mut frame = Frame::from_triangles(vec![Vec3::ZERO, Vec3::X, Vec3::Y], vec![[0, 1, 2], [0, 2, 1]]);
    /// let objects = &mut Arc::make_mut(&mut frame.mesh).objects;
    /// objects.begin(0, "roof");
    /// objects.begin(1, "floor");
    /// let house = Scene::new(Box::new(frame))?;
    /// let open = house.hiding(&["roof".to_owned()]).expect("there is one");
    /// assert_eq!((house.at(0.0)?.triangles().len(), open.at(0.0)?.triangles().len()), (2, 1));
    /// # Ok::<(), umbrage_scene::Error>(())
    /// ```
    ///
    /// # Errors
    /// Where a name is none of the scene's [objects](Self::objects), with the names that there are.
    pub fn hiding(&self, names: &[String]) -> Result<Self, String> {
        let unknown = |unknown: &str| unknown_object(unknown, &self.survey.objects);
        let hidden =
            if names.is_empty() { None } else { Some(Hidden::new(names, &self.survey.objects).map_err(unknown)?) };
        let (source, survey) = (Arc::clone(&self.source), Arc::clone(&self.survey));
        let (sun, files) = (self.sun.clone(), self.files.clone());
        let mut scene = Self { source, survey, sun, hidden, ground: None, files };
        scene.set_ground(self.ground());
        Ok(scene)
    }

    /// Whether the scene's first moment has points or lines.
    #[must_use]
    pub fn has_marks(&self) -> bool {
        self.survey.has_marks
    }

    /// Whether an object isn't shown.
    #[must_use]
    pub fn is_hidden(&self, object: &str) -> bool {
        self.hidden.as_ref().is_some_and(|hidden| hidden.has(object))
    }

    /// Puts a ground under the scene, in place of the last one, or takes that away.
    pub fn set_ground(&mut self, ground: Option<Ground>) {
        let [_, level, _] = self.origin();
        self.ground = ground.map(|ground| Grounded::new(ground, self.survey.bounds, level));
    }

    /// As [`set_ground`](Self::set_ground), by a choice.
    pub fn choose_ground(&mut self, choice: GroundChoice) {
        let is_file = !self.files.is_empty();
        self.set_ground(match choice {
            GroundChoice::None => None,
            GroundChoice::Auto => (is_file && self.survey.lacks_floor).then(Ground::default),
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
        self.fill(seconds, frame, |moment, frame| self.source.pose(moment, frame))?;
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
        self.fill(seconds, frame, |moment, frame| self.source.pose_rig(moment, frame, pose))?;
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

    /// Poses a moment, completes the frame with the scene's own data and a light if it has none, and takes hidden objects out.
    fn fill(
        &self,
        seconds: f64,
        frame: &mut Frame,
        pose: impl FnOnce(f64, &mut Frame) -> Result<(), Error>,
    ) -> Result<(), Error> {
        if !seconds.is_finite() {
            return Err(Error::Moment(seconds));
        }
        begin(frame);
        pose(self.looped(seconds), frame)?;
        frame.seconds = seconds;
        frame.origin = self.origin();
        frame.animation_bounds = self.survey.bounds;
        frame.light_is_made = frame.lights.is_empty();
        if frame.light_is_made {
            frame.lights.push(self.made_light(frame.cameras.first().map(|named| &named.camera)));
        }
        if let Some(hidden) = &self.hidden {
            hidden.take_out(&mut frame.mesh);
        }
        Ok(())
    }

    /// The light of frames without lights: a sun above the left of the [framing camera](Frame::framing_camera), or a lamp
    /// beside `camera` where that is inside the scene's bounds, since walls would block the sun.
    #[must_use]
    pub fn made_light(&self, camera: Option<&Camera>) -> Light {
        let mut light = self.sun.clone();
        let diagonal = diagonal(self.survey.bounds);
        let inside = camera.filter(|camera| {
            let Bounds { min, max } = self.survey.bounds;
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
        self.survey.size
    }

    /// The point of the world that coordinates of frames, cameras and lights count from: zero, unless the coordinates of the
    /// scene's first moment reach beyond 512 diagonals of its box. Then it is the middle of that box, in whole numbers or, of
    /// scenes smaller than 1, in powers of two, so that f32 holds shapes as well as near zero. All moments have the same one.
    #[must_use]
    pub fn origin(&self) -> [f64; 3] {
        self.source.origin()
    }

    /// A point of the world as frames, cameras and lights have it: from the scene's [origin](Self::origin), rounded to f32.
    ///
    /// ```
    /// use glam::{DVec3, Vec3};
    /// use umbrage_scene::{Frame, Scene};
    ///
    /// let corners = vec![Vec3::new(-0.75, -1.0, 0.0), Vec3::new(0.25, -1.0, 0.0), Vec3::new(-0.75, 0.5, 0.0)];
    /// let mut survey = Frame::from_triangles(corners, vec![[0, 1, 2]]);
    /// survey.origin = [500001.0, 4649777.0, 120.0];
    /// let scene = Scene::new(Box::new(survey))?;
    /// let corner = DVec3::new(500000.25, 4649776.0, 120.0);
    /// assert_eq!(scene.local_from_world(corner), scene.at(0.0)?.positions[0]);
    /// assert_eq!(scene.world_from_local(Vec3::new(-0.75, -1.0, 0.0)), corner);
    /// # Ok::<(), umbrage_scene::Error>(())
    /// ```
    #[must_use]
    pub fn local_from_world(&self, point: DVec3) -> Vec3 {
        (point - DVec3::from(self.origin())).as_vec3()
    }

    /// A point of the scene's frames in the world's coordinates, the inverse of [`local_from_world`](Self::local_from_world).
    #[must_use]
    pub fn world_from_local(&self, point: Vec3) -> DVec3 {
        DVec3::from(self.origin()) + point.as_dvec3()
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

/// Facts about a scene that don't change.
#[derive(Debug, Default)]
struct Survey {
    /// Bounds over a few moments, enough for a view that doesn't cut much off.
    bounds: Bounds,
    /// The diagonal of the bounds of the first of these moments that has any.
    size: f32,
    /// The names of the first moment's objects.
    objects: Vec<Arc<str>>,
    /// Whether the first moment has neither lights nor a floor.
    lacks_floor: bool,
    /// Whether the first moment has points or lines.
    has_marks: bool,
}

impl Survey {
    fn of(source: &dyn Animated) -> Result<Self, Error> {
        const MOMENTS: u32 = 5;
        let duration = source.duration_seconds();
        let moments = if duration > 0.0 { MOMENTS } else { 1 };
        let mut frame = Frame::default();
        let mut survey = Self::default();
        for moment in 0..moments {
            begin(&mut frame);
            source.pose(duration * f64::from(moment) / f64::from(moments), &mut frame)?;
            let bounds = frame.bounds();
            survey.bounds = survey.bounds.union(bounds);
            if survey.size == 0.0 && !bounds.is_empty() {
                survey.size = diagonal(bounds);
            }
            if moment == 0 {
                survey.objects = frame.mesh.objects.names().to_vec();
                survey.lacks_floor = ground::lacks_floor(&frame);
                survey.has_marks = !frame.mesh.marks.is_empty();
            }
        }
        Ok(survey)
    }
}

/// Removes lights and cameras, which sources add.
fn begin(frame: &mut Frame) {
    frame.lights.clear();
    frame.cameras.clear();
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

/// A sun above the viewer's left. No size and no distance changes it.
fn sun_above() -> Light {
    const TOWARDS_LIGHT: Vec3 = Vec3::new(-0.45, 1.0, 0.65);
    let source = LightSource::Directional { direction: -TOWARDS_LIGHT.normalize() };
    Light { name: "made for the scene".into(), ..Light::new(source, NEARLY_WHITE) }
}

/// The illuminance, in lux, that makes a white surface nearly as bright as a screen can show, with the light of the sky.
const NEARLY_WHITE: f32 = 0.65 * std::f32::consts::PI;

/// The length of a box's diagonal, as far as a float holds it.
fn diagonal(bounds: Bounds) -> f32 {
    (bounds.max.as_dvec3() - bounds.min.as_dvec3()).length().min(f32::MAX.into()) as f32
}

/// Clamps a position to finite coordinates: a lamp beside a huge scene may overflow.
fn somewhere(position: Vec3) -> Vec3 {
    position.clamp(Vec3::MIN, Vec3::MAX)
}
