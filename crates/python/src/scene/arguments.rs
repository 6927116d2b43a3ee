//! What several questions take as arguments.

use glam::{DAffine3, DMat4, DVec3, Vec3};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use umbrage::rays::Sweep;

use crate::arrays::{Numbers, Rows, shown, world_point};
use crate::errors::expected;

/// Directions between two looks whether a call shall end.
const DIRECTIONS_AT_ONCE: usize = 1 << 22;

/// Origins with their directions.
pub(super) struct Sweeps<'py> {
    origins: Rows<'py, f64, 3>,
    /// From the scene's origin.
    local_origins: Vec<DVec3>,
    directions: Rows<'py, f32, 3>,
    /// Whether each origin has directions of its own.
    each: bool,
}

/// The same, without Python.
#[derive(Clone, Copy)]
pub(super) struct Pieces<'a> {
    origins: &'a [DVec3],
    directions: &'a [Vec3],
    each: bool,
}

impl<'py> Sweeps<'py> {
    /// In a scene whose coordinates count from `scene_origin`.
    pub(super) fn new(
        origin: &Bound<'py, PyAny>,
        directions: &Bound<'py, PyAny>,
        each: bool,
        scene_origin: DVec3,
    ) -> PyResult<Self> {
        let origins = Rows::<f64, 3>::new("origin", origin)?;
        if origins.shape().len() > 1 {
            let found = [origins.shape(), &[3]].concat();
            return Err(expected("origin", "shape (3,) or (S, 3)", shown(&found)));
        }
        let directions = Rows::new("directions", directions)?;
        let local_origins = origins.of::<DVec3>().iter().map(|&origin| origin - scene_origin).collect();
        let sweeps = Self { origins, local_origins, directions, each };
        if each
            && (sweeps.origins.shape().is_empty()
                || sweeps.directions.shape().first() != sweeps.origins.shape().first())
        {
            let wanted = match sweeps.origins.shape() {
                [] => "each=False, as there is one origin".to_owned(),
                [origins, ..] => format!("shape ({origins}, ..., 3), as there are {origins} origins"),
            };
            let found = [sweeps.directions.shape(), &[3]].concat();
            return Err(expected("directions", &wanted, shown(&found)));
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
        Pieces { origins: &self.local_origins, directions: self.directions.of(), each: self.each }
    }
}

impl<'a> Pieces<'a> {
    /// The sweeps, in pieces of so many directions.
    pub(super) fn sweeps(self) -> impl Iterator<Item = Sweep<'a>> {
        let Self { origins, directions, each } = self;
        let of_each = if each { directions.len() / origins.len().max(1) } else { directions.len() };
        origins.iter().enumerate().flat_map(move |(index, &origin)| {
            let first = if each { index * of_each } else { 0 };
            let own = &directions[first..first + of_each];
            own.chunks(DIRECTIONS_AT_ONCE).map(move |directions| Sweep { origin, directions })
        })
    }
}

/// The triangle of each point.
pub(super) struct Own<'py>([Numbers<'py, u32>; 2]);

impl<'py> Own<'py> {
    /// `None` where there are no points, or none says on what it is.
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
    pub(super) fn new(value: &Bound<'py, PyAny>, origin: DVec3) -> PyResult<Self> {
        if origin == DVec3::ZERO {
            let rows = Rows::new("points", value)?;
            let shape = rows.shape().to_vec();
            return Ok(Self { rows: Some(rows), moved: Vec::new(), shape });
        }
        let rows = Rows::<f64, 3>::new("points", value)?;
        let moved = rows.of::<DVec3>().iter().map(|&point| (point - origin).as_vec3()).collect();
        Ok(Self { rows: None, moved, shape: rows.shape().to_vec() })
    }

    pub(super) fn positions(&self) -> &[Vec3] {
        match &self.rows {
            Some(rows) => rows.of(),
            None => &self.moved,
        }
    }

    pub(super) fn shape(&self) -> &[usize] {
        &self.shape
    }
}

/// A point of the world, zero where none is given.
pub(super) fn origin_or_zero(value: Option<&Bound<'_, PyAny>>) -> PyResult<DVec3> {
    value.map_or(Ok(DVec3::ZERO), |value| world_point("origin", value))
}

/// How many hits of each direction, of which there is one where that isn't said.
pub(super) fn hits_of_each(returns: Option<usize>) -> PyResult<usize> {
    const MOST: usize = 1024;
    let returns = returns.unwrap_or(1);
    let error = || expected("returns", &format!("1 to {MOST} hits"), returns);
    (1..=MOST).contains(&returns).then_some(returns).ok_or_else(error)
}

/// Checks how many points each triangle has.
pub(super) fn samples_of_each(samples: u32) -> PyResult<()> {
    const MOST: u32 = 1 << 16;
    let error = || expected("samples", &format!("1 to {MOST}"), samples);
    (1..=MOST).contains(&samples).then_some(()).ok_or_else(error)
}

/// A transform of column vectors whose last row is 0, 0, 0, 1.
pub(super) fn affine(name: &str, value: &Bound<'_, PyAny>) -> PyResult<DAffine3> {
    let matrix = Numbers::<f64>::new(name, value, &[4, 4])?;
    let matrix = DMat4::from_cols_slice(matrix.slice()).transpose();
    let is_affine = matrix.is_finite() && matrix.row(3).to_array() == [0.0, 0.0, 0.0, 1.0];
    let error = || expected(name, "finite numbers and a last row of 0, 0, 0, 1", matrix.transpose());
    is_affine.then(|| DAffine3::from_mat4(matrix)).ok_or_else(error)
}
