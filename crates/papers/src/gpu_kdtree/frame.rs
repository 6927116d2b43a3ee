use bytemuck::{Pod, Zeroable};
use glam::Vec3;
use umbrage_rays::{LightSource, View};

use super::raster::Raster;
use umbrage_gpu::internals::{ExactView, light_words};
use umbrage_gpu::rays::{RayRecords, RayTracer};
use umbrage_gpu::{Buffer, Done, Geometry, Gpu, GpuError, Groups, Kernel, Recorder};

use crate::{KdNodes, KdTracerOptions};

/// A material: Lambert's, with a mirror over it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct KdMaterial {
    /// Diffuse reflectance, and the tint of mirrored light.
    pub color: [f32; 3],
    /// Mirrored fraction of light, 0 to 1.
    pub mirror: f32,
}

/// How primary hits are found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum KdPrimary {
    /// By rays through the tree, exactly.
    Traced,
    /// By rasterisation, which isn't exact where triangles meet; only other rays are traced (Horn et al. 2007, §4).
    Rasterised,
}

/// Parameters of a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KdScenery {
    /// The only light, which casts shadows. A spot light is a point light here, and none grows weaker with distance.
    pub light: LightSource,
    /// Its colour.
    pub light_color: Vec3,
    /// Ambient radiance, without shadows.
    pub ambient: Vec3,
    /// Radiance of rays that hit nothing.
    pub sky: Vec3,
    /// Maximum number of mirrors on a path.
    pub bounces: u32,
    /// How primary hits are found.
    pub primary: KdPrimary,
}

/// Frames whose rays are all made and traced on the GPU: primary rays, a shadow ray from each hit, and mirrored rays to
/// any depth. Nothing is read back in between.
#[derive(Debug)]
pub struct KdFrame {
    tracer: RayTracer,
    eye: Kernel,
    bounce: Kernel,
    size_bounced: Kernel,
    lighten: Kernel,
    surface: Kernel,
    raster: Raster,
    eye_view: Buffer,
    /// Uniforms for all bounces but the last, and for the last.
    bounce_views: [Buffer; 2],
    surface_view: Buffer,
    materials: Buffer,
    /// Rays of one bounce and of the next, alternating.
    rays: [RayRecords; 2],
    shadows: RayRecords,
    film: Buffer,
    /// Set by [`KdFrame::prepare`].
    size: [u32; 2],
    bounces: u32,
    primary: KdPrimary,
}

/// Uniform of `eye.wgsl`.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
struct KdEye {
    view: ExactView,
    packet: u32,
    unused: [u32; 3],
}

/// Uniform of `bounce.wgsl`.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
struct KdBounce {
    light: [u32; 3],
    is_directional: u32,
    light_color: [f32; 3],
    goes_on: u32,
    ambient: [f32; 3],
    packet: u32,
    sky: [f32; 3],
    pixels: u32,
}

/// Uniform of `surface.wgsl`.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
struct KdSurface {
    width: u32,
    row_words: u32,
    unused: [u32; 2],
}

impl KdFrame {
    /// Makes the stages.
    #[must_use]
    pub fn new(gpu: &Gpu, options: KdTracerOptions) -> Self {
        let kernel = |path, entry| Kernel::of_modules(gpu, super::MODULES, path, entry, &[]);
        Self {
            tracer: RayTracer::new(gpu, options),
            eye: kernel("kdtree::eye", "eye"),
            bounce: kernel("kdtree::bounce", "bounce"),
            size_bounced: kernel("kdtree::bounce", "size_bounced"),
            lighten: kernel("kdtree::lighten", "lighten"),
            surface: kernel("kdtree::surface", "surface"),
            raster: Raster::new(gpu),
            eye_view: Buffer::uniform(gpu, "view"),
            bounce_views: [Buffer::uniform(gpu, "scenery"), Buffer::uniform(gpu, "scenery at the last")],
            surface_view: Buffer::uniform(gpu, "rasterised image"),
            materials: Buffer::storage(gpu, "kd-tree materials"),
            rays: [RayRecords::new(gpu), RayRecords::new(gpu)],
            shadows: RayRecords::new(gpu),
            film: Buffer::storage(gpu, "kd-tree film"),
            size: [0; 2],
            bounces: 0,
            primary: KdPrimary::Traced,
        }
    }

    /// The tracer.
    #[must_use]
    pub fn tracer(&self) -> &RayTracer {
        &self.tracer
    }

    /// The tracer, for other rays.
    pub fn tracer_mut(&mut self) -> &mut RayTracer {
        &mut self.tracer
    }

    /// Sets the traversal for the next frames.
    pub fn set_options(&mut self, gpu: &Gpu, options: KdTracerOptions) {
        self.tracer.set_options(gpu, options);
    }

    /// Prepares a frame: parameters and room. A triangle's material is the one of `materials` at its number (see
    /// [`TriangleFlags`](umbrage_gpu::TriangleFlags); the flags are ignored: all triangles are opaque).
    ///
    /// # Errors
    /// If a stage needs more bytes than one buffer of the device can have.
    pub fn prepare(
        &mut self,
        gpu: &Gpu,
        tree: &KdNodes,
        view: &View,
        scenery: &KdScenery,
        materials: &[KdMaterial],
    ) -> Result<(), GpuError> {
        let View { width, height, .. } = *view;
        let pixels = width * height;
        let rays = 64 * width.div_ceil(8) * height.div_ceil(8);
        let packet = self.tracer.options().lanes();
        (self.size, self.bounces, self.primary) = ([width, height], scenery.bounces, scenery.primary);
        self.eye_view.write(gpu, &[KdEye { view: view.into(), packet, unused: [0; 3] }])?;
        let [x, y, z, is_directional] = light_words(&scenery.light);
        for (buffer, goes_on) in self.bounce_views.iter_mut().zip([1, 0]) {
            let bounce = KdBounce {
                light: [x, y, z],
                is_directional,
                light_color: scenery.light_color.to_array(),
                goes_on,
                ambient: scenery.ambient.to_array(),
                packet,
                sky: scenery.sky.to_array(),
                pixels,
            };
            buffer.write(gpu, &[bounce])?;
        }
        if scenery.primary == KdPrimary::Rasterised {
            let row_words = Raster::row_bytes(width) / 4;
            self.surface_view.write(gpu, &[KdSurface { width, row_words, unused: [0; 2] }])?;
            self.raster.prepare(gpu, view, tree.reach())?;
        }
        self.materials.write(gpu, materials)?;
        for records in self.rays.iter_mut().chain([&mut self.shadows]) {
            records.reserve(gpu, rays)?;
        }
        self.film.reserve(gpu, 32 * u64::from(pixels))?;
        self.tracer.prepare(gpu, rays, 2 * (scenery.bounces + 1))
    }

    /// Records all stages.
    ///
    /// # Panics
    /// If it wasn't prepared.
    pub fn record(&mut self, gpu: &Gpu, recorder: &mut Recorder<'_>, geometry: &Geometry, tree: &KdNodes) {
        let [width, height] = self.size;
        let blocks = Groups::Flat(width.div_ceil(8) * height.div_ceil(8));
        let buffers = [&self.eye_view, self.rays[0].buffer(), &self.film];
        recorder.stage("eye", |pass| self.eye.dispatch(gpu, pass, &buffers, blocks));
        for bounce in 0..=self.bounces {
            let [even, odd] = &self.rays;
            let (rays, next) = if bounce % 2 == 0 { (even, odd) } else { (odd, even) };
            if bounce == 0 && self.primary == KdPrimary::Rasterised {
                self.raster.record(gpu, recorder, geometry);
                rays.record_sizes(recorder);
                let (seen, hits) = (self.raster.seen(), self.tracer.hits());
                let buffers =
                    [&self.surface_view, rays.buffer(), geometry.triangles(), geometry.positions(), seen, hits];
                recorder.stage("surface", |pass| self.surface.dispatch(gpu, pass, &buffers, blocks));
            } else {
                self.tracer.record_nearest(gpu, recorder, geometry, tree, rays);
            }

            recorder.clear_words(next.buffer(), RayRecords::HEADER);
            recorder.clear_words(self.shadows.buffer(), RayRecords::HEADER);
            let view = &self.bounce_views[usize::from(bounce == self.bounces)];
            let buffers = [
                view,
                rays.buffer(),
                self.tracer.hits(),
                geometry.triangles(),
                geometry.positions(),
                &self.materials,
                next.buffer(),
                self.shadows.buffer(),
                &self.film,
            ];
            recorder.stage("bounce", |pass| {
                self.bounce.dispatch(gpu, pass, &buffers, Groups::Indirect(rays.sizes(), RayRecords::GROUPS));
                self.size_bounced.dispatch(gpu, pass, &buffers, Groups::Flat(1));
            });

            self.tracer.record_blocked(gpu, recorder, geometry, tree, &self.shadows);
            let buffers = [self.shadows.buffer(), self.tracer.shadows(), &self.film];
            let groups = Groups::Indirect(self.shadows.sizes(), RayRecords::GROUPS);
            recorder.stage("lighten", |pass| self.lighten.dispatch(gpu, pass, &buffers, groups));
        }
    }

    /// As [`RayTracer::finish`].
    ///
    /// # Errors
    /// As there.
    pub fn finish(&mut self, gpu: &Gpu, done: &Done) -> Result<bool, GpuError> {
        self.tracer.finish(gpu, done)
    }

    /// The image: four f32 for each pixel, row after row; red, green, blue and one. The rest of the buffer is the
    /// stages' own.
    #[must_use]
    pub fn film(&self) -> &Buffer {
        &self.film
    }

    /// The rays of the last bounce; their hits are in [`RayTracer::hits`].
    #[must_use]
    pub fn last_rays(&self) -> &RayRecords {
        &self.rays[self.bounces as usize % 2]
    }

    /// The shadow questions of the last bounce; their answers are in [`RayTracer::shadows`].
    #[must_use]
    pub fn last_shadows(&self) -> &RayRecords {
        &self.shadows
    }

    /// Bytes on the GPU, without textures.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        let records = self.rays.iter().chain([&self.shadows]).map(|records| records.buffer().bytes());
        records.sum::<u64>() + self.tracer.bytes() + self.film.bytes() + self.raster.seen().bytes()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu_kdtree::link;
    use crate::layout::{differences, layout, module};

    #[test]
    fn parameters_are_those_of_the_shaders() {
        let eye = layout!(KdEye { view, packet });
        let bounce = layout!(KdBounce { light, is_directional, light_color, goes_on, ambient, packet, sky, pixels });
        let surface = layout!(KdSurface { width, row_words, unused });
        for (path, layout) in [("kdtree::eye", eye), ("kdtree::bounce", bounce), ("kdtree::surface", surface)] {
            assert_eq!(differences(&module(&link(path)), &layout), [""; 0], "{path}");
        }
    }
}
