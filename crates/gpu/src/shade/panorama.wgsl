// A latitude–longitude image around the scene: crates/umbrage/src/panorama.rs.

import package::shade::tables::{shade_scene, shade_texels};

const PANORAMA_PI: f32 = 3.14159265358979;

// Mean radiance around a unit direction, over a patch of about `width` of the sphere's circumference.
fn panorama_radiance(direction: vec3<f32>, width: f32) -> vec3<f32> {
    let last = shade_scene.surroundings.panorama_levels - 1u;
    let lod = min(log2(max(width * f32(shade_scene.surroundings.panorama_size.x), 1.0)), f32(last));
    let finer = u32(lod);
    let part = lod - f32(finer);
    let coords = panorama_coords(direction);
    var radiance = vec3<f32>(0.0);
    for (var step = 0u; step < 2u; step++) {
        let share = select(part, 1.0 - part, step == 0u);
        if share > 0.0 {
            radiance += share * panorama_level_at(finer + step, coords);
        }
    }
    return radiance;
}

fn panorama_level_at(level: u32, coords: vec2<f32>) -> vec3<f32> {
    let size = max(shade_scene.surroundings.panorama_size >> vec2<u32>(level), vec2<u32>(1u));
    let first = shade_texels[shade_scene.surroundings.panorama_word + level];
    let position = coords * vec2<f32>(size) - 0.5;
    let corner = floor(position);
    let part = position - corner;
    var radiance = vec3<f32>(0.0);
    for (var step = 0u; step < 4u; step++) {
        let right = vec2<u32>(step & 1u, step >> 1u);
        let share = select(1.0 - part, part, right == vec2<u32>(1u));
        let at = vec2<i32>(corner) + vec2<i32>(right);
        // Wraps around in x, and clamps at the poles in y.
        let x = u32((at.x + i32(size.x)) % i32(size.x));
        let y = u32(clamp(at.y, 0, i32(size.y) - 1));
        let word = first + 3u * (y * size.x + x);
        let texel = vec3<u32>(shade_texels[word], shade_texels[word + 1u], shade_texels[word + 2u]);
        radiance += share.x * share.y * bitcast<vec3<f32>>(texel);
    }
    return radiance;
}

// Image coordinates of a unit direction: (0, 0) at the upper left, (1, 1) at the lower right.
fn panorama_coords(direction: vec3<f32>) -> vec2<f32> {
    let longitude = panorama_angle(direction.x, -direction.z);
    let height = clamp(direction.y, -1.0, 1.0);
    let from_zenith = panorama_angle(sqrt((1.0 - height) * (1.0 + height)), height);
    return vec2<f32>(0.5 + longitude / (2.0 * PANORAMA_PI), from_zenith / PANORAMA_PI);
}

// The angle of (x, y) from the x axis, −π … π. WGSL's own atan2 may be wrong by 4,096 units in the last place, half a
// texel of a large image; this one is wrong by about two (Moshier, Cephes library, atanf, 1989).
fn panorama_angle(y: f32, x: f32) -> f32 {
    let least = min(abs(x), abs(y));
    let most = max(abs(x), abs(y));
    if most == 0.0 {
        return 0.0;
    }
    var ratio = least / most;
    var angle = 0.0;
    if ratio > 0.41421356 {
        ratio = (least - most) / (least + most);
        angle = 0.25 * PANORAMA_PI;
    }
    let z = ratio * ratio;
    angle += (((8.05374449538e-2 * z - 1.38776856032e-1) * z + 1.99777106478e-1) * z - 3.33329491539e-1) * z * ratio
        + ratio;
    if abs(y) > abs(x) {
        angle = 0.5 * PANORAMA_PI - angle;
    }
    if x < 0.0 {
        angle = PANORAMA_PI - angle;
    }
    return select(angle, -angle, y < 0.0);
}
