//! Answers a shot by single rays, one for each pixel and one for each point and light. This makes a structure of any
//! [`SingleRays`].

use crate::parallel::Parallel;
use rayon::prelude::*;

use crate::predicate::ShadowRay;
use crate::shot::{Cone, LightMask, Opacity, OpacityOfSides, SeenPixels, Shot, TileOrder};
use crate::{Hit, LightSource, Ray, Triangles};

/// A structure that answers single rays, of any origin and direction.
///
/// `triangles` are always those that it was built over.
pub trait SingleRays: Sync {
    /// The nearest hit of `ray` for which `stops` is true; at equal t the one with the lowest triangle id. `None` for a
    /// miss.
    ///
    /// Hits for which `stops` is false are passed through: use it for alpha masks and back faces.
    fn nearest(&self, triangles: Triangles<'_>, ray: &Ray, stops: &dyn Fn(&Hit) -> bool) -> Option<Hit> {
        self.nearest_from(triangles, ray, SeenPixels::NONE, stops)
    }

    /// As [`nearest`](Self::nearest), without the triangle `own`, on which the ray starts: its hit would be at a t of about
    /// zero, which takes the predicate longest.
    fn nearest_from(&self, triangles: Triangles<'_>, ray: &Ray, own: u32, stops: &dyn Fn(&Hit) -> bool) -> Option<Hit>;

    /// Whether any triangle but `own` shadows the point of `shadow_ray`.
    ///
    /// Triangles for which `stops`, given an id and the weights of the second and third vertex, is false let the light
    /// through.
    fn blocked(
        &self,
        triangles: Triangles<'_>,
        shadow_ray: &ShadowRay,
        own: u32,
        stops: &dyn Fn(u32, [f32; 2]) -> bool,
    ) -> bool;
}

/// Finds the triangle that each pixel sees, as [`Structure::see`](crate::Structure::see) does.
pub fn see(rays: &dyn SingleRays, shot: &Shot<'_>, seen: &mut SeenPixels) {
    seen.resize(shot.view.width, shot.view.height);
    let order = seen.order();
    let opacity: &dyn Opacity = &OpacityOfSides::of_camera(shot);
    let stops = |hit: &Hit| opacity.is_stopped_at(hit.triangle, hit.barycentric);
    let pixels = seen.triangle.par_iter_mut().zip(&mut seen.inverse_depth).enumerate();
    pixels.each(|(index, (triangle, inverse_depth))| {
        let pixel = order.pixel(index);
        let nearest = pixel.and_then(|(x, y)| rays.nearest(shot.triangles, &shot.ray(x, y), &stops));
        *triangle = nearest.map_or(SeenPixels::NONE, |hit| hit.triangle);
        *inverse_depth = nearest.map_or(f32::NAN, |hit| SeenPixels::inverse_of(hit.t));
    });
}

/// Finds which points each light reaches, as [`Structure::shadow`](crate::Structure::shadow) does.
///
/// # Panics
/// If there are more or fewer masks than lights, or `seen` isn't of the size of the shot's view.
pub fn shadow(
    rays: &dyn SingleRays,
    shot: &Shot<'_>,
    seen: &SeenPixels,
    lights: &[LightSource],
    masks: &mut [LightMask],
) {
    shot.expect_masks(seen, lights, masks);
    for (light, mask) in lights.iter().zip(masks) {
        let opacity: &dyn Opacity = &OpacityOfSides::of_light(shot, light);
        let stops = |id: u32, barycentric: [f32; 2]| opacity.is_stopped_at(id, barycentric);
        let cone = Cone::of(light);
        mask.resize(seen.order());
        mask.blocks_mut().par_iter_mut().enumerate().each(|(block, lit)| {
            *lit = 0;
            for lane in 0..TileOrder::BLOCK_PIXELS {
                let index = block * TileOrder::BLOCK_PIXELS + lane;
                let Some(ray) = shot.shadow_ray(seen, index, light) else { continue };
                let is_in_cone = cone.is_none_or(|cone| cone.contains(ray.point()));
                let is_lit = is_in_cone && !rays.blocked(shot.triangles, &ray, seen.triangle[index], &stops);
                *lit |= u16::from(is_lit) << lane;
            }
        });
    }
}
