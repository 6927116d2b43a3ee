// Stage `bounce`: shades hits without shadows, and writes shadow questions and mirrored rays.

import package::dispatch::{Invocation, flat_index, groups_of};
import package::exact::corners::{corner_bits};
import package::exact::double::{F64, F64_ZERO, f64_from_f32_bits, f64_to_f32_bits};
import package::exact::predicate::{exact_scale_to_one};
import package::exact::shadow::{ExactPoint, exact_point, exact_shadow};
import package::exact::vector::{F64Vector, f64_vector_scale};
import package::rays::read::{read_ray};
import package::rays::records::{
    HIT_WORDS, NO_TRIANGLE, RAY_DIRECTION, RAY_T_MAX, RAY_T_MIN, RECORDS_COUNT, RECORDS_GROUPS, RECORDS_PACKETS,
    RECORD_LANES, RECORD_OWN, RECORD_TAG, SHADOW_COLOR, SHADOW_ERROR, SHADOW_IS_DIRECTIONAL, SHADOW_LIGHT, record_start,
};
import package::mask::flags::{TRIANGLE_MATERIAL};

struct KdBounce {
    // The light's position, or its direction of travel, in bits of f32.
    light: vec3<u32>,
    is_directional: u32,
    // Radiance that a white surface facing the light reflects.
    light_color: vec3<f32>,
    // Whether mirrors send rays on.
    goes_on: u32,
    // Ambient radiance.
    ambient: vec3<f32>,
    // Rays of a packet.
    packet: u32,
    // Radiance of rays that hit nothing.
    sky: vec3<f32>,
    pixels: u32,
}

@group(0) @binding(0) var<uniform> kd_bounce: KdBounce;
@group(0) @binding(1) var<storage, read> records: array<u32>;
@group(0) @binding(2) var<storage, read> hits: array<u32>;
@group(0) @binding(3) var<storage, read> triangles: array<vec4<u32>>;
@group(0) @binding(4) var<storage, read> positions: array<u32>;
// A colour, and the mirrored fraction of light.
@group(0) @binding(5) var<storage, read> materials: array<vec4<f32>>;
@group(0) @binding(6) var<storage, read_write> next_records: array<atomic<u32>>;
@group(0) @binding(7) var<storage, read_write> shadow_records: array<atomic<u32>>;
@group(0) @binding(8) var<storage, read_write> film: array<vec4<f32>>;

const BOUNCE_INFINITE = F64(0u, 0x7ff00000u);

// Prefix sums of the workgroup's mirrored rays and shadow questions; both counts in a word.
var<workgroup> bounce_counts: array<u32, RECORD_LANES>;
var<workgroup> bounce_starts: vec2<u32>;

fn rounded_vector(a: F64Vector) -> vec3<f32> {
    return bitcast<vec3<f32>>(vec3(f64_to_f32_bits(a.x), f64_to_f32_bits(a.y), f64_to_f32_bits(a.z)));
}

// A vector scaled to unit length, from any length.
fn unit_vector(a: vec3<f32>) -> vec3<f32> {
    let largest = max(max(abs(a.x), abs(a.y)), abs(a.z));
    if !(largest > 1.0e-37) {
        return vec3(0.0);
    }
    return normalize(a / largest);
}

fn normal_of(id: u32) -> vec3<f32> {
    let bits = corner_bits(id);
    let a = bitcast<vec3<f32>>(bits.a);
    return unit_vector(cross(unit_vector(bitcast<vec3<f32>>(bits.b) - a), unit_vector(bitcast<vec3<f32>>(bits.c) - a)));
}

fn put_next(word: u32, number: F64) {
    atomicStore(&next_records[word], number.x);
    atomicStore(&next_records[word + 1u], number.y);
}

fn put_shadow(word: u32, number: F64) {
    atomicStore(&shadow_records[word], number.x);
    atomicStore(&shadow_records[word + 1u], number.y);
}

// Indices of this invocation's ray and question: those of a workgroup stay together and in order.
fn bounce_numbers(lane: u32, has_ray: bool, has_question: bool) -> vec2<u32> {
    let own = u32(has_ray) | (u32(has_question) << 16u);
    bounce_counts[lane] = own;
    workgroupBarrier();
    for (var step = 1u; step < RECORD_LANES; step *= 2u) {
        var sum = bounce_counts[lane];
        if lane >= step {
            sum += bounce_counts[lane - step];
        }
        workgroupBarrier();
        bounce_counts[lane] = sum;
        workgroupBarrier();
    }
    if lane == RECORD_LANES - 1u {
        let total = bounce_counts[lane];
        bounce_starts.x = atomicAdd(&next_records[RECORDS_COUNT], total & 0xffffu);
        bounce_starts.y = atomicAdd(&shadow_records[RECORDS_COUNT], total >> 16u);
    }
    workgroupBarrier();
    let before = bounce_counts[lane] - own;
    return bounce_starts + vec2(before & 0xffffu, before >> 16u);
}

@compute @workgroup_size(64)
fn bounce(at: Invocation) {
    let number = flat_index(at, RECORD_LANES);
    let word = record_start(number);
    var id = NO_TRIANGLE;
    var pixel = NO_TRIANGLE;
    if number < records[RECORDS_COUNT] {
        id = hits[number * HIT_WORDS];
        pixel = records[word + RECORD_TAG];
    }
    var point: ExactPoint;
    var mirrored = vec3(0.0);
    var lit = vec3(0.0);
    if pixel != NO_TRIANGLE {
        let weight = film[kd_bounce.pixels + pixel].rgb;
        var color = kd_bounce.sky;
        if id != NO_TRIANGLE {
            let ray = read_ray(word);
            point = exact_point(ray, F64(hits[number * HIT_WORDS + 2u], hits[number * HIT_WORDS + 3u]));
            let along = f64_vector_scale(ray.direction, exact_scale_to_one(ray.direction));
            let towards = unit_vector(rounded_vector(along));
            let outwards = normal_of(id);
            // The normal on the side of the ray's origin.
            let normal = select(outwards, -outwards, dot(outwards, towards) > 0.0);
            let material = materials[triangles[id].w & TRIANGLE_MATERIAL];
            let shadow = exact_shadow(kd_bounce.is_directional != 0u, kd_bounce.light, point);
            // From the point to the light: a point light's shadow ray starts at the light.
            let from_light = unit_vector(rounded_vector(shadow.ray.direction));
            let to_light = select(-from_light, from_light, shadow.from_point);
            let diffuse = weight * material.rgb * (1.0 - material.a);
            lit = diffuse * kd_bounce.light_color * max(dot(normal, to_light), 0.0);
            color = (1.0 - material.a) * material.rgb * kd_bounce.ambient;
            if kd_bounce.goes_on != 0u && material.a > 0.0 {
                mirrored = towards - 2.0 * dot(towards, normal) * normal;
                film[kd_bounce.pixels + pixel] = vec4(weight * material.rgb * material.a, 1.0);
            }
        }
        film[pixel] += vec4(weight * color, 0.0);
    }
    let has_ray = any(mirrored != vec3(0.0));
    let has_question = any(lit > vec3(0.0));
    let numbers = bounce_numbers(at.lane, has_ray, has_question);
    if has_ray {
        let to = record_start(numbers.x);
        put_next(to, point.position.x);
        put_next(to + 2u, point.position.y);
        put_next(to + 4u, point.position.z);
        for (var axis = 0u; axis < 3u; axis++) {
            put_next(to + RAY_DIRECTION + 2u * axis, f64_from_f32_bits(bitcast<u32>(mirrored[axis])));
        }
        put_next(to + RAY_T_MIN, F64_ZERO);
        put_next(to + RAY_T_MAX, BOUNCE_INFINITE);
        atomicStore(&next_records[to + RECORD_OWN], id);
        atomicStore(&next_records[to + RECORD_TAG], pixel);
    }
    if has_question {
        let to = record_start(numbers.y);
        put_shadow(to, point.position.x);
        put_shadow(to + 2u, point.position.y);
        put_shadow(to + 4u, point.position.z);
        put_shadow(to + SHADOW_ERROR, point.error);
        for (var axis = 0u; axis < 3u; axis++) {
            atomicStore(&shadow_records[to + SHADOW_LIGHT + axis], kd_bounce.light[axis]);
            atomicStore(&shadow_records[to + SHADOW_COLOR + axis], bitcast<u32>(lit[axis]));
        }
        atomicStore(&shadow_records[to + SHADOW_IS_DIRECTIONAL], kd_bounce.is_directional);
        atomicStore(&shadow_records[to + RECORD_OWN], id);
        atomicStore(&shadow_records[to + RECORD_TAG], pixel);
    }
}

// Writes the workgroups for the new rays and for the questions.
@compute @workgroup_size(1)
fn size_bounced() {
    let rays = atomicLoad(&next_records[RECORDS_COUNT]);
    let questions = atomicLoad(&shadow_records[RECORDS_COUNT]);
    let of_rays = groups_of((rays + RECORD_LANES - 1u) / RECORD_LANES);
    let of_questions = groups_of((questions + RECORD_LANES - 1u) / RECORD_LANES);
    let packets_of_rays = groups_of((rays + kd_bounce.packet - 1u) / kd_bounce.packet);
    let packets_of_questions = groups_of((questions + kd_bounce.packet - 1u) / kd_bounce.packet);
    for (var axis = 0u; axis < 3u; axis++) {
        atomicStore(&next_records[RECORDS_GROUPS + axis], of_rays[axis]);
        atomicStore(&next_records[RECORDS_PACKETS + axis], packets_of_rays[axis]);
        atomicStore(&shadow_records[RECORDS_GROUPS + axis], of_questions[axis]);
        atomicStore(&shadow_records[RECORDS_PACKETS + axis], packets_of_questions[axis]);
    }
}
