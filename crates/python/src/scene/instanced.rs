//! `umbrage.InstancedScene`: meshes that stand in the world many times.

use std::sync::{Mutex, MutexGuard, PoisonError};

use glam::{DAffine3, DVec3, Vec3};
use pyo3::exceptions::PyIndexError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use umbrage::rays::{
    InstanceTree, InstancedTriangles, LightSource, LitBits, Placement, Ray, RayMasks, Rays, Receivers, Scanned,
    Triangles,
};
use umbrage::scene::BadInstance;

use super::answers::{Answers, INVALID_ID, Precision};
use super::arguments::{NewMesh, Sweeps, Targets};
use super::keys::Keys;
use super::masks::{self, MaskArgument};
use super::rays::RayArray;
use super::state::spread_bits;
use crate::arrays::{Numbers, Rows, affines, hand_over, shown};
use crate::errors::{bad_instance, expected};
use crate::light;
use crate::threads::{Call, in_pieces, pool};

#[doc = include_str!("docs/instanced.txt")]
#[pyclass(frozen, module = "umbrage")]
#[derive(Debug)]
pub(crate) struct InstancedScene {
    state: Mutex<State>,
    nthreads: usize,
}

#[derive(Debug, Default)]
struct State {
    meshes: Vec<(Vec<Vec3>, Vec<[u32; 3]>)>,
    placements: Vec<Placement>,
    tree: InstanceTree,
    is_current: bool,
}

/// Rays or lights of a piece.
const RAYS: usize = 1 << 20;
const LIGHTS: usize = 64;
/// Directions that become rays at once.
const DIRECTIONS: usize = 1 << 16;

impl State {
    /// Builds what changed, and answers a question.
    fn ask<R>(&mut self, question: impl FnOnce(&InstanceTree, &InstancedTriangles<'_>) -> R) -> R {
        let Self { meshes, placements, tree, is_current } = self;
        let meshes: Vec<Triangles<'_>> =
            meshes.iter().map(|(positions, indices)| Triangles { positions, indices }).collect();
        let scene = InstancedTriangles { meshes: &meshes, placements };
        if !std::mem::replace(is_current, true) {
            tree.build(&scene);
        }
        question(tree, &scene)
    }

    /// Adds hits to answers.
    fn append(&mut self, rays: Rays<'_>, masks: RayMasks<'_>, answers: &mut Answers) {
        let mut traced = Scanned::default();
        self.ask(|tree, scene| tree.trace(scene, rays, masks, &mut traced));
        answers.append(traced);
    }

    fn complete(&mut self, answers: &mut Answers, keys: Keys) {
        self.ask(|tree, scene| answers.complete(keys, |_, id| tree.corners(scene, id), |id| tree.of_triangle(id)));
    }

    fn mesh(&mut self, mesh: usize) -> PyResult<&mut (Vec<Vec3>, Vec<[u32; 3]>)> {
        let count = self.meshes.len();
        let missing = || PyIndexError::new_err(format!("mesh_id: expected one of {count} meshes, found {mesh}"));
        self.meshes.get_mut(mesh).ok_or_else(missing)
    }
}

impl InstancedScene {
    /// Waits for the current question to end. Only without Python's lock.
    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn ask<R: Send>(
        &self,
        py: Python<'_>,
        nthreads: usize,
        question: impl FnOnce(&Call, &mut State) -> PyResult<R> + Send,
    ) -> PyResult<R> {
        let nthreads = if nthreads == 0 { self.nthreads } else { nthreads };
        in_pieces(py, nthreads, |call| question(call, &mut self.lock()))
    }
}

#[pymethods]
impl InstancedScene {
    /// Stands for no geometry and no triangle: 0xFFFFFFFF.
    #[classattr]
    const INVALID_ID: u32 = INVALID_ID;

    #[new]
    #[pyo3(signature = (nthreads=0))]
    fn new(nthreads: usize) -> PyResult<Self> {
        pool(nthreads)?;
        Ok(Self { state: Mutex::default(), nthreads })
    }

    /// Adds a mesh, which is nowhere until `set_instances` places it.
    ///
    /// Parameters
    /// ----------
    /// vertex_positions, triangle_indices
    ///     As of `RaycastingScene.add_triangles`; an own transform of the mesh is ignored.
    ///
    /// Returns
    /// -------
    /// int
    ///     The mesh's id: how many were added before.
    #[pyo3(signature = (vertex_positions, triangle_indices=None))]
    fn add_mesh(
        &self,
        py: Python<'_>,
        vertex_positions: &Bound<'_, PyAny>,
        triangle_indices: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<usize> {
        let NewMesh { vertices, triangles, .. } = NewMesh::new(vertex_positions, triangle_indices, DVec3::ZERO)?;
        let (vertices, triangles): (&[Vec3], &[[u32; 3]]) = (vertices.of(), triangles.of());
        let most = triangles.as_flattened().iter().copied().max();
        if let Some(index) = most.filter(|&index| index as usize >= vertices.len()) {
            return Err(bad_instance(BadInstance::Index { index, vertices: vertices.len() }));
        }
        py.detach(|| {
            let mut state = self.lock();
            state.is_current = false;
            state.meshes.push((vertices.to_vec(), triangles.to_vec()));
            Ok(state.meshes.len() - 1)
        })
    }

    /// Moves the vertices of a mesh, in its own space.
    ///
    /// Parameters
    /// ----------
    /// mesh_id : int
    ///     What `add_mesh` returned.
    /// vertex_positions : array_like (N, 3) float32
    ///     As many as there are.
    fn update_mesh(&self, py: Python<'_>, mesh_id: usize, vertex_positions: &Bound<'_, PyAny>) -> PyResult<()> {
        let vertices = Rows::<f32, 3>::table("vertex_positions", "N", vertex_positions)?;
        let vertices: &[Vec3] = vertices.of();
        py.detach(|| {
            let mut state = self.lock();
            let (positions, _) = state.mesh(mesh_id)?;
            if positions.len() != vertices.len() {
                let wanted = shown(&[positions.len(), 3]);
                return Err(expected("vertex_positions", &wanted, shown(&[vertices.len(), 3])));
            }
            positions.copy_from_slice(vertices);
            state.tree.forget(mesh_id);
            state.is_current = false;
            Ok(())
        })
    }

    /// Places meshes in the world, in place of all earlier instances.
    ///
    /// Parameters
    /// ----------
    /// mesh_ids : int or array_like (N,) uint32
    ///     The mesh of each instance, or that of all.
    /// world_from_mesh : array_like (N, 4, 4) or (N, 3, 4) float64
    ///     The transform of each: columns vectors, and 0, 0, 0, 1 as the last row. Positions are computed in float64 and rounded
    ///     to float32 once. Any transform will do; those that flatten a mesh or take it far away cost more memory.
    /// mask : int or array_like (N,) uint32, optional
    ///     The mask of each instance, or that of all: rays see it only where their mask and this one have a bit in common.
    ///
    /// Raises
    /// ------
    /// IndexError
    ///     Where there is no such mesh.
    /// ValueError
    ///     For arrays of another shape, or more than 4294967295 triangles in the world.
    #[pyo3(signature = (mesh_ids, world_from_mesh, *, mask=None))]
    fn set_instances(
        &self,
        py: Python<'_>,
        mesh_ids: &Bound<'_, PyAny>,
        world_from_mesh: &Bound<'_, PyAny>,
        mask: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<()> {
        let transforms: Vec<DAffine3> = affines("world_from_mesh", world_from_mesh)?;
        let shape = [transforms.len()];
        let (mask, numbers) =
            (MaskArgument::new(mask, &shape)?, Numbers::<u32>::one_or_each("mesh_ids", mesh_ids, &shape)?);
        let mesh = |index: usize| numbers.one().unwrap_or_else(|| numbers.slice()[index]);
        let meshes: Vec<u32> = (0..transforms.len()).map(mesh).collect();
        let masks = mask.rays();
        py.detach(|| {
            let mut state = self.lock();
            if let Some(&most) = meshes.iter().max() {
                state.mesh(most as usize)?;
            }
            let triangles: usize = meshes.iter().map(|&mesh| state.meshes[mesh as usize].1.len()).sum();
            if triangles >= INVALID_ID as usize {
                return Err(bad_instance(BadInstance::TooMany));
            }
            let places = meshes.iter().zip(&transforms).enumerate();
            let placed = places.map(|(index, (&mesh, &world_from_mesh))| Placement {
                mesh,
                world_from_mesh,
                mask: masks.at(index),
            });
            state.placements.clear();
            state.placements.extend(placed);
            state.is_current = false;
            Ok(())
        })
    }

    /// Finds what any rays hit first, as `RaycastingScene.cast_rays`; ``geometry_ids`` are the numbers of instances.
    #[pyo3(signature = (rays, nthreads=0, *, mask=None, keys=None))]
    fn cast_rays<'py>(
        &self,
        py: Python<'py>,
        rays: &Bound<'py, PyAny>,
        nthreads: usize,
        mask: Option<&Bound<'py, PyAny>>,
        keys: Option<Vec<String>>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let (rays, keys) = (RayArray::new(rays, DVec3::ZERO)?, Keys::new(keys)?);
        let mask = MaskArgument::new(mask, rays.shape())?;
        let (these, masks) = (rays.rays(), mask.rays());
        let question = |call: &Call, state: &mut State| {
            let mut answers = Answers::default();
            for (number, chunk) in these.chunks(RAYS).enumerate() {
                let masks = masks::part(masks, number * RAYS, RAYS);
                call.piece(|| state.append(chunk, masks, &mut answers))?;
            }
            call.piece(|| state.complete(&mut answers, keys))?;
            Ok(answers)
        };
        self.ask(py, nthreads, question)?.into_dict(py, rays.shape(), rays.precision(), keys)
    }

    /// Finds what directions from one or more origins hit first, as `RaycastingScene.scan` with one hit for each direction.
    #[pyo3(signature = (origin, directions, *, t_min=0.0, t_max=f64::INFINITY, each=false, mask=None, nthreads=0, keys=None))]
    #[expect(clippy::too_many_arguments, reason = "they are Python's keywords")]
    fn scan<'py>(
        &self,
        py: Python<'py>,
        origin: &Bound<'py, PyAny>,
        directions: &Bound<'py, PyAny>,
        t_min: f64,
        t_max: f64,
        each: bool,
        mask: Option<&Bound<'py, PyAny>>,
        nthreads: usize,
        keys: Option<Vec<String>>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let (sweeps, keys) = (Sweeps::new(origin, directions, each, mask, DVec3::ZERO)?, Keys::new(keys)?);
        let pieces = sweeps.pieces();
        let question = |call: &Call, state: &mut State| {
            let (mut answers, mut rays) = (Answers::default(), Vec::new());
            for (sweep, mask) in pieces.sweeps() {
                for directions in sweep.directions.chunks(DIRECTIONS) {
                    let ray = |direction: &Vec3| Ray { t_min, t_max, ..Ray::new(sweep.origin, direction.as_dvec3()) };
                    rays.clear();
                    rays.extend(directions.iter().map(ray));
                    call.piece(|| state.append(Rays::These(&rays), RayMasks::All(mask), &mut answers))?;
                }
            }
            call.piece(|| state.complete(&mut answers, keys))?;
            Ok(answers)
        };
        self.ask(py, nthreads, question)?.into_dict(py, &sweeps.shape(), Precision::Double, keys)
    }

    /// Finds which points, or centroids of all instances' triangles, each light reaches, as `RaycastingScene.lit`.
    #[pyo3(signature = (lights, *, points=None, faces=false, geometry_ids=None, primitive_ids=None, mask=None, nthreads=0))]
    #[expect(clippy::too_many_arguments, reason = "they are Python's keywords")]
    fn lit<'py>(
        &self,
        py: Python<'py>,
        lights: &Bound<'py, PyAny>,
        points: Option<&Bound<'py, PyAny>>,
        faces: bool,
        geometry_ids: Option<&Bound<'py, PyAny>>,
        primitive_ids: Option<&Bound<'py, PyAny>>,
        mask: Option<&Bound<'py, PyAny>>,
        nthreads: usize,
    ) -> PyResult<Bound<'py, PyAny>> {
        let lights: Vec<LightSource> = light::lights(lights, DVec3::ZERO)?;
        let targets = Targets::new(points, faces, geometry_ids, primitive_ids, DVec3::ZERO)?;
        let mask = MaskArgument::new(mask, &[lights.len()])?;
        let (positions, own, masks) = (targets.positions(), targets.own(), mask.rays());
        let question = |call: &Call, state: &mut State| {
            let own = own.map_or(Ok(Vec::new()), |own| state.ids(own))?;
            let receivers = positions.map_or(Receivers::Faces, |positions| Receivers::Points { positions, own: &own });
            let (mut lit, mut bits) = (Vec::new(), LitBits::default());
            for (number, lights) in lights.chunks(LIGHTS).enumerate() {
                let masks = masks::part(masks, number * LIGHTS, LIGHTS);
                call.piece(|| {
                    state.ask(|tree, scene| tree.lit(scene, receivers, lights, masks, &mut bits));
                    (0..lights.len()).for_each(|light| spread_bits(bits.of_light(light), bits.points(), &mut lit));
                })?;
            }
            Ok((lit, state.ask(|_, scene| scene.len())))
        };
        let (lit, triangles) = self.ask(py, nthreads, question)?;
        hand_over(py, lit, &targets.shape(lights.len(), triangles))
    }
}

impl State {
    /// The ids among all triangles of triangles of instances.
    fn ids(&mut self, [geometries, triangles]: [&[u32]; 2]) -> PyResult<Vec<u32>> {
        self.ask(|tree, scene| {
            let id = |(&geometry, &triangle): (&u32, &u32)| {
                if geometry == INVALID_ID || triangle == INVALID_ID {
                    return Ok(INVALID_ID);
                }
                let count = scene.placements.len();
                let placement = scene.placements.get(geometry as usize).ok_or_else(|| {
                    expected("geometry_ids", &format!("ids below {count}, the number of instances"), geometry)
                })?;
                let count = scene.meshes[placement.mesh as usize].len();
                if triangle as usize >= count {
                    let wanted = format!("ids below {count}, the number of triangles of instance {geometry}");
                    return Err(expected("primitive_ids", &wanted, triangle));
                }
                Ok(tree.first_of(geometry as usize) + triangle)
            };
            geometries.iter().zip(triangles).map(id).collect()
        })
    }
}
