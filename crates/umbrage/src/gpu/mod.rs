//! The GPU engine: a frame's stages as compute shaders, through structures rebuilt for every frame.

mod geometry;
mod rig;
mod tables;
pub mod trial;

use std::sync::Arc;

use rayon::prelude::*;
use umbrage_gpu::shade::{FilmPlanes, Layer, Shade, ShadeInputs};
use umbrage_gpu::{
    Buffer, CameraGrid, CameraOptions, CameraWork, Gpu, GpuError, LightGrid, LightWork, Recorder, Sight,
};
use umbrage_rays::{Omitted, SeenPixels, View};
use umbrage_scene::{Frame, Scene};

use crate::background::Surroundings;
use crate::cpu::LightMask;
use crate::sampling::Sample;
use crate::{Film, Settings, Stats};
use geometry::FrameGeometry;
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
    shade: Shade,
    planes: FilmPlanes,
    /// A layer that shows nothing.
    nothing: Buffer,
    culls_back_faces: bool,
    is_see_through: bool,
    /// What each pixel showed first, and which lights reached that, at the last sample; filled when it is asked for.
    seen: SeenPixels,
    lit: Vec<LightMask>,
    shadow_rays: u64,
    /// What the GPU had taken over before the last frame.
    uploaded_before: u64,
}

impl GpuEngine {
    /// How many surfaces one behind the other are seen through.
    const MOST_LAYERS: usize = 32;

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
            shade: Shade::new(&gpu)?,
            planes: FilmPlanes::new(&gpu),
            nothing: Buffer::storage(&gpu, "nothing seen"),
            culls_back_faces: false,
            is_see_through: false,
            seen: SeenPixels::default(),
            lit: Vec::new(),
            shadow_rays: 0,
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
        stats: &mut Stats,
    ) -> Result<(), GpuError> {
        self.culls_back_faces = settings.culls_back_faces;
        self.is_see_through = frame.is_see_through();
        self.shadow_rays = 0;
        let rig = self.rig.rig().map(Arc::as_ref);
        self.geometry.upload(&self.gpu, frame, rig)?;
        self.tables.upload(&self.gpu, frame, rig, surroundings, &mut self.shade)?;
        let times = self.rig.pose(&self.gpu, self.geometry.geometry(), &self.shade)?;
        times.iter().for_each(|stage| stats.add(stage.name, stage.milliseconds));
        self.planes.prepare(&self.gpu, [view.width, view.height], true, self.is_see_through)
    }

    /// Adds a sample to the film on the GPU: sees, shadows and shades, layer by layer where the scene is seen through.
    ///
    /// # Errors
    /// Where the device is lost, or has too little room.
    pub(crate) fn sample(
        &mut self,
        frame: &Frame,
        view: &View,
        sample: &Sample,
        stats: &mut Stats,
    ) -> Result<(), GpuError> {
        self.layer(frame, view, sample, true, stats)?;
        if !self.is_see_through {
            return Ok(());
        }
        for _ in 1..Self::MOST_LAYERS {
            if !self.layer(frame, view, sample, false, stats)? {
                break;
            }
        }
        self.shade_surroundings(view, sample, stats)
    }

    /// One layer of surfaces: the nearest ones, or those behind the last. Whether any was seen, of those behind.
    fn layer(
        &mut self,
        frame: &Frame,
        view: &View,
        sample: &Sample,
        is_first: bool,
        stats: &mut Stats,
    ) -> Result<bool, GpuError> {
        self.trace(frame, view, sample, is_first, stats)?;
        let Self { gpu, geometry, camera, lights, shade, planes, .. } = self;
        if is_first {
            read_masks(gpu, lights, frame.lights.len(), view, &mut self.lit)?;
            self.seen.resize(view.width, view.height);
            camera.seen().read_into(gpu, &mut self.seen.triangle)?;
            self.seen.inverse_depth.fill(f32::NAN);
            let order = self.seen.order();
            let places = self.seen.triangle.par_iter_mut().enumerate();
            let points = places.filter_map(|(place, triangle)| {
                if order.pixel(place).is_none() {
                    *triangle = SeenPixels::NONE;
                }
                (*triangle != SeenPixels::NONE).then_some(())
            });
            let points = points.count();
            self.shadow_rays += (points * frame.lights.len()) as u64;
        } else if !camera.sees_any() {
            return Ok(false);
        }
        let layer = Layer { is_of_first_sample: sample.index == 0, is_first, is_last: !self.is_see_through };
        shade.prepare(gpu, &sample_rays(view, sample), layer, planes)?;
        let geometry = geometry.geometry();
        let (positions, triangles) = (geometry.positions(), geometry.triangles());
        let inputs = ShadeInputs { seen: camera.seen(), lit: lights.lit(), positions, triangles };
        let mut recorder = Recorder::new(gpu);
        recorder.stage("shade", |pass| shade.record(gpu, pass, &inputs, planes));
        if self.is_see_through {
            camera.keep(gpu, &mut recorder)?;
        }
        recorder.submit()()?.iter().for_each(|stage| stats.add(stage.name, stage.milliseconds));
        Ok(true)
    }

    /// Finds the triangles of one layer and which lights reach them. Where there was too little room for what that needs,
    /// it is done again with more.
    fn trace(
        &mut self,
        frame: &Frame,
        view: &View,
        sample: &Sample,
        is_first: bool,
        stats: &mut Stats,
    ) -> Result<(), GpuError> {
        let Self { gpu, geometry, camera, lights, .. } = self;
        let geometry = geometry.geometry();
        let sources: Vec<_> = frame.lights.iter().map(|light| light.source).collect();
        let sight = Sight { culls_back_faces: self.culls_back_faces, is_behind: !is_first };
        loop {
            camera.prepare(gpu, geometry, view, sample.offset_pixels, sight)?;
            lights.prepare(gpu, geometry, view, sample.offset_pixels, &sources)?;
            let mut recorder = Recorder::new(gpu);
            camera.record(gpu, &mut recorder, geometry);
            lights.record(gpu, &mut recorder, geometry, camera.seen());
            let times = recorder.submit()()?;
            if camera.finish(gpu)? & lights.finish(gpu)? {
                times.iter().for_each(|stage| stats.add(stage.name, stage.milliseconds));
                return Ok(());
            }
        }
    }

    /// What is around the scene, seen through all layers.
    fn shade_surroundings(&mut self, view: &View, sample: &Sample, stats: &mut Stats) -> Result<(), GpuError> {
        let Self { gpu, geometry, lights, shade, planes, nothing, .. } = self;
        let none = vec![SeenPixels::NONE; self.seen.order().places()];
        nothing.write(gpu, &none)?;
        let layer = Layer { is_of_first_sample: sample.index == 0, is_first: false, is_last: true };
        shade.prepare(gpu, &sample_rays(view, sample), layer, planes)?;
        let geometry = geometry.geometry();
        let (positions, triangles) = (geometry.positions(), geometry.triangles());
        let inputs = ShadeInputs { seen: nothing, lit: lights.lit(), positions, triangles };
        let mut recorder = Recorder::new(gpu);
        recorder.stage("shade", |pass| shade.record(gpu, pass, &inputs, planes));
        recorder.submit()()?.iter().for_each(|stage| stats.add(stage.name, stage.milliseconds));
        Ok(())
    }

    /// Fetches the film: sums over the samples.
    ///
    /// # Errors
    /// Where the device is lost.
    pub(crate) fn read_film(&mut self, film: &mut Film) -> Result<(), GpuError> {
        let Self { gpu, planes, .. } = self;
        let first = planes.read_first(gpu)?;
        film.color = planes.read_color(gpu)?.into_iter().map(Into::into).collect();
        film.depth = first.iter().map(|&[.., depth]| depth).collect();
        film.normal = first.iter().map(|&[x, y, z, _]| [x, y, z].into()).collect();
        film.triangle = planes.read_triangle(gpu)?;
        Ok(())
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

    pub(crate) fn gpu(&self) -> &Gpu {
        &self.gpu
    }

    /// What the camera was as work at the last sample.
    pub(crate) fn camera_work(&self) -> CameraWork {
        self.camera.work()
    }

    /// What each light was as work at the last sample.
    pub(crate) fn light_work(&self) -> &[LightWork] {
        self.lights.work()
    }

    /// Shadow rays of the last sample's first surfaces, times the number of samples.
    pub(crate) fn shadow_rays(&self) -> u64 {
        self.shadow_rays
    }

    pub(crate) fn structure_bytes(&self) -> usize {
        (self.camera.structure_bytes() + self.lights.structure_bytes()) as usize
    }

    pub(crate) fn point_bytes(&self) -> usize {
        self.lights.point_bytes() as usize
    }

    pub(crate) fn pixel_bytes(&self) -> usize {
        (self.camera.pixel_bytes() + self.planes.planes().bytes() + self.planes.triangle().bytes()) as usize
    }
}

/// Fetches for each light which places it reaches.
fn read_masks(
    gpu: &Gpu,
    lights: &LightGrid,
    count: usize,
    view: &View,
    masks: &mut Vec<LightMask>,
) -> Result<(), GpuError> {
    let words = lights.mask_words() as usize;
    let bits: Vec<u32> = lights.lit().read(gpu, words * count)?;
    masks.resize(count, LightMask::default());
    for (mask, bits) in masks.iter_mut().zip(bits.chunks_exact(words.max(1))) {
        mask.set_words(view.width, view.height, bits);
    }
    Ok(())
}
