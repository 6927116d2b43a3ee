use glam::DVec3;
use pyo3::prelude::*;
use rayon::prelude::*;
use umbrage::Settings;
use umbrage::rays::{Projection, View};

use crate::arrays::{finite_vector, hand_over_rows, is_far, world_point};
use crate::errors::expected;
use crate::threads::{compute, pool};

/// A camera in the world.
///
/// Parameters
/// ----------
/// position : array_like (3,)
///     Where it is in the world, in float64.
/// target : array_like (3,)
///     The point that it looks at.
/// up : array_like (3,), default (0, 1, 0)
///     What is upwards in the image, as near as can be.
/// fov_degrees : float, default 40
///     Vertical field of view, above 0 and below 180.
/// half_height : float, optional
///     Makes it an orthographic camera: half the height of its view in world units, above 0.
///
/// Raises
/// ------
/// ValueError
///     Where `position` is `target`, or a number is out of its range.
///
/// Examples
/// --------
/// >>> camera = umbrage.Camera([0, 1, 5], [0, 1, 0])
/// >>> camera.rays(640, 480).shape
/// (480, 640, 6)
#[pyclass(frozen, module = "umbrage")]
#[derive(Clone, Copy, Debug)]
pub(crate) struct Camera {
    /// From `origin`.
    pub(crate) camera: umbrage::rays::Camera,
    /// In the world; zero unless f32 is too coarse for the camera there.
    pub(crate) origin: DVec3,
}

#[pymethods]
impl Camera {
    #[new]
    #[pyo3(signature = (position, target, up=None, *, fov_degrees=40.0, half_height=None))]
    fn new(
        position: &Bound<'_, PyAny>,
        target: &Bound<'_, PyAny>,
        up: Option<&Bound<'_, PyAny>>,
        fov_degrees: f32,
        half_height: Option<f32>,
    ) -> PyResult<Self> {
        let (position, target) = (world_point("position", position)?, world_point("target", target)?);
        let origin = if position != target && is_far(position, target) { position } else { DVec3::ZERO };
        let [position, target] = [position, target].map(|point| (point - origin).as_vec3());
        if position == target {
            return Err(expected("target", "another point than position", target));
        }
        let up = up.map_or(Ok(glam::Vec3::Y), |up| finite_vector("up", up))?;
        if up == glam::Vec3::ZERO {
            return Err(expected("up", "a direction", up));
        }
        if !(fov_degrees > 0.0 && fov_degrees < 180.0) {
            return Err(expected("fov_degrees", "a number above 0 and below 180", fov_degrees));
        }
        let mut camera = umbrage::rays::Camera::look_at(position, target, up, fov_degrees.to_radians());
        if let Some(half_height) = half_height {
            if !(half_height > 0.0 && half_height.is_finite()) {
                return Err(expected("half_height", "a finite number above 0", half_height));
            }
            camera.projection = Projection::Orthographic { half_height };
        }
        Ok(Self { camera, origin })
    }

    /// World position.
    #[getter]
    fn position(&self) -> [f64; 3] {
        self.position_from(DVec3::ZERO).to_array()
    }

    /// The direction into the image, of unit length.
    #[getter]
    fn forward(&self) -> [f32; 3] {
        self.camera.forward.to_array()
    }

    /// The rays through the middles of an image's pixels, for `RaycastingScene.cast_rays`.
    ///
    /// Their directions are such that t is the depth along `forward` in world units.
    ///
    /// Parameters
    /// ----------
    /// width, height : int
    ///     Pixels, 1 to 16384.
    /// nthreads : int, default 0
    ///     Threads, 0 for as many as `set_threads` says.
    ///
    /// Returns
    /// -------
    /// ndarray (height, width, 6) float64
    ///     Origin and direction, in rows from the upper left corner.
    #[pyo3(signature = (width, height, nthreads=0))]
    fn rays<'py>(&self, py: Python<'py>, width: u32, height: u32, nthreads: usize) -> PyResult<Bound<'py, PyAny>> {
        let view = self.view(width, height, self.origin)?;
        let (pool, origin) = (pool(nthreads)?, self.origin);
        let rays: Vec<[f64; 6]> = compute(py, &pool, || {
            let pixels = (0..width as usize * height as usize).into_par_iter();
            pixels
                .map(|pixel| {
                    let ray = middle(&view, pixel);
                    let ([x, y, z], [dx, dy, dz]) = ((ray.origin + origin).to_array(), ray.direction.to_array());
                    [x, y, z, dx, dy, dz]
                })
                .collect()
        });
        hand_over_rows(py, rays, &[height as usize, width as usize])
    }

    fn __repr__(&self) -> String {
        let umbrage::rays::Camera { forward, projection, .. } = self.camera;
        let spread = match projection {
            Projection::Perspective { tan_half_height } => {
                format!("fov_degrees={:.6}", 2.0 * tan_half_height.atan().to_degrees())
            }
            Projection::Orthographic { half_height } => format!("half_height={half_height}"),
        };
        if self.origin == DVec3::ZERO {
            let position = self.camera.position;
            return format!("Camera({:?}, {:?}, {spread})", position.to_array(), (position + forward).to_array());
        }
        let position = self.position_from(DVec3::ZERO);
        format!("Camera({:?}, {:?}, {spread})", position.to_array(), (position + forward.as_dvec3()).to_array())
    }
}

impl Camera {
    /// Where it is from a point of the world.
    fn position_from(&self, origin: DVec3) -> DVec3 {
        self.origin - origin + self.camera.position.as_dvec3()
    }

    /// The camera of a scene with this origin.
    pub(crate) fn local(&self, origin: DVec3) -> umbrage::rays::Camera {
        umbrage::rays::Camera { position: self.position_from(origin).as_vec3(), ..self.camera }
    }

    /// The camera of a scene with this origin, with an image's size.
    pub(crate) fn view(&self, width: u32, height: u32, origin: DVec3) -> PyResult<View> {
        size(width, height)?;
        Ok(View { camera: self.local(origin), width, height })
    }
}

/// Checks an image's size.
pub(crate) fn size(width: u32, height: u32) -> PyResult<()> {
    for (name, side) in [("width", width), ("height", height)] {
        if !(1..=Settings::MAX_SIDE).contains(&side) {
            return Err(expected(name, &format!("1 to {} pixels", Settings::MAX_SIDE), side));
        }
    }
    Ok(())
}

/// The ray through the middle of a pixel, counted from the upper left corner.
pub(crate) fn middle(view: &View, pixel: usize) -> umbrage::rays::Ray {
    let (x, y) = (pixel % view.width as usize, pixel / view.width as usize);
    view.ray(x as f64 + 0.5, y as f64 + 0.5)
}
