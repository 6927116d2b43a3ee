//! Rays of pinhole cameras, with Open3D's arguments, and of lidars that turn.

use glam::{DAffine3, DMat3, DQuat, DVec3};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

use crate::arrays::{Numbers, affine, vector};
use crate::errors::expected;

/// The arguments of Open3D's first form, and of its second.
const MATRICES: [&str; 4] = ["intrinsic_matrix", "extrinsic_matrix", "width_px", "height_px"];
const VIEW: [&str; 6] = ["fov_deg", "center", "eye", "up", "width_px", "height_px"];

/// The most pixels along a side, and columns of a lidar.
const MOST: usize = 1 << 16;

/// A camera whose rays go through the middles of pixels.
pub(super) struct Pinhole {
    eye: DVec3,
    /// From a pixel's x, y and 1 to a direction in the world.
    world_from_pixel: DMat3,
    /// Rows and columns.
    pub(super) shape: [usize; 2],
}

impl Pinhole {
    /// Takes either form of Open3D's arguments, by position or by name.
    pub(super) fn new(arguments: &Bound<'_, PyTuple>, named: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        let is_named = |name: &&str| named.is_some_and(|named| named.contains(name).unwrap_or_default());
        let is_number = arguments.get_item(0).is_ok_and(|first| first.extract::<f64>().is_ok());
        if is_number || VIEW[..4].iter().any(is_named) {
            let [fov_deg, center, eye, up, width, height] = bound(VIEW, arguments, named)?;
            Self::of_view(&fov_deg, [&center, &eye, &up], [&height, &width])
        } else {
            let [intrinsic, extrinsic, width, height] = bound(MATRICES, arguments, named)?;
            Self::of_matrices(&intrinsic, &extrinsic, [&height, &width])
        }
    }

    fn of_matrices(
        intrinsic: &Bound<'_, PyAny>,
        extrinsic: &Bound<'_, PyAny>,
        shape: [&Bound<'_, PyAny>; 2],
    ) -> PyResult<Self> {
        let numbers = Numbers::<f64>::new(MATRICES[0], intrinsic, &[3, 3])?;
        let camera_from_world = affine(MATRICES[1], extrinsic)?;
        let pixel_from_camera = DMat3::from_cols_slice(numbers.slice()).transpose();
        let camera_from_pixel = pixel_from_camera.inverse();
        if !camera_from_pixel.is_finite() {
            return Err(expected(MATRICES[0], "a matrix with an inverse", pixel_from_camera.transpose()));
        }
        let turned = camera_from_world.matrix3.transpose();
        let eye = turned * -camera_from_world.translation;
        Ok(Self { eye, world_from_pixel: turned * camera_from_pixel, shape: image_shape(shape)? })
    }

    fn of_view(
        fov_deg: &Bound<'_, PyAny>,
        [center, eye, up]: [&Bound<'_, PyAny>; 3],
        shape: [&Bound<'_, PyAny>; 2],
    ) -> PyResult<Self> {
        let degrees: f64 = fov_deg.extract()?;
        if !(degrees > 0.0 && degrees < 180.0) {
            return Err(expected("fov_deg", "degrees between 0 and 180", degrees));
        }
        let (center, eye, up) = (vector("center", center)?, vector("eye", eye)?, vector("up", up)?);
        let shape = image_shape(shape)?;
        let forward = (center - eye).try_normalize();
        let forward = forward.ok_or_else(|| expected("center", "another point than eye", center))?;
        let across = up.cross(forward).try_normalize();
        let across = across.ok_or_else(|| expected("up", "a direction beside that from eye to center", up))?;
        let [height, width] = shape.map(|side| side as f64);
        let focal = 0.5 * width / (0.5 * degrees.to_radians()).tan();
        let corner = forward * focal - across * (0.5 * width) - forward.cross(across) * (0.5 * height);
        // Directions with 1 along the axis, as of an intrinsic matrix.
        let world_from_pixel = DMat3::from_cols(across, forward.cross(across), corner) * focal.recip();
        Ok(Self { eye, world_from_pixel, shape })
    }

    /// Row by row, in f32 as Open3D's.
    pub(super) fn rays(&self) -> Vec<[f32; 6]> {
        let [rows, columns] = self.shape;
        let pixels = (0..rows).flat_map(|row| (0..columns).map(move |column| [column, row].map(|at| at as f64 + 0.5)));
        pixels.map(|[x, y]| ray(self.eye, self.world_from_pixel * DVec3::new(x, y, 1.0)).map(|of| of as f32)).collect()
    }
}

/// Arguments by position or name.
fn bound<'py, const N: usize>(
    names: [&str; N],
    arguments: &Bound<'py, PyTuple>,
    named: Option<&Bound<'py, PyDict>>,
) -> PyResult<[Bound<'py, PyAny>; N]> {
    let error = |why: String| {
        let forms = format!("expected ({}) or ({})", MATRICES.join(", "), VIEW.join(", "));
        PyTypeError::new_err(format!("create_rays_pinhole: {forms}, found {why}"))
    };
    let count = arguments.len();
    let names_given: Vec<String> = named.map_or(Ok(Vec::new()), |named| named.keys().extract())?;
    if count > N {
        return Err(error(format!("{count} arguments")));
    }
    if let Some(other) = names_given.iter().find(|name| !names[count..].contains(&name.as_str())) {
        return Err(error(format!("another {other}")));
    }
    let mut all = Vec::with_capacity(N);
    for (index, name) in names.iter().enumerate() {
        let by_name = || named.map_or(Ok(None), |named| named.get_item(name));
        let value = if index < count { Some(arguments.get_item(index)?) } else { by_name()? };
        all.push(value.ok_or_else(|| error(format!("no {name}")))?);
    }
    all.try_into().map_err(|_| error("others".to_owned()))
}

/// Rows and columns of an image, from `height_px` and `width_px`.
fn image_shape(shape: [&Bound<'_, PyAny>; 2]) -> PyResult<[usize; 2]> {
    let mut sides = [0; 2];
    for (index, name) in ["height_px", "width_px"].into_iter().enumerate() {
        sides[index] = shape[index].extract()?;
        if !(1..=MOST).contains(&sides[index]) {
            return Err(expected(name, &format!("1 to {MOST} pixels"), sides[index]));
        }
    }
    Ok(sides)
}

/// A lidar whose column of beams turns, and moves meanwhile.
pub(super) struct Lidar {
    elevations: Vec<f64>,
    /// In radians.
    azimuths: Vec<f64>,
    world_from_sensor: DAffine3,
    /// World units a second, and radians a second around the sensor, each along the world's axes.
    velocity: DVec3,
    turn: DVec3,
    /// Seconds from the first column to where the next turn's first one would be.
    period: f64,
}

impl Lidar {
    pub(super) fn new(
        elevations_deg: &Bound<'_, PyAny>,
        columns: &Bound<'_, PyAny>,
        world_from_sensor: Option<&Bound<'_, PyAny>>,
        [velocity, angular_velocity_deg]: [Option<&Bound<'_, PyAny>>; 2],
        period: f64,
    ) -> PyResult<Self> {
        let elevations = degrees("elevations_deg", elevations_deg)?;
        let azimuths = match columns.extract::<usize>() {
            Ok(count) if !(1..=MOST).contains(&count) => {
                return Err(expected("columns", &format!("1 to {MOST} columns"), count));
            }
            Ok(count) => (0..count).map(|column| std::f64::consts::TAU * column as f64 / count as f64).collect(),
            Err(_) => degrees("columns", columns)?,
        };
        let identity = Ok(DAffine3::IDENTITY);
        let rate = |name, value: Option<&Bound<'_, PyAny>>| {
            let rate = value.map_or(Ok(DVec3::ZERO), |value| vector(name, value))?;
            rate.is_finite().then_some(rate).ok_or_else(|| expected(name, "finite numbers", rate))
        };
        if !(period.is_finite() && period >= 0.0) {
            return Err(expected("period", "seconds from 0", period));
        }
        Ok(Self {
            elevations,
            azimuths,
            world_from_sensor: world_from_sensor.map_or(identity, |pose| affine("world_from_sensor", pose))?,
            velocity: rate("velocity", velocity)?,
            turn: rate("angular_velocity_deg", angular_velocity_deg)?.map(f64::to_radians),
            period,
        })
    }

    pub(super) fn shape(&self) -> [usize; 2] {
        [self.elevations.len(), self.azimuths.len()]
    }

    /// Row by row. Directions are f32's numbers, so that the scanner takes them.
    pub(super) fn rays(&self) -> Vec<[f64; 6]> {
        let Self { azimuths, world_from_sensor, velocity, turn, period, .. } = self;
        let poses: Vec<(DVec3, DMat3)> = (0..azimuths.len())
            .map(|column| {
                let seconds = period * column as f64 / azimuths.len() as f64;
                let turned = DMat3::from_quat(DQuat::from_scaled_axis(*turn * seconds)) * world_from_sensor.matrix3;
                (world_from_sensor.translation + *velocity * seconds, turned)
            })
            .collect();
        let beam = |elevation: f64, (azimuth, (origin, turned)): (&f64, &(DVec3, DMat3))| {
            let ((up, flat), (left, ahead)) = (elevation.sin_cos(), azimuth.sin_cos());
            let direction = *turned * DVec3::new(flat * ahead, flat * left, up);
            ray(*origin, direction.as_vec3().as_dvec3())
        };
        let rows = self.elevations.iter();
        rows.flat_map(|&elevation| azimuths.iter().zip(&poses).map(move |of| beam(elevation, of))).collect()
    }
}

/// Angles in radians, of a list of degrees.
fn degrees(name: &str, value: &Bound<'_, PyAny>) -> PyResult<Vec<f64>> {
    let angles = Numbers::<f64>::list(name, "N", value)?;
    let angles = angles.slice();
    match angles.iter().find(|angle| !angle.is_finite()) {
        Some(other) => Err(expected(name, "finite degrees", other)),
        None => Ok(angles.iter().map(|angle| angle.to_radians()).collect()),
    }
}

fn ray(origin: DVec3, direction: DVec3) -> [f64; 6] {
    let ([x, y, z], [dx, dy, dz]) = (origin.to_array(), direction.to_array());
    [x, y, z, dx, dy, dz]
}
