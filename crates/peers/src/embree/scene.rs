use std::ptr;
use std::sync::Arc;

use glam::Vec3;

use super::filter::{keep_casting, keep_solid};
use super::point_query::closest;
use super::{Embree, Error, Handle};
use crate::packet::{RayHitPacket, SingleRay, Valid};
use crate::posed::Posed;

/// Method to rebuild a scene for each frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BuildMethod {
    /// Builder of the hierarchy.
    pub quality: Quality,
    /// Whether one dynamic scene is kept, so that its memory is reused; otherwise each frame has a new scene.
    pub kept: bool,
}

/// Builder of a hierarchy.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quality {
    /// By Morton codes.
    Low,
    /// By the binned surface area heuristic.
    Medium,
    /// As `Medium` in the first frame; later frames refit that hierarchy's boxes to the moved triangles. For a kept
    /// scene, whose triangles keep their vertex indices.
    Refit,
}

/// Embree's hierarchy over a frame's triangles.
#[derive(Debug)]
pub struct Scene {
    embree: Arc<Embree>,
    method: BuildMethod,
    built: Option<Built>,
}

#[derive(Debug)]
struct Built {
    scene: Handle,
    opaque: Handle,
    /// Geometry of the triangles with filters, if there are any.
    asked: Option<Handle>,
    posed: Arc<Posed>,
    /// The frame whose indices Embree has, if it refits: other indices would make it build.
    joined: Option<Arc<Posed>>,
}

// From `rtcore_common.h`, `rtcore_buffer.h`, `rtcore_geometry.h` and `rtcore_scene.h`.
const TRIANGLE: i32 = 0;
const INDEX_BUFFER: i32 = 0;
const VERTEX_BUFFER: i32 = 1;
const FORMAT_UINT3: i32 = 0x5003;
const FORMAT_FLOAT3: i32 = 0x9003;
const DYNAMIC: i32 = 1;

// SAFETY: many threads may trace through a scene at once; methods that change it take `&mut self`.
unsafe impl Send for Scene {}
// SAFETY: as above.
unsafe impl Sync for Scene {}

impl Scene {
    /// A scene without triangles.
    #[must_use]
    pub fn new(embree: &Arc<Embree>, method: BuildMethod) -> Self {
        Self { embree: Arc::clone(embree), method, built: None }
    }

    /// Releases the old scene, so that the next build's time excludes that; does nothing if the scene is kept.
    pub fn clear(&mut self) {
        if !self.method.kept {
            self.release();
        }
    }

    /// Builds the hierarchy over a frame's triangles, on Embree's own threads.
    ///
    /// # Errors
    /// If Embree reports one; the scene is then empty.
    pub fn build(&mut self, posed: &Arc<Posed>) -> Result<(), Error> {
        self.clear();
        if self.built.as_ref().is_some_and(|built| built.asked.is_some() != posed.asked().is_some()) {
            self.release();
        }
        if self.built.is_none() {
            self.built = Some(self.make(posed)?);
        }
        let functions = &self.embree.functions;
        if let Some(built) = &mut self.built {
            let positions = posed.positions();
            let is_joined = built.joined.is_some();
            // SAFETY: the handles are alive. The buffers have the given lengths and are kept by `built.posed`, or the
            // indices by `built.joined`, as are the filters' data; old ones are released only after Embree has the new ones.
            unsafe {
                let share = |geometry, indices: &[[u32; 3]]| {
                    let share = functions.set_shared_buffer;
                    let (vertices, corners) = (positions.as_ptr().cast(), indices.as_ptr().cast());
                    share(geometry, VERTEX_BUFFER, 0, FORMAT_FLOAT3, vertices, 0, 12, positions.len());
                    if !is_joined {
                        share(geometry, INDEX_BUFFER, 0, FORMAT_UINT3, corners, 0, 12, indices.len());
                    }
                };
                share(built.opaque, posed.opaque());
                (functions.commit_geometry)(built.opaque);
                if let Some((geometry, asked)) = built.asked.zip(posed.asked()) {
                    share(geometry, &asked.indices);
                    (functions.set_user_data)(geometry, ptr::from_ref(asked).cast());
                    (functions.commit_geometry)(geometry);
                }
                (functions.commit_scene)(built.scene);
            }
            built.posed = Arc::clone(posed);
            if self.method.quality == Quality::Refit {
                built.joined.get_or_insert_with(|| Arc::clone(posed));
            }
        }
        self.embree.check("build a scene").inspect_err(|_| self.release())
    }

    /// Makes an empty scene with one or two empty geometries.
    fn make(&self, posed: &Arc<Posed>) -> Result<Built, Error> {
        let Embree { functions, device, .. } = &*self.embree;
        let quality = match self.method.quality {
            Quality::Low => 0,
            Quality::Medium => 1,
            Quality::Refit => 3,
        };
        let failed =
            || self.embree.check("make a scene").err().unwrap_or(Error::Failed { what: "make a scene", code: 0 });
        // SAFETY: the device is alive. The handles are released once: those of `Built` in `release`, and others here.
        unsafe {
            let scene = (functions.new_scene)(*device).ok_or_else(failed)?;
            let geometry = || {
                let geometry = (functions.new_geometry)(*device, TRIANGLE)?;
                (functions.set_geometry_quality)(geometry, quality);
                (functions.attach_geometry)(scene, geometry);
                Some(geometry)
            };
            let opaque = geometry();
            let asked = if posed.asked().is_some() { geometry().map(Some) } else { Some(None) };
            let Some((opaque, asked)) = opaque.zip(asked) else {
                // The scene holds its attached geometries.
                opaque.into_iter().chain(asked.flatten()).for_each(|geometry| (functions.release_geometry)(geometry));
                (functions.release_scene)(scene);
                return Err(failed());
            };
            if let Some(asked) = asked {
                (functions.set_intersect_filter)(asked, Some(keep_solid));
                (functions.set_occluded_filter)(asked, Some(keep_casting));
            }
            // Scenes have no quality for refitting.
            (functions.set_scene_quality)(scene, quality.min(1));
            (functions.set_scene_flags)(scene, if self.method.kept { DYNAMIC } else { 0 });
            Ok(Built { scene, opaque, asked, posed: Arc::clone(posed), joined: None })
        }
    }

    fn release(&mut self) {
        if let Some(Built { scene, opaque, asked, .. }) = self.built.take() {
            let functions = &self.embree.functions;
            // SAFETY: each handle is released once; nobody traces through them, since this has `&mut self`.
            unsafe {
                [opaque].into_iter().chain(asked).for_each(|geometry| (functions.release_geometry)(geometry));
                (functions.release_scene)(scene);
            }
        }
    }

    /// Finds the nearest hits of the `valid` rays; misses stay unchanged.
    #[inline]
    pub fn nearest(&self, valid: &Valid, packet: &mut RayHitPacket) {
        if let Some(Built { scene, .. }) = self.built {
            // SAFETY: the scene was committed, and is not changed while it is borrowed.
            unsafe { self.embree.trace.nearest(scene, valid, packet, self.embree.is_sixteen) }
        }
    }

    /// Finds the nearest hit of a single ray; a miss stays unchanged.
    #[inline]
    pub fn nearest_of_one(&self, ray: &mut SingleRay) {
        if let Some(Built { scene, .. }) = self.built {
            // SAFETY: as for `nearest`.
            unsafe { self.embree.trace.nearest_of_one(scene, ray) }
        }
    }

    /// Sets `t_far` of the `valid` rays that hit anything to −∞.
    #[inline]
    pub fn occluded(&self, valid: &Valid, packet: &mut RayHitPacket) {
        if let Some(Built { scene, .. }) = self.built {
            // SAFETY: as for `nearest`.
            unsafe { self.embree.trace.occluded(scene, valid, packet, self.embree.is_sixteen) }
        }
    }

    /// Finds the triangle that is nearest to a point, whatever its opacity: its name for [`Posed::triangle`], and its distance
    /// in world units, in f32. `None` if there is no triangle.
    #[inline]
    #[must_use]
    pub fn closest_point(&self, point: Vec3) -> Option<(u32, f32)> {
        let Built { scene, posed, .. } = self.built.as_ref()?;
        closest(posed, point, &|query, context, visit, user| {
            // SAFETY: as for `nearest`; query and context have the header's layouts and outlive the call.
            unsafe { (self.embree.functions.point_query)(*scene, query, context, Some(visit), user) };
        })
    }
}

impl Drop for Scene {
    fn drop(&mut self) {
        self.release();
    }
}
