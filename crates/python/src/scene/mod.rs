//! `umbrage.RaycastingScene`: meshes, and what rays, directions, cameras and lights find among them.

mod answers;
mod arguments;
mod ask;
mod questions;
mod rays;
mod state;

use std::sync::Mutex;

use glam::{DVec3, Vec3};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PySlice};
use umbrage::rays::Choice;
use umbrage::scene::{Frame, Instance};

use crate::arrays::{Rows, hand_over, hand_over_rows, shown};
use crate::camera::Camera;
use crate::errors::{bad_instance, expected};
use crate::light;
use crate::picture::{Look, Subject, render};
use crate::threads::{Call, pool};
use answers::{INVALID_ID, Precision};
use arguments::{Own, Points, Sweeps, affine, hits_of_each, origin_or_zero, samples_of_each};
use ask::geometry_of;
use rays::RayArray;
use state::State;

/// Triangle meshes that may move between two questions, and what finds rays' hits among them.
///
/// The names, keys and shapes are those of Open3D's class, whose meshes can't move. What was built for a mesh is rebuilt, when
/// it is next asked for, after `add_triangles`, `update_vertices` or `set_transform`.
///
/// Answers are exact: no ray slips between triangles that share an edge, t is the number nearest to the true one, and nothing
/// depends on an offset or the number of threads. Rays hit both sides of triangles. Where several triangles are hit at the same
/// t, the lowest one counts. Intervals are open: what is at the origin itself isn't hit.
///
/// Methods release Python's global lock. Two threads may ask the same scene, and wait for each other; they mustn't write to arrays
/// that a call reads.
///
/// Parameters
/// ----------
/// nthreads : int, default 0
///     Threads of calls that don't say how many; 0 for as many as `umbrage.set_threads` says.
/// origin : array_like (3,), default (0, 0, 0)
///     The point of the world that vertices without a transform count from: `Scene.origin`. All else is in the world.
///
/// Examples
/// --------
/// >>> import numpy as np, umbrage
/// >>> scene = umbrage.RaycastingScene()
/// >>> floor = scene.add_triangles(np.float32([[0, 0, 0], [1, 0, 0], [0, 1, 0]]), np.uint32([[0, 1, 2]]))
/// >>> answer = scene.cast_rays(np.float32([[0.2, 0.2, 1, 0, 0, -1], [5, 5, 1, 0, 0, -1]]))
/// >>> answer["t_hit"]
/// array([ 1., inf], dtype=float32)
/// >>> answer["geometry_ids"] == floor
/// array([ True, False])
#[pyclass(frozen, module = "umbrage")]
#[derive(Debug)]
pub(crate) struct RaycastingScene {
    state: Mutex<State>,
    nthreads: usize,
    origin: DVec3,
}

#[pymethods]
impl RaycastingScene {
    /// Stands for no geometry and no triangle: 0xFFFFFFFF.
    #[classattr]
    const INVALID_ID: u32 = INVALID_ID;

    #[new]
    #[pyo3(signature = (nthreads=0, *, origin=None))]
    fn new(nthreads: usize, origin: Option<&Bound<'_, PyAny>>) -> PyResult<Self> {
        pool(nthreads)?;
        let origin = origin_or_zero(origin)?;
        Ok(Self { state: State::with_origin(origin).into(), nthreads, origin })
    }

    /// Adds a triangle mesh.
    ///
    /// Vertices are copied into the scene. Triangles with a corner that isn't finite, or with two corners that are the same, are
    /// never hit: see `omitted`.
    ///
    /// Parameters
    /// ----------
    /// vertex_positions : array_like (N, 3) float32
    ///     In world units; or a mesh with `vertices` and `faces`, as trimesh has them, without `triangle_indices`.
    /// triangle_indices : array_like (M, 3) uint32
    ///     Three vertices each.
    ///
    /// Returns
    /// -------
    /// int
    ///     The geometry's id: how many were added before.
    ///
    /// Raises
    /// ------
    /// ValueError
    ///     For arrays of another shape, or an index of a vertex that isn't there.
    #[pyo3(signature = (vertex_positions, triangle_indices=None))]
    fn add_triangles(
        &self,
        py: Python<'_>,
        vertex_positions: &Bound<'_, PyAny>,
        triangle_indices: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<u32> {
        let (vertices, triangles) = match triangle_indices {
            Some(triangles) => (vertex_positions.clone(), triangles.clone()),
            None if vertex_positions.hasattr("faces")? => {
                (vertex_positions.getattr("vertices")?, vertex_positions.getattr("faces")?)
            }
            None => return Err(PyValueError::new_err("triangle_indices: expected shape (M, 3), found None")),
        };
        let vertices = Rows::<f32, 3>::table("vertex_positions", "N", &vertices)?;
        let triangles = Rows::<u32, 3>::table("triangle_indices", "M", &triangles)?;
        let (vertices, triangles): (&[Vec3], &[[u32; 3]]) = (vertices.of(), triangles.of());
        py.detach(|| self.lock().change().add("", vertices, triangles)).map_err(bad_instance)
    }

    /// Moves the vertices of a geometry, whose triangles stay.
    ///
    /// Parameters
    /// ----------
    /// geometry_id : int
    ///     What `add_triangles` returned.
    /// vertex_positions : array_like (N, 3) float32
    ///     As many as there are, before the geometry's transform.
    ///
    /// Raises
    /// ------
    /// IndexError
    ///     Where there is no such geometry.
    /// ValueError
    ///     For an array of another shape.
    fn update_vertices(&self, py: Python<'_>, geometry_id: usize, vertex_positions: &Bound<'_, PyAny>) -> PyResult<()> {
        let vertices = Rows::<f32, 3>::table("vertex_positions", "N", vertex_positions)?;
        let vertices: &[Vec3] = vertices.of();
        py.detach(|| {
            let mut state = self.lock();
            let count = geometry_of(&state, geometry_id)?.vertices();
            if count != vertices.len() {
                return Err(expected("vertex_positions", &shown(&[count, 3]), shown(&[vertices.len(), 3])));
            }
            state.change().update(geometry_id as u32, vertices);
            Ok(())
        })
    }

    /// Puts a geometry elsewhere.
    ///
    /// Parameters
    /// ----------
    /// geometry_id : int
    ///     What `add_triangles` returned.
    /// world_from_object : array_like (4, 4)
    ///     An affine transform of column vectors, in place of the last one; its last row is 0, 0, 0, 1. It is applied in float64 and
    ///     rounded to float32 once.
    ///
    /// Raises
    /// ------
    /// IndexError
    ///     Where there is no such geometry.
    /// ValueError
    ///     For another shape, or a matrix that isn't affine.
    fn set_transform(&self, py: Python<'_>, geometry_id: usize, world_from_object: &Bound<'_, PyAny>) -> PyResult<()> {
        let matrix = affine("world_from_object", world_from_object)?;
        py.detach(|| {
            let mut state = self.lock();
            geometry_of(&state, geometry_id)?;
            state.change().set_transform(geometry_id as u32, matrix);
            Ok(())
        })
    }

    /// Finds what each of any rays hits first, through what takes the least for so many rays of as many origins. Answers don't
    /// depend on that.
    ///
    /// Parameters
    /// ----------
    /// rays : array_like (..., 6) float32 or float64
    ///     Origin and direction; t is in lengths of the direction. Rays with a direction of zero, or with numbers that aren't
    ///     finite, hit nothing. float64 is taken as it is, and all but float32 and float64 is converted to float32.
    /// nthreads : int, default 0
    ///     Threads; 0 for the scene's.
    ///
    /// Returns
    /// -------
    /// dict
    ///     ``t_hit`` (...) of the rays' type, infinite for a miss; ``geometry_ids`` (...) and ``primitive_ids`` (...) uint32,
    ///     `INVALID_ID` for a miss; ``primitive_uvs`` (..., 2) float32, weights of the second and the third corner, zero for a miss;
    ///     ``primitive_normals`` (..., 3) float32, of unit length, towards where the corners are seen counterclockwise, zero for a
    ///     miss; and ``structures``, a list of str: what answered each million of rays, ``"scanner"`` or ``"hierarchy"``.
    ///
    /// Examples
    /// --------
    /// >>> scene.cast_rays([[0.2, 0.2, 1, 0, 0, -1]])["t_hit"]
    /// array([1.], dtype=float32)
    #[pyo3(signature = (rays, nthreads=0))]
    fn cast_rays<'py>(
        &self,
        py: Python<'py>,
        rays: &Bound<'py, PyAny>,
        nthreads: usize,
    ) -> PyResult<Bound<'py, PyDict>> {
        let rays = RayArray::new(rays, self.origin)?;
        let (these, precision) = (rays.rays(), rays.precision());
        let (answers, by) = self.ask(py, nthreads, |call, state| questions::cast(call, state, these))?;
        let dict = answers.into_dict(py, rays.shape(), precision)?;
        dict.set_item("structures", by.into_iter().map(Choice::name).collect::<Vec<_>>())?;
        Ok(dict)
    }

    /// Finds whether each of any rays hits anything in a part of it.
    ///
    /// Parameters
    /// ----------
    /// rays, nthreads
    ///     As of `cast_rays`.
    /// tnear, tfar : float, default 0 and infinity
    ///     Only hits between them count, in lengths of a direction.
    ///
    /// Returns
    /// -------
    /// ndarray (...) bool
    #[pyo3(signature = (rays, tnear=0.0, tfar=f64::INFINITY, nthreads=0))]
    fn test_occlusions<'py>(
        &self,
        py: Python<'py>,
        rays: &Bound<'py, PyAny>,
        tnear: f64,
        tfar: f64,
        nthreads: usize,
    ) -> PyResult<Bound<'py, PyAny>> {
        let rays = RayArray::new(rays, self.origin)?;
        let these = rays.rays();
        let hit = self.ask(py, nthreads, |call, state| questions::any(call, state, these, [tnear, tfar]))?;
        hand_over(py, hit, rays.shape())
    }

    /// Counts the triangles that each of any rays hits. One through an edge that two triangles share hits both.
    ///
    /// Parameters
    /// ----------
    /// rays, nthreads
    ///     As of `cast_rays`.
    ///
    /// Returns
    /// -------
    /// ndarray (...) int32
    #[pyo3(signature = (rays, nthreads=0))]
    fn count_intersections<'py>(
        &self,
        py: Python<'py>,
        rays: &Bound<'py, PyAny>,
        nthreads: usize,
    ) -> PyResult<Bound<'py, PyAny>> {
        let rays = RayArray::new(rays, self.origin)?;
        let these = rays.rays();
        let counts = self.ask(py, nthreads, |call, state| questions::count(call, state, these))?;
        hand_over(py, counts, rays.shape())
    }

    /// Lists all triangles that each of any rays hits, nearest first; of those at the same t the lowest first.
    ///
    /// Parameters
    /// ----------
    /// rays, nthreads
    ///     As of `cast_rays`.
    ///
    /// Returns
    /// -------
    /// dict
    ///     ``ray_splits`` (R + 1) int64: the hits of ray i, of R in all, are those from ``ray_splits[i]`` to before
    ///     ``ray_splits[i + 1]``; ``ray_ids`` (H) int64; and ``t_hit``, ``geometry_ids``, ``primitive_ids`` and ``primitive_uvs`` of
    ///     the H hits, as of `cast_rays`.
    #[pyo3(signature = (rays, nthreads=0))]
    fn list_intersections<'py>(
        &self,
        py: Python<'py>,
        rays: &Bound<'py, PyAny>,
        nthreads: usize,
    ) -> PyResult<Bound<'py, PyDict>> {
        let rays = RayArray::new(rays, self.origin)?;
        let (these, precision) = (rays.rays(), rays.precision());
        let listed = self.ask(py, nthreads, |call, state| questions::list(call, state, these))?;
        let hits = listed.rays.len();
        let dict = listed.hits.into_dict(py, &[hits], precision)?;
        dict.set_item("ray_splits", hand_over(py, listed.splits, &[these.len() + 1])?)?;
        dict.set_item("ray_ids", hand_over(py, listed.rays, &[hits])?)?;
        Ok(dict)
    }

    /// Finds what directions from one origin, or from several, hit: a lidar's, a panorama's.
    ///
    /// Parameters
    /// ----------
    /// origin : array_like (3,) or (S, 3) float64
    ///     World position, or S of them.
    /// directions : array_like (..., 3) float32
    ///     In any order and of any length, which is the unit of t. Those that are zero or not finite hit nothing. Each of S
    ///     origins has all of them, or with ``each=True`` origin i has ``directions[i]``.
    /// returns : int, optional
    ///     How many hits of each direction, nearest first, as of a lidar with several returns; adds a dimension.
    /// t_min, t_max : float, default 0 and infinity
    ///     Only hits between them count; at least 0.
    /// each : bool, default False
    ///     Whether ``directions`` has a first dimension of S.
    /// nthreads : int, default 0
    ///     Threads; 0 for the scene's.
    ///
    /// Returns
    /// -------
    /// dict
    ///     The keys of `cast_rays`, of shape (..., [returns]) for one origin, (S, ..., [returns]) for several; ``t_hit`` is float64.
    ///
    /// Examples
    /// --------
    /// >>> scene.scan([0.2, 0.2, 1], [[0, 0, -1], [0, 0, 1]])["t_hit"]
    /// array([ 1., inf])
    #[pyo3(signature = (origin, directions, *, returns=None, t_min=0.0, t_max=f64::INFINITY, each=false, nthreads=0))]
    #[expect(clippy::too_many_arguments, reason = "they are Python's keywords")]
    fn scan<'py>(
        &self,
        py: Python<'py>,
        origin: &Bound<'py, PyAny>,
        directions: &Bound<'py, PyAny>,
        returns: Option<usize>,
        t_min: f64,
        t_max: f64,
        each: bool,
        nthreads: usize,
    ) -> PyResult<Bound<'py, PyDict>> {
        let most = hits_of_each(returns)?;
        let sweeps = Sweeps::new(origin, directions, each, self.origin)?;
        let pieces = sweeps.pieces();
        let question = |call: &Call, state: &mut State| questions::scan(call, state, pieces, [t_min, t_max], most);
        let answers = self.ask(py, nthreads, question)?;
        let mut shape = sweeps.shape();
        shape.extend(returns);
        answers.into_dict(py, &shape, Precision::Double)
    }

    /// Finds which directions hit anything, which takes less than finding what.
    ///
    /// Parameters
    /// ----------
    /// origin, directions, t_min, t_max, each, nthreads
    ///     As of `scan`.
    ///
    /// Returns
    /// -------
    /// ndarray (...) or (S, ...) bool
    #[pyo3(signature = (origin, directions, *, t_min=0.0, t_max=f64::INFINITY, each=false, nthreads=0))]
    #[expect(clippy::too_many_arguments, reason = "they are Python's keywords")]
    fn scan_any<'py>(
        &self,
        py: Python<'py>,
        origin: &Bound<'py, PyAny>,
        directions: &Bound<'py, PyAny>,
        t_min: f64,
        t_max: f64,
        each: bool,
        nthreads: usize,
    ) -> PyResult<Bound<'py, PyAny>> {
        let sweeps = Sweeps::new(origin, directions, each, self.origin)?;
        let pieces = sweeps.pieces();
        let question = |call: &Call, state: &mut State| questions::scan_any(call, state, pieces, [t_min, t_max]);
        let hit = self.ask(py, nthreads, question)?;
        hand_over(py, hit, &sweeps.shape())
    }

    /// Finds what the pixels of a camera's image show.
    ///
    /// Parameters
    /// ----------
    /// camera : Camera
    ///     From where.
    /// width, height : int
    ///     Pixels, 1 to 16384.
    /// nthreads : int, default 0
    ///     Threads; 0 for the scene's.
    ///
    /// Returns
    /// -------
    /// dict
    ///     The keys of `cast_rays`, of shape (height, width), in rows from the upper left corner; ``t_hit`` is float64, and the depth
    ///     along the camera's forward axis in world units.
    #[pyo3(signature = (camera, width, height, nthreads=0))]
    fn see<'py>(
        &self,
        py: Python<'py>,
        camera: &Camera,
        width: u32,
        height: u32,
        nthreads: usize,
    ) -> PyResult<Bound<'py, PyDict>> {
        let view = camera.view(width, height, self.origin)?;
        let answers = self.ask(py, nthreads, |call, state| questions::see(call, state, view))?;
        answers.into_dict(py, &[height as usize, width as usize], Precision::Double)
    }

    /// Finds which points, or which triangles' centroids, lights reach.
    ///
    /// A point is lit where no triangle but its own stands strictly between it and the light. There is no offset to choose. On which
    /// side of its own triangle the light is doesn't matter: compare with its normal where it has only one side.
    ///
    /// Parameters
    /// ----------
    /// lights : Light, or a sequence of L of them
    ///     Suns, points, spots.
    /// points : array_like (..., 3) float32, optional
    ///     World positions. Those that aren't finite are dark.
    /// faces : bool, default False
    ///     In place of points the centroids of all triangles: those of geometry 0, then of geometry 1, and so on
    ///     (`triangle_slice`). Triangles that no ray can hit are dark.
    /// geometry_ids, primitive_ids : array_like (...) uint32, optional
    ///     The triangle that each point is on, as of `cast_rays`; `INVALID_ID` for a point on none. A point on a triangle counts as
    ///     rounded to float32, others are where they are said to be.
    /// nthreads : int, default 0
    ///     Threads; 0 for the scene's.
    ///
    /// Returns
    /// -------
    /// ndarray (L, ...) bool
    ///     With ``faces=True`` (L, T) for T triangles.
    ///
    /// Examples
    /// --------
    /// >>> noon = umbrage.Light.sun([0, 0, -1])
    /// >>> scene.lit(noon, points=[[0.2, 0.2, -1], [0.2, 0.2, 1]])
    /// array([[False,  True]])
    /// >>> scene.lit(noon, faces=True)
    /// array([[ True]])
    #[pyo3(signature = (lights, *, points=None, faces=false, geometry_ids=None, primitive_ids=None, nthreads=0))]
    #[expect(clippy::too_many_arguments, reason = "they are Python's keywords")]
    fn lit<'py>(
        &self,
        py: Python<'py>,
        lights: &Bound<'py, PyAny>,
        points: Option<&Bound<'py, PyAny>>,
        faces: bool,
        geometry_ids: Option<&Bound<'py, PyAny>>,
        primitive_ids: Option<&Bound<'py, PyAny>>,
        nthreads: usize,
    ) -> PyResult<Bound<'py, PyAny>> {
        let lights = light::lights(lights, self.origin)?;
        let points = match (points, faces) {
            (Some(points), false) => Some(Points::new(points, self.origin)?),
            (None, true) => None,
            _ => return Err(PyValueError::new_err("points, faces: expected points or faces=True, and not both")),
        };
        let ids = Own::new(points.as_ref().map(Points::shape), geometry_ids, primitive_ids)?;
        let positions: Option<&[Vec3]> = points.as_ref().map(Points::positions);
        let own = ids.as_ref().map(Own::slices);
        let question = |call: &Call, state: &mut State| questions::lit(call, state, positions, own, &lights);
        let (lit, count) = self.ask(py, nthreads, question)?;
        let shape = points.as_ref().map_or(vec![count], |points| points.shape().to_vec());
        let shape: Vec<usize> = std::iter::once(lights.len()).chain(shape).collect();
        hand_over(py, lit, &shape)
    }

    /// Finds how much of each triangle's area lights reach, by points of even density that are the same on every machine.
    ///
    /// Parameters
    /// ----------
    /// lights, nthreads
    ///     As of `lit`.
    /// samples : int, default 64
    ///     Points of each triangle, 1 to 65536.
    ///
    /// Returns
    /// -------
    /// dict
    ///     ``share`` (L, T) float64, from 0 to 1, for T triangles: those of geometry 0, then of geometry 1, and so on; and
    ///     ``standard_error`` (L, T) float64, that of as many independent samples, which evenly spread ones stay below as a rule.
    #[pyo3(signature = (lights, *, samples=64, nthreads=0))]
    fn lit_areas<'py>(
        &self,
        py: Python<'py>,
        lights: &Bound<'py, PyAny>,
        samples: u32,
        nthreads: usize,
    ) -> PyResult<Bound<'py, PyDict>> {
        let lights = light::lights(lights, self.origin)?;
        samples_of_each(samples)?;
        let question = |call: &Call, state: &mut State| questions::lit_areas(call, state, &lights, samples);
        let (shares, count) = self.ask(py, nthreads, question)?;
        let (dict, shape) = (PyDict::new(py), [lights.len(), count]);
        let (share, error): (Vec<f64>, Vec<f64>) = shares.iter().map(|of| (of.share, of.standard_error)).unzip();
        dict.set_item("share", hand_over(py, share, &shape)?)?;
        dict.set_item("standard_error", hand_over(py, error, &shape)?)?;
        Ok(dict)
    }

    /// Renders a picture of the meshes, in clay.
    ///
    /// Parameters
    /// ----------
    /// camera : Camera or str, optional
    ///     From where; otherwise from where all is seen.
    /// width, height : int, default 1280 and 720
    ///     Pixels, 1 to 16384.
    /// samples, lights, background, nthreads
    ///     As of `Scene.render`; without lights there is only that of the background.
    ///
    /// Returns
    /// -------
    /// ndarray (height, width, 3) uint8, or (height, width, 4) with ``background="none"``
    #[pyo3(signature = (camera=None, width=1280, height=720, *, samples=1, lights=None, background="sky", nthreads=0))]
    #[expect(clippy::too_many_arguments, reason = "they are Python's keywords")]
    fn render<'py>(
        &self,
        py: Python<'py>,
        camera: Option<&Bound<'py, PyAny>>,
        width: u32,
        height: u32,
        samples: u32,
        lights: Option<&Bound<'py, PyAny>>,
        background: &str,
        nthreads: usize,
    ) -> PyResult<Bound<'py, PyAny>> {
        let look = Look::new([width, height], samples, camera, lights, background)?;
        let nthreads = if nthreads == 0 { self.nthreads } else { nthreads };
        let frame = py.detach(|| {
            let state = self.lock();
            let (triangles, origin) = (state.instances.triangles(), self.origin.into());
            Frame { origin, ..Frame::from_triangles(triangles.positions.to_vec(), triangles.indices.to_vec()) }
        });
        render(py, nthreads, &Mutex::default(), &look, Subject::Frame(&frame))
    }

    /// Where points are in the own space of the geometry that they are on, before its transform.
    ///
    /// Parameters
    /// ----------
    /// geometry_ids, primitive_ids : array_like (...) uint32
    ///     The triangle that each point is on, as of `cast_rays`, `scan` and `see`.
    /// primitive_uvs : array_like (..., 2) float32
    ///     The weights of its second and third corner, which make the point of the geometry's own corners.
    ///
    /// Returns
    /// -------
    /// ndarray (..., 3) float64
    ///     NaN where there is no triangle.
    fn object_positions<'py>(
        &self,
        py: Python<'py>,
        geometry_ids: &Bound<'py, PyAny>,
        primitive_ids: &Bound<'py, PyAny>,
        primitive_uvs: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let weights = Rows::<f32, 2>::new("primitive_uvs", primitive_uvs)?;
        let ids = Own::of(weights.shape(), geometry_ids, primitive_ids)?;
        let (ids, of) = (ids.slices(), weights.of());
        let positions = self.ask(py, 0, |call, state| questions::object_positions(call, state, ids, of))?;
        hand_over_rows(py, positions, weights.shape())
    }

    /// Which of all triangles, in the order of `lit`'s faces, are a geometry's.
    ///
    /// Parameters
    /// ----------
    /// geometry_id : int
    ///     What `add_triangles` returned.
    ///
    /// Returns
    /// -------
    /// slice
    fn triangle_slice<'py>(&self, py: Python<'py>, geometry_id: usize) -> PyResult<Bound<'py, PySlice>> {
        let range = py.detach(|| geometry_of(&self.lock(), geometry_id).map(Instance::triangles))?;
        Ok(PySlice::new(py, range.start as isize, range.end as isize, 1))
    }

    /// Counts the triangles that no ray can hit, by reason.
    ///
    /// Returns
    /// -------
    /// dict
    ///     ``not_finite``: a corner is NaN or infinite; ``zero_area``: two corners are the same.
    fn omitted<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let omitted = self.ask(py, 0, |call, state| call.piece(|| state.omitted()))?;
        let dict = PyDict::new(py);
        dict.set_item("not_finite", omitted.not_finite.count)?;
        dict.set_item("zero_area", omitted.zero_area.count)?;
        Ok(dict)
    }

    fn __repr__(&self, py: Python<'_>) -> String {
        let (geometries, triangles) = py.detach(|| {
            let state = self.lock();
            (state.instances.all().len(), state.instances.triangles().len())
        });
        format!("<umbrage.RaycastingScene: {geometries} geometries, {triangles} triangles>")
    }
}
