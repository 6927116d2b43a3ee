use glam::{DVec2, Vec3};
use rayon::prelude::*;
use umbrage_rays::predicate::{HitPoint, ShadowRay, crossing};
use umbrage_rays::{Cone, Hit, LightSource, Opacity, Opaque, Parts, SeenPixels, Shifts, Shot, Sides, View};

use crate::views::OFFSET_PIXELS;
use crate::{Oracle, TestMesh};

/// A mesh with a camera and lights: a question whose answer the oracle knows.
pub struct Case {
    /// The case's special feature.
    pub name: String,
    /// The triangles.
    pub mesh: TestMesh,
    /// The camera.
    pub view: View,
    /// Offset of each pixel's ray in the pixel.
    pub offset_pixels: DVec2,
    /// Additional shift of each ray.
    pub shifts: Shifts,
    /// Lights, all with shadows.
    pub lights: Vec<LightSource>,
    /// Opacity for camera rays.
    pub opacity: Box<dyn Opacity + Send>,
    /// Opacity for shadow rays.
    pub shadow_opacity: Box<dyn Opacity + Send>,
    /// Sides of triangles that stop rays.
    pub sides: Sides<'static>,
    /// The part of each triangle, for structures that outlive a frame; any numbers.
    pub part_of_triangle: Vec<u32>,
}

/// [`Sides`] with two sides for more than half of the first 4096 triangles, and for all later ones.
pub const MIXED_SIDES: Sides<'static> = Sides::Each(&[0x5bd1_e995_cc9e_2d51; 64]);

/// The true answers for each pixel of a [`Case`], or for every n-th, row by row.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Truth {
    /// The triangle that it shows; [`SeenPixels::NONE`] for none.
    pub triangle: Vec<u32>,
    /// For each light, whether it reaches the pixel; false for a pixel without a triangle.
    pub lit: Vec<Vec<bool>>,
}

impl std::fmt::Debug for Case {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Case").field("name", &self.name).field("shot", &self.shot()).finish_non_exhaustive()
    }
}

impl Case {
    /// A case of opaque, two-sided triangles, seen through about the middle of each pixel.
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

    /// Parts of triangles that move together.
    #[must_use]
    pub fn parts(&self) -> Parts<'_> {
        Parts { of_triangle: &self.part_of_triangle, objects: &[] }
    }

    /// The case as a structure's question.
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

    /// The truth, from the oracle, for each pixel.
    #[must_use]
    pub fn truth(&self) -> Truth {
        self.truth_of_some(1)
    }

    /// The truth for the first of each `every` pixels.
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

    /// The truth for the first of each `every` pixels, from `of_pixel`: the triangle that the pixel shows, if any, and
    /// whether each light reaches it.
    pub(crate) fn truth_by(&self, every: u32, of_pixel: impl Fn(u32, u32) -> Option<(u32, Vec<bool>)> + Sync) -> Truth {
        let pixels = (0..self.view.width * self.view.height).into_par_iter().step_by(every as usize);
        let answers = pixels.map(|pixel| of_pixel(pixel % self.view.width, pixel / self.view.width));
        let nothing = || (SeenPixels::NONE, vec![false; self.lights.len()]);
        let (triangle, lit): (Vec<u32>, Vec<Vec<bool>>) = answers.map(|answer| answer.unwrap_or_else(nothing)).unzip();
        let of_light = |light: usize| lit.iter().map(|lit| lit[light]).collect();
        Truth { triangle, lit: (0..self.lights.len()).map(of_light).collect() }
    }
}

/// Whether a shadow ray meets a triangle on a side that stops light.
#[must_use]
pub fn stops_light(sides: Sides<'_>, light: &LightSource, ray: &ShadowRay, id: u32, corners: [Vec3; 3]) -> bool {
    // Shadow rays of parallel light go from the point to the light.
    let is_turned = matches!(light, LightSource::Directional { .. });
    sides.has_back(id) || crossing(&ray.ray, corners).is_some_and(|crossing| crossing.front != is_turned)
}
