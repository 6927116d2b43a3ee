//! Which frames are traced: scenes, cameras and lights.

use std::path::{Path, PathBuf};

use clap::ValueEnum;
use glam::{DVec2, Vec3};
use umbrage::rays::{Bounds, Camera, LightSource, Opacity, Opaque, View};
use umbrage::scene::Frame;
use umbrage::{Sample, Scene};

/// Scenes of the gallery nearly all of whose triangles move or change, or that the camera moves through.
pub(crate) const GALLERY: [&str; 7] =
    ["demo:cloth", "demo:forest", "demo:hall", "demo:shatter", "demo:statue", "demo:marbles", "demo:gears"];

/// Files that are looked for in a folder of real scenes; those that aren't there are left out.
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

/// Where an interior is seen and lit from; their files say nothing of it, or show them from outside.
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

/// Which of a frame's lights cast shadows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Lights {
    /// The frame's first one
    First,
    /// All of them, one after the other
    All,
}

/// One frame as everyone is given it.
#[derive(Debug)]
pub(crate) struct Shot<'a> {
    pub(crate) frame: &'a Frame,
    pub(crate) view: View,
    /// Where in each pixel the rays of each sample go through.
    pub(crate) offsets_pixels: Vec<DVec2>,
    pub(crate) lights: Vec<LightSource>,
    /// Of all triangles.
    pub(crate) bounds: Bounds,
    /// Whether alpha masks and opacity decide what stops rays; else all triangles do.
    pub(crate) masks: bool,
}

impl<'a> Shot<'a> {
    /// `frame` of the scene at `address`, with opaque triangles. Interiors have an eye and a light of ours; other scenes show
    /// what they say themselves.
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
        Self {
            frame,
            view: View { camera, width, height },
            offsets_pixels: Sample::all(samples).map(|sample| sample.offset_pixels).collect(),
            lights: sources,
            bounds: frame.triangles().bounds(),
            masks: false,
        }
    }
}

impl Shot<'_> {
    /// What stops camera rays, and what stops shadow rays.
    pub(crate) fn opacities(&self) -> [Box<dyn Opacity + '_>; 2] {
        if self.masks {
            [Box::new(self.frame.camera_opacity()), Box::new(self.frame.shadow_opacity())]
        } else {
            [Box::new(Opaque), Box::new(Opaque)]
        }
    }

    /// One sample of each pixel.
    pub(crate) fn question<'a>(
        &'a self,
        [opacity, shadow_opacity]: &'a [Box<dyn Opacity + '_>; 2],
        offset_pixels: DVec2,
    ) -> umbrage::rays::Shot<'a> {
        let question = umbrage::rays::Shot::new(self.frame.triangles(), self.view);
        umbrage::rays::Shot { offset_pixels, opacity: &**opacity, shadow_opacity: &**shadow_opacity, ..question }
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

/// The same without what all of a kind share, for charts.
pub(crate) fn short_name(address: &str) -> &str {
    let name = name(address);
    let name = name.strip_prefix("demo:").unwrap_or(name);
    name.rsplit_once('.').map_or(name, |(stem, _)| stem)
}

/// Addresses of the scenes that take part: those that were named, or else the gallery's and those of a folder of files.
pub(crate) fn addresses(named: &[String], folder: Option<&PathBuf>) -> Vec<String> {
    if !named.is_empty() {
        return named.to_vec();
    }
    let path = |folder: &Path, name: &str| folder.join(name).to_string_lossy().into_owned();
    let files = folder.into_iter().flat_map(|folder| FILES.map(|name| path(folder, name)));
    GALLERY.map(str::to_owned).into_iter().chain(files.filter(|path| Path::new(path).exists())).collect()
}

/// Moments in seconds of `scene` at which as many `frames` are traced, and whether each counts: the first takes memory that
/// later ones use again.
pub(crate) fn moments(scene: &Scene, frames: u32) -> impl Iterator<Item = (f64, bool)> + use<> {
    let duration = scene.duration_seconds();
    (0..=frames).map(move |number| (duration * f64::from(number) / f64::from(frames + 1), number > 0))
}

/// Which interiors of `addresses` are seen from where, in words; empty for none.
pub(crate) fn viewpoints(addresses: &[String]) -> Vec<String> {
    let interiors = addresses.iter().filter_map(|address| interior(address));
    let words = |Interior { file, eye, target, fov_degrees, light }: &Interior| {
        format!("{file}: from {eye} to {target}, {fov_degrees}° high, lit from {light}")
    };
    interiors.map(words).collect()
}
