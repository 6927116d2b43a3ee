//! The predicate, shadows and the camera's rays.

use glam::{DVec3, Vec3};
use umbrage_gpu::{Gpu, Kernel};
use umbrage_rays::predicate::{HitPoint, ShadowRay, crossing, is_front_along, is_front_from};
use umbrage_rays::{Camera, LightSource, Projection, View};

use super::cases::{Pair, Shadowing};
use super::{Random, common, map};

const CASE_WORDS: usize = 32;
pub(crate) const ANSWER_WORDS: usize = 16;
pub(crate) type Case = [u32; CASE_WORDS];

pub(crate) fn kernel(gpu: &Gpu, entry: &'static str) -> Kernel {
    super::kernel(gpu, include_str!("predicate.wgsl"), entry)
}

#[test]
fn crossings_have_the_bits_of_the_reference() {
    let Some(gpu) = common::gpu() else { return };
    let kernel = kernel(&gpu, "crossings");
    let mut random = Random(2);
    let pairs: Vec<_> = (0..1 << 17).map(|index| Pair::random(&mut random, index)).collect();
    let cases: Vec<_> = pairs.iter().map(pair_case).collect();
    let answers = map(&gpu, &kernel, &cases, ANSWER_WORDS);
    let mut hits = 0;
    for (pair, answer) in pairs.iter().zip(answers.chunks_exact(ANSWER_WORDS)) {
        let expected = crossing(&pair.ray, pair.corners);
        let found = (answer[0] != 0).then(|| (number(answer, 2), [answer[4], answer[5]], answer[1] != 0));
        let expected =
            expected.map(|crossing| (crossing.t.to_bits(), crossing.barycentric.map(f32::to_bits), crossing.front));
        assert_eq!(found, expected, "{pair:?}");
        hits += usize::from(found.is_some());
    }
    assert!(hits > pairs.len() / 3 && hits < pairs.len() * 9 / 10, "{hits} hits of {}", pairs.len());
}

#[test]
fn fronts_are_those_of_the_reference() {
    let Some(gpu) = common::gpu() else { return };
    let kernel = kernel(&gpu, "fronts");
    let mut random = Random(3);
    let pairs: Vec<_> = (0..1 << 16).map(|index| Pair::random(&mut random, index)).collect();
    let cases: Vec<_> = pairs.iter().map(pair_case).collect();
    let answers = map(&gpu, &kernel, &cases, ANSWER_WORDS);
    for (pair, answer) in pairs.iter().zip(answers.chunks_exact(ANSWER_WORDS)) {
        let expected = [is_front_from(pair.ray.origin, pair.corners), is_front_along(pair.ray.direction, pair.corners)];
        assert_eq!([answer[0] != 0, answer[1] != 0], expected, "{pair:?}");
    }
}

#[test]
fn shadows_have_the_bits_of_the_reference() {
    let Some(gpu) = common::gpu() else { return };
    let kernel = kernel(&gpu, "shadows");
    let mut random = Random(4);
    let shadowings: Vec<_> = (0..1 << 17).map(|index| Shadowing::random(&mut random, index)).collect();
    let cases: Vec<_> = shadowings.iter().map(shadow_case).collect();
    let answers = map(&gpu, &kernel, &cases, ANSWER_WORDS);
    let mut blocked = 0;
    for (shadowing, answer) in shadowings.iter().zip(answers.chunks_exact(ANSWER_WORDS)) {
        let point = HitPoint::new(&shadowing.ray, shadowing.t);
        let found_point = [4, 6, 8, 10].map(|word| f64::from_bits(number(answer, word)));
        let expected_point = [point.position.x, point.position.y, point.position.z, point.error];
        let same = |(a, b): (&f64, &f64)| a.to_bits() == b.to_bits() || a.is_nan() && b.is_nan();
        let is_same = found_point.iter().zip(&expected_point).all(same);
        assert!(is_same, "{shadowing:?}: {found_point:?}, not {expected_point:?}");
        let expected = ShadowRay::new(&light(shadowing), point).blocked_by(shadowing.corners);
        let found = (answer[0] != 0).then_some([answer[1], answer[2]]);
        assert_eq!(found, expected.map(|barycentric| barycentric.map(f32::to_bits)), "{shadowing:?}");
        blocked += usize::from(found.is_some());
    }
    assert!(blocked > shadowings.len() / 10, "{blocked} blocked of {}", shadowings.len());
}

#[test]
fn camera_rays_have_the_bits_of_the_reference() {
    let Some(gpu) = common::gpu() else { return };
    let kernel = kernel(&gpu, "rays");
    let mut random = Random(5);
    let views: Vec<_> =
        (0..1 << 15).map(|_| (random_view(&mut random), random.bits(), random_offset(&mut random))).collect();
    let cases: Vec<_> = views.iter().map(|(view, pixel, offset)| view_case(view, *pixel, *offset)).collect();
    let answers = map(&gpu, &kernel, &cases, ANSWER_WORDS);
    for ((view, pixel, [x, y]), answer) in views.iter().zip(answers.chunks_exact(ANSWER_WORDS)) {
        let [column, row] = pixel_of(view, *pixel).map(f64::from);
        let ray = view.ray(column + x, row + y);
        let expected: Vec<_> = [ray.origin, ray.direction].iter().flat_map(DVec3::to_array).map(f64::to_bits).collect();
        let found: Vec<_> = (0..6).map(|index| number(answer, 2 * index)).collect();
        assert_eq!(found, expected, "{view:?} at {column} + {x}, {row} + {y}");
    }
}

fn random_view(random: &mut Random) -> View {
    let mut camera = Camera::look_at(random.point() * 10.0, random.point(), Vec3::Y, 0.1 + random.unit() as f32);
    if random.below(2) == 0 {
        camera.projection =
            Projection::Orthographic { half_height: random.unit() as f32 * 2.0_f32.powi(random.below(81) as i32 - 40) };
    }
    if random.below(4) == 0 {
        // Along the axes many products are zero.
        camera = Camera { right: Vec3::X, up: Vec3::NEG_Z, forward: Vec3::Y, position: Vec3::ZERO, ..camera };
    }
    View { camera, width: 1 + random.below(8192) as u32, height: 1 + random.below(8192) as u32 }
}

fn random_offset(random: &mut Random) -> [f64; 2] {
    let count = 1 + random.below(64);
    [(); 2].map(|()| (random.below(count) as f64 + 0.5) / count as f64)
}

fn pixel_of(view: &View, bits: u64) -> [u32; 2] {
    [bits as u32 % view.width, (bits >> 32) as u32 % view.height]
}

fn view_case(view: &View, pixel: u64, offset: [f64; 2]) -> Case {
    let Camera { position, right, up, forward, projection } = view.camera;
    let (half_height, is_orthographic) = match projection {
        Projection::Perspective { tan_half_height } => (tan_half_height, 0),
        Projection::Orthographic { half_height } => (half_height, 1),
    };
    let vectors = [position, right, up, forward].map(|vector| vector.to_array().map(f32::to_bits));
    let rest = [half_height.to_bits(), is_orthographic, view.width, view.height];
    let words = vectors.into_iter().zip(rest).flat_map(|(vector, word)| vector.into_iter().chain([word]));
    case(words.chain(pixel_of(view, pixel)).chain(offset.into_iter().flat_map(words_of)))
}

pub(crate) fn pair_case(pair: &Pair) -> Case {
    case(pair_words(pair))
}

pub(crate) fn shadow_case(shadowing: &Shadowing) -> Case {
    let Shadowing { ray, t, is_directional, light, corners } = *shadowing;
    let t = [0].into_iter().chain(words_of(t));
    let light = [u32::from(is_directional)].into_iter().chain(light.to_array().map(f32::to_bits));
    case(pair_words(&Pair { ray, corners }).chain(t).chain(light))
}

fn pair_words(pair: &Pair) -> impl Iterator<Item = u32> {
    let ray = [pair.ray.origin, pair.ray.direction].into_iter().flat_map(|vector| vector.to_array()).flat_map(words_of);
    let corners = pair.corners.into_iter().flat_map(|corner| corner.to_array()).map(f32::to_bits);
    ray.chain(corners)
}

fn light(shadowing: &Shadowing) -> LightSource {
    if shadowing.is_directional {
        LightSource::Directional { direction: shadowing.light }
    } else {
        LightSource::Point { position: shadowing.light }
    }
}

fn case(words: impl Iterator<Item = u32>) -> Case {
    let mut case = [0; CASE_WORDS];
    case.iter_mut().zip(words).for_each(|(to, from)| *to = from);
    case
}

/// Low word, high word.
fn words_of(number: f64) -> [u32; 2] {
    [number.to_bits() as u32, (number.to_bits() >> 32) as u32]
}

fn number(words: &[u32], index: usize) -> u64 {
    u64::from(words[index]) | (u64::from(words[index + 1]) << 32)
}
