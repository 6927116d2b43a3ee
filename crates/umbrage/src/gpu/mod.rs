//! The GPU engine: a frame's stages as compute shaders, through structures rebuilt for every frame.

mod first_layer;
mod geometry;
mod picture;
mod rig;
mod tables;

use std::sync::Arc;

pub use rig::tables as rig_tables;
pub(crate) use umbrage_gpu::Band;
pub use umbrage_gpu::{Adapter, DeviceLimits, Gpu, GpuError, wgpu};

use umbrage_gpu::shade::{FilmPlanes, Layer, Shade, ShadeInputs};
use umbrage_gpu::{Buffer, CameraGrid, CameraOptions, Fit, Groups, LightGrid, Recorder, Sight};
use umbrage_rays::{LightMask, Omitted, SeenPixels, Sides, View};
use umbrage_scene::{Frame, Scene};

use crate::background::Surroundings;
use crate::engine::Output;
use crate::sampling::Sample;
use crate::{Film, Settings, Settled, Stats};
use first_layer::FirstLayer;
use geometry::FrameGeometry;
use picture::Picture;
use rig::FrameRig;
use tables::{Tables, sample_rays};

/// Finds what each pixel sees, which lights reach it and what that looks like, on a GPU.
#[derive(Debug)]
pub(crate) struct GpuEngine {
    gpu: Gpu,
    rig: FrameRig,
    geometry: FrameGeometry,
    camera: CameraGrid,
    lights: LightGrid,
    tables: Tables,
    fit: Fit,
    shade: Shade,
    planes: FilmPlanes,
    /// What pixels show first.
    first: FirstLayer,
    picture: Picture,
    /// A layer that shows nothing.
    nothing: Buffer,
    sides: Sides,
    is_see_through: bool,
    /// The same, and which lights reach it, fetched.
    seen: SeenPixels,
    lit: Vec<LightMask>,
    shadow_rays: u64,
    /// How many lights of the last frame something can keep away.
    shadowing_lights: u64,
    /// Whether the last frame that was begun got to its end.
    is_finished: bool,
    /// What the predicate settled of the camera rays and of the shadow rays of first surfaces.
    settled: [Settled; 2],
    /// What the GPU had taken over before the last frame.
    uploaded_before: u64,
}

impl GpuEngine {
    /// How many surfaces one behind the other are seen through.
    const MOST_LAYERS: usize = 32;
    /// How often a frame is done again with more room: what a list needs is known once those before it fit.
    const MOST_TRIES: usize = 16;

    /// An engine on an open device.
    ///
    /// # Errors
    /// Where the device has no memory for fixed tables.
    pub(crate) fn new(gpu: Gpu, options: CameraOptions) -> Result<Self, GpuError> {
        Ok(Self {
            rig: FrameRig::new(&gpu)?,
            geometry: FrameGeometry::new(&gpu),
            camera: CameraGrid::new(&gpu, options),
            lights: LightGrid::new(&gpu),
            tables: Tables::default(),
            fit: Fit::new(&gpu),
            shade: Shade::new(&gpu)?,
            planes: FilmPlanes::new(&gpu),
            first: FirstLayer::new(&gpu),
            picture: Picture::new(&gpu)?,
            nothing: Buffer::storage(&gpu, "nothing seen"),
            sides: Sides::Both,
            is_see_through: false,
            seen: SeenPixels::default(),
            lit: Vec::new(),
            shadow_rays: 0,
            shadowing_lights: 0,
            is_finished: false,
            settled: [Settled::default(); 2],
            uploaded_before: 0,
            gpu,
        })
    }

    /// Brings a frame to a moment. Where a rig moves the scene, its vertices are posed on the GPU alone, unless a camera is
    /// made from them.
    ///
    /// # Errors
    /// Where the scene can't be posed.
    pub(crate) fn animate(
        &mut self,
        scene: &Scene,
        seconds: f64,
        settings: &Settings,
        frame: &mut Frame,
    ) -> Result<(), umbrage_scene::Error> {
        self.uploaded_before = self.gpu.uploaded_bytes();
        self.rig.animate(scene, seconds, frame)?;
        if settings.camera.is_none() && frame.cameras.is_empty() {
            self.rig.pose_on_cpu(frame);
        }
        Ok(())
    }

    /// Makes ready for a frame that comes with its vertices.
    pub(crate) fn adopt(&mut self) {
        self.uploaded_before = self.gpu.uploaded_bytes();
        self.rig.leave();
    }

    /// Brings what is new of a frame to the GPU.
    ///
    /// # Errors
    /// Where something is larger than the device allows.
    pub(crate) fn build(
        &mut self,
        frame: &Frame,
        view: &View,
        settings: &Settings,
        surroundings: &Surroundings<'_>,
        output: Output,
    ) -> Result<(), GpuError> {
        if !self.is_finished {
            // What a frame that failed has uploaded may not be there.
            self.geometry.forget();
            self.tables = Tables::default();
            self.rig.forget();
        }
        self.is_finished = false;
        self.sides = settings.sides;
        self.is_see_through = frame.is_see_through();
        self.shadow_rays = 0;
        self.shadowing_lights = frame.lights.iter().filter(|light| light.casts_shadow).count() as u64;
        self.settled = [Settled { rays: Some(0), ..Settled::default() }, Settled::default()];
        let rig = self.rig.rig().map(Arc::as_ref);
        self.geometry.upload(&self.gpu, frame, rig)?;
        self.tables.upload(&self.gpu, frame, rig, surroundings, &mut self.shade)?;
        self.rig.prepare(&self.gpu, self.geometry.geometry(), &self.shade)?;
        let [width, height] = output.fetched(view);
        self.seen.resize(width, height);
        self.seen.inverse_depth.fill(f32::NAN);
        self.lit.resize(frame.lights.len(), LightMask::default());
        self.lit.iter_mut().for_each(|mask| mask.resize(self.seen.order()));
        Ok(())
    }

    /// The bands of rows in which an image is rendered: one where the device has room for it.
    pub(crate) fn bands(&self, view: &View) -> Vec<Band> {
        Band::all(&self.gpu, view).collect()
    }

    /// Adds a sample to the film on the GPU: sees, shadows and shades, layer by layer where the scene is seen through.
    ///
    /// # Errors
    /// Where the device is lost, or has too little room.
    pub(crate) fn sample(
        &mut self,
        frame: &Frame,
        band: &Band,
        sample: &Sample,
        stats: &mut Stats,
    ) -> Result<(), GpuError> {
        if sample.index == 0 {
            self.planes.prepare(&self.gpu, band.size(), true, self.is_see_through)?;
        }
        self.layer(frame, band, sample, true, stats)?;
        if !self.is_see_through {
            return Ok(());
        }
        for _ in 1..Self::MOST_LAYERS {
            if !self.layer(frame, band, sample, false, stats)? {
                break;
            }
        }
        self.shade_surroundings(band, sample, stats)
    }

    /// One layer of surfaces: the nearest ones, or those behind the last. Whether any was seen, of those behind.
    ///
    /// All stages go to the GPU at once, and nothing is read back between them. Where there was too little room for what
    /// they need, the layer isn't shaded, and all is done again with more.
    fn layer(
        &mut self,
        frame: &Frame,
        band: &Band,
        sample: &Sample,
        is_first: bool,
        stats: &mut Stats,
    ) -> Result<bool, GpuError> {
        let Self { gpu, rig, geometry, camera, lights, fit, shade, planes, .. } = self;
        let geometry = geometry.geometry();
        let sources: Vec<_> = frame.lights.iter().map(|light| light.casts_shadow.then_some(light.source)).collect();
        let sight = Sight { culls_back_faces: self.sides == Sides::Front, is_behind: !is_first };
        let layer = Layer { is_of_first_sample: sample.index == 0, is_first, is_last: !self.is_see_through };
        shade.prepare(gpu, &sample_rays(band, sample), layer, planes)?;
        for _ in 0..Self::MOST_TRIES {
            camera.prepare(gpu, geometry, band.clone(), sample.offset_pixels, sight)?;
            lights.prepare(gpu, geometry, band.clone(), sample.offset_pixels, &sources)?;
            fit.prepare(gpu, camera, lights, shade.groups())?;
            let mut recorder = Recorder::new(gpu);
            rig.record(gpu, &mut recorder, geometry, shade);
            camera.record(gpu, &mut recorder, geometry);
            lights.record(gpu, &mut recorder, geometry, camera.seen());
            fit.record(gpu, &mut recorder, camera, lights);
            if is_first {
                self.first.record(gpu, &mut recorder, camera, lights)?;
            }
            let (positions, triangles) = (geometry.positions(), geometry.triangles());
            let inputs = ShadeInputs { seen: camera.seen(), lit: lights.lit(), positions, triangles };
            recorder.stage("shade", |pass| shade.record(gpu, pass, &inputs, planes, fit.groups()));
            if self.is_see_through {
                camera.keep(gpu, &mut recorder)?;
            }
            let times = recorder.submit()()?;
            rig.finish();
            if camera.finish(gpu)? & lights.finish(gpu)? {
                times.iter().for_each(|stage| stats.add(stage.name, stage.milliseconds));
                if is_first {
                    count_settled(&mut self.settled, camera, lights);
                }
                return Ok(is_first || camera.sees_any());
            }
        }
        Err(GpuError::OutOfMemory(format!("a frame's lists have outgrown their buffers {} times", Self::MOST_TRIES)))
    }

    /// What is around the scene, seen through all layers.
    fn shade_surroundings(&mut self, band: &Band, sample: &Sample, stats: &mut Stats) -> Result<(), GpuError> {
        let Self { gpu, geometry, lights, shade, planes, nothing, .. } = self;
        let none = vec![SeenPixels::NONE; band.order().slots()];
        nothing.write(gpu, &none)?;
        let layer = Layer { is_of_first_sample: sample.index == 0, is_first: false, is_last: true };
        shade.prepare(gpu, &sample_rays(band, sample), layer, planes)?;
        let geometry = geometry.geometry();
        let (positions, triangles) = (geometry.positions(), geometry.triangles());
        let inputs = ShadeInputs { seen: nothing, lit: lights.lit(), positions, triangles };
        let mut recorder = Recorder::new(gpu);
        recorder.stage("shade", |pass| shade.record(gpu, pass, &inputs, planes, Groups::Flat(shade.groups())));
        recorder.submit()()?.iter().for_each(|stage| stats.add(stage.name, stage.milliseconds));
        Ok(())
    }

    /// Fetches a band: the film's rows, summed over the samples, and what the last sample showed first.
    ///
    /// # Errors
    /// Where the device is lost.
    pub(crate) fn fetch(&mut self, band: &Band, film: &mut Film, samples: u32) -> Result<(), GpuError> {
        let shown = self.first.fetch(&self.gpu, band, &mut self.seen, &mut self.lit)?;
        self.shadow_rays += shown * self.shadowing_lights * u64::from(samples);
        let Self { gpu, planes, .. } = self;
        let [width, rows] = band.size().map(|side| side as usize);
        let first = band.rows.start as usize * width;
        let pixels = first..first + rows * width;
        for (color, read) in film.color[pixels.clone()].iter_mut().zip(planes.read_color(gpu)?) {
            *color = read.into();
        }
        let nearest = film.depth[pixels.clone()].iter_mut().zip(&mut film.normal[pixels.clone()]);
        for ((depth, normal), [x, y, z, w]) in nearest.zip(planes.read_first(gpu)?) {
            (*depth, *normal) = (w, [x, y, z].into());
        }
        film.triangle[pixels].copy_from_slice(&planes.read_triangle(gpu)?);
        self.is_finished = true;
        Ok(())
    }

    /// Develops a band into its rows of a texture, in place of [fetching](Self::fetch) it.
    ///
    /// # Errors
    /// Where the device has no room for the texture, or is lost.
    pub(crate) fn develop(&mut self, band: &Band, settings: &Settings, stats: &mut Stats) -> Result<(), GpuError> {
        let Self { gpu, planes, first, picture, .. } = self;
        let shown = picture.develop(gpu, band, (planes, first.seen()), settings, stats)?;
        self.shadow_rays += shown * self.shadowing_lights * u64::from(settings.samples);
        self.is_finished = true;
        Ok(())
    }

    /// The texture that the last frame was developed into.
    pub(crate) fn texture(&self) -> Option<wgpu::Texture> {
        self.picture.texture()
    }

    /// The last frame with its vertices, which are posed on the CPU where only the GPU has them.
    pub(crate) fn whole_frame<'a>(&'a self, frame: &'a Frame) -> &'a Frame {
        self.rig.whole(frame)
    }

    /// Which of the last frame's triangles no ray can hit.
    ///
    /// # Errors
    /// Where the device is lost.
    pub(crate) fn omitted(&self, frame: &Frame) -> Result<Omitted, GpuError> {
        self.rig.omitted(&self.gpu, frame)
    }

    /// How many vertices the last frame has.
    pub(crate) fn vertices(&self) -> usize {
        self.geometry.geometry().vertex_count() as usize
    }

    /// Bytes of what the vertices are made from that the GPU poses.
    pub(crate) fn rig_bytes(&self) -> usize {
        self.rig.bytes() as usize
    }

    /// Bytes that went to the GPU since the last frame was begun.
    pub(crate) fn uploaded_bytes(&self) -> u64 {
        self.gpu.uploaded_bytes() - self.uploaded_before
    }

    /// What each pixel showed first at the last sample.
    pub(crate) fn seen(&self) -> &SeenPixels {
        &self.seen
    }

    /// For each light, which of these pixels it lit at the last sample.
    pub(crate) fn light_masks(&self) -> &[LightMask] {
        &self.lit
    }

    /// Shadow rays of the last sample's first surfaces, times the number of samples: those behind aren't counted.
    pub(crate) fn shadow_rays(&self) -> u64 {
        self.shadow_rays
    }

    /// What of the last frame's camera rays and shadow rays was left to the predicate, of the surfaces seen first.
    pub(crate) fn settled(&self) -> [Settled; 2] {
        self.settled
    }

    pub(crate) fn structure_bytes(&self) -> usize {
        (self.camera.structure_bytes() + self.lights.structure_bytes()) as usize
    }

    pub(crate) fn point_bytes(&self) -> usize {
        self.lights.point_bytes() as usize
    }

    pub(crate) fn pixel_bytes(&self) -> usize {
        let film = self.planes.planes().bytes() + self.planes.triangle().bytes();
        (self.camera.pixel_bytes() + film + self.picture.bytes()) as usize
    }
}

/// The least linear value of each level of an eight-bit channel of a picture.
#[must_use]
pub fn screen_levels() -> &'static [f32; 256] {
    crate::screen::Levels::get().least()
}

/// Adds what the predicate settled for the grids' last frame.
fn count_settled([of_camera, of_lights]: &mut [Settled; 2], camera: &CameraGrid, lights: &LightGrid) {
    let work = camera.work();
    of_camera.tests += u64::from(work.open_hits);
    of_camera.rays = of_camera.rays.map(|rays| rays + u64::from(work.open_pixels));
    of_lights.tests += lights.work().iter().map(|work| u64::from(work.open)).sum::<u64>();
}
