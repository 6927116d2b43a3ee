use glam::{Vec2, Vec3, Vec4};

use umbrage_rays::{MaskAnswers, MaskPoints, Opacity};

use crate::texture::TexelRanges;
use crate::{Alpha, Clearcoat, Frame, Layers, Material, Texture, TextureUse};

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

    /// Whether any material may show objects straight behind its surfaces.
    #[must_use]
    pub fn is_see_through(&self) -> bool {
        self.materials.materials.iter().any(Material::is_see_through)
    }

    /// Opacity for camera rays: all points stop them, except those that alpha masks cut away.
    #[must_use]
    pub fn camera_opacity(&self) -> FrameOpacity<'_> {
        FrameOpacity::new(self, false)
    }

    /// Opacity for shadow rays: masked-out points don't stop them, blended ones do where they are at least half opaque,
    /// and materials that transmit at least half of the light never do.
    #[must_use]
    pub fn shadow_opacity(&self) -> FrameOpacity<'_> {
        FrameOpacity::new(self, true)
    }

    /// Share of red, green and blue light that passes straight through a point of a triangle: the part that opacity
    /// leaves, and the part that is transmitted rather than mirrored at the front.
    #[must_use]
    pub fn passing(&self, triangle: u32, barycentric: [f32; 2]) -> Vec3 {
        let material = self.material(triangle);
        let tex_coords = self.tex_coords(triangle, barycentric);
        let read = |texture: Option<TextureUse>| {
            texture.map_or(Vec4::ONE, |texture| {
                self.materials.textures[texture.texture as usize].sample(texture.image_coords(tex_coords), 0.0)
            })
        };
        let texel = read(material.base_color_texture);
        let color = material.base_color * self.vertex_color(triangle, barycentric) * texel;
        let opacity = match material.alpha {
            Alpha::Opaque => 1.0,
            Alpha::Blend => color.w.clamp(0.0, 1.0),
            Alpha::Mask { cutoff } => f32::from(self.opacity(triangle, barycentric) >= cutoff),
        };
        let ahead = ((material.ior - 1.0) / (material.ior + 1.0)).powi(2);
        let entering = material.layers.as_ref().map_or(1.0 - ahead, |layers| {
            let Layers { specular, clearcoat, .. } = &**layers;
            let color = specular.color * read(specular.color_texture).truncate();
            let weight = (specular.factor * read(specular.texture).w).clamp(0.0, 1.0);
            let coat = (clearcoat.factor * read(clearcoat.texture).x).clamp(0.0, 1.0);
            (1.0 - (color * ahead).max_element().clamp(0.0, 1.0) * weight) * (1.0 - Clearcoat::F0 * coat)
        });
        let metallic = material.metallic * read(material.metallic_roughness_texture).z;
        let transmission = material.transmission.max(0.0) * read(material.transmission_texture).x * (1.0 - metallic);
        Vec3::splat(1.0 - opacity) + color.truncate() * (opacity * transmission * entering)
    }

    /// Opacity of a point of a triangle, read from the full-size texture: the same for every ray.
    fn opacity(&self, triangle: u32, barycentric: [f32; 2]) -> f32 {
        let material = self.material(triangle);
        let texture = material.base_color_texture.map_or(1.0, |texture| {
            let coords = texture.image_coords(self.tex_coords(triangle, barycentric));
            self.materials.textures[texture.texture as usize].opacity(coords)
        });
        material.base_color.w * self.vertex_color(triangle, barycentric).w * texture
    }
}

/// Opacity of a frame's triangles for camera rays or for shadow rays.
#[derive(Clone, Copy, Debug)]
pub struct FrameOpacity<'a> {
    frame: &'a Frame,
    of_shadows: bool,
    /// Whether all materials are opaque.
    are_all_opaque: bool,
}

/// The part of a triangle that stops rays.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum OpaquePart {
    /// All of it.
    All,
    /// Nothing of it.
    None,
    /// Where its opacity is at least this.
    AtLeast(f32),
}

impl Material {
    /// The part of its triangles that stops camera rays.
    #[must_use]
    pub fn camera_part(&self) -> OpaquePart {
        match self.alpha {
            Alpha::Opaque | Alpha::Blend => OpaquePart::All,
            Alpha::Mask { cutoff } => OpaquePart::AtLeast(cutoff),
        }
    }

    /// The part of its triangles that stops shadow rays.
    #[must_use]
    pub fn shadow_part(&self) -> OpaquePart {
        match self.alpha {
            _ if self.transmission >= 0.5 => OpaquePart::None,
            Alpha::Opaque => OpaquePart::All,
            Alpha::Blend => OpaquePart::AtLeast(0.5),
            Alpha::Mask { cutoff } => OpaquePart::AtLeast(cutoff),
        }
    }
}

impl<'a> FrameOpacity<'a> {
    fn new(frame: &'a Frame, of_shadows: bool) -> Self {
        let is_opaque = |material| part(material, of_shadows) == OpaquePart::All;
        let are_all_opaque = frame.materials.materials.iter().all(is_opaque);
        Self { frame, of_shadows, are_all_opaque }
    }

    fn part(&self, triangle: u32) -> OpaquePart {
        part(self.frame.material(triangle), self.of_shadows)
    }
}

fn part(material: &Material, of_shadows: bool) -> OpaquePart {
    if of_shadows { material.shadow_part() } else { material.camera_part() }
}

impl Opacity for FrameOpacity<'_> {
    fn is_opaque(&self, triangle: u32) -> bool {
        self.are_all_opaque || self.part(triangle) == OpaquePart::All
    }

    fn are_all_opaque(&self) -> bool {
        self.are_all_opaque
    }

    fn stops(&self, triangle: u32, barycentric: [f32; 2]) -> bool {
        match self.part(triangle) {
            OpaquePart::All => true,
            OpaquePart::None => false,
            OpaquePart::AtLeast(cutoff) => self.frame.opacity(triangle, barycentric) >= cutoff,
        }
    }

    fn which_stop(&self, triangle: u32, points: &MaskPoints) -> MaskAnswers {
        let &MaskPoints { barycentric: [v, w], error, lanes } = points;
        let cutoff = match self.part(triangle) {
            OpaquePart::All => return MaskAnswers { opaque: lanes, cut: 0 },
            OpaquePart::None => return MaskAnswers { opaque: 0, cut: lanes },
            OpaquePart::AtLeast(cutoff) => cutoff,
        };
        let plane = OpacityPlane::new(self.frame, triangle);
        let mut answers = plane.decided_by_cells(cutoff, points);
        let mut left = lanes & !(answers.opaque | answers.cut);
        while left != 0 {
            let lane = left.trailing_zeros() as usize;
            match plane.is_above(cutoff, [v[lane], w[lane]], error[lane]) {
                Some(true) => answers.opaque |= 1 << lane,
                Some(false) => answers.cut |= 1 << lane,
                None => {}
            }
            left &= left - 1;
        }
        answers
    }
}

/// Factors of a triangle's opacity, as linear functions of the weights of its second and third vertex.
#[derive(Debug)]
struct OpacityPlane<'a> {
    texture: Option<&'a Texture>,
    /// Texture coordinates, in texels, of the first vertex, and from there to the others.
    coords: [Vec2; 3],
    /// Their error bound along each axis.
    coords_error: Vec2,
    /// Vertex opacity of the first vertex, and how much more it is at the others.
    vertex: [f32; 3],
    /// Error bound of a vertex opacity.
    vertex_error: f32,
    /// The material's own opacity.
    base: f32,
}

impl<'a> OpacityPlane<'a> {
    /// Maximum distance of weights outside 0 … 1, and maximum of their errors.
    const OVERHANG: f32 = 0.25;

    /// Roundings between two ways to interpolate three values up to one, which are linear functions of them with three
    /// steps in between; f32 ulps relative to the largest that takes part.
    ///
    /// With weights that are at most 1/2 outside of their range, the magnitudes of three weights add up to three at most.
    /// In half ulps, the way of [`Frame::tex_coords`] is wrong by 12.5 (3.5 for the first weight, 3 for the products, 6
    /// for the sums), the transform by 12 more, the product with the size by 3 and the move by half a texel by 3.5. The
    /// way taken here is wrong by 4 for the first vertex, 25 for the differences and their conversion to texels, 16 for
    /// products and sums, and by 14 for the reach and the bounds around it.
    const ROUNDING: f32 = 64.0 * f32::EPSILON;

    fn new(frame: &'a Frame, triangle: u32) -> Self {
        let material = frame.material(triangle);
        let vertices = frame.mesh.triangles[triangle as usize].map(|vertex| vertex as usize);
        let mut plane = Self {
            texture: None,
            coords: [Vec2::ZERO; 3],
            coords_error: Vec2::ZERO,
            vertex: [1.0, 0.0, 0.0],
            vertex_error: 0.0,
            base: material.base_color.w,
        };
        if let Some(used) = &material.base_color_texture {
            let texture = &frame.materials.textures[used.texture as usize];
            let coords = &frame.mesh.tex_coords[usize::from(used.tex_coord_set.min(1))];
            let [a, b, c] = if coords.is_empty() { [Vec2::ZERO; 3] } else { vertices.map(|vertex| coords[vertex]) };
            let [width, height] = texture.size();
            let (size, transform) = (Vec2::new(width as f32, height as f32), &used.image_from_mesh);
            let matrix = &transform.matrix2;
            plane.coords = [transform.transform_point2(a), *matrix * (b - a), *matrix * (c - a)].map(|at| at * size);
            let largest = a.abs().max(b.abs()).max(c.abs());
            let reach = matrix.x_axis.abs() * largest.x + matrix.y_axis.abs() * largest.y + transform.translation.abs();
            plane.coords_error = (reach * size + 0.5) * Self::ROUNDING;
            plane.texture = Some(texture);
        }
        if !frame.mesh.colors.is_empty() {
            let [a, b, c] = vertices.map(|vertex| frame.mesh.colors[vertex].w);
            plane.vertex = [a, b - a, c - a];
            plane.vertex_error = a.abs().max(b.abs()).max(c.abs()) * Self::ROUNDING;
        }
        plane
    }

    /// Decides points by the texels around each, without their own opacity: most points are away from the mask's edge. Those
    /// that it leaves may be decided by [`is_above`](Self::is_above), which would answer the same for these.
    fn decided_by_cells(&self, cutoff: f32, points: &MaskPoints) -> MaskAnswers {
        let (mut answers, least) = (MaskAnswers::default(), -Self::OVERHANG);
        let Some(texture) = self.texture else { return answers };
        let [origin, to_second, to_third] = self.coords;
        let spread = to_second.abs() + to_third.abs();
        let mut ranges = TexelRanges::new(texture.filter());
        let MaskPoints { barycentric: [second, third], error, mut lanes } = *points;
        let (mut vertex_low, mut vertex_high, mut usable) = ([0.0; 16], [0.0; 16], [false; 16]);
        // Without branches, so that it becomes vectors.
        for lane in 0..16 {
            let (v, w, error) = (second[lane], third[lane], error[lane]);
            let is_near = (v >= least) & (w >= least) & (v + w <= 1.0 - least);
            let (coords, reach) = (origin + (to_second * v + to_third * w), spread * error + self.coords_error);
            let is_close = ranges.set(lane, coords, reach);
            let vertex = self.vertex[0] + (self.vertex[1] * v + self.vertex[2] * w);
            let vertex_error = (self.vertex[1].abs() + self.vertex[2].abs()) * error + self.vertex_error;
            (vertex_low[lane], vertex_high[lane]) = (vertex - vertex_error, vertex + vertex_error);
            let is_ordered = (self.base >= 0.0) & (vertex_low[lane] >= 0.0);
            usable[lane] = is_near & (0.0..=Self::OVERHANG).contains(&error) & is_close & is_ordered;
        }
        while lanes != 0 {
            let lane = lanes.trailing_zeros() as usize % 16;
            lanes &= lanes - 1;
            if usable[lane]
                && let Some([low, high]) = texture.opacity_of_cells(&ranges, lane)
            {
                answers.opaque |= u16::from(self.base * vertex_low[lane] * low >= cutoff) << lane;
                answers.cut |= u16::from(self.base * vertex_high[lane] * high < cutoff) << lane;
            }
        }
        answers
    }

    /// Whether the opacity of all points within `error` is at least `cutoff`, or that of none is; `None` where undecided.
    #[inline]
    fn is_above(&self, cutoff: f32, barycentric: [f32; 2], error: f32) -> Option<bool> {
        let [low, high] = self.opacity_within(barycentric, error)?;
        if low >= cutoff {
            Some(true)
        } else if high < cutoff {
            Some(false)
        } else {
            None
        }
    }

    /// Bounds of the opacity, as [`Opacity::stops`] finds it, of all points within `error`; `None` where they aren't
    /// known.
    #[inline]
    fn opacity_within(&self, [v, w]: [f32; 2], error: f32) -> Option<[f32; 2]> {
        let least = -Self::OVERHANG;
        let usable = v >= least && w >= least && v + w <= 1.0 - least && (0.0..=Self::OVERHANG).contains(&error);
        if !usable {
            return None;
        }
        let texture = match self.texture {
            None => [1.0; 2],
            Some(texture) => {
                let [origin, to_second, to_third] = self.coords;
                let reach = (to_second.abs() + to_third.abs()) * error + self.coords_error;
                texture.opacity_around(origin + (to_second * v + to_third * w), reach)?
            }
        };
        let [origin, to_second, to_third] = self.vertex;
        let vertex = origin + (to_second * v + to_third * w);
        let vertex_error = (to_second.abs() + to_third.abs()) * error + self.vertex_error;
        let vertex = [vertex - vertex_error, vertex + vertex_error];
        // Where no factor is below zero, rounded products are in the same order as they.
        let is_ordered = self.base >= 0.0 && vertex[0] >= 0.0;
        is_ordered.then(|| [0, 1].map(|bound: usize| self.base * vertex[bound] * texture[bound]))
    }
}
