use std::f32::consts::FRAC_1_PI;

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, mask32x16};
use glam::Vec3;

use super::brdf::Reflectance;
use super::coat::Coat;
use super::film::Film;
use super::gloss::GlossyLayers;
use super::grooves::Grooves;
use super::irradiance::Arriving;
use super::lanes::{LANES, Vectors};
use super::layer_paint::LayerPaint;
use super::sheen::Sheen;
use crate::background::Surroundings;

/// The rarer layers of materials, beyond metal, colour and roughness, seen from one side. A layer that no lane has is left
/// out; lanes without a layer have a neutral one.
#[derive(Clone, Copy)]
pub(crate) struct Layers<S: Simd> {
    /// Layers that shape the specular layer.
    pub(super) film: Option<Film<S>>,
    pub(super) grooves: Option<Grooves<S>>,
    /// The lanes that mirror in colours of their own.
    pub(super) tinting: mask32x16<S>,
    /// Layers on top.
    sheen: Option<Sheen<S>>,
    coat: Option<Coat<S>>,
    /// The part of the light from below that sheen and coat leave, and that the coat alone leaves.
    pub(super) below: f32x16<S>,
    below_coat: f32x16<S>,
}

impl<S: Simd> Layers<S> {
    /// Layers for the unit `normal` of the surface, that of its coat, and the unit direction of the view; `groove` is the
    /// direction in which highlights are stretched.
    #[inline(always)]
    pub(super) fn new(
        simd: S,
        paint: &LayerPaint,
        reflectance: &mut Reflectance<S>,
        [normal, coat_normal, groove]: [Vectors<S>; 3],
        view: Vectors<S>,
    ) -> Self {
        let one = f32x16::splat(simd, 1.0);
        let tinting = mask32x16::from_bitmask(simd, (paint.specular_lanes | paint.film_lanes).into());
        let mut layers =
            Self { film: None, grooves: None, tinting, sheen: None, coat: None, below: one, below_coat: one };
        if paint.grooves.lanes != 0 {
            let lanes = mask32x16::from_bitmask(simd, paint.grooves.lanes.into());
            let strength = f32x16::from_slice(simd, &paint.stretch);
            let grooves = Grooves::new(lanes, groove, strength, reflectance.roughness(), [normal, view]);
            reflectance.roughen(grooves.mean_roughness(reflectance.roughness()));
            layers.grooves = Some(grooves);
        }
        if paint.film_lanes != 0 {
            let [part, ior, nanometers] = [&paint.film, &paint.film_ior, &paint.film_nanometers];
            let (part, ior) = (f32x16::from_slice(simd, part), f32x16::from_slice(simd, ior));
            let nanometers = f32x16::from_slice(simd, nanometers);
            let n_v = normal.dot(view).max(1e-4);
            layers.film = Some(Film::new(simd, [part, ior, nanometers], reflectance.f0(), n_v));
        }
        if paint.coat_lanes != 0 {
            let [factor, roughness] = [&paint.coat, &paint.coat_roughness];
            let (factor, roughness) = (f32x16::from_slice(simd, factor), f32x16::from_slice(simd, roughness));
            let coat = Coat::new(factor, roughness, [coat_normal, view]);
            layers.below_coat = 1.0 - coat.part;
            layers.coat = Some(coat);
        }
        layers.below = layers.below_coat;
        if paint.sheen_lanes != 0 {
            let (color, roughness) =
                (Vectors::load(simd, &paint.sheen_color), f32x16::from_slice(simd, &paint.sheen_roughness));
            let sheen = Sheen::new(simd, color, roughness, [normal, view]);
            layers.below *= sheen.below();
            layers.sheen = Some(sheen);
        }
        layers
    }

    /// Radiance that the layers on top reflect of a light.
    #[inline(always)]
    pub(crate) fn lit(&self, simd: S, arriving: &Arriving<S>) -> Vectors<S> {
        let mut reflected = Vectors::splat(simd, Vec3::ZERO);
        if let Some(sheen) = &self.sheen {
            reflected += sheen.lit(simd, arriving.towards).scaled(self.below_coat);
        }
        if let Some(coat) = &self.coat {
            reflected = reflected.raised(coat.lit(simd, arriving.towards));
        }
        reflected * arriving.irradiance
    }

    /// Radiance that the layers on top scatter of light from all around, for each unit of irradiance.
    #[inline(always)]
    pub(crate) fn scattered(&self, simd: S) -> Vectors<S> {
        match &self.sheen {
            Some(sheen) => sheen.albedo().scaled(self.below_coat * FRAC_1_PI),
            None => Vectors::splat(simd, Vec3::ZERO),
        }
    }

    /// Radiance that the layers on top reflect of the surroundings, with the `irradiance` of the surface. In `followed`
    /// lanes the coat's part is left out.
    #[inline(always)]
    pub(crate) fn ambient(
        &self,
        simd: S,
        surroundings: &Surroundings<'_>,
        irradiance: Vectors<S>,
        followed: u16,
    ) -> Vectors<S> {
        let nothing = Vectors::splat(simd, Vec3::ZERO);
        let mut reflected = self.scattered(simd) * irradiance;
        if let Some(coat) = &self.coat {
            let (direction, roughness) = coat.reflection();
            let shown = coat.albedo(simd) * surroundings.blurred(simd, direction, roughness);
            reflected += Vectors::select(mask32x16::from_bitmask(simd, followed.into()), nothing, shown);
        }
        reflected
    }

    /// The lanes where the coat is a mirror, the directions of all mirrors, and their weights towards the camera, given
    /// those of the surface below and the weight of the whole surface. Where the surface below a mirroring coat is a mirror
    /// too, its direction stays.
    #[inline(always)]
    pub(crate) fn coat_mirror(
        &self,
        simd: S,
        is_mirror: mask32x16<S>,
        (mirrored, mirrored_through): (Vectors<S>, Vectors<S>),
        through: Vectors<S>,
    ) -> (mask32x16<S>, Vectors<S>, Vectors<S>) {
        let Some(coat) = &self.coat else { return (mask32x16::splat(simd, false), mirrored, mirrored_through) };
        let (direction, _) = coat.reflection();
        let coat_mirrors = coat.is_mirror(simd);
        let of_surface = Vectors::select(is_mirror, mirrored_through, Vectors::splat(simd, Vec3::ZERO));
        let both = of_surface + through * coat.albedo(simd);
        (
            coat_mirrors,
            Vectors::select(coat_mirrors & !is_mirror, direction, mirrored),
            Vectors::select(coat_mirrors, both, mirrored_through),
        )
    }

    /// The coat's weight for the surroundings; zero without a coat.
    #[inline(always)]
    pub(crate) fn coat_albedo(&self, simd: S) -> f32x16<S> {
        self.coat.as_ref().map_or(f32x16::splat(simd, 0.0), |coat| coat.albedo(simd).x)
    }

    /// The layers' effect on microfacets, lane by lane, given their reflectance at grazing angles and their albedo.
    #[inline(always)]
    pub(super) fn gloss(&self, simd: S, f90: f32x16<S>, albedo: f32x16<S>) -> GlossyLayers {
        let nothing = || ([0.0; LANES], [[0.0; LANES]; 3]);
        let (film_part, film_reflected) = self.film.as_ref().map_or_else(nothing, Film::store);
        let (grooves, along, widths) = match &self.grooves {
            Some(grooves) => grooves.store(),
            None => (0, [[0.0; LANES]; 3], [[0.0; LANES]; 2]),
        };
        let (mut coat_part, mut coat_normal) = nothing();
        let (mut coat_alpha, mut coat_mirrors) = ([0.0; LANES], 0);
        if let Some(coat) = &self.coat {
            (coat_part, coat_normal, coat_alpha) = coat.store();
            coat_mirrors = coat.is_mirror(simd).to_bitmask() as u16;
        }
        GlossyLayers {
            f90: f90.into(),
            albedo: albedo.into(),
            film_part,
            film_reflected,
            grooves,
            along,
            widths,
            coat_normal,
            coat_alpha,
            coat_mirrors,
            coat_part,
        }
    }

    /// The part of the light that the surface emits which passes through the coat.
    #[inline(always)]
    pub(crate) fn emitted(&self, emitted: Vectors<S>) -> Vectors<S> {
        emitted.scaled(self.below_coat)
    }

    /// The one direction whose light stands for the specular layer's whole reflection, and the perceptual roughness to blur
    /// it with.
    #[inline(always)]
    pub(crate) fn reflection(
        &self,
        surface: [Vectors<S>; 2],
        round: (Vectors<S>, f32x16<S>),
    ) -> (Vectors<S>, f32x16<S>) {
        match &self.grooves {
            Some(grooves) => grooves.reflection(surface, round),
            None => round,
        }
    }
}
