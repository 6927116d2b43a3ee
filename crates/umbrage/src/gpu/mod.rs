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
use umbrage_gpu::{Band, Buffer, Done, Fetch, Geometry, Groups, Onward, Recorder, Sight};
use umbrage_rays::{LightMask, LightSource, SeenPixels, Work};
use umbrage_scene::{Frame, Light};
use web_time::Instant;

use crate::cpu::SeenAndLit;
use crate::engine::{Engine, Last, Outcome, Output, Passes, Staged};
use crate::frame::Subject;
use crate::motion::Next;
use crate::plan::Plan;
use crate::sampling::{Sample, Samples};
use crate::{CameraChoice, Error, Film, Settings, Settled, Stats};
use finder::Finders;
use first_layer::FirstLayer;
use geometry::FrameGeometry;
use mirrors::{Mirrored, Mirrors};
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
    plan: Plan,
    /// Tracer of secondary rays, made for the first frame that has any.
    mirrors: Option<Mirrors>,
    /// The sample that is seen, shadowed and shaded.
    turn: Option<Turn>,
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
#[derive(Debug)]
struct Turn {
    plan: Plan,
    band: Band,
    sample: Sample,
    /// Sources of the lights; `None` for a light without shadows.
    sources: Vec<Option<LightSource>>,
    /// Whether the film is fetched after it.
    is_last: bool,
}

impl Turn {
    /// The rays of the sample, with the limits of their secondary rays.
    fn rays(&self) -> ShadeSample {
        let Plan { bounces, least: least_contribution, around, .. } = self.plan;
        let (number, looks_around) = (self.sample.index, u32::from(around > 0.0));
        ShadeSample { bounces, least_contribution, number, looks_around, ..sample_rays(&self.band, &self.sample) }
    }
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
            plan: Plan::default(),
            mirrors: None,
            turn: None,
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
    async fn layer(&mut self, turn: &Turn, is_first: bool, stats: &mut Stats) -> Result<bool, GpuError> {
        let Turn { plan, band, sample, sources: lights, is_last } = turn;
        let shades = !plan.light().is_asked_first();
        let may_fetch = *is_last && shades && !plan.is_in_layers() && plan.ways() == 0;
        let Self { gpu, rig, geometry, finders, shade, planes, first, lit: masks, .. } = self;
        let (geometry, finder) = (geometry.geometry(), finders.chosen_mut());
        let (sight, offset_pixels) = (Sight { is_behind: !is_first }, sample.offset_pixels);
        let layer = Layer { is_of_first_sample: sample.index == 0, is_first, is_last: !plan.is_in_layers() };
        shade.prepare(gpu, &turn.rays(), layer, planes)?;
        for _ in 0..Self::MOST_TRIES {
            let groups = shade.groups();
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
            if plan.is_in_layers() {
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
    async fn shade_sample(&mut self, turn: &Turn, stats: &mut Stats) -> Result<(), GpuError> {
        self.layer(turn, true, stats).await?;
        if turn.plan.light().is_asked_first() {
            self.shade_asked(turn, stats).await?;
        }
        if turn.plan.ways() > 0 {
            return self.follow_mirrors(turn, stats).await;
        }
        if !turn.plan.is_in_layers() {
            return Ok(());
        }
        for _ in 1..Plan::MOST_LAYERS {
            if !self.layer(turn, false, stats).await? {
                break;
            }
        }
        self.shade_surroundings(turn, stats).await
    }

    /// Shades the first hits once their tints and ambient occlusion are known.
    async fn shade_asked(&mut self, turn: &Turn, stats: &mut Stats) -> Result<(), GpuError> {
        let Self { gpu, geometry, finders, shade, planes, mirrors, .. } = self;
        let Some(mirrors) = mirrors else { return Ok(()) };
        let geometry = geometry.geometry();
        let Found { seen, lit, .. } = finders.chosen().found();
        mirrors.ask_first(gpu, &Mirrored { turn, geometry, seen }, lit, shade, planes, stats).await?;
        let (lit, tints_word) = mirrors.asked();
        let rays = ShadeSample { tints_word, ..turn.rays() };
        shade.prepare(gpu, &rays, Layer::only(turn.sample.index == 0), planes)?;
        shade_all(gpu, shade, geometry, [seen, lit], planes, stats).await
    }

    /// Traces and shades a sample's secondary rays.
    async fn follow_mirrors(&mut self, turn: &Turn, stats: &mut Stats) -> Result<(), GpuError> {
        let Self { gpu, geometry, finders, shade, planes, mirrors, .. } = self;
        let Some(mirrors) = mirrors else { return Ok(()) };
        let (geometry, seen) = (geometry.geometry(), finders.chosen().found().seen);
        mirrors.follow(gpu, &Mirrored { turn, geometry, seen }, shade, planes, stats).await
    }

    /// The planes that the film has for a frame.
    fn keeps(&self, staged: &Staged<'_>) -> FilmKeeps {
        let (through, ways) = (self.plan.is_in_layers(), self.plan.ways());
        FilmKeeps { first: staged.settings.first_hits, through, flat: staged.has_flat(), ways }
    }

    /// Shades the surroundings, seen through all layers.
    async fn shade_surroundings(&mut self, turn: &Turn, stats: &mut Stats) -> Result<(), GpuError> {
        let Self { gpu, geometry, finders, shade, planes, nothing, .. } = self;
        let Turn { band, sample, .. } = turn;
        nothing.write(gpu, &vec![SeenPixels::NONE; band.order().slots()])?;
        let layer = Layer { is_of_first_sample: sample.index == 0, is_first: false, is_last: true };
        shade.prepare(gpu, &sample_rays(band, sample), layer, planes)?;
        let lit = finders.chosen().found().lit;
        shade_all(gpu, shade, geometry.geometry(), [nothing, lit], planes, stats).await
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
        if !film.triangle.is_empty() {
            let depths_and_normals = film.depth[pixels.clone()].iter_mut().zip(&mut film.normal[pixels.clone()]);
            for ((depth, normal), [x, y, z, w]) in depths_and_normals.zip(done.read::<[f32; 4]>(nearest)?) {
                (*depth, *normal) = (w, [x, y, z].into());
            }
            done.read_into(triangle, &mut film.triangle[pixels])?;
        }
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
    fn begin(&mut self, settings: &Settings, output: Output) -> Result<(), Error> {
        match settings.structure.on_gpu() {
            _ if settings.smooth_terminator => return Err(Error::TerminatorOnGpu),
            _ if settings.noise > 0.0 && output == Output::Texture => return Err(Error::NoiseOfTexture),
            counterpart => drop(counterpart?),
        }
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
        Ok(())
    }

    /// Where a rig moves the scene, its vertices are posed on the GPU alone, unless a camera is made from them.
    fn animate(&mut self, subject: Subject<'_>, settings: &Settings, frame: &mut Frame) -> Result<(), Error> {
        let Subject::Moment(scene, seconds) = subject else {
            self.rig.leave();
            return Ok(());
        };
        let Plan { bounces, around, .. } = Plan::limits(settings);
        let may_go_on = bounces > 0 || around > 0.0;
        if self.finders.chosen().needs_vertices() || may_go_on || !settings.layers.is_empty() {
            self.rig.leave();
            return Ok(scene.pose(seconds, frame)?);
        }
        self.rig.animate(scene, seconds, frame)?;
        if settings.camera == CameraChoice::Default && frame.cameras.is_empty() {
            self.rig.pose_on_cpu(frame);
        }
        Ok(())
    }

    /// Uploads the changes of a frame.
    fn build(&mut self, staged: &Staged<'_>, output: Output) -> Result<Passes, Error> {
        let Staged { frame, lights, view, settings, .. } = *staged;
        self.plan = Plan::new(settings, frame);
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
        let (light, ways) = (self.plan.light(), self.plan.ways());
        let goes_on = ways > 0 || light.is_asked_first();
        let onward_bytes = if goes_on { Onward::pixel_bytes(ways) } else { 0 };
        let pixel_bytes = self.keeps(staged).plane_bytes().max(onward_bytes);
        let finder = self.finders.chosen_mut();
        finder.build(&self.gpu, frame)?;
        if goes_on {
            self.mirrors.get_or_insert_with(|| Mirrors::new(&self.gpu)).build(&self.gpu, frame, light)?;
        }
        self.bands = Band::all(&self.gpu, &view, finder.pixel_bytes().max(pixel_bytes)).collect();
        self.shadow_rays.resize(self.bands.len(), 0);
        match settings {
            _ if self.bands.len() == 1 => {}
            Settings { noise, .. } if *noise > 0.0 => return Err(Error::NoiseInBands),
            Settings { layers, .. } if !layers.is_empty() => return Err(Error::LayersInBands),
            _ => {}
        }
        Ok(Passes { bands: self.bands.len(), by_four: false })
    }

    fn see(&mut self, staged: &Staged<'_>, _stats: &mut Stats) -> Result<(), Error> {
        let Staged { view, settings, samples, .. } = *staged;
        let band = Band { view, ..self.bands[staged.band].clone() };
        let sample = samples.as_slice()[0];
        if sample.index == 0 {
            self.planes.prepare(&self.gpu, band.size(), self.keeps(staged))?;
        }
        let is_last = self.output == Output::Film && sample.index + 1 == settings.samples;
        self.turn = Some(Turn { plan: self.plan, band, sample, sources: Vec::new(), is_last });
        Ok(())
    }

    fn shadow(&mut self, staged: &Staged<'_>, _stats: &mut Stats) -> Result<(), Error> {
        self.tables.upload_lights(&self.gpu, staged, &mut self.shade)?;
        let source = |light: &Light| light.casts_shadow.then_some(light.source);
        if let Some(turn) = &mut self.turn {
            turn.sources.extend(staged.lights.iter().map(source));
        }
        Ok(())
    }

    fn shade<'a>(
        &'a mut self,
        staged: &'a Staged<'a>,
        next: Option<&'a Next<'a>>,
        film: &'a mut Film,
        stats: &'a mut Stats,
    ) -> Outcome<'a> {
        Box::pin(async move {
            let Some(turn) = self.turn.take() else { return Ok(()) };
            self.shade_sample(&turn, stats).await?;
            self.shaded = turn.sample.index + 1;
            // A texture has no layers.
            if !staged.settings.layers.is_empty() && self.output == Output::Film {
                self.fetch_seen(&turn.band).await?;
                let all = SeenAndLit { seen: &self.seen, masks: &self.lit };
                stats.time("layers", || all.add_layers(staged, next, film));
            }
            Ok(())
        })
    }

    fn develop<'a>(&'a mut self, staged: &'a Staged<'a>, film: &'a mut Film, stats: &'a mut Stats) -> Outcome<'a> {
        Box::pin(async move {
            match self.output {
                Output::Film | Output::Rows => {
                    let start = Instant::now();
                    self.fetch(staged.band, film).await?;
                    stats.add("fetch", start.elapsed().as_secs_f64() * 1e3);
                }
                Output::Texture => self.develop_to_texture(staged.band, staged.settings, stats).await?,
            }
            Ok(())
        })
    }

    fn last(&self) -> Last<'_> {
        Last {
            samples: Samples::one(Sample::MIDDLE),
            seen: &self.seen,
            light_masks: &self.lit,
            camera_work: Work::default(),
            light_work: &[],
            texture: self.picture.texture(),
        }
    }

    fn whole_frame<'a>(&'a self, frame: &'a Frame) -> &'a Frame {
        self.rig.whole(frame)
    }

    /// Of the work of several layers, only that of the surfaces seen first is counted; their shadow rays are those of the
    /// last sample, times the number of samples.
    fn count(&self, frame: &Frame, stats: &mut Stats) {
        stats.omitted_marks = stats.marks;
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

/// Shades all hits of a band, for which `shade` is prepared: the triangles of slots, and the lights that reach them.
async fn shade_all(
    gpu: &Gpu,
    shade: &Shade,
    geometry: &Geometry,
    [seen, lit]: [&Buffer; 2],
    planes: &FilmPlanes,
    stats: &mut Stats,
) -> Result<(), GpuError> {
    let inputs = ShadeInputs { seen, lit, positions: geometry.positions(), triangles: geometry.triangles() };
    let mut recorder = Recorder::new(gpu);
    recorder.stage("shade", |pass| shade.record(gpu, pass, &inputs, planes, Groups::Flat(shade.groups())));
    add_times(stats, &recorder.submit().await?);
    Ok(())
}

/// The least linear value of each level of an eight-bit channel of a picture.
#[doc(hidden)] // For tests of the stage `develop`.
#[must_use]
pub fn screen_levels() -> &'static [f32; 256] {
    crate::screen::Levels::get().least()
}
