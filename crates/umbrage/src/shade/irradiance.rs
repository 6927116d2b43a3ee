use glam::{DVec3, Vec3};
use umbrage_rays::LightSource;
use umbrage_scene::Light;

/// A light as it arrives at a point where nothing is in between.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Arriving {
    /// Unit direction towards the light.
    pub(crate) towards: Vec3,
    /// Irradiance of a surface that faces the light.
    pub(crate) irradiance: Vec3,
}

/// What `light` sends to `point`; `None` outside its cone and range, and in the light itself.
pub(crate) fn arriving(light: &Light, point: DVec3) -> Option<Arriving> {
    let emitted = light.color * light.intensity;
    let from_point = |position: Vec3| {
        let offset = position.as_dvec3() - point;
        let squared = offset.length_squared();
        let faded = light.range.map_or(1.0, |range| fade(squared.sqrt() as f32 / range));
        let irradiance = emitted * (faded / squared as f32);
        (squared > 0.0 && faded > 0.0).then(|| Arriving { towards: offset.normalize().as_vec3(), irradiance })
    };
    match light.source {
        LightSource::Point { position } => from_point(position),
        LightSource::Spot { position, direction, inner_radians, outer_radians } => {
            let mut arriving = from_point(position)?;
            let cosine = direction.dot(-arriving.towards);
            // KHR_lights_punctual: squared linear interpolation between the cosines of the two angles.
            let (inner, outer) = (inner_radians.cos(), outer_radians.cos());
            let part = ((cosine - outer) / (inner - outer).max(1e-4)).clamp(0.0, 1.0);
            arriving.irradiance *= part * part;
            (part > 0.0).then_some(arriving)
        }
        LightSource::Directional { direction } => Some(Arriving { towards: -direction, irradiance: emitted }),
    }
}

/// How much of a light is left at a distance, given in ranges (`KHR_lights_punctual`).
fn fade(distance: f32) -> f32 {
    (1.0 - distance.powi(4)).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use std::f32::consts::FRAC_PI_4;

    use super::*;

    fn light(source: LightSource, range: Option<f32>) -> Light {
        Light { name: "".into(), source, color: Vec3::ONE, intensity: 8.0, range, casts_shadow: true }
    }

    #[test]
    fn a_point_light_falls_off_with_the_square_of_the_distance() {
        let lamp = light(LightSource::Point { position: Vec3::new(0.0, 2.0, 0.0) }, None);
        let arriving = arriving(&lamp, DVec3::ZERO).unwrap();
        assert_eq!(arriving.towards, Vec3::Y);
        assert_eq!(arriving.irradiance, Vec3::splat(2.0));
    }

    #[test]
    fn nothing_arrives_beyond_the_range_or_inside_the_light() {
        let lamp = light(LightSource::Point { position: Vec3::ZERO }, Some(2.0));
        assert!(arriving(&lamp, DVec3::X).is_some());
        assert!(arriving(&lamp, DVec3::X * 2.0).is_none());
        assert!(arriving(&lamp, DVec3::ZERO).is_none());
    }

    #[test]
    fn a_spot_light_is_full_inside_and_dark_outside_its_cone() {
        let direction = Vec3::NEG_Y;
        let spot = |angle: f32| {
            let source =
                LightSource::Spot { position: Vec3::ZERO, direction, inner_radians: 0.2, outer_radians: FRAC_PI_4 };
            let point = Vec3::new(angle.sin(), -angle.cos(), 0.0).as_dvec3();
            arriving(&light(source, None), point).map(|arriving| arriving.irradiance.x)
        };
        assert!((spot(0.1).unwrap() - 8.0).abs() < 1e-3);
        assert!(spot(0.5).unwrap() < 8.0);
        assert_eq!(spot(FRAC_PI_4 + 0.01), None);
    }
}
