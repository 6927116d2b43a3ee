//! Certain answers around a point of a masked triangle hold at every point there.

use std::sync::Arc;

use glam::{Affine2, Vec2, Vec4};
use proptest::prelude::*;
use umbrage_rays::{MaskAnswers, MaskPoints, Opacity as _};
use umbrage_scene::{
    Alpha, ColorSpace, Filter, Frame, FrameOpacity, Material, Materials, Mesh, Texture, TextureUse, Wrap,
};

/// A frame of one triangle with a mask.
#[derive(Clone, Debug)]
struct Leaf {
    size: [u32; 2],
    opacities: Vec<u8>,
    filter: Filter,
    wrap: [Wrap; 2],
    tex_coords: [[f32; 2]; 3],
    vertex_opacities: Option<[f32; 3]>,
    turn_radians: f32,
    base: f32,
    alpha: Alpha,
}

impl Leaf {
    fn frame(&self) -> Frame {
        let texels = self.opacities.iter().map(|&opacity| [255, 255, 255, opacity]).collect();
        let texture = Texture::new("mask", self.size, texels, ColorSpace::Srgb, self.filter, self.wrap);
        let image_from_mesh =
            Affine2::from_scale_angle_translation(Vec2::new(1.5, 0.7), self.turn_radians, Vec2::new(0.3, -2.0));
        let material = Material {
            base_color: Vec4::new(1.0, 1.0, 1.0, self.base),
            base_color_texture: Some(TextureUse { image_from_mesh, ..TextureUse::new(0) }),
            alpha: self.alpha,
            ..Material::default()
        };
        let colors = self.vertex_opacities.map_or(Vec::new(), |three| three.map(|w| Vec4::ONE.with_w(w)).to_vec());
        let mesh = Mesh {
            triangles: vec![[0, 1, 2]],
            material_of_triangle: vec![0],
            tex_coords: [self.tex_coords.map(Vec2::from).to_vec(), Vec::new()],
            colors,
            ..Mesh::default()
        };
        let materials = Materials { materials: vec![material], textures: vec![texture] };
        Frame { mesh: Arc::new(mesh), materials: Arc::new(materials), ..Frame::default() }
    }
}

fn leaf() -> impl Strategy<Value = Leaf> {
    let wrap = || prop_oneof![Just(Wrap::Repeat), Just(Wrap::MirroredRepeat), Just(Wrap::ClampToEdge)];
    let image = (1..9_u32, 1..9_u32).prop_flat_map(|(width, height)| {
        let texel = prop_oneof![4 => Just(0_u8), 4 => Just(255), 1 => any::<u8>()];
        (Just([width, height]), prop::collection::vec(texel, (width * height) as usize))
    });
    let coordinate = || prop_oneof![4 => -1.5..1.5_f32, 1 => -300.0..300.0_f32];
    let reading = (prop_oneof![Just(Filter::Nearest), Just(Filter::Linear)], wrap(), wrap());
    let tex_coords = prop::array::uniform3([coordinate(), coordinate()]);
    let vertex_opacities = prop::option::weighted(0.3, prop::array::uniform3(0.0..1.0_f32));
    let base = prop_oneof![Just(1.0_f32), 0.3..1.0_f32];
    let alpha = prop_oneof![
        4 => (0.01..1.0_f32).prop_map(|cutoff| Alpha::Mask { cutoff }),
        4 => Just(Alpha::Mask { cutoff: 0.5 }),
        1 => Just(Alpha::Blend),
    ];
    (image, reading, tex_coords, vertex_opacities, prop_oneof![Just(0.0_f32), -3.0..3.0_f32], base, alpha).prop_map(
        |((size, opacities), (filter, across, down), tex_coords, vertex_opacities, turn_radians, base, alpha)| Leaf {
            size,
            opacities,
            filter,
            wrap: [across, down],
            tex_coords,
            vertex_opacities,
            turn_radians,
            base,
            alpha,
        },
    )
}

/// The certain answer for all points within `error` of a point, asked in one lane; `None` if undecided.
fn stops_within(opacity: FrameOpacity<'_>, [v, w]: [f32; 2], error: f32) -> Option<bool> {
    const LANE: u16 = 1 << 5;
    let points = MaskPoints { barycentric: [[v; 16], [w; 16]], error: [error; 16], lanes: LANE };
    let MaskAnswers { opaque, cut } = opacity.which_stop(0, &points);
    assert_eq!((opaque & cut, (opaque | cut) & !LANE), (0, 0));
    (opaque | cut != 0).then_some(opaque != 0)
}

/// Whether the certain answers around `point` hold at `there`, which is within `error` of it.
fn holds(frame: &Frame, point: [f32; 2], error: f32, there: [f32; 2]) -> bool {
    let agrees = |certain: Option<bool>, truth: bool| certain.is_none_or(|certain| certain == truth);
    let opacities = [frame.camera_opacity(), frame.shadow_opacity()];
    opacities.iter().all(|opacity| agrees(stops_within(*opacity, point, error), opacity.stops(0, there)))
}

/// Bisects to two neighbouring f32 points between `from` and `to` for which `stops` differs, as it does for these two.
fn border(stops: impl Fn([f32; 2]) -> bool, mut from: [f32; 2], mut to: [f32; 2]) -> [[f32; 2]; 2] {
    let side = stops(from);
    loop {
        let middle = [0, 1].map(|axis| from[axis].midpoint(to[axis]));
        if middle == from || middle == to {
            return [from, to];
        }
        *if stops(middle) == side { &mut from } else { &mut to } = middle;
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn what_is_certain_around_a_point_holds_at_each(
        leaf in leaf(),
        points in prop::collection::vec((0.0..1.0_f32, 0.0..1.0_f32, -7.0..-0.7_f32), 20),
        moves in prop::collection::vec((-1.0..=1.0_f32, -1.0..=1.0_f32), 12),
    ) {
        let frame = leaf.frame();
        for (v, w, exponent) in points {
            let (w, error) = (w * (1.0 - v), 10.0_f32.powf(exponent));
            let corners = [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0), (0.0, 0.0)];
            for (along, across) in moves.iter().copied().chain(corners) {
                let moved = |from: f32, by: f32| {
                    let to = from + by * error;
                    // Rounding of the sum mustn't exceed `error`.
                    if (f64::from(to) - f64::from(from)).abs() <= f64::from(error) { to } else { from }
                };
                let there = [moved(v, along), moved(w, across)];
                prop_assert!(holds(&frame, [v, w], error, there), "{:?} around {:?}, {}", there, [v, w], error);
            }
        }
    }

    #[test]
    fn nothing_is_certain_at_borders(
        leaf in leaf(),
        points in prop::collection::vec((0.0..1.0_f32, 0.0..1.0_f32), 20),
    ) {
        // Tests points so near the border that rounding decides opacity.
        let frame = leaf.frame();
        let points: Vec<[f32; 2]> = points.into_iter().map(|(v, w)| [v, w * (1.0 - v)]).collect();
        let opacities = [frame.camera_opacity(), frame.shadow_opacity()];
        for (opacity, ends) in opacities.iter().flat_map(|opacity| points.windows(2).map(move |ends| (opacity, ends))) {
            let stops = |point: [f32; 2]| opacity.stops(0, point);
            if stops(ends[0]) == stops(ends[1]) {
                continue;
            }
            let pair = border(stops, ends[0], ends[1]);
            let apart = (pair[0][0] - pair[1][0]).abs().max((pair[0][1] - pair[1][1]).abs());
            for [here, there] in [[pair[0], pair[1]], [pair[1], pair[0]]] {
                // With a reach smaller than the distance to the next point; with that distance; and from a point slightly
                // beside both.
                prop_assert!(holds(&frame, here, 1e-12, here), "{:?} of {:?}", here, pair);
                prop_assert!(holds(&frame, here, apart, there), "{:?} of {:?}", here, pair);
                let beside = [here[0] + 3e-7, here[1] - 3e-7];
                prop_assert!(holds(&frame, beside, 6e-7, here) && holds(&frame, beside, 6e-7, there), "{:?}", pair);
            }
        }
    }
}

#[test]
fn most_of_a_leaf_is_certain() {
    let disc = |texel: u32| {
        let from_middle = Vec2::new((texel % 64) as f32, (texel / 64) as f32) - 31.5;
        if from_middle.length() < 20.0 { 255 } else { 0 }
    };
    let leaf = Leaf {
        size: [64; 2],
        opacities: (0..64 * 64).map(disc).collect(),
        filter: Filter::Linear,
        wrap: [Wrap::Repeat; 2],
        tex_coords: [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]],
        vertex_opacities: None,
        turn_radians: 0.0,
        base: 1.0,
        alpha: Alpha::Mask { cutoff: 0.5 },
    };
    let frame = leaf.frame();
    let points = (0..100).flat_map(|v| (0..100 - v).map(move |w| [v, w].map(|weight| weight as f32 / 100.0)));
    let answers: Vec<_> = points.map(|point| stops_within(frame.camera_opacity(), point, 1e-4)).collect();
    let undecided = answers.iter().filter(|answer| answer.is_none()).count();
    assert!(undecided * 100 < answers.len(), "{undecided} of {}", answers.len());
    assert!(answers.contains(&Some(true)) && answers.contains(&Some(false)));
}
