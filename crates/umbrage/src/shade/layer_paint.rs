use fearless_simd::Simd;
use glam::Vec3;
use umbrage_scene::{Anisotropy, Clearcoat, Frame, Iridescence, Layers, Sheen, Specular};

use super::hits::BlockHits;
use super::lanes::{Each, LANES, each, lanes_of, put};
use super::paint::{Bumps, MaterialLanes};
use super::texels::Texels;

/// Parameters of the layers of the lanes' materials, textures included. A lane without a layer has neutral values.
pub(super) struct LayerPaint {
    /// Strength of the dielectric reflection.
    pub(super) specular: Each<f32>,
    pub(super) specular_color: [Each<f32>; 3],
    pub(super) coat: Each<f32>,
    pub(super) coat_roughness: Each<f32>,
    pub(super) coat_bumps: Bumps,
    pub(super) sheen_color: [Each<f32>; 3],
    pub(super) sheen_roughness: Each<f32>,
    /// Strength of the highlights' stretch.
    pub(super) stretch: Each<f32>,
    /// The direction of the stretch, as a bump without height.
    pub(super) grooves: Bumps,
    pub(super) film: Each<f32>,
    pub(super) film_ior: Each<f32>,
    pub(super) film_nanometers: Each<f32>,
    /// The lanes that have each layer, the first in the lowest bit.
    pub(super) specular_lanes: u16,
    pub(super) coat_lanes: u16,
    pub(super) sheen_lanes: u16,
    pub(super) film_lanes: u16,
}

impl LayerPaint {
    /// The thickest film, in nanometres: a thicker one interferes beyond the eye's resolution of colours.
    const THICKEST_NANOMETERS: f32 = 1e5;

    pub(super) fn new<S: Simd>(frame: &Frame, hits: &BlockHits<'_, S>, texels: &Texels<'_, S>) -> Self {
        let mut paint = Self::nothing();
        for (material, lanes) in MaterialLanes::new(frame, hits) {
            if let Some(layers) = &material.layers {
                paint.read(lanes, layers, texels);
            }
        }
        paint
    }

    fn nothing() -> Self {
        Self {
            specular: each(1.0),
            specular_color: [each(1.0); 3],
            coat: each(0.0),
            coat_roughness: each(0.0),
            coat_bumps: Bumps::none(),
            sheen_color: [each(0.0); 3],
            sheen_roughness: each(1.0),
            stretch: each(0.0),
            grooves: Bumps::none(),
            film: each(0.0),
            film_ior: each(1.0),
            film_nanometers: each(0.0),
            specular_lanes: 0,
            coat_lanes: 0,
            sheen_lanes: 0,
            film_lanes: 0,
        }
    }

    fn read<S: Simd>(&mut self, lanes: u16, layers: &Layers, texels: &Texels<'_, S>) {
        let Layers { specular, clearcoat, sheen, anisotropy, iridescence } = layers;
        if *specular != Specular::default() {
            self.read_specular(lanes, specular, texels);
        }
        if clearcoat.factor > 0.0 {
            self.read_coat(lanes, clearcoat, texels);
        }
        if sheen.color != Vec3::ZERO {
            self.read_sheen(lanes, sheen, texels);
        }
        if anisotropy.strength > 0.0 {
            self.read_grooves(lanes, anisotropy, texels);
        }
        if iridescence.factor > 0.0 {
            self.read_film(lanes, iridescence, texels);
        }
    }

    fn read_specular<S: Simd>(&mut self, lanes: u16, specular: &Specular, texels: &Texels<'_, S>) {
        self.specular_lanes |= lanes;
        let [_, _, _, strength] = texels.read_any(specular.texture, lanes);
        let [red, green, blue, _] = texels.read_any(specular.color_texture, lanes);
        for lane in lanes_of(lanes) {
            self.specular[lane] = (specular.factor * strength[lane]).clamp(0.0, 1.0);
            let texel = Vec3::new(red[lane], green[lane], blue[lane]);
            put(lane, (specular.color * texel).max(Vec3::ZERO), &mut self.specular_color);
        }
    }

    fn read_coat<S: Simd>(&mut self, lanes: u16, coat: &Clearcoat, texels: &Texels<'_, S>) {
        self.coat_lanes |= lanes;
        let [strength, ..] = texels.read_any(coat.texture, lanes);
        let [_, roughness, ..] = texels.read_any(coat.roughness_texture, lanes);
        for lane in lanes_of(lanes) {
            self.coat[lane] = (coat.factor * strength[lane]).clamp(0.0, 1.0);
            self.coat_roughness[lane] = coat.roughness * roughness[lane];
        }
        if let Some(texture) = coat.normal_texture {
            self.coat_bumps.read(lanes, texels, texture, coat.normal_scale);
        }
    }

    fn read_sheen<S: Simd>(&mut self, lanes: u16, sheen: &Sheen, texels: &Texels<'_, S>) {
        self.sheen_lanes |= lanes;
        let [red, green, blue, _] = texels.read_any(sheen.color_texture, lanes);
        let [_, _, _, roughness] = texels.read_any(sheen.roughness_texture, lanes);
        for lane in lanes_of(lanes) {
            let texel = Vec3::new(red[lane], green[lane], blue[lane]);
            put(lane, (sheen.color * texel).clamp(Vec3::ZERO, Vec3::ONE), &mut self.sheen_color);
            self.sheen_roughness[lane] = sheen.roughness * roughness[lane];
        }
    }

    fn read_grooves<S: Simd>(&mut self, lanes: u16, anisotropy: &Anisotropy, texels: &Texels<'_, S>) {
        // Without a texture, along the tangent with full strength.
        let [x, y, strength] = match anisotropy.texture {
            Some(texture) => {
                let [x, y, strength, _] = texels.read(texture, lanes);
                [x.map(|texel| texel * 2.0 - 1.0), y.map(|texel| texel * 2.0 - 1.0), strength]
            }
            None => [each(1.0), each(0.0), each(1.0)],
        };
        // The same on all machines.
        let (sine, cosine) = libm::sincosf(anisotropy.rotation_radians);
        let mut turned = [[0.0; LANES]; 3];
        for lane in lanes_of(lanes) {
            turned[0][lane] = x[lane] * cosine - y[lane] * sine;
            turned[1][lane] = x[lane] * sine + y[lane] * cosine;
            self.stretch[lane] = (anisotropy.strength * strength[lane]).clamp(0.0, 1.0);
        }
        let set = anisotropy.texture.map_or(0, |texture| texture.tex_coord_set);
        self.grooves.set(lanes, texels, set, &turned);
    }

    fn read_film<S: Simd>(&mut self, lanes: u16, film: &Iridescence, texels: &Texels<'_, S>) {
        self.film_lanes |= lanes;
        let [strength, ..] = texels.read_any(film.texture, lanes);
        let [_, thickness, ..] = texels.read_any(film.thickness_texture, lanes);
        let Iridescence { thickness_minimum_nanometers: least, thickness_maximum_nanometers: most, .. } = *film;
        for lane in lanes_of(lanes) {
            self.film[lane] = (film.factor * strength[lane]).clamp(0.0, 1.0);
            self.film_ior[lane] = film.ior.clamp(1.0, 1e3);
            let nanometers = least * (1.0 - thickness[lane]) + most * thickness[lane];
            self.film_nanometers[lane] = nanometers.clamp(0.0, Self::THICKEST_NANOMETERS);
        }
    }
}
