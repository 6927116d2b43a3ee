//! `umbrage.open`: scenes of files and of the gallery, at any moment.

use std::path::PathBuf;
use std::sync::{Arc, Mutex};

use glam::DMat4;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::sync::MutexExt;
use pyo3::types::PyTuple;
use umbrage::scene::{Clip, GroundChoice, Instances, Mesh, OpenOptions};
use umbrage::{Renderer, gallery};

use crate::arrays::{counted, hand_over_rows, rows};
use crate::camera::Camera;
use crate::errors::{exception, expected};
use crate::light::Light;
use crate::pickled::pickled;
use crate::picture::{Look, Subject, render};
use crate::threads::{compute, pool};

/// Opens a scene: what the command `umbrage` reads.
///
/// Parameters
/// ----------
/// address : str or path
///     A glTF, OBJ, PLY or STL file, a numbered sequence's pattern or folder, or ``"demo:NAME"``, ``"demo:NAME?triangles=N"`` for a
///     scene that comes with the library, as ``"demo:cloth"``.
/// clip : str, optional
///     Which of a file's animations plays: a name, or a number from 0; ``"all"`` or ``"rest"``.
/// ground : str, optional
///     Puts a floor under the scene: ``"matte"``, or ``"shadow"`` of which only the shadows are seen; with a height as ``"matte:0.5"``;
///     ``"auto"`` for shadows under a file that has neither lights nor a floor, as the command `umbrage render` shows it.
/// variant : str, optional
///     Which of a file's variants has its materials shown, of `Scene.variants`; without, those of the file itself.
/// hide : sequence of str, optional
///     Shows all objects but those with these names, of `Scene.objects`; ``*`` stands for any characters.
/// sequence_fps : float, default 24
///     How many files of a sequence make a second.
/// allow_outside : bool, default False
///     Whether a file may name others outside of its own folder: for files that you trust.
///
/// Returns
/// -------
/// Scene
///
/// Raises
/// ------
/// OSError
///     Where the file can't be read, as `FileNotFoundError`.
/// ValueError
///     Where it breaks its format or needs something unsupported; the message names the place.
///
/// Examples
/// --------
/// >>> cloth = umbrage.open("demo:cloth?triangles=2000")
/// >>> frame = cloth.at(0.5)
/// >>> frame.vertices.shape[1], frame.vertices.dtype
/// (3, dtype('float32'))
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "they are Python's keywords")]
#[pyo3(signature = (address, *, clip=None, ground=None, variant=None, hide=None, sequence_fps=24.0, allow_outside=false))]
pub(crate) fn open(
    py: Python<'_>,
    address: PathBuf,
    clip: Option<String>,
    ground: Option<String>,
    variant: Option<String>,
    hide: Option<Vec<String>>,
    sequence_fps: f64,
    allow_outside: bool,
) -> PyResult<Scene> {
    Opened { address, clip, ground, variant, hide, sequence_fps, allow_outside }.open(py)
}

/// The arguments that a scene was opened with.
#[derive(Clone, Debug, FromPyObject, IntoPyObject)]
#[pyo3(from_item_all)]
struct Opened {
    address: PathBuf,
    clip: Option<String>,
    ground: Option<String>,
    variant: Option<String>,
    hide: Option<Vec<String>>,
    sequence_fps: f64,
    allow_outside: bool,
}

impl Opened {
    fn open(self, py: Python<'_>) -> PyResult<Scene> {
        let clip = match self.clip.as_deref() {
            None => Clip::Auto,
            Some("all") => Clip::All,
            Some("rest") => Clip::Rest,
            Some(name) => Clip::Named(name.to_owned()),
        };
        let wrong = |why: String| PyValueError::new_err(format!("ground: {why}"));
        let ground = self.ground.as_deref().map(|text| text.parse::<GroundChoice>().map_err(wrong));
        if !(self.sequence_fps.is_finite() && self.sequence_fps > 0.0) {
            return Err(expected("sequence_fps", "a finite number above 0", self.sequence_fps));
        }
        let options = OpenOptions {
            clip,
            ground: ground.transpose()?.unwrap_or_default(),
            variant: self.variant.clone(),
            hidden: self.hide.clone().unwrap_or_default(),
            sequence_fps: self.sequence_fps,
            allow_outside: self.allow_outside,
            ..OpenOptions::default()
        };
        let scene = compute(py, &*pool(0)?, || umbrage::open_with(&self.address, &options)).map_err(exception)?;
        Ok(Scene { opened: self.anywhere(), scene, renderer: Mutex::default(), triangles: Mutex::default() })
    }

    /// The same from any working folder.
    fn anywhere(mut self) -> Self {
        if !self.address.to_string_lossy().starts_with(gallery::PREFIX)
            && let Ok(absolute) = std::path::absolute(&self.address)
        {
            self.address = absolute;
        }
        self
    }
}

/// A scene that has a look at every moment; made by `umbrage.open`.
#[pyclass(frozen, module = "umbrage")]
#[derive(Debug)]
pub(crate) struct Scene {
    opened: Opened,
    scene: umbrage::Scene,
    renderer: Mutex<Renderer>,
    /// Those of the last frame, which the next one mostly shares.
    triangles: Mutex<Option<Triangles>>,
}

#[derive(Debug)]
struct Triangles {
    mesh: Arc<Mesh>,
    array: Py<PyAny>,
}

#[pymethods]
impl Scene {
    /// How long the animation takes before it starts again, in seconds; 0 for what doesn't move.
    #[getter]
    fn duration(&self) -> f64 {
        self.scene.duration_seconds()
    }

    /// The point of the world that `Frame.vertices` count from, (x, y, z): (0, 0, 0), unless the scene is so far from there that
    /// float32 would round its shape. Cameras, lights and `Instance.world_from_object` are in the world.
    #[getter]
    fn origin(&self) -> [f64; 3] {
        self.scene.origin()
    }

    /// The names of the animations to choose from by `clip`.
    #[getter]
    fn animations(&self) -> Vec<String> {
        self.scene.animations().iter().map(|animation| animation.name.clone()).collect()
    }

    /// The names of the objects to choose from by `hide`: nodes of glTF files, objects and groups of OBJ files.
    #[getter]
    fn objects(&self) -> Vec<&str> {
        self.scene.objects().iter().map(|name| &**name).collect()
    }

    /// The names of the variants to choose from by `variant`.
    #[getter]
    fn variants(&self) -> Vec<String> {
        self.scene.variants().to_vec()
    }

    /// What was left out of a file or guessed, in words.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.scene.warnings().to_vec()
    }

    /// The scene at a moment. Moments after the end play the animation again from its start.
    ///
    /// Parameters
    /// ----------
    /// seconds : float
    ///     A finite number.
    /// nthreads : int, default 0
    ///     Threads; 0 for as many as `set_threads` says.
    ///
    /// Returns
    /// -------
    /// Frame
    ///
    /// Raises
    /// ------
    /// ValueError, OSError
    ///     Where the moment can't be had.
    #[pyo3(signature = (seconds, nthreads=0))]
    fn at(&self, py: Python<'_>, seconds: f64, nthreads: usize) -> PyResult<Frame> {
        let frame = compute(py, &*pool(nthreads)?, || self.scene.at(seconds)).map_err(exception)?;
        let triangles = self.triangles(py, &frame.mesh)?;
        let cameras = frame.cameras.iter();
        let origin = frame.origin.into();
        let cameras = cameras.map(|named| (named.name.to_string(), Camera::in_world(named.camera, origin))).collect();
        let lights = frame.lights.iter().map(|light| Light::in_world(light.source, origin)).collect();
        let positions: Vec<[f32; 3]> = bytemuck::allocation::cast_vec(frame.positions);
        let count = positions.len();
        let vertices = hand_over_rows(py, positions, &[count])?.unbind();
        Ok(Frame { vertices, triangles, cameras, lights, seconds, origin: frame.origin })
    }

    /// The scene's objects at a moment, as meshes with a transform each.
    ///
    /// A node of a glTF file that has a mesh is one, or each copy that it shows of one. Meshes that follow a skin or morph have no
    /// rigid place: their own space is the world's, as it is for the objects of other files. Each moment has the same objects, so
    /// what `RaycastingScene.add_triangles` was given once moves by `set_transform`, and what deforms by `update_vertices`.
    ///
    /// Parameters
    /// ----------
    /// seconds, nthreads
    ///     As of `at`.
    ///
    /// Returns
    /// -------
    /// list of Instance
    ///     Their triangles, one instance after the other, are those of `Frame.triangles`.
    ///
    /// Raises
    /// ------
    /// ValueError, OSError
    ///     Where the moment can't be had.
    ///
    /// Examples
    /// --------
    /// >>> [part.name for part in umbrage.open("demo:cloth?triangles=2000").instances(0.5)]
    /// ['silk', 'ball', 'floor']
    #[pyo3(signature = (seconds, nthreads=0))]
    fn instances(&self, py: Python<'_>, seconds: f64, nthreads: usize) -> PyResult<Vec<Instance>> {
        let of_scene = || Instances::of_scene(&self.scene, seconds);
        let instances = compute(py, &*pool(nthreads)?, of_scene).map_err(exception)?;
        (0..instances.all().len() as u32).map(|id| Instance::new(py, &instances, id)).collect()
    }

    /// Renders a picture of a moment.
    ///
    /// Parameters
    /// ----------
    /// seconds : float, optional
    ///     The moment; otherwise the one that shows a demo best, or the middle of the animation.
    /// width, height : int, optional
    ///     Pixels, 1 to 16384; otherwise those of the camera's own image (`Camera.from_intrinsics`), or 1280 and 720.
    /// samples : int, default 1
    ///     Rays for each pixel, 1 to 4096.
    /// camera : Camera, int or str, optional
    ///     From where; or the file's camera of that number or name, or ``"X,Y,Z:X,Y,Z:FOV"``. Otherwise the file's first one, or one
    ///     that sees all. Pictures have square pixels, and a camera's principal point at the nearest corner, edge or middle of one.
    /// lights : sequence of Light or str, optional
    ///     In place of the file's: lights as bright as full sunlight at the middle of the scene, or words as of the command, such as
    ///     ``"sun:-1,-2,-1:3:1,0.9,0.8:radius=0.3"``.
    /// background : str, default "sky"
    ///     ``"sky"``, ``"none"``, a colour such as ``"orange"`` or ``"#rrggbb"``, or the path of a latitude–longitude image.
    /// bounces : int, default 0
    ///     Mirrors and surfaces of glass that light may come by, 0 to 1024.
    /// exposure : float or "auto", default 0
    ///     Stops, each of which doubles the brightness; ``"auto"`` measures how many suit what the picture shows, -20 to 4.
    /// nthreads : int, default 0
    ///     Threads; 0 for as many as `set_threads` says.
    ///
    /// Returns
    /// -------
    /// Picture (height, width, 3) uint8, or (height, width, 4) with ``background="none"``
    ///     sRGB, and how much of each pixel is covered.
    ///
    /// Examples
    /// --------
    /// >>> umbrage.open("demo:cloth?triangles=2000").render(0.5, 64, 36).shape
    /// (36, 64, 3)
    #[pyo3(signature = (seconds=None, width=None, height=None, *, samples=1, camera=None, lights=None, background="sky", bounces=0, exposure=None, nthreads=0))]
    #[expect(clippy::too_many_arguments, reason = "they are Python's keywords")]
    fn render<'py>(
        &self,
        py: Python<'py>,
        seconds: Option<f64>,
        width: Option<u32>,
        height: Option<u32>,
        samples: u32,
        camera: Option<&Bound<'py, PyAny>>,
        lights: Option<&Bound<'py, PyAny>>,
        background: &str,
        bounces: u32,
        exposure: Option<&Bound<'py, PyAny>>,
        nthreads: usize,
    ) -> PyResult<Bound<'py, PyAny>> {
        let look = Look::new([width, height], samples, camera, lights, background)?;
        let look = look.with_bounces(bounces).with_exposure(exposure)?;
        let seconds = seconds.unwrap_or(self.scene.still_seconds());
        render(py, nthreads, &self.renderer, &look, Subject::Moment(&self.scene, seconds))
    }

    #[staticmethod]
    fn _restore(py: Python<'_>, opened: Opened) -> PyResult<Self> {
        opened.open(py)
    }

    /// Pickles are opened again, with the same options.
    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        pickled::<Self>(py, (self.opened.clone(),))
    }

    /// Itself: a scene never changes.
    fn __copy__(slf: Bound<'_, Self>) -> Bound<'_, Self> {
        slf
    }

    /// Itself: a scene never changes.
    fn __deepcopy__<'py>(slf: Bound<'py, Self>, _memo: &Bound<'py, PyAny>) -> Bound<'py, Self> {
        slf
    }

    fn __repr__(&self) -> String {
        let mut said = vec![counted(self.scene.objects().len(), "object", "objects")];
        let seconds = self.scene.duration_seconds();
        if seconds > 0.0 {
            said.push(format!("{} s of animation", (1e3 * seconds).round() / 1e3));
        }
        let of_choice = [
            (self.scene.animations().len(), "animation", "animations"),
            (self.scene.variants().len(), "variant", "variants"),
            (self.scene.warnings().len(), "warning", "warnings"),
        ];
        said.extend(of_choice.iter().filter(|of| of.0 > 0).map(|&(count, one, several)| counted(count, one, several)));
        format!("<umbrage.Scene {:?}: {}>", self.opened.address, said.join(", "))
    }
}

impl Scene {
    fn triangles(&self, py: Python<'_>, mesh: &Arc<Mesh>) -> PyResult<Py<PyAny>> {
        let mut last = self.triangles.lock_py_attached(py).unwrap_or_else(std::sync::PoisonError::into_inner);
        if let Some(last) = last.as_ref().filter(|last| Arc::ptr_eq(&last.mesh, mesh)) {
            return Ok(last.array.clone_ref(py));
        }
        let array = hand_over_rows(py, mesh.triangles.clone(), &[mesh.triangles.len()])?;
        // Other frames share it.
        array.call_method1("setflags", (false,))?;
        *last = Some(Triangles { mesh: mesh.clone(), array: array.clone().unbind() });
        Ok(array.unbind())
    }
}

/// A scene at a moment; made by `Scene.at`.
#[pyclass(frozen, module = "umbrage")]
#[derive(Debug)]
pub(crate) struct Frame {
    /// Positions from `origin`: (N, 3) float32, in world units.
    #[pyo3(get)]
    vertices: Py<PyAny>,
    /// Three vertices each: (M, 3) uint32. Read-only: frames share it.
    #[pyo3(get)]
    triangles: Py<PyAny>,
    /// Name and camera of each of the file's cameras.
    #[pyo3(get)]
    cameras: Vec<(String, Camera)>,
    /// Where the file's lights are.
    #[pyo3(get)]
    lights: Vec<Light>,
    /// The moment that was asked for.
    #[pyo3(get)]
    seconds: f64,
    /// `Scene.origin` of its scene.
    #[pyo3(get)]
    pub(crate) origin: [f64; 3],
}

#[pymethods]
impl Frame {
    #[staticmethod]
    #[pyo3(signature = (vertices, triangles, cameras, lights, seconds, origin=[0.0; 3]))]
    fn _restore(
        vertices: Py<PyAny>,
        triangles: Py<PyAny>,
        cameras: Vec<(String, Camera)>,
        lights: Vec<Light>,
        seconds: f64,
        origin: [f64; 3],
    ) -> Self {
        Self { vertices, triangles, cameras, lights, seconds, origin }
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        let Self { vertices, triangles, cameras, lights, seconds, origin } = self;
        let arrays = [vertices, triangles].map(|array| array.clone_ref(py));
        let [vertices, triangles] = arrays;
        pickled::<Self>(py, (vertices, triangles, cameras.clone(), lights.clone(), *seconds, *origin))
    }

    fn __repr__(&self, py: Python<'_>) -> String {
        let Self { vertices, triangles, cameras, lights, seconds, .. } = self;
        let said = [
            counted(rows(py, vertices), "vertex", "vertices"),
            counted(rows(py, triangles), "triangle", "triangles"),
            counted(cameras.len(), "camera", "cameras"),
            counted(lights.len(), "light", "lights"),
        ];
        format!("<umbrage.Frame at {seconds} s: {}>", said.join(", "))
    }
}

/// A rigid object of a scene at a moment; made by `Scene.instances`.
#[pyclass(frozen, module = "umbrage")]
#[derive(Debug)]
pub(crate) struct Instance {
    /// The file's name for it; those of several may be the same.
    #[pyo3(get)]
    name: String,
    /// In its own space: (N, 3) float32.
    #[pyo3(get)]
    vertices: Py<PyAny>,
    /// Three of these vertices each: (M, 3) uint32.
    #[pyo3(get)]
    triangles: Py<PyAny>,
    /// Where it is: (4, 4) float64, for column vectors, as `RaycastingScene.set_transform` takes it.
    #[pyo3(get)]
    world_from_object: Py<PyAny>,
}

impl Instance {
    pub(crate) fn new(py: Python<'_>, instances: &Instances, id: u32) -> PyResult<Self> {
        let of = &instances.all()[id as usize];
        let (vertices, triangles) = instances.mesh(id);
        let matrix = DMat4::from(of.world_from_object()).transpose().to_cols_array_2d();
        Ok(Self {
            name: of.name().to_owned(),
            vertices: hand_over_rows(py, bytemuck::cast_slice::<_, [f32; 3]>(vertices).to_vec(), &[vertices.len()])?
                .unbind(),
            triangles: hand_over_rows(py, triangles.collect(), &[of.triangles().len()])?.unbind(),
            world_from_object: hand_over_rows(py, matrix.to_vec(), &[4])?.unbind(),
        })
    }
}

#[pymethods]
impl Instance {
    #[staticmethod]
    fn _restore(name: String, vertices: Py<PyAny>, triangles: Py<PyAny>, world_from_object: Py<PyAny>) -> Self {
        Self { name, vertices, triangles, world_from_object }
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        let arrays = [&self.vertices, &self.triangles, &self.world_from_object].map(|array| array.clone_ref(py));
        let [vertices, triangles, world_from_object] = arrays;
        pickled::<Self>(py, (self.name.clone(), vertices, triangles, world_from_object))
    }

    fn __repr__(&self, py: Python<'_>) -> String {
        let vertices = counted(rows(py, &self.vertices), "vertex", "vertices");
        let triangles = counted(rows(py, &self.triangles), "triangle", "triangles");
        format!("<umbrage.Instance {:?}: {vertices}, {triangles}>", self.name)
    }
}
