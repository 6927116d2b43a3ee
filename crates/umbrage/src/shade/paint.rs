use glam::{Vec2, Vec3, Vec4};
use umbrage_scene::{Alpha, Frame, Material, TextureUse};

use super::hits::LaneHits;
use super::lanes::{Each, LANES, each, put};

/// What the materials and textures of a block's lanes say, read lane by lane; without the vertices' colours.
pub(super) struct Paint {
    pub(super) base_color: [Each<f32>; 3],
    /// For blended materials.
    pub(super) opacity: Each<f32>,
    pub(super) metallic: Each<f32>,
    pub(super) roughness: Each<f32>,
    pub(super) ior: Each<f32>,
    /// Of what isn't metal.
    pub(super) transmission: Each<f32>,
    pub(super) ambient_occlusion: Each<f32>,
    pub(super) emitted: [Each<f32>; 3],
    pub(super) bumps: Bumps,
    /// The lanes of blended materials, the first in the lowest bit.
    pub(super) blended: u16,
    /// The lanes whose surface bounds a volume.
    pub(super) volume: u16,
    pub(super) unlit: u16,
    /// The lanes that show nothing but shadows.
    pub(super) catches: u16,
    /// The lanes whose material has layers.
    pub(super) layered: u16,
}

/// What normal textures say.
pub(super) struct Bumps {
    /// The lanes that have one, the first in the lowest bit.
    pub(super) lanes: u16,
    /// Along the tangent, the bitangent and the normal.
    pub(super) bump: [Each<f32>; 3],
    /// Of any length, not yet at right angles to the normal.
    pub(super) tangent: [Each<f32>; 3],
    pub(super) bitangent_sign: Each<f32>,
}

impl Paint {
    /// `covered_triangles` is the area of each ray's cone on the surface, in triangle areas.
    pub(super) fn new(frame: &Frame, hits: &LaneHits, covered_triangles: &Each<f32>) -> Self {
        let material_of = |lane: usize| frame.mesh.material_of_triangle[hits.triangle[lane] as usize];
        let material = &frame.materials.materials[material_of(0) as usize];
        let mut paint = Self::plain(material);
        let mut is_textured = has_textures(material);
        if (1..LANES).any(|lane| material_of(lane) != material_of(0)) {
            for lane in 1..LANES {
                let material = &frame.materials.materials[material_of(lane) as usize];
                paint.put(lane, material);
                is_textured |= has_textures(material);
            }
        }
        if !is_textured {
            return paint;
        }
        for lane in 0..LANES {
            if hits.shown >> lane & 1 == 0 {
                continue;
            }
            let texels = Texels::of_lane(frame, hits, covered_triangles, lane);
            paint.read_textures(lane, &frame.materials.materials[material_of(lane) as usize], &texels);
        }
        paint
    }

    /// A material without textures, in all lanes.
    fn plain(material: &Material) -> Self {
        Self {
            base_color: material.base_color.truncate().to_array().map(each),
            opacity: each(material.base_color.w),
            metallic: each(material.metallic),
            roughness: each(material.roughness),
            ior: each(material.ior),
            transmission: each(material.transmission),
            ambient_occlusion: each(1.0),
            emitted: material.emissive.to_array().map(each),
            bumps: Bumps::none(),
            blended: if material.alpha == Alpha::Blend { u16::MAX } else { 0 },
            volume: if material.bounds_volume() { u16::MAX } else { 0 },
            unlit: if material.unlit { u16::MAX } else { 0 },
            catches: if material.catches_shadows { u16::MAX } else { 0 },
            layered: if material.layers.is_some() { u16::MAX } else { 0 },
        }
    }

    /// A material without textures, in one lane.
    fn put(&mut self, lane: usize, material: &Material) {
        put(lane, material.base_color.truncate(), &mut self.base_color);
        self.opacity[lane] = material.base_color.w;
        self.metallic[lane] = material.metallic;
        self.roughness[lane] = material.roughness;
        self.ior[lane] = material.ior;
        self.transmission[lane] = material.transmission;
        put(lane, material.emissive, &mut self.emitted);
        let bit = 1 << lane;
        self.blended = self.blended & !bit | if material.alpha == Alpha::Blend { bit } else { 0 };
        self.volume = self.volume & !bit | if material.bounds_volume() { bit } else { 0 };
        self.unlit = self.unlit & !bit | if material.unlit { bit } else { 0 };
        self.catches = self.catches & !bit | if material.catches_shadows { bit } else { 0 };
        self.layered = self.layered & !bit | if material.layers.is_some() { bit } else { 0 };
    }

    /// Multiplies a lane's material by its textures.
    fn read_textures(&mut self, lane: usize, material: &Material, texels: &Texels<'_>) {
        if let Some(texture) = material.base_color_texture {
            let [red, green, blue, opacity] = texels.read(texture).to_array();
            for (channel, texel) in self.base_color.iter_mut().zip([red, green, blue]) {
                channel[lane] *= texel;
            }
            self.opacity[lane] *= opacity;
        }
        if let Some(texture) = material.metallic_roughness_texture {
            let texel = texels.read(texture);
            self.metallic[lane] *= texel.z;
            self.roughness[lane] *= texel.y;
        }
        if let Some(texture) = material.transmission_texture {
            self.transmission[lane] *= texels.read(texture).x;
        }
        if let Some(texture) = material.occlusion_texture {
            self.ambient_occlusion[lane] = 1.0 + material.occlusion_strength * (texels.read(texture).x - 1.0);
        }
        if let Some(texture) = material.emissive_texture {
            for (channel, texel) in self.emitted.iter_mut().zip(texels.read(texture).truncate().to_array()) {
                channel[lane] *= texel;
            }
        }
        if let Some(texture) = material.normal_texture {
            self.bumps.read(lane, texels, texture, material.normal_scale);
        }
    }
}

fn has_textures(material: &Material) -> bool {
    material.textures().iter().any(Option::is_some)
}

impl Bumps {
    pub(super) fn none() -> Self {
        Self { lanes: 0, bump: [[0.0; LANES]; 3], tangent: [[0.0; LANES]; 3], bitangent_sign: [0.0; LANES] }
    }

    /// Reads a normal texture.
    pub(super) fn read(&mut self, lane: usize, texels: &Texels<'_>, texture: TextureUse, scale: f32) {
        let texel = texels.read(texture).truncate() * 2.0 - 1.0;
        self.set(lane, texels, texture.tex_coord_set, texel * Vec3::new(scale, scale, 1.0));
    }

    /// Takes a bump in the tangent frame of the file, or else of a set of texture coordinates; none where there is neither.
    pub(super) fn set(&mut self, lane: usize, texels: &Texels<'_>, tex_coord_set: u8, bump: Vec3) {
        let Some((tangent, sign)) = texels.vertex_tangent().or_else(|| texels.gradient_tangent(tex_coord_set)) else {
            return;
        };
        self.lanes |= 1 << lane;
        put(lane, bump, &mut self.bump);
        put(lane, tangent, &mut self.tangent);
        self.bitangent_sign[lane] = sign;
    }
}

/// What is needed to read textures at a hit.
pub(super) struct Texels<'a> {
    frame: &'a Frame,
    vertices: [u32; 3],
    /// Weights of the second and the third vertex.
    barycentric: [f32; 2],
    /// Area of the ray's cone on the surface, in triangle areas.
    covered_triangles: f32,
}

impl<'a> Texels<'a> {
    pub(super) fn of_lane(frame: &'a Frame, hits: &LaneHits, covered_triangles: &Each<f32>, lane: usize) -> Self {
        let [second, third] = &hits.barycentric;
        Self {
            frame,
            vertices: hits.vertices[lane],
            barycentric: [second[lane], third[lane]],
            covered_triangles: covered_triangles[lane],
        }
    }

    /// Ray cones (Akenine-Möller et al., *Texture Level of Detail Strategies for Real-Time Ray Tracing*, 2019): as many
    /// texels are averaged as the pixel's cone covers on the surface.
    pub(super) fn read(&self, texture: TextureUse) -> Vec4 {
        let image = &self.frame.materials.textures[texture.texture as usize];
        let [width, height] = image.size();
        let [a, b, c] = self.corner_coords(texture.tex_coord_set);
        let matrix = texture.image_from_mesh.matrix2;
        let doubled_area = (matrix * (b - a)).perp_dot(matrix * (c - a)).abs();
        let triangle_texels = 0.5 * doubled_area * width as f32 * height as f32;
        let [second, third] = self.barycentric;
        let coords = a * (1.0 - second - third) + b * second + c * third;
        let footprint = (triangle_texels * self.covered_triangles).sqrt();
        image.sample(texture.image_from_mesh.transform_point2(coords), footprint)
    }

    fn corner_coords(&self, tex_coord_set: u8) -> [Vec2; 3] {
        let coords = &self.frame.mesh.tex_coords[usize::from(tex_coord_set.min(1))];
        self.vertices.map(|vertex| coords.get(vertex as usize).copied().unwrap_or_default())
    }

    /// The file's tangent, of any length, and the sign of the bitangent.
    fn vertex_tangent(&self) -> Option<(Vec3, f32)> {
        if self.frame.tangents.is_empty() {
            return None;
        }
        let [a, b, c] = self.vertices.map(|vertex| self.frame.tangents[vertex as usize]);
        let [second, third] = self.barycentric;
        let mean = a * (1.0 - second - third) + b * second + c * third;
        let tangent = mean.truncate().try_normalize()?;
        Some((tangent, if a.w < 0.0 { -1.0 } else { 1.0 }))
    }

    /// The direction in which the texture's u grows across the triangle, and the sign of the bitangent.
    fn gradient_tangent(&self, tex_coord_set: u8) -> Option<(Vec3, f32)> {
        let [a, b, c] = self.corner_coords(tex_coord_set);
        let (coords_ab, coords_ac) = (b - a, c - a);
        let [a, b, c] = self.vertices.map(|vertex| self.frame.positions[vertex as usize]);
        let (ab, ac) = (b - a, c - a);
        let area = coords_ab.perp_dot(coords_ac);
        let tangent = (ab * coords_ac.y - ac * coords_ab.y) * area.signum();
        // v grows downwards in the image and the bitangent points up: an image that isn't mirrored has a negative area.
        (area != 0.0).then_some((tangent, if area < 0.0 { 1.0 } else { -1.0 }))
    }
}
