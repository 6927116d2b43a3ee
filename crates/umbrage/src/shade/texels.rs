use std::cell::Cell;

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, i32x16, mask32x16, u32x16};
use glam::{Mat2, Vec2};
use umbrage_scene::{ColorSpace, Filter, Frame, Texture, TextureUse, Wrap};

use super::hits::BlockHits;
use super::lanes::{Each, LANES, Vectors, each, lanes_of};
use super::transcendental::log2;

/// Reads textures at sixteen hits.
///
/// Coordinates, weights and means are computed in vectors; texels are fetched one after the other, by code that all sets of
/// instructions share. [`Texture::sample`] reads the same at one point, except for rounding.
pub(super) struct Texels<'a, S: Simd> {
    simd: S,
    frame: &'a Frame,
    hits: &'a BlockHits<'a, S>,
    /// Area of each ray's cone on the surface, in triangle areas.
    covered_triangles: f32x16<S>,
    /// Corners of each set, read at its first use.
    corner_coords: [Cell<Option<[Coords<S>; 3]>>; 2],
}

/// Texture coordinates.
type EachCoords = [Each<f32>; 2];
type Coords<S> = [f32x16<S>; 2];

/// Directions of the bumps' axes.
pub(super) struct Tangents {
    /// The lanes that have one, the first in the lowest bit.
    pub(super) lanes: u16,
    /// Of any length, not yet at right angles to the normal.
    pub(super) tangent: [Each<f32>; 3],
    pub(super) bitangent_sign: Each<f32>,
}

impl<'a, S: Simd> Texels<'a, S> {
    #[inline(always)]
    pub(super) fn new(simd: S, frame: &'a Frame, hits: &'a BlockHits<'a, S>, covered_triangles: f32x16<S>) -> Self {
        Self { simd, frame, hits, covered_triangles, corner_coords: [Cell::new(None), Cell::new(None)] }
    }

    /// Red, green, blue and alpha in some lanes. Values in other lanes have no meaning.
    ///
    /// By ray cones (Akenine-Möller et al., *Texture Level of Detail Strategies for Real-Time Ray Tracing*, 2019): averages
    /// as many texels as the pixel's cone covers on the surface.
    // One function for all textures: inlining would copy it for each of them.
    #[inline(never)]
    pub(super) fn read(&self, texture: TextureUse, lanes: u16) -> [Each<f32>; 4] {
        self.simd.vectorize(
            #[inline(always)]
            || {
                let image = &self.frame.materials.textures[texture.texture as usize];
                let (coords, footprint) = self.coords_and_footprint(&texture, image);
                colors(self.simd, image, coords, footprint, lanes)
            },
        )
    }

    /// The same; 1 without a texture.
    pub(super) fn read_any(&self, texture: Option<TextureUse>, lanes: u16) -> [Each<f32>; 4] {
        texture.map_or([each(1.0); 4], |texture| self.read(texture, lanes))
    }

    /// Coordinates of the hits in an image, and the number of its texels along a side of their pixels' cones.
    #[inline(always)]
    fn coords_and_footprint(&self, texture: &TextureUse, image: &Texture) -> (Coords<S>, f32x16<S>) {
        let [a, b, c] = self.corner_coords(texture.tex_coord_set);
        let [second, third] = self.hits.barycentric;
        let first = 1.0 - second - third;
        let (matrix, moved) = (texture.image_from_mesh.matrix2, texture.image_from_mesh.translation);
        let to_second = turned(matrix, [b[0] - a[0], b[1] - a[1]]);
        let to_third = turned(matrix, [c[0] - a[0], c[1] - a[1]]);
        let doubled_area = (to_second[0] * to_third[1] - to_second[1] * to_third[0]).abs();
        let [width, height] = image.size();
        let triangle_texels = doubled_area * 0.5 * width as f32 * height as f32;
        let u = a[0] * first + b[0] * second + c[0] * third;
        let v = a[1] * first + b[1] * second + c[1] * third;
        let [u, v] = turned(matrix, [u, v]);
        ([u + moved.x, v + moved.y], (triangle_texels * self.covered_triangles).sqrt())
    }

    /// Coordinates of each corner, in a set of texture coordinates; zero where the file has none.
    #[inline(always)]
    fn corner_coords(&self, set: u8) -> [Coords<S>; 3] {
        let set = usize::from(set.min(1));
        if let Some(coords) = self.corner_coords[set].get() {
            return coords;
        }
        let of_vertices = &self.frame.mesh.tex_coords[set];
        let coords = self.hits.triangles.corners(
            self.simd,
            #[inline(always)]
            |vertex| of_vertices.get(vertex as usize).copied().unwrap_or_default().to_array(),
        );
        self.corner_coords[set].set(Some(coords));
        coords
    }

    /// The tangents of the file, or else the directions in which the u of a set of texture coordinates grows; none where
    /// there is neither.
    #[inline(never)]
    pub(super) fn tangents(&self, set: u8) -> Tangents {
        self.simd.vectorize(
            #[inline(always)]
            || {
                let (mut tangent, mut negative, mut lanes) = self.gradients(set);
                if !self.frame.tangents.is_empty() {
                    let (of_file, has_direction, is_negative) = self.file_tangents();
                    tangent = Vectors::select(has_direction, of_file, tangent);
                    negative = (has_direction & is_negative) | (!has_direction & negative);
                    lanes |= has_direction;
                }
                let one = f32x16::splat(self.simd, 1.0);
                Tangents {
                    lanes: lanes.to_bitmask() as u16,
                    tangent: tangent.store(),
                    bitangent_sign: negative.select(-one, one).into(),
                }
            },
        )
    }

    /// The directions in which the texture's u grows across the triangles, a mask of negative bitangents, and a mask of the
    /// lanes that have a direction.
    #[inline(always)]
    fn gradients(&self, set: u8) -> (Vectors<S>, mask32x16<S>, mask32x16<S>) {
        let [a, b, c] = self.corner_coords(set);
        let ([u_b, v_b], [u_c, v_c]) = ([b[0] - a[0], b[1] - a[1]], [c[0] - a[0], c[1] - a[1]]);
        let area = u_b * v_c - v_b * u_c;
        let [a, b, c] = self.hits.corners;
        let tangent = (b - a).scaled(v_c) - (c - a).scaled(v_b);
        // v grows downwards in the image and the bitangent points up: an image that isn't mirrored has a negative area.
        let is_mirrored = area.simd_lt(0.0);
        (Vectors::select(is_mirrored, -tangent, tangent), !is_mirrored, !area.simd_eq(0.0))
    }

    /// The file's tangents with a length of 1, a mask of the lanes that have them, and a mask of negative bitangents.
    #[inline(always)]
    fn file_tangents(&self) -> (Vectors<S>, mask32x16<S>, mask32x16<S>) {
        let [[xa, ya, za, sign], [xb, yb, zb, _], [xc, yc, zc, _]] = self.hits.triangles.corners(
            self.simd,
            #[inline(always)]
            |vertex| self.frame.tangents[vertex as usize].to_array(),
        );
        let corners = [Vectors::of_axes([xa, ya, za]), Vectors::of_axes([xb, yb, zb]), Vectors::of_axes([xc, yc, zc])];
        let (unit, has_direction) = self.hits.interpolated(corners).try_normalized();
        (unit, has_direction, sign.simd_lt(0.0))
    }
}

/// Texture coordinates times a matrix.
#[inline(always)]
fn turned<S: Simd>(matrix: Mat2, [u, v]: Coords<S>) -> Coords<S> {
    [u * matrix.x_axis.x + v * matrix.y_axis.x, u * matrix.x_axis.y + v * matrix.y_axis.y]
}

/// The linear colours at some coordinates, averaged over about `footprint` texels of the full image along each side, in some
/// lanes.
#[inline(always)]
fn colors<S: Simd>(simd: S, image: &Texture, coords: Coords<S>, footprint: f32x16<S>, lanes: u16) -> [Each<f32>; 4] {
    // Above this, f32 has less than four numbers between a texel and the next.
    const FAR: f32 = (1 << 22) as f32;
    let last = (image.levels().len() - 1) as f32;
    // NaN footprints (a texture stretched to nothing) read the full image.
    let lod = log2(footprint.max_precise(1.0)).min(last);
    let mut colors = [[0.0; LANES]; 4];
    match image.filter() {
        Filter::Nearest => store(mixed(simd, image, (lod + 0.5).floor(), coords, lanes), &mut colors),
        Filter::Linear => {
            let fine = lod.floor();
            let part = lod - fine;
            let mut mean = mixed(simd, image, fine, coords, lanes);
            if part.simd_gt(0.0).any_true() {
                let coarse = mixed(simd, image, (fine + 1.0).min(last), coords, lanes);
                for (fine, coarse) in mean.iter_mut().zip(coarse) {
                    *fine = between(*fine, coarse, part);
                }
            }
            store(mean, &mut colors);
        }
    }
    let [width, height] = image.size();
    let texels_away = (coords[0].abs() * width as f32).max(coords[1].abs() * height as f32);
    let far = texels_away.simd_ge(FAR).to_bitmask() as u16 & lanes;
    if far != 0 {
        read_far(image, &[coords[0].into(), coords[1].into()], &footprint.into(), far, &mut colors);
    }
    colors
}

#[inline(always)]
fn store<S: Simd>(channels: [f32x16<S>; 4], to: &mut [Each<f32>; 4]) {
    for (channel, to) in channels.into_iter().zip(to) {
        *to = channel.into();
    }
}

/// From `from` at 0 to `to` at 1.
#[inline(always)]
fn between<S: Simd>(from: f32x16<S>, to: f32x16<S>, part: f32x16<S>) -> f32x16<S> {
    from + (to - from) * part
}

/// The colours of one level, mixed from the four nearest texels.
#[inline(always)]
fn mixed<S: Simd>(simd: S, image: &Texture, level: f32x16<S>, [u, v]: Coords<S>, lanes: u16) -> [f32x16<S>; 4] {
    let ([width, height], [wrap_u, wrap_v]) = (image.size(), image.wrap());
    let halvings = ((127 - level.to_int::<i32x16<S>>()) << 23).bitcast::<f32x16<S>>();
    let width = (halvings * width as f32).floor().max(1.0);
    let height = (halvings * height as f32).floor().max(1.0);
    let x = Axis::new(simd, wrap_u, image.filter(), u * width, width);
    let y = Axis::new(simd, wrap_v, image.filter(), v * height, height);
    let levels = level.to_int::<u32x16<S>>().into();
    let texels = image.fetch(lanes, &levels, [&x.first, &x.second], [&y.first, &y.second]);
    let [a, b, c, d] = &texels;
    let bytes = [
        u32x16::from_slice(simd, a),
        u32x16::from_slice(simd, b),
        u32x16::from_slice(simd, c),
        u32x16::from_slice(simd, d),
    ];
    let part = 1.0 / 255.0;
    let alpha = mix(channel(bytes, 3), x.part, y.part) * part;
    match image.space() {
        ColorSpace::Linear => {
            let red = mix(channel(bytes, 0), x.part, y.part) * part;
            let green = mix(channel(bytes, 1), x.part, y.part) * part;
            let blue = mix(channel(bytes, 2), x.part, y.part) * part;
            [red, green, blue, alpha]
        }
        ColorSpace::Srgb => {
            let [red, green, blue] = &linear_from_srgb(&texels);
            let red = mix(load_four(simd, red), x.part, y.part);
            let green = mix(load_four(simd, green), x.part, y.part);
            let blue = mix(load_four(simd, blue), x.part, y.part);
            [red, green, blue, alpha]
        }
    }
}

/// A channel of texels, 0 … 255.
#[inline(always)]
fn channel<S: Simd>([a, b, c, d]: [u32x16<S>; 4], number: u32) -> [f32x16<S>; 4] {
    let bits = 8 * number;
    [
        ((a >> bits) & 255).to_float(),
        ((b >> bits) & 255).to_float(),
        ((c >> bits) & 255).to_float(),
        ((d >> bits) & 255).to_float(),
    ]
}

#[inline(always)]
fn load_four<S: Simd>(simd: S, [a, b, c, d]: &[Each<f32>; 4]) -> [f32x16<S>; 4] {
    [f32x16::from_slice(simd, a), f32x16::from_slice(simd, b), f32x16::from_slice(simd, c), f32x16::from_slice(simd, d)]
}

/// Bilinear mix of the upper left, upper right, lower left and lower right texel.
#[inline(always)]
fn mix<S: Simd>([a, b, c, d]: [f32x16<S>; 4], right: f32x16<S>, down: f32x16<S>) -> f32x16<S> {
    between(between(a, b, right), between(c, d, right), down)
}

/// The texels read along an axis.
struct Axis<S: Simd> {
    first: Each<u32>,
    second: Each<u32>,
    /// The position between the first one's centre and the second's, 0 … 1; NaN where coordinates aren't finite.
    part: f32x16<S>,
}

impl<S: Simd> Axis<S> {
    /// The texels at coordinates in texels, on a side of `side` texels.
    #[inline(always)]
    fn new(simd: S, wrap: Wrap, filter: Filter, at: f32x16<S>, side: f32x16<S>) -> Self {
        match filter {
            Filter::Nearest => {
                let first = texel(wrap, at.floor(), side).into();
                Self { first, second: first, part: f32x16::splat(simd, 0.0) }
            }
            Filter::Linear => {
                let at = at - 0.5;
                let whole = at.floor();
                let (first, second) = (texel(wrap, whole, side).into(), texel(wrap, whole + 1.0, side).into());
                Self { first, second, part: at - whole }
            }
        }
    }
}

/// The texels for whole numbers on a side of `side` texels; the first for NaN.
#[inline(always)]
fn texel<S: Simd>(wrap: Wrap, at: f32x16<S>, side: f32x16<S>) -> u32x16<S> {
    let last = side - 1.0;
    let texel = match wrap {
        Wrap::Repeat => remainder(at, side),
        Wrap::MirroredRepeat => {
            let twice = remainder(at, side * 2.0);
            twice.min(side * 2.0 - 1.0 - twice)
        }
        Wrap::ClampToEdge => at,
    };
    texel.max_precise(0.0).min_precise(last).to_int()
}

/// The remainder of whole numbers below 2²³ in magnitude, 0 … `side` − 1.
#[inline(always)]
fn remainder<S: Simd>(at: f32x16<S>, side: f32x16<S>) -> f32x16<S> {
    // The quotient's floor may be off by one, and every later step is exact.
    let left = at - (at / side).floor() * side;
    let left = left.simd_lt(0.0).select(left + side, left);
    left.simd_ge(side).select(left - side, left)
}

/// Reads some lanes one by one.
#[cold]
fn read_far(image: &Texture, [u, v]: &EachCoords, footprint: &Each<f32>, lanes: u16, colors: &mut [Each<f32>; 4]) {
    for lane in lanes_of(lanes) {
        let color = image.sample(Vec2::new(u[lane], v[lane]), footprint[lane]);
        for (channel, color) in colors.iter_mut().zip(color.to_array()) {
            channel[lane] = color;
        }
    }
}

/// The linear red, green and blue of sRGB texels.
fn linear_from_srgb(texels: &[Each<u32>; 4]) -> [[Each<f32>; 4]; 3] {
    let table = ColorSpace::linear_from_srgb();
    let mut linear = [[[0.0; LANES]; 4]; 3];
    let [red, green, blue] = &mut linear;
    for (index, texels) in texels.iter().enumerate() {
        for (lane, texel) in texels.iter().enumerate() {
            let [r, g, b, _] = texel.to_le_bytes().map(usize::from);
            (red[index][lane], green[index][lane], blue[index][lane]) = (table[r], table[g], table[b]);
        }
    }
    linear
}

#[cfg(test)]
mod tests {
    use glam::Vec4;
    use umbrage_rays::{SimdLevel, dispatch};

    use super::*;

    const WRAPS: [Wrap; 3] = [Wrap::Repeat, Wrap::MirroredRepeat, Wrap::ClampToEdge];

    fn image(size: [u32; 2], space: ColorSpace, filter: Filter, wrap: [Wrap; 2]) -> Texture {
        let texels = (0..size[0] * size[1]).map(|texel| (texel + 1).wrapping_mul(0x9e37_79b1).to_le_bytes());
        Texture::new("", size, texels.collect(), space, filter, wrap)
    }

    fn read(image: &Texture, u: &Each<f32>, v: &Each<f32>, footprint: &Each<f32>, lanes: u16) -> [Each<f32>; 4] {
        dispatch!(SimdLevel::default(), simd => {
            let coords = [f32x16::from_slice(simd, u), f32x16::from_slice(simd, v)];
            colors(simd, image, coords, f32x16::from_slice(simd, footprint), lanes)
        })
    }

    #[test]
    fn sixteen_are_read_as_one_is() {
        let coords: Each<f32> =
            [0.0, 0.31, 0.5, 0.77, 1.0, -0.2, -1.0, -7.77, 3.4, 1234.5, 0.999_999, -1e-9, 2e5, -9e6, 1e30, 1e-20];
        let footprints = [0.0, 1.0, 1.3, 2.0, 2.9, 5.0, 17.0, f32::INFINITY, f32::NAN];
        for (size, space) in [([1, 1], ColorSpace::Srgb), ([7, 3], ColorSpace::Linear), ([33, 64], ColorSpace::Srgb)] {
            for (wrap_u, wrap_v) in WRAPS.into_iter().flat_map(|u| WRAPS.map(|v| (u, v))) {
                for filter in [Filter::Nearest, Filter::Linear] {
                    let image = image(size, space, filter, [wrap_u, wrap_v]);
                    for turn in 0..LANES {
                        let mut v = coords;
                        v.rotate_left(turn);
                        let footprint = std::array::from_fn(|lane| footprints[(lane + turn) % footprints.len()]);
                        let colors = read(&image, &coords, &v, &footprint, u16::MAX);
                        for lane in 0..LANES {
                            let (u, v, footprint) = (coords[lane], v[lane], footprint[lane]);
                            let alone = image.sample(Vec2::new(u, v), footprint);
                            let color = Vec4::from_array(colors.map(|channel| channel[lane]));
                            let of = format!("{size:?} {wrap_u:?} {wrap_v:?} {filter:?} at {u}, {v} over {footprint}");
                            assert!(color.abs_diff_eq(alone, 1e-5), "{of}: {color}, alone {alone}");
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn what_is_no_finite_number_is_some_color_and_spoils_no_other() {
        let image = image([5, 4], ColorSpace::Srgb, Filter::Linear, [Wrap::Repeat; 2]);
        let mut u = [0.3; LANES];
        (u[1], u[2], u[3]) = (f32::NAN, f32::INFINITY, f32::NEG_INFINITY);
        let colors = read(&image, &u, &[0.6; LANES], &[1.0; LANES], u16::MAX);
        let alone = image.sample(Vec2::new(0.3, 0.6), 1.0).to_array();
        for (channel, alone) in colors.iter().zip(alone) {
            assert!(channel[1..4].iter().all(|color| color.is_nan()));
            assert!((channel[0] - alone).abs() < 1e-6 && channel[4..].iter().all(|color| *color == channel[0]));
        }
    }

    #[test]
    fn lanes_that_arent_asked_for_read_nothing() {
        let image = image([5, 4], ColorSpace::Linear, Filter::Nearest, [Wrap::Repeat; 2]);
        let colors = read(&image, &[0.3; LANES], &[0.6; LANES], &[1.0; LANES], 0b101);
        for (lane, alpha) in colors[3].iter().enumerate() {
            assert_eq!(*alpha > 0.0, lane == 0 || lane == 2, "{lane}");
        }
    }
}
