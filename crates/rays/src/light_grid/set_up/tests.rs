//! The filter beside functions of real numbers. Sizes are drawn from many orders of magnitude, and points from where the
//! errors decide, so that each term of the errors is most of those of some triangles: without any one of them some point is
//! decided that can't be.

use crate::dispatch;
use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::*;
use crate::SimdLevel;
use crate::light_grid::boxes::SplatBox;
use crate::light_grid::face::Block;
use crate::light_grid::filter::{TilePoints, enqueue};
use crate::light_grid::parts::TileParts;
use crate::light_grid::points::{MappedGroup, TILE_BLOCKS, block_of};
use crate::light_grid::trace::QUEUE;
use crate::random::Random;
use crate::shot::SeenPixels;

mod predicate;

const TRIALS: u32 = 40_000;

const IDS: [u32; LANES] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15];

/// X, Y and W of a triangle's corners as real numbers.
type Corners = [DVec3; 3];

/// Twice the area of a triangle in X and Y.
fn area([a, b, c]: Corners) -> f64 {
    (b - a).truncate().perp_dot((c - a).truncate())
}

/// The edge functions of a point, above zero in a triangle of either winding, and the difference by which its plane is
/// nearer.
fn functions(corners: Corners, point: DVec3) -> ([f64; 3], f64) {
    let [a, b, c] = corners;
    let area = area(corners);
    let edges = [[b, c], [c, a], [a, b]].map(|[from, to]| 1.0_f64.copysign(area) * self::area([point, from, to]));
    let [u, v] = [edges[1], edges[2]].map(|edge| edge / area.abs());
    (edges, a.z - point.z + u * (b.z - a.z) + v * (c.z - a.z))
}

/// A patch of sixteen triangles and sixteen blocks of points, each aimed at one of them.
struct AimedBlocks {
    random: Random,
    level: SimdLevel,
    face: Face,
    origin: DVec3,
    /// A triangle's extent and its distance from the origin.
    size: f64,
    away: f64,
    /// A triangle's height in relation to its length.
    aspect: f64,
    rise: f64,
    /// The points'.
    errors: [f64; 2],
    /// A bit for each triangle that is there for light on its front alone, and for each that isn't padding.
    one_sided: u16,
    filled: u16,
}

/// Results for sixteen points each about sixteen triangles: a bit for each that may be shadowed, and a bit for each that
/// certainly is.
type Decisions = [[u16; 2]; LANES];

/// Sixteen triangles with these vertices, and for each a block of points as they are found in relation to the origin.
struct Setting<'a> {
    level: SimdLevel,
    face: &'a Face,
    vertex_errors: &'a VertexErrors,
    origin: [f32; 3],
    /// Errors of the points.
    errors: [f32; 2],
    one_sided: u16,
    filled: u16,
    vertices: &'a [[f32; 4]],
}

impl Setting<'_> {
    /// Of no points yet.
    fn extent(&self) -> Extent {
        Extent { origin: self.origin, errors: self.errors, ..Extent::default() }
    }

    /// Fills in a group's set-up; returns the bounds of the group.
    fn fill(&self, set_up: &mut SetUp, extent: &Extent) -> FaceBox {
        let corners = std::array::from_fn(|id| [0, 1, 2, 0].map(|corner| 3 * id as u8 + corner));
        let Self { level, face, vertex_errors, vertices, one_sided, filled, .. } = *self;
        let group = TriangleGroup { vertices, corners: &corners, ids: &IDS, filled };
        dispatch!(level, simd => {
            let corners = GroupCorners::new(simd, &group);
            let bounds = corners.bounds(simd, face, extent);
            set_up.fill(simd, face, vertex_errors, &corners, extent, one_sided);
            bounds
        })
    }

    fn decide(&self, points: &[[[f32; 3]; LANES]; LANES]) -> Decisions {
        let mut blocks = Box::new([Block::EMPTY; TILE_BLOCKS]);
        let mut ranges = [[[f32::INFINITY; LANES], [f32::NEG_INFINITY; LANES]]; 3];
        for (number, points) in points.iter().enumerate() {
            let block = &mut blocks[block_of(0, number)];
            for (lane, &point) in points.iter().enumerate() {
                [block.x[lane], block.y[lane], block.nearness[lane]] = point;
                for ([low, high], coordinate) in ranges.iter_mut().zip(point) {
                    low[number] = low[number].min(coordinate);
                    high[number] = high[number].max(coordinate);
                }
            }
        }
        let [x, y, nearness] = ranges;
        let Self { level, errors, .. } = *self;
        let group = MappedGroup { members: [u16::MAX; LANES], x, y, nearness, errors };
        let mut extent = self.extent();
        let mut parts = TileParts::default();
        dispatch!(level, simd => {
            parts.divide(simd, 0, &group, &blocks, 1e30);
            parts.finish(simd, &mut extent);
        });
        let mut set_up = SetUp::EMPTY;
        let around = self.fill(&mut set_up, &extent);
        let mut seen = SeenPixels::default();
        seen.resize(64, 64);
        let [part] = &parts.parts[..] else { panic!("one part") };
        let points = TilePoints::new(0, &blocks, &seen.triangle);
        std::array::from_fn(|triangle| {
            dispatch!(level, simd => {
                let mut queue = [0; QUEUE];
                let end = enqueue(simd, &set_up, part, 1 << triangle, &mut queue);
                let is_queued = queue[..end].contains(&((triangle * LANES + triangle) as u32));
                let of_slot = (part.blocks[triangle], !part.points[triangle]);
                let found = points.test(simd, &set_up.quads(triangle), triangle as u32, of_slot);
                let inside = points.inside(simd, part.blocks[triangle], &SplatBox::new(simd, &around));
                let certain = found.certain(simd, set_up.errors(triangle));
                for lane in 0..LANES {
                    let (point, own) = points.point(part.blocks[triangle], lane);
                    let by_point = set_up.test_point(simd, &IDS, point, own).map(|found| found >> triangle & 1);
                    let by_triangle = [found.possible, certain].map(|found| found >> lane & set_up.there >> triangle & 1);
                    assert_eq!(by_point, by_triangle, "triangle {triangle}, point {lane}");
                }
                if is_queued { [found.possible & inside, certain] } else { [0; 2] }
            })
        })
    }
}

impl AimedBlocks {
    fn new(mut random: Random, level: SimdLevel) -> Self {
        let is_parallel = random.unit() < 0.5;
        let depth = if is_parallel { random.signed() } else { random.power(-3.0, 0.0) };
        let origin = DVec3::new(random.signed(), random.signed(), depth).as_vec3().as_dvec3();
        let mut error = |most: f64| if random.unit() < 0.5 { 0.0 } else { most * random.power(-6.0, 0.0) };
        let errors = [error(1.0 / 4096.0), error(depth.abs() * 0.01)].map(|error| f64::from(error as f32));
        let (size, away) = (random.power(-8.0, 0.0), random.power(-8.0, 2.0).min(3.0));
        // Thin ones whose area is as small as the errors, in between.
        let thin = 16.0 * HALF_ULP * (1.0 + away) * random.unit() / size;
        let aspect = [1.0, random.power(-7.0, 0.0), thin][(random.unit() * 3.0) as usize];
        let rise = random.power(-7.0, -0.6);
        let face = Face { x: DVec3::X, y: DVec3::Y, z: DVec3::Z, is_parallel, ..Face::default() };
        let one_sided = if random.unit() < 0.5 { (random.unit() * 65536.0) as u16 } else { 0 };
        let filled = if random.unit() < 0.2 { u16::MAX >> (random.unit() * 16.0) as u32 } else { u16::MAX };
        let trial = Self { random, level, face, origin, size, away, aspect, rise, errors, one_sided, filled };
        trial.tiny_or_not()
    }

    /// Makes one of sixteen so small that products of coordinates are among the least of f32.
    fn tiny_or_not(mut self) -> Self {
        if self.random.unit() < 0.06 {
            let size = self.random.power(-40.0, -37.0);
            let error = self.random.power(-44.5, -43.0) / size;
            let origin = DVec3::ZERO.with_z(self.origin.z);
            Self { origin, size, away: 0.0, aspect: 1.0, errors: [f64::from(error as f32), self.errors[1]], ..self }
        } else {
            self
        }
    }

    fn corners(&mut self) -> Corners {
        let Self { random, origin, size, away, aspect, rise, .. } = self;
        let mut flat = |size: f64| DVec3::new(random.signed() * size, random.signed() * size, 0.0);
        let middle = *origin + flat(*away);
        let (a, b) = (middle + flat(*size), middle + flat(*size));
        let along = random.unit() * 1.5 - 0.25;
        let height = (b - a).cross(DVec3::Z) * (*aspect * random.signed());
        let depth = if self.face.is_parallel { origin.z + *away * random.signed() } else { random.power(-3.0, 0.0) };
        let scale = if self.face.is_parallel { *rise } else { depth * *rise };
        let mut rises = [(); 3].map(|()| scale * random.signed());
        // In thin ones that rise along their length alone, roundings are all that slopes are across.
        if random.unit() < 0.3 {
            rises[2] = rises[0] + (rises[1] - rises[0]) * along;
        }
        let corners = [a, b, a + (b - a) * along + height];
        std::array::from_fn(|corner| {
            corners[corner].clamp(DVec3::splat(-2.0), DVec3::splat(2.0)).with_z(depth + rises[corner])
        })
    }

    /// The predicate's further demands are checked by `predicate`, not here.
    fn setting<'a>(&self, face: &'a Face, vertex_errors: &'a VertexErrors, vertices: &'a [[f32; 4]]) -> Setting<'a> {
        let Self { level, one_sided, filled, .. } = *self;
        let (origin, errors) = (self.origin.as_vec3().to_array(), self.errors.map(|error| error as f32));
        Setting { level, face, vertex_errors, origin, errors, one_sided, filled, vertices }
    }

    /// A corner's computed coordinates.
    fn vertex(&mut self, corner: DVec3) -> [f32; 4] {
        let of_depth = if self.face.is_parallel { 1.0 } else { corner.z };
        let wrong = if self.size < 1e-20 { 0.0 } else { HALF_ULP / 8.0 };
        let mut error = |size: f64| self.random.signed() * size * wrong;
        [corner.x + error(1.0), corner.y + error(1.0), corner.z + error(of_depth), 0.0].map(|number| number as f32)
    }

    /// Points as they are found, in relation to the origin: all about as far inside or outside of an edge, around a corner,
    /// or anywhere, and about as far above the plane or below.
    fn points(&mut self, corners: Corners, [edge_error, depth_error]: [f64; 2]) -> [[f32; 3]; LANES] {
        let Self { random, origin, size, errors: [position, _], .. } = self;
        let beyond =
            |random: &mut Random| DVec3::new(random.signed(), random.signed(), 0.0).signum().with_z(0.0) * *position;
        let first = (random.unit() * 3.0) as usize;
        let [from, to, _] = std::array::from_fn(|corner| corners[(first + corner) % 3]);
        let middle = (corners[0] + corners[1] + corners[2]) / 3.0;
        let highest = corners.map(|corner| corner.z).into_iter().fold(f64::NEG_INFINITY, f64::max);
        let along = (to - from).with_z(0.0);
        let beside = along.cross(DVec3::Z) * (edge_error / along.length_squared().max(1e-40));
        let depth_error = if depth_error < 1e30 { depth_error } else { highest.abs() * HALF_ULP };
        let [aim, nearness] = [random.unit() * 3.0, random.unit() * 3.0].map(|side| side.floor() - 1.0);
        let (is_corner, depth) = (random.unit() < 0.3, random.unit());
        let farthest = random.power(-9.0, 0.0);
        std::array::from_fn(|_| {
            let at = if is_corner {
                from + (middle - from) * (farthest * random.unit()) + beside * (aim * random.unit())
            } else {
                let at = from + (to - from) * random.unit() + beside * (aim + random.signed()) * 1.5;
                if aim == 0.0 { at.lerp(middle, random.unit()) } else { at }
            };
            let at = if *size < 1e-20 { at + beyond(random) } else { at };
            let (_, above) = functions(corners, at.with_z(0.0));
            let plane = if above.is_finite() && above < highest && depth < 0.8 { above } else { highest };
            let at = at.with_z(plane + depth_error * (nearness + random.signed()) * 1.5);
            (at - *origin).as_vec3().to_array()
        })
    }

    /// A triangle whose bounds don't reach a found position of a point beyond a corner, or whose group's don't reach all
    /// positions in real numbers; `None` if all do.
    fn short_bound(&mut self) -> Option<String> {
        let triangles: [Corners; LANES] = std::array::from_fn(|_| self.corners());
        let vertices: Vec<_> = triangles.as_flattened().iter().map(|&corner| self.vertex(corner)).collect();
        let [origin, error] = [self.origin, DVec3::new(self.errors[0], self.errors[0], self.errors[1])];
        let (face, vertex_errors) = (self.face, VertexErrors::default());
        let setting = Setting { one_sided: 0, ..self.setting(&face, &vertex_errors, &vertices) };
        let mut set_up = SetUp::EMPTY;
        let of_group = setting.fill(&mut set_up, &setting.extent());
        (0..LANES).filter(|&triangle| self.filled >> triangle & 1 == 1).find_map(|triangle| {
            let of_triangle = set_up.bounds.get(triangle);
            triangles[triangle].into_iter().find_map(|corner| {
                let ends = [corner - origin - error, corner - origin + error];
                // The farthest f32 that a point at the corner may be found at, on either side, and where a bound that is
                // grown by the error ends.
                let found = [-ends[0], ends[1]].map(|end| Vec3::from(end.to_array().map(below)).as_dvec3());
                let grown = [-found[0] + error, found[1] - error].map(|end| end.as_vec3().as_dvec3());
                let are_reached = reaches(&of_triangle, grown) && reaches(&of_group, ends);
                (!are_reached).then(|| format!("{corner} from {origin} ±{error}: {of_triangle:?}, {of_group:?}"))
            })
        })
    }

    /// The numbers of points found shadowed, not shadowed and undecided.
    fn run(&mut self) -> [u32; 3] {
        let triangles: [Corners; LANES] = std::array::from_fn(|_| self.corners());
        let vertices: Vec<_> = triangles.as_flattened().iter().map(|&corner| self.vertex(corner)).collect();
        let (face, vertex_errors) = (self.face, VertexErrors::default());
        let setting = self.setting(&face, &vertex_errors, &vertices);
        let mut set_up = SetUp::EMPTY;
        setting.fill(&mut set_up, &setting.extent());
        let points = std::array::from_fn(|triangle| {
            self.points(triangles[triangle], set_up.errors(triangle).map(|twice| f64::from(twice) / 2.0))
        });
        self.check(&triangles, &points, &setting.decide(&points))
    }

    fn check(
        &self,
        triangles: &[Corners; LANES],
        points: &[[[f32; 3]; LANES]; LANES],
        decisions: &Decisions,
    ) -> [u32; 3] {
        let mut counts = [0; 3];
        for (triangle, &corners) in triangles.iter().enumerate() {
            let [possible, certain] = decisions[triangle];
            let shows_back = area(corners) * f64::from(self.face.sign_of_fronts()) < 0.0;
            let is_there = !(shows_back && self.one_sided >> triangle & 1 == 1) && self.filled >> triangle & 1 == 1;
            for (lane, point) in points[triangle].iter().enumerate() {
                let found = self.origin + DVec3::from(point.map(f64::from));
                let (is_possible, is_certain) = (possible >> lane & 1 == 1, certain >> lane & 1 == 1);
                counts[if is_certain { 0 } else { 1 + usize::from(is_possible) }] += 1;
                for shadowed in self.truths(corners, found) {
                    let shadowed = if is_there { shadowed } else { Some(false) };
                    let about =
                        || format!("{corners:?} at {found}, in relation to {}, ±{:?}", self.origin, self.errors);
                    assert!(is_possible || shadowed != Some(true), "ruled out: {}", about());
                    assert!(!is_certain || shadowed != Some(false), "certain: {}", about());
                }
            }
        }
        counts
    }

    /// Whether a triangle shadows the points that may have been found as `found`; `None` where f64 can't say.
    fn truths(&self, corners: Corners, found: DVec3) -> impl Iterator<Item = Option<bool>> {
        const ROUNDED: f64 = 4e-15;
        let [position, nearness] = self.errors;
        let [a, b, c] = corners.map(DVec3::truncate);
        let girth = (b - a).abs().max((c - a).abs()).element_sum();
        let depths = corners.map(|corner| corner.z);
        let depth = depths.into_iter().fold(0.0_f64, |most, depth| most.max((depth - depths[0]).abs()));
        // Where all is tiny, so are the roundings of f64.
        let of_edges = ROUNDED * girth * if self.size < 1e-20 { self.size } else { 1.0 };
        let of_weights = of_edges / area(corners).abs();
        let signs = [[0.0; 3], [1.0, 1.0, 1.0], [-1.0, 1.0, -1.0], [1.0, -1.0, -1.0], [-1.0, -1.0, 1.0]];
        signs.into_iter().chain(signs.map(|[x, y, z]| [x, y, -z])).map(move |signs| {
            let point = found + DVec3::from(signs) * DVec3::new(position, position, nearness);
            let (edges, nearer) = functions(corners, point);
            let least = edges.into_iter().fold(f64::INFINITY, f64::min);
            let of_depth = (of_weights * depth + ROUNDED) * 4.0;
            if least > of_edges && nearer > of_depth {
                Some(true)
            } else if least < -of_edges || nearer < -of_depth {
                Some(false)
            } else {
                None
            }
        })
    }
}

/// Whether bounds hold the lowest and the highest position of a point.
fn reaches(&FaceBox { x, y, nearness }: &FaceBox, [low, high]: [DVec3; 2]) -> bool {
    let [x, y] = [x, y].map(|range| range.map(f64::from));
    low.x >= x[0] && low.y >= y[0] && high.x <= x[1] && high.y <= y[1] && high.z <= f64::from(nearness)
}

/// The largest f32 that isn't above a number.
fn below(number: f64) -> f32 {
    let nearest = number as f32;
    if f64::from(nearest) > number { nearest.next_down() } else { nearest }
}

#[test]
fn bounds_reach_what_may_be_found_of_their_corners() {
    let levels = SimdLevel::available();
    let of_trial =
        |seed: u32| AimedBlocks::new(Random::new(seed.into()), levels[seed as usize % levels.len()]).short_bound();
    let short = (0..TRIALS).into_par_iter().find_map_first(of_trial);
    assert_eq!(short, None);
}

#[test]
fn what_the_filter_decides_is_so() {
    let levels = SimdLevel::available();
    let of_trial = |seed: u32| AimedBlocks::new(Random::new(seed.into()), levels[seed as usize % levels.len()]).run();
    let counts = (0..TRIALS).into_par_iter().map(of_trial).collect::<Vec<_>>();
    let counts = counts.into_iter().fold([0; 3], |sum, one| std::array::from_fn(|verdict| sum[verdict] + one[verdict]));
    let all = TRIALS * (LANES * LANES) as u32;
    assert!(counts.iter().all(|&count| count > all / 100), "shadowed, not, not decided: {counts:?}");
}
