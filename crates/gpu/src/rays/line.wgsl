// Stage `line`: converts rays to the f32 lines of the traversals. The derivation is in `mod.rs`.

import package::dispatch::{Invocation, flat_index};
import package::exact::double::{
    F64, F64_ZERO, f64_abs, f64_add, f64_divide, f64_is_below_zero, f64_is_finite, f64_is_zero, f64_larger_magnitude, f64_less,
    f64_multiply, f64_subtract, f64_to_f32_bits,
};
import package::exact::predicate::{ExactRay, exact_scale_to_one};
import package::exact::vector::{
    F64Vector, f64_largest_magnitude, f64_vector_add, f64_vector_from_f32_bits, f64_vector_scale, f64_vector_turned,
};
import package::rays::read::{read_number, read_point, read_ray, read_shadow};
import package::rays::records::{
    NO_TRIANGLE, RAY_ERROR, RAY_T_MAX, RAY_T_MIN, RECORDS_COUNT, RECORD_LANES, RECORD_OWN, RECORD_TAG, record_start,
};
import package::rays::space::{RaySpace};

@group(0) @binding(0) var<uniform> ray_space: RaySpace;
@group(0) @binding(1) var<storage, read> records: array<u32>;
@group(0) @binding(2) var<storage, read_write> lines: array<vec4<u32>>;

// Whether records are shadow questions rather than rays.
override RAY_IS_SHADOW: bool = false;

const LINE_ONE = F64(0u, 0x3ff00000u);
// 2⁻⁴⁸ and 2⁻⁴⁹.
const LINE_DOUBT = F64(0u, 0x3cf00000u);
const LINE_BLUR = F64(0u, 0x3ce00000u);
// 2⁻¹⁰⁰⁰: above anything that underflows.
const LINE_SMALLEST = F64(0u, 0x01700000u);
// 2⁻⁸⁶: above anything that underflows in f32, and twice the movement across planes that a ray counts as parallel to.
const LINE_SMALLEST_BLUR = F64(0u, 0x3a900000u);
// 8: the interval is never longer inside the bounds.
const LINE_FAR = F64(0u, 0x40200000u);
const LINE_FAR_BACK = F64(0u, 0xc0200000u);
// 64.
const LINE_HEIGHTS = F64(0u, 0x40500000u);
// 2⁻⁹⁰: directions below this, beside a largest component of one to two, count as along the plane.
const LINE_PARALLEL = 8.0779357e-28;
// Blur of lines that test everything.
const LINE_EVERYTHING = 1.0995116e12;
const LINE_MISS = -1.0e30;

struct Slabs {
    enter: F64,
    leave: F64,
    // One over each component of the direction.
    inverse: F64Vector,
    is_missed: bool,
    is_lost: bool,
}

fn f64_at_most(a: F64, b: F64) -> F64 {
    return select(a, b, f64_less(b, a));
}

fn f64_at_least(a: F64, b: F64) -> F64 {
    return select(a, b, f64_less(a, b));
}

fn line_f32(a: F64) -> f32 {
    return bitcast<f32>(f64_to_f32_bits(a));
}

// The interval of a line inside the bounds, within `enter` to `leave`.
fn line_slabs(start: F64Vector, along: F64Vector, enter: F64, leave: F64, scale: F64) -> Slabs {
    var origin = start;
    var direction = along;
    var low = f64_vector_scale(f64_vector_from_f32_bits(ray_space.min), scale);
    var high = f64_vector_scale(f64_vector_from_f32_bits(ray_space.max), scale);
    var slabs = Slabs(enter, leave, direction, ray_space.is_empty != 0u, ray_space.is_lost != 0u);
    for (var axis = 0u; axis < 3u; axis++) {
        var inverse = F64_ZERO;
        if f64_is_zero(direction.x) {
            slabs.is_missed |= f64_less(origin.x, low.x) || f64_less(high.x, origin.x);
        } else {
            inverse = f64_divide(LINE_ONE, direction.x);
            let to_low = f64_multiply(f64_subtract(low.x, origin.x), inverse);
            let to_high = f64_multiply(f64_subtract(high.x, origin.x), inverse);
            slabs.is_lost |= !f64_is_finite(inverse) || !f64_is_finite(to_low) || !f64_is_finite(to_high);
            let is_backward = f64_is_below_zero(direction.x);
            slabs.enter = f64_at_least(slabs.enter, select(to_low, to_high, is_backward));
            slabs.leave = f64_at_most(slabs.leave, select(to_high, to_low, is_backward));
        }
        slabs.inverse = F64Vector(slabs.inverse.y, slabs.inverse.z, inverse);
        origin = f64_vector_turned(origin);
        direction = f64_vector_turned(direction);
        low = f64_vector_turned(low);
        high = f64_vector_turned(high);
    }
    return slabs;
}

// Writes a line that meets nothing.
fn write_missed(number: u32, packed_own: u32) {
    let to = 1u + 4u * number;
    lines[to] = vec4(0u);
    lines[to + 1u] = vec4(0u);
    lines[to + 2u] = vec4(0u, 0u, bitcast<u32>(LINE_MISS), 0u);
    lines[to + 3u] = vec4(0u, 0u, packed_own | 2u, 0u);
}

// Writes the line of `ray` in its interval. It ignores the triangle `own`, and of one-sided triangles the front if it
// `meets_backs`, else the back. `error` bounds the rounding error, on any axis, of the point that the ray starts from
// or ends at.
fn write_line(number: u32, ray: ExactRay, t_min: F64, t_max: F64, error: F64, own: u32, meets_backs: bool) {
    let to = 1u + 4u * number;
    let packed_own = own << 2u;
    let scale = F64(0u, ray_space.scale_high);
    let turn = exact_scale_to_one(ray.direction);
    let direction = f64_vector_scale(ray.direction, turn);
    let origin = f64_vector_scale(ray.origin, scale);
    // t in lengths of the scaled direction, in scaled space; a power of two has its inverse's exponent.
    let shortened = F64(0u, 0x7fe00000u - turn.y);
    let first_t = f64_multiply(f64_multiply(t_min, scale), shortened);
    let last_t = f64_multiply(f64_multiply(t_max, scale), shortened);

    let slabs = line_slabs(origin, direction, first_t, last_t, scale);
    let magnitude = f64_larger_magnitude(slabs.enter, slabs.leave);
    let doubt = f64_add(f64_multiply(magnitude, LINE_DOUBT), LINE_SMALLEST);
    let enter = f64_subtract(slabs.enter, doubt);
    let leave = f64_add(slabs.leave, doubt);

    let skipped = f64_abs(enter);
    let reach = f64_add(f64_largest_magnitude(origin), f64_add(skipped, skipped));
    let blur = f64_add(f64_multiply(reach, LINE_BLUR), LINE_SMALLEST_BLUR);
    let is_lost = slabs.is_lost || !f64_is_finite(enter) || !f64_is_finite(leave) || !f64_is_finite(blur)
        || f64_less(F64(0u, 0x3fa00000u), blur);
    if slabs.is_missed || (!is_lost && f64_less(leave, enter)) {
        write_missed(number, packed_own);
        return;
    }
    if is_lost {
        let far = bitcast<u32>(LINE_EVERYTHING);
        lines[to] = vec4(0u, 0u, 0u, far);
        lines[to + 1u] = vec4(0u, 0u, 0u, far);
        lines[to + 2u] = vec4(0u, 0u, far, far);
        lines[to + 3u] = vec4(0u, 0u, packed_own | 2u, u32(meets_backs));
        return;
    }

    let start = f64_vector_add(origin, f64_vector_scale(direction, enter));
    let length = f64_subtract(leave, enter);
    let first = f64_at_least(f64_subtract(first_t, enter), LINE_FAR_BACK);
    let last = f64_at_most(f64_subtract(last_t, enter), LINE_FAR);
    let along = vec3(line_f32(direction.x), line_f32(direction.y), line_f32(direction.z));
    let is_parallel = abs(along) < vec3(LINE_PARALLEL);
    var inverse = vec3(0.0);
    if !is_parallel.x {
        inverse.x = line_f32(slabs.inverse.x);
    }
    if !is_parallel.y {
        inverse.y = line_f32(slabs.inverse.y);
    }
    if !is_parallel.z {
        inverse.z = line_f32(slabs.inverse.z);
    }
    let size = abs(along);
    let axis = select(select(2u, 1u, size.y >= size.z), 0u, size.x >= max(size.y, size.z));
    // The other two components over the largest, in turning order.
    var slope_x = f64_multiply(direction.x, slabs.inverse.z);
    var slope_y = f64_multiply(direction.y, slabs.inverse.z);
    if axis == 0u {
        slope_x = f64_multiply(direction.y, slabs.inverse.x);
        slope_y = f64_multiply(direction.z, slabs.inverse.x);
    } else if axis == 1u {
        slope_x = f64_multiply(direction.z, slabs.inverse.y);
        slope_y = f64_multiply(direction.x, slabs.inverse.y);
    }
    var heights = F64_ZERO;
    if RAY_IS_SHADOW || !f64_is_zero(error) {
        heights = f64_add(blur, f64_multiply(error, scale));
        if f64_is_finite(last_t) {
            // A ray to a point misses it by the rounding of its direction.
            heights = f64_add(heights, f64_multiply(last_t, LINE_BLUR));
        }
        heights = f64_multiply(heights, LINE_HEIGHTS);
    }
    let widest = max(abs(inverse.x), max(abs(inverse.y), abs(inverse.z)));
    let most_doubt = select((1.0e-6 + 4.0 * line_f32(blur)) * widest, LINE_EVERYTHING, any(is_parallel));

    lines[to] = vec4(
        f64_to_f32_bits(start.x), f64_to_f32_bits(start.y), f64_to_f32_bits(start.z), f64_to_f32_bits(blur),
    );
    lines[to + 1u] = vec4(bitcast<vec3<u32>>(inverse), f64_to_f32_bits(heights));
    lines[to + 2u] = vec4(
        f64_to_f32_bits(slope_x), f64_to_f32_bits(slope_y), f64_to_f32_bits(length), bitcast<u32>(most_doubt),
    );
    lines[to + 3u] = vec4(f64_to_f32_bits(first), f64_to_f32_bits(last), packed_own | axis, u32(meets_backs));
}

@compute @workgroup_size(64)
fn line(at: Invocation) {
    let number = flat_index(at, RECORD_LANES);
    if number == 0u {
        lines[0] = vec4(records[RECORDS_COUNT], 0u, 0u, 0u);
    }
    if number >= records[RECORDS_COUNT] {
        return;
    }
    let word = record_start(number);
    let own = records[word + RECORD_OWN];
    if RAY_IS_SHADOW {
        let point = read_point(word);
        let shadow = read_shadow(word, point);
        // No triangle shadows a point at the light.
        let is_at_light = f64_is_zero(f64_largest_magnitude(shadow.ray.direction));
        if is_at_light || records[word + RECORD_TAG] == NO_TRIANGLE {
            write_missed(number, own << 2u);
            return;
        }
        let t_max = select(LINE_ONE, F64(0u, 0x7ff00000u), shadow.from_point);
        write_line(number, shadow.ray, F64_ZERO, t_max, point.error, own, shadow.from_point);
    } else {
        let t_min = read_number(word + RAY_T_MIN);
        let error = read_number(word + RAY_ERROR);
        write_line(number, read_ray(word), t_min, read_number(word + RAY_T_MAX), error, own, false);
    }
}
