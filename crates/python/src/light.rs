use glam::{DVec3, Vec3};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyString, PyTuple};
use umbrage::rays::LightSource;
use umbrage::spec::LightSpec;

use crate::arrays::{Rows, finite_vector, vector};
use crate::errors::expected;
use crate::pickled::pickled;

/// Where light comes from: made by `Light.sun`, `Light.point`, `Light.spot`, or `Light.suns` for many.
#[pyclass(frozen, module = "umbrage", from_py_object)]
#[derive(Clone, Debug)]
pub(crate) struct Light {
    pub(crate) source: LightSource,
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
        Ok(Self { source: LightSource::Directional { direction } })
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
            Ok(Self { source: LightSource::Directional { direction } })
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
        Ok(Self { source: LightSource::Point { position: finite_vector("position", position)? } })
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
        let (position, target) = (finite_vector("position", position)?, vector("target", target)?);
        let direction = unit("target - position", target - position.as_dvec3())?;
        if !(degrees > 0.0 && degrees <= 180.0) {
            return Err(expected("degrees", "a number above 0, at most 180", degrees));
        }
        let outer_radians = (0.5 * degrees).to_radians().min(std::f32::consts::FRAC_PI_2);
        let inner_radians = LightSpec::INNER * outer_radians;
        Ok(Self { source: LightSource::Spot { position, direction, inner_radians, outer_radians } })
    }

    #[staticmethod]
    fn _restore(
        position: Option<[f32; 3]>,
        direction: Option<[f32; 3]>,
        angles_radians: Option<[f32; 2]>,
    ) -> PyResult<Self> {
        let (position, direction) = (position.map(Vec3::from), direction.map(Vec3::from));
        let source = match (position, direction, angles_radians) {
            (Some(position), Some(direction), Some([inner_radians, outer_radians])) => {
                LightSource::Spot { position, direction, inner_radians, outer_radians }
            }
            (Some(position), None, None) => LightSource::Point { position },
            (None, Some(direction), None) => LightSource::Directional { direction },
            _ => return Err(PyValueError::new_err("no light has these")),
        };
        Ok(Self { source })
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        let (position, direction, angles_radians) = match self.source {
            LightSource::Point { position } => (Some(position), None, None),
            LightSource::Directional { direction } => (None, Some(direction), None),
            LightSource::Spot { position, direction, inner_radians, outer_radians } => {
                (Some(position), Some(direction), Some([inner_radians, outer_radians]))
            }
        };
        pickled::<Self>(py, (position.map(|of| of.to_array()), direction.map(|of| of.to_array()), angles_radians))
    }

    fn __repr__(&self) -> String {
        format!("Light({})", LightSpec::new(self.source))
    }
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
        return Ok(LightSpec::new(light.get().source));
    }
    let text: String = light.extract().map_err(|_| not_lights(light))?;
    text.parse().map_err(|why: String| expected("lights", &format!("words of a light ({why})"), &text))
}

fn not_lights(found: &Bound<'_, PyAny>) -> PyErr {
    let found = found.get_type().name().map_or_else(|_| "an object".to_owned(), |name| name.to_string());
    PyTypeError::new_err(format!("lights: expected a Light, a str or a sequence of them, found {found}"))
}

/// Where the light of lights comes from, each from one point or direction.
pub(crate) fn lights(value: &Bound<'_, PyAny>) -> PyResult<Vec<LightSource>> {
    let source = |spec: LightSpec| {
        // Where a light's full strength is makes no difference.
        let light = spec.light(Vec3::ZERO);
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
