//! Attributes of the picture as a whole: the camera, and names for the numbers in its layers.

use std::collections::HashMap;

use ::exr::prelude::{LayerAttributes, Text, attribute::AttributeValue};
use glam::{Mat4, Vec3, Vec4};
use umbrage_rays::{Camera, Projection, View};

use super::cryptomatte;
use crate::Film;
use crate::output::FrameRate;

/// An attribute's name and value.
pub(super) type Attribute = (Text, AttributeValue);

/// All attributes of a film; `rate` for frames of an animation.
pub(super) fn attributes(film: &Film, rate: Option<FrameRate>) -> LayerAttributes {
    let mut attributes = film.view.as_ref().map_or_else(LayerAttributes::default, of_view);
    attributes.frames_per_second =
        rate.and_then(|rate| Some((i32::try_from(rate.numerator()).ok()?, rate.denominator())));
    let mut others = cryptomatte::attributes(&film.layers);
    if !film.layers.object.is_empty() {
        let names: Vec<&str> = film.layers.objects.iter().map(|name| &**name).collect();
        others.push((text("umbrage/objects"), AttributeValue::Text(text(&ascii_json(&names.into())))));
    }
    if film.origin != [0.0; 3] {
        // The f32 matrices are relative to this origin, where they are exact enough.
        let origin = serde_json::Value::from(film.origin.as_slice()).to_string();
        others.push((text("umbrage/origin"), AttributeValue::Text(text(&origin))));
    }
    attributes.other = in_order(&others);
    attributes
}

/// OpenEXR's standard camera attributes. Points are row vectors there, so the rows of its matrices are columns of ours.
fn of_view(view: &View) -> LayerAttributes {
    let aspect = view.width as f32 / view.height as f32;
    let (half_height, fov_degrees) = match view.camera.projection {
        Projection::Perspective { tan_half_height } => {
            let degrees = |tan_half: f32| f64::from(tan_half).atan().to_degrees() * 2.0;
            let degrees = [tan_half_height * aspect, tan_half_height].map(|tan_half| degrees(tan_half) as f32);
            (tan_half_height, Some(degrees))
        }
        Projection::Orthographic { half_height } => (half_height, None),
    };
    let camera_from_world = camera_from_world(&view.camera);
    let ndc_from_world = ndc_from_camera(&view.camera, half_height, aspect) * camera_from_world;
    LayerAttributes {
        screen_window_width: 2.0 * half_height * aspect,
        world_to_camera: Some(camera_from_world.to_cols_array()),
        world_to_normalized_device: Some(ndc_from_world.to_cols_array()),
        horizontal_field_of_view: fov_degrees.map(|[horizontal, _]| horizontal),
        vertical_field_of_view: fov_degrees.map(|[_, vertical]| vertical),
        ..LayerAttributes::default()
    }
}

/// From world to camera axes: right, up and into the image.
fn camera_from_world(camera: &Camera) -> Mat4 {
    let Camera { position, right, up, forward, .. } = *camera;
    let axes = Mat4::from_cols(right.extend(0.0), up.extend(0.0), forward.extend(0.0), Vec4::W).transpose();
    axes * Mat4::from_translation(-position)
}

/// From camera to image: (0, 0) at its upper left and (1, 1) at its lower right corner, and the depth or, in
/// perspective, one over it.
fn ndc_from_camera(camera: &Camera, half_height: f32, aspect: f32) -> Mat4 {
    let [x, y] = [0.5 / (half_height * aspect), -0.5 / half_height];
    let middle = Vec3::new(0.5, 0.5, 0.0);
    match camera.projection {
        Projection::Perspective { .. } => Mat4::from_cols(Vec4::X * x, Vec4::Y * y, middle.extend(1.0), Vec4::Z),
        Projection::Orthographic { .. } => Mat4::from_cols(Vec4::X * x, Vec4::Y * y, Vec4::Z, middle.extend(1.0)),
    }
}

/// A name or a text of ASCII.
pub(super) fn text(ascii: &str) -> Text {
    Text::from_slice_unchecked(ascii.as_bytes())
}

/// JSON with non-ASCII letters escaped: no reader takes them for Latin-1.
pub(super) fn ascii_json(value: &serde_json::Value) -> String {
    let json = value.to_string();
    let mut ascii = String::with_capacity(json.len());
    for letter in json.chars() {
        match letter {
            _ if letter.is_ascii() => ascii.push(letter),
            _ => letter.encode_utf16(&mut [0; 2]).iter().for_each(|unit| ascii.push_str(&format!("\\u{unit:04x}"))),
        }
    }
    ascii
}

/// A map that iterates over the attributes in this order. They are written in the map's order, which is random for
/// every map, and the same picture should be the same bytes.
fn in_order(attributes: &[Attribute]) -> HashMap<Text, AttributeValue> {
    /// Of five attributes, one of 120 maps has them in order.
    const MOST_MAPS: usize = 10_000;
    let numbered = || attributes.iter().enumerate().map(|(number, (name, _))| (name.clone(), number));
    let is_in_order = |map: &HashMap<Text, usize>| map.values().copied().eq(0..attributes.len());
    let maps = (0..MOST_MAPS).map(|_| numbered().collect::<HashMap<Text, usize>>());
    let found = maps.into_iter().find(is_in_order).unwrap_or_else(|| numbered().collect());
    let hasher = found.hasher().clone();
    let mut map = HashMap::with_capacity_and_hasher(found.capacity(), hasher);
    map.extend(attributes.iter().cloned());
    map
}

#[cfg(test)]
mod tests {
    use super::*;

    /// As OpenEXR's readers multiply: a point as a row.
    fn transformed(point: Vec3, matrix: &[f32; 16]) -> [f64; 3] {
        let row = point.extend(1.0).as_dvec4().to_array();
        let [x, y, z, w] =
            [0, 1, 2, 3].map(|column| (0..4).map(|of| row[of] * f64::from(matrix[4 * of + column])).sum::<f64>());
        [x / w, y / w, z / w]
    }

    #[test]
    fn matrices_say_where_the_image_shows_points() {
        let camera = Camera::look_at(Vec3::new(3.1, -1.7, 2.3), Vec3::ZERO, Vec3::Y, 0.83);
        let parallel = Camera { projection: Projection::Orthographic { half_height: 1.7 }, ..camera };
        for camera in [camera, parallel] {
            let view = View { camera, width: 640, height: 360 };
            let attributes = of_view(&view);
            let (to_camera, to_ndc) =
                (attributes.world_to_camera.unwrap(), attributes.world_to_normalized_device.unwrap());
            for (x, y, depth) in [(0.0, 0.0, 1.0), (640.0, 360.0, 2.5), (160.0, 90.0, 7.0)] {
                let ray = view.ray(x, y);
                let point = (ray.origin + ray.direction * depth).as_vec3();
                let [right, up, into] = transformed(point, &to_camera);
                assert!((into - depth).abs() < 1e-5 && right.signum() == (x - 320.0).signum());
                assert!(up.signum() == (180.0 - y).signum());
                let [across, down, _] = transformed(point, &to_ndc);
                assert!((across - x / 640.0).abs() < 1e-5 && (down - y / 360.0).abs() < 1e-5, "{across}, {down}");
                // The screen window is at depth 1, or anywhere with parallel rays.
                let depth = if attributes.vertical_field_of_view.is_some() { depth } else { 1.0 };
                let of_window = right / depth / f64::from(attributes.screen_window_width);
                assert!((of_window - (x / 640.0 - 0.5)).abs() < 1e-5);
            }
        }
        let degrees = of_view(&View { camera, width: 640, height: 360 }).vertical_field_of_view.unwrap();
        assert!((degrees.to_radians() - 0.83).abs() < 1e-6);
    }

    #[test]
    fn attributes_keep_their_order() {
        let attributes: Vec<Attribute> =
            ["d", "a", "c", "e", "b"].map(|name| (text(name), AttributeValue::I32(1))).into();
        for _ in 0..20 {
            let map = in_order(&attributes).clone();
            let names: Vec<String> = map.keys().map(ToString::to_string).collect();
            assert_eq!(names, ["d", "a", "c", "e", "b"]);
        }
    }
}
