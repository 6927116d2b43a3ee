use glam::{Vec3, Vec4};
use rayon::prelude::*;
use umbrage_rays::{Bvh, Hit, Ray, View};
use umbrage_scene::Frame;

use super::shadow::{LightMask, is_blocked};
use super::{Cpu, counts, hit_of};
use crate::Film;
use crate::background::Surroundings;
use crate::sampling::Sample;
use crate::shade::{Footprint, Surface, arriving};

impl Cpu {
    /// Adds each pixel's radiance at the current sample to the film.
    pub(crate) fn shade(
        &self,
        frame: &Frame,
        view: &View,
        sample: &Sample,
        surroundings: &Surroundings<'_>,
        film: &mut Film,
    ) {
        let footprint = Footprint::new(view, sample.of);
        let culls_back_faces = self.culls_back_faces;
        let shading = Shading { bvh: &self.bvh, lit: &self.lit, frame, surroundings, footprint, culls_back_faces };
        let Film { color, depth, normal, triangle, .. } = film;
        let (order, width) = (self.seen.order(), view.width as usize);
        let pixels = color.par_iter_mut().zip(depth).zip(normal).zip(triangle).enumerate();
        pixels.for_each(|(pixel, (((color, depth), normal), triangle))| {
            let (x, y) = ((pixel % width) as u32, (pixel / width) as u32);
            let (ray, place) = (sample.ray(view, x, y), order.place(x, y));
            let seen = shading.seen(place, &ray, hit_of(frame, &ray, self.seen.triangle[place]));
            *color += seen.color;
            if let (0, Some((hit, surface))) = (sample.index, seen.first) {
                (*depth, *normal, *triangle) = (hit.t as f32, surface.normal, hit.triangle);
            }
        });
    }
}

/// What shading one sample needs.
struct Shading<'a> {
    bvh: &'a Bvh,
    lit: &'a [LightMask],
    frame: &'a Frame,
    surroundings: &'a Surroundings<'a>,
    footprint: Footprint,
    culls_back_faces: bool,
}

/// What one ray saw.
struct Seen {
    /// Radiance, and how much of the background is hidden.
    color: Vec4,
    first: Option<(Hit, Surface)>,
}

impl Shading<'_> {
    /// How many such surfaces one behind the other are seen through.
    const MOST_LAYERS: usize = 32;

    /// What the camera ray of a place, whose nearest hit is `hit`, sees, through blended and transmissive surfaces to what
    /// is behind them.
    fn seen(&self, place: usize, ray: &Ray, hit: Option<Hit>) -> Seen {
        let mut color = Vec3::ZERO;
        let mut through = Vec3::ONE;
        let mut first = None;
        let mut next = hit;
        for layer in 0..Self::MOST_LAYERS {
            let Some(hit) = next else { break };
            let surface = Surface::new(self.frame, ray, &hit, &self.footprint);
            let radiance = self.reflected(&surface, |light| {
                if layer == 0 {
                    self.lit[light].is_lit_at(place)
                } else {
                    !is_blocked(self.bvh, self.frame, &self.frame.lights[light], ray, &hit)
                }
            });
            color += radiance * (through * surface.opacity);
            through *= Vec3::ONE.lerp(surface.transmitted, surface.opacity);
            first = first.or(Some((hit, surface)));
            if through.max_element() <= 0.0 {
                break;
            }
            let behind = Ray { t_min: hit.t, ..*ray };
            let counts = |hit: &Hit| counts(self.frame, ray, hit, self.culls_back_faces);
            next = self.bvh.nearest(self.frame.triangles(), &behind, counts);
        }
        color += self.surroundings.radiance(ray.direction.normalize().as_vec3()) * through;
        Seen { color: color.extend(1.0 - through.element_sum() / 3.0), first }
    }

    /// Radiance that a surface sends along the ray, by itself and from the lights that reach it.
    fn reflected(&self, surface: &Surface, is_lit: impl Fn(usize) -> bool) -> Vec3 {
        if surface.unlit {
            return surface.base_color;
        }
        let Surface { normal, view, reflectance, .. } = surface;
        let mirrored = -view.reflect(*normal);
        let ambient = reflectance.ambient(
            normal.dot(*view).max(0.0),
            self.surroundings.irradiance(*normal),
            self.surroundings.blurred(mirrored, reflectance.roughness()),
        );
        let mut radiance = surface.emitted + ambient * surface.ambient_occlusion;
        for (_, light) in self.frame.lights.iter().enumerate().filter(|(place, _)| is_lit(*place)) {
            if let Some(arriving) = arriving(light, surface.position) {
                let cosine = normal.dot(arriving.towards).max(0.0);
                // Light from behind the triangle lights its other side, whatever the bent normal says.
                if surface.geometric_normal.dot(arriving.towards) > 0.0 {
                    radiance += reflectance.evaluate(*normal, *view, arriving.towards) * arriving.irradiance * cosine;
                }
            }
        }
        radiance
    }
}
