use std::mem;

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, mask32x16};
use glam::{UVec2, Vec3, Vec4};
use rayon::iter::Either;
use rayon::prelude::*;
use umbrage_rays::dispatch;
use umbrage_rays::predicate::{HitPoint, ShadowRay};
use umbrage_rays::{Hit, LightMask, Ray, SeenPixels, Sides, SimdLevel, SingleRays, TileOrder, View};
use umbrage_scene::{Frame, Light};

use super::marks::{MarkStrip, Marks};
use super::met::Met;
use super::onward::{Drawn, Lanes, Meeting, Onward, Path, Queue, Shadow};
use super::samples::{OneSample, Slots};
use super::strip::{FirstHits, Flat, Shaded, Strip};
use super::terminator::smooth_point;
use super::{Cpu, hit_of};
use crate::Film;
use crate::background::Surroundings;
use crate::develop::Developer;
use crate::engine::Staged;
use crate::plan::Plan;
use crate::sampling::Samples;
use crate::shade::glass::Media;
use crate::shade::lanes::{BRIGHTEST, Each, LANES, Vectors, lanes_of, vector_of};
use crate::shade::{Block, BlockHits, BlockRays, Emitter, Footprint, SeenTriangles};

impl Cpu {
    /// Adds each pixel's radiance at the current samples to the film, or develops a frame of one sample without a film.
    pub(super) fn shade_pixels(&mut self, staged: &Staged<'_>, marks: Option<&Marks>, film: &mut Film) {
        let Staged { frame, lights, sky_lights, ref view, surroundings, ref samples, .. } = *staged;
        self.emitters.clear();
        self.emitters.extend(lights.iter().map(Emitter::new));
        let mut rows = mem::take(&mut self.rows);
        let Self { masks: lit, seen, sides, plan, .. } = &*self;
        let (sides, plan, rays_onward) = (sides.get(), *plan, self.single_rays());
        let (level, footprint) = (self.level, Footprint::new(view, samples.as_slice()[0].of));
        let first_sky_light = lights.len() - sky_lights;
        let shading = Shading {
            rays_onward,
            lit,
            seen,
            frame,
            lights,
            emitters: &self.emitters,
            first_sky_light,
            surroundings,
            footprint,
            smooth_terminator: self.smooth_terminator.is_some(),
            sides,
            plan,
            is_plain: &self.is_plain,
            has_flat: staged.has_flat(),
        };
        let strips = Strips { shading: &shading, level, view, samples, marks };
        match self.is_to_rows {
            true => strips.develop(Developer::new(staged.settings, 1), &mut rows),
            false => strips.shade(film),
        }
        self.rows = rows;
    }
}

/// A frame to be shaded in strips, rows of blocks.
struct Strips<'a> {
    shading: &'a Shading<'a>,
    level: SimdLevel,
    view: &'a View,
    samples: &'a Samples,
    marks: Option<&'a Marks>,
}

impl Strips<'_> {
    /// Adds all of them to the film.
    fn shade(&self, Film { color, flat, depth, normal, triangle, .. }: &mut Film) {
        let rows = self.pixels();
        let strips = color.len().div_ceil(rows);
        let flat = match flat.is_empty() {
            true => Either::Left((0..strips).into_par_iter().map(|_| None)),
            false => Either::Right(flat.par_chunks_mut(rows).map(Some)),
        };
        let hits = match triangle.is_empty() {
            true => Either::Left((0..strips).into_par_iter().map(|_| None)),
            false => {
                let hits = depth.par_chunks_mut(rows).zip(normal.par_chunks_mut(rows));
                let hits = hits.zip(triangle.par_chunks_mut(rows));
                Either::Right(hits.map(|((depth, normal), triangle)| Some(FirstHits { depth, normal, triangle })))
            }
        };
        let planes = color.par_chunks_mut(rows).zip(flat).zip(hits);
        planes.enumerate().for_each_init(<_>::default, |memory, (number, ((color, flat), hits))| {
            self.add(number, memory, &mut Strip { color, flat, hits });
        });
    }

    /// Develops all of them, each while a fast cache has it.
    fn develop(&self, developer: Developer, rows: &mut Vec<u8>) {
        rows.resize(3 * self.view.width as usize * self.view.height as usize, 0);
        let strips = rows.par_chunks_mut(3 * self.pixels()).enumerate();
        strips.for_each_init(<(_, [Vec<Vec4>; 2])>::default, |(memory, [color, flat]), (number, rows)| {
            let pixels = rows.len() / 3;
            color.resize(pixels, Vec4::ZERO);
            flat.resize(if self.shading.has_flat { pixels } else { 0 }, Vec4::ZERO);
            let flat_rows = Some(&mut flat[..]).filter(|flat| !flat.is_empty());
            self.add(number, memory, &mut Strip { color, flat: flat_rows, hits: None });
            dispatch!(self.level, simd => developer.encode_rows(simd, (color, flat), rows));
        });
    }

    /// The pixels of a strip that isn't cut.
    fn pixels(&self) -> usize {
        TileOrder::BLOCK as usize * self.view.width as usize
    }

    /// Adds a strip, in the memory of an earlier one.
    fn add(&self, number: usize, (queue, drawn): &mut (Queue, MarkStrip), film: &mut Strip<'_>) {
        let &Self { shading, level, view, samples, marks } = self;
        let y = number as u32 * TileOrder::BLOCK;
        for (which, sample) in samples.as_slice().iter().enumerate() {
            let one = OneSample::new(shading.seen.order(), samples, which);
            if let Some(marks) = marks {
                drawn.draw(marks, view, sample, y);
            }
            for x in (0..view.width).step_by(TileOrder::BLOCK as usize) {
                let block = Block { view, sample, corner: UVec2::new(x, y) };
                let before = [queue.next.len(), queue.shadows.len()];
                dispatch!(level, simd => {
                    let mut shaded = shading.shade_seen(simd, &block, &one, queue);
                    if let Some(marks) = marks {
                        let ids = one.slots(block.corner).of(&shading.seen.triangle);
                        drawn.cover(marks, shading.frame, &block, &ids, &mut shaded).take_from(queue, before);
                    }
                    film.add_block(simd, &block, &shaded);
                });
            }
            queue.follow(level, shading, marks.map(|marks| (marks, &*drawn)), film);
        }
    }
}

/// Inputs for shading one sample.
pub(super) struct Shading<'a> {
    /// For secondary rays; built if any [go on](Plan::goes_on).
    pub(super) rays_onward: &'a dyn SingleRays,
    lit: &'a [LightMask],
    seen: &'a SeenPixels,
    pub(super) frame: &'a Frame,
    pub(super) lights: &'a [Light],
    /// The same lights.
    pub(super) emitters: &'a [Emitter],
    /// Index of the first sky light.
    pub(super) first_sky_light: usize,
    pub(super) surroundings: &'a Surroundings<'a>,
    pub(super) footprint: Footprint,
    /// Whether shadows are those of the smooth surfaces that the vertex normals describe.
    pub(super) smooth_terminator: bool,
    pub(super) sides: Sides<'a>,
    pub(super) plan: Plan,
    /// For each material, whether paths [end](Plan::ends_at) at it.
    is_plain: &'a [bool],
    /// Whether the film has [`Film::flat`].
    has_flat: bool,
}

/// How light from the surroundings arrives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum AroundLight {
    /// At every surface, without occlusion.
    Even,
    /// With ambient occlusion.
    Near,
    /// Through sky lights.
    Lights,
}

impl Shading<'_> {
    /// Shades the hits of a block's camera rays, and queues their secondary rays.
    #[inline(always)]
    fn shade_seen<S: Simd>(&self, simd: S, block: &Block<'_>, one_sample: &OneSample, queue: &mut Queue) -> Shaded {
        let slots = one_sample.slots(block.corner);
        let ids = slots.of(&self.seen.triangle);
        let Some(seen) = SeenTriangles::new(simd, self.frame, block, &ids) else {
            let rays = BlockRays::new(simd, block);
            let color = self.around(simd, &rays, &[0; LANES]).at_most_brightest().store();
            let flat = self.surroundings.are_flat().then_some(Flat { color, part: [1.0; LANES] });
            return Shaded { color, flat, ..Shaded::NOTHING };
        };
        let materials = &self.frame.mesh.material_of_triangle;
        if seen.ids().all(|id| self.is_plain[materials[id as usize] as usize]) {
            self.shade_hits::<S, true>(simd, (block, &slots), &seen, queue)
        } else {
            self.shade_any_hits(simd, (block, &slots), &seen, queue)
        }
    }

    /// Shades hits of any materials.
    // Apart, so that the code for plain ones has few numbers to keep in registers and a small stack frame.
    #[inline(never)]
    fn shade_any_hits<S: Simd>(
        &self,
        simd: S,
        (block, slots): (&Block<'_>, &Slots),
        seen: &SeenTriangles,
        queue: &mut Queue,
    ) -> Shaded {
        simd.vectorize(
            #[inline(always)]
            || self.shade_hits::<S, false>(simd, (block, slots), seen, queue),
        )
    }

    /// Shades hits, with `PLAIN` of plain materials alone ([`Plan::ends_at`]).
    #[inline(always)]
    fn shade_hits<S: Simd, const PLAIN: bool>(
        &self,
        simd: S,
        (block, slots): (&Block<'_>, &Slots),
        seen: &SeenTriangles,
        queue: &mut Queue,
    ) -> Shaded {
        let rays = BlockRays::new(simd, block);
        let hits = BlockHits::of_seen(simd, self.frame, block, &rays, seen);
        let through = Vectors::splat(simd, Vec3::ONE);
        let met = Met::new::<PLAIN>(simd, self, &rays, &hits, through, &[0; LANES]);
        let mut radiance = self.own_radiance(simd, &met);
        let mut caught_light = met.caught.as_ref().map(|caught| caught.ambient);
        let meeting = |lane: usize| {
            let (ray, [x, y]) = (block.ray(lane), block.pixel(lane));
            let pixel = (y - block.corner.y) * block.view.width + x;
            let media = Media::default();
            let drawn = Drawn { pixel: y * block.view.width + x, sample: block.sample.index };
            let path =
                Path { pixel, drawn, through: Vec3::ONE, travelled: 0.0, blur: 0.0, bounces: 0, layers: 0, media };
            hit_of(self.frame, &ray, hits.triangles.of_lanes[lane]).map(|hit| Meeting { ray, hit, path })
        };
        for (((number, light), emitter), lit) in self.lights.iter().enumerate().zip(self.emitters).zip(self.lit) {
            let lit = slots.lit(lit) & met.lit_lanes();
            if lit != 0 {
                let (mut reflected, faces) = met.reflected(simd, emitter, number >= self.first_sky_light);
                let is_lit = faces & mask32x16::from_bitmask(simd, lit.into());
                let mut tint = through;
                if !PLAIN && self.plan.tints() && light.casts_shadow {
                    tint = Vectors::load(simd, &self.tints(&meeting, light, is_lit.to_bitmask() as u16));
                    reflected = reflected * tint;
                }
                radiance = Vectors::select(is_lit, radiance + reflected, radiance);
                if let Some(sum) = &mut caught_light {
                    *sum = Vectors::select(is_lit, *sum + met.caught_share(simd, emitter) * tint, *sum);
                }
            }
        }
        let color = self.seen_color(simd, &rays, &met, through, radiance, &[0; LANES]);
        let mut passing = met.where_shown(simd, Vectors::splat(simd, Vec3::ZERO), through);
        if !PLAIN {
            passing = met.passing(simd, through);
            if met.leads_on(passing) {
                self.go_on(
                    &meeting,
                    &met.ways(simd, &rays, &hits, [through, passing], self.plan.gloss),
                    &mut queue.next,
                );
            }
            if self.around_light() == AroundLight::Near {
                self.look_around_from(simd, &met, through, f32x16::splat(simd, 1.0), &meeting, &mut queue.shadows);
            }
        }
        let bare = match (&met.caught, caught_light) {
            (Some(caught), Some(light)) => Vectors::select(caught.lanes, light, passing),
            _ => passing,
        };
        // Opaque where numbers overflow.
        let coverage = 1.0 - bare.mean();
        Shaded {
            color: color.store(),
            flat: self.flat(simd, &met, through, bare, color, u16::MAX),
            coverage: coverage.min_precise(1.0).max_precise(-BRIGHTEST).into(),
            shown: hits.shown,
            depth: hits.depth.min_precise(f32::MAX).into(),
            normal: met.surface.normal.store(),
            triangle: hits.triangles.of_lanes,
        }
    }

    /// Shades the hits of up to sixteen secondary rays, and adds them to the film. The rays that they spawn wait in the
    /// queue; contributions of lights wait in `shadows` for their shadow rays.
    #[inline(always)]
    pub(super) fn shade_onward<S: Simd>(
        &self,
        simd: S,
        onward: &[Onward],
        found: &[Option<Hit>],
        queue: &mut Vec<Onward>,
        shadows: &mut Vec<Shadow>,
        film: &mut Strip<'_>,
    ) {
        let lanes = Lanes::new(onward, found, &self.frame.materials.materials);
        let through = Vectors::load(simd, &lanes.through);
        let rays = BlockRays::of_rays(simd, &lanes.rays, f32x16::from_slice(simd, &lanes.travelled));
        // Surfaces seen in mirrors hide nothing of the background.
        let is_straight = f32x16::from_slice(simd, &lanes.bounces.map(|bounces| if bounces == 0 { 1.0 } else { 0.0 }));
        let straight = is_straight.simd_gt(0.0).to_bitmask() as u16;
        let Some(seen) = SeenTriangles::of_found(simd, self.frame, &lanes.found) else {
            let color = (self.around(simd, &rays, &lanes.bounces) * through).at_most_brightest().store();
            let part = (through.mean() * is_straight).into();
            let flat = self.surroundings.are_flat().then(|| Flat { color, part }.only(straight));
            film.add_lanes(onward, &color, flat.as_ref(), &[0.0; LANES]);
            return;
        };
        let hits = BlockHits::of_found(simd, self.frame, &rays, &lanes.found, &seen);
        let mut met = Met::new::<false>(simd, self, &rays, &hits, through, &lanes.bounces);
        met.seen.widen(f32x16::from_slice(simd, &lanes.blur));
        let meeting = |lane: usize| {
            let Onward { ray, path, .. } = onward[lane];
            found[lane].map(|hit| Meeting { ray, hit, path })
        };
        let radiance = self.own_radiance(simd, &met);
        let color = self.seen_color(simd, &rays, &met, through, radiance, &lanes.bounces);
        for ((number, light), emitter) in self.lights.iter().enumerate().zip(self.emitters) {
            let (reflected, faces) = met.reflected(simd, emitter, number >= self.first_sky_light);
            let reflected = (reflected * through.scaled(met.surface.opacity)).at_most_brightest();
            let share = met.caught_share(simd, emitter);
            let adds = reflected.is_something() | share.is_something();
            let lit = met.lit_lanes() & (faces & adds).to_bitmask() as u16;
            let (reflected, bare) = (reflected.store(), Each::from(met.bare(simd, share, through) * is_straight));
            for lane in lanes_of(lit) {
                let Some(Meeting { ray, hit, path }) = meeting(lane) else { continue };
                let (radiance, coverage) = (vector_of(lane, &reflected), -bare[lane]);
                if light.casts_shadow {
                    let ray = ShadowRay::new(&light.source, self.lit_point(&ray, &hit));
                    let (triangle, source, pixel) = (hit.triangle, light.source, path.pixel);
                    shadows.push(Shadow { ray, triangle, source, pixel, radiance, coverage });
                } else {
                    film.add_light(path.pixel, radiance, coverage, self.surroundings.are_flat());
                }
            }
        }
        let passing = met.passing(simd, through);
        if met.leads_on(passing) {
            self.go_on(&meeting, &met.ways(simd, &rays, &hits, [through, passing], self.plan.gloss), queue);
        }
        if self.around_light() == AroundLight::Near {
            self.look_around_from(simd, &met, through, is_straight, &meeting, shadows);
        }
        let bare = match &met.caught {
            Some(caught) => Vectors::select(caught.lanes, caught.ambient * through, passing),
            None => passing,
        };
        let coverage = (through - bare).mean().min_precise(1.0).max_precise(-BRIGHTEST);
        let flat = self.flat(simd, &met, through, bare, color, straight);
        film.add_lanes(onward, &color.store(), flat.as_ref(), &(coverage * is_straight).into());
    }

    /// The part of `color` in `lanes` that is shown without exposure and tone map: unlit surfaces, and a background of
    /// one colour, also behind shadow catchers. `bare` is the visible part of the background.
    #[inline(always)]
    fn flat<S: Simd>(
        &self,
        simd: S,
        met: &Met<S>,
        through: Vectors<S>,
        bare: Vectors<S>,
        color: Vectors<S>,
        lanes: u16,
    ) -> Option<Flat> {
        if !self.has_flat {
            return None;
        }
        let unlit = met.shown & met.surface.unlit;
        let around = if self.surroundings.are_flat() { !met.shown | met.surface.catches } else { 0 };
        let lanes = (unlit | around) & lanes;
        let part =
            mask32x16::from_bitmask(simd, unlit.into()).select(through.mean() * met.surface.opacity, bare.mean());
        (lanes != 0).then(|| Flat { color: color.store(), part: part.into() }.only(lanes))
    }

    /// Radiance that rays bring to the camera: that of surfaces, given, or of the surroundings for a miss.
    #[inline(always)]
    fn seen_color<S: Simd>(
        &self,
        simd: S,
        rays: &BlockRays<S>,
        met: &Met<S>,
        through: Vectors<S>,
        radiance: Vectors<S>,
        bounces: &Each<u32>,
    ) -> Vectors<S> {
        let color = radiance * through.scaled(met.surface.opacity);
        if met.shown == u16::MAX {
            return color.at_most_brightest();
        }
        let around = self.around(simd, rays, bounces) * through;
        Vectors::select(mask32x16::from_bitmask(simd, met.shown.into()), color, around).at_most_brightest()
    }

    /// How light from the surroundings arrives.
    #[inline(always)]
    pub(super) fn around_light(&self) -> AroundLight {
        if self.first_sky_light < self.lights.len() {
            AroundLight::Lights
        } else if self.plan.around > 0.0 {
            AroundLight::Near
        } else {
            AroundLight::Even
        }
    }

    /// Queues contributions from the surroundings that anything within the ambient-occlusion radius blocks.
    #[inline(always)]
    fn look_around_from<S: Simd>(
        &self,
        simd: S,
        met: &Met<S>,
        through: Vectors<S>,
        is_straight: f32x16<S>,
        meeting: &dyn Fn(usize) -> Option<Meeting>,
        shadows: &mut Vec<Shadow>,
    ) {
        let Met { surface, seen, caught, .. } = met;
        let irradiance = self.surroundings.irradiance(simd, surface.normal).scaled(surface.ambient_occlusion);
        let mut scattered = seen.diffuse();
        if let Some(layers) = &surface.layers {
            scattered += layers.scattered(simd);
        }
        scattered = (scattered * irradiance * through.scaled(surface.opacity)).at_most_brightest();
        let mut bare = f32x16::splat(simd, 0.0);
        if let Some(caught) = caught {
            scattered = Vectors::select(caught.lanes, caught.around * caught.near * through, scattered);
            bare = met.bare(simd, caught.near, through) * is_straight;
        }
        let lanes = met.lit_lanes() & (scattered.is_something().to_bitmask() as u16 | surface.catches);
        let (scattered, bare, normal) = (scattered.store(), Each::from(bare), surface.normal.store());
        for lane in lanes_of(lanes) {
            let Some(meeting) = meeting(lane) else { continue };
            let normal = vector_of(lane, &normal).as_dvec3().normalize();
            self.look_around(&meeting, normal, vector_of(lane, &scattered), -bare[lane], shadows);
        }
    }

    /// The origin of a hit's shadow rays.
    pub(super) fn lit_point(&self, ray: &Ray, hit: &Hit) -> HitPoint {
        let smooth = self.smooth_terminator.then(|| smooth_point(self.frame, ray, hit)).flatten();
        smooth.unwrap_or_else(|| HitPoint::new(ray, hit.t))
    }

    /// Radiance of the surroundings for rays that miss. Transparent surroundings are seen only after a bounce.
    #[inline(always)]
    pub(super) fn around<S: Simd>(&self, simd: S, rays: &BlockRays<S>, bounces: &Each<u32>) -> Vectors<S> {
        let radiance = self.surroundings.radiance(simd, rays.unit_direction());
        if !self.surroundings.are_transparent() {
            return radiance;
        }
        let is_seen = f32x16::from_slice(simd, &bounces.map(|bounces| bounces.min(1) as f32));
        radiance.scaled(is_seen)
    }

    /// Radiance that surfaces emit, and that they reflect from the surroundings. Mirrors and glass that secondary rays
    /// follow are left out.
    #[inline(always)]
    fn own_radiance<S: Simd>(&self, simd: S, met: &Met<S>) -> Vectors<S> {
        let Met { surface, seen, mirrored, .. } = met;
        let nothing = Vectors::splat(simd, Vec3::ZERO);
        let (mut from, mut roughness) = (*mirrored, surface.reflectance.roughness());
        if let Some(layers) = &surface.layers {
            (from, roughness) = layers.reflection([surface.normal, surface.view], (from, roughness));
        }
        let mut surrounding = self.surroundings.blurred(simd, from, roughness);
        let is_mirror = surface.reflectance.is_mirror().to_bitmask() as u16;
        let (followed, coats_followed) = if self.plan.gloss {
            (met.mirrors | met.glass, met.mirrors)
        } else {
            // Below a coat that is a mirror, the base reflects the surroundings, unless it is a mirror too.
            (met.mirrors & (is_mirror | !met.coat_mirrors) | met.glass & is_mirror, met.coat_mirrors)
        };
        if followed != 0 {
            surrounding = Vectors::select(mask32x16::from_bitmask(simd, followed.into()), nothing, surrounding);
        }
        let is_even = self.around_light() == AroundLight::Even;
        let irradiance = if is_even { self.surroundings.irradiance(simd, surface.normal) } else { nothing };
        let (mut ambient, mut emitted) = (seen.ambient(irradiance, surrounding), surface.emitted);
        if let Some(layers) = &surface.layers {
            ambient += layers.ambient(simd, self.surroundings, irradiance, coats_followed);
            emitted = layers.emitted(emitted);
        }
        if met.is_inside() != 0 {
            ambient = Vectors::select(mask32x16::from_bitmask(simd, met.is_inside().into()), nothing, ambient);
        }
        let mut radiance = emitted + ambient.scaled(surface.ambient_occlusion);
        if let Some(caught) = &met.caught {
            radiance = Vectors::select(caught.lanes, caught.around * caught.ambient, radiance);
        }
        if surface.unlit == 0 {
            return radiance;
        }
        Vectors::select(mask32x16::from_bitmask(simd, surface.unlit.into()), surface.base_color, radiance)
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
            let plain = Settings { width: 61, height: 47, samples: 2, ..Settings::default() };
            let drawn = Settings { bounces: 2, gloss: true, ambient_occlusion: 0.5, ..plain.clone() };
            let smooth = Settings { smooth_terminator: true, ..drawn.clone() };
            for settings in [plain, drawn, smooth] {
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

    #[test]
    fn nothing_is_left_of_an_earlier_picture() {
        let full = crate::open("demo:hall?triangles=600").unwrap().at(0.2).unwrap();
        let small = Frame::from_triangles(vec![Vec3::ZERO, Vec3::X, Vec3::Y], vec![[0, 1, 2]]);
        let sky = Settings { width: 61, height: 47, ..Settings::default() };
        let flat = Settings { background: Background::Color(Vec3::ONE), ..sky.clone() };
        for after in [flat.clone(), Settings { samples: 4, ..flat.clone() }, sky.clone()] {
            for before in [&sky, &flat] {
                let (mut again, mut fresh) = (Renderer::default(), Renderer::default());
                again.render_frame(&full, before).unwrap();
                let [again, fresh] =
                    [&mut again, &mut fresh].map(|by| by.render_frame(&small, &after).unwrap().clone());
                assert!(fresh.triangle.contains(&0) && fresh.triangle.contains(&Film::NO_TRIANGLE));
                assert_eq!((&again.color, &again.flat, &again.depth), (&fresh.color, &fresh.flat, &fresh.depth));
                assert_eq!((&again.normal, &again.triangle), (&fresh.normal, &fresh.triangle));
            }
        }
    }

    #[test]
    fn films_are_finite_however_bright_it_is() {
        let positions =
            [[-2., 0., -2.], [2., 0., -2.], [2., 0., 2.], [-2., 0., 2.], [-1., 0., 0.], [1., 0., 0.], [0., 1., 0.]];
        let triangles = vec![[0, 2, 1], [0, 3, 2], [4, 5, 6]];
        let lamp = |height: f32, intensity: f32| Light {
            color: Vec3::splat(intensity.min(1e10)),
            ..Light::new(LightSource::Point { position: Vec3::new(0.1, height, 0.2) }, intensity)
        };
        let clay = Material { base_color: Vec4::splat(1.0), ..Material::default() };
        let huge = f32::MAX;
        let materials = [
            Material { emissive: Vec3::splat(huge), ..clay.clone() },
            Material { base_color: Vec4::splat(huge), ..clay.clone() },
            Material { base_color: Vec4::splat(-huge), alpha: Alpha::Blend, ..clay.clone() },
            Material { base_color: Vec4::splat(huge), transmission: huge, ..clay.clone() },
            Material { base_color: Vec4::splat(-huge), transmission: -huge, ..clay.clone() },
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
