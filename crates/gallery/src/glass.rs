//! Balls of glass, mirror and lacquer on a chequered floor.

use glam::{Vec2, Vec3};

use super::build::math::{mix, turned, wave};
use super::build::{MeshBuilder, Paint, checker, fineness_of_balls, srgb};
use super::{DemoScene, Moment, Pose, studio};
use umbrage_scene::{Material, Volume};

pub(crate) const SCENE: DemoScene = DemoScene {
    name: "glass",
    about: "balls of glass and mirror on a chequered floor",
    triangles: 60_000,
    seconds: 16.0,
    still_seconds: 7.0,
    open,
};

/// Motion of a ball from its start.
#[derive(Clone, Copy, Debug)]
enum Motion {
    Rests,
    /// Around the y axis, once in the whole scene.
    Circles,
    /// Up and down.
    Floats,
}

/// Finish of a ball.
#[derive(Clone, Copy, Debug)]
enum Finish {
    Clear,
    Bubble,
    /// Glass that takes on this sRGB colour over most of a ball.
    Stained(u32),
    Mirror,
    /// Metal of this sRGB colour and roughness.
    Metal(u32, f32),
    /// Glossy paint of this sRGB colour.
    Lacquer(u32),
}

/// Middle, radius, motion and finish of each ball; those that rest or circle lie on the floor.
const BALLS: [(Vec3, f32, Motion, Finish); 14] = {
    use Finish::{Bubble, Clear, Lacquer, Metal, Mirror, Stained};
    use Motion::{Floats, Rests};
    [
        (Vec3::new(0.0, 1.0, 0.0), 1.0, Rests, Clear),
        (Vec3::new(-2.7, 1.35, -2.7), 1.35, Rests, Mirror),
        (Vec3::new(2.9, 1.0, -2.4), 1.0, Rests, Metal(0xe3a77c, 0.22)),
        (Vec3::new(0.9, 2.35, -1.6), 0.6, Floats, Bubble),
        circling(0.00, 0.42, Stained(0xb5172f)),
        circling(0.11, 0.28, Lacquer(0xf2efe6)),
        circling(0.21, 0.34, Mirror),
        circling(0.31, 0.26, Lacquer(0xe0892b)),
        circling(0.41, 0.40, Stained(0x1f8f5f)),
        circling(0.52, 0.30, Lacquer(0x17636b)),
        circling(0.61, 0.24, Metal(0xf0c26a, 0.15)),
        circling(0.71, 0.38, Stained(0x2b55c9)),
        circling(0.81, 0.32, Clear),
        circling(0.91, 0.26, Lacquer(0xa8323e)),
    ]
};

/// A ball on the ring around the middle one; `turns` is its position on the ring, kept in `x` until the start.
const fn circling(turns: f32, radius: f32, finish: Finish) -> (Vec3, f32, Motion, Finish) {
    (Vec3::new(turns, radius, 0.0), radius, Motion::Circles, finish)
}

const TILES: Paint = Paint::textured("floor", || checker("tiles", 256, srgb(0x31474c), srgb(0xe9e2d3)), [1.8; 2], 0.35);

/// Radius of the ring on which balls circle.
const RING: f32 = 1.95;

fn open(triangles: usize) -> Pose {
    let mut builder = MeshBuilder::new();
    builder.paint(TILES).floor(Vec3::ZERO, Vec2::splat(400.0), [1, 1]);

    // A bubble has two surfaces.
    let mut radii: Vec<f32> = BALLS.iter().map(|ball| ball.1).collect();
    radii.extend(BALLS.iter().filter(|ball| matches!(ball.3, Finish::Bubble)).map(|ball| ball.1));
    let fineness = fineness_of_balls(&radii, triangles.saturating_sub(2));
    let mut inner_fineness = fineness[BALLS.len()..].iter();
    let mut balls = Vec::new();
    for ((center, radius, motion, finish), &fineness) in BALLS.into_iter().zip(&fineness) {
        let start = builder.positions.len();
        let center = match motion {
            Motion::Circles => {
                let away = mix(0.94, 1.1, 0.5 + 0.5 * wave(center.x * 3.0));
                Vec3::new(RING * away * wave(center.x), center.y, RING * away * wave(center.x + 0.25))
            }
            Motion::Rests | Motion::Floats => center,
        };
        builder.material(finish.material(radius)).ball(center, radius, fineness);
        if matches!(finish, Finish::Bubble) {
            let inner = inner_fineness.next().copied().unwrap_or(fineness);
            builder.hollow(center, 0.96 * radius, inner);
        }
        balls.push((start..builder.positions.len(), motion, center));
    }
    let still = builder.finish();

    Box::new(move |Moment { part, .. }, frame| {
        frame.copy_surfaces(&still);
        let turn = turned(std::f32::consts::TAU * part);
        for (vertices, motion, center) in &balls {
            let offset = match motion {
                Motion::Rests => continue,
                Motion::Circles => turn * *center - *center,
                Motion::Floats => Vec3::new(0.25 * wave(part), 0.22 * wave(2.0 * part), 0.0),
            };
            for position in &mut frame.positions[vertices.clone()] {
                *position += offset;
            }
        }
        let eye = turned(0.12 * wave(part)) * Vec3::new(1.3, 3.1, 7.2);
        studio::look(frame, "front", eye, Vec3::new(0.1, 0.95, -0.4), 0.34);
        let lamp = turned(0.35 * wave(part + 0.25)) * Vec3::new(-4.2, 6.5, 3.2);
        studio::light(frame, "key", lamp, Vec3::ZERO, srgb(0xfff1de), 1.0);
        studio::light(frame, "fill", Vec3::new(6.0, 5.0, 4.0), Vec3::ZERO, srgb(0xcfe0ff), 0.22);
    })
}

impl Finish {
    /// The material for a ball of `radius`.
    fn material(self, radius: f32) -> Material {
        let plain = Material { roughness: 0.0, ior: 1.5, double_sided: true, ..Material::default() };
        let glass = |name: &str, volume: Volume| Material {
            name: name.into(),
            transmission: 1.0,
            volume: Volume { thickness: 2.0 * radius, ..volume },
            ..plain.clone()
        };
        match self {
            Self::Clear => glass("clear glass", Volume::default()),
            Self::Bubble => glass("thin glass", Volume::default()),
            Self::Stained(color) => {
                let volume =
                    Volume { attenuation_distance: 1.8 * radius, attenuation_color: srgb(color), ..Volume::default() };
                // The surface has some of the colour too, for renderers that don't follow light through volumes.
                let base_color = Vec3::ONE.lerp(srgb(color), 0.35).extend(1.0);
                Material { base_color, ..glass("stained glass", volume) }
            }
            Self::Mirror => metal("mirror", 0xf2f4f5, 0.0),
            Self::Metal(color, roughness) => metal("metal", color, roughness),
            Self::Lacquer(color) => {
                Material { name: "lacquer".into(), base_color: srgb(color).extend(1.0), roughness: 0.15, ..plain }
            }
        }
    }
}

fn metal(name: &str, color: u32, roughness: f32) -> Material {
    let base_color = srgb(color).extend(1.0);
    Material { name: name.into(), base_color, metallic: 1.0, roughness, double_sided: true, ..Material::default() }
}
