use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16};
use glam::Vec3;
use umbrage_rays::LightSource;
use umbrage_scene::Light;

use super::lanes::{Vectors, Wide};

/// The light that arrives at points without occlusion.
#[derive(Clone, Copy)]
pub(crate) struct Arriving<S: Simd> {
    /// Unit direction towards the light.
    pub(crate) towards: Vectors<S>,
    /// Irradiance of a surface that faces the light; zero outside its cone and range, and in the light itself.
    pub(crate) irradiance: Vectors<S>,
}

/// A light, with the numbers that are the same for all points.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Emitter {
    source: LightSource,
    emitted: Vec3,
    /// One over the squared range of lights that have one.
    inverse_squared_range: Option<f32>,
    /// Of a spot with a cone, the factor and the summand that turn the cosine to its axis into the root of its falloff. A
    /// flat light falls off with the cosine itself.
    cone: Option<[f32; 2]>,
}

impl Emitter {
    pub(crate) fn new(light: &Light) -> Self {
        let cone = match light.source {
            LightSource::Spot { inner_radians, outer_radians, .. } if !light.shape.is_flat() => {
                // KHR_lights_punctual: squared linear interpolation between the cosines of the two angles.
                let (inner, outer) = (libm::cosf(inner_radians), libm::cosf(outer_radians));
                let factor = 1.0 / (inner - outer).max(1e-4);
                Some([factor, -outer * factor])
            }
            _ => None,
        };
        Self {
            source: light.source,
            emitted: (light.color * light.intensity).clamp(Vec3::MIN, Vec3::MAX),
            inverse_squared_range: light.range.map(|range| (1.0 / (range * range)).clamp(f32::MIN_POSITIVE, f32::MAX)),
            cone,
        }
    }

    /// The direction and irradiance at some points.
    #[inline(always)]
    pub(crate) fn arriving<S: Simd>(&self, simd: S, points: [Wide<S>; 2]) -> Arriving<S> {
        match self.source {
            LightSource::Directional { direction } => Arriving {
                towards: Vectors::splat(simd, -direction),
                irradiance: Vectors::splat(simd, self.emitted).at_most_brightest(),
            },
            LightSource::Point { position } => self.at_position(simd, position, points),
            LightSource::Spot { position, direction, .. } => {
                let arriving = self.at_position(simd, position, points);
                let cosine = Vectors::splat(simd, -direction).dot(arriving.towards);
                let part = match self.cone {
                    Some([factor, summand]) => {
                        let root = (cosine * factor + summand).max(0.0).min(1.0);
                        root * root
                    }
                    None => cosine.max(0.0),
                };
                Arriving { irradiance: arriving.irradiance.scaled(part), ..arriving }
            }
        }
    }

    /// The same for a light at a point that shines in all directions.
    #[inline(always)]
    fn at_position<S: Simd>(&self, simd: S, position: Vec3, points: [Wide<S>; 2]) -> Arriving<S> {
        // In f64, since points of a scene far from the origin may be near the light.
        let position = Wide::splat(simd, position.as_dvec3());
        let offset = Vectors::narrow([position - points[0], position - points[1]]);
        let squared = offset.dot(offset);
        let is_apart = squared.simd_gt(0.0);
        let inverse = 1.0 / squared.sqrt();
        let nothing = Vectors::splat(simd, Vec3::ZERO);
        let faded = match self.inverse_squared_range {
            Some(inverse) => fade(squared * inverse),
            None => f32x16::splat(simd, 1.0),
        };
        let irradiance = Vectors::splat(simd, self.emitted).scaled(faded * inverse * inverse).at_most_brightest();
        Arriving {
            towards: Vectors::select(is_apart, offset.scaled(inverse), nothing),
            irradiance: Vectors::select(is_apart, irradiance, nothing),
        }
    }
}

/// The part of a light, 0 to 1, left at a squared distance given in squared ranges (`KHR_lights_punctual`).
#[inline(always)]
fn fade<S: Simd>(squared: f32x16<S>) -> f32x16<S> {
    (1.0 - squared * squared).max(0.0).min(1.0)
}

#[cfg(test)]
mod tests {
    use std::f32::consts::FRAC_PI_4;

    use glam::DVec3;
    use umbrage_rays::{SimdLevel, dispatch};

    use super::*;
    use crate::shade::lanes::{Each, vector_of};

    fn light(source: LightSource, range: Option<f32>) -> Light {
        Light { range, ..Light::new(source, 8.0) }
    }

    /// Direction towards the light and irradiance; `None` where that is zero.
    fn arriving_at(light: &Light, point: DVec3) -> Option<[Vec3; 2]> {
        let arriving: [[Each<f32>; 3]; 2] = dispatch!(SimdLevel::default(), simd => {
            let arriving = Emitter::new(light).arriving(simd, [Wide::splat(simd, point); 2]);
            [arriving.towards.store(), arriving.irradiance.store()]
        });
        let arriving = arriving.map(|vectors| vector_of(0, &vectors));
        (arriving[1] != Vec3::ZERO).then_some(arriving)
    }

    #[test]
    fn a_point_light_falls_off_with_the_square_of_the_distance() {
        let lamp = light(LightSource::Point { position: Vec3::new(0.0, 2.0, 0.0) }, None);
        assert_eq!(arriving_at(&lamp, DVec3::ZERO), Some([Vec3::Y, Vec3::splat(2.0)]));
    }

    #[test]
    fn nothing_arrives_beyond_the_range_or_inside_the_light() {
        let lamp = light(LightSource::Point { position: Vec3::ZERO }, Some(2.0));
        assert!(arriving_at(&lamp, DVec3::X).is_some());
        assert!(arriving_at(&lamp, DVec3::X * 2.0).is_none());
        assert!(arriving_at(&lamp, DVec3::ZERO).is_none());
    }

    #[test]
    fn a_spot_light_is_full_inside_and_dark_outside_its_cone() {
        let direction = Vec3::NEG_Y;
        let spot = |angle: f32| {
            let source =
                LightSource::Spot { position: Vec3::ZERO, direction, inner_radians: 0.2, outer_radians: FRAC_PI_4 };
            let point = Vec3::new(angle.sin(), -angle.cos(), 0.0).as_dvec3();
            arriving_at(&light(source, None), point).map(|[_, irradiance]| irradiance.x)
        };
        assert!((spot(0.1).unwrap() - 8.0).abs() < 1e-3);
        assert!(spot(0.5).unwrap() < 8.0);
        assert_eq!(spot(FRAC_PI_4 + 0.01), None);
    }
}
