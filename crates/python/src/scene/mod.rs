//! `umbrage.RaycastingScene`: meshes, and queries by rays, directions, cameras and lights.

mod answers;
mod arguments;
mod ask;
mod create_rays;
mod distances;
mod facing;
mod instanced;
mod keys;
mod masks;
mod moving;
mod questions;
mod rays;
mod state;
mod thickness;

use std::sync::Mutex;

use glam::{DVec3, Vec3};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PySlice, PyTuple};
use umbrage::rays::Choice;
use umbrage::scene::Frame;

use crate::animated::Instance;
use crate::arrays::{Rows, affine, counted, hand_over, hand_over_rows, shown};
use crate::camera::Camera;
use crate::errors::{bad_instance, expected};
use crate::light;
use crate::pickled::pickled;
use crate::picture::{Look, Subject, render};
use crate::threads::Call;
pub(crate) use instanced::InstancedScene;
pub(crate) use moving::MovingScene;

use answers::{INVALID_ID, Precision};
use arguments::{NewMesh, Own, Points, Sweeps, Targets, hits_of_each, origin_or_zero, samples_of_each};
use ask::geometry_of;
use create_rays::{Lidar, Pinhole};
use keys::Keys;
use masks::MaskArgument;
use questions::Receiving;
use rays::RayArray;
use state::State;

#[doc = include_str!("docs/class.txt")]
#[pyclass(frozen, module = "umbrage")]
#[derive(Debug)]
pub(crate) struct RaycastingScene {
    state: Mutex<State>,
    nthreads: usize,
    /// The point of the world that coordinates count from.
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
        Self::with_origin(nthreads, origin_or_zero(origin)?)
    }

    #[doc = include_str!("docs/add_triangles.txt")]
    #[pyo3(signature = (vertex_positions, triangle_indices=None, *, mask=0xFFFF_FFFF))]
    fn add_triangles(
        &self,
        py: Python<'_>,
        vertex_positions: &Bound<'_, PyAny>,
        triangle_indices: Option<&Bound<'_, PyAny>>,
        mask: u32,
    ) -> PyResult<u32> {
        let NewMesh { vertices, triangles, world_from_object } =
            NewMesh::new(vertex_positions, triangle_indices, self.origin)?;
        let (vertices, triangles) = (vertices.of(), triangles.of());
        py.detach(|| self.lock().add(vertices, triangles, world_from_object, mask)).map_err(bad_instance)
    }

    #[doc = include_str!("docs/remove.txt")]
    fn remove(&self, py: Python<'_>, geometry_id: usize) -> PyResult<()> {
        py.detach(|| {
            let mut state = self.lock();
            geometry_of(&state, geometry_id)?;
            state.remove(geometry_id as u32).map_err(bad_instance)
        })
    }

    #[doc = include_str!("docs/update_vertices.txt")]
    fn update_vertices(&self, py: Python<'_>, geometry_id: usize, vertex_positions: &Bound<'_, PyAny>) -> PyResult<()> {
        let vertices = Rows::<f32, 3>::table("vertex_positions", "N", vertex_positions)?;
        let vertices: &[Vec3] = vertices.of();
        py.detach(|| {
            let mut state = self.lock();
            let count = geometry_of(&state, geometry_id)?.vertices();
            if count != vertices.len() {
                let [wanted, found] = [count, vertices.len()].map(|count| format!("shape {}", shown(&[count, 3])));
                return Err(expected("vertex_positions", &wanted, found));
            }
            state.change().update(geometry_id as u32, vertices);
            Ok(())
        })
    }

    #[doc = include_str!("docs/set_transform.txt")]
    fn set_transform(&self, py: Python<'_>, geometry_id: usize, world_from_object: &Bound<'_, PyAny>) -> PyResult<()> {
        let matrix = affine("world_from_object", world_from_object)?;
        py.detach(|| {
            let mut state = self.lock();
            geometry_of(&state, geometry_id)?;
            state.change().set_transform(geometry_id as u32, matrix);
            Ok(())
        })
    }

    #[doc = include_str!("docs/cast_rays.txt")]
    #[pyo3(signature = (rays, nthreads=0, *, mask=None, keys=None))]
    fn cast_rays<'py>(
        &self,
        py: Python<'py>,
        rays: &Bound<'py, PyAny>,
        nthreads: usize,
        mask: Option<&Bound<'py, PyAny>>,
        keys: Option<Vec<String>>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let (rays, keys) = (RayArray::new(rays, self.origin)?, Keys::new(keys)?);
        let masks = MaskArgument::new(mask, rays.shape())?;
        let (these, precision) = ((rays.rays(), masks.rays()), rays.precision());
        let answers = self.ask(py, nthreads, |call, state| questions::cast(call, state, these, keys))?;
        answers.into_dict(py, rays.shape(), precision, keys)
    }

    /// Names of the structures that answered the last `cast_rays`, one for each million of rays: ``"scanner"`` or
    /// ``"hierarchy"``. Answers don't depend on them.
    #[getter]
    fn last_structures(&self, py: Python<'_>) -> Vec<&'static str> {
        py.detach(|| self.lock().answered.iter().copied().map(Choice::name).collect())
    }

    #[doc = include_str!("docs/test_occlusions.txt")]
    #[pyo3(signature = (rays, tnear=0.0, tfar=f64::INFINITY, nthreads=0, *, mask=None))]
    fn test_occlusions<'py>(
        &self,
        py: Python<'py>,
        rays: &Bound<'py, PyAny>,
        tnear: f64,
        tfar: f64,
        nthreads: usize,
        mask: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let rays = RayArray::new(rays, self.origin)?;
        let masks = MaskArgument::new(mask, rays.shape())?;
        let these = (rays.rays(), masks.rays());
        let hit = self.ask(py, nthreads, |call, state| questions::any(call, state, these, [tnear, tfar]))?;
        hand_over(py, hit, rays.shape())
    }

    #[doc = include_str!("docs/count_intersections.txt")]
    #[pyo3(signature = (rays, nthreads=0, *, mask=None))]
    fn count_intersections<'py>(
        &self,
        py: Python<'py>,
        rays: &Bound<'py, PyAny>,
        nthreads: usize,
        mask: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let rays = RayArray::new(rays, self.origin)?;
        let masks = MaskArgument::new(mask, rays.shape())?;
        let these = (rays.rays(), masks.rays());
        let counts = self.ask(py, nthreads, |call, state| questions::count(call, state, these))?;
        hand_over(py, counts, rays.shape())
    }

    #[doc = include_str!("docs/list_intersections.txt")]
    #[pyo3(signature = (rays, nthreads=0, *, mask=None))]
    fn list_intersections<'py>(
        &self,
        py: Python<'py>,
        rays: &Bound<'py, PyAny>,
        nthreads: usize,
        mask: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let rays = RayArray::new(rays, self.origin)?;
        let masks = MaskArgument::new(mask, rays.shape())?;
        let (these, precision) = ((rays.rays(), masks.rays()), rays.precision());
        let listed = self.ask(py, nthreads, |call, state| questions::list(call, state, these))?;
        let hits = listed.rays.len();
        let dict = listed.hits.into_dict(py, &[hits], precision, Keys::WITHOUT_NORMALS)?;
        dict.set_item("ray_splits", hand_over(py, listed.splits, &[these.0.len() + 1])?)?;
        dict.set_item("ray_ids", hand_over(py, listed.rays, &[hits])?)?;
        Ok(dict)
    }

    #[doc = include_str!("docs/scan.txt")]
    #[pyo3(signature = (origin, directions, *, returns=None, t_min=0.0, t_max=f64::INFINITY, each=false, mask=None, nthreads=0, keys=None))]
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
        mask: Option<&Bound<'py, PyAny>>,
        nthreads: usize,
        keys: Option<Vec<String>>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let (most, keys) = (hits_of_each(returns)?, Keys::new(keys)?);
        let sweeps = Sweeps::new(origin, directions, each, mask, self.origin)?;
        let pieces = sweeps.pieces();
        let question =
            |call: &Call, state: &mut State| questions::scan(call, state, pieces, [t_min, t_max], most, keys);
        let answers = self.ask(py, nthreads, question)?;
        let mut shape = sweeps.shape();
        shape.extend(returns);
        answers.into_dict(py, &shape, Precision::Double, keys)
    }

    #[doc = include_str!("docs/scan_any.txt")]
    #[pyo3(signature = (origin, directions, *, t_min=0.0, t_max=f64::INFINITY, each=false, mask=None, nthreads=0))]
    #[expect(clippy::too_many_arguments, reason = "they are Python's keywords")]
    fn scan_any<'py>(
        &self,
        py: Python<'py>,
        origin: &Bound<'py, PyAny>,
        directions: &Bound<'py, PyAny>,
        t_min: f64,
        t_max: f64,
        each: bool,
        mask: Option<&Bound<'py, PyAny>>,
        nthreads: usize,
    ) -> PyResult<Bound<'py, PyAny>> {
        let sweeps = Sweeps::new(origin, directions, each, mask, self.origin)?;
        let pieces = sweeps.pieces();
        let question = |call: &Call, state: &mut State| questions::scan_any(call, state, pieces, [t_min, t_max]);
        let hit = self.ask(py, nthreads, question)?;
        hand_over(py, hit, &sweeps.shape())
    }

    #[doc = include_str!("docs/see.txt")]
    #[pyo3(signature = (camera, width=None, height=None, nthreads=0, *, mask=0xFFFF_FFFF, keys=None))]
    #[expect(clippy::too_many_arguments, reason = "they are Python's keywords")]
    fn see<'py>(
        &self,
        py: Python<'py>,
        camera: &Camera,
        width: Option<u32>,
        height: Option<u32>,
        nthreads: usize,
        mask: u32,
        keys: Option<Vec<String>>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let (image, keys) = (camera.image(width, height, self.origin)?, Keys::new(keys)?);
        let answers = self.ask(py, nthreads, |call, state| questions::see(call, state, &image, mask, keys))?;
        answers.into_dict(py, &image.shape(), Precision::Double, keys)
    }

    #[doc = include_str!("docs/create_rays_pinhole.txt")]
    #[staticmethod]
    #[pyo3(signature = (*arguments, **named))]
    fn create_rays_pinhole<'py>(
        py: Python<'py>,
        arguments: &Bound<'py, PyTuple>,
        named: Option<&Bound<'py, PyDict>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let camera = Pinhole::new(arguments, named)?;
        hand_over_rows(py, camera.rays(), &camera.shape)
    }

    #[doc = include_str!("docs/create_rays_lidar.txt")]
    #[staticmethod]
    #[pyo3(signature = (elevations_deg, columns, world_from_sensor=None, *, period=0.0, velocity=None, angular_velocity_deg=None))]
    fn create_rays_lidar<'py>(
        py: Python<'py>,
        elevations_deg: &Bound<'py, PyAny>,
        columns: &Bound<'py, PyAny>,
        world_from_sensor: Option<&Bound<'py, PyAny>>,
        period: f64,
        velocity: Option<&Bound<'py, PyAny>>,
        angular_velocity_deg: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let rates = [velocity, angular_velocity_deg];
        let lidar = Lidar::new(elevations_deg, columns, world_from_sensor, rates, period)?;
        hand_over_rows(py, lidar.rays(), &lidar.shape())
    }

    #[doc = include_str!("docs/closest_points.txt")]
    #[pyo3(signature = (query_points, nthreads=0))]
    fn compute_closest_points<'py>(
        &self,
        py: Python<'py>,
        query_points: &Bound<'py, PyAny>,
        nthreads: usize,
    ) -> PyResult<Bound<'py, PyDict>> {
        let points = Points::new("query_points", query_points, self.origin)?;
        let positions = points.positions();
        self.ask(py, nthreads, |call, state| distances::closest_points(call, state, positions))?.into_dict(py, &points)
    }

    /// Finds how far the nearest surface is from each point: as `compute_signed_distance`, but nowhere below zero.
    #[pyo3(signature = (query_points, nthreads=0))]
    fn compute_distance<'py>(
        &self,
        py: Python<'py>,
        query_points: &Bound<'py, PyAny>,
        nthreads: usize,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.ask_of_points(py, query_points, nthreads, |call, state, points| {
            distances::distances(call, state, points, false)
        })
    }

    #[doc = include_str!("docs/signed_distance.txt")]
    #[pyo3(signature = (query_points, nthreads=0, nsamples=1))]
    fn compute_signed_distance<'py>(
        &self,
        py: Python<'py>,
        query_points: &Bound<'py, PyAny>,
        nthreads: usize,
        nsamples: usize,
    ) -> PyResult<Bound<'py, PyAny>> {
        let _ = nsamples;
        self.ask_of_points(py, query_points, nthreads, |call, state, points| {
            distances::distances(call, state, points, true)
        })
    }

    /// Finds which points are inside of closed meshes: (...) float32, 1 inside and 0 outside, as `compute_signed_distance` tells.
    /// `nsamples` makes no difference there either.
    #[pyo3(signature = (query_points, nthreads=0, nsamples=1))]
    fn compute_occupancy<'py>(
        &self,
        py: Python<'py>,
        query_points: &Bound<'py, PyAny>,
        nthreads: usize,
        nsamples: usize,
    ) -> PyResult<Bound<'py, PyAny>> {
        let _ = nsamples;
        self.ask_of_points(py, query_points, nthreads, distances::occupancy)
    }

    #[doc = include_str!("docs/winding_numbers.txt")]
    #[pyo3(signature = (query_points, nthreads=0))]
    fn compute_winding_numbers<'py>(
        &self,
        py: Python<'py>,
        query_points: &Bound<'py, PyAny>,
        nthreads: usize,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.ask_of_points(py, query_points, nthreads, distances::winding_numbers)
    }

    #[doc = include_str!("docs/list_overlapping.txt")]
    #[pyo3(signature = (boxes, nthreads=0))]
    fn list_overlapping<'py>(
        &self,
        py: Python<'py>,
        boxes: &Bound<'py, PyAny>,
        nthreads: usize,
    ) -> PyResult<Bound<'py, PyDict>> {
        self.ask_of_boxes(py, boxes, nthreads)
    }

    #[doc = include_str!("docs/thickness.txt")]
    #[pyo3(signature = (points, geometry_ids, primitive_ids, nthreads=0))]
    fn compute_thickness<'py>(
        &self,
        py: Python<'py>,
        points: &Bound<'py, PyAny>,
        geometry_ids: &Bound<'py, PyAny>,
        primitive_ids: &Bound<'py, PyAny>,
        nthreads: usize,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.ask_for_thickness(py, points, [geometry_ids, primitive_ids], nthreads)
    }

    #[doc = include_str!("docs/lit.txt")]
    #[pyo3(signature = (lights, *, points=None, faces=false, geometry_ids=None, primitive_ids=None, facing=false, mask=None, nthreads=0))]
    #[expect(clippy::too_many_arguments, reason = "they are Python's keywords")]
    fn lit<'py>(
        &self,
        py: Python<'py>,
        lights: &Bound<'py, PyAny>,
        points: Option<&Bound<'py, PyAny>>,
        faces: bool,
        geometry_ids: Option<&Bound<'py, PyAny>>,
        primitive_ids: Option<&Bound<'py, PyAny>>,
        facing: bool,
        mask: Option<&Bound<'py, PyAny>>,
        nthreads: usize,
    ) -> PyResult<Bound<'py, PyAny>> {
        let lights = light::lights(lights, self.origin)?;
        let masks = MaskArgument::new(mask, &[lights.len()])?;
        let masks = masks.rays();
        let targets = Targets::new(points, faces, geometry_ids, primitive_ids, self.origin)?;
        if facing {
            targets.expect_sides("facing")?;
        }
        let receiving = Receiving { points: targets.positions(), own: targets.own() };
        let question = |call: &Call, state: &mut State| questions::lit(call, state, receiving, facing, &lights, masks);
        let (lit, triangles) = self.ask(py, nthreads, question)?;
        hand_over(py, lit, &targets.shape(lights.len(), triangles))
    }

    #[doc = include_str!("docs/incidence.txt")]
    #[pyo3(signature = (lights, *, points=None, faces=false, geometry_ids=None, primitive_ids=None, nthreads=0))]
    #[expect(clippy::too_many_arguments, reason = "they are Python's keywords")]
    fn incidence<'py>(
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
        let targets = Targets::new(points, faces, geometry_ids, primitive_ids, self.origin)?;
        targets.expect_sides("points")?;
        let receiving = Receiving { points: targets.positions(), own: targets.own() };
        let question = |call: &Call, state: &mut State| questions::incidence(call, state, receiving, &lights);
        let (cosines, triangles) = self.ask(py, nthreads, question)?;
        hand_over(py, cosines, &targets.shape(lights.len(), triangles))
    }

    #[doc = include_str!("docs/lit_areas.txt")]
    #[pyo3(signature = (lights, *, samples=64, mask=None, nthreads=0))]
    fn lit_areas<'py>(
        &self,
        py: Python<'py>,
        lights: &Bound<'py, PyAny>,
        samples: u32,
        mask: Option<&Bound<'py, PyAny>>,
        nthreads: usize,
    ) -> PyResult<Bound<'py, PyDict>> {
        let lights = light::lights(lights, self.origin)?;
        let masks = MaskArgument::new(mask, &[lights.len()])?;
        let masks = masks.rays();
        samples_of_each(samples)?;
        let question = |call: &Call, state: &mut State| questions::lit_areas(call, state, &lights, masks, samples);
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
    /// width, height, samples, lights, background, exposure, nthreads
    ///     As of `Scene.render`; without lights there is only that of the background.
    ///
    /// Returns
    /// -------
    /// Picture (height, width, 3) uint8, or (height, width, 4) with ``background="none"``
    #[pyo3(signature = (camera=None, width=None, height=None, *, samples=1, lights=None, background="sky", exposure=None, nthreads=0))]
    #[expect(clippy::too_many_arguments, reason = "they are Python's keywords")]
    fn render<'py>(
        &self,
        py: Python<'py>,
        camera: Option<&Bound<'py, PyAny>>,
        width: Option<u32>,
        height: Option<u32>,
        samples: u32,
        lights: Option<&Bound<'py, PyAny>>,
        background: &str,
        exposure: Option<&Bound<'py, PyAny>>,
        nthreads: usize,
    ) -> PyResult<Bound<'py, PyAny>> {
        let look = Look::new([width, height], samples, camera, lights, background)?.with_exposure(exposure)?;
        let nthreads = if nthreads == 0 { self.nthreads } else { nthreads };
        let frame = py.detach(|| {
            let state = self.lock();
            let (triangles, origin) = (state.instances.triangles(), self.origin.into());
            Frame { origin, ..Frame::from_triangles(triangles.positions.to_vec(), triangles.indices.to_vec()) }
        });
        render(py, nthreads, &Mutex::default(), &look, Subject::Frame(&frame))
    }

    #[doc = include_str!("docs/object_positions.txt")]
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

    #[doc = include_str!("docs/triangle_slice.txt")]
    fn triangle_slice<'py>(&self, py: Python<'py>, geometry_id: usize) -> PyResult<Bound<'py, PySlice>> {
        let range = py.detach(|| geometry_of(&self.lock(), geometry_id).map(umbrage::scene::Instance::triangles))?;
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

    /// Meshes as they were added, with `None` for those that were removed, and the mask of each.
    #[staticmethod]
    #[pyo3(signature = (nthreads, meshes, origin=[0.0; 3], masks=Vec::new()))]
    fn _restore(
        py: Python<'_>,
        nthreads: usize,
        meshes: Vec<Option<Bound<'_, PyAny>>>,
        origin: [f64; 3],
        masks: Vec<u32>,
    ) -> PyResult<Self> {
        let scene = Self::with_origin(nthreads, origin.into())?;
        for (id, mesh) in meshes.into_iter().enumerate() {
            match mesh {
                Some(mesh) => {
                    scene.add_triangles(py, &mesh, None, masks.get(id).copied().unwrap_or(u32::MAX))?;
                }
                None => scene.lock().skip(id).map_err(bad_instance)?,
            }
        }
        Ok(scene)
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        let state = py.detach(|| self.lock().copy());
        let ids = (0..state.instances.all().len()).map(|id| (id as u32, state.removed.contains(&id)));
        let mesh =
            |(id, is_removed): (u32, bool)| (!is_removed).then(|| Instance::new(py, &state.instances, id)).transpose();
        let meshes = ids.map(mesh).collect::<PyResult<Vec<Option<Instance>>>>()?;
        let masks: Vec<u32> = (0..meshes.len()).map(|id| state.mask(id)).collect();
        pickled::<Self>(py, (self.nthreads, meshes, self.origin.to_array(), masks))
    }

    fn __copy__(&self, py: Python<'_>) -> Self {
        let state = py.detach(|| self.lock().copy());
        Self { state: Mutex::new(state), nthreads: self.nthreads, origin: self.origin }
    }

    fn __deepcopy__(&self, py: Python<'_>, _memo: &Bound<'_, PyAny>) -> Self {
        self.__copy__(py)
    }

    fn __repr__(&self, py: Python<'_>) -> String {
        let (geometries, triangles) = py.detach(|| {
            let state = self.lock();
            (state.instances.all().len() - state.removed.len(), state.instances.triangles().len())
        });
        let geometries = counted(geometries, "geometry", "geometries");
        let triangles = counted(triangles, "triangle", "triangles");
        let threads = if self.nthreads == 0 { String::new() } else { format!(", nthreads={}", self.nthreads) };
        let is_far = self.origin != DVec3::ZERO;
        let origin = if is_far { format!(", origin={:?}", self.origin.to_array()) } else { String::new() };
        format!("<umbrage.RaycastingScene: {geometries}, {triangles}{threads}{origin}>")
    }
}
