use bytemuck::{Pod, Zeroable};
use glam::DVec3;
use umbrage_rays::{Cone, LightSource, View};

use super::LightOptions;
use crate::Geometry;

/// A light's parameters, as in `light.wgsl`.
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
    has_clamp: u32,
    axis: [f32; 3],
    slices: u32,
    squared_cosine: [u32; 2],
    unused_of_cosine: [u32; 2],
    along_rows: [f32; 3],
    unused_of_rows: u32,
    clamp_low: [i32; 2],
    clamp_high: [i32; 2],
}

impl LightParameters {
    pub(super) fn new(
        light: &LightSource,
        [side_of_one, side_of_six]: [u32; 2],
        geometry: &Geometry,
        mask: u32,
        slots: u32,
        view: &View,
        options: LightOptions,
    ) -> Self {
        let (vector, is_directional) = match *light {
            LightSource::Point { position } | LightSource::Spot { position, .. } => (position, 0),
            LightSource::Directional { direction } => (direction, 1),
        };
        let everywhere = Cone { apex: DVec3::ZERO, axis: DVec3::ZERO, squared_cosine: 0.0 };
        let cone = Cone::of(light).unwrap_or(everywhere);
        // An orthographic camera's rays start beside it.
        let beside = match view.camera.projection {
            umbrage_rays::Projection::Perspective { .. } => 0.0,
            umbrage_rays::Projection::Orthographic { half_height } => {
                half_height * (1.0 + view.width as f32 / view.height as f32)
            }
        };
        let [left, right, low, high] = options.clamp.map_or([0; 4], |clamp| clamp.map(angle_units));
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
            has_clamp: options.clamp.is_some().into(),
            axis: cone.axis.as_vec3().to_array(),
            slices: options.slices,
            squared_cosine: bytemuck::cast(cone.squared_cosine),
            unused_of_cosine: [0; 2],
            along_rows: view.camera.right.to_array(),
            unused_of_rows: 0,
            clamp_low: [left, low],
            clamp_high: [right, high],
        }
    }
}

/// Converts an angle to the units of `sphere/turn.wgsl`.
fn angle_units(degrees: f32) -> i32 {
    let (across, along) = f64::from(degrees).to_radians().sin_cos();
    let part = across / (across.abs() + along.abs());
    let part = if along < 0.0 { 2.0_f64.copysign(across) - part } else { part };
    (part * f64::from(1 << 28)) as i32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layout::{Layout, differences, layout, module};
    use crate::link::link;

    #[test]
    fn lights_are_those_of_the_shaders() {
        let shader = module(&link("light::cone"));
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
            has_clamp,
            axis,
            slices,
            squared_cosine,
            along_rows,
            clamp_low,
            clamp_high,
        });
        assert_eq!(differences(&shader, &Layout { name: "Light", ..layout }), [""; 0]);
    }

    #[test]
    fn angles_are_counted_in_their_order() {
        let quarters = [-180.0, -90.0, 0.0, 90.0, 180.0].map(angle_units);
        for (units, quarter) in quarters.into_iter().zip(-2..=2) {
            assert!(units.abs_diff(quarter << 28) <= 1, "{units}");
        }
        assert!((-180..180).all(|degrees| angle_units(degrees as f32) < angle_units(degrees as f32 + 1.0)));
    }
}
