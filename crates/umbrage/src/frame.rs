//! The spine: a frame from top to bottom.

use umbrage_rays::{LightCells, LightMask, PixelWork, SeenPixels, SimdLevel, View, Work};
use umbrage_scene::{BadFrame, Frame, Scene};

use crate::background::Surroundings;
use crate::cpu::Cpu;
use crate::engine::{Engine, Output};
use crate::sampling::Sample;
use crate::{Film, Settings, Stats};

/// Renders frames, one after the other, in the same memory.
#[derive(Debug, Default)]
pub struct Renderer {
    engine: Engine,
    frame: Frame,
    view: Option<View>,
    film: Film,
    stats: Stats,
}

/// Why a frame could not be rendered.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The scene could not be posed.
    #[error(transparent)]
    Scene(#[from] umbrage_scene::Error),
    /// A frame that was made by hand is not what a frame has to be.
    #[error(transparent)]
    Frame(#[from] BadFrame),
    /// The image has more pixels on a side than the structure can sort.
    #[error(transparent)]
    ImageTooLarge(#[from] umbrage_rays::ImageTooLarge),
    /// The GPU can't do what is asked of it.
    #[cfg(feature = "gpu")]
    #[error(transparent)]
    Gpu(#[from] umbrage_gpu::GpuError),
    /// A light was asked for that isn't there.
    #[error("there is no light {light}: the scene has {lights}, counted from 0")]
    NoSuchLight {
        /// The one that was asked for.
        light: usize,
        /// How many there are.
        lights: usize,
    },
    /// A setting makes no sense.
    #[error("{0}")]
    Settings(String),
    /// A background image could not be read.
    #[error("{}: {cause}", path.display())]
    Background {
        /// The file.
        path: std::path::PathBuf,
        /// What is wrong with it.
        cause: String,
    },
}

impl Renderer {
    /// A renderer whose grids use the instructions of `level` rather than the widest; pictures are the same.
    #[must_use]
    pub fn with_simd_level(level: SimdLevel) -> Self {
        Self { engine: Engine::Cpu(Box::new(Cpu::with_level(level))), ..Self::default() }
    }

    /// A renderer that works on a GPU. Triangles and shadows are the CPU's; colours differ by rounding.
    ///
    /// [`Settings::structure`] doesn't matter to it: a GPU has the perspective grid.
    ///
    /// # Errors
    /// Where the device has no memory for fixed tables.
    #[cfg(feature = "gpu")]
    pub fn with_gpu(gpu: umbrage_gpu::Gpu) -> Result<Self, Error> {
        let engine = crate::gpu::GpuEngine::new(gpu, umbrage_gpu::CameraOptions::default())?;
        Ok(Self { engine: Engine::Gpu(Box::new(engine)), ..Self::default() })
    }

    /// Renders `scene` at a moment, on the threads of the current rayon pool.
    ///
    /// # Errors
    /// Where the scene can't be posed, the image is too large, or a setting makes no sense.
    pub fn render(&mut self, scene: &Scene, seconds: f64, settings: &Settings) -> Result<&Film, Error> {
        self.animate(scene, seconds, settings)?;
        self.render_animated(settings, Output::Film)?;
        Ok(&self.film)
    }

    /// As [`Renderer::render`], on a GPU alone and to a texture of its device, without a copy through the CPU: RGBA8 as
    /// [`Film::develop_for_screen`] gives it, in the format `Rgba8Unorm` although its values are sRGB-encoded.
    ///
    /// The texture is done once what is submitted to the device's queue from now on runs. It stays as it is while the next
    /// frame is rendered, and is drawn over by the one after that.
    ///
    /// No pixel is fetched: [`Renderer::film`], [`Renderer::seen`] and [`Renderer::light_masks`] are empty afterwards.
    /// [`Stats`] are those of [`Renderer::render`], with the stages `shown` and `develop` in place of `fetch`.
    ///
    /// # Errors
    /// As [`Renderer::render`], and on the CPU; where the image is larger than the device's textures.
    #[cfg(feature = "gpu")]
    pub fn render_to_texture(
        &mut self,
        scene: &Scene,
        seconds: f64,
        settings: &Settings,
    ) -> Result<umbrage_gpu::wgpu::Texture, Error> {
        if let Engine::Cpu(_) = self.engine {
            return self.engine.texture();
        }
        self.animate(scene, seconds, settings)?;
        self.render_animated(settings, Output::Texture)?;
        self.engine.texture()
    }

    /// Renders triangles of your own, on the threads of the current rayon pool; [`Renderer::frame`] has them afterwards.
    ///
    /// Where the next frame has the same [`Frame::mesh`] and [`Frame::materials`] (the same `Arc`s), a GPU takes over only
    /// what moves. Triangles with a corner that isn't finite are left out, and counted in [`Stats::omitted`]. Without
    /// lights, in the frame or in the settings, only what is around the scene lights it.
    ///
    /// ```
    /// use umbrage::rays::{Camera, LightSource};
    /// use umbrage::scene::{Frame, Light};
    /// use umbrage::{Renderer, Settings};
    /// use glam::Vec3;
    ///
    /// // A triangle that stands on a floor of two.
    /// let positions = [[-2., 0., -2.], [2., 0., -2.], [2., 0., 2.], [-2., 0., 2.], [-1., 0., 0.], [1., 0., 0.], [0., 1., 0.]];
    /// let mut frame =
    ///     Frame::from_triangles(positions.map(Vec3::from).to_vec(), vec![[0, 2, 1], [0, 3, 2], [4, 5, 6]]);
    /// frame.lights = vec![Light {
    ///     name: "lamp".into(),
    ///     source: LightSource::Point { position: Vec3::new(1.0, 3.0, 2.0) },
    ///     color: Vec3::ONE,
    ///     intensity: 30.0,
    ///     range: None,
    ///     casts_shadow: true,
    /// }];
    ///
    /// let camera = Camera::look_at(Vec3::new(0.0, 2.0, 4.0), Vec3::ZERO, Vec3::Y, 0.8);
    /// let settings = Settings { width: 64, height: 48, camera: Some(camera), ..Settings::default() };
    /// let mut renderer = Renderer::default();
    /// for step in 0..3 {
    ///     frame.positions[6].x = 0.1 * step as f32;
    ///     let film = renderer.render_frame(frame.clone(), &settings)?;
    ///     assert!(film.triangle.contains(&2));
    /// }
    /// # Ok::<(), umbrage::Error>(())
    /// ```
    ///
    /// # Errors
    /// Where the frame is not what [`Frame::check`] asks for, the image is too large, or a setting makes no sense. A frame
    /// that is refused leaves the last one as it was.
    pub fn render_frame(&mut self, mut frame: Frame, settings: &Settings) -> Result<&Film, Error> {
        settings.check()?;
        if let Some(lights) = &settings.lights {
            frame.lights.clone_from(lights);
        }
        frame.check()?;
        self.stats.start();
        self.engine.adopt();
        self.frame = frame;
        self.render_animated(settings, Output::Film)?;
        Ok(&self.film)
    }

    /// Brings the frame to a moment.
    fn animate(&mut self, scene: &Scene, seconds: f64, settings: &Settings) -> Result<(), Error> {
        settings.check()?;
        let Self { engine, frame, stats, .. } = self;
        stats.start();

        stats.time("animate", || engine.animate(scene, seconds, settings, frame))?;
        if let Some(lights) = &settings.lights {
            frame.lights.clone_from(lights);
        }
        Ok(())
    }

    /// From the frame as it is to the film, or to a texture.
    fn render_animated(&mut self, settings: &Settings, output: Output) -> Result<(), Error> {
        let Self { engine, frame, view: shown, film, stats } = self;
        let view = settings.view(frame);
        *shown = Some(view);
        let surroundings = Surroundings::new(&settings.background);

        film.clear(output.fetched(&view));
        stats.time("build", || engine.build(frame, &view, settings, &surroundings, output))?;
        for band in engine.bands(&view) {
            for sample in Sample::all(settings.samples) {
                // See, shadow, shade.
                engine.sample(frame, &band, &sample, &surroundings, film, stats)?;
            }
            engine.finish(&band, settings, output, film, stats)?;
        }
        film.average(settings.samples);

        stats.count(frame, &view, film, engine, settings.samples)
    }

    /// Counts, pixel by pixel, the work of seeing `scene` at a moment through the middle of each pixel, and lights
    /// nothing. Only that of [specialised](crate::Structure::is_specialised) structures is counted.
    ///
    /// # Errors
    /// Where the scene can't be posed, the image is too large, or a setting makes no sense.
    pub fn count_work(
        &mut self,
        scene: &Scene,
        seconds: f64,
        settings: &Settings,
        work: &mut PixelWork,
    ) -> Result<(), Error> {
        settings.check()?;
        if !settings.structure.is_specialised() {
            return Err(Error::Settings("the work of pixels is counted in perspective grids alone".to_owned()));
        }
        let Self { engine, frame, .. } = self;
        engine.animate(scene, seconds, settings, frame)?;
        let view = settings.view(frame);
        engine.build(frame, &view, settings, &Surroundings::new(&settings.background), Output::Film)?;
        for sample in Sample::all(1) {
            engine.see_counting(frame, &view, &sample, work)?;
        }
        Ok(())
    }

    /// Finds in which cell of a light's grid the point is that `scene` shows at a moment through the middle of each pixel,
    /// and lights nothing. `light` counts from 0 among the lights of the settings, else of the scene. Only
    /// [specialised](crate::Structure::is_specialised) structures have cells.
    ///
    /// # Errors
    /// Where there is no such light, the scene can't be posed, the image is too large, or a setting makes no sense.
    pub fn locate_points(
        &mut self,
        scene: &Scene,
        seconds: f64,
        settings: &Settings,
        light: usize,
        cells: &mut LightCells,
    ) -> Result<(), Error> {
        settings.check()?;
        if !settings.structure.is_specialised() {
            return Err(Error::Settings("only light grids have such cells".to_owned()));
        }
        let Self { engine, frame, .. } = self;
        engine.animate(scene, seconds, settings, frame)?;
        if let Some(lights) = &settings.lights {
            frame.lights.clone_from(lights);
        }
        let Some(source) = frame.lights.get(light).map(|light| light.source) else {
            return Err(Error::NoSuchLight { light, lights: frame.lights.len() });
        };
        let view = settings.view(frame);
        engine.build(frame, &view, settings, &Surroundings::new(&settings.background), Output::Film)?;
        for sample in Sample::all(1) {
            engine.locate(frame, &view, &sample, &source, cells)?;
        }
        Ok(())
    }

    /// The last frame's film; empty before the first, and where that went to a texture.
    #[must_use]
    pub fn film(&self) -> &Film {
        &self.film
    }

    /// What the last frame cost.
    #[must_use]
    pub fn stats(&self) -> &Stats {
        &self.stats
    }

    /// What the camera was as work for its grid, at the last frame's last sample; zero without a grid.
    #[must_use]
    pub fn camera_work(&self) -> Work {
        self.engine.camera_work()
    }

    /// What each light that casts shadows was as work for its grid, at the last frame's last sample; empty without a grid.
    #[must_use]
    pub fn light_work(&self) -> &[Work] {
        self.engine.light_work()
    }

    /// What each pixel showed at the last frame's last sample.
    #[must_use]
    pub fn seen(&self) -> &SeenPixels {
        self.engine.seen()
    }

    /// For each light of the last frame, which pixels it reached at the last sample.
    #[must_use]
    pub fn light_masks(&self) -> &[LightMask] {
        self.engine.light_masks()
    }

    /// From where the last frame was seen; `None` before the first.
    #[must_use]
    pub fn view(&self) -> Option<View> {
        self.view
    }

    /// The last frame's lights, cameras and materials. Where only a GPU has its vertices, they are missing: see
    /// [`Renderer::frame`].
    #[must_use]
    pub fn scenery(&self) -> &Frame {
        &self.frame
    }

    /// The scene as the last frame showed it. Vertices that only a GPU has are posed for this.
    #[must_use]
    pub fn frame(&self) -> &Frame {
        self.engine.whole_frame(&self.frame)
    }
}
