//! Pictures of the pixels' hits, in place of light.

use glam::{DVec2, DVec3, Vec3};
use rayon::prelude::*;
use umbrage_rays::{Ray, View};
use umbrage_scene::Frame;

use crate::Film;
use crate::panorama::linear_from_srgb;

/// The data that a picture shows in place of light. All are of the pixel's first sample, so edges are hard.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PixelView {
    /// World-space shading normals: red is x, green is y, blue is z, each from -1 (dark) to 1 (bright).
    #[default]
    Normals,
    /// The first texture coordinates: red is u, green is v, both without their whole part. Black where a mesh has none.
    Uv,
    /// Depth along the camera's axis: white at the nearest hit, darker farther away. The farthest hundredth of the pixels is
    /// as dark as the one just before it.
    Depth,
    /// Edges of triangles, a pixel wide to each side, over grey that is darker where a surface is seen at an angle.
    Wireframe,
}

impl PixelView {
    /// Replaces the colours of a film of `frame` by those of this view. Exposure and tone map leave them as they are. Misses
    /// become black and uncovered; a film without a [view](Film::view), or without
    /// [first hits](crate::Settings::first_hits), stays as it is.
    pub fn paint(self, film: &mut Film, frame: &Frame) {
        let Some(view) = film.view.filter(|_| !film.triangle.is_empty()) else { return };
        let depths = if self == Self::Depth { depth_range(&film.depth) } else { [0.0, 1.0] };
        let (width, depth, normal) = (film.width as usize, &film.depth, &film.normal);
        let colors = film.triangle.par_iter().enumerate().map(|(pixel, &triangle)| {
            if triangle == Film::NO_TRIANGLE {
                return Vec3::ZERO.extend(0.0);
            }
            let at = [pixel % width, pixel / width].map(|at| at as f64 + 0.5);
            let encoded = match self {
                Self::Normals => normal[pixel] * 0.5 + 0.5,
                Self::Uv => uv(frame, &view, triangle, at.into()),
                Self::Depth => {
                    let [nearest, farthest] = depths;
                    Vec3::splat(1.0 - 0.9 * ((depth[pixel] - nearest) / (farthest - nearest)).clamp(0.0, 1.0))
                }
                Self::Wireframe => wire(frame, &view, triangle, at.into()),
            };
            let encoded = encoded.clamp(Vec3::ZERO, Vec3::ONE);
            Vec3::from(encoded.to_array().map(linear_from_srgb)).extend(1.0)
        });
        film.color = colors.collect();
        film.flat.clone_from(&film.color);
    }
}

/// The least depth, and the depth that at most one in a hundred of the pixels with a hit exceeds.
fn depth_range(depth: &[f32]) -> [f32; 2] {
    let mut depths: Vec<f32> = depth.iter().copied().filter(|depth| depth.is_finite()).collect();
    if depths.is_empty() {
        return [0.0, 1.0];
    }
    let index = (depths.len() - 1) * 99 / 100;
    let (nearer, &mut farthest, _) = depths.select_nth_unstable_by(index, f32::total_cmp);
    let nearest = nearer.iter().copied().fold(farthest, f32::min);
    [nearest, farthest.max(nearest + f32::MIN_POSITIVE + nearest.abs() * 1e-6)]
}

/// Weights of a triangle's corners at the crossing of a ray with its plane; NaN or infinite where the ray is parallel.
fn weights([a, b, c]: [DVec3; 3], ray: &Ray) -> DVec3 {
    let (ab, ac, from_a) = (b - a, c - a, ray.origin - a);
    let normal = ab.cross(ac);
    let across = from_a.cross(ray.direction);
    let scale = -ray.direction.dot(normal).recip();
    let (second, third) = (ac.dot(across) * scale, -ab.dot(across) * scale);
    DVec3::new(1.0 - second - third, second, third)
}

fn corners(frame: &Frame, triangle: u32) -> [DVec3; 3] {
    frame.triangles().corners(triangle).map(Vec3::as_dvec3)
}

fn uv(frame: &Frame, view: &View, triangle: u32, at: DVec2) -> Vec3 {
    let coords = &frame.mesh.tex_coords[0];
    let of_corners = frame.mesh.triangles[triangle as usize].map(|vertex| coords.get(vertex as usize).copied());
    let [Some(a), Some(b), Some(c)] = of_corners else { return Vec3::ZERO };
    let [first, second, third] = weights(corners(frame, triangle), &view.ray(at.x, at.y)).to_array();
    let uv = a.as_dvec2() * first + b.as_dvec2() * second + c.as_dvec2() * third;
    let parts = (uv - uv.floor()).as_vec2();
    if parts.is_finite() { parts.extend(0.0) } else { Vec3::ZERO }
}

fn wire(frame: &Frame, view: &View, triangle: u32, at: DVec2) -> Vec3 {
    const LINE: f32 = 0.08;
    let corners = corners(frame, triangle);
    let ray = view.ray(at.x, at.y);
    let here = weights(corners, &ray);
    let right = weights(corners, &view.ray(at.x + 1.0, at.y)) - here;
    let down = weights(corners, &view.ray(at.x, at.y + 1.0)) - here;
    // Weights are zero on the edges and grow by this much a pixel.
    let slope = (right * right + down * down).to_array().map(f64::sqrt);
    let distances = here.to_array().into_iter().zip(slope).map(|(weight, slope)| weight.abs() / slope);
    let distance = distances.fold(f64::INFINITY, f64::min);
    let [a, b, c] = corners;
    let normal = (b - a).cross(c - a).normalize_or_zero();
    let facing = ray.direction.normalize_or_zero().dot(normal).abs() as f32;
    let grey = 0.45 + 0.4 * facing;
    // An edge is the line of both its triangles, each of which draws its half.
    let covered = (1.0 - distance as f32).clamp(0.0, 1.0);
    Vec3::splat(grey + (LINE - grey) * covered)
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::{Vec2, Vec4};
    use umbrage_rays::Camera;

    use super::*;
    use crate::{Settings, ToneMap};

    const SIDE: u32 = 64;

    /// The colour of the pixel at x, y. The picture's middle half is filled by the lower left half of a square, from -1 to
    /// 1.
    fn shown(view: PixelView, at: [u32; 2]) -> [i32; 3] {
        let positions = vec![Vec3::new(-1.0, -1.0, 0.0), Vec3::new(1.0, -1.0, 0.0), Vec3::new(-1.0, 1.0, 0.0)];
        let coords = vec![Vec2::ZERO, Vec2::new(1.0, 0.0), Vec2::new(0.0, 0.5)];
        let mut frame = Frame::from_triangles(positions, vec![[0, 1, 2]]);
        Arc::make_mut(&mut frame.mesh).tex_coords[0] = coords;
        let camera = Camera::look_at(Vec3::new(0.0, 0.0, 4.0), Vec3::ZERO, Vec3::Y, 2.0 * 0.5_f32.atan());
        let pixels = (SIDE * SIDE) as usize;
        let is_hit = |pixel: usize| {
            let (x, y) = (pixel as u32 % SIDE, pixel as u32 / SIDE);
            (16..48).contains(&x) && (16..48).contains(&y) && x <= y
        };
        let mut film = Film {
            width: SIDE,
            height: SIDE,
            color: vec![Vec4::ONE; pixels],
            depth: (0..pixels)
                .map(|pixel| if is_hit(pixel) { (pixel as u32 % SIDE) as f32 } else { f32::INFINITY })
                .collect(),
            normal: vec![Vec3::Z; pixels],
            triangle: (0..pixels).map(|pixel| if is_hit(pixel) { 0 } else { Film::NO_TRIANGLE }).collect(),
            view: Some(View { camera, width: SIDE, height: SIDE }),
            ..Film::default()
        };
        view.paint(&mut film, &frame);
        let settings = Settings { exposure_stops: -2.0, tone_map: ToneMap::PbrNeutral, ..Settings::default() };
        let image = film.develop(&settings);
        image.pixels[(at[1] * SIDE + at[0]) as usize].map(|channel| i32::from(channel) * 255 / 65535)
    }

    fn assert_near(shown: [i32; 3], expected: [i32; 3]) {
        assert!(
            shown.iter().zip(expected).all(|(shown, expected)| shown.abs_diff(expected) <= 2),
            "{shown:?} {expected:?}"
        );
    }

    #[test]
    fn a_film_without_first_hits_stays_as_it_is() {
        let frame = Frame::from_triangles(vec![Vec3::ZERO, Vec3::X, Vec3::Y], vec![[0, 1, 2]]);
        let settings = Settings { width: 5, height: 4, first_hits: false, ..Settings::default() };
        let mut film = crate::Renderer::default().render_frame(&frame, &settings).unwrap().clone();
        let color = film.color.clone();
        PixelView::Depth.paint(&mut film, &frame);
        assert!(film.view.is_some() && film.color == color && color.len() == 20);
    }

    #[test]
    fn normals_are_colors_whatever_the_exposure_is() {
        assert_near(shown(PixelView::Normals, [20, 40]), [127, 127, 255]);
        assert_eq!(shown(PixelView::Normals, [2, 2]), [0; 3]);
    }

    #[test]
    fn texture_coordinates_are_red_and_green() {
        // 8.5 of 32 pixels from the left edge, 15.5 from the lower one, where v is half as much.
        assert_near(shown(PixelView::Uv, [24, 32]), [68, 62, 0]);
    }

    #[test]
    fn what_is_near_is_white() {
        assert_near(shown(PixelView::Depth, [16, 40]), [255; 3]);
        assert_near(shown(PixelView::Depth, [47, 47]), [25; 3]);
    }

    #[test]
    fn edges_are_dark_lines() {
        let [inside, edge] = [[24, 36], [16, 36]].map(|at| shown(PixelView::Wireframe, at)[0]);
        assert!((200..=220).contains(&inside), "{inside}");
        // The pixel's middle is half a pixel from the edge.
        assert!((105..=130).contains(&edge), "{edge}");
        assert!(shown(PixelView::Wireframe, [19, 36])[0].abs_diff(inside) <= 3, "three pixels away");
    }
}
