use glam::{DAffine3, DMat3, DVec2, DVec3, Vec3};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyTuple;
use rayon::prelude::*;
use umbrage::Settings;
use umbrage::rays::{Projection, Ray, View};

use crate::arrays::{Numbers, affine, finite_vector, hand_over_rows, is_far, world_point};
use crate::errors::expected;
use crate::pickled::pickled;
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
#[pyclass(frozen, module = "umbrage", from_py_object)]
#[derive(Clone, Copy, Debug)]
pub(crate) struct Camera {
    /// From `origin`.
    camera: umbrage::rays::Camera,
    /// A point of the world: the position of cameras with an image of their own and of those for whose position f32 is too coarse,
    /// the scene's origin for cameras of files, otherwise zero.
    origin: DVec3,
    /// `None` where it takes images of any size, with their middle on its axis.
    pinhole: Option<Pinhole>,
}

/// A camera's image, in pixels from the middle of its upper left one.
#[derive(Clone, Copy, Debug)]
struct Pinhole {
    size: [u32; 2],
    focal: [f64; 2],
    principal: [f64; 2],
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
        let up = up.map_or(Ok(Vec3::Y), |up| finite_vector("up", up))?;
        if up == Vec3::ZERO {
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
        Ok(Self::in_world(camera, origin))
    }

    /// A camera of computer vision, as OpenCV describes it: its view may be off centre, and its pixels wider than high.
    ///
    /// It takes images of one size. Axes are rounded to float32, and so is the position, from the origin of the scene that is seen.
    /// `rays` start at the rounded position within 512 units of the world's origin, and in float64 beyond.
    ///
    /// Parameters
    /// ----------
    /// intrinsics : array_like (3, 3)
    ///     K = [[fx, 0, cx], [0, fy, cy], [0, 0, 1]]: focal lengths and principal point in pixels, x to the right and y down. (0, 0)
    ///     is the middle of the upper left pixel, so the middle of the image is ((width − 1) / 2, (height − 1) / 2).
    /// extrinsics : array_like (4, 4) or (3, 4), optional
    ///     A rotation and a translation: camera_from_world, of a camera whose x is to the right, y down and z into the image.
    ///     Otherwise it is at the origin, with the world's axes.
    /// width, height : int
    ///     Pixels, 1 to 16384.
    ///
    /// Returns
    /// -------
    /// Camera
    ///
    /// Raises
    /// ------
    /// ValueError
    ///     Where `intrinsics` have skew or a focal length that isn't above 0, or `extrinsics` aren't rigid.
    ///
    /// Examples
    /// --------
    /// >>> K = [[500, 0, 310.5], [0, 500, 239.5], [0, 0, 1]]
    /// >>> camera = umbrage.Camera.from_intrinsics(K, width=640, height=480)
    /// >>> camera.rays()[100, 200, 3:]
    /// array([-0.221, -0.279,  1.   ])
    #[staticmethod]
    #[pyo3(signature = (intrinsics, extrinsics=None, *, width, height))]
    fn from_intrinsics(
        intrinsics: &Bound<'_, PyAny>,
        extrinsics: Option<&Bound<'_, PyAny>>,
        width: u32,
        height: u32,
    ) -> PyResult<Self> {
        size(width, height)?;
        let matrix = Numbers::<f64>::new("intrinsics", intrinsics, &[3, 3])?;
        let matrix = DMat3::from_cols_slice(matrix.slice()).transpose();
        let (focal, principal) = ([matrix.x_axis.x, matrix.y_axis.y], [matrix.z_axis.x, matrix.z_axis.y]);
        let tan_half_height = (0.5 * f64::from(height) / focal[1]) as f32;
        let [[fx, fy], [cx, cy]] = [focal, principal];
        let plain = DMat3::from_cols_array_2d(&[[fx, 0.0, 0.0], [0.0, fy, 0.0], [cx, cy, 1.0]]);
        let is_possible = fx > 0.0 && tan_half_height > 0.0 && tan_half_height.is_finite() && matrix.is_finite();
        if !is_possible || matrix != plain {
            let wanted = "[[fx, 0, cx], [0, fy, cy], [0, 0, 1]] with focal lengths above 0";
            return Err(expected("intrinsics", wanted, matrix.transpose()));
        }
        let camera_from_world = extrinsics.map_or(Ok(DAffine3::IDENTITY), |matrix| affine("extrinsics", matrix))?;
        let rotation = camera_from_world.matrix3;
        if !(rotation.transpose() * rotation).abs_diff_eq(DMat3::IDENTITY, 1e-4) || rotation.determinant() < 0.0 {
            return Err(expected("extrinsics", "a rotation and a translation", camera_from_world.matrix3.transpose()));
        }
        let [right, down, forward] = rotation.transpose().to_cols_array_2d().map(|axis| DVec3::from(axis).normalize());
        let origin = camera_from_world.inverse().translation;
        let camera = umbrage::rays::Camera {
            position: Vec3::ZERO,
            right: right.as_vec3(),
            up: -down.as_vec3(),
            forward: forward.as_vec3(),
            projection: Projection::Perspective { tan_half_height },
        };
        Ok(Self { camera, origin, pinhole: Some(Pinhole { size: [width, height], focal, principal }) })
    }

    /// Width and height of its image in pixels; None where it takes any.
    #[getter]
    fn size(&self) -> Option<(u32, u32)> {
        self.pinhole.map(|pinhole| pinhole.size.into())
    }

    /// K of an image, as `from_intrinsics` takes it.
    ///
    /// Parameters
    /// ----------
    /// width, height : int, optional
    ///     Pixels; of a camera with an image of its own, that is the one.
    ///
    /// Returns
    /// -------
    /// ndarray (3, 3) float64
    ///
    /// Raises
    /// ------
    /// ValueError
    ///     For an orthographic camera, which has no focal length.
    #[pyo3(signature = (width=None, height=None))]
    fn intrinsics<'py>(&self, py: Python<'py>, width: Option<u32>, height: Option<u32>) -> PyResult<Bound<'py, PyAny>> {
        let View { camera, width, height } = self.image(width, height, self.origin)?.view;
        let ([fx, fy], [cx, cy]) = match (self.pinhole, camera.projection) {
            (Some(pinhole), _) => (pinhole.focal, pinhole.principal),
            (None, Projection::Perspective { tan_half_height }) => {
                let focal = 0.5 * f64::from(height) / f64::from(tan_half_height);
                ([focal; 2], [width, height].map(|side| 0.5 * (f64::from(side) - 1.0)))
            }
            (None, Projection::Orthographic { .. }) => {
                return Err(PyValueError::new_err("an orthographic camera has no focal length"));
            }
        };
        hand_over_rows(py, vec![[fx, 0.0, cx], [0.0, fy, cy], [0.0, 0.0, 1.0]], &[3])
    }

    /// camera_from_world (4, 4) float64, as `from_intrinsics` takes it: x to the right, y down and z into the image.
    #[getter]
    fn extrinsics<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let umbrage::rays::Camera { right, up, forward, .. } = self.camera;
        let position = self.position_from(DVec3::ZERO);
        let row = |axis: Vec3| {
            let axis = axis.as_dvec3();
            [axis.x, axis.y, axis.z, -axis.dot(position)]
        };
        hand_over_rows(py, vec![row(right), row(-up), row(forward), [0.0, 0.0, 0.0, 1.0]], &[4])
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
    /// width, height : int, optional
    ///     Pixels, 1 to 16384; of a camera with an image of its own, that is the one.
    /// nthreads : int, default 0
    ///     Threads, 0 for as many as `set_threads` says.
    ///
    /// Returns
    /// -------
    /// ndarray (height, width, 6) float64
    ///     Origin and direction, in rows from the upper left corner.
    #[pyo3(signature = (width=None, height=None, nthreads=0))]
    fn rays<'py>(
        &self,
        py: Python<'py>,
        width: Option<u32>,
        height: Option<u32>,
        nthreads: usize,
    ) -> PyResult<Bound<'py, PyAny>> {
        let origin = self.rays_origin();
        let image = self.image(width, height, origin)?;
        let rays = compute(py, &*pool(nthreads)?, || image.rays(origin));
        hand_over_rows(py, rays, &image.shape())
    }

    #[staticmethod]
    #[pyo3(signature = (axes, projection, pinhole, origin=[0.0; 3]))]
    fn _restore(
        axes: [[f32; 3]; 4],
        projection: (bool, f32),
        pinhole: Option<([u32; 2], [f64; 2], [f64; 2])>,
        origin: [f64; 3],
    ) -> Self {
        let (is_parallel, half_height) = projection;
        let projection = if is_parallel {
            Projection::Orthographic { half_height }
        } else {
            Projection::Perspective { tan_half_height: half_height }
        };
        let [position, right, up, forward] = axes.map(Vec3::from);
        let camera = umbrage::rays::Camera { position, right, up, forward, projection };
        let pinhole = pinhole.map(|(size, focal, principal)| Pinhole { size, focal, principal });
        Self { camera, origin: origin.into(), pinhole }
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        let umbrage::rays::Camera { position, right, up, forward, projection } = self.camera;
        let projection = match projection {
            Projection::Perspective { tan_half_height } => (false, tan_half_height),
            Projection::Orthographic { half_height } => (true, half_height),
        };
        let pinhole = self.pinhole.map(|Pinhole { size, focal, principal }| (size, focal, principal));
        let axes = [position, right, up, forward].map(|of| of.to_array());
        pickled::<Self>(py, (axes, projection, pinhole, self.origin.to_array()))
    }

    fn __repr__(&self) -> String {
        let umbrage::rays::Camera { position, forward, up, projection, .. } = self.camera;
        let [position, target] = if self.origin == DVec3::ZERO {
            [position, position + forward].map(|point| format!("{:?}", point.to_array()))
        } else {
            let position = self.position_from(DVec3::ZERO);
            [position, position + forward.as_dvec3()].map(|point| format!("{:?}", point.to_array()))
        };
        let [forward, up] = [forward, up].map(|of| of.to_array());
        if let Some(Pinhole { size: [width, height], focal: [fx, fy], principal: [cx, cy] }) = self.pinhole {
            let image = format!("{width}×{height} pixels, fx={fx}, fy={fy}, cx={cx}, cy={cy}");
            return format!("<umbrage.Camera at {position}, forward {forward:?}, up {up:?}: {image}>");
        }
        let spread = match projection {
            Projection::Perspective { tan_half_height } => {
                let degrees = 2.0 * f64::from(tan_half_height).atan().to_degrees();
                format!("fov_degrees={}", (1e4 * degrees).round() / 1e4)
            }
            Projection::Orthographic { half_height } => format!("half_height={half_height}"),
        };
        format!("Camera({position}, {target}, {up:?}, {spread})")
    }
}

impl Camera {
    /// A camera of a scene with this origin.
    pub(crate) fn in_world(camera: umbrage::rays::Camera, origin: DVec3) -> Self {
        Self { camera, origin, pinhole: None }
    }

    /// The position from a point of the world.
    fn position_from(&self, origin: DVec3) -> DVec3 {
        self.origin - origin + self.camera.position.as_dvec3()
    }

    /// The camera of a scene with this origin.
    pub(crate) fn local(&self, origin: DVec3) -> umbrage::rays::Camera {
        umbrage::rays::Camera { position: self.position_from(origin).as_vec3(), ..self.camera }
    }

    /// The origin from which `rays` have the position in f32. A camera with an image of its own has no target to derive
    /// the allowed rounding from: a point at distance 1 stands in for it.
    fn rays_origin(&self) -> DVec3 {
        let is_near = self.pinhole.is_some() && !is_far(self.origin, self.origin + self.camera.forward.as_dvec3());
        if is_near { DVec3::ZERO } else { self.origin }
    }

    /// Whether it has an image of its own.
    pub(crate) fn has_image(&self) -> bool {
        self.pinhole.is_some()
    }

    /// An image of this size, or of the camera's own, in a scene with this origin.
    pub(crate) fn image(&self, width: Option<u32>, height: Option<u32>, origin: DVec3) -> PyResult<PixelRays> {
        let mut sides = [0; 2];
        for (axis, (name, given)) in [("width", width), ("height", height)].into_iter().enumerate() {
            sides[axis] = match (given, self.pinhole.map(|pinhole| pinhole.size[axis])) {
                (Some(given), Some(own)) if given != own => {
                    return Err(expected(name, &format!("{own}, that of the camera's own image"), given));
                }
                (Some(side), _) | (None, Some(side)) => side,
                (None, None) => return Err(expected(name, "a number of pixels", "None")),
            };
        }
        let [width, height] = sides;
        size(width, height)?;
        let view = View { camera: self.local(origin), width, height };
        Ok(match self.pinhole {
            None => PixelRays { view, offset_pixels: DVec2::splat(0.5), stretch: None },
            Some(Pinhole { focal: [fx, fy], principal, .. }) => {
                let middle = DVec2::new(f64::from(width), f64::from(height)) * 0.5;
                let stretch = (fx != fy).then(|| fy / fx);
                PixelRays { view, offset_pixels: middle - DVec2::from(principal), stretch }
            }
        })
    }

    /// A picture around the camera's axis, and the part of it that is the camera's image.
    pub(crate) fn canvas(&self, width: Option<u32>, height: Option<u32>) -> PyResult<Canvas> {
        let View { width, height, .. } = self.image(width, height, self.origin)?.view;
        let Some(Pinhole { focal: [fx, fy], principal, .. }) = self.pinhole else {
            return Ok(Canvas { camera: *self, size: [width, height], corner: [0; 2], part: [width, height] });
        };
        if fx != fy {
            let why = format!("camera: expected fx = fy for a picture, whose pixels are square, found {fx} and {fy}");
            return Err(PyValueError::new_err(why));
        }
        let (part, mut whole, mut corner) = ([width, height], [0; 2], [0; 2]);
        for axis in 0..2 {
            // Twice where the axis goes through the image: whole pixels on both sides of it make a picture.
            let twice = (2.0 * principal[axis] + 1.0).round().clamp(-1e6, 1e6) as i64;
            let most = twice.max(2 * i64::from(part[axis]) - twice);
            if most > i64::from(Settings::MAX_SIDE) {
                let wanted =
                    format!("a principal point that is in the middle of at most {} pixels", Settings::MAX_SIDE);
                return Err(expected("camera", &wanted, most));
            }
            (whole[axis], corner[axis]) = (most as u32, ((most - twice) / 2) as u32);
        }
        let tan_half_height = (0.5 * f64::from(whole[1]) / fy) as f32;
        let projection = Projection::Perspective { tan_half_height };
        let camera = Self::in_world(umbrage::rays::Camera { projection, ..self.camera }, self.origin);
        Ok(Canvas { camera, size: whole, corner, part })
    }
}

/// A picture of which a part is kept.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Canvas {
    pub(crate) camera: Camera,
    pub(crate) size: [u32; 2],
    /// The part's upper left pixel, by column and row.
    pub(crate) corner: [u32; 2],
    /// The part's size.
    pub(crate) part: [u32; 2],
}

/// The rays through the middles of an image's pixels.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PixelRays {
    pub(crate) view: View,
    /// Position of the upper left pixel's ray in the view; half a pixel from the corner if the view is centred.
    pub(crate) offset_pixels: DVec2,
    /// Ratio of a pixel's width to its height, unless they are equal.
    stretch: Option<f64>,
}

impl PixelRays {
    pub(crate) fn are_square(&self) -> bool {
        self.stretch.is_none()
    }

    /// Rows and columns.
    pub(crate) fn shape(&self) -> [usize; 2] {
        [self.view.height as usize, self.view.width as usize]
    }

    /// The ray of a pixel, counted from the upper left corner.
    pub(crate) fn ray(&self, pixel: usize) -> Ray {
        let (column, row) = (pixel % self.view.width as usize, pixel / self.view.width as usize);
        let (x, y) = (column as f64 + self.offset_pixels.x, row as f64 + self.offset_pixels.y);
        let middle = 0.5 * f64::from(self.view.width);
        self.view.ray(self.stretch.map_or(x, |stretch| middle + (x - middle) * stretch), y)
    }

    /// Start and direction of all rays in the world, of a scene with this origin.
    pub(crate) fn rays(&self, origin: DVec3) -> Vec<[f64; 6]> {
        let [rows, columns] = self.shape();
        let numbers = |pixel| {
            let ray = self.ray(pixel);
            let ([x, y, z], [dx, dy, dz]) = ((ray.origin + origin).to_array(), ray.direction.to_array());
            [x, y, z, dx, dy, dz]
        };
        (0..rows * columns).into_par_iter().map(numbers).collect()
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
