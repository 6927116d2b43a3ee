//! The plan of a frame's secondary rays, for both engines: the surfaces from which rays go on, and where paths end.

use umbrage_scene::{Frame, Material};

use crate::Settings;
use crate::shade::SMOOTHEST;

/// The secondary rays of a frame, and their limits.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Plan {
    /// Maximum number of bounces on a path.
    pub(crate) bounces: u32,
    /// Minimum throughput in mirrors and glass: without it, panes behind panes would mirror each other endlessly.
    pub(crate) least: f32,
    /// Whether rough surfaces mirror as well.
    pub(crate) gloss: bool,
    /// Ambient-occlusion radius in world units; 0 with a single sample, since one direction says nothing.
    pub(crate) around: f32,
    /// Whether any surface is blended or transmissive.
    pub(crate) is_see_through: bool,
    /// Whether rays from any mirror are followed.
    pub(crate) mirrors: bool,
}

impl Plan {
    /// Number of surfaces in a row from which rays with a throughput below [`LEAST_PART`](Self::LEAST_PART) end.
    pub(crate) const MANY_LAYERS: u32 = 32;
    /// Number of surfaces in a row from which only opaque ones stop a ray, so that every ray ends.
    pub(crate) const MOST_LAYERS: u32 = 256;
    /// About a quarter of a level, of 255, of a white pixel.
    pub(crate) const LEAST_PART: f32 = 1.0 / 1024.0;

    /// The plan for a frame.
    pub(crate) fn new(settings: &Settings, frame: &Frame) -> Self {
        let limits = Self::limits(settings);
        let mirrors = |material: &Material| mirrors(material, limits.gloss);
        Self {
            is_see_through: frame.is_see_through(),
            mirrors: limits.bounces > 0 && frame.materials.materials.iter().any(mirrors),
            ..limits
        }
    }

    /// The limits that settings set, for a frame that isn't known yet.
    pub(crate) fn limits(settings: &Settings) -> Self {
        let Settings { bounces, least_contribution: least, gloss, ambient_occlusion, samples, .. } = *settings;
        let (gloss, around) = if samples > 1 { (gloss, ambient_occlusion) } else { (false, 0.0) };
        Self { bounces, least, gloss, around, ..Self::default() }
    }

    /// Whether any surface may spawn secondary rays.
    pub(crate) fn goes_on(self) -> bool {
        self.is_see_through || self.around > 0.0 || self.mirrors
    }

    /// Whether all light from a material's surfaces is known without secondary rays, and the surfaces are opaque and of one
    /// layer, as most are.
    pub(crate) fn ends_at(&self, material: &Material) -> bool {
        let is_followed = self.around > 0.0 || self.tints() || self.bounces > 0 && mirrors(material, self.gloss);
        let is_opaque = !material.is_see_through() && !material.bounds_volume();
        is_opaque && !is_followed && material.layers.is_none() && !material.catches_shadows
    }

    /// Whether see-through surfaces tint the light that passes them.
    pub(crate) fn tints(self) -> bool {
        self.bounces > 0 && self.is_see_through
    }
}

/// Whether rays mirrored by a material may be followed.
fn mirrors(material: &Material, gloss: bool) -> bool {
    let Material { roughness, metallic_roughness_texture, unlit, layers, .. } = material;
    let coat_is_smooth = layers.as_ref().is_some_and(|layers| {
        let coat = &layers.clearcoat;
        coat.factor > 0.0 && (coat.roughness <= SMOOTHEST || coat.roughness_texture.is_some())
    });
    !unlit && (gloss || *roughness <= SMOOTHEST || metallic_roughness_texture.is_some() || coat_is_smooth)
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::Vec3;
    use umbrage_scene::Alpha;

    use super::*;

    fn frame(material: Material) -> Frame {
        let mut frame = Frame::from_triangles(vec![Vec3::ZERO, Vec3::X, Vec3::Y], vec![[0, 1, 2]]);
        Arc::make_mut(&mut frame.materials).materials = vec![material];
        frame
    }

    #[test]
    fn rays_go_on_only_where_a_surface_and_the_settings_let_them() {
        let rough = Material { roughness: 0.5, ..Material::default() };
        let mirror = Material { roughness: 0.0, ..Material::default() };
        let unlit = Material { unlit: true, ..mirror.clone() };
        let pane = Material { alpha: Alpha::Blend, ..rough.clone() };
        let one = Settings { samples: 1, gloss: true, ambient_occlusion: 1.0, ..Settings::default() };
        let bounces = Settings { bounces: 1, ..one.clone() };
        let glossy = Settings { samples: 4, ambient_occlusion: 0.0, ..bounces.clone() };
        let around = Settings { samples: 4, ..one.clone() };
        let goes_on = |material: &Material| {
            [&one, &bounces, &glossy, &around].map(|settings| Plan::new(settings, &frame(material.clone())).goes_on())
        };
        assert_eq!(goes_on(&rough), [false, false, true, true]);
        assert_eq!(goes_on(&mirror), [false, true, true, true]);
        assert_eq!(goes_on(&unlit), [false, false, false, true]);
        assert_eq!(goes_on(&pane), [true; 4]);
        let tints = |material: &Material| Plan::new(&bounces, &frame(material.clone())).tints();
        assert_eq!([tints(&pane), tints(&mirror)], [true, false]);
        assert!(!Plan::new(&one, &frame(pane.clone())).tints());
        let ends_at =
            |settings: &Settings, material: &Material| Plan::new(settings, &frame(material.clone())).ends_at(material);
        let end = |material: &Material| [&one, &bounces, &glossy, &around].map(|settings| ends_at(settings, material));
        assert_eq!(end(&rough), [true, true, false, false]);
        assert_eq!(end(&mirror), [true, false, false, false]);
        let catcher = Material { catches_shadows: true, ..rough.clone() };
        for other in [pane, catcher, Material { layers: Some(Box::default()), ..rough.clone() }] {
            assert_eq!(end(&other), [false; 4]);
        }
        // Beside panes, light is tinted everywhere.
        let beside = Plan { is_see_through: true, ..Plan::new(&bounces, &frame(rough.clone())) };
        assert!(!beside.ends_at(&rough));
    }
}
