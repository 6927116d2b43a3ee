//! Shadows of smooth surfaces that triangles stand for: lights are tested at points moved onto the smooth surface (Hanika,
//! *Hacking the Shadow Terminator*, Ray Tracing Gems II, 2021).

use glam::{DVec3, Vec3};
use rayon::prelude::*;
use umbrage_rays::parallel::Parallel;
use umbrage_rays::predicate::{self, HitPoint};
use umbrage_rays::{
    Hit, LightMask, LightSource, Lit, LitBits, Patches, Ray, Receivers, Scanner, SeenPixels, Shot, SimdLevel, TileOrder,
};
use umbrage_scene::Frame;

use crate::shade::lanes::LANES;

/// The points of an image that differ on the smooth surface, and the lights that reach them.
#[derive(Debug)]
pub(super) struct SmoothTerminator {
    scanner: Scanner,
    /// The smooth position for each of the image's slots; NaN for a point that stays in its triangle.
    positions: Vec<Vec3>,
    bits: LitBits,
}

impl SmoothTerminator {
    pub(super) fn with_level(level: SimdLevel) -> Self {
        Self { scanner: Scanner::with_level(level), positions: Vec::new(), bits: LitBits::default() }
    }

    /// Bytes held.
    pub(super) fn bytes(&self) -> usize {
        self.scanner.bytes() + self.positions.capacity() * size_of::<Vec3>()
    }

    /// Tests lights again for the points of an image that differ on the smooth surface.
    pub(super) fn shadow(
        &mut self,
        patches: Option<&Patches>,
        (frame, shot): (&Frame, &Shot<'_>),
        seen: &SeenPixels,
        lights: &[LightSource],
        masks: &mut [LightMask],
    ) {
        let Self { scanner, positions, bits } = self;
        if lights.is_empty() {
            return;
        }
        let position = |slot: usize| {
            let triangle = seen.triangle[slot];
            if triangle == SeenPixels::NONE || !is_bent(frame, triangle) {
                return None;
            }
            let (x, y) = seen.order().column_and_row(slot);
            let ray = shot.ray(x, y);
            let barycentric = predicate::barycentric_of(&ray, frame.triangles().corners(triangle))?;
            smooth_position(frame, &ray, triangle, barycentric)
        };
        let slots = (0..seen.order().slots()).into_par_iter().with_min_len(TileOrder::TILE_PIXELS);
        slots.map(|slot| position(slot).unwrap_or(Vec3::NAN)).collect_into_vec(positions);

        let receivers = Receivers::Pixels { positions, own: &seen.triangle };
        let (opacity, sides) = (shot.shadow_opacity, shot.sides);
        let question = Lit { opacity, sides, ..Lit::new(shot.triangles, receivers) };
        scanner.lit_with(patches, &question, lights, bits);
        for (light, mask) in masks.iter_mut().enumerate() {
            let blocks = mask.blocks_mut().par_iter_mut().zip(positions.par_chunks(LANES));
            blocks.enumerate().with_min_len(TileOrder::TILE_PIXELS / LANES).each(|(block, (lit, positions))| {
                for (lane, _) in positions.iter().enumerate().filter(|(_, position)| !position.is_nan()) {
                    let is_lit = bits.is_lit(light, block * LANES + lane);
                    *lit = *lit & !(1 << lane) | u16::from(is_lit) << lane;
                }
            });
        }
    }
}

/// Whether the smooth surface of a triangle isn't flat.
fn is_bent(frame: &Frame, triangle: u32) -> bool {
    let [a, b, c] = frame.mesh.triangles[triangle as usize].map(|vertex| frame.normals.get(vertex as usize));
    a != b || a != c
}

/// The point of the smooth surface for a hit, for rays that come one at a time.
pub(super) fn smooth_point(frame: &Frame, ray: &Ray, hit: &Hit) -> Option<HitPoint> {
    let positions = &[smooth_position(frame, ray, hit.triangle, hit.barycentric)?];
    let (point, _) = Receivers::Points { positions, own: &[hit.triangle] }.point(frame.triangles(), 0)?;
    Some(point)
}

/// The position on the smooth surface for a hit: an interpolation of the nearest points in the planes through the triangle's
/// corners, at right angles to the vertices' normals. `None` where it isn't outside of the triangle, as seen from the ray's
/// origin: where the surface is flat or bends towards the ray.
fn smooth_position(frame: &Frame, ray: &Ray, triangle: u32, barycentric: [f32; 2]) -> Option<Vec3> {
    /// The least shift, in relation to the triangle's size: smaller ones may be errors of normals and points.
    const LEAST: f64 = 1e-5;
    if !is_bent(frame, triangle) {
        return None;
    }
    let vertices = frame.mesh.triangles[triangle as usize];
    let corners @ [a, b, c] = vertices.map(|vertex| frame.positions[vertex as usize].as_dvec3());
    let normals = vertices.map(|vertex| frame.normals[vertex as usize].as_dvec3());
    let [second, third] = barycentric.map(f64::from);
    let weights = [1.0 - second - third, second, third];
    let between = |of: [DVec3; 3]| of[0] * weights[0] + of[1] * weights[1] + of[2] * weights[2];
    let (position, smooth, geometric) = (between(corners), between(normals), (b - a).cross(c - a));
    // As in shading: smooth normals define the front, even in files whose winding disagrees with them.
    let shows_front = (geometric.dot(ray.direction) <= 0.0) == (geometric.dot(smooth) >= 0.0);
    let normals = if shows_front { normals } else { normals.map(|normal| -normal) };
    let lifted = [0, 1, 2].map(|corner| normals[corner] * (corners[corner] - position).dot(normals[corner]).max(0.0));
    let lift = between(lifted);
    let size_squared = (b - a).length_squared().max((c - a).length_squared());
    (lift.length_squared() > LEAST * LEAST * size_squared).then(|| (position + lift).as_vec3())
}
