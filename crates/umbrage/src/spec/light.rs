use std::f32::consts::PI;
use std::fmt;
use std::str::FromStr;

use glam::{DVec3, Vec3};
use umbrage_rays::LightSource;
use umbrage_scene::{Light, LightShape};

use super::color::color;
use super::{Length, Words, number, vector, widened, world_point};

/// A light: `point:X,Y,Z`, `sun:DX,DY,DZ` that travels along DX,DY,DZ, `spot:X,Y,Z:X,Y,Z:DEGREES` from a point to
/// another with the cone's full angle, or a flat one around a point that faces another, `rect:X,Y,Z:X,Y,Z:WIDTHxHEIGHT`
/// or `disk:X,Y,Z:X,Y,Z:RADIUS`; then, if wanted, `:STRENGTH` in candela or lux, a colour as `:R,G,B`, `:#rrggbb` or by
/// its name in CSS, `:radius=R` of any other than a flat one, and `:noshadow`. Sizes are in world units or, such as
/// `2%`, shares of the scene's size; a sun's radius is in degrees.
#[derive(Clone, Debug, PartialEq)]
pub struct LightSpec {
    /// Its position, where it has one, is `position` in f32.
    source: LightSource,
    /// In the world; zero for suns.
    position: DVec3,
    /// The point in the world that it faces, and where a light without a strength is as bright as full sunlight; `None`
    /// for the scene's centre.
    target: Option<DVec3>,
    /// In candela or lux.
    intensity: Option<f32>,
    color: Vec3,
    shape: LightShape,
    /// Whether the shape's lengths are in hundredths of the scene's size.
    is_share: bool,
    casts_shadow: bool,
}

impl LightSpec {
    /// A spot's inner angle, with the full strength, as a part of its outer angle.
    pub const INNER: f32 = 0.85;

    /// A white light that casts shadows, as bright as full sunlight at the middle of the scene.
    #[must_use]
    pub fn new(source: LightSource) -> Self {
        Self {
            source,
            position: position(&source),
            target: None,
            intensity: None,
            color: Vec3::ONE,
            shape: LightShape::POINT,
            is_share: false,
            casts_shadow: true,
        }
    }

    /// The light from a scene's [origin](umbrage_scene::Scene::origin) in place of the world's.
    #[must_use]
    pub fn local(&self, origin: [f64; 3]) -> Self {
        self.moved(-DVec3::from(origin))
    }

    /// The light in the world, inverse of [`local`](Self::local).
    #[must_use]
    pub fn in_world(&self, origin: [f64; 3]) -> Self {
        self.moved(origin.into())
    }

    fn moved(&self, by: DVec3) -> Self {
        let mut moved = self.clone();
        moved.target = moved.target.map(|target| target + by);
        if let LightSource::Point { position } | LightSource::Spot { position, .. } = &mut moved.source {
            moved.position += by;
            *position = moved.position.as_vec3();
        }
        moved
    }

    /// The same of another shape, in world units. A flat one needs [a source to one side](LightSource::to_one_side).
    #[must_use]
    pub fn shaped(self, shape: LightShape) -> Self {
        Self { shape, is_share: false, ..self }
    }

    /// Whether it is more than a point.
    #[must_use]
    pub fn is_wide(&self) -> bool {
        self.shape.is_wide()
    }

    /// Whether its size depends on the scene's.
    #[must_use]
    pub fn is_share(&self) -> bool {
        self.is_share
    }

    /// The light in a scene around `center`, both from the same origin, of this [size](umbrage_scene::Scene::size).
    #[must_use]
    pub fn light(&self, center: Vec3, scene_size: f32) -> Light {
        let target = self.target.map(DVec3::as_vec3);
        let mut source = self.source;
        if let (LightSource::Spot { position, direction: towards, .. }, Some(target)) = (&mut source, target) {
            // Of the points in f32, unless these are the same.
            *towards = direction(target - *position, "").unwrap_or(*towards);
        }
        // An irradiance of π makes a white surface as bright as a screen's white.
        let bright = match self.source {
            LightSource::Directional { .. } => PI,
            LightSource::Point { position } | LightSource::Spot { position, .. } => {
                let distance_squared = position.distance_squared(target.unwrap_or(center));
                PI * if distance_squared > 0.0 { distance_squared } else { 1.0 }
            }
        };
        let intensity = self.intensity.unwrap_or(bright);
        let Self { color, casts_shadow, .. } = *self;
        let length = |length: f32| self.length(length).in_scene(scene_size);
        let shape = match self.shape {
            LightShape::Ball(radius) => LightShape::Ball(length(radius)),
            LightShape::Disk(radius) => LightShape::Disk(length(radius)),
            LightShape::Rectangle { width, height } => {
                LightShape::Rectangle { width: length(width), height: length(height) }
            }
        };
        Light { color, casts_shadow, shape, ..Light::new(source, intensity) }
    }

    /// One of the shape's lengths.
    fn length(&self, number: f32) -> Length {
        if self.is_share { Length::Percent(number) } else { Length::World(number) }
    }
}

/// The property of a light that the words can't express.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum UnspeakableLight {
    /// The words have one softness of spots, [`LightSpec::INNER`].
    #[error("there are no words for how soft this spot light is")]
    Softness,
    /// The words have no range.
    #[error("there are no words for how far this light reaches")]
    Range,
}

impl TryFrom<&Light> for LightSpec {
    type Error = UnspeakableLight;

    fn try_from(light: &Light) -> Result<Self, UnspeakableLight> {
        if let LightSource::Spot { inner_radians, outer_radians, .. } = light.source
            && !light.shape.is_flat()
            && (inner_radians - Self::INNER * outer_radians).abs() > 1e-3 * outer_radians
        {
            return Err(UnspeakableLight::Softness);
        }
        if light.range.is_some() {
            return Err(UnspeakableLight::Range);
        }
        let Light { source, color, shape, casts_shadow, .. } = *light;
        let (position, intensity) = (position(&source), Some(light.intensity));
        Ok(Self { source, position, target: None, intensity, color, shape, is_share: false, casts_shadow })
    }
}

impl fmt::Display for LightSpec {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let position = Words(self.position.to_array());
        match self.source {
            LightSource::Point { .. } => write!(f, "point:{position}")?,
            LightSource::Directional { direction } => write!(f, "sun:{}", Words(direction.to_array()))?,
            LightSource::Spot { direction, outer_radians, .. } => {
                let target = Words(self.target.unwrap_or_else(|| self.position + widened(direction)).to_array());
                match self.shape {
                    LightShape::Ball(_) => write!(f, "spot:{position}:{target}:{}", 2.0 * outer_radians.to_degrees())?,
                    LightShape::Rectangle { width, height } => {
                        write!(f, "rect:{position}:{target}:{}x{}", self.length(width), self.length(height))?;
                    }
                    LightShape::Disk(radius) => write!(f, "disk:{position}:{target}:{}", self.length(radius))?,
                }
            }
        }
        // Without a strength it is white.
        if let Some(intensity) = self.intensity {
            write!(f, ":{intensity}:{}", Words(self.color.to_array()))?;
        }
        if let LightShape::Ball(radius) = self.shape
            && radius > 0.0
        {
            write!(f, ":radius={}", self.length(radius))?;
        }
        f.write_str(if self.casts_shadow { "" } else { ":noshadow" })
    }
}

impl FromStr for LightSpec {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (text, casts_shadow) = match text.strip_suffix(":noshadow") {
            Some(rest) => (rest, false),
            None => (text, true),
        };
        let (text, radius) = match text.rsplit_once(":radius=") {
            Some((rest, radius)) => (rest, Some(radius.parse::<Length>()?)),
            None => (text, None),
        };
        let ball = ball(radius.unwrap_or(Length::World(0.0)));
        let parts: Vec<&str> = text.split(':').collect();
        let (source, position, target, (shape, is_share), rest) = match parts[..] {
            ["point", position, ref rest @ ..] => {
                let position = world_point(position)?;
                (LightSource::Point { position: position.as_vec3() }, position, None, ball, rest)
            }
            ["sun", travel, ref rest @ ..] => {
                let direction = direction(vector(travel)?, "a sun's direction")?;
                (LightSource::Directional { direction }, DVec3::ZERO, None, ball, rest)
            }
            ["spot", position, target, angle, ref rest @ ..] => {
                let (position, target, direction) = aimed("spot", position, target)?;
                (spot(position.as_vec3(), direction, number(angle)?)?, position, Some(target), ball, rest)
            }
            [kind @ ("rect" | "disk"), position, target, size, ref rest @ ..] => {
                let (position, target, direction) = aimed(kind, position, target)?;
                let source = LightSource::to_one_side(position.as_vec3(), direction);
                (source, position, Some(target), flat(kind, size)?, rest)
            }
            _ => {
                return Err("give point:X,Y,Z, sun:DX,DY,DZ, spot:X,Y,Z:X,Y,Z:DEGREES, rect:X,Y,Z:X,Y,Z:WIDTHxHEIGHT or \
                            disk:X,Y,Z:X,Y,Z:RADIUS, then if wanted :STRENGTH or :STRENGTH:R,G,B, then if wanted :radius=R \
                            and :noshadow"
                    .to_owned());
            }
        };
        if shape.is_flat() && radius.is_some() {
            return Err("a flat light has no :radius=R: its size follows its target".to_owned());
        }
        let (intensity, color) = match rest {
            [] => (None, Vec3::ONE),
            [intensity] => (Some(number(intensity)?), Vec3::ONE),
            [intensity, named] => (Some(number(intensity)?), color(named)?),
            _ => return Err("there is too much behind the colour".to_owned()),
        };
        if intensity.is_some_and(|intensity| intensity < 0.0) {
            return Err("a light's strength isn't below zero".to_owned());
        }
        if let (LightSource::Directional { .. }, LightShape::Ball(degrees)) = (source, shape) {
            if is_share {
                return Err("a sun's radius is in degrees, such as :radius=0.27, and no share of the scene".to_owned());
            }
            if degrees > Light::MAX_SUN_RADIUS_DEGREES {
                return Err(format!("a sun's radius is at most {} degrees", Light::MAX_SUN_RADIUS_DEGREES));
            }
        }
        Ok(Self { source, position, target, intensity, color, shape, is_share, casts_shadow })
    }
}

/// Where a light of this kind is, the point that it faces, and the direction of that.
fn aimed(kind: &str, position: &str, target: &str) -> Result<(DVec3, DVec3, Vec3), String> {
    let (position, target) = (world_point(position)?, world_point(target)?);
    let way = (target - position).try_normalize();
    let way = way.ok_or_else(|| format!("the way from a {kind} to its target has no length"))?;
    Ok((position, target, way.as_vec3()))
}

/// Where a source is; zero for suns.
fn position(source: &LightSource) -> DVec3 {
    match *source {
        LightSource::Point { position } | LightSource::Spot { position, .. } => widened(position),
        LightSource::Directional { .. } => DVec3::ZERO,
    }
}

/// The shape of a light that is no flat one, and whether its radius is a share of the scene's size.
fn ball(radius: Length) -> (LightShape, bool) {
    (LightShape::Ball(radius.number()), radius.is_share())
}

/// The shape of a flat light, and whether its lengths are shares of the scene's size.
fn flat(kind: &str, size: &str) -> Result<(LightShape, bool), String> {
    if kind == "disk" {
        let radius: Length = size.parse()?;
        return Ok((LightShape::Disk(radius.number()), radius.is_share()));
    }
    let (width, height) = size.split_once('x').ok_or_else(|| format!("`{size}` is not a size such as 2x1"))?;
    let (width, height): (Length, Length) = (width.parse()?, height.parse()?);
    if width.is_share() != height.is_share() {
        return Err(format!(
            "`{size}`: both sides are in world units, or both are shares of the scene, such as 20%x10%"
        ));
    }
    Ok((LightShape::Rectangle { width: width.number(), height: height.number() }, width.is_share()))
}

fn direction(vector: Vec3, what: &str) -> Result<Vec3, String> {
    // In f64: the square of a small or large component would leave f32's range.
    let direction = vector.as_dvec3().try_normalize().ok_or_else(|| format!("{what} has no length"))?;
    Ok(direction.as_vec3())
}

fn spot(position: Vec3, direction: Vec3, full_angle_degrees: f32) -> Result<LightSource, String> {
    if !(0.1..=180.0).contains(&full_angle_degrees) {
        return Err("a spot's angle is from 0.1 to 180 degrees".to_owned());
    }
    let outer_radians = 0.5 * full_angle_degrees.to_radians();
    Ok(LightSource::Spot { position, direction, inner_radians: LightSpec::INNER * outer_radians, outer_radians })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lights_parse() {
        let light = |text: &str| text.parse::<LightSpec>().unwrap().light(Vec3::ZERO, 1.0);
        let point = light("point:0,2,0");
        assert_eq!(point.source, LightSource::Point { position: Vec3::new(0.0, 2.0, 0.0) });
        assert_eq!((point.intensity, point.color, point.casts_shadow), (4.0 * PI, Vec3::ONE, true));
        assert_eq!(light("point:0,2,0:noshadow"), Light { casts_shadow: false, ..point });
        let sun = light("sun:0,-2,0:5:1,0.5,0");
        assert_eq!(sun.source, LightSource::Directional { direction: Vec3::NEG_Y });
        assert_eq!((sun.intensity, sun.color), (5.0, Vec3::new(1.0, 0.5, 0.0)));
        assert_eq!(light("sun:0,-2,0:5:yellow").color, Vec3::new(1.0, 1.0, 0.0));
        let LightSource::Spot { direction, inner_radians, outer_radians, .. } = light("spot:0,3,0:0,0,0:60").source
        else {
            panic!("not a spot")
        };
        assert_eq!(direction, Vec3::NEG_Y);
        assert!((outer_radians - PI / 6.0).abs() < 1e-6 && inner_radians < outer_radians);
    }

    #[test]
    fn sizes_may_be_shares_of_the_scene() {
        for (text, shape) in [
            ("point:0,2,0:radius=10%", LightShape::Ball(0.5)),
            ("point:1,3,0:radius=1%:noshadow", LightShape::Ball(0.05)),
            ("rect:0,3,0:0,0,0:20%x50%", LightShape::Rectangle { width: 1.0, height: 2.5 }),
            ("disk:0,3,0:0,0,0:2%", LightShape::Disk(0.1)),
            ("disk:0,3,0:0,0,0:2", LightShape::Disk(2.0)),
        ] {
            let spec: LightSpec = text.parse().unwrap();
            assert_eq!((spec.light(Vec3::ZERO, 5.0).shape, spec.is_share()), (shape, text.contains('%')), "{text}");
            assert_eq!(spec.to_string(), text);
        }
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
            ("point:1,2,3:1:1,-1,1", "a colour isn't below zero"),
            ("point:1,2,3:1:orang", "`orange`"),
            ("sun:0,0,0", "no length"),
            ("point:1,2,3:radius=x", "`x` is no length"),
            ("point:1,2,3:radius=-1", "world units from 0"),
            ("point:1,2,3:radius=-3%", "such as 2%"),
            ("sun:0,-1,0:radius=1%", "in degrees"),
            ("rect:0,3,0:0,0,0:10%x1", "both"),
            ("sun:0,-1,0:radius=46", "45 degrees"),
            ("spot:0,3,0:0,3,0:60", "no length"),
            ("spot:0,3,0:0,0,0:0", "0.1 to 180"),
            ("spot:0,3,0:0,0,0", "give point:"),
            ("rect:0,3,0:0,0,0", "give point:"),
            ("rect:0,3,0:0,3,0:1x1", "no length"),
            ("rect:0,3,0:0,0,0:1", "2x1"),
            ("rect:0,3,0:0,0,0:1x-1", "`-1` is no length"),
            ("disk:0,3,0:0,0,0:x", "`x` is no length"),
            ("disk:0,3,0:0,0,0:1:radius=1", "no :radius=R"),
        ] {
            let refused = text.parse::<LightSpec>().unwrap_err();
            assert!(refused.contains(why), "{text}: {refused}");
        }
    }

    #[test]
    fn lights_are_said_to_the_last_bit() {
        let source = LightSource::Point { position: Vec3::new(0.1, -2.0, 1e-7) };
        let light = Light { color: Vec3::new(1.0, 0.5, 0.25), ..Light::new(source, 12.3) };
        let said = |light: &Light| LightSpec::try_from(light).map(|spec| spec.to_string());
        assert_eq!(said(&light).unwrap(), "point:0.1,-2,0.0000001:12.3:1,0.5,0.25");
        let wide = Light { shape: LightShape::Ball(0.25), ..light.clone() };
        assert!(said(&wide).unwrap().ends_with(":radius=0.25"));
        let hidden = Light { casts_shadow: false, ..light.clone() };
        assert!(said(&hidden).unwrap().ends_with(":noshadow"));
        assert_eq!(said(&Light { range: Some(3.0), ..light }), Err(UnspeakableLight::Range));
        let source = "spot:0,3,0:0,0,0:60".parse::<LightSpec>().unwrap().light(Vec3::ZERO, 1.0);
        let again: LightSpec = said(&source).unwrap().parse().unwrap();
        assert_eq!(again.light(Vec3::ZERO, 1.0).intensity, source.intensity);
        for text in [
            "point:0,2,0",
            "point:0,2,0:radius=0.5",
            "sun:0,-1,0:5:1,0.5,0:radius=0.27:noshadow",
            "spot:0,3,0:0,0,0:60:3:1,1,1",
            "rect:0,3,0:1,0,0:2x0.5:3:1,1,1:noshadow",
            "disk:0,3,0:0,0,0:0.5",
        ] {
            let spec: LightSpec = text.parse().unwrap();
            let light = spec.light(Vec3::ZERO, 1.0);
            assert_eq!(said(&light).unwrap().parse::<LightSpec>().unwrap().light(Vec3::ZERO, 1.0), light, "{text}");
            assert_eq!(spec.to_string().parse(), Ok(spec), "{text}");
        }
    }
}
