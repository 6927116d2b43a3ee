use bytemuck::{Pod, Zeroable};
use umbrage_rays::{Cone, LightSource};

use super::records::light_words;
use crate::grid::words;

/// A light for shadow questions, as in `light.wgsl`.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct ShadowLight {
    vector: [u32; 3],
    is_directional: u32,
    axis: [f32; 3],
    has_cone: u32,
    squared_cosine: [u32; 2],
    casts_shadow: u32,
    packet: u32,
    mask: u32,
    tints: u32,
    unused: [u32; 2],
}

impl ShadowLight {
    /// `None` stands for a light without shadows. Its mask starts at the word `mask`, the transmittances at the word
    /// `tints`, and a packet has `packet` questions.
    #[must_use]
    pub fn new(light: Option<&LightSource>, packet: u32, mask: u32, tints: u32) -> Self {
        let cone = light.and_then(Cone::of);
        let [x, y, z, is_directional] = light.map_or([0; 4], light_words);
        Self {
            vector: [x, y, z],
            is_directional,
            axis: cone.map_or([0.0; 3], |cone| cone.axis.as_vec3().to_array()),
            has_cone: u32::from(cone.is_some()),
            squared_cosine: words(cone.map_or(0.0, |cone| cone.squared_cosine)),
            casts_shadow: u32::from(light.is_some()),
            packet,
            mask,
            tints,
            unused: [0; 2],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layout::{differences, layout, module};
    use crate::link::link;

    #[test]
    fn parameters_are_those_of_the_shaders() {
        let light = layout!(ShadowLight {
            vector,
            is_directional,
            axis,
            has_cone,
            squared_cosine,
            casts_shadow,
            packet,
            mask,
            tints
        });
        for path in ["rays::lit", "onward::ask", "onward::tinted"] {
            assert_eq!(differences(&module(&link(path)), &light), [""; 0], "{path}");
        }
    }
}
