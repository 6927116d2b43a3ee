use std::array;

use fearless_simd::prelude::*;
use fearless_simd::{Level, Simd, dispatch, f32x16, mask32x16};
use glam::{Vec3, Vec4};
use rayon::prelude::*;
use umbrage_rays::{Hit, Ray, SeenPixels, TileOrder, View};
use umbrage_scene::Frame;

use super::shadow::{LightMask, is_blocked};
use super::single_rays::SingleRays;
use super::{Cpu, counts, hit_of};
use crate::Film;
use crate::background::Surroundings;
use crate::sampling::Sample;
use crate::shade::lanes::{Each, LANES, Vectors, lanes_of, vector_of};
use crate::shade::{Block, BlockHits, BlockRays, Footprint, Surface, arriving};

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
        let Self { lit, seen, culls_back_faces, .. } = self;
        let rays_behind = self.single_rays();
        let (level, footprint) = (Level::from(self.level), Footprint::new(view, sample.of));
        let shading =
            Shading { rays_behind, lit, seen, frame, surroundings, footprint, culls_back_faces: *culls_back_faces };
        let Film { color, depth, normal, triangle, .. } = film;
        let rows = TileOrder::BLOCK as usize * view.width as usize;
        let planes = color.par_chunks_mut(rows).zip(depth.par_chunks_mut(rows));
        let planes = planes.zip(normal.par_chunks_mut(rows)).zip(triangle.par_chunks_mut(rows));
        planes.enumerate().for_each(|(strip, (((color, depth), normal), triangle))| {
            let y = strip as u32 * TileOrder::BLOCK;
            let mut film = Strip { color, depth, normal, triangle };
            for x in (0..view.width).step_by(TileOrder::BLOCK as usize) {
                let block = Block { view, sample, corner: [x, y] };
                let shaded = dispatch!(level, simd => shading.shade(simd, &block));
                film.add(&block, &shaded);
            }
        });
    }
}

/// What shading one sample needs.
struct Shading<'a> {
    /// For rays that go on behind what was seen.
    rays_behind: SingleRays<'a>,
    lit: &'a [LightMask],
    seen: &'a SeenPixels,
    frame: &'a Frame,
    surroundings: &'a Surroundings<'a>,
    footprint: Footprint,
    culls_back_faces: bool,
}

/// What the rays of a block saw.
struct Shaded {
    /// Radiance.
    color: [Each<f32>; 3],
    /// How much of the background is hidden.
    coverage: Each<f32>,
    /// What they saw first; there is nothing of it in lanes that show nothing.
    shown: u16,
    depth: Each<f32>,
    normal: [Each<f32>; 3],
    triangle: Each<u32>,
}

impl Shading<'_> {
    /// How many such surfaces one behind the other are seen through.
    const MOST_LAYERS: usize = 32;

    /// What the camera rays of a block see, through blended and transmissive surfaces to what is behind them.
    #[inline(always)]
    fn shade<S: Simd>(&self, simd: S, block: &Block<'_>) -> Shaded {
        let nothing = Vectors::splat(simd, Vec3::ZERO);
        let (mut color, mut through) = (nothing, Vectors::splat(simd, Vec3::ONE));
        let (mut shown, mut depth, mut normal, mut triangle) = (0, f32x16::splat(simd, 0.0), nothing, [0; LANES]);
        let place = self.seen.order().place(block.corner[0], block.corner[1]);
        let rays = BlockRays::new(simd, block);
        let mut next = BlockHits::of_seen(simd, self.frame, block, &rays, &self.seen.triangle[place..place + LANES]);
        let mut found = None;
        for layer in 0..Self::MOST_LAYERS {
            let Some(hits) = next else { break };
            let surface = Surface::new(simd, self.frame, &rays, &hits, &self.footprint);
            let lit = |light: usize| match &found {
                None => self.lit[light].block(place / LANES),
                Some(found) => self.lit_behind(block, light, found),
            };
            let radiance = self.reflected(simd, &surface, hits.shown, lit);
            let is_shown = mask32x16::from_bitmask(simd, hits.shown.into());
            color += Vectors::select(is_shown, radiance * through.scaled(surface.opacity), nothing);
            let passing = Vectors::splat(simd, Vec3::ONE).lerp(surface.transmitted, surface.opacity);
            through = Vectors::select(is_shown, through * passing, through);
            if layer == 0 {
                (shown, depth, normal, triangle) = (hits.shown, hits.depth, surface.normal, hits.triangle);
            }
            let seen_through = hits.shown & through.largest().simd_gt(0.0).to_bitmask() as u16;
            if seen_through == 0 {
                break;
            }
            let behind = self.behind(block, seen_through, found.as_ref(), &hits.triangle);
            next = BlockHits::of_found(simd, self.frame, &rays, &behind);
            found = Some(behind);
        }
        if through.largest().simd_gt(0.0).any_true() {
            color += self.surroundings.radiance(simd, rays.unit_direction()) * through;
        }
        Shaded {
            color: color.store(),
            coverage: (1.0 - (through.x + through.y + through.z) / 3.0).into(),
            shown,
            depth: depth.into(),
            normal: normal.store(),
            triangle,
        }
    }

    /// Radiance that surfaces send along the rays, by themselves and from the lights that reach them; `lit` gives the
    /// lanes that a light reaches.
    #[inline(always)]
    fn reflected<S: Simd>(&self, simd: S, surface: &Surface<S>, shown: u16, lit: impl Fn(usize) -> u16) -> Vectors<S> {
        let Surface { normal, view, reflectance, .. } = *surface;
        let mirrored = normal.scaled(2.0 * view.dot(normal)) - view;
        let seen = reflectance.seen(simd, normal, view);
        let ambient = seen.ambient(
            self.surroundings.irradiance(simd, normal),
            self.surroundings.blurred(simd, mirrored, reflectance.roughness()),
        );
        let mut radiance = surface.emitted + ambient.scaled(surface.ambient_occlusion);
        for (place, light) in self.frame.lights.iter().enumerate() {
            let lit = lit(place) & shown & !surface.unlit;
            if lit == 0 {
                continue;
            }
            let arriving = arriving(simd, light, surface.position);
            let cosine = normal.dot(arriving.towards).max(0.0);
            // Light from behind the triangle lights its other side, whatever the bent normal says.
            let faces = surface.geometric_normal.dot(arriving.towards).simd_gt(0.0);
            let is_lit = faces & mask32x16::from_bitmask(simd, lit.into());
            let reflected = seen.evaluate(simd, arriving.towards) * arriving.irradiance.scaled(cosine);
            radiance = Vectors::select(is_lit, radiance + reflected, radiance);
        }
        if surface.unlit == 0 {
            return radiance;
        }
        Vectors::select(mask32x16::from_bitmask(simd, surface.unlit.into()), surface.base_color, radiance)
    }

    /// What some lanes show behind what they have `found` so far, or behind the triangles that they show first.
    #[cold]
    fn behind(
        &self,
        block: &Block<'_>,
        lanes: u16,
        found: Option<&Each<Option<Hit>>>,
        first: &Each<u32>,
    ) -> Each<Option<Hit>> {
        let mut behind = [None; LANES];
        for lane in lanes_of(lanes) {
            let ray = block.ray(lane);
            // The exact distance, so that the same surface isn't met again.
            let hit = found.map_or_else(|| hit_of(self.frame, &ray, first[lane]), |found| found[lane]);
            let Some(hit) = hit else { continue };
            let counts = |hit: &Hit| counts(self.frame, &ray, hit, self.culls_back_faces);
            behind[lane] = self.rays_behind.nearest(self.frame.triangles(), &Ray { t_min: hit.t, ..ray }, counts);
        }
        behind
    }

    /// The lanes whose `found` hits a light reaches.
    #[cold]
    fn lit_behind(&self, block: &Block<'_>, light: usize, found: &Each<Option<Hit>>) -> u16 {
        let light = &self.frame.lights[light];
        let is_lit = |lane: usize, hit: &Hit| !is_blocked(self.rays_behind, self.frame, light, &block.ray(lane), hit);
        (0..LANES)
            .filter(|&lane| found[lane].is_some_and(|hit| is_lit(lane, &hit)))
            .fold(0, |lit, lane| lit | 1 << lane)
    }
}

/// Some rows of the film, as many as a block has.
struct Strip<'a> {
    color: &'a mut [Vec4],
    depth: &'a mut [f32],
    normal: &'a mut [Vec3],
    triangle: &'a mut [u32],
}

impl Strip<'_> {
    fn add(&mut self, block: &Block<'_>, shaded: &Shaded) {
        let pixels: Each<usize> = array::from_fn(|lane| {
            let [column, row] = block.pixel(lane);
            ((row - block.corner[1]) * block.view.width + column) as usize
        });
        for lane in lanes_of(block.pixels()) {
            self.color[pixels[lane]] += vector_of(lane, &shaded.color).extend(shaded.coverage[lane]);
        }
        if block.sample.index == 0 {
            for lane in lanes_of(shaded.shown) {
                let pixel = pixels[lane];
                self.depth[pixel] = shaded.depth[lane];
                self.normal[pixel] = vector_of(lane, &shaded.normal);
                self.triangle[pixel] = shaded.triangle[lane];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use umbrage_rays::SimdLevel;

    use crate::{Film, Renderer, Scene, Settings};

    #[test]
    fn every_simd_level_shades_the_same_bits() {
        for name in ["demo:forest?triangles=3000", "demo:glass?triangles=600", "demo:hall?triangles=3000"] {
            let scene = Scene::open(name).unwrap();
            // Sides that no block divides.
            let settings = Settings { width: 61, height: 47, samples: 2, ..Settings::default() };
            let films = SimdLevel::available()
                .into_iter()
                .map(|level| Renderer::with_simd_level(level).render(&scene, 0.4, &settings).unwrap().clone());
            let films: Vec<Film> = films.collect();
            assert!(films[0].triangle.iter().any(|&triangle| triangle != Film::NO_TRIANGLE));
            for film in &films {
                assert_eq!(film.color, films[0].color, "{name}");
                assert_eq!(film.depth, films[0].depth, "{name}");
                assert_eq!(film.normal, films[0].normal, "{name}");
                assert_eq!(film.triangle, films[0].triangle, "{name}");
            }
        }
    }
}
