use glam::Vec3;
use umbrage_scene::{Anisotropy, Clearcoat, Frame, Iridescence, Layers, Sheen, Specular};

use super::hits::LaneHits;
use super::lanes::{Each, LANES, each, put};
use super::paint::{Bumps, Texels};

/// What the layers of the lanes' materials say, textures included. A lane without a layer has the numbers of one that does
/// nothing.
pub(super) struct LayerPaint {
    /// How much of what isn't metal mirrors.
    pub(super) specular: Each<f32>,
    pub(super) specular_color: [Each<f32>; 3],
    pub(super) coat: Each<f32>,
    pub(super) coat_roughness: Each<f32>,
    pub(super) coat_bumps: Bumps,
    pub(super) sheen_color: [Each<f32>; 3],
    pub(super) sheen_roughness: Each<f32>,
    /// How strongly highlights are stretched.
    pub(super) stretch: Each<f32>,
    /// The direction of the stretch, as a bump without height.
    pub(super) grooves: Bumps,
    pub(super) film: Each<f32>,
    pub(super) film_ior: Each<f32>,
    pub(super) film_nanometers: Each<f32>,
    /// The lanes that have each of them, the first in the lowest bit.
    pub(super) specular_lanes: u16,
    pub(super) coat_lanes: u16,
    pub(super) sheen_lanes: u16,
    pub(super) film_lanes: u16,
}

impl LayerPaint {
    /// A film of more interferes with no light that the eye tells apart.
    const THICKEST_NANOMETERS: f32 = 1e5;

    /// `covered_triangles` is the area of each ray's cone on the surface, in triangle areas.
    pub(super) fn new(frame: &Frame, hits: &LaneHits, covered_triangles: &Each<f32>) -> Self {
        let mut paint = Self::nothing();
        for lane in 0..LANES {
            let material = frame.mesh.material_of_triangle[hits.triangle[lane] as usize];
            let Some(layers) = &frame.materials.materials[material as usize].layers else { continue };
            if hits.shown >> lane & 1 == 1 {
                paint.read(lane, layers, &Texels::of_lane(frame, hits, covered_triangles, lane));
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

    fn read(&mut self, lane: usize, layers: &Layers, texels: &Texels<'_>) {
        let Layers { specular, clearcoat, sheen, anisotropy, iridescence } = layers;
        if *specular != Specular::default() {
            self.read_specular(lane, specular, texels);
        }
        if clearcoat.factor > 0.0 {
            self.read_coat(lane, clearcoat, texels);
        }
        if sheen.color != Vec3::ZERO {
            self.read_sheen(lane, sheen, texels);
        }
        if anisotropy.strength > 0.0 {
            self.read_grooves(lane, anisotropy, texels);
        }
        if iridescence.factor > 0.0 {
            self.read_film(lane, iridescence, texels);
        }
    }

    fn read_specular(&mut self, lane: usize, specular: &Specular, texels: &Texels<'_>) {
        self.specular_lanes |= 1 << lane;
        let texel = specular.texture.map_or(1.0, |texture| texels.read(texture).w);
        self.specular[lane] = (specular.factor * texel).clamp(0.0, 1.0);
        let texel = specular.color_texture.map_or(Vec3::ONE, |texture| texels.read(texture).truncate());
        put(lane, (specular.color * texel).max(Vec3::ZERO), &mut self.specular_color);
    }

    fn read_coat(&mut self, lane: usize, coat: &Clearcoat, texels: &Texels<'_>) {
        self.coat_lanes |= 1 << lane;
        let texel = coat.texture.map_or(1.0, |texture| texels.read(texture).x);
        self.coat[lane] = (coat.factor * texel).clamp(0.0, 1.0);
        let texel = coat.roughness_texture.map_or(1.0, |texture| texels.read(texture).y);
        self.coat_roughness[lane] = coat.roughness * texel;
        if let Some(texture) = coat.normal_texture {
            self.coat_bumps.read(lane, texels, texture, coat.normal_scale);
        }
    }

    fn read_sheen(&mut self, lane: usize, sheen: &Sheen, texels: &Texels<'_>) {
        self.sheen_lanes |= 1 << lane;
        let texel = sheen.color_texture.map_or(Vec3::ONE, |texture| texels.read(texture).truncate());
        put(lane, (sheen.color * texel).clamp(Vec3::ZERO, Vec3::ONE), &mut self.sheen_color);
        let texel = sheen.roughness_texture.map_or(1.0, |texture| texels.read(texture).w);
        self.sheen_roughness[lane] = sheen.roughness * texel;
    }

    fn read_grooves(&mut self, lane: usize, anisotropy: &Anisotropy, texels: &Texels<'_>) {
        let (mut direction, mut strength) = (Vec3::X, anisotropy.strength);
        let mut set = 0;
        if let Some(texture) = anisotropy.texture {
            let texel = texels.read(texture);
            direction = Vec3::new(texel.x * 2.0 - 1.0, texel.y * 2.0 - 1.0, 0.0);
            strength *= texel.z;
            set = texture.tex_coord_set;
        }
        // The same on all machines.
        let (sine, cosine) = libm::sincosf(anisotropy.rotation_radians);
        let turned =
            Vec3::new(direction.x * cosine - direction.y * sine, direction.x * sine + direction.y * cosine, 0.0);
        self.stretch[lane] = strength.clamp(0.0, 1.0);
        self.grooves.set(lane, texels, set, turned);
    }

    fn read_film(&mut self, lane: usize, film: &Iridescence, texels: &Texels<'_>) {
        self.film_lanes |= 1 << lane;
        let texel = film.texture.map_or(1.0, |texture| texels.read(texture).x);
        self.film[lane] = (film.factor * texel).clamp(0.0, 1.0);
        self.film_ior[lane] = film.ior.clamp(1.0, 1e3);
        let texel = film.thickness_texture.map_or(1.0, |texture| texels.read(texture).y);
        let Iridescence { thickness_minimum_nanometers: least, thickness_maximum_nanometers: most, .. } = *film;
        self.film_nanometers[lane] = (least * (1.0 - texel) + most * texel).clamp(0.0, Self::THICKEST_NANOMETERS);
    }
}
