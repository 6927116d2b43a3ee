//! The traced frames: scenes, cameras and lights.

use std::fmt;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use glam::{Quat, Vec3};
use umbrage::rays::{Bounds, Camera, LightSource, Opacity, Opaque, Projection, Ray, Sides, View};
use umbrage::scene::Frame;
use umbrage::{Samples, Scene};

/// Scenes of the gallery in which nearly all triangles move or change, or the camera moves.
pub(crate) const GALLERY: [&str; 7] =
    ["demo:cloth", "demo:forest", "demo:hall", "demo:shatter", "demo:statue", "demo:marbles", "demo:gears"];

/// Files that are looked up in a folder of real scenes; missing ones are left out.
const FILES: [&str; 9] = [
    "cesium_man.glb",
    "robot_expressive.glb",
    "robot_arm.glb",
    "elephant_gallop.glb",
    "vintage_fan.glb",
    "horse_gallop_obj_sequence",
    INTERIORS[0].file,
    INTERIORS[1].file,
    INTERIORS[2].file,
];

/// Camera and light of an interior; its file has none, or shows it from outside.
struct Interior {
    file: &'static str,
    eye: Vec3,
    target: Vec3,
    fov_degrees: f32,
    light: Vec3,
}

const INTERIORS: [Interior; 3] = [
    // The nave from above the entrance, towards the apse.
    Interior {
        file: "sibenik.obj",
        eye: Vec3::new(14.0, 6.0, 2.0),
        target: Vec3::new(-10.0, 4.0, -1.0),
        fov_degrees: 75.0,
        light: Vec3::new(3.0, 8.0, 0.0),
    },
    // The file's camera, turned to show the whole room.
    Interior {
        file: "country_kitchen.glb",
        eye: Vec3::new(1.211, 1.8, 3.85),
        target: Vec3::new(0.0, 1.0, -1.0),
        fov_degrees: 60.0,
        light: Vec3::new(1.0, 2.6, 1.0),
    },
    // The kitchen over its counter, below a ceiling that isn't there.
    Interior {
        file: "dream_apartment.glb",
        eye: Vec3::new(8.3, 1.6, -6.8),
        target: Vec3::new(11.0, 0.9, -3.0),
        fov_degrees: 75.0,
        light: Vec3::new(10.0, 2.4, -5.0),
    },
];

/// Which lights of a frame cast shadows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Lights {
    /// The frame's first one.
    First,
    /// All of them, one after the other.
    All,
    /// This many: the frame's own and, if it has fewer, its first one, turned around the scene.
    Count(u32),
}

impl FromStr for Lights {
    type Err = &'static str;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        match text {
            "first" => Ok(Self::First),
            "all" => Ok(Self::All),
            number => match number.parse() {
                Ok(count @ 1..) => Ok(Self::Count(count)),
                _ => Err("`first`, `all` or a number above zero is needed"),
            },
        }
    }
}

impl fmt::Display for Lights {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::First => f.write_str("first"),
            Self::All => f.write_str("all"),
            Self::Count(count) => write!(f, "{count}"),
        }
    }
}

/// One frame, the same for all sides.
#[derive(Debug)]
pub(crate) struct Shot<'a> {
    pub(crate) frame: &'a Frame,
    pub(crate) view: View,
    /// Samples of each pixel, as our structures trace them together.
    pub(crate) samples: Vec<Samples>,
    pub(crate) lights: Vec<LightSource>,
    /// Bounds of all triangles.
    pub(crate) bounds: Bounds,
    /// Whether alpha masks and opacity let rays pass; otherwise all triangles stop rays.
    pub(crate) masks: bool,
}

impl<'a> Shot<'a> {
    /// `frame` of the scene at `address`, with opaque triangles. Interiors have a camera and a light of ours; other
    /// scenes have their own.
    pub(crate) fn new(
        frame: &'a Frame,
        address: &str,
        [width, height]: [u32; 2],
        samples: u32,
        lights: Lights,
    ) -> Self {
        let interior = interior(address);
        let camera = interior.map_or_else(|| frame.camera(width as f32 / height as f32), Interior::camera);
        let mut sources: Vec<LightSource> = match interior {
            Some(Interior { light: position, .. }) => vec![LightSource::Point { position: *position }],
            None => frame.lights.iter().map(|light| light.source).collect(),
        };
        if lights == Lights::First {
            sources.truncate(1);
        }
        let mut shot = Self {
            frame,
            view: View { camera, width, height },
            samples: Samples::all(samples, true).collect(),
            lights: sources,
            bounds: frame.triangles().bounds(),
            masks: false,
        };
        if let Lights::Count(count) = lights {
            shot.make_lights(count);
        }
        shot
    }
}

impl Shot<'_> {
    /// All samples, each of them alone.
    pub(crate) fn each_alone(&self) -> Vec<Samples> {
        self.samples.iter().flat_map(Samples::as_slice).map(|&sample| Samples::one(sample)).collect()
    }

    /// The ray of a pixel at the last sample, and its position in the image of all samples that are traced with it.
    pub(crate) fn last_ray(&self, x: u32, y: u32) -> (Ray, [u32; 2]) {
        let samples = &self.samples[self.samples.len() - 1];
        let which = samples.as_slice().len() - 1;
        let ([column, row], side) = (samples.quarter(which), samples.side());
        (samples.as_slice()[which].ray(&self.view, x, y), [side * x + column, side * y + row])
    }

    /// Makes the camera's view so many times narrower.
    pub(crate) fn narrow(&mut self, times: f32) {
        match &mut self.view.camera.projection {
            Projection::Perspective { tan_half_height: size } | Projection::Orthographic { half_height: size } => {
                *size /= times;
            }
        }
    }

    /// Drops lights, or adds the first one, turned around the scene, until there are `count`.
    pub(crate) fn make_lights(&mut self, count: u32) {
        let Self { lights, bounds, .. } = self;
        let from_above = LightSource::Point { position: bounds.center() + bounds.size() };
        let first = lights.first().copied().unwrap_or(from_above);
        lights.truncate(count as usize);
        lights.extend((lights.len() as u32..count).map(|index| turned(first, bounds.center(), index)));
    }

    /// Opacities for camera rays and for shadow rays.
    pub(crate) fn opacities(&self) -> [Box<dyn Opacity + '_>; 2] {
        if self.masks {
            [Box::new(self.frame.camera_opacity()), Box::new(self.frame.shadow_opacity())]
        } else {
            [Box::new(Opaque), Box::new(Opaque)]
        }
    }

    /// The question of some samples of each pixel.
    pub(crate) fn question<'a>(
        &'a self,
        [opacity, shadow_opacity]: &'a [Box<dyn Opacity + '_>; 2],
        samples: &Samples,
    ) -> umbrage::rays::Shot<'a> {
        let question = umbrage::rays::Shot::new(self.frame.triangles(), self.view);
        // Other ray tracers have no one-sided triangles.
        let sides = Sides::Both;
        let [opacity, shadow_opacity] = [&**opacity, &**shadow_opacity];
        samples.question(umbrage::rays::Shot { opacity, shadow_opacity, sides, ..question })
    }
}

/// The light after `index` golden angles around the vertical axis through `middle`: any number of them are spread evenly.
fn turned(light: LightSource, middle: Vec3, index: u32) -> LightSource {
    const GOLDEN_ANGLE: f32 = 2.399_963_1;
    let turn = Quat::from_rotation_y(GOLDEN_ANGLE * index as f32);
    let at = |position: Vec3| middle + turn * (position - middle);
    match light {
        LightSource::Point { position } => LightSource::Point { position: at(position) },
        LightSource::Spot { position, direction, inner_radians, outer_radians } => {
            LightSource::Spot { position: at(position), direction: turn * direction, inner_radians, outer_radians }
        }
        LightSource::Directional { direction } => LightSource::Directional { direction: turn * direction },
    }
}

impl Interior {
    fn camera(&self) -> Camera {
        Camera::look_at(self.eye, self.target, Vec3::Y, self.fov_degrees.to_radians())
    }
}

fn interior(address: &str) -> Option<&'static Interior> {
    INTERIORS.iter().find(|interior| interior.file == name(address))
}

/// The last part of an address.
pub(crate) fn name(address: &str) -> &str {
    address.rsplit('/').next().unwrap_or(address)
}

/// The same without common prefixes and suffixes, for charts.
pub(crate) fn short_name(address: &str) -> &str {
    let name = name(address);
    let name = name.strip_prefix("demo:").unwrap_or(name);
    name.rsplit_once('.').map_or(name, |(stem, _)| stem)
}

/// Addresses of the named scenes, or else of the whole gallery.
pub(crate) fn or_gallery(named: &[String]) -> Vec<String> {
    let gallery = || umbrage::gallery::DEMOS.iter().map(|demo| format!("demo:{}", demo.name)).collect();
    if named.is_empty() { gallery() } else { named.to_vec() }
}

/// Addresses of the scenes that take part: the named ones, or else the gallery's and those of a folder of files.
pub(crate) fn addresses(named: &[String], folder: Option<&PathBuf>) -> Vec<String> {
    if !named.is_empty() {
        return named.to_vec();
    }
    let path = |folder: &Path, name: &str| folder.join(name).to_string_lossy().into_owned();
    let files = folder.into_iter().flat_map(|folder| FILES.map(|name| path(folder, name)));
    GALLERY.map(str::to_owned).into_iter().chain(files.filter(|path| Path::new(path).exists())).collect()
}

/// Moments of `scene` in seconds for `frames` counted frames, and whether each counts: the first one takes memory that
/// later ones reuse.
pub(crate) fn moments(scene: &Scene, frames: u32) -> impl Iterator<Item = (f64, bool)> + use<> {
    let duration = scene.duration_seconds();
    (0..=frames).map(move |number| (duration * f64::from(number) / f64::from(frames + 1), number > 0))
}

/// Descriptions of the viewpoints of the interiors in `addresses`; empty for none.
pub(crate) fn viewpoints(addresses: &[String]) -> Vec<String> {
    let interiors = addresses.iter().filter_map(|address| interior(address));
    let words = |Interior { file, eye, target, fov_degrees, light }: &Interior| {
        format!("{file}: from {eye} to {target}, {fov_degrees}° high, lit from {light}")
    };
    interiors.map(words).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lights_are_named_or_counted() {
        for lights in [Lights::First, Lights::All, Lights::Count(8)] {
            assert_eq!(lights.to_string().parse(), Ok(lights));
        }
        for wrong in ["0", "-1", "", "many"] {
            assert!(wrong.parse::<Lights>().is_err(), "{wrong}");
        }
    }

    #[test]
    fn further_lights_are_as_many_as_asked_for_and_apart() {
        let mut frame = Frame::default();
        let scene = umbrage::open("demo:gears?triangles=100").unwrap();
        scene.pose(0.0, &mut frame).unwrap();
        let of = |lights| Shot::new(&frame, "demo:gears", [8, 8], 1, lights).lights;
        let own = of(Lights::All);
        assert_eq!((of(Lights::First), of(Lights::Count(1))), (own[..1].to_vec(), own[..1].to_vec()));
        let many = of(Lights::Count(64));
        assert_eq!((many.len(), &many[..own.len()]), (64, &own[..]));
        assert!((0..64).all(|one| (0..one).all(|other| many[one] != many[other])));
    }
}
