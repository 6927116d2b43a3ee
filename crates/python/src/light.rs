use glam::{DVec3, Vec3};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use umbrage::rays::LightSource;
use umbrage::spec::LightSpec;

use crate::arrays::{Rows, is_far, vector, world_point};
use crate::errors::expected;

/// Where light comes from: made by `Light.sun`, `Light.point`, `Light.spot`, or `Light.suns` for many.
#[pyclass(frozen, module = "umbrage", from_py_object)]
#[derive(Clone, Debug)]
pub(crate) struct Light {
    /// Its position, where it has one, is `position` in f32.
    pub(crate) source: LightSource,
    /// In the world; zero for suns.
    pub(crate) position: DVec3,
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

    fn __repr__(&self) -> String {
        let is_single = self.position == self.position.as_vec3().as_dvec3();
        format!("Light({})", if is_single { LightSpec::new(self.source) } else { self.spec() })
    }
}

impl Light {
    /// A light of a scene with this origin, as in that scene.
    pub(crate) fn in_world(source: LightSource, origin: DVec3) -> Self {
        let position = match source {
            LightSource::Point { position } | LightSource::Spot { position, .. } => position.as_dvec3() + origin,
            LightSource::Directional { .. } => DVec3::ZERO,
        };
        Self { source: placed(source, position), position }
    }

    /// The source in a scene with this origin.
    fn local(&self, origin: DVec3) -> LightSource {
        placed(self.source, self.position - origin)
    }

    /// As bright as full sunlight, in the world.
    pub(crate) fn spec(&self) -> LightSpec {
        LightSpec::new(self.local(self.position)).in_world(self.position.into())
    }
}

/// The source at another position; suns have none.
fn placed(source: LightSource, position: DVec3) -> LightSource {
    let mut placed = source;
    if let LightSource::Point { position: of } | LightSource::Spot { position: of, .. } = &mut placed {
        *of = position.as_vec3();
    }
    placed
}

fn unit(name: &str, direction: DVec3) -> PyResult<Vec3> {
    let unit = direction.is_finite().then(|| direction.try_normalize()).flatten();
    unit.map(DVec3::as_vec3).ok_or_else(|| expected(name, "a direction with a finite length above 0", direction))
}

/// One light, or a sequence of them, in a scene with this origin.
pub(crate) fn lights(value: &Bound<'_, PyAny>, origin: DVec3) -> PyResult<Vec<LightSource>> {
    if let Ok(light) = value.cast::<Light>() {
        return Ok(vec![light.get().local(origin)]);
    }
    let wrong = |found: &Bound<'_, PyAny>| {
        let found = found.get_type().name().map_or_else(|_| "an object".to_owned(), |name| name.to_string());
        PyTypeError::new_err(format!("lights: expected a Light or a sequence of them, found {found}"))
    };
    let mut sources = Vec::new();
    for light in value.try_iter().map_err(|_| wrong(value))? {
        let light = light?;
        sources.push(light.cast::<Light>().map_err(|_| wrong(&light))?.get().local(origin));
    }
    Ok(sources)
}
