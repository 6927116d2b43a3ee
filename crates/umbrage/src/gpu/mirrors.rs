use std::sync::Arc;

use umbrage_gpu::shade::{FilmPlanes, Shade};
use umbrage_gpu::{Buffer, Geometry, Gpu, GpuError, Onward, OnwardLayers, OnwardLight, Recorder};
use umbrage_rays::{Bvh, Triangles};
use umbrage_scene::{Frame, Materials, Mesh, OpaquePart};

use super::{Turn, add_times};
use crate::Stats;
use crate::cpu::Kept;
use crate::plan::Plan;

/// Traces rays from mirrors through a hierarchy that the CPU builds.
#[derive(Debug)]
pub(super) struct Mirrors {
    hierarchy: Bvh,
    /// A hierarchy of the triangles that let light through.
    passed: Bvh,
    /// The triangles of the last build.
    kept: Kept,
    painted: Option<(Arc<Mesh>, Arc<Materials>)>,
    onward: Onward,
    light: OnwardLight,
}

/// The inputs for mirrors of a frame's sample.
pub(super) struct Mirrored<'a> {
    pub(super) turn: &'a Turn,
    pub(super) geometry: &'a Geometry,
    /// The camera rays' triangles.
    pub(super) seen: &'a Buffer,
}

impl Mirrors {
    /// Kernels take long to compile, so this is called only once a frame has mirrors.
    pub(super) fn new(gpu: &Gpu) -> Self {
        Self {
            hierarchy: Bvh::default(),
            passed: Bvh::default(),
            kept: Kept::default(),
            painted: None,
            onward: Onward::new(gpu, Plan::LAYERS),
            light: OnwardLight::default(),
        }
    }

    /// Forgets the state of the GPU, so that everything is uploaded again.
    pub(super) fn forget(&mut self) {
        self.painted = None;
    }

    /// Rebuilds the hierarchies, unless no triangle moves.
    pub(super) fn build(&mut self, gpu: &Gpu, frame: &Frame, light: OnwardLight) -> Result<(), GpuError> {
        let has_passed = self.light.takes_colors || !light.takes_colors;
        let is_painted = self.painted.as_ref().is_some_and(|(mesh, materials)| {
            Arc::ptr_eq(mesh, &frame.mesh) && Arc::ptr_eq(materials, &frame.materials)
        });
        self.light = light;
        if self.kept.are_still(frame.triangles()) && is_painted && has_passed {
            return Ok(());
        }
        // The mesh and materials are held, so that no others take their address; set only once all is uploaded.
        self.painted = None;
        self.hierarchy.build(frame.triangles());
        self.onward.build(gpu, &self.hierarchy)?;
        if light.takes_colors {
            self.build_passed(gpu, frame)?;
        }
        self.painted = Some((Arc::clone(&frame.mesh), Arc::clone(&frame.materials)));
        Ok(())
    }

    fn build_passed(&mut self, gpu: &Gpu, frame: &Frame) -> Result<(), GpuError> {
        let Mesh { triangles, material_of_triangle, .. } = &*frame.mesh;
        let lets_light_through: Vec<bool> =
            frame.materials.materials.iter().map(|material| material.shadow_part() != OpaquePart::All).collect();
        let is_some = |id: &u32| lets_light_through[material_of_triangle[*id as usize] as usize];
        let ids: Vec<u32> = (0..triangles.len() as u32).filter(is_some).collect();
        let indices: Vec<[u32; 3]> = ids.iter().map(|&id| triangles[id as usize]).collect();
        self.passed.build(Triangles { positions: &frame.positions, indices: &indices });
        self.onward.build_passed(gpu, &self.passed, &ids)
    }

    /// Traces the queries that come before shading a sample's camera rays: the colours of transmitted light, and ambient
    /// occlusion nearby. `lit` has the lights that reach the hits.
    pub(super) async fn ask_first(
        &mut self,
        gpu: &Gpu,
        mirrored: &Mirrored<'_>,
        lit: &Buffer,
        shade: &mut Shade,
        planes: &FilmPlanes,
        stats: &mut Stats,
    ) -> Result<(), GpuError> {
        let Self { onward, light, .. } = self;
        let Mirrored { turn, geometry, seen } = *mirrored;
        onward.start(gpu, &turn.band, turn.sample.offset_pixels, planes, *light)?;
        onward.prepare_first(gpu, &turn.sources)?;
        shade.prepare_first(gpu, &turn.rays(), *light)?;
        loop {
            let mut recorder = Recorder::new(gpu);
            onward.record_first(gpu, &mut recorder, geometry, [planes.planes(), seen, lit], shade);
            let done = recorder.submit().await?;
            if onward.finish_first(gpu, &done)? {
                add_times(stats, &done);
                return Ok(());
            }
        }
    }

    /// The lights that reach the camera's hits, and the word of that buffer where the light's colours begin.
    pub(super) fn asked(&self) -> (&Buffer, u32) {
        (self.onward.lit(), self.onward.tints_word())
    }

    /// Adds the radiance seen in mirrors to the film, generation by generation.
    pub(super) async fn follow(
        &mut self,
        gpu: &Gpu,
        mirrored: &Mirrored<'_>,
        shade: &mut Shade,
        planes: &FilmPlanes,
        stats: &mut Stats,
    ) -> Result<(), GpuError> {
        let Self { onward, light, .. } = self;
        let Mirrored { turn, geometry, seen } = *mirrored;
        let (film, of_rays) = (planes.planes(), turn.rays());
        if !light.is_asked_first() {
            onward.start(gpu, &turn.band, turn.sample.offset_pixels, planes, *light)?;
        }
        loop {
            let mut recorder = Recorder::new(gpu);
            onward.record_count(gpu, &mut recorder, film);
            let done = recorder.submit().await?;
            let rays = onward.counted(&done)?;
            if rays == 0 {
                break;
            }
            onward.prepare(gpu, rays, &turn.sources)?;
            shade.prepare_onward(gpu, &of_rays, onward)?;
            loop {
                let mut recorder = Recorder::new(gpu);
                onward.record_rays(gpu, &mut recorder, geometry, [film, seen], shade);
                let done = recorder.submit().await?;
                if onward.finish(gpu, &done)? {
                    add_times(stats, &done);
                    break;
                }
            }
            let mut recorder = Recorder::new(gpu);
            recorder.stage("shade", |pass| shade.record_onward(gpu, pass, onward, geometry));
            onward.record_add(gpu, &mut recorder, film);
            let done = recorder.submit().await?;
            add_times(stats, &done);
            onward.advance(gpu)?;
        }
        Ok(())
    }

    /// Bytes for triangles, on both sides, and for rays.
    pub(super) fn bytes(&self) -> [u64; 2] {
        let [triangles, rays] = self.onward.bytes();
        [triangles + self.kept.bytes() as u64, rays]
    }
}

impl Plan {
    const LAYERS: OnwardLayers =
        OnwardLayers { many: Self::MANY_LAYERS, least_part: Self::LEAST_PART, most: Self::MOST_LAYERS };

    /// Effects on light besides opaque shadows.
    pub(super) fn light(self) -> OnwardLight {
        OnwardLight { takes_colors: self.tints(), around: self.around }
    }

    /// Number of the film's planes for secondary rays.
    pub(super) fn ways(self) -> u32 {
        match () {
            () if self.mirrors && self.gloss => Onward::GLOSSY_WAYS,
            () if self.is_see_through && (self.bounces > 0 || self.around > 0.0) => Onward::ALL_WAYS,
            () if self.mirrors => Onward::MIRRORS,
            () => 0,
        }
    }

    /// Whether surfaces are shaded layer by layer, one behind the other: see-through ones without other secondary rays.
    pub(super) fn is_in_layers(self) -> bool {
        self.is_see_through && self.ways() == 0
    }
}
