//! GPUs to render on: [`Gpu::open`] opens one of [`Adapter::all`] through [`wgpu`], [`Gpu::of_device`] takes one that a
//! window has open, and [`Renderer::with_gpu`](crate::Renderer::with_gpu) renders on it.
//!
//! A frame's stages are compute shaders, through structures that are rebuilt for every frame. Triangles and shadows are
//! those of the CPU.
//!
//! ```
//! use umbrage::gpu::{DeviceLimits, Gpu};
//! use umbrage::{Renderer, Settings};
//!
//! // Where there is none, or none that can do this, an error says so.
//! if let Ok(gpu) = Gpu::open("no such device", DeviceLimits::Adapter) {
//!     let mut renderer = Renderer::with_gpu(gpu)?;
//!     renderer.render(&umbrage::open("demo:cloth")?, 0.0, &Settings::default())?;
//! }
//! # Ok::<(), umbrage::Error>(())
//! ```

mod finder;
mod first_layer;
mod geometry;
mod mirrors;
mod picture;
mod rig;
mod tables;

use std::sync::Arc;
use umbrage_rays::parallel::both;

#[doc(hidden)] // For structures of other crates.
pub use finder::{Finder, Found, MakeFinder, Question};
#[doc(hidden)] // For tests of the stage `pose`.
pub use rig::tables as rig_tables;
pub use umbrage_gpu::{Adapter, DeviceLimits, Gpu, GpuError, wgpu};

use umbrage_gpu::shade::{FilmKeeps, FilmPlanes, Layer, Shade, ShadeInputs, ShadeSample};
use umbrage_gpu::{Band, Buffer, Done, Fetch, Groups, Onward, OnwardLight, Recorder, Sight};
use umbrage_rays::{LightMask, LightSource, SeenPixels};
use umbrage_scene::{Frame, Light, Scene};
use web_time::Instant;

use crate::cpu::{SeenAndLit, material_mirrors};
use crate::engine::{Engine, Outcome, Output, Staged};
use crate::motion::Next;
use crate::sampling::{Sample, Samples};
use crate::{CameraChoice, Error, Film, Settings, Settled, Stats};
use finder::Finders;
use first_layer::FirstLayer;
use geometry::FrameGeometry;
use mirrors::{Mirrored, Mirrors, following, looked_around};
use picture::Picture;
use rig::FrameRig;
use tables::{Tables, sample_rays};

/// The GPU engine: finds each pixel's hit and the lights that reach it, and shades it.
#[derive(Debug)]
pub(crate) struct GpuEngine {
    gpu: Gpu,
    rig: FrameRig,
    geometry: FrameGeometry,
    finders: Finders,
    tables: Tables,
    shade: Shade,
    planes: FilmPlanes,
    /// The first hits of pixels.
    first: FirstLayer,
    picture: Picture,
    /// A layer without hits.
    nothing: Buffer,
    /// The bands of rows in which the frame is rendered.
    bands: Vec<Band>,
    /// Whether surfaces are shaded layer by layer, one behind the other.
    is_see_through: bool,
    /// Tracer of secondary rays, made for the first frame that has any; and the number of this frame's planes for them.
    mirrors: Option<Mirrors>,
    ways: u32,
    light: OnwardLight,
    output: Output,
    /// The first hits of pixels and their light masks, fetched.
    seen: SeenPixels,
    lit: Vec<LightMask>,
    /// Shadow rays of each band.
    shadow_rays: Vec<u64>,
    /// Number of samples of the band under way that are shaded.
    shaded: u32,
    /// Number of lights of the last frame that cast shadows.
    shadowing_lights: u64,
    /// Whether the last frame that was begun was finished.
    is_finished: bool,
    /// The predicate's counts for camera rays and for the shadow rays of first hits.
    settled: [Settled; 2],
    /// Bytes uploaded to the GPU before the last frame.
    uploaded_before: u64,
    /// Results fetched with the band's last sample, until they are in the film.
    fetched: Option<(FilmFetch, Done)>,
}

/// One sample of a band.
struct Turn<'a> {
    staged: &'a Staged<'a>,
    band: &'a Band,
    sample: &'a Sample,
    /// Whether the film is fetched after it.
    is_last: bool,
}

/// A band on its way from the GPU.
#[derive(Clone, Copy, Debug)]
struct FilmFetch {
    first: [Fetch; 2],
    color: Fetch,
    flat: Fetch,
    nearest: Fetch,
    triangle: Fetch,
}

impl FilmFetch {
    fn record(
        recorder: &mut Recorder<'_>,
        planes: &FilmPlanes,
        first: &FirstLayer,
        band: &Band,
        lights: usize,
    ) -> Self {
        Self {
            first: first.fetch(recorder, band, lights),
            color: planes.fetch_color(recorder),
            flat: planes.fetch_flat(recorder),
            nearest: planes.fetch_first(recorder),
            triangle: planes.fetch_triangle(recorder),
        }
    }
}

impl GpuEngine {
    /// Maximum number of see-through surfaces in a row, as on the CPU.
    const MOST_LAYERS: usize = 256;
    /// Maximum number of tries for a layer, each with more room: the size of a list is known once those before it fit.
    const MOST_TRIES: usize = 16;

    /// An engine on an open device.
    ///
    /// # Errors
    /// Where the device has no memory for fixed tables.
    pub(crate) fn new(gpu: Gpu) -> Result<Self, GpuError> {
        // Other engines on the device have uploads, too.
        let gpu = gpu.with_own_counts();
        // Drivers compile kernels for so long that all processors have to take part.
        let (finders, (rig, (shade, picture))) = both(
            || Finders::new(&gpu),
            || both(|| FrameRig::new(&gpu), || both(|| Shade::new(&gpu), || Picture::new(&gpu))),
        );
        Ok(Self {
            rig: rig?,
            geometry: FrameGeometry::new(&gpu),
            finders,
            tables: Tables::default(),
            shade: shade?,
            planes: FilmPlanes::new(&gpu),
            first: FirstLayer::new(&gpu),
            picture: picture?,
            nothing: Buffer::storage(&gpu, "nothing seen"),
            bands: Vec::new(),
            is_see_through: false,
            mirrors: None,
            ways: 0,
            light: OnwardLight::default(),
            output: Output::Film,
            seen: SeenPixels::default(),
            lit: Vec::new(),
            shadow_rays: Vec::new(),
            shaded: 0,
            shadowing_lights: 0,
            is_finished: false,
            settled: [Settled::default(); 2],
            uploaded_before: 0,
            fetched: None,
            gpu,
        })
    }

    /// Renders one layer of surfaces: the nearest ones, or those behind the last. `false` if none was hit behind the
    /// last.
    ///
    /// All stages go to the GPU at once, and nothing is read back between them. Where their lists were too small, the
    /// layer isn't shaded, and all stages run again with more room.
    async fn layer(&mut self, turn: &Turn<'_>, is_first: bool, stats: &mut Stats) -> Result<bool, GpuError> {
        let shades = !self.light.is_asked_first();
        let may_fetch = turn.is_last && shades && !self.is_see_through && self.ways == 0;
        let Self { gpu, rig, geometry, finders, shade, planes, first, lit: masks, .. } = self;
        let (geometry, finder) = (geometry.geometry(), finders.chosen_mut());
        let Turn { staged, band, sample, .. } = *turn;
        let sources = all_sources(staged.lights);
        let (sight, offset_pixels) = (Sight { is_behind: !is_first }, sample.offset_pixels);
        let layer = Layer { is_of_first_sample: sample.index == 0, is_first, is_last: !self.is_see_through };
        shade.prepare(gpu, &following(staged.settings, sample, sample_rays(band, sample)), layer, planes)?;
        for _ in 0..Self::MOST_TRIES {
            let (lights, groups) = (&sources[..], shade.groups());
            finder.prepare(gpu, &Question { geometry, band, offset_pixels, sight, lights, groups })?;
            let mut recorder = Recorder::new(gpu);
            rig.record(gpu, &mut recorder, geometry, shade);
            finder.record(gpu, &mut recorder, geometry);
            if is_first {
                first.record(gpu, &mut recorder, &finder.found())?;
            }
            let (positions, triangles) = (geometry.positions(), geometry.triangles());
            let Found { seen, lit, .. } = finder.found();
            let inputs = ShadeInputs { seen, lit, positions, triangles };
            if shades {
                recorder.stage("shade", |pass| shade.record(gpu, pass, &inputs, planes, finder.groups()));
            }
            if self.is_see_through {
                finder.keep(gpu, &mut recorder)?;
            }
            let fetch = may_fetch.then(|| FilmFetch::record(&mut recorder, planes, first, band, masks.len()));
            let done = recorder.submit().await?;
            rig.finish(&done)?;
            if finder.finish(gpu, &done)? {
                add_times(stats, &done);
                if is_first {
                    finder.count_settled(&mut self.settled);
                }
                self.fetched = fetch.map(|fetch| (fetch, done));
                return Ok(is_first || finder.sees_any());
            }
        }
        Err(GpuError::OutOfMemory(format!("a frame's lists have outgrown their buffers {} times", Self::MOST_TRIES)))
    }

    /// Renders one sample of a band, layer by layer if surfaces are see-through.
    async fn shade_sample(
        &mut self,
        staged: &Staged<'_>,
        band: &Band,
        sample: &Sample,
        stats: &mut Stats,
    ) -> Result<(), GpuError> {
        if sample.index == 0 {
            self.planes.prepare(&self.gpu, band.size(), self.keeps(staged))?;
        }
        let is_last = self.output == Output::Film && sample.index + 1 == staged.settings.samples;
        let turn = Turn { staged, band, sample, is_last };
        self.layer(&turn, true, stats).await?;
        if self.light.is_asked_first() {
            self.shade_asked(&turn, stats).await?;
        }
        if self.ways > 0 {
            return self.follow_mirrors(&turn, stats).await;
        }
        if !self.is_see_through {
            return Ok(());
        }
        for _ in 1..Self::MOST_LAYERS {
            if !self.layer(&turn, false, stats).await? {
                break;
            }
        }
        self.shade_surroundings(band, sample, stats).await
    }

    /// Shades the first hits once their tints and ambient occlusion are known.
    async fn shade_asked(&mut self, turn: &Turn<'_>, stats: &mut Stats) -> Result<(), GpuError> {
        let Self { gpu, geometry, finders, shade, planes, mirrors, .. } = self;
        let Some(mirrors) = mirrors else { return Ok(()) };
        let Turn { staged, band, sample, .. } = *turn;
        let geometry = geometry.geometry();
        let Found { seen, lit, .. } = finders.chosen().found();
        let mirrored = Mirrored { staged, band, sample, geometry, seen };
        mirrors.ask_first(gpu, &mirrored, lit, shade, planes, stats).await?;
        let (lit, tints_word) = mirrors.asked();
        let rays = ShadeSample { tints_word, ..following(staged.settings, sample, sample_rays(band, sample)) };
        shade.prepare(gpu, &rays, Layer::only(sample.index == 0), planes)?;
        let (positions, triangles) = (geometry.positions(), geometry.triangles());
        let inputs = ShadeInputs { seen, lit, positions, triangles };
        let mut recorder = Recorder::new(gpu);
        recorder.stage("shade", |pass| shade.record(gpu, pass, &inputs, planes, Groups::Flat(shade.groups())));
        add_times(stats, &recorder.submit().await?);
        Ok(())
    }

    /// Traces and shades a sample's secondary rays.
    async fn follow_mirrors(&mut self, turn: &Turn<'_>, stats: &mut Stats) -> Result<(), GpuError> {
        let Self { gpu, geometry, finders, shade, planes, mirrors, .. } = self;
        let Some(mirrors) = mirrors else { return Ok(()) };
        let Turn { staged, band, sample, .. } = *turn;
        let (geometry, seen) = (geometry.geometry(), finders.chosen().found().seen);
        let mirrored = Mirrored { staged, band, sample, geometry, seen };
        mirrors.follow(gpu, &mirrored, shade, planes, stats).await
    }

    /// The planes that the film has for a frame.
    fn keeps(&self, staged: &Staged<'_>) -> FilmKeeps {
        FilmKeeps { first: true, through: self.is_see_through, flat: staged.has_flat(), ways: self.ways }
    }

    /// Shades the surroundings, seen through all layers.
    async fn shade_surroundings(&mut self, band: &Band, sample: &Sample, stats: &mut Stats) -> Result<(), GpuError> {
        let Self { gpu, geometry, finders, shade, planes, nothing, .. } = self;
        let none = vec![SeenPixels::NONE; band.order().slots()];
        nothing.write(gpu, &none)?;
        let layer = Layer { is_of_first_sample: sample.index == 0, is_first: false, is_last: true };
        shade.prepare(gpu, &sample_rays(band, sample), layer, planes)?;
        let geometry = geometry.geometry();
        let (positions, triangles) = (geometry.positions(), geometry.triangles());
        let inputs = ShadeInputs { seen: nothing, lit: finders.chosen().found().lit, positions, triangles };
        let mut recorder = Recorder::new(gpu);
        recorder.stage("shade", |pass| shade.record(gpu, pass, &inputs, planes, Groups::Flat(shade.groups())));
        add_times(stats, &recorder.submit().await?);
        Ok(())
    }

    /// Fetches the first hits of a band's sample, and the lights that reach them.
    async fn fetch_seen(&mut self, band: &Band) -> Result<(), GpuError> {
        let Self { gpu, first, seen, lit, .. } = self;
        let mut recorder = Recorder::new(gpu);
        let fetch = first.fetch(&mut recorder, band, lit.len());
        let done = recorder.submit().await?;
        FirstLayer::take(&done, fetch, band, seen, lit)?;
        Ok(())
    }

    /// Fetches a band: the film's rows, summed over the samples, and the first hits of the last sample.
    ///
    /// # Errors
    /// Where the device is lost.
    async fn fetch(&mut self, number: usize, film: &mut Film) -> Result<(), GpuError> {
        let band = &self.bands[number].clone();
        let Self { gpu, planes, first, seen, lit, .. } = self;
        let (fetch, done) = match self.fetched.take() {
            Some(fetched) => fetched,
            None => {
                let mut recorder = Recorder::new(gpu);
                let fetch = FilmFetch::record(&mut recorder, planes, first, band, lit.len());
                (fetch, recorder.submit().await?)
            }
        };
        let FilmFetch { color, flat, nearest, triangle, .. } = fetch;
        let shown = FirstLayer::take(&done, fetch.first, band, seen, lit)?;
        self.shadow_rays[number] = shown * self.shadowing_lights * u64::from(self.shaded);
        let [width, rows] = band.size().map(|side| side as usize);
        let first = band.rows.start as usize * width;
        let pixels = first..first + rows * width;
        for (color, read) in film.color[pixels.clone()].iter_mut().zip(done.read::<[f32; 4]>(color)?) {
            *color = Film::bounded(read.into());
        }
        for (flat, read) in film.flat.iter_mut().skip(first).zip(done.read::<[f32; 4]>(flat)?) {
            *flat = Film::bounded(read.into());
        }
        let depths_and_normals = film.depth[pixels.clone()].iter_mut().zip(&mut film.normal[pixels.clone()]);
        for ((depth, normal), [x, y, z, w]) in depths_and_normals.zip(done.read::<[f32; 4]>(nearest)?) {
            (*depth, *normal) = (w, [x, y, z].into());
        }
        done.read_into(triangle, &mut film.triangle[pixels])?;
        self.is_finished = true;
        Ok(())
    }

    /// Develops a band into its rows of a texture, in place of [fetching](Self::fetch) it.
    ///
    /// # Errors
    /// Where the device has no room for the texture, or is lost.
    async fn develop_to_texture(
        &mut self,
        number: usize,
        settings: &Settings,
        stats: &mut Stats,
    ) -> Result<(), GpuError> {
        let Self { gpu, planes, first, picture, bands, .. } = self;
        let band = &bands[number];
        let shown = picture.develop(gpu, band, (planes, first.seen()), settings, stats).await?;
        self.shadow_rays[number] = shown * self.shadowing_lights * u64::from(self.shaded);
        self.is_finished = true;
        Ok(())
    }
}

impl Engine for GpuEngine {
    fn check(&self, settings: &Settings, output: Output) -> Result<(), Error> {
        match settings.structure.on_gpu() {
            _ if settings.smooth_terminator => Err(Error::TerminatorOnGpu),
            _ if settings.noise > 0.0 && output == Output::Texture => Err(Error::NoiseOfTexture),
            counterpart => counterpart.map(drop),
        }
    }

    fn begin(&mut self, settings: &Settings) {
        self.uploaded_before = self.gpu.uploaded_bytes();
        self.finders.choose(&self.gpu, &settings.structure);
        if !self.is_finished {
            // Uploads of a frame that failed may be missing.
            self.geometry.forget();
            self.tables = Tables::default();
            self.rig.forget();
            self.mirrors.iter_mut().for_each(Mirrors::forget);
        }
        self.is_finished = false;
        self.fetched = None;
        self.shadow_rays.clear();
        self.settled = [Settled { rays: Some(0), ..Settled::default() }, Settled::default()];
    }

    /// Where a rig moves the scene, its vertices are posed on the GPU alone, unless a camera is made from them.
    fn animate(&mut self, scene: &Scene, seconds: f64, settings: &Settings, frame: &mut Frame) -> Result<(), Error> {
        let goes_on = settings.bounces > 0 || looked_around(settings) > 0.0;
        if self.finders.chosen().needs_vertices() || goes_on || !settings.layers.is_empty() {
            self.rig.leave();
            return Ok(scene.pose(seconds, frame)?);
        }
        self.rig.animate(scene, seconds, frame)?;
        if settings.camera == CameraChoice::Default && frame.cameras.is_empty() {
            self.rig.pose_on_cpu(frame);
        }
        Ok(())
    }

    fn adopt(&mut self) {
        self.rig.leave();
    }

    /// Uploads the changes of a frame.
    fn build(&mut self, staged: &Staged<'_>, output: Output) -> Result<(), Error> {
        let Staged { frame, lights, view, settings, .. } = *staged;
        let (follows, is_see_through) = (settings.bounces > 0, frame.is_see_through());
        self.light = OnwardLight { takes_colors: is_see_through && follows, around: looked_around(settings) };
        self.ways = match () {
            () if follows && settings.gloss && settings.samples > 1 => Onward::GLOSSY_WAYS,
            () if is_see_through && (follows || self.light.is_asked_first()) => Onward::ALL_WAYS,
            () if follows && has_mirrors(frame) => Onward::MIRRORS,
            () => 0,
        };
        self.is_see_through = is_see_through && self.ways == 0;
        self.output = output;
        self.shadowing_lights = lights.iter().filter(|light| light.casts_shadow).count() as u64;
        let rig = self.rig.rig().map(Arc::as_ref);
        self.geometry.upload(&self.gpu, frame, rig, settings.sides)?;
        self.tables.upload(&self.gpu, staged, rig, &mut self.shade)?;
        self.rig.prepare(&self.gpu, self.geometry.geometry(), &self.shade)?;
        let [width, height] = output.fetched(&view);
        self.seen.resize(width, height);
        self.seen.inverse_depth.fill(f32::NAN);
        self.lit.resize(lights.len(), LightMask::default());
        self.lit.iter_mut().for_each(|mask| mask.resize(self.seen.order()));
        let goes_on = self.ways > 0 || self.light.is_asked_first();
        let onward_bytes = if goes_on { Onward::pixel_bytes(self.ways) } else { 0 };
        let pixel_bytes = self.keeps(staged).plane_bytes().max(onward_bytes);
        let finder = self.finders.chosen_mut();
        finder.build(&self.gpu, frame)?;
        if goes_on {
            self.mirrors.get_or_insert_with(|| Mirrors::new(&self.gpu)).build(&self.gpu, frame, self.light)?;
        }
        self.bands = Band::all(&self.gpu, &view, finder.pixel_bytes().max(pixel_bytes)).collect();
        self.shadow_rays.resize(self.bands.len(), 0);
        match settings {
            _ if self.bands.len() == 1 => {}
            Settings { noise, .. } if *noise > 0.0 => return Err(Error::NoiseInBands),
            Settings { layers, .. } if !layers.is_empty() => return Err(Error::LayersInBands),
            _ => {}
        }
        Ok(())
    }

    fn bands(&self) -> usize {
        self.bands.len()
    }

    /// Adds samples to the film on the GPU, one after the other: sees, shadows and shades.
    fn shade<'a>(
        &'a mut self,
        staged: &'a Staged<'a>,
        band: usize,
        samples: &'a Samples,
        _film: &'a mut Film,
        stats: &'a mut Stats,
    ) -> Outcome<'a> {
        Outcome::of(async move {
            let band = Band { view: staged.view, ..self.bands[band].clone() };
            self.tables.upload_lights(&self.gpu, staged, &mut self.shade)?;
            for sample in samples.as_slice() {
                self.shade_sample(staged, &band, sample, stats).await?;
                self.shaded = sample.index + 1;
            }
            if !staged.settings.layers.is_empty() {
                self.fetch_seen(&band).await?;
            }
            Ok(())
        })
    }

    fn layers(
        &mut self,
        staged: &Staged<'_>,
        samples: &Samples,
        next: Option<&Next<'_>>,
        film: &mut Film,
        stats: &mut Stats,
    ) {
        // A texture has none.
        if !staged.settings.layers.is_empty() && self.output == Output::Film {
            let all = SeenAndLit { seen: &self.seen, masks: &self.lit, samples };
            stats.time("layers", || all.add_layers(staged, next, film));
        }
    }

    fn develop<'a>(
        &'a mut self,
        staged: &'a Staged<'a>,
        band: usize,
        output: Output,
        film: &'a mut Film,
        stats: &'a mut Stats,
    ) -> Outcome<'a> {
        Outcome::of(async move {
            match output {
                Output::Film => {
                    let start = Instant::now();
                    self.fetch(band, film).await?;
                    stats.add("fetch", start.elapsed().as_secs_f64() * 1e3);
                }
                Output::Texture => self.develop_to_texture(band, staged.settings, stats).await?,
            }
            Ok(())
        })
    }

    fn texture(&self) -> Option<wgpu::Texture> {
        self.picture.texture()
    }

    fn seen(&self) -> &SeenPixels {
        &self.seen
    }

    fn light_masks(&self) -> &[LightMask] {
        &self.lit
    }

    fn whole_frame<'a>(&'a self, frame: &'a Frame) -> &'a Frame {
        self.rig.whole(frame)
    }

    /// Of the work of several layers, only that of the surfaces seen first is counted; their shadow rays are those of the
    /// last sample, times the number of samples.
    fn count(&self, frame: &Frame, stats: &mut Stats) {
        stats.vertices = self.geometry.geometry().vertex_count() as usize;
        stats.shadow_rays = self.shadow_rays.iter().sum();
        stats.count_settled(self.settled.map(Some));
        let [triangles, points, pixels] = self.finders.chosen().bytes();
        let [triangles_in_mirrors, rays] = self.mirrors.as_ref().map_or([0; 2], Mirrors::bytes);
        stats.structure_bytes = (triangles + triangles_in_mirrors) as usize;
        stats.point_bytes = points as usize;
        stats.frame_bytes += self.rig.bytes() as usize;
        let film = self.planes.planes().bytes() + self.planes.triangle().bytes();
        stats.pixel_bytes += (pixels + rays + film + self.picture.bytes()) as usize;
        stats.count_omitted(&self.rig.omitted(frame));
        stats.uploaded_bytes = self.gpu.uploaded_bytes() - self.uploaded_before;
    }
}

/// Adds the times of finished stages.
fn add_times(stats: &mut Stats, done: &Done) {
    done.times.iter().for_each(|stage| stats.add(stage.name, stage.milliseconds));
}

/// Whether any surface is a mirror.
fn has_mirrors(frame: &Frame) -> bool {
    frame.materials.materials.iter().any(|material| material_mirrors(material, false))
}

/// Sources of the lights; `None` for a light without shadows.
fn all_sources(lights: &[Light]) -> Vec<Option<LightSource>> {
    lights.iter().map(|light| light.casts_shadow.then_some(light.source)).collect()
}

/// The least linear value of each level of an eight-bit channel of a picture.
#[doc(hidden)] // For tests of the stage `develop`.
#[must_use]
pub fn screen_levels() -> &'static [f32; 256] {
    crate::screen::Levels::get().least()
}
