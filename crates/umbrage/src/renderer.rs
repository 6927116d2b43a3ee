use std::mem;
use std::pin::pin;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::{Arc, OnceLock};
use std::task::{Context, Poll, Waker};

use umbrage_rays::{LightMask, SeenPixels, SimdLevel, View, Work};
use umbrage_scene::{Frame, Scene};

use crate::cpu::{Cpu, last_alone};
use crate::engine::{Engine, Last, Output};
use crate::frame::Subject;
use crate::output::{Picture, PictureForm};
use crate::{Error, Film, Settings, Stats};

/// Renders frames, one after the other, in the same memory.
#[derive(Debug)]
pub struct Renderer {
    pub(crate) engine: Box<dyn Engine>,
    /// Answers without a picture; `None` on a GPU.
    pub(crate) answering: Option<Box<Cpu>>,
    /// The last scene, posed at its moment.
    pub(crate) posed: Frame,
    /// The same scene a moment later, if motion is asked for.
    pub(crate) next: Frame,
    pub(crate) view: Option<View>,
    pub(crate) film: Film,
    /// Hits and light masks of the last sample alone, made on demand if several were traced together.
    pub(crate) last_sample: OnceLock<(SeenPixels, Vec<LightMask>)>,
    pub(crate) stats: Stats,
    pub(crate) progress: Progress,
}

/// The progress of a frame, for another thread that waits for it or wants to stop it.
#[derive(Clone, Debug, Default)]
pub struct Progress(Arc<Shared>);

#[derive(Debug, Default)]
struct Shared {
    part: AtomicU32,
    stops: AtomicBool,
}

impl Progress {
    /// The part of the frame's samples that are done, from 0 to 1.
    #[must_use]
    pub fn part(&self) -> f32 {
        f32::from_bits(self.0.part.load(Ordering::Relaxed))
    }

    /// Ends the frame before its next sample with [`Error::Stopped`], and later ones before their first, until
    /// [`Progress::resume`].
    pub fn stop(&self) {
        self.0.stops.store(true, Ordering::Relaxed);
    }

    /// Lets frames be rendered again.
    pub fn resume(&self) {
        self.0.stops.store(false, Ordering::Relaxed);
    }

    pub(crate) fn set(&self, part: f32) {
        self.0.part.store(part.to_bits(), Ordering::Relaxed);
    }

    /// # Errors
    /// Where it was stopped.
    pub(crate) fn go_on(&self) -> Result<(), Error> {
        if self.0.stops.load(Ordering::Relaxed) { Err(Error::Stopped) } else { Ok(()) }
    }
}

/// On the CPU, with the widest instructions that it has.
impl Default for Renderer {
    fn default() -> Self {
        Self::with_simd_level(SimdLevel::default())
    }
}

impl Renderer {
    /// A renderer whose grids use the instructions of `level` rather than the widest; pictures are the same.
    #[must_use]
    pub fn with_simd_level(level: SimdLevel) -> Self {
        Self::with_engine(Cpu::with_level(level), Some(Cpu::with_level(level).into()))
    }

    /// A renderer that works on a GPU. Triangles and shadows are the CPU's; colours differ by rounding.
    ///
    /// Where [`Settings::structure`] has a [counterpart](crate::GpuStructure) on a GPU, that finds triangles and shadows;
    /// with any other, the GPU uses its grids.
    ///
    /// # Errors
    /// Where the device has no memory for fixed tables.
    #[cfg(feature = "gpu")]
    pub fn with_gpu(gpu: umbrage_gpu::Gpu) -> Result<Self, Error> {
        Ok(Self::with_engine(crate::gpu::GpuEngine::new(gpu)?, None))
    }

    fn with_engine(engine: impl Engine + 'static, answering: Option<Box<Cpu>>) -> Self {
        Self {
            engine: Box::new(engine),
            answering,
            posed: Frame::default(),
            next: Frame::default(),
            view: None,
            film: Film::default(),
            last_sample: OnceLock::new(),
            stats: Stats::default(),
            progress: Progress::default(),
        }
    }

    /// Renders `scene` at a moment, on the threads of the current rayon pool.
    ///
    /// # Errors
    /// Where the scene can't be posed, the image is too large, or a setting makes no sense.
    pub fn render(&mut self, scene: &Scene, seconds: f64, settings: &Settings) -> Result<&Film, Error> {
        at_once(self.render_subject(Subject::Moment(scene, seconds), settings, Output::Film))?;
        Ok(&self.film)
    }

    /// As [`Renderer::render`], for a browser, where waiting for a GPU needs the page's event loop. Elsewhere the thread
    /// that awaits it blocks.
    ///
    /// # Errors
    /// As [`Renderer::render`].
    pub async fn render_async(&mut self, scene: &Scene, seconds: f64, settings: &Settings) -> Result<&Film, Error> {
        self.render_subject(Subject::Moment(scene, seconds), settings, Output::Film).await?;
        Ok(&self.film)
    }

    /// Renders `scene` at a moment to a picture of `form`, in the memory of an earlier picture.
    ///
    /// It is that of [`Renderer::render`], developed. Where the picture is opaque and has eight bits a channel, and nothing
    /// but the colours of one sample is wanted ([`Settings::samples`], [`Settings::first_hits`], [`Settings::layers`]), the
    /// CPU develops each part when it has shaded it: that is faster and takes no memory for a film, so [`Renderer::film`]
    /// is empty afterwards. Otherwise [`PictureForm::develop`] has the film. A stage `develop` is in [`Stats`] where
    /// developing isn't a part of `shade`.
    ///
    /// # Errors
    /// As [`Renderer::render`].
    pub fn render_picture(
        &mut self,
        scene: &Scene,
        seconds: f64,
        settings: &Settings,
        (form, picture): (PictureForm, &mut Picture),
    ) -> Result<(), Error> {
        let subject = Subject::Moment(scene, seconds);
        let is_plain = settings.samples == 1 && !settings.first_hits && settings.layers.is_empty();
        if is_plain
            && self.engine.rows().is_some()
            && let Some(rows) = form.rows(settings, picture)
        {
            at_once(self.render_subject(subject, settings, Output::Rows))?;
            // The next frame gets the memory of the picture's earlier rows.
            if let Some(made) = self.engine.rows() {
                mem::swap(made, rows);
            }
            return Ok(());
        }
        at_once(self.render_subject(subject, settings, Output::Film))?;
        let Self { film, stats, .. } = self;
        stats.time("develop", || form.develop(film, settings, picture));
        Ok(())
    }

    /// As [`Renderer::render`], on a GPU alone and to a texture of its device, without a copy through the CPU: RGBA8 as
    /// [`Film::develop_for_screen`] gives it, in the format `Rgba8Unorm` although its values are sRGB-encoded.
    ///
    /// The texture is complete for commands that are submitted to the device's queue from now on. It stays as it is while
    /// the next frame is rendered, and is overwritten by the one after that.
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
        at_once(self.render_subject(Subject::Moment(scene, seconds), settings, Output::Texture))?;
        self.engine.last().texture.ok_or(Error::TextureOnCpu)
    }

    /// Renders triangles of your own, on the threads of the current rayon pool. They are borrowed during the call, and
    /// nothing of them is copied on the CPU.
    ///
    /// Where the next frame has the same [`Frame::mesh`] and [`Frame::materials`] (the same `Arc`s), only the moving parts
    /// are uploaded to a GPU. Triangles with a corner that isn't finite are left out, and counted in [`Stats::omitted`].
    /// Without lights, in the frame or in the settings, only its surroundings light the scene.
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
    /// frame.lights = vec![Light::new(LightSource::Point { position: Vec3::new(1.0, 3.0, 2.0) }, 30.0)];
    ///
    /// let camera = Camera::look_at(Vec3::new(0.0, 2.0, 4.0), Vec3::ZERO, Vec3::Y, 0.8);
    /// let settings = Settings { width: 64, height: 48, camera: camera.into(), ..Settings::default() };
    /// let mut renderer = Renderer::default();
    /// for step in 0..3 {
    ///     frame.positions[6].x = 0.1 * step as f32;
    ///     let film = renderer.render_frame(&frame, &settings)?;
    ///     assert!(film.triangle.contains(&2));
    /// }
    /// # Ok::<(), umbrage::Error>(())
    /// ```
    ///
    /// # Errors
    /// Where [`Frame::check`] rejects the frame, the image is too large, or a setting makes no sense. A rejected frame
    /// leaves the last one as it was.
    pub fn render_frame(&mut self, frame: &Frame, settings: &Settings) -> Result<&Film, Error> {
        at_once(self.render_subject(Subject::Frame(frame), settings, Output::Film))?;
        Ok(&self.film)
    }

    /// As [`Renderer::render_frame`], for a browser: see [`Renderer::render_async`].
    ///
    /// # Errors
    /// As [`Renderer::render_frame`].
    pub async fn render_frame_async(&mut self, frame: &Frame, settings: &Settings) -> Result<&Film, Error> {
        self.render_subject(Subject::Frame(frame), settings, Output::Film).await?;
        Ok(&self.film)
    }

    /// The last frame's film; empty before the first, and after a frame that went to a texture.
    #[must_use]
    pub fn film(&self) -> &Film {
        &self.film
    }

    /// Takes the last frame's film and leaves another, whose memory the next frame uses: so one thread can write a picture
    /// while another one renders.
    pub fn swap_film(&mut self, film: &mut Film) {
        mem::swap(&mut self.film, film);
    }

    /// Times and counts of the last frame.
    #[must_use]
    pub fn stats(&self) -> &Stats {
        &self.stats
    }

    /// The progress of the frame that is being rendered.
    #[must_use]
    pub fn progress(&self) -> Progress {
        self.progress.clone()
    }

    /// Makes later frames report their progress to `progress`, and stop where it asks for that.
    pub fn report_to(&mut self, progress: Progress) {
        self.progress = progress;
    }

    /// The work of the camera's grid for the last group of samples of the last frame; zero without a grid.
    #[must_use]
    pub fn camera_work(&self) -> Work {
        self.engine.last().camera_work
    }

    /// The work of each light's grid for the last group of samples of the last frame; empty without a grid.
    #[must_use]
    pub fn light_work(&self) -> &[Work] {
        self.engine.last().light_work
    }

    /// Each pixel's triangle at the last frame's last sample.
    #[must_use]
    pub fn seen(&self) -> &SeenPixels {
        self.last_sample().map_or(self.engine.last().seen, |(seen, _)| seen)
    }

    /// For each light of the last frame, the pixels that it reached at the last sample.
    #[must_use]
    pub fn light_masks(&self) -> &[LightMask] {
        self.last_sample().map_or(self.engine.last().light_masks, |(_, masks)| masks)
    }

    /// Hits and masks of the last sample, if it wasn't traced alone.
    fn last_sample(&self) -> Option<&(SeenPixels, Vec<LightMask>)> {
        let Last { samples, seen, light_masks, .. } = self.engine.last();
        (samples.side() > 1).then(|| self.last_sample.get_or_init(|| last_alone(&samples, seen, light_masks)))
    }

    /// The view of the last frame; `None` before the first.
    #[must_use]
    pub fn view(&self) -> Option<View> {
        self.view
    }

    /// The lights, cameras and materials of the scene at the moment that was rendered last. Where only a GPU has its
    /// vertices, they are missing: see [`Renderer::frame`].
    #[must_use]
    pub fn scenery(&self) -> &Frame {
        &self.posed
    }

    /// The scene at the moment that was rendered last, or with an open shutter at the last sample's, lit as the settings
    /// say. It is empty after [`Renderer::render_frame`], whose frame you have. Vertices that only a GPU has are posed for
    /// this.
    #[must_use]
    pub fn frame(&self) -> &Frame {
        self.engine.whole_frame(&self.posed)
    }
}

/// The result of a frame that needs no awaiting: everywhere but with a GPU in a browser, since elsewhere engines block their
/// threads.
pub(crate) fn at_once(frame: impl Future<Output = Result<(), Error>>) -> Result<(), Error> {
    match pin!(frame).poll(&mut Context::from_waker(Waker::noop())) {
        Poll::Ready(result) => result,
        Poll::Pending => Err(Error::WaitsInBrowser),
    }
}
