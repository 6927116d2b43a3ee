//! The fast triangle tests against the predicate, within their documented bounds.

use fearless_simd::{Simd, f32x16, prelude::*};
use glam::{DVec3, Vec3};
use umbrage_papers::triangle::{
    Badouel, BadouelBundle, Bundle, BundleTest, Fans, HavelHerout, Hits, KenslerShirley, MollerTrumbore,
    MollerTrumboreBundle, Plucker, PluckerBundle, Rays, Shevtsov, TriangleTest, Wachter,
};
use umbrage_rays::dispatch;
use umbrage_rays::predicate::crossing;
use umbrage_rays::{Ray, SimdLevel, Triangles};

use crate::support::{Mesh, Random};

/// A ray with coordinates in f32.
#[derive(Clone, Copy, Debug)]
struct Line {
    origin: Vec3,
    direction: Vec3,
    interval: [f32; 2],
}

impl Line {
    fn new(origin: Vec3, direction: Vec3) -> Self {
        Self { origin, direction, interval: [0.0, f32::INFINITY] }
    }

    fn through(origin: Vec3, point: Vec3) -> Self {
        Self::new(origin, point - origin)
    }

    fn exact(&self) -> Ray {
        let [t_min, t_max] = self.interval.map(f64::from);
        Ray { origin: self.origin.as_dvec3(), direction: self.direction.as_dvec3(), t_min, t_max }
    }

    fn rays(&self) -> Rays<f32> {
        Rays::new(self.origin.to_array(), self.direction.to_array(), self.interval)
    }

    fn bundle(&self) -> Bundle<f32> {
        let [t_min, t_max] = self.interval;
        Bundle { direction: self.direction.to_array(), t_min, t_max }
    }
}

type Corners = [Vec3; 3];

/// t and the weights of the second and third corner.
type Found = Option<[f32; 3]>;

fn found(hits: Option<Hits<f32>>) -> Found {
    hits.map(|Hits { mask, t, barycentric: [v, w] }| {
        assert!(mask, "there are hits only where a ray hits");
        [t, v, w]
    })
}

/// A test with its forms and bound.
struct Subject {
    name: &'static str,
    bound: Bound,
    single: fn(Corners, &Line) -> Found,
    /// Sixteen rays; only tests for any rays accept several origins.
    sixteen: fn(SimdLevel, Corners, &[Line; 16]) -> [Found; 16],
    shares_origin: bool,
}

/// How a test's errors grow, by its documentation.
#[derive(Clone, Copy, Debug)]
enum Bound {
    Edges,
    PluckerWorld,
    PluckerOrigin,
    PlaneWorld,
    PlaneOrigin,
}

fn of_test<T: TriangleTest>(bound: Bound) -> Subject {
    fn single<T: TriangleTest>(corners: Corners, line: &Line) -> Found {
        found(T::new(corners).hit(&line.rays()))
    }
    fn sixteen<T: TriangleTest>(level: SimdLevel, corners: Corners, lines: &[Line; 16]) -> [Found; 16] {
        dispatch!(level, simd => {
            let [origin, direction] = vectors(simd, lines);
            lanes(T::new(corners).hit(&Rays::new(origin, direction, intervals(simd, lines))))
        })
    }
    Subject { name: T::NAME, bound, single: single::<T>, sixteen: sixteen::<T>, shares_origin: false }
}

fn of_bundle<T: BundleTest>(bound: Bound) -> Subject {
    fn single<T: BundleTest>(corners: Corners, line: &Line) -> Found {
        found(T::new(corners, line.origin).hit(&line.bundle()))
    }
    fn sixteen<T: BundleTest>(level: SimdLevel, corners: Corners, lines: &[Line; 16]) -> [Found; 16] {
        dispatch!(level, simd => {
            let ([_, direction], [t_min, t_max]) = (vectors(simd, lines), intervals(simd, lines));
            lanes(T::new(corners, lines[0].origin).hit(&Bundle { direction, t_min, t_max }))
        })
    }
    Subject { name: T::NAME, bound, single: single::<T>, sixteen: sixteen::<T>, shares_origin: true }
}

/// A fan of one triangle; each corner is the centre in turn.
fn of_fan() -> Subject {
    fn fan(corners: Corners) -> Fans {
        let turn = corners[0].x.to_bits() % 3;
        let indices = [[0, 1, 2].map(|corner: u32| (corner + turn) % 3)];
        let mut positions = corners;
        positions.rotate_right(turn as usize);
        Fans::new(Triangles { positions: &positions, indices: &indices })
    }
    fn single(corners: Corners, line: &Line) -> Found {
        let (fans, mut result) = (fan(corners), None);
        (0..fans.len()).for_each(|place| fans.fan(place).hit(&line.rays(), |_, hits| result = found(Some(hits))));
        result
    }
    fn sixteen(level: SimdLevel, corners: Corners, lines: &[Line; 16]) -> [Found; 16] {
        let fans = fan(corners);
        let mut result = [None; 16];
        dispatch!(level, simd => {
            let [origin, direction] = vectors(simd, lines);
            let rays = Rays::new(origin, direction, intervals(simd, lines));
            (0..fans.len()).for_each(|place| fans.fan(place).hit(&rays, |_, hits| result = lanes(Some(hits))));
        });
        result
    }
    Subject { name: "Galin–Akkouche", bound: Bound::Edges, single, sixteen, shares_origin: false }
}

fn subjects() -> Vec<Subject> {
    vec![
        of_test::<MollerTrumbore>(Bound::Edges),
        of_test::<KenslerShirley>(Bound::Edges),
        of_test::<Badouel>(Bound::PlaneWorld),
        of_test::<Wachter>(Bound::PlaneWorld),
        of_test::<Shevtsov>(Bound::PlaneWorld),
        of_test::<HavelHerout>(Bound::PlaneWorld),
        of_test::<Plucker>(Bound::PluckerWorld),
        of_bundle::<MollerTrumboreBundle>(Bound::Edges),
        of_bundle::<BadouelBundle>(Bound::PlaneOrigin),
        of_bundle::<PluckerBundle>(Bound::PluckerOrigin),
        of_fan(),
    ]
}

fn vectors<S: Simd>(simd: S, lines: &[Line; 16]) -> [[f32x16<S>; 3]; 2] {
    let lane = |number: &dyn Fn(&Line) -> f32| f32x16::simd_from(simd, lines.map(|line| number(&line)));
    [
        [lane(&|line| line.origin.x), lane(&|line| line.origin.y), lane(&|line| line.origin.z)],
        [lane(&|line| line.direction.x), lane(&|line| line.direction.y), lane(&|line| line.direction.z)],
    ]
}

fn intervals<S: Simd>(simd: S, lines: &[Line; 16]) -> [f32x16<S>; 2] {
    [0, 1].map(|end| f32x16::simd_from(simd, lines.map(|line| line.interval[end])))
}

fn lanes<S: Simd>(hits: Option<Hits<f32x16<S>>>) -> [Found; 16] {
    let Some(Hits { mask, t, barycentric: [v, w] }) = hits else { return [None; 16] };
    assert!(mask.any_true(), "there are hits only where a ray hits");
    std::array::from_fn(|lane| mask.test(lane).then(|| [t[lane], v[lane], w[lane]]))
}

impl Bound {
    /// Error bounds of weights and t, for a ray's line that meets the triangle's plane at `t`.
    fn of(self, line: &Line, corners: Corners, t: f64) -> [f64; 2] {
        const FACTOR: f64 = 16.0 / (1 << 24) as f64;
        let (origin, direction) = (line.origin.as_dvec3(), line.direction.as_dvec3());
        let [a, b, c] = corners.map(Vec3::as_dvec3);
        let normal = (b - a).cross(c - a);
        let (determinant, area) = (normal.dot(direction).abs(), normal.length());
        let edge = (b - a).length().max((c - b).length()).max((a - c).length());
        let (speed, hit) = (direction.length(), origin + t * direction);
        let farthest = |points: &[DVec3], from: DVec3| points.iter().map(|&p| p.distance(from)).fold(0.0, f64::max);
        let of_world = farthest(&[a, b, c, origin, hit], DVec3::ZERO);
        let of_origin = farthest(&[a, b, c, hit], origin);
        let plane = |reach: f64| {
            let steepness = 1.0 + area * speed / determinant;
            reach / edge * (edge * edge / area).powi(2) * steepness
        };
        let (weights, reach) = match self {
            Self::Edges => (edge * speed * (of_origin + edge) / determinant, of_origin),
            Self::PluckerWorld => (of_world * of_world * speed / determinant, of_world),
            Self::PluckerOrigin => (of_origin * of_origin * speed / determinant, of_origin),
            Self::PlaneWorld => (plane(of_world), of_world),
            Self::PlaneOrigin => (plane(of_origin), of_origin),
        };
        [FACTOR * weights, FACTOR * edge * edge * reach / determinant]
    }
}

/// Number of compared pairs, and of pairs too near a limit to be compared with the predicate's answer.
#[derive(Debug, Default)]
struct Tally {
    pairs: usize,
    hits: usize,
    borderline: usize,
    /// The largest errors of weights and t, relative to the bounds.
    worst: [f64; 2],
}

impl Tally {
    fn borderline_share(&self) -> f64 {
        self.borderline as f64 / self.pairs as f64
    }

    /// Compares `found` with the predicate.
    fn note(&mut self, subject: &Subject, line: &Line, corners: Corners, found: Found) {
        let ray = line.exact();
        let relative = corners.map(|corner| corner.as_dvec3() - ray.origin);
        let edges = [(1, 2), (2, 0), (0, 1)];
        let edges = edges.map(|(p, q): (usize, usize)| ray.direction.dot(relative[p].cross(relative[q])));
        let sum: f64 = edges.iter().sum();
        let weights = edges.map(|edge| edge / sum);
        let [a, b, c] = corners.map(Vec3::as_dvec3);
        let normal = (b - a).cross(c - a);
        let t = normal.dot(a - ray.origin) / normal.dot(ray.direction);
        let [of_weights, of_t] = subject.bound.of(line, corners, t);

        let expected = crossing(&ray, corners).filter(|crossing| ray.t_min < crossing.t && crossing.t < ray.t_max);
        let margin = weights.iter().fold(f64::INFINITY, |least, &weight| least.min(weight)).abs();
        let to_limits = (t - ray.t_min).abs().min((t - ray.t_max).abs());
        // NaN is uncertain as well.
        let is_certain = margin > of_weights && to_limits > of_t;
        self.pairs += 1;
        self.borderline += usize::from(!is_certain);
        let describe =
            || format!("{}: {line:?} {corners:?}: {weights:?} ± {of_weights:e}, {t} ± {of_t:e}", subject.name);
        if is_certain {
            assert_eq!(found.is_some(), expected.is_some(), "{}", describe());
        }
        if let (Some([t, v, w]), Some(expected)) = (found, expected) {
            self.hits += 1;
            let [expected_v, expected_w] = expected.barycentric.map(f64::from);
            // The predicate's own weights are rounded to f32.
            let off = (f64::from(v) - expected_v).abs().max((f64::from(w) - expected_w).abs()) - 1e-7;
            let errors = [off / of_weights, (f64::from(t) - expected.t).abs() / of_t];
            // Bounds of more than a tenth say nothing about f32.
            if of_weights < 0.1 {
                assert!(errors[0] <= 1.0 && errors[1] <= 1.0, "{errors:?} {found:?} {expected:?} {}", describe());
                self.worst = [self.worst[0].max(errors[0]), self.worst[1].max(errors[1])];
            }
        }
    }
}

/// Compares a test, one ray at a time and sixteen, with the predicate, and each lane of the sixteen with the ray alone.
fn check(subject: &Subject, cases: &[(Corners, [Line; 16])]) -> Tally {
    let mut tally = Tally::default();
    for (corners, lines) in cases {
        let mut lines = *lines;
        if subject.shares_origin {
            let origin = lines[0].origin;
            lines.iter_mut().for_each(|line| line.origin = origin);
        }
        let alone = lines.map(|line| (subject.single)(*corners, &line));
        for (line, &found) in lines.iter().zip(&alone) {
            tally.note(subject, line, *corners, found);
        }
        for level in SimdLevel::available() {
            let together = (subject.sixteen)(level, *corners, &lines);
            let bits = |found: [Found; 16]| found.map(|found| found.map(|numbers| numbers.map(f32::to_bits)));
            assert_eq!(bits(together), bits(alone), "{} with {level}: {corners:?} {lines:?}", subject.name);
        }
    }
    tally
}

fn random_triangle(random: &mut Random) -> Corners {
    [random.point(), random.point(), random.point()]
}

/// The point with weights `v` and `w` of the second and third corner.
fn point_of([a, b, c]: Corners, v: f32, w: f32) -> Vec3 {
    a + (b - a) * v + (c - a) * w
}

#[test]
fn random_rays_hit_what_the_predicate_says() {
    let mut random = Random(61);
    let cases: Vec<_> = (0..400)
        .map(|_| {
            let (corners, origin) = (random_triangle(&mut random), random.point() * 3.0);
            let line = |_| {
                let target = point_of(corners, random.unit() * 1.4 - 0.2, random.unit() * 1.4 - 0.2);
                Line::through(origin + random.point() * 0.1, target)
            };
            (corners, [0; 16].map(line))
        })
        .collect();
    for subject in subjects() {
        let tally = check(&subject, &cases);
        println!("{}: {tally:?}", subject.name);
        assert!(tally.hits > 1000, "{}: {tally:?}", subject.name);
        assert!(tally.borderline_share() < 0.02, "{}: {tally:?}", subject.name);
    }
}

#[test]
fn rays_beside_edges_and_vertices_hit_what_the_predicate_says() {
    let mut random = Random(62);
    let cases: Vec<_> = (0..200)
        .map(|_| {
            // Not too thin, so that the weights have a few digits.
            let corners = [Vec3::ZERO, Vec3::X, Vec3::Y].map(|corner| corner + random.point() * 0.2);
            let origin = Vec3::new(0.3, 0.3, 2.0) + random.point();
            let place = std::cell::Cell::new(0);
            let line = |_| {
                // At, inside and outside of an edge or a vertex.
                let away = [0.0, 1e-3, -1e-3, 1e-7][place.replace(place.get() + 1) % 4];
                let along = [0.0, 1.0, 0.5, random.unit()][place.get() / 4 % 4];
                let mut weights = [along, away, 1.0 - along - away];
                weights.rotate_left((random.bits() % 3) as usize);
                Line::through(origin, point_of(corners, weights[0], weights[1]))
            };
            (corners, [0; 16].map(line))
        })
        .collect();
    for subject in subjects() {
        let tally = check(&subject, &cases);
        println!("{}: {tally:?}", subject.name);
        // Half of the rays aim at an edge, or 1e-7 beside it.
        assert!((0.2..0.65).contains(&tally.borderline_share()), "{}: {tally:?}", subject.name);
    }
}

#[test]
fn slivers_are_hit_as_the_predicate_says() {
    let mut random = Random(63);
    let cases: Vec<_> = (0..300)
        .map(|_| {
            let (a, b) = (random.point(), random.point());
            let thickness = 0.3 * 1e-3_f32.powf(random.unit());
            let corners = [a, b, a.lerp(b, random.unit()) + random.point() * thickness];
            let origin = random.point() * 3.0;
            let line = |_| Line::through(origin, point_of(corners, random.unit(), random.unit()));
            (corners, [0; 16].map(line))
        })
        .collect();
    for subject in subjects() {
        let tally = check(&subject, &cases);
        println!("{}: {tally:?}", subject.name);
        // The bounds of planes and projections grow with the square of the sliver's length over its width.
        let is_plane = matches!(subject.bound, Bound::PlaneWorld | Bound::PlaneOrigin);
        let most = if is_plane { 0.6 } else { 0.2 };
        assert!(tally.hits > 500 && tally.borderline_share() < most, "{}: {tally:?}", subject.name);
    }
}

/// A right triangle with legs of one in a plane across `axis`, and sixteen rays along the axis through its rectangle.
///
/// Small multiples of 1/4: no test rounds anything.
fn axis_parallel(axis: usize, height: f32, is_turned: bool, towards: f32) -> (Corners, [Line; 16]) {
    let place = |across: f32, up: f32, along: f32| {
        let mut point = [0.0; 3];
        (point[axis], point[(axis + 1) % 3], point[(axis + 2) % 3]) = (along, across, up);
        Vec3::from(point)
    };
    let (second, third) = (place(1.0, 0.0, height), place(0.0, 1.0, height));
    let corners = [place(0.0, 0.0, height), second, third];
    let corners = if is_turned { [corners[0], third, second] } else { corners };
    let lines = std::array::from_fn(|ray| {
        let (across, up) = ((ray % 4) as f32 * 0.5 - 0.25, (ray / 4) as f32 * 0.5 - 0.25);
        // Every other ray is shifted to a corner or an edge.
        let shift = if ray % 2 == 0 { 0.25 } else { 0.0 };
        Line::new(place(across + shift, up + shift, height - 2.0 * towards), place(0.0, 0.0, towards))
    });
    (corners, lines)
}

fn all_axis_parallel() -> impl Iterator<Item = (Corners, [Line; 16])> {
    let sides = [(false, 1.0), (true, 1.0), (false, -1.0), (true, -1.0)];
    (0..3).flat_map(move |axis| {
        sides.into_iter().flat_map(move |(is_turned, towards)| {
            [0.0, 3.0, -5.0].map(|height| axis_parallel(axis, height, is_turned, towards))
        })
    })
}

#[test]
fn axis_parallel_triangles_and_rays_leave_no_doubt() {
    for subject in subjects() {
        let (mut hits, mut at_edges) = (0, 0);
        for (corners, lines) in all_axis_parallel() {
            for line in lines {
                let expected = crossing(&line.exact(), corners);
                let result = (subject.single)(corners, &line);
                let expected = expected.map(|expected| {
                    let [v, w] = expected.barycentric;
                    at_edges += usize::from(v == 0.0 || w == 0.0 || v + w == 1.0);
                    [expected.t as f32, v, w]
                });
                assert_eq!(result, expected, "{}: {line:?} {corners:?}", subject.name);
                hits += usize::from(expected.is_some());
            }
        }
        assert!(hits >= 36 * 3 && at_edges >= 36, "{hits} {at_edges}");
        let cases: Vec<_> = all_axis_parallel().collect();
        check(&subject, &cases);
    }
}

#[test]
fn the_interval_is_open() {
    let (corners, lines) = axis_parallel(2, 1.0, false, 1.0);
    let line = lines[5];
    let (below, above) = (2.0_f32.next_down(), 2.0_f32.next_up());
    let cases = [
        ([0.0, f32::INFINITY], true),
        ([f32::NEG_INFINITY, f32::INFINITY], true),
        ([0.0, 2.0], false),
        ([0.0, above], true),
        ([2.0, 3.0], false),
        ([below, 3.0], true),
        ([below, above], true),
        ([3.0, 1.0], false),
        ([-3.0, -1.0], false),
        ([f32::NAN, 3.0], false),
        ([0.0, f32::NAN], false),
    ];
    for subject in subjects() {
        for (interval, is_hit) in cases {
            // Integer comparisons need a finite, non-empty interval, as its documentation says.
            let is_interval = interval[0].is_finite() && interval[0] < interval[1];
            if subject.name == Wachter::NAME && !is_interval {
                continue;
            }
            let line = Line { interval, ..line };
            let found = (subject.single)(corners, &line);
            assert_eq!(found.is_some(), is_hit, "{}: {interval:?} {found:?}", subject.name);
            let [first, ..] = (subject.sixteen)(SimdLevel::default(), corners, &[line; 16]);
            assert_eq!(first, found, "{}: {interval:?}", subject.name);
        }
    }
    // Behind the origin, but inside an interval below zero.
    for subject in subjects() {
        let line = Line { direction: -line.direction, interval: [-3.0, -1.0], ..line };
        let found = (subject.single)(corners, &line).map(|[t, ..]| t);
        assert_eq!(found, Some(-2.0), "{}", subject.name);
    }
}

#[test]
fn rays_in_the_plane_miss() {
    for subject in subjects() {
        for (corners, _) in all_axis_parallel() {
            let [a, b, c] = corners;
            let middle = (b + c) * 0.5;
            let targets = [a, b, c, middle, (a + b) * 0.5];
            for target in targets {
                for origin in [a + (a - b), b + (b - middle), c * 2.0 - a, a + (a - middle) * 2.0] {
                    for line in [Line::through(origin, target), Line::through(target, origin)] {
                        let found = (subject.single)(corners, &line);
                        assert_eq!(found, None, "{}: {line:?} {corners:?}", subject.name);
                    }
                }
            }
        }
    }
}

#[test]
fn nan_and_nothing_miss() {
    let corners = [Vec3::ZERO, Vec3::X, Vec3::Y];
    let line = Line::through(Vec3::new(0.25, 0.25, 2.0), Vec3::new(0.25, 0.25, 0.0));
    let spoilt = |vector: Vec3, axis: usize| {
        let mut vector = vector;
        vector[axis] = f32::NAN;
        vector
    };
    for subject in subjects() {
        assert!((subject.single)(corners, &line).is_some(), "{}", subject.name);
        let misses = |corners: Corners, line: Line| {
            assert_eq!((subject.single)(corners, &line), None, "{}: {line:?} {corners:?}", subject.name);
            let sixteen = (subject.sixteen)(SimdLevel::default(), corners, &[line; 16]);
            assert_eq!(sixteen, [None; 16], "{}: {line:?} {corners:?}", subject.name);
        };
        for axis in 0..3 {
            for corner in 0..3 {
                let mut corners = corners;
                corners[corner] = spoilt(corners[corner], axis);
                misses(corners, line);
            }
            misses(corners, Line { origin: spoilt(line.origin, axis), ..line });
            misses(corners, Line { direction: spoilt(line.direction, axis), ..line });
        }
        misses(corners, Line { direction: Vec3::ZERO, ..line });
        // No area: a point, and three corners in a row.
        misses([Vec3::ZERO; 3], line);
        misses([Vec3::ZERO, Vec3::X, Vec3::X * 2.0], line);
        misses([line.origin; 3], line);
    }
}

#[test]
fn fans_hit_what_their_triangles_do() {
    let mut random = Random(64);
    let mut soup = Mesh::soup(&mut random, 40, 0.3);
    soup.append(&Mesh::bumpy_ball(Vec3::ZERO, 1.0, 8));
    let mut odd = Mesh::floor(5, 2.0);
    // Reversed, duplicated, degenerate, out of range, not finite.
    odd.indices.extend([[1, 0, 7], [0, 1, 7], [0, 1, 7], [3, 3, 4], [0, 1, 999]]);
    odd.push([Vec3::ZERO, Vec3::X, Vec3::NAN]);
    for (mesh, most_fans) in [
        (Mesh::bumpy_ball(Vec3::ZERO, 1.0, 10), 0.34),
        (Mesh::floor(12, 2.0), 0.34),
        (soup, 0.6),
        (odd, 0.5),
        (Mesh::default(), 1.0),
    ] {
        let triangles = mesh.triangles();
        let fans = Fans::new(triangles);
        fans.validate(triangles).expect("valid fans");
        assert_eq!(fans.omitted(), &triangles.omitted());
        let share = fans.len() as f64 / triangles.len().max(1) as f64;
        println!("{} triangles in {} fans, {} bytes", triangles.len(), fans.len(), fans.bytes());
        assert!(share <= most_fans, "{} fans for {} triangles", fans.len(), triangles.len());

        let subject = of_test::<MollerTrumbore>(Bound::Edges);
        let mut tally = Tally::default();
        for _ in 0..150 {
            let line = Line::through(random.point() * 3.0, random.point());
            let mut found = vec![None; triangles.len()];
            for place in 0..fans.len() {
                fans.fan(place).hit(&line.rays(), |id, Hits { t, barycentric: [v, w], .. }| {
                    assert!(found[id as usize].replace([t, v, w]).is_none(), "{id} is hit twice");
                });
            }
            let ids = (0..fans.len()).flat_map(|place| fans.fan(place).ids().to_vec());
            for id in ids {
                tally.note(&subject, &line, triangles.corners(id), found[id as usize]);
            }
        }
        // A twentieth of a ball's triangles are slivers at its poles.
        assert!(triangles.is_empty() || (tally.hits > 50 && tally.borderline_share() < 0.06), "{tally:?}");
    }
}

#[test]
fn validation_finds_what_is_wrong_with_fans() {
    let mesh = Mesh::bumpy_ball(Vec3::ZERO, 1.0, 6);
    let fans = Fans::new(mesh.triangles());
    let mut moved = mesh.clone();
    moved.positions[20] += Vec3::X;
    assert!(fans.validate(moved.triangles()).unwrap_err().contains("other corners"));
    // The edges are the same, the centres aren't.
    let floor = Mesh::floor(4, 2.0);
    let aside = floor.moved(1.0, Vec3::X);
    assert!(Fans::new(floor.triangles()).validate(aside.triangles()).unwrap_err().contains("other corners"));
    let mut turned = mesh.clone();
    turned.indices[30].swap(0, 1);
    assert!(fans.validate(turned.triangles()).unwrap_err().contains("other corners"));
    let mut more = mesh.clone();
    more.push([Vec3::ZERO, Vec3::X, Vec3::Y]);
    assert!(fans.validate(more.triangles()).unwrap_err().contains("is in 0 fans"));
    let mut fewer = mesh;
    fewer.indices.pop();
    assert!(fans.validate(fewer.triangles()).unwrap_err().contains("isn't there"));
}

#[test]
fn tests_take_the_bytes_that_they_state() {
    assert_eq!(size_of::<MollerTrumbore>(), 36);
    assert_eq!(size_of::<KenslerShirley>(), 36);
    assert_eq!(size_of::<Badouel>(), 40);
    assert_eq!(size_of::<Shevtsov>(), 40);
    assert_eq!(size_of::<HavelHerout>(), 48);
    assert_eq!(size_of::<Plucker>(), 88);
    assert_eq!(size_of::<MollerTrumboreBundle>(), 40);
    assert_eq!(size_of::<BadouelBundle>(), 40);
    assert_eq!(size_of::<PluckerBundle>(), 52);
}
