// A film thin enough for interference: crates/umbrage/src/shade/film.rs, which has the sources.

const FILM_TURN: f32 = 6.28318530717959;

// Gaussians of the eye's responses X, Y and Z to path lengths, in Fourier space: heights, positions in 1/m, variances
// in 1/m².
const FILM_HEIGHT: vec3<f32> = vec3<f32>(5.4856e-13, 4.4201e-13, 5.2481e-13);
const FILM_POSITION: vec3<f32> = vec3<f32>(1.6810e6, 1.7953e6, 2.2084e6);
const FILM_VARIANCE: vec3<f32> = vec3<f32>(4.3278e9, 9.3046e9, 6.6121e9);
// The second Gaussian of X, in the blue.
const FILM_BLUE_HEIGHT: f32 = 9.7470e-14;
const FILM_BLUE_POSITION: f32 = 2.2399e6;
const FILM_BLUE_VARIANCE: f32 = 4.5282e9;
// Scale by which light of all wavelengths has Y = 1.
const FILM_WHOLE: f32 = 1.0685e-7;

// Reflectance of a film with this index and thickness in nanometres, together with a surface of reflectance `f0` at
// normal incidence.
fn film_reflected(ior: f32, nanometers: f32, f0: vec3<f32>, n_v: f32) -> vec3<f32> {
    let cosine = min(n_v, 1.0);
    let cosine_inside = sqrt(max(1.0 - (1.0 - cosine * cosine) / (ior * ior), 0.0));
    let first = film_schlick(vec3<f32>(film_ahead(vec3<f32>(ior), 1.0)), cosine).x;
    let root = sqrt(clamp(f0 + 1e-4, vec3<f32>(0.0), vec3<f32>(0.9999)));
    let below = (1.0 + root) / (1.0 - root);
    let second = film_schlick(film_ahead(below, ior), cosine_inside);
    let both = clamp(first * second, vec3<f32>(1e-5), vec3<f32>(0.9999));
    let there_and_back = sqrt(both);
    let transmitted = 1.0 - first;
    let returned = transmitted * transmitted * second / (1.0 - both);
    let shift = select(vec3<f32>(-1.0), vec3<f32>(1.0), below < vec3<f32>(ior));
    let phase = FILM_TURN * 1e-9 * (2.0 * ior * nanometers * cosine_inside);
    let once = (returned - transmitted) * there_and_back;
    var sum = first + returned;
    sum += once * 2.0 * film_rec709_from_xyz(film_answer(phase) * shift);
    sum += once * there_and_back * 2.0 * film_rec709_from_xyz(film_answer(2.0 * phase));
    return clamp(sum, vec3<f32>(0.0), vec3<f32>(1.0));
}

// Reflectance at normal incidence between two media of these indices.
fn film_ahead(behind: vec3<f32>, before: f32) -> vec3<f32> {
    let ratio = (behind - before) / (behind + before);
    return ratio * ratio;
}

fn film_schlick(f0: vec3<f32>, cosine: f32) -> vec3<f32> {
    let missing = 1.0 - clamp(cosine, 0.0, 1.0);
    let squared = missing * missing;
    return f0 + (1.0 - f0) * (squared * squared * missing);
}

fn film_answer(phase: f32) -> vec3<f32> {
    let squared = phase * phase;
    let waves = FILM_HEIGHT * sqrt(FILM_TURN * FILM_VARIANCE) / FILM_WHOLE
        * film_cosine(FILM_POSITION * phase) * exp(-(FILM_VARIANCE * squared));
    let blue = FILM_BLUE_HEIGHT * sqrt(FILM_TURN * FILM_BLUE_VARIANCE) / FILM_WHOLE
        * film_cosine(vec3<f32>(FILM_BLUE_POSITION * phase)).x * exp(-(FILM_BLUE_VARIANCE * squared));
    return waves + vec3<f32>(blue, 0.0, 0.0);
}

// Reduced to half a turn, where WGSL bounds the error of cosines.
fn film_cosine(radians: vec3<f32>) -> vec3<f32> {
    let turns = radians / FILM_TURN;
    return cos((turns - floor(turns + 0.5)) * FILM_TURN);
}

fn film_rec709_from_xyz(xyz: vec3<f32>) -> vec3<f32> {
    return vec3<f32>(
        dot(xyz, vec3<f32>(3.2404542, -1.5371385, -0.4985314)),
        dot(xyz, vec3<f32>(-0.9692660, 1.8760108, 0.0415560)),
        dot(xyz, vec3<f32>(0.0556434, -0.2040259, 1.0572252)),
    );
}
