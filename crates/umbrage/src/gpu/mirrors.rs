use umbrage_gpu::shade::{FilmPlanes, Shade, ShadeSample};
use umbrage_gpu::{Band, Buffer, Geometry, Gpu, GpuError, Onward, Recorder};
use umbrage_rays::{KdTree, LightSource, SimdLevel};
use umbrage_scene::Frame;

use super::all_sources;
use super::tables::sample_rays;
use crate::engine::Staged;
use crate::sampling::Sample;
use crate::{Settings, Stats};

/// What is seen in mirrors, through a kd-tree that the CPU builds.
#[derive(Debug)]
pub(super) struct Mirrors {
    tree: KdTree,
    onward: Onward,
}

/// What mirrors show of a frame's sample.
pub(super) struct Mirrored<'a> {
    pub(super) staged: &'a Staged<'a>,
    pub(super) band: &'a Band,
    pub(super) sample: &'a Sample,
    pub(super) geometry: &'a Geometry,
    /// What the camera's rays have seen.
    pub(super) seen: &'a Buffer,
}

impl Mirrors {
    /// Kernels take long to compile, so it is made when a frame has mirrors.
    pub(super) fn new(gpu: &Gpu) -> Self {
        Self { tree: KdTree::with_level(SimdLevel::default()), onward: Onward::new(gpu) }
    }

    /// Rebuilds the tree.
    pub(super) fn build(&mut self, gpu: &Gpu, frame: &Frame) -> Result<(), GpuError> {
        self.tree.build(frame.triangles());
        self.onward.build(gpu, &self.tree)
    }

    /// Finds what colours light takes on its way to what a sample's camera rays see, where something is seen through, and which
    /// lights reach it: where that is.
    pub(super) async fn tint(
        &mut self,
        gpu: &Gpu,
        mirrored: &Mirrored<'_>,
        lit: &Buffer,
        shade: &mut Shade,
        planes: &FilmPlanes,
        stats: &mut Stats,
    ) -> Result<(), GpuError> {
        let Self { onward, .. } = self;
        let Mirrored { staged, band, sample, geometry, seen } = *mirrored;
        onward.start(gpu, band, sample.offset_pixels, planes)?;
        onward.prepare_tints(gpu, &all_sources(staged.lights))?;
        shade.prepare_first_tints(gpu, &sample_rays(band, sample))?;
        loop {
            let mut recorder = Recorder::new(gpu);
            onward.record_tints(gpu, &mut recorder, geometry, [planes.planes(), seen, lit], shade);
            let done = recorder.submit().await?;
            if onward.finish_tints(gpu, &done)? {
                done.times.iter().for_each(|stage| stats.add(stage.name, stage.milliseconds));
                return Ok(());
            }
        }
    }

    /// Which lights reach what the camera sees, and where that says in what colours.
    pub(super) fn tinted(&self, lights: usize) -> (&Buffer, u32) {
        (self.onward.lit(), self.onward.first_tints_word(lights))
    }

    /// Adds to the film what mirrors show, generation by generation.
    pub(super) async fn follow(
        &mut self,
        gpu: &Gpu,
        mirrored: &Mirrored<'_>,
        shade: &mut Shade,
        planes: &FilmPlanes,
        stats: &mut Stats,
    ) -> Result<(), GpuError> {
        let Self { onward, .. } = self;
        let Mirrored { staged, band, sample, geometry, seen } = *mirrored;
        let film = planes.planes();
        let sources: Vec<Option<LightSource>> = all_sources(staged.lights);
        let of_rays = following(staged.settings, sample_rays(band, sample));
        if planes.ways() != Onward::ALL_WAYS {
            onward.start(gpu, band, sample.offset_pixels, planes)?;
        }
        loop {
            let mut recorder = Recorder::new(gpu);
            onward.record_count(gpu, &mut recorder, film);
            let done = recorder.submit().await?;
            let rays = onward.counted(&done)?;
            if rays == 0 {
                break;
            }
            onward.prepare(gpu, rays, &sources)?;
            shade.prepare_onward(gpu, &of_rays, onward)?;
            loop {
                let mut recorder = Recorder::new(gpu);
                onward.record_rays(gpu, &mut recorder, geometry, [film, seen], shade);
                let done = recorder.submit().await?;
                if onward.finish(gpu, &done)? {
                    done.times.iter().for_each(|stage| stats.add(stage.name, stage.milliseconds));
                    break;
                }
            }
            let mut recorder = Recorder::new(gpu);
            recorder.stage("shade", |pass| shade.record_onward(gpu, pass, onward, geometry));
            onward.record_add(gpu, &mut recorder, film);
            let done = recorder.submit().await?;
            done.times.iter().for_each(|stage| stats.add(stage.name, stage.milliseconds));
            onward.advance(gpu)?;
        }
        Ok(())
    }

    pub(super) fn bytes(&self) -> [u64; 2] {
        self.onward.bytes()
    }
}

/// The rays of a sample, some of which go on.
pub(super) fn following(settings: &Settings, sample: ShadeSample) -> ShadeSample {
    let Settings { bounces, least_contribution, .. } = *settings;
    ShadeSample { bounces, least_contribution, ..sample }
}
