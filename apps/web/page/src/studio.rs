use std::mem;

use glam::Vec3;
use umbrage::rays::{Bounds, LightSource, Projection};
use umbrage::scene::{Light, OpenOptions};
use umbrage::spec::LightSpec;
use umbrage::{CameraChoice, HeatKind, HeatScale, Renderer, Scene, Settings, Stage, WorkCounts, gallery};
use web_time::Instant;

use crate::tracers::{Tracers, settings};
use crate::{Look, LookAt, Opened, Proof, Shown, ShownLight};

const NO_SCENE: &str = "there is no scene yet";

/// A scene, its renderers, and the last picture.
#[derive(Debug, Default)]
pub struct Studio {
    scene: Option<Scene>,
    /// The exposure of looks that have none of their own; `None` until it is measured.
    exposure_stops: Option<f32>,
    tracers: Tracers,
    /// Counts work for heat maps.
    counter: Renderer,
    counts: WorkCounts,
    picture: Vec<[u8; 4]>,
}

impl Studio {
    /// Opens a scene of the gallery.
    ///
    /// # Errors
    /// The reason why there is no such scene, in words; the last one stays.
    pub fn open_demo(&mut self, address: &str) -> Result<Opened, String> {
        self.show(gallery::open(address).map_err(|error| error.to_string())?, Some(0.0))
    }

    /// Opens the scene `name`, one of `files`, each a path and its content.
    ///
    /// # Errors
    /// The reason why it can't be read, in words; the last scene stays.
    pub fn open_files(
        &mut self,
        name: &str,
        files: impl IntoIterator<Item = (String, Vec<u8>)>,
    ) -> Result<Opened, String> {
        let scene =
            umbrage::open_files(name, files, &OpenOptions::for_pictures()).map_err(|error| error.to_string())?;
        self.show(scene, None)
    }

    fn show(&mut self, scene: Scene, exposure_stops: Option<f32>) -> Result<Opened, String> {
        let opened = Opened {
            duration_seconds: scene.duration_seconds(),
            still_seconds: scene.still_seconds(),
            warnings: scene.warnings().to_vec(),
        };
        let mut tracers = mem::take(&mut self.tracers);
        tracers.forget_scene();
        *self = Self { scene: Some(scene), exposure_stops, tracers, ..Self::default() };
        Ok(opened)
    }

    /// Sets the renderer of looks that ask for a GPU.
    pub fn use_gpu(&mut self, renderer: Renderer) {
        self.tracers.use_gpu(renderer);
    }

    /// Renders a moment of the scene.
    ///
    /// # Errors
    /// The reason why it can't be rendered, in words.
    pub async fn render(&mut self, look: &Look) -> Result<Shown, String> {
        let heat: Option<HeatKind> =
            look.heat.as_deref().map(str::parse).transpose().map_err(|error| format!("{error}"))?;
        let Self { scene, exposure_stops, tracers, counter, counts, picture } = self;
        let scene = scene.as_ref().ok_or(NO_SCENE)?;
        let stops = match look.exposure_stops.or(*exposure_stops) {
            Some(stops) => stops,
            None => *exposure_stops.insert(tracers.metered_stops(scene, look).await?),
        };
        let mut stages = tracers.render(scene, look).await?;
        let mut settings = Settings { exposure_stops: stops, ..settings(look)? };
        let (renderer, film) = (tracers.last(), tracers.last().film());
        let start = Instant::now();
        film.develop_for_screen(&settings, picture);
        stages.push(Stage { name: "develop", milliseconds: start.elapsed().as_secs_f64() * 1e3 });

        let frame = tracers.frame();
        let camera = renderer.view().ok_or("nothing was rendered")?.camera;
        let heat = match heat {
            Some(kind) => {
                settings.camera = CameraChoice::Own(camera);
                let light = (kind == HeatKind::Points && !frame.lights.is_empty()).then_some(0);
                let counted = counter.count_work(frame, &settings, light, counts);
                counted.map_err(|error| error.to_string())?;
                Some((kind.title(), paint(kind, light.is_some(), counts, look, picture)))
            }
            None => None,
        };
        let bounds = frame.animation_bounds;
        let middle = film.depth[(look.height / 2 * look.width + look.width / 2) as usize];
        let away = if middle.is_finite() { middle } else { (bounds.center() - camera.position).dot(camera.forward) };
        let fov_degrees = match camera.projection {
            Projection::Perspective { tan_half_height } => (2.0 * tan_half_height.atan()).to_degrees(),
            Projection::Orthographic { .. } => umbrage::spec::LookAt::DEFAULT_FOV_DEGREES,
        };
        let away = if away > 0.0 && away.is_finite() { away } else { 1.0 };
        let position = camera.position.to_array();
        Ok(Shown {
            stages,
            triangles: frame.triangles().len() - frame.mesh.ground_triangles,
            camera: LookAt { position, target: (camera.position + camera.forward * away).to_array(), fov_degrees },
            is_widened: tracers.is_widened(),
            lights: frame.lights.iter().map(|light| shown(light, bounds, look.samples)).collect(),
            exposure_stops: stops,
            bounds: [bounds.min, bounds.max].map(|corner| corner.to_array()),
            heat,
        })
    }

    /// Number of pixels in which the CPU's triangle or light masks differ from the GPU's, which rendered the last picture
    /// by the same `look`.
    ///
    /// # Errors
    /// As [`Studio::render`].
    pub async fn differing(&mut self, look: &Look) -> Result<u32, String> {
        self.tracers.differing(self.scene.as_ref().ok_or(NO_SCENE)?, look).await
    }

    /// The last picture, four bytes a pixel: opaque RGBA, in rows from the upper left corner.
    #[must_use]
    pub fn pixels(&self) -> &[u8] {
        self.picture.as_flattened()
    }

    /// The triangle at each pixel of the last picture; [`Film::NO_TRIANGLE`](umbrage::Film::NO_TRIANGLE) for a miss.
    #[must_use]
    pub fn hits(&self) -> &[u32] {
        &self.tracers.last().film().triangle
    }

    /// The corners of the triangles of the moment that was rendered last.
    #[must_use]
    pub fn triangles(&self) -> Vec<f32> {
        let triangles = self.tracers.frame().triangles();
        (0..triangles.len() as u32).flat_map(|id| triangles.corners(id)).flat_map(|corner| corner.to_array()).collect()
    }

    /// Hashes of the last picture's data.
    #[must_use]
    pub fn proof(&self) -> Proof {
        let renderer = self.tracers.last();
        Proof::new(renderer.film(), renderer.light_masks(), self.pixels())
    }
}

/// The scenes that need no file, as JSON.
pub(crate) fn gallery() -> String {
    let scenes = gallery::DEMOS.iter().map(|demo| {
        let gallery::DemoScene { name, about, triangles, .. } = demo;
        serde_json::json!({ "name": name, "about": about, "triangles": triangles })
    });
    serde_json::Value::from_iter(scenes).to_string()
}

/// Colours each pixel by its count, and returns the count of the last colour.
fn paint(kind: HeatKind, of_light: bool, counts: &WorkCounts, look: &Look, picture: &mut [[u8; 4]]) -> u32 {
    let pixels = (0..look.height).flat_map(|y| (0..look.width).map(move |x| (x, y)));
    let count = |(x, y)| match kind {
        HeatKind::Points if of_light => counts.cells.points_at(x, y),
        kind => kind.of(counts.pixels.at(x, y)).unwrap_or_default(),
    };
    let counts: Vec<u32> = pixels.map(count).collect();
    let scale = HeatScale::of(&counts);
    for (pixel, count) in picture.iter_mut().zip(counts) {
        let [red, green, blue] = scale.color(count);
        *pixel = [red, green, blue, u8::MAX];
    }
    scale.top()
}

fn shown(light: &Light, bounds: Bounds, samples: u32) -> ShownLight {
    // With one sample, everything is sharp.
    let shape = if samples > 1 { light.shape } else { light.shape.narrowed() };
    ShownLight {
        name: light.name.to_string(),
        position: light_position(&light.source, bounds).to_array(),
        spec: LightSpec::try_from(&Light { shape, ..light.clone() }).ok().map(|spec| spec.to_string()),
    }
}

/// Position of a light; a sun is one scene size from the middle of the scene.
fn light_position(source: &LightSource, bounds: Bounds) -> Vec3 {
    match *source {
        LightSource::Point { position } | LightSource::Spot { position, .. } => position,
        LightSource::Directional { direction } => bounds.center() - direction * bounds.size().length(),
    }
}
