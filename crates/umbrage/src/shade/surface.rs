use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, mask32x16};
use umbrage_rays::{Projection, View};
use umbrage_scene::Frame;

use super::Reflectance;
use super::hits::{BlockHits, corner_vectors};
use super::lanes::{Vectors, Wide};
use super::layer_paint::LayerPaint;
use super::layers::Layers;
use super::paint::{Bumps, Paint};
use super::rays::BlockRays;
use super::texels::Texels;

/// The width of a camera ray's pixel cone.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Footprint {
    /// Width at depth 0, in world units.
    pub(crate) width: f32,
    /// Growth of the width for each unit of depth.
    pub(crate) width_per_depth: f32,
}

impl Footprint {
    /// The cone of one of `samples` rays through a pixel of `view`.
    pub(crate) fn new(view: &View, samples: u32) -> Self {
        let pixel = 2.0 / (view.height as f32 * (samples as f32).sqrt());
        match view.camera.projection {
            Projection::Perspective { tan_half_height } => {
                Self { width: 0.0, width_per_depth: pixel * tan_half_height }
            }
            Projection::Orthographic { half_height } => Self { width: pixel * half_height, width_per_depth: 0.0 },
        }
    }

    #[inline(always)]
    fn width_at<S: Simd>(&self, depth: f32x16<S>) -> f32x16<S> {
        depth * self.width_per_depth + self.width
    }
}

/// Sixteen points of surfaces with all inputs of shading.
#[derive(Clone, Copy)]
pub(crate) struct Surface<S: Simd> {
    /// World positions.
    pub(crate) position: [Wide<S>; 2],
    /// Unit direction towards the ray's origin.
    pub(crate) view: Vectors<S>,
    /// Unit normal of the triangle, on the side of `view`.
    pub(crate) geometric_normal: Vectors<S>,
    /// The normal of the side that a light must be on to reach the surface.
    pub(crate) lit_side: Vectors<S>,
    /// Unit normal with the vertices' and the texture's bumps.
    pub(crate) normal: Vectors<S>,
    pub(crate) reflectance: Reflectance<S>,
    pub(crate) base_color: Vectors<S>,
    /// Opacity of the surface, 0 to 1; 1 except for blended materials.
    pub(crate) opacity: f32x16<S>,
    /// Transmittance for light from behind, apart from reflection, where the surface is opaque otherwise.
    pub(crate) transmitted: Vectors<S>,
    pub(crate) emitted: Vectors<S>,
    /// The part of the light from all around that arrives, 0 … 1.
    pub(crate) ambient_occlusion: f32x16<S>,
    /// The lanes in which a volume of glass begins or ends, the first in the lowest bit.
    pub(crate) volume: u16,
    /// The lanes that show the front of their triangle.
    pub(crate) front: u16,
    /// The lanes shown in their base colour in any light, the first in the lowest bit.
    pub(crate) unlit: u16,
    /// The lanes that show only the shadows on them.
    pub(crate) catches: u16,
    /// `None` where no lane has any.
    pub(crate) layers: Option<Layers<S>>,
}

impl<S: Simd> Surface<S> {
    /// The surfaces of hits, with `PLAIN` of plain materials alone ([`Plan::ends_at`](crate::plan::Plan::ends_at)).
    #[inline(always)]
    pub(crate) fn new<const PLAIN: bool>(
        simd: S,
        frame: &Frame,
        rays: &BlockRays<S>,
        hits: &BlockHits<'_, S>,
        footprint: &Footprint,
        smooth_terminator: bool,
    ) -> Self {
        let facet = Facet::new(rays, hits, footprint);
        let texels = Texels::new(simd, frame, hits, facet.covered_triangles);
        let paint = Paint::new(frame, hits, &texels);
        let one = f32x16::splat(simd, 1.0);
        let (mut base_color, mut opacity) =
            (Vectors::load(simd, &paint.base_color), f32x16::from_slice(simd, &paint.opacity));
        if !frame.mesh.colors.is_empty() {
            let (color, alpha) = vertex_colors(simd, frame, hits);
            (base_color, opacity) = (base_color * color, opacity * alpha);
        }
        let metallic = f32x16::from_slice(simd, &paint.metallic);
        let mut transmission = f32x16::from_slice(simd, &paint.transmission) * (1.0 - metallic);
        if PLAIN {
            transmission = f32x16::splat(simd, 0.0);
        }
        let roughness = f32x16::from_slice(simd, &paint.roughness);
        let dielectric = f32x16::from_slice(simd, &paint.dielectric);
        let mut reflectance = Reflectance::new(simd, base_color, metallic, roughness, dielectric);
        let smooth = facet.smooth_normal(simd, frame, hits);
        let normal = facet.on_the_side_of_the_ray(smooth, bend(simd, smooth, &paint.bumps));
        let mut layers = None;
        if !PLAIN && paint.layered != 0 {
            let paint = LayerPaint::new(frame, hits, &texels);
            reflectance = reflectance.with_specular(simd, &paint, (base_color, metallic, dielectric));
            let coat_normal = facet.on_the_side_of_the_ray(smooth, bend(simd, smooth, &paint.coat_bumps));
            let normals = [normal, coat_normal, bend(simd, smooth, &paint.grooves)];
            layers = Some(Layers::new(simd, &paint, &mut reflectance, normals, rays.towards_origin));
        }
        let blended = mask32x16::from_bitmask(simd, paint.blended.into());
        Self {
            position: hits.position,
            view: rays.towards_origin,
            geometric_normal: facet.geometric_normal,
            lit_side: if smooth_terminator {
                facet.on_the_side_of_the_ray(smooth, smooth)
            } else {
                facet.geometric_normal
            },
            normal,
            reflectance: reflectance.with_transmission(transmission),
            base_color,
            opacity: if PLAIN { one } else { blended.select(opacity.max(0.0).min(1.0), one) },
            transmitted: base_color.scaled(transmission),
            emitted: Vectors::load(simd, &paint.emitted),
            ambient_occlusion: f32x16::from_slice(simd, &paint.ambient_occlusion),
            volume: if PLAIN { 0 } else { paint.volume },
            front: facet.shows_front.to_bitmask() as u16,
            unlit: paint.unlit & !paint.catches,
            catches: if PLAIN { 0 } else { paint.catches },
            layers,
        }
    }
}

/// Triangles from the rays' side.
struct Facet<S: Simd> {
    /// On the side from which the corners are seen counterclockwise.
    front: Vectors<S>,
    /// On the side of the ray's origin.
    geometric_normal: Vectors<S>,
    shows_front: mask32x16<S>,
    /// Area of the ray's cone on the surface, in triangle areas.
    covered_triangles: f32x16<S>,
}

impl<S: Simd> Facet<S> {
    #[inline(always)]
    fn new(rays: &BlockRays<S>, hits: &BlockHits<'_, S>, footprint: &Footprint) -> Self {
        let [a, b, c] = hits.corners;
        let view = rays.towards_origin;
        let doubled_area = (b - a).cross(c - a);
        // A sliver whose area vanishes in f32 is seen as if from the front.
        let front = doubled_area.normalized_or(view);
        let is_behind = front.dot(view).simd_lt(0.0);
        let geometric_normal = Vectors::select(is_behind, -front, front);
        let width = footprint.width_at(hits.depth + rays.travelled);
        let cosine = geometric_normal.dot(view).max(0.01);
        let covered_triangles = 2.0 * width * width / (cosine * doubled_area.length());
        Self { front, geometric_normal, shows_front: !is_behind, covered_triangles }
    }

    /// The normal that is interpolated between the vertices, on the front of the surface.
    #[inline(always)]
    fn smooth_normal(&self, simd: S, frame: &Frame, hits: &BlockHits<'_, S>) -> Vectors<S> {
        if frame.normals.is_empty() {
            return self.front;
        }
        // Zero where the surface is flat.
        vertex_normals(simd, frame, hits).normalized_or(self.front)
    }

    /// A normal on the front of the surface, turned to the side of the ray's origin.
    #[inline(always)]
    fn on_the_side_of_the_ray(&self, smooth: Vectors<S>, bent: Vectors<S>) -> Vectors<S> {
        // Smooth normals define the front, even in files whose winding disagrees with them.
        Vectors::select(smooth.dot(self.geometric_normal).simd_lt(0.0), -bent, bent)
    }
}

/// The vertices' own colours and opacities, interpolated.
#[inline(always)]
fn vertex_colors<S: Simd>(simd: S, frame: &Frame, hits: &BlockHits<'_, S>) -> (Vectors<S>, f32x16<S>) {
    let [[ra, ga, ba, alpha_a], [rb, gb, bb, alpha_b], [rc, gc, bc, alpha_c]] = hits.triangles.corners(
        simd,
        #[inline(always)]
        |vertex| frame.mesh.colors[vertex as usize].to_array(),
    );
    let color = hits.interpolated([
        Vectors::of_axes([ra, ga, ba]),
        Vectors::of_axes([rb, gb, bb]),
        Vectors::of_axes([rc, gc, bc]),
    ]);
    let [second, third] = hits.barycentric;
    (color, alpha_a * (1.0 - second - third) + alpha_b * second + alpha_c * third)
}

/// The vertices' normals, interpolated; of any length.
#[inline(always)]
fn vertex_normals<S: Simd>(simd: S, frame: &Frame, hits: &BlockHits<'_, S>) -> Vectors<S> {
    hits.interpolated(corner_vectors(simd, &frame.normals, hits.triangles))
}

/// Normals bent by the normal texture in the lanes that have one.
#[inline(always)]
fn bend<S: Simd>(simd: S, normal: Vectors<S>, bumps: &Bumps) -> Vectors<S> {
    if bumps.lanes == 0 {
        return normal;
    }
    let tangent = Vectors::load(simd, &bumps.tangent);
    let (tangent, has_tangent) = (tangent - normal.scaled(tangent.dot(normal))).try_normalized();
    let bitangent = normal.cross(tangent).scaled(f32x16::from_slice(simd, &bumps.bitangent_sign));
    let bump = Vectors::load(simd, &bumps.bump);
    let bent = tangent.scaled(bump.x) + bitangent.scaled(bump.y) + normal.scaled(bump.z);
    let is_bent = has_tangent & mask32x16::from_bitmask(simd, bumps.lanes.into());
    Vectors::select(is_bent, bent.normalized_or(normal), normal)
}
