use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, mask32x16};
use glam::Vec3;

use super::caught::Caught;
use super::shade::Shading;
use crate::shade::gloss::Gloss;
use crate::shade::lanes::{BRIGHTEST, Each, Vectors};
use crate::shade::{BlockHits, BlockRays, Emitter, SeenReflectance, Surface};

/// The surfaces that sixteen rays meet.
pub(super) struct Met<S: Simd> {
    pub(super) surface: Surface<S>,
    pub(super) seen: SeenReflectance<S>,
    /// Shadow catchers among them.
    pub(super) caught: Option<Caught<S>>,
    /// The directions of reflection at the surface's normal.
    pub(super) mirrored: Vectors<S>,
    /// The directions that mirrors lead in: those of a coat may differ.
    leads: Vectors<S>,
    /// The mirrors' weight, per colour, towards the camera.
    pub(super) mirrored_through: Vectors<S>,
    /// The lanes with a hit.
    pub(super) shown: u16,
    /// The lanes whose mirrors are followed.
    pub(super) mirrors: u16,
    /// Those of `mirrors` whose mirror is a coat.
    pub(super) coat_mirrors: u16,
    /// The lanes where light is followed into glass or out of it.
    pub(super) glass: u16,
}

impl<S: Simd> Met<S> {
    /// The surfaces of hits, with `PLAIN` of plain materials alone ([`Plan::ends_at`](crate::plan::Plan::ends_at)).
    #[inline(always)]
    pub(super) fn new<const PLAIN: bool>(
        simd: S,
        shading: &Shading<'_>,
        rays: &BlockRays<S>,
        hits: &BlockHits<'_, S>,
        through: Vectors<S>,
        bounces: &Each<u32>,
    ) -> Self {
        let mut surface =
            Surface::new::<PLAIN>(simd, shading.frame, rays, hits, &shading.footprint, shading.smooth_terminator);
        // Lanes without a hit have a surface without a meaning.
        surface.catches &= hits.shown;
        let seen = surface.reflectance.seen(simd, surface.normal, surface.view, surface.layers.as_ref());
        let mirrored = surface.normal.scaled(2.0 * surface.view.dot(surface.normal)) - surface.view;
        let mut leads = mirrored;
        let mut mirrored_through = through.scaled(surface.opacity) * seen.specular();
        let mut is_mirror = surface.reflectance.is_mirror();
        let mut coat_mirrors = mask32x16::splat(simd, false);
        if let Some(layers) = &surface.layers {
            (coat_mirrors, leads, mirrored_through) =
                layers.coat_mirror(simd, is_mirror, (mirrored, mirrored_through), through.scaled(surface.opacity));
            is_mirror |= coat_mirrors;
        }
        let mut follows = 0;
        if !PLAIN && shading.plan.bounces > 0 {
            follows = bounces.iter().rev().fold(0_u16, |bits, &by| bits << 1 | u16::from(by < shading.plan.bounces));
        }
        let (mut mirrors, mut glass) = (0, 0);
        if follows != 0 {
            let lanes = follows & hits.shown & !surface.unlit & !surface.catches;
            glass = lanes & surface.volume & surface.transmitted.is_something().to_bitmask() as u16;
            // A bent normal may mirror rays into the triangle.
            let is_outside = surface.geometric_normal.dot(leads).simd_gt(0.0);
            let mut is_seen = mirrored_through.largest().simd_gt(shading.plan.least);
            let mut is_followed = is_mirror & is_outside;
            if shading.plan.gloss {
                is_followed |= is_outside | !is_mirror;
                if let Some(layers) = &surface.layers {
                    let of_coat = through.scaled(surface.opacity * layers.coat_albedo(simd));
                    is_seen |= of_coat.largest().simd_gt(shading.plan.least);
                }
            }
            mirrors = (is_followed & is_seen).to_bitmask() as u16 & lanes & !glass;
        }
        let coat_mirrors = coat_mirrors.to_bitmask() as u16 & mirrors;
        let around = || shading.around(simd, rays, bounces);
        let caught =
            if PLAIN || surface.catches == 0 { None } else { Some(Caught::new(simd, shading, &surface, around())) };
        Self {
            surface,
            seen,
            caught,
            mirrored,
            leads,
            mirrored_through,
            shown: hits.shown,
            mirrors,
            coat_mirrors,
            glass,
        }
    }

    /// The lanes that show glass from inside, where light arrives only along followed rays.
    #[inline(always)]
    pub(super) fn is_inside(&self) -> u16 {
        self.glass & !self.surface.front
    }

    /// The lanes that lights can light.
    #[inline(always)]
    pub(super) fn lit_lanes(&self) -> u16 {
        self.shown & !self.surface.unlit & !self.is_inside()
    }

    /// Radiance that a light adds where it reaches the surface, and the lanes that it can reach. A light of the sky is only
    /// scattered.
    #[inline(always)]
    pub(super) fn reflected(&self, simd: S, light: &Emitter, is_of_sky: bool) -> (Vectors<S>, mask32x16<S>) {
        let Self { surface, seen, .. } = self;
        let arriving = light.arriving(simd, surface.position);
        let cosine = surface.normal.dot(arriving.towards).max(0.0);
        // Light from behind the triangle lights its other side, regardless of the bent normal.
        let faces = surface.lit_side.dot(arriving.towards).simd_gt(0.0);
        let layers = surface.layers.as_ref();
        let irradiance = arriving.irradiance.scaled(cosine);
        let reflected = if is_of_sky { seen.diffuse() } else { seen.evaluate(simd, arriving.towards, layers) };
        let mut reflected = reflected * irradiance;
        if let Some(layers) = layers {
            reflected += if is_of_sky { layers.scattered(simd) * irradiance } else { layers.lit(simd, &arriving) };
        }
        match &self.caught {
            Some(caught) => {
                (Vectors::select(caught.lanes, caught.around * self.caught_share(simd, light), reflected), faces)
            }
            None => (reflected, faces),
        }
    }

    /// A light's share of the light on shadow catchers; zero in other lanes.
    #[inline(always)]
    pub(super) fn caught_share(&self, simd: S, light: &Emitter) -> Vectors<S> {
        match &self.caught {
            Some(caught) => caught.share(simd, &self.surface, light),
            None => Vectors::splat(simd, Vec3::ZERO),
        }
    }

    /// The opacity that shadow catchers lose where this share of their light reaches them.
    #[inline(always)]
    pub(super) fn bare(&self, simd: S, share: Vectors<S>, through: Vectors<S>) -> f32x16<S> {
        let nothing = f32x16::splat(simd, 0.0);
        match &self.caught {
            Some(caught) => caught.lanes.select((share * through).mean(), nothing).min_precise(BRIGHTEST),
            None => nothing,
        }
    }

    /// Weight towards the camera, per colour, of the radiance straight behind.
    #[inline(always)]
    pub(super) fn passing(&self, simd: S, through: Vectors<S>) -> Vectors<S> {
        let Self { surface, seen, glass, .. } = self;
        let one = Vectors::splat(simd, Vec3::ONE);
        // Mirrored light doesn't pass.
        let mut transmitted = surface.transmitted * seen.entering();
        if *glass != 0 {
            let nothing = Vectors::splat(simd, Vec3::ZERO);
            transmitted = Vectors::select(mask32x16::from_bitmask(simd, (*glass).into()), nothing, transmitted);
        }
        let passing = one.lerp(transmitted, surface.opacity);
        self.where_shown(simd, through * passing, through)
    }

    /// `one` in the lanes with a hit, `other` in the others.
    #[inline(always)]
    pub(super) fn where_shown(&self, simd: S, one: Vectors<S>, other: Vectors<S>) -> Vectors<S> {
        Vectors::select(mask32x16::from_bitmask(simd, self.shown.into()), one, other)
    }

    /// The lanes in which the scene straight behind is visible.
    #[inline(always)]
    pub(super) fn behind(&self, passing: Vectors<S>) -> u16 {
        self.shown & passing.largest().simd_gt(0.0).to_bitmask() as u16
    }

    /// Whether these hits spawn secondary rays.
    #[inline(always)]
    pub(super) fn leads_on(&self, passing: Vectors<S>) -> bool {
        self.mirrors | self.glass | self.behind(passing) != 0
    }

    #[inline(always)]
    pub(super) fn ways(
        &self,
        simd: S,
        rays: &BlockRays<S>,
        hits: &BlockHits<'_, S>,
        [through, passing]: [Vectors<S>; 2],
        has_gloss: bool,
    ) -> Ways {
        let Self { surface, mirrors, glass, .. } = self;
        let [mirrors, glass, behind, volume, front] =
            [*mirrors, *glass, self.behind(passing), surface.volume, surface.front];
        Ways {
            mirrors,
            glass,
            behind,
            volume,
            front,
            is_smooth: surface.reflectance.is_mirror().to_bitmask() as u16,
            mirrored: self.leads.store(),
            mirrored_through: self.mirrored_through.store(),
            passing: passing.store(),
            surface_through: through.scaled(surface.opacity).store(),
            transmitted: surface.transmitted.store(),
            normal: surface.normal.store(),
            geometric_normal: surface.geometric_normal.store(),
            travelled: (rays.travelled + hits.depth).into(),
            gloss: has_gloss.then(|| self.seen.gloss(simd, surface.layers.as_ref())),
        }
    }
}

/// The onward directions of sixteen rays at their hits, with weights, lane by lane.
pub(super) struct Ways {
    /// The lanes with a followed mirror, with glass, and with a visible scene straight behind.
    pub(super) mirrors: u16,
    pub(super) glass: u16,
    pub(super) behind: u16,
    /// The lanes whose surface bounds a volume, whose front is visible, and that are smooth.
    pub(super) volume: u16,
    pub(super) front: u16,
    pub(super) is_smooth: u16,
    /// The directions that mirrors lead in, and their weights towards the camera.
    pub(super) mirrored: [Each<f32>; 3],
    pub(super) mirrored_through: [Each<f32>; 3],
    /// Weights towards the camera of the radiance straight behind.
    pub(super) passing: [Each<f32>; 3],
    /// Weights towards the camera of the surface's own radiance.
    pub(super) surface_through: [Each<f32>; 3],
    /// The surface's transmittance for light from behind.
    pub(super) transmitted: [Each<f32>; 3],
    pub(super) normal: [Each<f32>; 3],
    pub(super) geometric_normal: [Each<f32>; 3],
    /// Distance from the surface to the camera.
    pub(super) travelled: Each<f32>,
    /// Parameters of rough surfaces' reflection, where it is followed.
    pub(super) gloss: Option<Gloss>,
}
