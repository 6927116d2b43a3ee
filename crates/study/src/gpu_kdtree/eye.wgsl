// Stage `eye`: makes the camera's rays, in blocks of 8×8 pixels so that packets stay together, and an empty film.

import package::dispatch::{Invocation, flat_group};
import package::exact::camera::{ExactView, exact_pixel_ray};
import package::exact::double::{F64, F64_ZERO};
import package::rays::records::{
    NO_TRIANGLE, RAY_DIRECTION, RAY_T_MAX, RAY_T_MIN, RECORD_OWN, RECORD_TAG, record_start,
};
import package::rays::write::{put_header, put_number, put_vector};

struct KdEye {
    view: ExactView,
    // Rays of a packet.
    packet: u32,
}

@group(0) @binding(0) var<uniform> kd_eye: KdEye;
@group(0) @binding(1) var<storage, read_write> records: array<u32>;
// The colour of each pixel, then the throughput of its next ray.
@group(0) @binding(2) var<storage, read_write> film: array<vec4<f32>>;

const EYE_HALF = F64(0u, 0x3fe00000u);
const EYE_ONE = F64(0u, 0x3ff00000u);

@compute @workgroup_size(64)
fn eye(at: Invocation) {
    let block = flat_group(at.group);
    let columns = (kd_eye.view.width + 7u) / 8u;
    let blocks = columns * ((kd_eye.view.height + 7u) / 8u);
    if block == 0u && at.lane == 0u {
        put_header(blocks * 64u, kd_eye.packet);
    }
    if block >= blocks {
        return;
    }
    let column = block % columns * 8u + at.lane % 8u;
    let row = block / columns * 8u + at.lane / 8u;
    let is_inside = column < kd_eye.view.width && row < kd_eye.view.height;
    let ray = exact_pixel_ray(kd_eye.view, column, row, EYE_HALF, EYE_HALF);
    let word = record_start(block * 64u + at.lane);
    put_vector(word, ray.origin);
    put_vector(word + RAY_DIRECTION, ray.direction);
    // Outside of the image the interval is empty.
    put_number(word + RAY_T_MIN, select(EYE_ONE, F64_ZERO, is_inside));
    put_number(word + RAY_T_MAX, select(F64_ZERO, F64(0u, 0x7ff00000u), is_inside));
    records[word + RECORD_OWN] = NO_TRIANGLE;
    let pixel = row * kd_eye.view.width + column;
    records[word + RECORD_TAG] = select(NO_TRIANGLE, pixel, is_inside);
    if is_inside {
        film[pixel] = vec4(0.0, 0.0, 0.0, 1.0);
        film[kd_eye.view.width * kd_eye.view.height + pixel] = vec4(1.0);
    }
}
