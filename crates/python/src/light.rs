use glam::{DVec3, Vec3};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyString, PyTuple};
use umbrage::rays::LightSource;
use umbrage::spec::LightSpec;

use crate::arrays::{Rows, is_far, vector, world_point};
use crate::errors::expected;
use crate::pickled::pickled;

/// Where light comes from: made by `Light.sun`, `Light.point`, `Light.spot`, or `Light.suns` for many.
#[pyclass(frozen, module = "umbrage", from_py_object)]
#[derive(Clone, Debug)]
pub(crate) struct Light {
    /// Its position, where it has one, is `position` in f32.
    source: LightSource,
    /// In the world; zero for suns.
    position: DVec3,
}

#[pymethods]
impl Light {
    /// Parallel light from infinitely far away.
    ///
    /// Parameters
    /// ----------
    /// direction : array_like (3,)
    ///     In which the light travels, so away from the sun; of any length but zero.
    ///
    /// Examples
    /// --------
    /// >>> noon = umbrage.Light.sun([0, -1, 0])
    #[staticmethod]
    fn sun(direction: &Bound<'_, PyAny>) -> PyResult<Self> {
        let direction = unit("direction", vector("direction", direction)?)?;
        Ok(Self { source: LightSource::Directional { direction }, position: DVec3::ZERO })
    }

    /// A sun for each of many directions.
    ///
    /// Parameters
    /// ----------
    /// directions : array_like (L, 3)
    ///     In which their light travels; of any length but zero.
    ///
    /// Returns
    /// -------
    /// list of Light
    #[staticmethod]
    fn suns(directions: &Bound<'_, PyAny>) -> PyResult<Vec<Self>> {
        let directions = Rows::<f64, 3>::table("directions", "L", directions)?;
        let sun = |(index, direction): (usize, &[f64; 3])| {
            let direction = unit(&format!("directions[{index}]"), (*direction).into())?;
            Ok(Self { source: LightSource::Directional { direction }, position: DVec3::ZERO })
        };
        directions.of::<[f64; 3]>().iter().enumerate().map(sun).collect()
    }

    /// Light in every direction from one point.
    ///
    /// Parameters
    /// ----------
    /// position : array_like (3,)
    ///     World position.
    #[staticmethod]
    fn point(position: &Bound<'_, PyAny>) -> PyResult<Self> {
        let position = world_point("position", position)?;
        Ok(Self { source: LightSource::Point { position: position.as_vec3() }, position })
    }

    /// Light from one point inside a cone.
    ///
    /// Parameters
    /// ----------
    /// position : array_like (3,)
    ///     World position.
    /// target : array_like (3,)
    ///     The point in the middle of its light.
    /// degrees : float
    ///     The cone's full angle, above 0, at most 180.
    #[staticmethod]
    fn spot(position: &Bound<'_, PyAny>, target: &Bound<'_, PyAny>, degrees: f32) -> PyResult<Self> {
        let (position, target) = (world_point("position", position)?, vector("target", target)?);
        let from = if is_far(position, target) { position } else { position.as_vec3().as_dvec3() };
        let direction = unit("target - position", target - from)?;
        if !(degrees > 0.0 && degrees <= 180.0) {
            return Err(expected("degrees", "a number above 0, at most 180", degrees));
        }
        let outer_radians = (0.5 * degrees).to_radians().min(std::f32::consts::FRAC_PI_2);
        let inner_radians = LightSpec::INNER * outer_radians;
        let source = LightSource::Spot { position: position.as_vec3(), direction, inner_radians, outer_radians };
        Ok(Self { source, position })
    }

    #[staticmethod]
    fn _restore(
        position: Option<[f64; 3]>,
        direction: Option<[f32; 3]>,
        angles_radians: Option<[f32; 2]>,
    ) -> PyResult<Self> {
        let position = position.map(DVec3::from);
        let source = match (position.map(DVec3::as_vec3), direction.map(Vec3::from), angles_radians) {
            (Some(position), Some(direction), Some([inner_radians, outer_radians])) => {
                LightSource::Spot { position, direction, inner_radians, outer_radians }
            }
            (Some(position), None, None) => LightSource::Point { position },
            (None, Some(direction), None) => LightSource::Directional { direction },
            _ => return Err(PyValueError::new_err("no light has these")),
        };
        Ok(Self { source, position: position.unwrap_or_default() })
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        let (position, direction, angles_radians) = match self.source {
            LightSource::Point { .. } => (Some(self.position), None, None),
            LightSource::Directional { direction } => (None, Some(direction), None),
            LightSource::Spot { direction, inner_radians, outer_radians, .. } => {
                (Some(self.position), Some(direction), Some([inner_radians, outer_radians]))
            }
        };
        pickled::<Self>(py, (position.map(|of| of.to_array()), direction.map(|of| of.to_array()), angles_radians))
    }

    fn __repr__(&self) -> String {
        let is_single = self.position == self.position.as_vec3().as_dvec3();
        format!("Light({})", if is_single { LightSpec::new(self.source) } else { self.spec() })
    }
}

impl Light {
    /// A light of a scene with this origin.
    pub(crate) fn in_world(source: LightSource, origin: DVec3) -> Self {
        let position = match source {
            LightSource::Point { position } | LightSource::Spot { position, .. } => position.as_dvec3() + origin,
            LightSource::Directional { .. } => DVec3::ZERO,
        };
        Self { source: placed(source, position.as_vec3()), position }
    }

    /// As bright as full sunlight, in the world.
    fn spec(&self) -> LightSpec {
        // At the origin, so that the position comes from f64 alone.
        LightSpec::new(placed(self.source, Vec3::ZERO)).in_world(self.position.into())
    }
}

/// The source at another position; suns have none.
fn placed(mut source: LightSource, at: Vec3) -> LightSource {
    if let LightSource::Point { position } | LightSource::Spot { position, .. } = &mut source {
        *position = at;
    }
    source
}

fn unit(name: &str, direction: DVec3) -> PyResult<Vec3> {
    let unit = direction.is_finite().then(|| direction.try_normalize()).flatten();
    unit.map(DVec3::as_vec3).ok_or_else(|| expected(name, "a direction with a finite length above 0", direction))
}

/// One light, or a sequence of them: each a `Light` or the words of one.
pub(crate) fn specs(value: &Bound<'_, PyAny>) -> PyResult<Vec<LightSpec>> {
    if value.is_instance_of::<Light>() || value.is_instance_of::<PyString>() {
        return Ok(vec![spec(value)?]);
    }
    value.try_iter().map_err(|_| not_lights(value))?.map(|light| spec(&light?)).collect()
}

fn spec(light: &Bound<'_, PyAny>) -> PyResult<LightSpec> {
    if let Ok(light) = light.cast::<Light>() {
        return Ok(light.get().spec());
    }
    let text: String = light.extract().map_err(|_| not_lights(light))?;
    text.parse().map_err(|why: String| expected("lights", &format!("words of a light ({why})"), &text))
}

fn not_lights(found: &Bound<'_, PyAny>) -> PyErr {
    let found = found.get_type().name().map_or_else(|_| "an object".to_owned(), |name| name.to_string());
    PyTypeError::new_err(format!("lights: expected a Light, a str or a sequence of them, found {found}"))
}

/// The sources of lights in a scene with this origin, each a point or a direction.
pub(crate) fn lights(value: &Bound<'_, PyAny>, origin: DVec3) -> PyResult<Vec<LightSource>> {
    let source = |spec: LightSpec| {
        // Strength and size make no difference.
        let light = spec.local(origin.into()).light(Vec3::ZERO, 0.0);
        if spec.is_wide() || light.shape.is_flat() {
            return Err(expected("lights", "lights without a size: ask about several points of one", spec));
        }
        if !light.casts_shadow {
            return Err(expected("lights", "lights with shadows", spec));
        }
        Ok(light.source)
    };
    specs(value)?.into_iter().map(source).collect()
}
