//! Materials and procedural textures.

use glam::{Affine2, Vec2, Vec3, Vec4};

use super::math::pow;
use umbrage_scene::{Alpha, ColorSpace, Filter, Material, Texture, TextureUse, Wrap};

/// The linear colour of an sRGB colour written as `0xrrggbb`.
pub(crate) fn srgb(hex: u32) -> Vec3 {
    let linear = |byte: u32| {
        let encoded = (byte & 0xff) as f32 / 255.0;
        if encoded <= 0.040_45 { encoded / 12.92 } else { pow((encoded + 0.055) / 1.055, 2.4) }
    };
    Vec3::new(linear(hex >> 16), linear(hex >> 8), linear(hex))
}

/// A material of the demos; the names in a demo are unique.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Paint {
    pub(crate) name: &'static str,
    look: Look,
    roughness: f32,
    masked: bool,
}

#[derive(Clone, Copy, Debug)]
enum Look {
    /// An sRGB colour.
    Dull(u32),
    /// The function that gives the linear colour.
    Metal(fn() -> Vec3),
    /// The function that makes the image, and the texture coordinates that span it once along both axes.
    Image(fn() -> Texture, Vec2),
    /// An sRGB colour and its strength.
    Glow(u32, f32),
}

impl Paint {
    const fn new(name: &'static str, look: Look, roughness: f32) -> Self {
        Self { name, look, roughness, masked: false }
    }

    /// Paint, stone, wood, … of an sRGB colour; `roughness` 0 … 1.
    pub(crate) const fn dull(name: &'static str, srgb: u32, roughness: f32) -> Self {
        Self::new(name, Look::Dull(srgb), roughness)
    }

    /// A metal whose reflection is tinted by the linear colour that `color` gives; at `roughness` 0 it is a mirror.
    pub(crate) const fn metal(name: &'static str, color: fn() -> Vec3, roughness: f32) -> Self {
        Self::new(name, Look::Metal(color), roughness)
    }

    /// A material whose colour is a texture; `repeat` texture coordinates span the image once, along both axes.
    pub(crate) const fn textured(
        name: &'static str,
        texture: fn() -> Texture,
        repeat: [f32; 2],
        roughness: f32,
    ) -> Self {
        Self::new(name, Look::Image(texture, Vec2::from_array(repeat)), roughness)
    }

    /// A material that glows in an sRGB colour.
    pub(crate) const fn glowing(name: &'static str, srgb: u32, strength: f32, roughness: f32) -> Self {
        Self::new(name, Look::Glow(srgb, strength), roughness)
    }

    /// The same, cut out by the opacity of its texture.
    pub(crate) const fn masked(self) -> Self {
        Self { masked: true, ..self }
    }

    /// The material itself, with two-sided triangles. Its texture is added to `textures`.
    pub(crate) fn material(self, textures: &mut Vec<Texture>) -> Material {
        let Self { name, look, roughness, masked } = self;
        let mut material = Material { name: name.into(), roughness, double_sided: true, ..Material::default() };
        match look {
            Look::Dull(color) => material.base_color = srgb(color).extend(1.0),
            Look::Metal(color) => (material.base_color, material.metallic) = (color().extend(1.0), 1.0),
            Look::Image(texture, repeat) => {
                let image_from_mesh = Affine2::from_scale(repeat.recip());
                let used = TextureUse { image_from_mesh, ..TextureUse::new(textures.len() as u32) };
                material.base_color_texture = Some(used);
                textures.push(texture());
            }
            Look::Glow(color, strength) => material.emissive = srgb(color) * strength,
        }
        if masked {
            material.alpha = Alpha::Mask { cutoff: 0.5 };
        }
        material
    }
}

/// A repeating colour texture of `size` texels: `color` gives the linear colour and opacity at (x, y), each 0 … 1,
/// from the upper left corner.
pub(crate) fn color_texture(name: &str, size: [u32; 2], color: impl Fn(Vec2) -> Vec4) -> Texture {
    painted(name, size, Wrap::Repeat, &color)
}

/// As [`color_texture`], but mirrored at its edges: for irregular patterns, which would show a seam when repeated.
pub(crate) fn mottled_texture(name: &str, size: [u32; 2], color: impl Fn(Vec2) -> Vec4) -> Texture {
    painted(name, size, Wrap::MirroredRepeat, &color)
}

fn painted(name: &str, size: [u32; 2], wrap: Wrap, color: &dyn Fn(Vec2) -> Vec4) -> Texture {
    let byte = |linear: f32| {
        let linear = linear.clamp(0.0, 1.0);
        let encoded = if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * pow(linear, 1.0 / 2.4) - 0.055 };
        (encoded * 255.0 + 0.5) as u8
    };
    let [width, height] = size;
    let texels = (0..height)
        .flat_map(|y| (0..width).map(move |x| Vec2::new(x as f32 + 0.5, y as f32 + 0.5)))
        .map(|texel| {
            let color = color(texel / Vec2::new(width as f32, height as f32));
            let opacity = (color.w.clamp(0.0, 1.0) * 255.0 + 0.5) as u8;
            [byte(color.x), byte(color.y), byte(color.z), opacity]
        })
        .collect();
    Texture::new(name, size, texels, ColorSpace::Srgb, Filter::Linear, [wrap; 2])
}

/// Two colours in squares, two by two: one square is half the image wide.
pub(crate) fn checker(name: &str, side_texels: u32, dark: Vec3, light: Vec3) -> Texture {
    color_texture(name, [side_texels; 2], |at| {
        let odd = (at.x < 0.5) != (at.y < 0.5);
        if odd { dark } else { light }.extend(1.0)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colors_survive_the_way_into_a_texture() {
        let color = srgb(0x80_40_c0);
        assert!(color.abs_diff_eq(Vec3::new(0.2159, 0.0513, 0.5271), 1e-3), "{color}");
        let texture = color_texture("plain", [4, 4], |_| color.extend(0.5));
        assert!(texture.sample(Vec2::splat(0.4), 1.0).truncate().abs_diff_eq(color, 1e-3));
        assert!((texture.opacity(Vec2::ZERO) - 0.5).abs() < 0.01);
    }

    #[test]
    fn checkers_alternate() {
        let texture = checker("board", 8, Vec3::ZERO, Vec3::ONE);
        let read = |x: f32, y: f32| texture.sample(Vec2::new(x, y), 1.0).x;
        assert_eq!([read(0.25, 0.25), read(0.75, 0.25), read(0.25, 0.75), read(0.75, 0.75)], [1.0, 0.0, 0.0, 1.0]);
    }
}
