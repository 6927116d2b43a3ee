use glam::{DVec3, Vec2, Vec3, Vec4};
use umbrage_rays::predicate::HitPoint;
use umbrage_rays::{Hit, Projection, Ray, View};
use umbrage_scene::{Alpha, Frame, Material, TextureUse};

use super::Reflectance;

/// How wide the cone of a camera ray's pixel is.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Footprint {
    /// At depth 0, in world units.
    pub(crate) width: f32,
    /// How much wider it becomes for each unit of depth.
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

    fn width_at(&self, depth: f32) -> f32 {
        self.width + self.width_per_depth * depth
    }
}

/// A point of a surface with everything that shading needs.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Surface {
    /// Where it is.
    pub(crate) position: DVec3,
    /// Unit direction towards the ray's origin.
    pub(crate) view: Vec3,
    /// Unit normal of the triangle, on the side of `view`.
    pub(crate) geometric_normal: Vec3,
    /// Unit normal with the vertices' and the texture's bumps.
    pub(crate) normal: Vec3,
    pub(crate) reflectance: Reflectance,
    pub(crate) base_color: Vec3,
    /// How much of what is behind the surface hides; 1 but for blended materials.
    pub(crate) opacity: f32,
    /// What passes through of the light from behind, as through a thin pane, where the surface is opaque otherwise.
    pub(crate) transmitted: Vec3,
    pub(crate) emitted: Vec3,
    /// How much of the light from all around arrives, 0 … 1.
    pub(crate) ambient_occlusion: f32,
    pub(crate) unlit: bool,
}

impl Surface {
    pub(crate) fn new(frame: &Frame, ray: &Ray, hit: &Hit, footprint: &Footprint) -> Self {
        let material = frame.material(hit.triangle);
        let texels = Texels::new(frame, ray, hit, footprint);
        let base_color = material.base_color
            * frame.vertex_color(hit.triangle, hit.barycentric)
            * texels.read_or_one(material.base_color_texture);
        let metallic_roughness = texels.read_or_one(material.metallic_roughness_texture);
        let occlusion = texels.read_or_one(material.occlusion_texture).x;
        let normal = bent_normal(frame, hit, &texels, material);
        let metallic = material.metallic * metallic_roughness.z;
        let transmission =
            material.transmission * texels.read_or_one(material.transmission_texture).x * (1.0 - metallic);
        Self {
            position: HitPoint::new(ray, hit.t).position,
            view: texels.view,
            geometric_normal: texels.geometric_normal,
            normal,
            reflectance: Reflectance::new(
                base_color.truncate(),
                metallic,
                material.roughness * metallic_roughness.y,
                material.ior,
            )
            .with_transmission(transmission),
            base_color: base_color.truncate(),
            opacity: if material.alpha == Alpha::Blend { base_color.w.clamp(0.0, 1.0) } else { 1.0 },
            transmitted: base_color.truncate() * transmission,
            emitted: material.emissive * texels.read_or_one(material.emissive_texture).truncate(),
            ambient_occlusion: 1.0 + material.occlusion_strength * (occlusion - 1.0),
            unlit: material.unlit,
        }
    }
}

/// What is needed to read textures at a hit.
struct Texels<'a> {
    frame: &'a Frame,
    corners: [Vec3; 3],
    corner_coords: [[Vec2; 3]; 2],
    coords: [Vec2; 2],
    /// Towards the ray's origin.
    view: Vec3,
    /// Of the triangle, on the side of `view`.
    geometric_normal: Vec3,
    /// 1 where the ray comes from the front of the triangle, −1 from its back.
    facing: f32,
    /// Area of the ray's cone on the surface, in triangle areas.
    covered_triangles: f32,
}

impl<'a> Texels<'a> {
    fn new(frame: &'a Frame, ray: &Ray, hit: &Hit, footprint: &Footprint) -> Self {
        let corners = frame.triangles().corners(hit.triangle);
        let [a, b, c] = corners;
        let doubled_area = (b - a).cross(c - a);
        let view = -ray.direction.normalize().as_vec3();
        // A sliver whose area vanishes in f32 is seen as if from the front.
        let front = doubled_area.try_normalize().unwrap_or(view);
        let facing = if front.dot(view) < 0.0 { -1.0 } else { 1.0 };
        let geometric_normal = front * facing;
        let width = footprint.width_at(hit.t as f32);
        let cosine = geometric_normal.dot(view).max(0.01);
        let corner_vertices = frame.mesh.triangles[hit.triangle as usize];
        let corner_coords = frame
            .mesh
            .tex_coords
            .each_ref()
            .map(|coords| corner_vertices.map(|vertex| coords.get(vertex as usize).copied().unwrap_or_default()));
        Self {
            frame,
            corners,
            corner_coords,
            coords: frame.tex_coords(hit.triangle, hit.barycentric),
            view,
            geometric_normal,
            facing,
            covered_triangles: 2.0 * width * width / (cosine * doubled_area.length()),
        }
    }

    fn read_or_one(&self, texture: Option<TextureUse>) -> Vec4 {
        texture.map_or(Vec4::ONE, |texture| self.read(texture))
    }

    /// Ray cones (Akenine-Möller et al., *Texture Level of Detail Strategies for Real-Time Ray Tracing*, 2019): as many
    /// texels are averaged as the pixel's cone covers on the surface.
    fn read(&self, texture: TextureUse) -> Vec4 {
        let image = &self.frame.materials.textures[texture.texture as usize];
        let [width, height] = image.size();
        let corners = self.corner_coords[usize::from(texture.tex_coord_set.min(1))];
        let [a, b, c] = corners.map(|coords| texture.image_from_mesh.transform_point2(coords));
        let triangle_texels = 0.5 * (b - a).perp_dot(c - a).abs() * width as f32 * height as f32;
        image.sample(texture.image_coords(self.coords), (triangle_texels * self.covered_triangles).sqrt())
    }
}

/// The shading normal: interpolated between the vertices, bent by the normal texture, and on the side of the ray.
fn bent_normal(frame: &Frame, hit: &Hit, texels: &Texels<'_>, material: &Material) -> Vec3 {
    let Some(smooth) = smooth_normal(frame, hit) else {
        return material.normal_texture.map_or(texels.geometric_normal, |texture| {
            let normal = texels.geometric_normal * texels.facing;
            bend(frame, hit, texels, material, texture, normal) * texels.facing
        });
    };
    let bent = material.normal_texture.map_or(smooth, |texture| bend(frame, hit, texels, material, texture, smooth));
    // Normals say which side is the front, also in files whose winding disagrees with them.
    if smooth.dot(texels.geometric_normal) < 0.0 { -bent } else { bent }
}

/// `None` where the surface is flat.
fn smooth_normal(frame: &Frame, hit: &Hit) -> Option<Vec3> {
    if frame.normals.is_empty() {
        return None;
    }
    let normals = frame.mesh.triangles[hit.triangle as usize].map(|vertex| frame.normals[vertex as usize]);
    interpolate(normals, hit.barycentric).try_normalize()
}

fn interpolate([a, b, c]: [Vec3; 3], [v, w]: [f32; 2]) -> Vec3 {
    a * (1.0 - v - w) + b * v + c * w
}

/// `normal` bent by the normal texture in the tangent frame of the file, or else of the texture coordinates.
fn bend(frame: &Frame, hit: &Hit, texels: &Texels<'_>, material: &Material, texture: TextureUse, normal: Vec3) -> Vec3 {
    let tangents = vertex_tangent(frame, hit).or_else(|| gradient_tangent(texels, texture));
    let Some((tangent, sign)) = tangents else { return normal };
    let Some(tangent) = tangent.reject_from_normalized(normal).try_normalize() else { return normal };
    let bitangent = normal.cross(tangent) * sign;
    let texel = texels.read(texture).truncate() * 2.0 - 1.0;
    let bump = texel * Vec3::new(material.normal_scale, material.normal_scale, 1.0);
    (tangent * bump.x + bitangent * bump.y + normal * bump.z).try_normalize().unwrap_or(normal)
}

fn vertex_tangent(frame: &Frame, hit: &Hit) -> Option<(Vec3, f32)> {
    if frame.tangents.is_empty() {
        return None;
    }
    let tangents = frame.mesh.triangles[hit.triangle as usize].map(|vertex| frame.tangents[vertex as usize]);
    let tangent = interpolate(tangents.map(Vec4::truncate), hit.barycentric).try_normalize()?;
    Some((tangent, if tangents[0].w < 0.0 { -1.0 } else { 1.0 }))
}

/// The direction in which the texture's u grows across the triangle, and the sign of the bitangent.
fn gradient_tangent(texels: &Texels<'_>, texture: TextureUse) -> Option<(Vec3, f32)> {
    let [a, b, c] = texels.corner_coords[usize::from(texture.tex_coord_set.min(1))];
    let (coords_ab, coords_ac) = (b - a, c - a);
    let [a, b, c] = texels.corners;
    let (ab, ac) = (b - a, c - a);
    let area = coords_ab.perp_dot(coords_ac);
    let tangent = (ab * coords_ac.y - ac * coords_ab.y) * area.signum();
    // v grows downwards in the image and the bitangent points up: an image that isn't mirrored has a negative area.
    (area != 0.0).then_some((tangent, if area < 0.0 { 1.0 } else { -1.0 }))
}
