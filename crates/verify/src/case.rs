use glam::{DVec2, Vec3};
use rayon::prelude::*;
use umbrage_rays::predicate::{HitPoint, ShadowRay, crossing};
use umbrage_rays::{Cone, Hit, LightSource, Opacity, Opaque, Parts, SeenPixels, Shifts, Shot, Sides, View};

use crate::views::OFFSET_PIXELS;
use crate::{Oracle, TestMesh};

/// What a camera and lights see of a mesh: a question whose answer the oracle knows.
pub struct Case {
    /// What is special about it.
    pub name: String,
    /// What there is.
    pub mesh: TestMesh,
    /// The camera.
    pub view: View,
    /// Where in each pixel its ray goes through.
    pub offset_pixels: DVec2,
    /// By how much more each ray is shifted.
    pub shifts: Shifts,
    /// Each with shadows.
    pub lights: Vec<LightSource>,
    /// What stops camera rays.
    pub opacity: Box<dyn Opacity + Send>,
    /// What stops shadow rays.
    pub shadow_opacity: Box<dyn Opacity + Send>,
    /// Which sides of triangles stop rays.
    pub sides: Sides<'static>,
    /// The part of each triangle, for structures that outlive a frame; they may be anything.
    pub part_of_triangle: Vec<u32>,
}

/// [`Sides`] of which more than half of the triangles have both, up to the 4096th; all that come later do.
pub const MIXED_SIDES: Sides<'static> = Sides::Each(&[0x5bd1_e995_cc9e_2d51; 64]);

/// What is true of each pixel of a [`Case`], or of one in so many, row by row.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Truth {
    /// What it shows; [`SeenPixels::NONE`] for nothing.
    pub triangle: Vec<u32>,
    /// For each light, whether it reaches that; false for nothing.
    pub lit: Vec<Vec<bool>>,
}

impl std::fmt::Debug for Case {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Case").field("name", &self.name).field("shot", &self.shot()).finish_non_exhaustive()
    }
}

impl Case {
    /// Opaque triangles of two sides, seen through about the middle of each pixel.
    #[must_use]
    pub fn new(name: impl Into<String>, mesh: TestMesh, view: View, lights: &[LightSource]) -> Self {
        let part_of_triangle = (0..mesh.indices.len() as u32).map(|id| id / 5 % 3).collect();
        Self {
            name: name.into(),
            mesh,
            view,
            offset_pixels: OFFSET_PIXELS,
            shifts: Shifts::NONE,
            lights: lights.into(),
            opacity: Box::new(Opaque),
            shadow_opacity: Box::new(Opaque),
            sides: Sides::Both,
            part_of_triangle,
        }
    }

    /// What moves together.
    #[must_use]
    pub fn parts(&self) -> Parts<'_> {
        Parts { of_triangle: &self.part_of_triangle, objects: &[] }
    }

    /// The question to a structure.
    #[must_use]
    pub fn shot(&self) -> Shot<'_> {
        Shot {
            triangles: self.mesh.triangles(),
            view: self.view,
            offset_pixels: self.offset_pixels,
            shifts: self.shifts,
            opacity: &*self.opacity,
            shadow_opacity: &*self.shadow_opacity,
            sides: self.sides,
        }
    }

    /// Columns and rows, row by row.
    pub fn pixels(&self) -> impl Iterator<Item = (u32, u32)> + use<> {
        let View { width, height, .. } = self.view;
        (0..height).flat_map(move |y| (0..width).map(move |x| (x, y)))
    }

    /// The truth, by asking the oracle about each pixel.
    #[must_use]
    pub fn truth(&self) -> Truth {
        self.truth_of_some(1)
    }

    /// The truth about the first of each `every` pixels.
    #[must_use]
    pub fn truth_of_some(&self, every: u32) -> Truth {
        let (shot, oracle) = (self.shot(), Oracle::new(self.mesh.triangles()));
        let stops = |opacity: &dyn Opacity, id: u32, at: [f32; 2]| opacity.is_opaque(id) || opacity.stops(id, at);
        self.truth_by(every, |x, y| {
            let ray = shot.ray(x, y);
            let is_stopped = |hit: &Hit| {
                let corners = shot.triangles.corners(hit.triangle);
                let has_back = self.sides.has_back(hit.triangle);
                let is_there = has_back || crossing(&ray, corners).is_some_and(|crossing| crossing.front);
                is_there && stops(shot.opacity, hit.triangle, hit.barycentric)
            };
            let hit = oracle.nearest(&ray, is_stopped)?;
            let lit = self.lights.iter().map(|light| {
                let shadow_ray = ShadowRay::new(light, HitPoint::new(&ray, hit.t));
                let is_in_cone = Cone::of(light).is_none_or(|cone| cone.contains(shadow_ray.point()));
                let is_there = |id| stops_light(self.sides, light, &shadow_ray, id, shot.triangles.corners(id));
                is_in_cone
                    && !oracle
                        .blocked(&shadow_ray, hit.triangle, |id, at| is_there(id) && stops(shot.shadow_opacity, id, at))
            });
            Some((hit.triangle, lit.collect()))
        })
    }

    /// The truth about the first of each `every` pixels, from the triangle that each shows, if any, and whether each light
    /// reaches that.
    pub(crate) fn truth_by(&self, every: u32, of_pixel: impl Fn(u32, u32) -> Option<(u32, Vec<bool>)> + Sync) -> Truth {
        let pixels = (0..self.view.width * self.view.height).into_par_iter().step_by(every as usize);
        let answers = pixels.map(|pixel| of_pixel(pixel % self.view.width, pixel / self.view.width));
        let nothing = || (SeenPixels::NONE, vec![false; self.lights.len()]);
        let (triangle, lit): (Vec<u32>, Vec<Vec<bool>>) = answers.map(|answer| answer.unwrap_or_else(nothing)).unzip();
        let of_light = |light: usize| lit.iter().map(|lit| lit[light]).collect();
        Truth { triangle, lit: (0..self.lights.len()).map(of_light).collect() }
    }
}

/// Whether a shadow ray's light falls on the side of a triangle that is there.
#[must_use]
pub fn stops_light(sides: Sides<'_>, light: &LightSource, ray: &ShadowRay, id: u32, corners: [Vec3; 3]) -> bool {
    // Rays of parallel light go the other way.
    let is_turned = matches!(light, LightSource::Directional { .. });
    sides.has_back(id) || crossing(&ray.ray, corners).is_some_and(|crossing| crossing.front != is_turned)
}
