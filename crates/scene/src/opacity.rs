use glam::{Vec2, Vec4};

use crate::{Alpha, Frame, Material};

impl Frame {
    /// The material of a triangle.
    ///
    /// # Panics
    /// If `triangle` is out of range.
    #[must_use]
    pub fn material(&self, triangle: u32) -> &Material {
        &self.materials.materials[self.mesh.material_of_triangle[triangle as usize] as usize]
    }

    /// Both sets of texture coordinates at a point of a triangle, given the weights of its second and third vertex;
    /// zero for a set that the scene doesn't have.
    #[must_use]
    pub fn tex_coords(&self, triangle: u32, barycentric: [f32; 2]) -> [Vec2; 2] {
        let [a, b, c] = self.mesh.triangles[triangle as usize].map(|vertex| vertex as usize);
        let [v, w] = barycentric;
        self.mesh.tex_coords.each_ref().map(|coords| {
            if coords.is_empty() { Vec2::ZERO } else { coords[a] * (1.0 - v - w) + coords[b] * v + coords[c] * w }
        })
    }

    /// The vertices' own colour and opacity at a point of a triangle; white where there is none.
    #[must_use]
    pub fn vertex_color(&self, triangle: u32, barycentric: [f32; 2]) -> Vec4 {
        let colors = &self.mesh.colors;
        if colors.is_empty() {
            return Vec4::ONE;
        }
        let [a, b, c] = self.mesh.triangles[triangle as usize].map(|vertex| colors[vertex as usize]);
        let [v, w] = barycentric;
        a * (1.0 - v - w) + b * v + c * w
    }

    /// Whether a triangle has an alpha mask, so that [`Frame::is_solid`] may say no.
    #[must_use]
    pub fn is_masked(&self, triangle: u32) -> bool {
        matches!(self.material(triangle).alpha, Alpha::Mask { .. })
    }

    /// Whether every point of a triangle casts a shadow, so that [`Frame::casts_shadow`] needn't be asked.
    #[must_use]
    pub fn is_opaque(&self, triangle: u32) -> bool {
        let material = self.material(triangle);
        material.alpha == Alpha::Opaque && material.transmission < 0.5
    }

    /// Whether some material lets one look through it at what is behind.
    #[must_use]
    pub fn is_see_through(&self) -> bool {
        let through = |material: &Material| material.alpha == Alpha::Blend || material.transmission > 0.0;
        self.materials.materials.iter().any(through)
    }

    /// Whether a point of a triangle is there at all: everything is, but what an alpha mask cuts away.
    #[must_use]
    pub fn is_solid(&self, triangle: u32, barycentric: [f32; 2]) -> bool {
        match self.material(triangle).alpha {
            Alpha::Opaque | Alpha::Blend => true,
            Alpha::Mask { cutoff } => self.opacity(triangle, barycentric) >= cutoff,
        }
    }

    /// Whether a point of a triangle keeps light off what is behind it: masked-out points don't, blended ones do where
    /// they are at least half opaque, and materials that transmit at least half of the light don't at all.
    #[must_use]
    pub fn casts_shadow(&self, triangle: u32, barycentric: [f32; 2]) -> bool {
        let material = self.material(triangle);
        if material.transmission >= 0.5 {
            return false;
        }
        match material.alpha {
            Alpha::Opaque => true,
            Alpha::Blend => self.opacity(triangle, barycentric) >= 0.5,
            Alpha::Mask { cutoff } => self.opacity(triangle, barycentric) >= cutoff,
        }
    }

    /// Opacity of a point of a triangle, read from the full-size texture: the same for every ray that asks.
    fn opacity(&self, triangle: u32, barycentric: [f32; 2]) -> f32 {
        let material = self.material(triangle);
        let texture = material.base_color_texture.map_or(1.0, |texture| {
            let coords = texture.image_coords(self.tex_coords(triangle, barycentric));
            self.materials.textures[texture.texture as usize].opacity(coords)
        });
        material.base_color.w * self.vertex_color(triangle, barycentric).w * texture
    }
}
