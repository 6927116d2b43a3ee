//! A scene's triangles and the structures that answer questions about them, each brought up to date when it is used.

use std::collections::BTreeSet;

use glam::{DAffine3, DVec3, Vec3};
use umbrage::rays::{
    Bvh, DirectGrids, ImageTooLarge, LightSource, Lit, LitBits, LitShare, Nearest, Omitted, Opaque, Ray, RayMasks,
    Rays, Receivers, Scan, Scanned, Scanner, SeenPixels, Shot, Structure, Trace, TracedBy, Tracer, Triangles, Wanted,
};
use umbrage::scene::{BadInstance, Instance, Instances};

use super::answers::Answers;
use super::arguments::MaskedSweep;
use super::keys::Keys;
use super::masks::TriangleMasks;
use super::questions::MaskedRays;
use crate::camera::PixelRays;

/// The state of a scene.
#[derive(Debug, Default)]
pub(super) struct State {
    pub(super) instances: Instances,
    masks: TriangleMasks,
    /// Ids of geometries that were taken out: they have no triangles.
    pub(super) removed: BTreeSet<usize>,
    tracer: Tracer,
    grids: DirectGrids,
    /// Whether the grids are up to date.
    are_grids_current: bool,
    nearest: Nearest,
    is_nearest_current: bool,
    /// The structures that answered the pieces of the last `cast_rays`.
    pub(super) answered: Vec<TracedBy>,
}

impl State {
    /// No meshes, and coordinates that count from a point of the world.
    pub(super) fn with_origin(origin: DVec3) -> Self {
        Self { instances: Instances::with_origin(origin), ..Self::default() }
    }

    /// The meshes, to change them.
    pub(super) fn change(&mut self) -> &mut Instances {
        self.tracer.forget();
        (self.are_grids_current, self.is_nearest_current) = (false, false);
        &mut self.instances
    }

    /// Adds a mesh with a transform and a mask.
    ///
    /// # Errors
    /// As [`Instances::add`].
    pub(super) fn add(
        &mut self,
        vertices: &[Vec3],
        triangles: &[[u32; 3]],
        world_from_object: Option<DAffine3>,
        mask: u32,
    ) -> Result<u32, BadInstance> {
        let id = self.change().add("", vertices, triangles)?;
        self.masks.add(self.instances.all()[id as usize].triangles(), mask);
        if let Some(matrix) = world_from_object {
            self.instances.set_transform(id, matrix);
        }
        Ok(id)
    }

    /// The same meshes, without built structures.
    pub(super) fn copy(&self) -> Self {
        let Self { instances, masks, removed, .. } = self;
        Self { instances: instances.clone(), masks: masks.clone(), removed: removed.clone(), ..Self::default() }
    }

    /// The mask of a geometry.
    pub(super) fn mask(&self, geometry: usize) -> u32 {
        self.masks.of(self.instances.all()[geometry].triangles())
    }

    /// Skips an id, such as that of a removed geometry.
    ///
    /// # Errors
    /// As [`Instances::add`].
    pub(super) fn skip(&mut self, geometry: usize) -> Result<(), BadInstance> {
        self.removed.insert(geometry);
        self.add(&[], &[], None, u32::MAX).map(drop)
    }

    /// Removes a geometry: all others are added anew, with their old ids.
    ///
    /// # Errors
    /// None, as there are fewer vertices and triangles than before.
    pub(super) fn remove(&mut self, geometry: u32) -> Result<(), BadInstance> {
        let origin = self.instances.origin();
        let old = std::mem::replace(self.change(), Instances::with_origin(origin));
        let masks = std::mem::take(&mut self.masks);
        self.removed.insert(geometry as usize);
        for (id, instance) in (0..).zip(old.all()) {
            if self.removed.contains(&(id as usize)) {
                self.add(&[], &[], None, u32::MAX)?;
                continue;
            }
            let (vertices, triangles) = old.mesh(id);
            let matrix = instance.world_from_object();
            let matrix = (matrix != DAffine3::from_translation(origin)).then_some(matrix);
            self.add(vertices, &triangles.collect::<Vec<_>>(), matrix, masks.of(instance.triangles()))?;
        }
        Ok(())
    }

    /// Nearest points, and their triangles.
    pub(super) fn nearest(&mut self) -> (&mut Nearest, Triangles<'_>) {
        let triangles = self.instances.triangles();
        if !std::mem::replace(&mut self.is_nearest_current, true) {
            self.nearest.build(triangles);
        }
        (&mut self.nearest, triangles)
    }

    /// The hierarchy, its triangles and their masks.
    pub(super) fn rays(&mut self) -> (&Bvh, Triangles<'_>, &TriangleMasks) {
        let triangles = self.instances.triangles();
        (self.tracer.hierarchy(triangles), triangles, &self.masks)
    }

    fn scanner(&mut self) -> (&mut Scanner, Triangles<'_>, &TriangleMasks) {
        let triangles = self.instances.triangles();
        (self.tracer.scanner(triangles), triangles, &self.masks)
    }

    /// The hits of any rays, and the structure that found them.
    pub(super) fn trace(&mut self, rays: Rays<'_>, masks: RayMasks<'_>, wanted: Wanted) -> (Scanned, TracedBy) {
        let mut traced = Scanned::default();
        let trace = Trace { wanted, masks: self.masks.with(masks), ..Trace::new(self.instances.triangles(), rays) };
        let by = self.tracer.trace(&trace, &mut traced);
        (traced, by)
    }

    /// Whether each ray hits anything between two t.
    pub(super) fn hits_any(&mut self, (rays, masks): MaskedRays<'_>, [t_min, t_max]: [f64; 2]) -> Vec<bool> {
        let behind;
        let rays = if t_min < 0.0 {
            // Arrays of numbers are rays for t above zero.
            behind = (0..rays.len()).map(|index| Ray { t_min, t_max, ..rays.get(index) }).collect::<Vec<_>>();
            Rays::from(&behind)
        } else {
            rays
        };
        let mut hit = Vec::new();
        let masks = self.masks.with(masks);
        let trace = Trace { t_min, t_max, masks, ..Trace::new(self.instances.triangles(), rays) };
        self.tracer.hits_any(&trace, &mut hit);
        hit
    }

    /// The number of triangles that each ray hits.
    pub(super) fn count_hits(&mut self, (rays, masks): MaskedRays<'_>) -> Vec<u32> {
        let mut counts = Vec::new();
        let trace = Trace { masks: self.masks.with(masks), ..Trace::new(self.instances.triangles(), rays) };
        self.tracer.count_hits(&trace, &mut counts);
        counts
    }

    /// The ids among all triangles of triangles of geometries.
    ///
    /// # Errors
    /// The geometry or triangle that isn't there.
    pub(super) fn ids(&self, geometries: &[u32], triangles: &[u32]) -> Result<Vec<u32>, String> {
        let all = self.instances.all();
        let id = |(&geometry, &triangle): (&u32, &u32)| {
            if geometry == Scanned::NONE || triangle == Scanned::NONE {
                return Ok(Scanned::NONE);
            }
            let range = all.get(geometry as usize).map(Instance::triangles);
            let range = range.ok_or_else(|| {
                let count = all.len();
                format!("geometry_ids: expected ids below {count}, the number of geometries, found {geometry}")
            })?;
            if triangle as usize >= range.len() {
                let count = range.len();
                return Err(format!(
                    "primitive_ids: expected ids below {count}, the number of triangles of geometry {geometry}, found {triangle}"
                ));
            }
            Ok((range.start + triangle as usize) as u32)
        };
        geometries.iter().zip(triangles).map(id).collect()
    }

    /// The triangles that no ray can hit.
    pub(super) fn omitted(&self) -> Omitted {
        self.instances.triangles().omitted()
    }

    /// The hits of a sweep's directions, with the sweep's mask.
    pub(super) fn scan(
        &mut self,
        (sweep, mask): MaskedSweep<'_>,
        [t_min, t_max]: [f64; 2],
        returns: usize,
        wanted: Wanted,
    ) -> Scanned {
        let (scanner, triangles, masks) = self.scanner();
        let (masks, mut scanned) = (masks.with(RayMasks::All(mask)), Scanned::default());
        let sweeps = [sweep];
        let scan = Scan { t_min, t_max, masks, wanted, ..Scan::new(triangles, &sweeps) };
        scanner.scan(&scan, returns, &mut scanned);
        scanned
    }

    /// Which directions hit anything.
    pub(super) fn scan_any(&mut self, (sweep, mask): MaskedSweep<'_>, [t_min, t_max]: [f64; 2], hit: &mut Vec<bool>) {
        let (scanner, triangles, masks) = self.scanner();
        let (masks, mut bits) = (masks.with(RayMasks::All(mask)), Vec::new());
        scanner.hits_any(&Scan { t_min, t_max, masks, ..Scan::new(triangles, &[sweep]) }, &mut bits);
        spread_bits(&bits, sweep.directions.len(), hit);
    }

    /// The hits of an image's pixels, which are square.
    pub(super) fn see(&mut self, image: &PixelRays, mask: u32, keys: Keys) -> Result<Answers, ImageTooLarge> {
        let Self { instances, masks, grids, are_grids_current, .. } = self;
        let triangles = instances.triangles();
        let opacity = &masks.with(RayMasks::All(mask)).opacity(mask, &Opaque);
        if !std::mem::replace(are_grids_current, true) {
            grids.build(triangles);
        }
        let mut seen = SeenPixels::default();
        let &PixelRays { view, offset_pixels, .. } = image;
        grids.see(&Shot { offset_pixels, opacity, ..Shot::new(triangles, view) }, &mut seen)?;
        let [height, width] = image.shape();
        let id = |pixel: usize| seen.triangle_at((pixel % width) as u32, (pixel / width) as u32);
        if keys.t() || keys.weights() {
            Ok(Answers::of_rays(triangles, width * height, id, |pixel| image.ray(pixel)))
        } else {
            Ok(Answers::of_ids(width * height, id))
        }
    }

    /// The points that lights reach: for the first light all points, then for the next one.
    pub(super) fn lit(
        &mut self,
        receivers: Receivers<'_>,
        lights: &[LightSource],
        masks: RayMasks<'_>,
        lit: &mut Vec<bool>,
    ) {
        let (scanner, triangles, of_triangles) = self.scanner();
        let (masks, mut bits) = (of_triangles.with(masks), LitBits::default());
        scanner.lit(&Lit { masks, ..Lit::new(triangles, receivers) }, lights, &mut bits);
        for light in 0..bits.lights() {
            spread_bits(bits.of_light(light), bits.points(), lit);
        }
    }

    /// The share of each triangle's area that a light reaches.
    pub(super) fn lit_areas(&mut self, light: &LightSource, mask: u32, samples: u32, shares: &mut Vec<LitShare>) {
        let (scanner, triangles, masks) = self.scanner();
        scanner.lit_areas(triangles, masks.with(RayMasks::All(mask)), std::slice::from_ref(light), samples, shares);
    }
}

/// Appends a value for each of `count` bits.
pub(super) fn spread_bits(words: &[u64], count: usize, values: &mut Vec<bool>) {
    let end = values.len() + count;
    values.reserve(words.len() * 64);
    for &word in words {
        values.extend((0..64).map(|bit| word >> bit & 1 == 1));
    }
    values.truncate(end);
}
