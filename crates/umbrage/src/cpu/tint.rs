use std::cell::RefCell;

use glam::{DVec3, Vec3};
use umbrage_rays::predicate::ShadowRay;
use umbrage_rays::{LightSource, Opacity as _};
use umbrage_scene::Light;

use super::onward::Meeting;
use super::shade::Shading;
use crate::shade::glass::attenuation;
use crate::shade::lanes::{Each, LANES, lanes_of, put};

impl Shading<'_> {
    /// The transmittance for a light, in red, green and blue, on its way to a point of a triangle; `None` where an occluder
    /// lets nothing pass. Light goes straight: refraction in glass isn't followed.
    ///
    /// Where rays aren't followed into glass, a triangle stops all light or none.
    pub(super) fn arriving_through(&self, source: &LightSource, ray: &ShadowRay, triangle: u32) -> Option<Vec3> {
        let (triangles, opacity) = (self.frame.triangles(), self.frame.shadow_opacity());
        let passed = RefCell::new(Vec::new());
        let is_blocked = self.rays_onward.blocked(triangles, ray, triangle, &|id, barycentric| {
            if !self.sides.stop_light(source, id, triangles.corners(id)) {
                return false;
            }
            let stops = opacity.stops(id, barycentric);
            if !stops && self.plan.tints() {
                passed.borrow_mut().push((id, barycentric));
            }
            stops
        });
        (!is_blocked).then(|| self.tint(source, ray.point(), passed.into_inner()))
    }

    /// Transmittances for a light in lanes that it is known to reach.
    #[cold]
    pub(super) fn tints(
        &self,
        meeting: &dyn Fn(usize) -> Option<Meeting>,
        light: &Light,
        lanes: u16,
    ) -> [Each<f32>; 3] {
        let mut tints = [[0.0; LANES]; 3];
        for lane in lanes_of(lanes) {
            let Some(Meeting { ray, hit, .. }) = meeting(lane) else { continue };
            let ray = ShadowRay::new(&light.source, self.lit_point(&ray, &hit));
            put(lane, self.arriving_through(&light.source, &ray, hit.triangle).unwrap_or(Vec3::ZERO), &mut tints);
        }
        tints
    }

    /// The transmittance of triangles on the light's straight way to a point.
    fn tint(&self, source: &LightSource, point: DVec3, mut passed: Vec<(u32, [f32; 2])>) -> Vec3 {
        // The product doesn't depend on the order in which a structure reports triangles, nor on repetitions.
        passed.sort_unstable_by_key(|&(id, _)| id);
        passed.dedup_by_key(|&mut (id, _)| id);
        let mut left = Vec3::ONE;
        // Lengths of the way through volumes, by material.
        let mut inside: Vec<(u32, f64)> = Vec::new();
        for (id, barycentric) in passed {
            left *= self.frame.passing(id, barycentric);
            if !self.frame.material(id).bounds_volume() {
                continue;
            }
            let [a, b, c] = self.frame.triangles().corners(id).map(Vec3::as_dvec3);
            let [v, w] = barycentric.map(f64::from);
            let crossing = a + (b - a) * v + (c - a) * w;
            let towards_light = match *source {
                LightSource::Directional { direction } => -direction.as_dvec3(),
                LightSource::Point { position } | LightSource::Spot { position, .. } => position.as_dvec3() - crossing,
            };
            // Seen from the point, a volume ends where its front shows the light, and begins where its back does.
            let sign = (b - a).cross(c - a).dot(towards_light).signum();
            let material = self.frame.mesh.material_of_triangle[id as usize];
            let length = crossing.distance(point) * sign;
            match inside.iter_mut().find(|(of, _)| *of == material) {
                Some((_, sum)) => *sum += length,
                None => inside.push((material, length)),
            }
        }
        for (material, length) in inside {
            left *= attenuation(&self.frame.materials.materials[material as usize], length as f32);
        }
        left
    }
}
