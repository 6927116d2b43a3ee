//! Arguments of several questions.

use glam::{DAffine3, DVec3, Vec3};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyTuple;
use umbrage::rays::{Masks, RayMasks, Sweep};

use super::masks::MaskArgument;
use crate::animated::Frame;
use crate::arrays::{Numbers, Rows, affine, other_array, world_point};
use crate::errors::expected;

/// Number of directions between two checks for signals.
const DIRECTIONS_AT_ONCE: usize = 1 << 22;

/// Origins with their directions.
pub(super) struct Sweeps<'py> {
    origins: Rows<'py, f64, 3>,
    /// From the scene's origin.
    local_origins: Vec<DVec3>,
    directions: Rows<'py, f32, 3>,
    /// Whether each origin has directions of its own.
    each: bool,
    /// One for all origins, or one for each.
    masks: MaskArgument<'py>,
}

/// The same, without Python.
#[derive(Clone, Copy)]
pub(super) struct Pieces<'a> {
    origins: &'a [DVec3],
    directions: &'a [Vec3],
    each: bool,
    masks: RayMasks<'a>,
}

/// Directions from one origin, and their mask.
pub(super) type MaskedSweep<'a> = (Sweep<'a>, u32);

impl<'py> Sweeps<'py> {
    /// In a scene whose coordinates count from `scene_origin`.
    pub(super) fn new(
        origin: &Bound<'py, PyAny>,
        directions: &Bound<'py, PyAny>,
        each: bool,
        mask: Option<&Bound<'py, PyAny>>,
        scene_origin: DVec3,
    ) -> PyResult<Self> {
        let origins = Rows::<f64, 3>::new("origin", origin)?;
        if origins.shape().len() > 1 {
            return Err(other_array::<f64>("origin", "(3,) or (S, 3)", origin));
        }
        let (given, directions) = (directions, Rows::new("directions", directions)?);
        let local_origins = origins.of::<DVec3>().iter().map(|&origin| origin - scene_origin).collect();
        let masks = MaskArgument::new(mask, origins.shape())?;
        let sweeps = Self { origins, local_origins, directions, each, masks };
        if each
            && (sweeps.origins.shape().is_empty()
                || sweeps.directions.shape().first() != sweeps.origins.shape().first())
        {
            return Err(match sweeps.origins.shape() {
                [] => PyValueError::new_err("directions: expected each=False, as there is one origin, found each=True"),
                [origins, ..] => other_array::<f32>("directions", &format!("({origins}, ..., 3)"), given),
            });
        }
        Ok(sweeps)
    }

    /// The shape of the answers.
    pub(super) fn shape(&self) -> Vec<usize> {
        let directions = self.directions.shape();
        let own = if self.each { &directions[1..] } else { directions };
        [self.origins.shape(), own].concat()
    }

    pub(super) fn pieces(&self) -> Pieces<'_> {
        let Self { local_origins, directions, each, masks, .. } = self;
        Pieces { origins: local_origins, directions: directions.of(), each: *each, masks: masks.rays() }
    }
}

impl<'a> Pieces<'a> {
    /// The sweeps, in pieces of at most [`DIRECTIONS_AT_ONCE`] directions.
    pub(super) fn sweeps(self) -> impl Iterator<Item = MaskedSweep<'a>> {
        let Self { origins, directions, each, masks } = self;
        let masks = Masks { rays: masks, ..Masks::default() };
        let of_each = if each { directions.len() / origins.len().max(1) } else { directions.len() };
        origins.iter().enumerate().flat_map(move |(index, &origin)| {
            let first = if each { index * of_each } else { 0 };
            let own = &directions[first..first + of_each];
            let mask = masks.of_ray(index);
            own.chunks(DIRECTIONS_AT_ONCE).map(move |directions| (Sweep { origin, directions }, mask))
        })
    }
}

/// A mesh to add.
pub(super) struct NewMesh<'py> {
    pub(super) vertices: Rows<'py, f32, 3>,
    pub(super) triangles: Rows<'py, u32, 3>,
    /// Its transform to the world; `None` if its vertices count from the scene's origin.
    pub(super) world_from_object: Option<DAffine3>,
}

impl<'py> NewMesh<'py> {
    /// Takes vertices and triangles, or one value that has both, for a scene with this origin.
    pub(super) fn new(
        mesh: &Bound<'py, PyAny>,
        triangles: Option<&Bound<'py, PyAny>>,
        origin: DVec3,
    ) -> PyResult<Self> {
        let mut world_from_object = None;
        let (vertices, triangles) = match triangles {
            Some(triangles) => (mesh.clone(), triangles.clone()),
            None if mesh.is_instance_of::<PyTuple>() => mesh
                .extract()
                .map_err(|_| PyValueError::new_err("vertex_positions: expected a tuple of vertices and triangles"))?,
            None => {
                let names = ["faces", "triangles"];
                let has = |name: &&&str| mesh.hasattr(**name).unwrap_or_default();
                let name = names.iter().find(has).filter(|_| mesh.hasattr("vertices").unwrap_or_default());
                let missing = || PyValueError::new_err("triangle_indices: expected shape (M, 3), found None");
                let triangles = mesh.getattr(*name.ok_or_else(missing)?)?;
                if let Some(matrix) = mesh.getattr_opt("world_from_object")? {
                    world_from_object = Some(affine("world_from_object", &matrix)?);
                }
                if let Ok(frame) = mesh.cast::<Frame>() {
                    let of_frame = DVec3::from(frame.get().origin);
                    world_from_object = (of_frame != origin).then(|| DAffine3::from_translation(of_frame));
                }
                (mesh.getattr("vertices")?, triangles)
            }
        };
        let vertices = Rows::table("vertex_positions", "N", &vertices)?;
        let triangles = Rows::table("triangle_indices", "M", &triangles)?;
        Ok(Self { vertices, triangles, world_from_object })
    }
}

/// The triangle of each point.
pub(super) struct Own<'py>([Numbers<'py, u32>; 2]);

impl<'py> Own<'py> {
    /// `None` where there are no points, or both arrays of ids are missing.
    pub(super) fn new(
        shape: Option<&[usize]>,
        geometries: Option<&Bound<'py, PyAny>>,
        triangles: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Option<Self>> {
        match (shape, geometries, triangles) {
            (_, None, None) => Ok(None),
            (Some(shape), Some(geometries), Some(triangles)) => Self::of(shape, geometries, triangles).map(Some),
            (None, ..) => {
                Err(PyValueError::new_err("geometry_ids, primitive_ids: expected none, as there are no points"))
            }
            _ => Err(PyValueError::new_err("geometry_ids, primitive_ids: expected both of them or neither")),
        }
    }

    /// One for each point of a shape.
    pub(super) fn of(shape: &[usize], geometries: &Bound<'py, PyAny>, triangles: &Bound<'py, PyAny>) -> PyResult<Self> {
        let geometries = Numbers::new("geometry_ids", geometries, shape)?;
        let triangles = Numbers::new("primitive_ids", triangles, shape)?;
        Ok(Self([geometries, triangles]))
    }

    pub(super) fn slices(&self) -> [&[u32]; 2] {
        [self.0[0].slice(), self.0[1].slice()]
    }
}

/// Points in a scene with an origin.
pub(super) struct Points<'py> {
    /// `None` where they were moved.
    rows: Option<Rows<'py, f32, 3>>,
    moved: Vec<Vec3>,
    shape: Vec<usize>,
}

impl<'py> Points<'py> {
    pub(super) fn new(name: &str, value: &Bound<'py, PyAny>, origin: DVec3) -> PyResult<Self> {
        if origin == DVec3::ZERO {
            let rows = Rows::new(name, value)?;
            let shape = rows.shape().to_vec();
            return Ok(Self { rows: Some(rows), moved: Vec::new(), shape });
        }
        let rows = Rows::<f64, 3>::new(name, value)?;
        let moved = rows.of::<DVec3>().iter().map(|&point| (point - origin).as_vec3()).collect();
        Ok(Self { rows: None, moved, shape: rows.shape().to_vec() })
    }

    /// As many points as this says.
    pub(super) fn shape(&self) -> &[usize] {
        &self.shape
    }

    pub(super) fn positions(&self) -> &[Vec3] {
        self.rows.as_ref().map_or(&self.moved, Rows::of)
    }
}

/// Points, or the centroids of all triangles where there are none.
pub(super) struct Targets<'py> {
    points: Option<Points<'py>>,
    own: Option<Own<'py>>,
}

impl<'py> Targets<'py> {
    /// In a scene with this origin.
    pub(super) fn new(
        points: Option<&Bound<'py, PyAny>>,
        faces: bool,
        geometries: Option<&Bound<'py, PyAny>>,
        triangles: Option<&Bound<'py, PyAny>>,
        origin: DVec3,
    ) -> PyResult<Self> {
        let points = match (points, faces) {
            (Some(points), false) => Some(Points::new("points", points, origin)?),
            (None, true) => None,
            _ => return Err(PyValueError::new_err("points, faces: expected points or faces=True, and not both")),
        };
        let own = Own::new(points.as_ref().map(|points| &*points.shape), geometries, triangles)?;
        Ok(Self { points, own })
    }

    /// Checks that each target has a triangle, which has sides, or says that it has none.
    pub(super) fn expect_sides(&self, name: &str) -> PyResult<()> {
        let wrong = || {
            let wanted = "faces=True, or geometry_ids and primitive_ids, which say on which triangles points are";
            PyValueError::new_err(format!("{name}: expected {wanted}"))
        };
        (self.points.is_none() || self.own.is_some()).then_some(()).ok_or_else(wrong)
    }

    /// Positions, where they are points.
    pub(super) fn positions(&self) -> Option<&[Vec3]> {
        self.points.as_ref().map(Points::positions)
    }

    /// Geometry and number of each point's triangle, where they are said.
    pub(super) fn own(&self) -> Option<[&[u32]; 2]> {
        self.own.as_ref().map(Own::slices)
    }

    /// The shape of answers for numbers of lights and triangles.
    pub(super) fn shape(&self, lights: usize, triangles: usize) -> Vec<usize> {
        let shape = self.points.as_ref().map_or(vec![triangles], |points| points.shape.clone());
        std::iter::once(lights).chain(shape).collect()
    }
}

/// A point of the world, zero where none is given.
pub(super) fn origin_or_zero(value: Option<&Bound<'_, PyAny>>) -> PyResult<DVec3> {
    value.map_or(Ok(DVec3::ZERO), |value| world_point("origin", value))
}

/// Number of hits of each direction; one by default.
pub(super) fn hits_of_each(returns: Option<usize>) -> PyResult<usize> {
    const MOST: usize = 1024;
    let returns = returns.unwrap_or(1);
    let error = || expected("returns", &format!("1 to {MOST} hits"), returns);
    (1..=MOST).contains(&returns).then_some(returns).ok_or_else(error)
}

/// Checks the number of points of each triangle.
pub(super) fn samples_of_each(samples: u32) -> PyResult<()> {
    const MOST: u32 = 1 << 16;
    let error = || expected("samples", &format!("1 to {MOST}"), samples);
    (1..=MOST).contains(&samples).then_some(()).ok_or_else(error)
}
