use glam::Vec3;
use serde::{Deserialize, Serialize};
use umbrage::spec;

/// The options of a picture of a scene.
#[derive(Clone, Debug, Deserialize)]
#[serde(rename_all = "camelCase", deny_unknown_fields, default)]
pub struct Look {
    /// Width of the picture in pixels.
    pub width: u32,
    /// Height of the picture in pixels.
    pub height: u32,
    /// The moment.
    pub seconds: f64,
    /// Camera rays for each pixel.
    pub samples: u32,
    /// Maximum number of mirrors and glass surfaces along a path of light.
    pub bounces: u32,
    /// The camera; `None` for the scene's own, or one that sees all of it.
    pub camera: Option<LookAt>,
    /// New positions of lights, in world space, by their numbers; lights with `None` or beyond the list stay. Moved spots
    /// and suns face the middle of the scene.
    pub lights: Vec<Option<[f32; 3]>>,
    /// The background, which lights the scene from all around: `sky`, or a colour as the command takes it.
    pub background: String,
    /// Exposure in photographic stops; `None` measures it for files, and is zero for scenes of the gallery.
    pub exposure_stops: Option<f32>,
    /// The engine that renders it.
    pub engine: Engine,
    /// The name of a [heat map](umbrage::HeatKind), in place of the picture.
    pub heat: Option<String>,
}

impl Default for Look {
    fn default() -> Self {
        let (samples, bounces) = (1, 0);
        Self {
            width: 640,
            height: 360,
            seconds: 0.0,
            samples,
            bounces,
            camera: None,
            lights: Vec::new(),
            background: "sky".to_owned(),
            exposure_stops: None,
            engine: Engine::Cpu,
            heat: None,
        }
    }
}

/// The engine that renders a picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Engine {
    /// The processor, on one thread.
    #[default]
    Cpu,
    /// The GPU that [`Studio::use_gpu`](crate::Studio::use_gpu) was given.
    Gpu,
}

/// A perspective camera, the world's Y axis upwards.
#[derive(Clone, Copy, Debug, Deserialize, Serialize)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct LookAt {
    /// Its position.
    pub position: [f32; 3],
    /// The point in the middle of its picture.
    pub target: [f32; 3],
    /// Its vertical field of view.
    pub fov_degrees: f32,
}

impl From<LookAt> for spec::LookAt {
    fn from(LookAt { position, target, fov_degrees }: LookAt) -> Self {
        Self { position: Vec3::from(position), target: Vec3::from(target), fov_degrees }
    }
}

/// A scene that was opened.
#[derive(Clone, Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct Opened {
    /// Duration of its animation, after which it repeats; zero for a motionless scene.
    pub duration_seconds: f64,
    /// The moment of a still picture, in seconds.
    pub still_seconds: f64,
    /// Messages about content that was left out or guessed.
    pub warnings: Vec<String>,
}

/// Data about a rendered picture.
#[derive(Clone, Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct Shown {
    /// The time of each stage, in the order in which they ran.
    pub stages: Vec<umbrage::Stage>,
    /// Triangles of the scene.
    pub triangles: usize,
    /// The camera; its target is the surface in the middle of the picture, or a point as far away as the scene.
    pub camera: LookAt,
    /// Whether the scene's own camera was widened for a narrow picture.
    pub is_widened: bool,
    /// The scene's lights.
    pub lights: Vec<ShownLight>,
    /// Brightness in photographic stops.
    pub exposure_stops: f32,
    /// The box around the scene over its whole animation.
    pub bounds: [[f32; 3]; 2],
    /// The quantity of a heat map, and the count that has its last colour.
    pub heat: Option<(&'static str, u32)>,
}

/// A light of a picture.
#[derive(Clone, Debug, Serialize)]
pub struct ShownLight {
    /// Its name in the file; may be empty.
    pub name: String,
    /// Its position; for a sun, a point outside of the scene.
    pub position: [f32; 3],
    /// The value of the command's `--light`; `None` for lights that the flag can't describe.
    pub spec: Option<String>,
}
