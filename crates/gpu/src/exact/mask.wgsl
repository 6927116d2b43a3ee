// Opacity at a point of a triangle: bit for bit the number that the Rust scene crate's `Frame::is_solid` and
// `Frame::casts_shadow` compare with the cutoff. Numbers are the bits of f32.
//
// The caller keeps the texels in a storage buffer: `mask_texels` gives the indices of four, and `mask_texture_opacity`
// mixes their alpha.

import package::exact::double::{f64_from_u32, f64_to_f32_bits};
import package::exact::single::{
    F32_HALF, F32_ONE, F32_SIGN, F32_ZERO, f32_add, f32_floor, f32_from_byte, f32_is_nan, f32_multiply, f32_subtract,
};
import package::wrap::{WRAP_CLAMP_TO_EDGE, WRAP_MIRRORED_REPEAT};

// How a material reads the opacity in a texture.
struct MaskTexture {
    // Matrix from the mesh's texture coordinates to the image's: the two axes, then the translation.
    x_axis: vec2<u32>,
    y_axis: vec2<u32>,
    translation: vec2<u32>,
    // In texels, each at most 65,536.
    size: vec2<u32>,
    // Wrapping beyond the edges: a `WRAP` constant for each axis.
    wrap: vec2<u32>,
    // 1 to mix four texels, 0 to read the nearest.
    is_linear: u32,
    // Index of the full-size image's first texel among the caller's texels.
    first_texel: u32,
}

// The texels to mix: the upper left and right ones, then the lower ones. `part` is the point's position between them, 0
// to 1: from left to right, and from upper to lower.
struct MaskTexels {
    indices: vec4<u32>,
    part: vec2<u32>,
}

// A vertex attribute's value at the weights of the second and third vertex.
fn mask_interpolated(of_vertices: vec3<u32>, barycentric: vec2<u32>) -> u32 {
    let first = f32_subtract(f32_subtract(F32_ONE, barycentric.x), barycentric.y);
    var weights = vec3(first, barycentric);
    var values = of_vertices;
    var sum: u32;
    for (var vertex = 0u; vertex < 3u; vertex++) {
        let product = f32_multiply(values.x, weights.x);
        sum = select(f32_add(sum, product), product, vertex == 0u);
        weights = weights.yzx;
        values = values.yzx;
    }
    return sum;
}

// The texels to read for the mesh's texture coordinates.
fn mask_texels(texture: MaskTexture, coords: vec2<u32>) -> MaskTexels {
    var x: MaskSpan;
    var y: MaskSpan;
    for (var axis = 0u; axis < 2u; axis++) {
        let image_from_mesh = select(
            vec3(texture.x_axis.x, texture.y_axis.x, texture.translation.x),
            vec3(texture.x_axis.y, texture.y_axis.y, texture.translation.y),
            axis == 1u,
        );
        let side = select(texture.size.x, texture.size.y, axis == 1u);
        let wrap = select(texture.wrap.x, texture.wrap.y, axis == 1u);
        x = y;
        y = mask_texels_along(image_from_mesh, coords, side, wrap, texture.is_linear != 0u);
    }
    let upper = texture.first_texel + y.first * texture.size.x;
    let lower = texture.first_texel + y.second * texture.size.x;
    let indices = vec4(upper + x.first, upper + x.second, lower + x.first, lower + x.second);
    return MaskTexels(indices, vec2(x.part, y.part));
}

// The two texels to mix along an axis.
struct MaskSpan {
    first: u32,
    second: u32,
    part: u32,
}

fn mask_texels_along(image_from_mesh: vec3<u32>, coords: vec2<u32>, side: u32, wrap: u32, is_linear: bool) -> MaskSpan {
    let turned = f32_add(f32_multiply(image_from_mesh.x, coords.x), f32_multiply(image_from_mesh.y, coords.y));
    let position = f32_multiply(f32_add(turned, image_from_mesh.z), f64_to_f32_bits(f64_from_u32(side)));
    if !is_linear {
        // Mixing a texel with itself gives that texel.
        let nearest = mask_wrapped(f32_floor(position), side, wrap);
        return MaskSpan(nearest, nearest, F32_ZERO);
    }
    let from_middle = f32_subtract(position, F32_HALF);
    let corner = f32_floor(from_middle);
    return MaskSpan(
        mask_wrapped(corner, side, wrap),
        mask_wrapped(f32_add(corner, F32_ONE), side, wrap),
        f32_subtract(from_middle, corner),
    );
}

// The texel for position `at`, a whole number, on a side of `side` texels; the first texel for NaN.
fn mask_wrapped(at: u32, side: u32, wrap: u32) -> u32 {
    let is_negative = at >= F32_SIGN;
    let field = (at >> 23u) & 0xffu;
    let significand = (at & 0x7fffffu) | 0x800000u;
    if wrap == WRAP_CLAMP_TO_EDGE {
        let whole = select(significand >> (min(150u - field, 31u) & 31u), 0xffffffffu, field >= 150u);
        return select(min(whole, side - 1u), 0u, is_negative || f32_is_nan(at));
    }
    if field == 0xffu {
        return 0u;
    }
    // A whole number of 24 bits, or one with zeros behind those.
    let period = select(side, 2u * side, wrap == WRAP_MIRRORED_REPEAT);
    var rest = select(significand >> (min(150u - field, 31u) & 31u), significand, field >= 150u) % period;
    for (var doubled = 150u; doubled < field; doubled++) {
        rest = (2u * rest) % period;
    }
    rest = select(rest, period - rest, is_negative && rest != 0u);
    return select(rest, period - 1u - rest, rest >= side);
}

// The opacity of a texture from the alpha bytes of its four texels.
fn mask_texture_opacity(bytes: vec4<u32>, part: vec2<u32>) -> u32 {
    var start = f32_from_byte(bytes.x);
    var end = f32_from_byte(bytes.y);
    var upper: u32;
    var mixed: u32;
    // Mixes the upper two, the lower two, and then the two results.
    for (var step = 0u; step < 3u; step++) {
        upper = mixed;
        mixed = mask_mix(start, end, select(part.x, part.y, step == 2u));
        start = select(upper, f32_from_byte(bytes.z), step == 0u);
        end = select(mixed, f32_from_byte(bytes.w), step == 0u);
    }
    return mixed;
}

fn mask_mix(start: u32, end: u32, part: u32) -> u32 {
    return f32_add(f32_multiply(start, f32_subtract(F32_ONE, part)), f32_multiply(end, part));
}

// Opacity of a point: the product of the material's, the vertices' (one without vertex colours) and the texture's (one
// without a texture). A masked triangle is there if this is `f32_at_least` the cutoff; a blended one casts a shadow if
// it is at least a half.
fn mask_opacity(material: u32, vertices: u32, texture: u32) -> u32 {
    return f32_multiply(f32_multiply(material, vertices), texture);
}
