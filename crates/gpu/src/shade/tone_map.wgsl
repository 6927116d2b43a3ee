// Maps linear radiance to linear display light: crates/umbrage/src/tone_map.rs.

// The Khronos PBR Neutral tone mapper.
const NEUTRAL_F0: f32 = 0.04;
const NEUTRAL_START_COMPRESSION: f32 = 0.8 - NEUTRAL_F0;
const NEUTRAL_DESATURATION: f32 = 0.15;

fn tone_map_neutral(radiance: vec3<f32>) -> vec3<f32> {
    let least = min(radiance.x, min(radiance.y, radiance.z));
    let toe = select(NEUTRAL_F0, least - least * least / (4.0 * NEUTRAL_F0), least < 2.0 * NEUTRAL_F0);
    let color = radiance - toe;
    let peak = max(color.x, max(color.y, color.z));
    if peak < NEUTRAL_START_COMPRESSION {
        return color;
    }
    let range = 1.0 - NEUTRAL_START_COMPRESSION;
    let new_peak = 1.0 - range * range / (peak + range - NEUTRAL_START_COMPRESSION);
    let white = 1.0 - 1.0 / (NEUTRAL_DESATURATION * (peak - new_peak) + 1.0);
    return mix(color * (new_peak / peak), vec3<f32>(new_peak), white);
}
