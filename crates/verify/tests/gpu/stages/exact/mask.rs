//! Opacity masks.

use std::sync::Arc;

use glam::{Affine2, Vec2, Vec4};
use umbrage_rays::Opacity as _;
use umbrage_scene::{Alpha, ColorSpace, Filter, Frame, Material, Materials, Mesh, Texture, TextureUse, Wrap};

use super::{Random, common, kernel, map};

const CASE_WORDS: usize = 64;
const FIRST_TEXEL: usize = 24;
const MOST_TEXELS: usize = CASE_WORDS - FIRST_TEXEL;

/// A point of a masked triangle, which is there if its opacity is at least the cutoff: two neighbouring cutoffs find
/// the opacity to its last bit.
#[test]
fn opacities_are_those_that_the_frame_compares() {
    let Some(gpu) = common::gpu() else { return };
    let kernel = kernel(&gpu, include_str!("mask.wgsl"), "opacities");
    let mut random = Random(8);
    let leaves: Vec<_> = (0..1 << 15).map(|_| Leaf::random(&mut random)).collect();
    let cases: Vec<_> = leaves.iter().map(Leaf::case).collect();
    let answers = map(&gpu, &kernel, &cases, 2);
    let mut between = 0;
    for (leaf, answer) in leaves.iter().zip(answers.chunks_exact(2)) {
        let opacity = f32::from_bits(answer[0]);
        let is_there = |cutoff: f32| leaf.frame(Alpha::Mask { cutoff }).camera_opacity().stops(0, leaf.barycentric);
        if opacity.is_nan() {
            assert!(!is_there(f32::NEG_INFINITY), "{leaf:?}: no number");
        } else {
            assert!(is_there(opacity) && !is_there(opacity.next_up()), "{leaf:?}: {opacity:e}");
        }
        let casts = leaf.frame(Alpha::Blend).shadow_opacity().stops(0, leaf.barycentric);
        assert_eq!(answer[1] != 0, casts, "{leaf:?}: {opacity:e}");
        between += usize::from(opacity > 0.0 && opacity < 1.0);
    }
    assert!(between > leaves.len() / 2, "{between} of {} opacities between nothing and all", leaves.len());
}

#[derive(Clone, Debug)]
struct Leaf {
    size: [u32; 2],
    texels: Vec<u8>,
    filter: Filter,
    wrap: [Wrap; 2],
    image_from_mesh: Affine2,
    tex_coords: [Vec2; 3],
    vertex_opacities: [f32; 3],
    base: f32,
    barycentric: [f32; 2],
}

impl Leaf {
    fn random(random: &mut Random) -> Self {
        let size = [1 + random.below(6) as u32, 1 + random.below(6) as u32];
        let wraps = [Wrap::Repeat, Wrap::MirroredRepeat, Wrap::ClampToEdge];
        let mut single = |most: f64| ((random.unit() * 2.0 - 1.0) * most) as f32;
        let turn = Affine2::from_scale_angle_translation(
            Vec2::new(single(2.0), single(2.0)),
            single(3.0),
            Vec2::new(single(2.0), single(2.0)),
        );
        let (v, w) = (single(0.5).abs(), single(0.5).abs());
        // Far from the image, positions are integers, at last so large that adding one changes nothing.
        let reach = 10.0_f64.powi(random.below(12) as i32 - 1) * if random.below(50) == 0 { 1e30 } else { 1.0 };
        let mut coordinate = || match random.below(16) {
            0 => random.any_f32(),
            1 => 0.0,
            2 => random.below(9) as f32 * 0.25 - 1.0,
            _ => ((random.unit() * 2.0 - 1.0) * reach) as f32,
        };
        let tex_coords = [(); 3].map(|()| Vec2::new(coordinate(), coordinate()));
        Self {
            size,
            texels: (0..size[0] * size[1]).map(|_| random.bits() as u8).collect(),
            filter: if random.below(4) == 0 { Filter::Nearest } else { Filter::Linear },
            wrap: [(); 2].map(|()| wraps[random.below(3) as usize]),
            image_from_mesh: if random.below(2) == 0 { Affine2::IDENTITY } else { turn },
            tex_coords,
            vertex_opacities: if random.below(2) == 0 { [1.0; 3] } else { [(); 3].map(|()| random.unit() as f32) },
            base: if random.below(2) == 0 { 1.0 } else { random.unit() as f32 },
            barycentric: if random.below(8) == 0 { [0.0, 0.0] } else { [v, w] },
        }
    }

    fn frame(&self, alpha: Alpha) -> Frame {
        let texels = self.texels.iter().map(|&opacity| [255, 255, 255, opacity]).collect();
        let texture = Texture::new("mask", self.size, texels, ColorSpace::Srgb, self.filter, self.wrap);
        let texture_use = TextureUse { image_from_mesh: self.image_from_mesh, ..TextureUse::new(0) };
        let material = Material {
            base_color: Vec4::ONE.with_w(self.base),
            base_color_texture: Some(texture_use),
            alpha,
            ..Material::default()
        };
        let mesh = Mesh {
            triangles: vec![[0, 1, 2]],
            material_of_triangle: vec![0],
            tex_coords: [self.tex_coords.to_vec(), Vec::new()],
            colors: self.vertex_opacities.map(|opacity| Vec4::ONE.with_w(opacity)).to_vec(),
            ..Mesh::default()
        };
        let materials = Materials { materials: vec![material], textures: vec![texture] };
        Frame { mesh: Arc::new(mesh), materials: Arc::new(materials), ..Frame::default() }
    }

    fn case(&self) -> [u32; CASE_WORDS] {
        let wrap = |wrap| match wrap {
            Wrap::Repeat => 0,
            Wrap::MirroredRepeat => 1,
            Wrap::ClampToEdge => 2,
        };
        let coords = [self.tex_coords.map(|coords| coords.x), self.tex_coords.map(|coords| coords.y)];
        let mut words: Vec<u32> = self.image_from_mesh.to_cols_array().map(f32::to_bits).to_vec();
        words.extend(self.size);
        words.extend(self.wrap.map(wrap));
        words.push(u32::from(self.filter == Filter::Linear));
        words.extend(self.barycentric.map(f32::to_bits));
        words.extend(coords.into_iter().flatten().map(f32::to_bits));
        words.extend(self.vertex_opacities.map(f32::to_bits));
        words.push(self.base.to_bits());
        words.resize(FIRST_TEXEL, 0);
        assert!(self.texels.len() <= MOST_TEXELS);
        words.extend(self.texels.iter().map(|&texel| u32::from(texel)));
        words.resize(CASE_WORDS, 0);
        words.try_into().expect("as many words")
    }
}
