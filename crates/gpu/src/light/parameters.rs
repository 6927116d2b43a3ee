use bytemuck::{Pod, Zeroable};
use umbrage_rays::{LightSource, View};

use crate::Geometry;

/// A light, as in `light.wgsl`.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(super) struct LightParameters {
    vector: [f32; 3],
    is_directional: u32,
    side_of_one: u32,
    side_of_six: u32,
    vertices: u32,
    triangles: u32,
    mask: u32,
    slots: u32,
    reach: f32,
    unused: u32,
}

impl LightParameters {
    pub(super) fn new(
        light: &LightSource,
        [side_of_one, side_of_six]: [u32; 2],
        geometry: &Geometry,
        mask: u32,
        slots: u32,
        view: &View,
    ) -> Self {
        let (vector, is_directional) = match *light {
            LightSource::Point { position } | LightSource::Spot { position, .. } => (position, 0),
            LightSource::Directional { direction } => (direction, 1),
        };
        // Of an orthographic camera, rays start beside it.
        let beside = match view.camera.projection {
            umbrage_rays::Projection::Perspective { .. } => 0.0,
            umbrage_rays::Projection::Orthographic { half_height } => {
                half_height * (1.0 + view.width as f32 / view.height as f32)
            }
        };
        Self {
            vector: vector.to_array(),
            is_directional,
            side_of_one,
            side_of_six,
            vertices: geometry.vertex_count(),
            triangles: geometry.triangle_count(),
            mask,
            slots,
            reach: view.camera.position.abs().max_element() + beside,
            unused: 0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layout::{Layout, differences, layout, module};
    use crate::link::link;

    #[test]
    fn lights_are_those_of_the_shaders() {
        let shader = module(&link("light::settle"));
        let layout = layout!(LightParameters {
            vector,
            is_directional,
            side_of_one,
            side_of_six,
            vertices,
            triangles,
            mask,
            slots,
            reach,
        });
        assert_eq!(differences(&shader, &Layout { name: "Light", ..layout }), [""; 0]);
    }
}
