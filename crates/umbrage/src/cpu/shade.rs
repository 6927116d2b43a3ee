use std::array;

use fearless_simd::prelude::*;
use fearless_simd::{Level, Simd, dispatch, f32x16, mask32x16};
use glam::{DVec3, Vec3, Vec4};
use rayon::prelude::*;
use umbrage_rays::predicate::HitPoint;
use umbrage_rays::{Hit, LightMask, Ray, SeenPixels, Sides, SingleRays, TileOrder};
use umbrage_scene::{Frame, Light};

use super::samples::OneSample;
use super::shadow::is_blocked;
use super::{Cpu, hit_of, stops};
use crate::Film;
use crate::background::Surroundings;
use crate::engine::Staged;
use crate::sampling::Samples;
use crate::shade::lanes::{BRIGHTEST, Each, LANES, Vectors, lanes_of, vector_of};
use crate::shade::{Block, BlockHits, BlockRays, Footprint, SeenReflectance, Surface, arriving};

impl Cpu {
    /// Adds each pixel's radiance at the current samples to the film, in the order of their numbers.
    pub(super) fn shade_pixels(&self, staged: &Staged<'_>, samples: &Samples, film: &mut Film) {
        let Staged { frame, lights, ref view, surroundings, .. } = *staged;
        let Self { masks: lit, seen, sides, bounces, .. } = self;
        let (sides, bounces, rays_onward) = (sides.get(), *bounces, self.single_rays());
        let (level, footprint) = (Level::from(self.level), Footprint::new(view, samples.as_slice()[0].of));
        let shading = Shading { rays_onward, lit, seen, frame, lights, surroundings, footprint, sides, bounces };
        let Film { color, depth, normal, triangle, .. } = film;
        let rows = TileOrder::BLOCK as usize * view.width as usize;
        let planes = color.par_chunks_mut(rows).zip(depth.par_chunks_mut(rows));
        let planes = planes.zip(normal.par_chunks_mut(rows)).zip(triangle.par_chunks_mut(rows));
        planes.enumerate().for_each(|(strip, (((color, depth), normal), triangle))| {
            let y = strip as u32 * TileOrder::BLOCK;
            let mut film = Strip { color, depth, normal, triangle };
            for x in (0..view.width).step_by(TileOrder::BLOCK as usize) {
                for (which, sample) in samples.as_slice().iter().enumerate() {
                    let block = Block { view, sample, corner: [x, y] };
                    let one = OneSample::new(seen.order(), samples, which);
                    let shaded = dispatch!(level, simd => shading.shade(simd, &block, &one));
                    film.add(&block, &shaded);
                }
            }
        });
    }
}

/// What shading one sample needs.
struct Shading<'a> {
    /// For rays that go on behind what was seen, or from mirrors.
    rays_onward: &'a dyn SingleRays,
    lit: &'a [LightMask],
    seen: &'a SeenPixels,
    frame: &'a Frame,
    lights: &'a [Light],
    surroundings: &'a Surroundings<'a>,
    footprint: Footprint,
    sides: Sides<'a>,
    /// How many mirrors light may come by.
    bounces: u32,
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

    /// What the camera rays of a block see, through blended and transmissive surfaces to what is behind them, and in
    /// mirrors.
    #[inline(always)]
    fn shade<S: Simd>(&self, simd: S, block: &Block<'_>, one_sample: &OneSample) -> Shaded {
        let (nothing, one) = (Vectors::splat(simd, Vec3::ZERO), Vectors::splat(simd, Vec3::ONE));
        let slots = one_sample.slots(block.corner);
        let rays = BlockRays::new(simd, block);
        let next = BlockHits::of_seen(simd, self.frame, block, &rays, &slots.of(&self.seen.triangle));
        let mut path = Path { rays, next, through: one, from_mirrors: None };
        let mut mirrors: Vec<Path<S>> = Vec::new();
        let (mut shown, mut depth, mut normal, mut triangle) = (0, f32x16::splat(simd, 0.0), nothing, [0; LANES]);
        let (mut color, mut behind_all) = (nothing, nothing);
        loop {
            let Path { rays, mut next, mut through, from_mirrors } = path;
            let ray = |lane| from_mirrors.as_ref().map_or_else(|| block.ray(lane), |from| from.rays[lane]);
            let mut found = from_mirrors.as_ref().map(|from| from.found);
            let bounces_left = self.bounces - from_mirrors.as_ref().map_or(0, |from| from.bounces);
            for layer in 0..Self::MOST_LAYERS {
                let Some(hits) = next else { break };
                let met = Met::new(simd, self, &rays, &hits, through, bounces_left > 0);
                let lit = |light: usize| match &found {
                    None => slots.lit(&self.lit[light]),
                    Some(found) => self.lit_onward(&ray, light, found),
                };
                let radiance = self.reflected(simd, &met, lit);
                let is_shown = mask32x16::from_bitmask(simd, hits.shown.into());
                color += Vectors::select(is_shown, radiance * through.scaled(met.surface.opacity), nothing);
                if met.traced != 0 {
                    let mirrored = met.mirrored.store();
                    let from =
                        self.follow_mirrors(&ray, met.traced, &mirrored, found.as_ref(), &hits.triangle, bounces_left);
                    let rays = BlockRays::of_rays(simd, &from.rays, rays.travelled + hits.depth);
                    let next = BlockHits::of_found(simd, self.frame, &rays, &from.found);
                    let is_traced = mask32x16::from_bitmask(simd, met.traced.into());
                    let through = Vectors::select(is_traced, met.mirrored_through, nothing);
                    mirrors.push(Path { rays, next, through, from_mirrors: Some(from) });
                }
                let passing = one.lerp(met.surface.transmitted, met.surface.opacity);
                through = Vectors::select(is_shown, through * passing, through);
                if layer == 0 && from_mirrors.is_none() {
                    (shown, depth, normal, triangle) = (hits.shown, hits.depth, met.surface.normal, hits.triangle);
                }
                let seen_through = hits.shown & through.largest().simd_gt(0.0).to_bitmask() as u16;
                if seen_through == 0 {
                    break;
                }
                let behind = self.behind(&ray, seen_through, found.as_ref(), &hits.triangle);
                next = BlockHits::of_found(simd, self.frame, &rays, &behind);
                found = Some(behind);
            }
            if through.largest().simd_gt(0.0).any_true() {
                color += self.surroundings.radiance(simd, rays.unit_direction()) * through;
            }
            if from_mirrors.is_none() {
                behind_all = through;
            }
            let Some(next_path) = mirrors.pop() else { break };
            path = next_path;
        }
        Shaded {
            color: color.at_most_brightest().store(),
            // Opaque where numbers overflow.
            coverage: (1.0 - (behind_all.x + behind_all.y + behind_all.z) / 3.0)
                .min_precise(1.0)
                .max_precise(-BRIGHTEST)
                .into(),
            shown,
            depth: depth.min_precise(f32::MAX).into(),
            normal: normal.store(),
            triangle,
        }
    }

    /// Radiance that surfaces send along the rays, by themselves and from the lights that reach them; `lit` gives the
    /// lanes that a light reaches. What is seen in mirrors that are followed is left out.
    #[inline(always)]
    fn reflected<S: Simd>(&self, simd: S, met: &Met<S>, lit: impl Fn(usize) -> u16) -> Vectors<S> {
        let Met { surface, seen, mirrored, shown, traced, .. } = met;
        let normal = surface.normal;
        let mut surrounding = self.surroundings.blurred(simd, *mirrored, surface.reflectance.roughness());
        if *traced != 0 {
            let nothing = Vectors::splat(simd, Vec3::ZERO);
            surrounding = Vectors::select(mask32x16::from_bitmask(simd, (*traced).into()), nothing, surrounding);
        }
        let ambient = seen.ambient(self.surroundings.irradiance(simd, normal), surrounding);
        let mut radiance = surface.emitted + ambient.scaled(surface.ambient_occlusion);
        for (number, light) in self.lights.iter().enumerate() {
            let lit = lit(number) & *shown & !surface.unlit;
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
        ray: &dyn Fn(usize) -> Ray,
        lanes: u16,
        found: Option<&Each<Option<Hit>>>,
        first: &Each<u32>,
    ) -> Each<Option<Hit>> {
        let mut behind = [None; LANES];
        for lane in lanes_of(lanes) {
            let ray = ray(lane);
            // The exact distance, so that the same surface isn't met again.
            let hit = found.map_or_else(|| hit_of(self.frame, &ray, first[lane]), |found| found[lane]);
            let Some(hit) = hit else { continue };
            let stops = |hit: &Hit| stops(self.frame, &ray, hit, self.sides);
            behind[lane] = self.rays_onward.nearest(self.frame.triangles(), &Ray { t_min: hit.t, ..ray }, &stops);
        }
        behind
    }

    /// What some lanes show in the mirrors that they have `found`, or that they show `first`, in the directions `mirrored`.
    #[cold]
    fn follow_mirrors(
        &self,
        ray: &dyn Fn(usize) -> Ray,
        lanes: u16,
        mirrored: &[Each<f32>; 3],
        found: Option<&Each<Option<Hit>>>,
        first: &Each<u32>,
        bounces_left: u32,
    ) -> FromMirrors {
        // Lanes without a ray get one that points somewhere.
        let mut from = FromMirrors {
            rays: [Ray::new(DVec3::ZERO, DVec3::Z); LANES],
            found: [None; LANES],
            bounces: self.bounces - bounces_left + 1,
        };
        let triangles = self.frame.triangles();
        for lane in lanes_of(lanes) {
            let ray = ray(lane);
            let hit = found.map_or_else(|| hit_of(self.frame, &ray, first[lane]), |found| found[lane]);
            let Some(hit) = hit else { continue };
            let point = HitPoint::new(&ray, hit.t);
            let ray = Ray::new(point.position, vector_of(lane, mirrored).as_dvec3());
            from.rays[lane] = ray;
            // As with shadows: neither the mirror itself nor what the point touches, as far as anybody can tell.
            from.found[lane] = self.rays_onward.nearest(triangles, &ray, &|other| {
                other.triangle != hit.triangle
                    && !point.is_on(triangles.corners(other.triangle))
                    && stops(self.frame, &ray, other, self.sides)
            });
        }
        from
    }

    /// The lanes whose `found` hits a light reaches.
    #[cold]
    fn lit_onward(&self, ray: &dyn Fn(usize) -> Ray, light: usize, found: &Each<Option<Hit>>) -> u16 {
        let light = &self.lights[light];
        let is_lit =
            |lane: usize, hit: &Hit| !is_blocked(self.rays_onward, self.frame, self.sides, light, &ray(lane), hit);
        (0..LANES)
            .filter(|&lane| found[lane].is_some_and(|hit| is_lit(lane, &hit)))
            .fold(0, |lit, lane| lit | 1 << lane)
    }
}

/// What sixteen rays meet next.
struct Met<S: Simd> {
    surface: Surface<S>,
    seen: SeenReflectance<S>,
    /// Where mirrors send the rays.
    mirrored: Vectors<S>,
    /// How much of what is there reaches the camera.
    mirrored_through: Vectors<S>,
    /// The lanes that meet anything.
    shown: u16,
    /// The lanes whose mirrors are followed.
    traced: u16,
}

impl<S: Simd> Met<S> {
    #[inline(always)]
    fn new(
        simd: S,
        shading: &Shading<'_>,
        rays: &BlockRays<S>,
        hits: &BlockHits<S>,
        through: Vectors<S>,
        follows_mirrors: bool,
    ) -> Self {
        /// Less than half of what a picture of 8 bits can show of white: panes behind panes would mirror each other endlessly.
        const LEAST: f32 = 0.002;
        let surface = Surface::new(simd, shading.frame, rays, hits, &shading.footprint);
        let seen = surface.reflectance.seen(simd, surface.normal, surface.view);
        let mirrored = surface.normal.scaled(2.0 * surface.view.dot(surface.normal)) - surface.view;
        let mirrored_through = through.scaled(surface.opacity) * seen.specular();
        let mut traced = 0;
        if follows_mirrors {
            // A bent normal may mirror rays into the triangle.
            let is_outside = surface.geometric_normal.dot(mirrored).simd_gt(0.0);
            let is_seen = mirrored_through.largest().simd_gt(LEAST);
            let is_traced = surface.reflectance.is_mirror() & is_outside & is_seen;
            traced = is_traced.to_bitmask() as u16 & hits.shown & !surface.unlit;
        }
        Self { surface, seen, mirrored, mirrored_through, shown: hits.shown, traced }
    }
}

/// Sixteen ways from the camera on.
struct Path<S: Simd> {
    rays: BlockRays<S>,
    /// What they meet next.
    next: Option<BlockHits<S>>,
    /// How much of what they meet reaches the camera; zero in lanes without a ray.
    through: Vectors<S>,
    /// `None` for the camera's own rays.
    from_mirrors: Option<FromMirrors>,
}

/// Rays that come from mirrors.
struct FromMirrors {
    rays: Each<Ray>,
    found: Each<Option<Hit>>,
    /// How many mirrors are behind them.
    bounces: u32,
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
    use glam::{Vec3, Vec4};
    use umbrage_rays::{Camera, LightSource, SimdLevel};
    use umbrage_scene::{Alpha, Frame, Light, Material};

    use crate::{Background, Film, Renderer, Settings};

    #[test]
    fn every_simd_level_shades_the_same_bits() {
        for name in ["demo:forest?triangles=3000", "demo:glass?triangles=600", "demo:hall?triangles=3000"] {
            let scene = crate::open(name).unwrap();
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

    #[test]
    fn films_are_finite_however_bright_it_is() {
        let positions =
            [[-2., 0., -2.], [2., 0., -2.], [2., 0., 2.], [-2., 0., 2.], [-1., 0., 0.], [1., 0., 0.], [0., 1., 0.]];
        let triangles = vec![[0, 2, 1], [0, 3, 2], [4, 5, 6]];
        let lamp = |height: f32, intensity: f32| Light {
            name: "".into(),
            source: LightSource::Point { position: Vec3::new(0.1, height, 0.2) },
            color: Vec3::splat(intensity.min(1e10)),
            intensity,
            range: None,
            casts_shadow: true,
        };
        let clay = Material { base_color: Vec4::splat(1.0), ..Material::default() };
        let huge = f32::MAX;
        let materials = [
            Material { emissive: Vec3::splat(huge), ..clay.clone() },
            Material { base_color: Vec4::splat(huge), ..clay.clone() },
            Material { base_color: Vec4::splat(-huge), alpha: Alpha::Blend, ..clay.clone() },
            Material { base_color: Vec4::splat(huge), transmission: huge, ..clay.clone() },
            Material { roughness: huge, metallic: -huge, ior: huge, ..clay.clone() },
            Material { roughness: 0.0, metallic: 1.0, ior: 0.0, ..clay },
        ];
        for scale in [1.0, 1e-30, 1e18, 1e37] {
            for material in &materials {
                let positions = positions.map(|position| Vec3::from(position) * scale).to_vec();
                let mut frame = Frame::from_triangles(positions, triangles.clone());
                std::sync::Arc::make_mut(&mut frame.materials).materials[0] = material.clone();
                let camera = Camera::look_at(Vec3::new(0.0, 2.0, 4.0) * scale, Vec3::ZERO, Vec3::Y, 0.8);
                for (height, intensity) in [(3.0, huge), (1e-20, huge), (1e-20, 1.0), (3.0, 1.0)] {
                    frame.lights = vec![lamp(height * scale, intensity), lamp(height * scale, -intensity)];
                    for background in [Background::Sky, Background::Color(Vec3::splat(huge))] {
                        let camera = camera.into();
                        let settings = Settings {
                            width: 16,
                            height: 12,
                            samples: 3,
                            bounces: 1,
                            camera,
                            background,
                            ..Settings::default()
                        };
                        let film = Renderer::default().render_frame(&frame, &settings).unwrap().clone();
                        assert!(film.color.iter().all(|color| color.is_finite()), "{scale} {material:?} {intensity}");
                        assert!(film.normal.iter().all(|normal| normal.is_finite()), "{scale} {material:?}");
                        let mut shown = film.depth.iter().zip(&film.triangle);
                        assert!(shown.all(|(depth, &triangle)| depth.is_finite() != (triangle == Film::NO_TRIANGLE)));
                    }
                }
            }
        }
    }
}
