use std::f32::consts::PI;
use std::str::FromStr;

use glam::{Quat, Vec3};
use umbrage::rays::LightSource;
use umbrage::scene::Light;

use crate::values::{number, vector};

/// A light as the command line gives it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct LightFlag {
    source: LightSource,
    /// Where a light without a strength is as bright as full sunlight; `None` for the scene's centre.
    target: Option<Vec3>,
    /// In candela or lux.
    intensity: Option<f32>,
    color: Vec3,
    casts_shadow: bool,
}

impl LightFlag {
    /// The light in a scene around `center`.
    pub(crate) fn light(&self, center: Vec3) -> Light {
        // An irradiance of π makes a white surface as bright as a screen's white.
        let bright = match self.source {
            LightSource::Directional { .. } => PI,
            LightSource::Point { position } | LightSource::Spot { position, .. } => {
                let distance_squared = position.distance_squared(self.target.unwrap_or(center));
                PI * if distance_squared > 0.0 { distance_squared } else { 1.0 }
            }
        };
        let intensity = self.intensity.unwrap_or(bright);
        Light {
            name: "".into(),
            source: self.source,
            color: self.color,
            intensity,
            range: None,
            casts_shadow: self.casts_shadow,
        }
    }
}

impl FromStr for LightFlag {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (text, casts_shadow) = match text.strip_suffix(":noshadow") {
            Some(rest) => (rest, false),
            None => (text, true),
        };
        let parts: Vec<&str> = text.split(':').collect();
        let (source, target, rest) = match parts[..] {
            ["point", position, ref rest @ ..] => (LightSource::Point { position: vector(position)? }, None, rest),
            ["sun", travel, ref rest @ ..] => {
                let direction = direction(vector(travel)?, "a sun's direction")?;
                (LightSource::Directional { direction }, None, rest)
            }
            ["spot", position, target, angle, ref rest @ ..] => {
                let (position, target) = (vector(position)?, vector(target)?);
                let direction = direction(target - position, "the way from a spot to its target")?;
                (spot(position, direction, number(angle)?)?, Some(target), rest)
            }
            _ => {
                return Err("give point:X,Y,Z, sun:DX,DY,DZ or spot:X,Y,Z:X,Y,Z:DEGREES, then if wanted \
                            :STRENGTH or :STRENGTH:R,G,B, then if wanted :noshadow"
                    .to_owned());
            }
        };
        let (intensity, color) = match rest {
            [] => (None, Vec3::ONE),
            [intensity] => (Some(number(intensity)?), Vec3::ONE),
            [intensity, color] => (Some(number(intensity)?), vector(color)?),
            _ => return Err("there is too much behind the colour".to_owned()),
        };
        if intensity.is_some_and(|intensity| intensity < 0.0) || color.min_element() < 0.0 {
            return Err("a light's strength and colour aren't below zero".to_owned());
        }
        Ok(Self { source, target, intensity, color, casts_shadow })
    }
}

fn direction(vector: Vec3, what: &str) -> Result<Vec3, String> {
    // In f64: the square of a small or large component would leave f32's range.
    let direction = vector.as_dvec3().try_normalize().ok_or_else(|| format!("{what} has no length"))?;
    Ok(direction.as_vec3())
}

fn spot(position: Vec3, direction: Vec3, full_angle_degrees: f32) -> Result<LightSource, String> {
    /// How much of the cone has the full strength.
    const INNER: f32 = 0.85;
    if !(0.1..=180.0).contains(&full_angle_degrees) {
        return Err("a spot's angle is from 0.1 to 180 degrees".to_owned());
    }
    let outer_radians = 0.5 * full_angle_degrees.to_radians();
    Ok(LightSource::Spot { position, direction, inner_radians: INNER * outer_radians, outer_radians })
}

/// The source turned round the vertical axis through `center`; `turn` is 1 for the whole circle.
pub(crate) fn orbited(source: LightSource, center: Vec3, turn: f64) -> LightSource {
    let rotation = Quat::from_rotation_y((turn.fract() * std::f64::consts::TAU) as f32);
    let moved = |position: Vec3| center + rotation * (position - center);
    let turned = |direction: Vec3| (rotation * direction).normalize();
    match source {
        LightSource::Point { position } => LightSource::Point { position: moved(position) },
        LightSource::Spot { position, direction, inner_radians, outer_radians } => {
            LightSource::Spot { position: moved(position), direction: turned(direction), inner_radians, outer_radians }
        }
        LightSource::Directional { direction } => LightSource::Directional { direction: turned(direction) },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lights_parse() {
        let light = |text: &str| text.parse::<LightFlag>().unwrap().light(Vec3::ZERO);
        let point = light("point:0,2,0");
        assert_eq!(point.source, LightSource::Point { position: Vec3::new(0.0, 2.0, 0.0) });
        assert_eq!((point.intensity, point.color, point.casts_shadow), (4.0 * PI, Vec3::ONE, true));
        assert_eq!(light("point:0,2,0:noshadow"), Light { casts_shadow: false, ..point });
        let sun = light("sun:0,-2,0:5:1,0.5,0");
        assert_eq!(sun.source, LightSource::Directional { direction: Vec3::NEG_Y });
        assert_eq!((sun.intensity, sun.color), (5.0, Vec3::new(1.0, 0.5, 0.0)));
        let LightSource::Spot { direction, inner_radians, outer_radians, .. } = light("spot:0,3,0:0,0,0:60").source
        else {
            panic!("not a spot")
        };
        assert_eq!(direction, Vec3::NEG_Y);
        assert!((outer_radians - PI / 6.0).abs() < 1e-6 && inner_radians < outer_radians);
    }

    #[test]
    fn wrong_lights_say_why() {
        for (text, why) in [
            ("lamp:1,2,3", "give point:"),
            ("point", "give point:"),
            ("point:1,2", "three numbers"),
            ("point:1,2,3:x", "`x` is not a number"),
            ("point:1,2,3:-1", "below zero"),
            ("point:1,2,3:1:1,1,1:1", "too much"),
            ("sun:0,0,0", "no length"),
            ("spot:0,3,0:0,3,0:60", "no length"),
            ("spot:0,3,0:0,0,0:0", "0.1 to 180"),
            ("spot:0,3,0:0,0,0", "give point:"),
        ] {
            let refused = text.parse::<LightFlag>().unwrap_err();
            assert!(refused.contains(why), "{text}: {refused}");
        }
    }

    #[test]
    fn a_quarter_of_an_orbit_turns_x_to_minus_z() {
        let center = Vec3::new(1.0, 0.0, 0.0);
        let LightSource::Point { position } =
            orbited(LightSource::Point { position: Vec3::new(3.0, 5.0, 0.0) }, center, 0.25)
        else {
            panic!("not a point")
        };
        assert!(position.abs_diff_eq(Vec3::new(1.0, 5.0, -2.0), 1e-5), "{position}");
    }
}
