//! Large triangles compared with precise numbers and with the predicate. Triangles reach through the light, are nearly in a
//! plane with it or have such edges, and points are where the errors decide.

use crate::dispatch;
use glam::DVec2;
use rayon::prelude::*;

use super::*;
use crate::light_grid::choose::across;
use crate::light_grid::face::{Block, LARGEST_POINT_ERROR, POINT_LIMIT};
use crate::light_grid::filter::{TilePoints, may_touch};
use crate::light_grid::parts::TileParts;
use crate::light_grid::points::{MappedGroup, TILE_BLOCKS, block_of};
use crate::light_grid::set_up::Extent;
use crate::precise::{Precise, PreciseVector, cross, difference, dot, precise};
use crate::predicate::{HitPoint, ShadowRay};
use crate::random::Random;
use crate::shot::{Opaque, SeenPixels, Sides};
use crate::{LightSource, SimdLevel, Triangles};

const TRIALS: u32 = 6000;

/// Triangles of a trial: more than are tested together.
const TRIANGLES: usize = 20;

/// A triangle on the face, precisely.
struct Truth {
    /// Functions of X, Y and one: the corners' weights, not yet divided by the determinant.
    edges: [PreciseVector; 3],
    determinant: Precise,
    nearness: [Precise; 3],
    /// The corners in f64, and their largest coordinates.
    points: [DVec3; 3],
    sizes: [f64; 3],
}

/// X, Y and one, in perspective times the depth, and minus W in parallel light or the depth.
fn homogeneous(face: &Face, v: PreciseVector) -> (PreciseVector, Precise) {
    let [x, y, z] = [face.x, face.y, face.z].map(|axis| dot(precise(axis), v));
    if face.is_parallel { ([x, y, 1.0.into()], z) } else { ([x, y, z], face.near.into()) }
}

/// X, Y and W.
fn on_face(face: &Face, v: PreciseVector) -> PreciseVector {
    let ([x, y, z], w) = homogeneous(face, v);
    [x / z, y / z, w / z]
}

impl Truth {
    fn new(face: &Face, corners: [Vec3; 3]) -> Self {
        let world = corners.map(|corner| difference(precise(corner.as_dvec3()), precise(face.origin)));
        let mapped = world.map(|corner| homogeneous(face, corner));
        let points = mapped.map(|(point, _)| point);
        let edges = [(1, 2), (2, 0), (0, 1)].map(|(j, k)| cross(points[j], points[k]));
        let points64 = points.map(|point| DVec3::from(point.map(Precise::to_f64)));
        Self {
            edges,
            determinant: dot(points[0], edges[0]),
            nearness: mapped.map(|(_, nearness)| nearness),
            points: points64,
            sizes: points64.map(|point| point.abs().max_element()),
        }
    }

    /// Whether the triangle is between the light and X, Y and W; `None` where that can't be told.
    fn shadows(&self, [x, y, w]: PreciseVector) -> Option<bool> {
        const ROUNDED: f64 = 1e-28;
        let [s0, s1, s2] = self.sizes;
        let flat = 1.0 + x.to_f64().abs() + y.to_f64().abs();
        let errors = [s1 * s2, s2 * s0, s0 * s1].map(|size| ROUNDED * flat * size);
        let of_determinant = 8.0 * ROUNDED * s0 * s1 * s2;
        if self.determinant.to_f64().abs() <= of_determinant {
            return None;
        }
        let sign = Precise::from(self.determinant.to_f64().signum());
        let weights = self.edges.map(|edge| dot(edge, [x, y, 1.0.into()]) * sign);
        let nearer = dot(weights, self.nearness) - w * self.determinant * sign;
        let weights = weights.map(Precise::to_f64);
        let nearness = self.nearness.map(|nearness| nearness.to_f64().abs());
        let of_depth = 4.0 * DVec3::from(errors).dot(nearness.into()) + of_determinant * w.to_f64().abs();
        let nearer = nearer.to_f64();
        if weights.iter().zip(errors).any(|(&weight, error)| weight < -error) || nearer < -of_depth {
            Some(false)
        } else if weights.iter().zip(errors).all(|(&weight, error)| weight > error) && nearer > of_depth {
            Some(true)
        } else {
            None
        }
    }

    /// An edge function in f64, of which the magnitudes sum up to one.
    fn edge(&self, index: usize) -> DVec3 {
        let edge = DVec3::from(self.edges[index].map(Precise::to_f64));
        edge * (self.determinant.to_f64().signum() / edge.abs().element_sum().max(1e-300))
    }

    /// W of the plane.
    fn plane(&self, at: DVec2) -> f64 {
        let at = precise(at.extend(1.0));
        (dot(self.edges.map(|edge| dot(edge, at)), self.nearness) / self.determinant).to_f64()
    }
}

/// A light's face with triangles.
struct FaceWithTriangles {
    random: Random,
    level: SimdLevel,
    light: LightSource,
    face: Face,
    /// Right, up and forward, and half the face and its middle, in lengths or tangents.
    frame: [DVec3; 3],
    half: DVec2,
    middle: DVec2,
    /// The direction that triangles are around, and the size of everything.
    towards: DVec3,
    flat: Option<usize>,
    size: f64,
}

impl FaceWithTriangles {
    fn new(mut random: Random, level: SimdLevel) -> Self {
        let is_parallel = random.unit() < 0.4;
        let mut vector = |size: f64| DVec3::from([0; 3].map(|_| random.signed() * size));
        let (somewhere, aside, along) = (vector(1.0), vector(0.5), vector(1.0));
        let mut towards = if random.unit() < 0.7 { (somewhere * 2.5).round() } else { somewhere };
        // Where nothing is rounded, triangles may be as near to a plane with the light as any.
        let flat = (random.unit() < 0.3).then(|| (random.unit() * 3.0) as usize);
        flat.inspect(|&axis| towards[axis] = 0.0);
        let towards = if towards == DVec3::ZERO { DVec3::ONE } else { towards };
        let forward = if random.unit() < 0.4 { towards } else { towards.normalize() + aside }.as_vec3();
        let direction = forward.as_dvec3().normalize();
        let along = match (random.unit() * 5.0) as u32 {
            0 => direction + along * random.power(-9.0, -5.0),
            1 | 2 => DVec3::AXES[(random.unit() * 3.0) as usize],
            _ => along,
        };
        let (right, up) = across(direction, along);
        let size = random.power(-3.0, 3.0).log2().round().exp2();
        let mut origin = match (random.unit() * 3.0) as u32 {
            0 => DVec3::ZERO,
            1 => (somewhere * 4.0).round() * size,
            _ => somewhere * size * random.power(-2.0, 5.0),
        };
        flat.inspect(|&axis| origin[axis] = 0.0);
        let origin = origin.as_vec3();
        let half = random.power(-5.0, 0.2);
        let half = DVec2::new(half, if random.unit() < 0.5 { half } else { random.power(-5.0, 0.2) });
        // In the middle, anywhere, or where the face ends.
        let mut aside = || [0.0, 0.8 * random.signed(), POINT_LIMIT - 0.5 / 1024.0][(random.unit() * 2.2) as usize];
        let aside = DVec2::new(aside(), aside()) * half;
        let middle = DVec2::new(right.dot(towards), up.dot(towards)) / direction.dot(towards) + aside;
        let depth = random.power(-5.0, 0.0);
        let half = if is_parallel { half * size } else { half };
        let is_exact = random.unit() < 0.3;
        let face = if is_parallel {
            let scale = half.extend(depth * size).recip();
            let (x, y, z) = (right * scale.x, up * scale.y, -direction * scale.z);
            let origin = origin.as_dvec3() + (aside.x * right + aside.y * up) * size;
            let point_error = if is_exact { 0.0 } else { size * random.power(-16.0, -7.0) };
            Face { origin, x, y, z, near: 1.0, is_parallel, scale, owned: None, point_error }
        } else {
            let scale = half.recip();
            let (x, y) = ((right - direction * middle.x) * scale.x, (up - direction * middle.y) * scale.y);
            let near = if random.unit() < 0.05 { random.power(-42.0, -36.0) } else { size * random.power(-3.0, 0.0) };
            let point_error = if is_exact { 0.0 } else { random.power(-11.0, -7.2) };
            let (origin, scale) = (origin.as_dvec3(), scale.extend(1.0));
            Face { origin, x, y, z: direction, near, is_parallel, scale, owned: None, point_error }
        };
        let light = LightSource::Point { position: origin };
        let light = if is_parallel { LightSource::Directional { direction: forward } } else { light };
        let frame = [right, up, direction];
        Self { random, level, light, face, frame, half, middle, towards, flat, size }
    }

    fn corners(&mut self) -> [Vec3; 3] {
        let Self { random, face, towards, flat, size, .. } = self;
        let kind = random.unit();
        let most = random.power(-10.0, 2.0);
        let is_whole = random.unit() < 0.5;
        let is_through = random.unit() < 0.3;
        let zeros = random.unit() * 0.8;
        let thin = random.power(-14.0, -4.0);
        let is_thin = random.unit() < 0.7;
        let all = if kind < 0.04 { random.power(-42.0, -30.0) } else { 1.0 };
        let large = random.power(-3.0, 8.0).log2().round().exp2();
        std::array::from_fn(|_| {
            if kind > 0.9 {
                // In a plane that the light faces, or is in.
                let beside = DVec3::from([0; 3].map(|_| (random.signed() * 3.5).round())).cross(*towards) * large;
                let along = if kind > 0.95 { DVec3::ZERO } else { *towards };
                return (face.origin + (beside + along) * *size).as_vec3();
            }
            let along = if is_whole { 1.0 + (random.unit() * 4.0).floor() } else { random.power(-1.0, 1.0) };
            let along = if is_through && random.unit() < 0.5 { -along } else { along };
            let of_corner = most * if random.unit() < 0.3 { random.power(-8.0, 0.0) } else { 1.0 };
            let spread = [0; 3].map(|_| if random.unit() < zeros { 0.0 } else { random.signed() * of_corner });
            let mut v = *towards * along + DVec3::from(spread);
            flat.filter(|_| is_thin).inspect(|&axis| v[axis] = thin * random.signed());
            (face.origin + v * (*size * all)).as_vec3()
        })
    }

    /// A place on the face: beside an edge of a triangle, by about its error, or anywhere in it.
    fn place(&mut self, truth: &Truth, edge_error: f64) -> DVec2 {
        let Self { random, .. } = self;
        let mut at = DVec2::new(random.signed(), random.signed());
        for _ in 0..3 {
            let weights = [0; 3].map(|_| if random.unit() < 0.2 { 0.0 } else { random.power(-4.0, 0.0) });
            let sum = (0..3).map(|corner| truth.points[corner] * weights[corner]).sum::<DVec3>();
            let inside = sum.truncate() / sum.z;
            if sum.z > 0.0 && inside.abs().max_element() < POINT_LIMIT {
                at = inside;
            }
        }
        if random.unit() < 0.7 {
            let edge = truth.edge((random.unit() * 3.0) as usize);
            let off = edge_error * random.signed() * 2.0;
            let aside = edge.truncate() * ((off - edge.dot(at.extend(1.0))) / edge.truncate().length_squared());
            at += if aside.is_finite() { aside } else { DVec2::ZERO };
        }
        at.clamp(DVec2::splat(-POINT_LIMIT), DVec2::splat(POINT_LIMIT))
    }

    fn nearness(&mut self, truth: &Truth, at: DVec2, depth_error: f64, side: f64) -> f64 {
        let random = &mut self.random;
        let plane = truth.plane(at);
        let plane = if plane.abs() < 1e14 { plane } else { 1.0 };
        let error = if depth_error < 1e14 { depth_error } else { plane };
        if side > 0.5 {
            plane - plane.abs() * random.power(-6.0, 1.0)
        } else {
            plane + error * (2.0 * side + random.signed()) * 2.0
        }
    }

    /// The world position of X, Y and W.
    fn world(&self, at: DVec3) -> DVec3 {
        let Self { face, frame: [right, up, forward], half, middle, .. } = self;
        if face.is_parallel {
            face.origin + right * (at.x * half.x) + up * (at.y * half.y) - forward * (at.z / face.scale.z)
        } else {
            let tangent = at.truncate() * *half + *middle;
            face.origin + (right * tangent.x + up * tangent.y + forward) * (face.near / at.z)
        }
    }

    fn run(&mut self) -> [u32; 6] {
        let corners: Vec<_> = (0..TRIANGLES).map(|_| self.corners()).collect();
        let indices: Vec<_> = (0..TRIANGLES as u32).map(|id| [3 * id, 3 * id + 1, 3 * id + 2]).collect();
        let triangles = Triangles { positions: corners.as_flattened(), indices: &indices };
        let opacity = OpacityOfSides::between(triangles, (&Opaque, Sides::Both), &self.light);
        let mut large = LargeTriangles::default();
        large.find(&self.face, 0..TRIANGLES as u32, &opacity);
        let mut counts = [0; 6];
        for (id, &corners) in corners.iter().enumerate() {
            let truth = Truth::new(&self.face, corners);
            if triangles.usable_corners(id as u32).is_ok() {
                self.check_reaching(&large, id as u32, &truth, &mut counts);
                self.check_record(&large, id as u32, corners, &truth, &mut counts);
            }
        }
        counts
    }

    fn check_reaching(&mut self, large: &LargeTriangles, id: u32, truth: &Truth, counts: &mut [u32; 6]) {
        let errors = large.planes.iter().find(|plane| plane.id == id).map_or([1e-7; 2], |plane| {
            let of_edge = plane.edge_errors[(self.random.unit() * 3.0) as usize];
            [of_edge.min(1.0), plane.depth_error]
        });
        for _ in 0..4 {
            let rounded = [HALF_ULP * self.random.power(-2.0, 1.0), HALF_ULP * self.random.power(-2.0, 1.0)];
            let at = self.place(truth, errors[0] + rounded[0]);
            let at = at.as_vec2().as_dvec2();
            let size = truth.plane(at).abs();
            let side = self.random.unit() - 0.4;
            let w = self.nearness(truth, at, errors[1] + rounded[1] * size, side) as f32;
            if truth.shadows(precise(at.extend(w.into()))) != Some(true) {
                continue;
            }
            counts[0] += 1;
            let grown = self.random.power(-9.0, 0.0) as f32;
            let [x, y] = at.as_vec2().to_array();
            let low = if self.random.unit() < 0.5 { grown } else { 0.0 };
            let boxed = FaceBox { x: [x - low, x], y: [y, y + low], nearness: w };
            let mut is_reached = false;
            dispatch!(self.level, simd => large.reaching(simd, &boxed, |number| is_reached |= large.planes[number].id == id));
            assert!(is_reached, "not reached: {truth} at {at}, {w}", truth = truth.determinant.to_f64());
        }
    }

    fn check_record(
        &mut self,
        large: &LargeTriangles,
        id: u32,
        corners: [Vec3; 3],
        truth: &Truth,
        counts: &mut [u32; 6],
    ) {
        let numbers: Vec<_> = (0..large.planes.len()).filter(|&number| large.planes[number].id == id).collect();
        let first = self.place(truth, 1e-7);
        let around = truth.plane(first);
        let around = if around.abs() < 1e14 { around } else { 1.0 };
        let mut error = |most: f64| if self.random.unit() < 0.4 { 0.0 } else { most * self.random.power(-9.0, 0.0) };
        let errors = [error(LARGEST_POINT_ERROR) as f32, error(around.abs() * 0.01) as f32];
        let [away, far] = [self.random.power(-12.0, 0.0), around.abs() * self.random.power(-9.0, 0.0)];
        let mut near = |size: f64| self.random.signed() * size;
        let origin = (first.extend(around) + DVec3::new(near(away), near(away), near(far))).as_vec3();
        let guess = numbers.first().map_or([1e-7, far], |&number| {
            let record = large.record(number, origin.to_array(), [away as f32, far as f32], errors);
            record.errors.map(|twice| f64::from(twice) / 2.0)
        });
        // Across the plane's slope all are as near to the light, so that rounding errors are far more than the remainder.
        let level = numbers.first().and_then(|&number| {
            let [p, q, _] = large.planes[number].nearness;
            DVec2::new(-q, p).try_normalize().filter(|_| self.random.unit() < 0.3)
        });
        let is_tight = self.random.unit() < 0.5;
        let side = self.random.unit() - 0.4;
        let local: [Vec3; LANES] = std::array::from_fn(|_| {
            let at = if let Some(level) = level {
                first + level * (self.random.signed() * away)
            } else if is_tight {
                first + DVec2::new(self.random.signed(), self.random.signed()) * away
            } else {
                self.place(truth, guess[0].min(1.0))
            };
            let at = at.clamp(DVec2::splat(-POINT_LIMIT), DVec2::splat(POINT_LIMIT));
            let w = self.nearness(truth, at, guess[1], side);
            (at.extend(w) - origin.as_dvec3()).as_vec3()
        });
        let (extent, parts, blocks) = self.parts(origin, &local, errors);
        let mut seen = SeenPixels::default();
        seen.resize(64, 64);
        let part = &parts.parts[0];
        let points = TilePoints::new(0, &blocks, &seen.triangle);
        let (mut possible, mut certain) = (0, 0);
        for number in numbers {
            let record = large.record(number, extent.origin, [extent.reach, extent.depth], extent.errors);
            dispatch!(self.level, simd => {
                let found = points.test(simd, &record.quads, id, (part.blocks[0], !part.points[0]));
                if may_touch(simd, &record.quads, &part.boxes) & 1 == 1 {
                    possible |= found.possible;
                    certain |= found.certain(simd, record.errors);
                }
            });
        }
        for (lane, local) in local.iter().enumerate() {
            let (is_possible, is_certain) = (possible >> lane & 1 == 1, certain >> lane & 1 == 1);
            counts[if is_certain { 1 } else { 2 + usize::from(is_possible) }] += 1;
            let local = precise(local.as_dvec3());
            let found: PreciseVector = std::array::from_fn(|axis| Precise::from(f64::from(origin[axis])) + local[axis]);
            self.check_point(corners, truth, found, errors.map(f64::from), [is_possible, is_certain], counts);
        }
    }

    fn parts(
        &self,
        origin: Vec3,
        local: &[Vec3; LANES],
        errors: [f32; 2],
    ) -> (Extent, TileParts, Box<[Block; TILE_BLOCKS]>) {
        let mut blocks = Box::new([Block::EMPTY; TILE_BLOCKS]);
        let mut group = MappedGroup {
            members: [0; LANES],
            x: [[f32::INFINITY; LANES], [f32::NEG_INFINITY; LANES]],
            y: [[f32::INFINITY; LANES], [f32::NEG_INFINITY; LANES]],
            nearness: [[f32::INFINITY; LANES], [f32::NEG_INFINITY; LANES]],
            errors,
        };
        group.members[0] = u16::MAX;
        let block = &mut blocks[block_of(0, 0)];
        for (lane, point) in local.iter().enumerate() {
            [block.x[lane], block.y[lane], block.nearness[lane]] = point.to_array();
        }
        let lows = local.iter().fold(Vec3::INFINITY, |low, &point| low.min(point));
        let highs = local.iter().fold(Vec3::NEG_INFINITY, |high, &point| high.max(point));
        (group.x[0][0], group.x[1][0]) = (lows.x, highs.x);
        (group.y[0][0], group.y[1][0]) = (lows.y, highs.y);
        (group.nearness[0][0], group.nearness[1][0]) = (lows.z, highs.z);
        let mut extent = Extent { origin: origin.to_array(), errors, ..Extent::default() };
        let mut parts = TileParts::default();
        dispatch!(self.level, simd => {
            parts.divide(simd, 0, &group, &blocks, 1e30);
            parts.finish(simd, &mut extent);
        });
        (extent, parts, blocks)
    }

    fn check_point(
        &mut self,
        corners: [Vec3; 3],
        truth: &Truth,
        found: PreciseVector,
        [position, nearness]: [f64; 2],
        [is_possible, is_certain]: [bool; 2],
        counts: &mut [u32; 6],
    ) {
        let signs = [[0.0; 3], [1.0, 1.0, 1.0], [-1.0, 1.0, -1.0], [1.0, -1.0, -1.0], [-1.0, -1.0, 1.0]];
        for signs in signs.into_iter().chain(signs.map(|[x, y, z]| [x, y, -z])) {
            let errors = DVec3::from(signs) * DVec3::new(position, position, nearness);
            let at: PreciseVector = std::array::from_fn(|axis| found[axis] + Precise::from(errors[axis]));
            let shadows = truth.shadows(at);
            let about =
                || format!("{corners:?} {:?} at {:?} ±{position} ±{nearness}", self.face, at.map(Precise::to_f64));
            assert!(is_possible || shadows != Some(true), "ruled out: {}", about());
            assert!(!is_certain || shadows != Some(false), "certain: {}", about());
        }
        let about = || format!("{corners:?} {:?} at {:?}", self.face, found.map(Precise::to_f64));
        let signs = DVec3::from(signs[(self.random.unit() * 5.0) as usize]) * 0.9;
        let at = DVec3::from(found.map(Precise::to_f64)) + signs * DVec3::new(position, position, nearness);
        if let Some(blocked) = self.predicate(corners, at, found, [position, nearness]) {
            counts[4 + usize::from(blocked)] += 1;
            assert!(is_possible || !blocked, "the predicate says that what is ruled out isn't: {}", about());
            assert!(!is_certain || blocked, "the predicate says that what is certain isn't: {}", about());
        }
    }

    /// The predicate's answer for a point at X, Y and W; `None` where f64 has no such point within the errors of the found
    /// one.
    fn predicate(
        &self,
        corners: [Vec3; 3],
        at: DVec3,
        found: PreciseVector,
        [position, nearness]: [f64; 2],
    ) -> Option<bool> {
        let Self { face, .. } = self;
        let point = self.world(at);
        if !(point.is_finite() && point.abs().max_element() < 1e37 && (face.is_parallel || at.z > 0.0)) {
            return None;
        }
        let v = difference(precise(point), precise(face.origin));
        let is_within = |v: PreciseVector, errors: [f64; 3]| {
            let away = difference(on_face(face, v), found);
            away.iter().zip(errors).all(|(away, error)| away.abs() <= error.into())
        };
        let is_found = is_within(v, [position, position, nearness])
            && (face.is_parallel || is_within(precise(point - face.origin), [position, position, f64::INFINITY]));
        let length = if face.is_parallel { 1.0 } else { dot(precise(face.z), v).to_f64() };
        let error = face.point_error * length * 0.999;
        let hit = HitPoint { position: point, error };
        (is_found && error > 0.0).then(|| ShadowRay::new(&self.light, hit).blocked_by(corners).is_some())
    }
}

#[test]
fn what_is_decided_of_large_triangles_is_so() {
    let levels = SimdLevel::available();
    let of_trial =
        |seed: u32| FaceWithTriangles::new(Random::new(seed.into()), levels[seed as usize % levels.len()]).run();
    let counts = (0..TRIALS).into_par_iter().map(of_trial).collect::<Vec<_>>();
    let counts = counts.into_iter().fold([0; 6], |sum, one| std::array::from_fn(|verdict| sum[verdict] + one[verdict]));
    assert!(counts.iter().all(|&count| count > TRIALS), "{counts:?}");
}

/// Triangles in planes through zero, so near to the light that rounding decides which parts are in front of it.
#[test]
fn what_is_outside_shadows_nothing() {
    let outside = (0..64_u32).into_par_iter().map(|seed| {
        let mut random = Random::new(seed.into());
        let near = random.power(-17.0, -15.0);
        let mut vector = |size: f64| DVec3::from([0; 3].map(|_| (random.signed() * size).round()));
        let towards = vector(4.0) + DVec3::new(0.0, 0.0, 5.0);
        let z = towards.normalize();
        let (x, y) = across(z, DVec3::X);
        let origin = -towards * near;
        let face = Face { origin, x, y, z, near: 1.0, scale: DVec3::ONE, ..Face::default() };
        let mut outside = 0;
        for _ in 0..4000 {
            let corners = [0; 3].map(|_| (vector(7.0).cross(towards) * 0.25).as_vec3());
            if let [None, _] = LargeTriangle::of(&face, corners, 0) {
                outside += 1;
                let truth = Truth::new(&face, corners);
                let at = precise(DVec3::new(0.1, 0.2, 0.5));
                assert!(truth.shadows(at) != Some(true), "outside: {corners:?} {face:?}");
            }
        }
        outside
    });
    assert!(outside.sum::<u32>() > 1000);
}
