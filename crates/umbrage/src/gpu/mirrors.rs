use umbrage_gpu::shade::{FilmPlanes, Shade, ShadeSample};
use umbrage_gpu::{Band, Buffer, Geometry, Gpu, GpuError, Onward, Recorder};
use umbrage_rays::{KdTree, LightSource, SimdLevel, Triangles};
use umbrage_scene::{Frame, Mesh, OpaquePart};

use super::all_sources;
use super::tables::sample_rays;
use crate::engine::Staged;
use crate::sampling::Sample;
use crate::{Settings, Stats};

/// What is seen in mirrors, through a kd-tree that the CPU builds.
#[derive(Debug)]
pub(super) struct Mirrors {
    tree: KdTree,
    /// Of what lets light through.
    passed: KdTree,
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
        let tree = || KdTree::with_level(SimdLevel::default());
        Self { tree: tree(), passed: tree(), onward: Onward::new(gpu) }
    }

    /// Rebuilds the trees.
    pub(super) fn build(&mut self, gpu: &Gpu, frame: &Frame) -> Result<(), GpuError> {
        self.tree.build(frame.triangles());
        self.onward.build(gpu, &self.tree)?;
        if !frame.is_see_through() {
            return Ok(());
        }
        let Mesh { triangles, material_of_triangle, .. } = &*frame.mesh;
        let lets_light_through: Vec<bool> =
            frame.materials.materials.iter().map(|material| material.shadow_part() != OpaquePart::All).collect();
        let is_some = |id: &u32| lets_light_through[material_of_triangle[*id as usize] as usize];
        let ids: Vec<u32> = (0..triangles.len() as u32).filter(is_some).collect();
        let indices: Vec<[u32; 3]> = ids.iter().map(|&id| triangles[id as usize]).collect();
        self.passed.build(Triangles { positions: &frame.positions, indices: &indices });
        self.onward.build_passed(gpu, &self.passed, &ids)
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
        onward.start(gpu, band, sample.offset_pixels, planes, true)?;
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
        let of_rays = following(staged.settings, sample, sample_rays(band, sample));
        if !staged.frame.is_see_through() {
            onward.start(gpu, band, sample.offset_pixels, planes, false)?;
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
pub(super) fn following(settings: &Settings, sample: &Sample, rays: ShadeSample) -> ShadeSample {
    let Settings { bounces, least_contribution, .. } = *settings;
    ShadeSample { bounces, least_contribution, number: sample.index, ..rays }
}
