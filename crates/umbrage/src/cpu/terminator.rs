//! Shadows of the smooth surfaces that triangles stand for: their points, moved there, are what lights are asked about
//! (Hanika, *Hacking the Shadow Terminator*, Ray Tracing Gems II, 2021).

use glam::{DVec3, Vec3};
use rayon::prelude::*;
use umbrage_rays::parallel::Parallel;
use umbrage_rays::predicate::{self, HitPoint};
use umbrage_rays::{
    Hit, LightMask, LightSource, Lit, LitBits, Patches, Ray, Receivers, Scanner, SeenPixels, Shot, SimdLevel, TileOrder,
};
use umbrage_scene::Frame;

use crate::shade::lanes::LANES;

/// The points of an image that are elsewhere on the smooth surface, and which lights reach them.
#[derive(Debug)]
pub(super) struct SmoothTerminator {
    scanner: Scanner,
    /// Where the point of each of the image's slots is; NaN where that is in its triangle.
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

    /// Asks again about the points of an image that are elsewhere on the smooth surface.
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

/// Whether the smooth surface that a triangle stands for isn't flat.
fn is_bent(frame: &Frame, triangle: u32) -> bool {
    let [a, b, c] = frame.mesh.triangles[triangle as usize].map(|vertex| frame.normals.get(vertex as usize));
    a != b || a != c
}

/// Where the smooth surface is that the triangle of a hit stands for, for rays that come one at a time.
pub(super) fn smooth_point(frame: &Frame, ray: &Ray, hit: &Hit) -> Option<HitPoint> {
    let positions = &[smooth_position(frame, ray, hit.triangle, hit.barycentric)?];
    let (point, _) = Receivers::Points { positions, own: &[hit.triangle] }.point(frame.triangles(), 0)?;
    Some(point)
}

/// Where the smooth surface is that the triangle of a hit stands for: between the points where the planes through its corners
/// are nearest, which are at right angles to the vertices' normals. `None` where that is not outside of the triangle, as seen
/// from where the ray comes: where the surface is flat or bends towards the ray.
fn smooth_position(frame: &Frame, ray: &Ray, triangle: u32, barycentric: [f32; 2]) -> Option<Vec3> {
    /// What moves a point less, in relation to the triangle's size, may be what normals and points are wrong by.
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
    // As in shading: smooth normals say which side is the front, also in files whose winding disagrees with them.
    let shows_front = (geometric.dot(ray.direction) <= 0.0) == (geometric.dot(smooth) >= 0.0);
    let normals = if shows_front { normals } else { normals.map(|normal| -normal) };
    let lifted = [0, 1, 2].map(|corner| normals[corner] * (corners[corner] - position).dot(normals[corner]).max(0.0));
    let lift = between(lifted);
    let size_squared = (b - a).length_squared().max((c - a).length_squared());
    (lift.length_squared() > LEAST * LEAST * size_squared).then(|| (position + lift).as_vec3())
}
