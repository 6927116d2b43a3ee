//! Structures with every pair of values of any two options, over a few frames, against the predicate asked about every
//! triangle. Rows that are chosen by hand leave out most pairs; faults that need three options are rarer.

use glam::Vec3;
use umbrage_rays::predicate::{HitPoint, ShadowRay};
use umbrage_rays::{
    Camera, Cone, LightMask, LightSource, Parts, Projection, SeenPixels, Shot, Sides, SimdLevel, Structure, View,
};

use super::{Mesh, Random, blocked_by_any, nearest_of_all};

/// Rows of values, one for each option, such that each pair of values of any two options is in some row. Each row is the
/// best of a few, whose values are chosen one after the other to bring the most new pairs.
pub(crate) fn covering(counts: &[usize]) -> Vec<Vec<usize>> {
    const TRIED: usize = 12;
    let starts: Vec<usize> =
        counts.iter().scan(0, |next, count| Some(std::mem::replace(next, *next + count))).collect();
    let all: usize = counts.iter().sum();
    let mut is_missing = vec![false; all * all];
    let at = |(a, x): (usize, usize), (b, y): (usize, usize)| (starts[a] + x) * all + starts[b] + y;
    let mut missing = 0;
    for (a, &of_a) in counts.iter().enumerate() {
        for (b, &of_b) in counts.iter().enumerate().filter(|(b, _)| *b != a) {
            for (x, y) in (0..of_a).flat_map(|x| (0..of_b).map(move |y| (x, y))) {
                is_missing[at((a, x), (b, y))] = true;
                missing += 1;
            }
        }
    }
    let (mut random, mut rows) = (Random(71), Vec::new());
    while missing > 0 {
        let mut best = (0, Vec::new());
        for _ in 0..TRIED {
            let mut order: Vec<usize> = (0..counts.len()).collect();
            (1..order.len()).for_each(|index| order.swap(index, (random.bits() % (index as u64 + 1)) as usize));
            let (mut row, mut gained) = (vec![0; counts.len()], 0);
            for (place, &option) in order.iter().enumerate() {
                let gain = |value: usize| {
                    let before =
                        order[..place].iter().filter(|&&other| is_missing[at((option, value), (other, row[other]))]);
                    let later = order[place + 1..]
                        .iter()
                        .any(|&other| (0..counts[other]).any(|y| is_missing[at((option, value), (other, y))]));
                    (before.count(), later)
                };
                // Not always the first of equal ones.
                let turn = random.bits() as usize % counts[option];
                let values = (0..counts[option]).map(|value| (value + turn) % counts[option]);
                let value = values.max_by_key(|&value| gain(value)).expect("a value");
                gained += gain(value).0;
                row[option] = value;
            }
            if gained > best.0 || best.1.is_empty() {
                best = (gained, row);
            }
        }
        let (gained, row) = best;
        assert!(gained > 0, "a row without a new pair");
        for (a, b) in (0..row.len()).flat_map(|a| (0..row.len()).map(move |b| (a, b))).filter(|(a, b)| a != b) {
            missing -= usize::from(std::mem::take(&mut is_missing[at((a, row[a]), (b, row[b]))]));
        }
        rows.push(row);
    }
    rows
}

/// A row's values, handed out option by option.
pub(crate) struct Row<'a> {
    values: &'a [usize],
    next: usize,
    /// The number of values of each option, noted as they are handed out.
    counts: Vec<usize>,
    text: String,
}

impl Row<'_> {
    /// The row's value of an option.
    pub(crate) fn pick<T: Copy + std::fmt::Debug>(&mut self, option: &str, values: &[T]) -> T {
        let value = values[self.values.get(self.next).copied().unwrap_or(0)];
        self.next += 1;
        self.counts.push(values.len());
        self.text += &format!("{option} {value:?}, ");
        value
    }
}

/// The number of values of each option that `make` picks.
fn counts<T>(make: &impl Fn(&mut Row<'_>) -> T) -> Vec<usize> {
    let mut row = Row { values: &[], next: 0, counts: Vec::new(), text: String::new() };
    make(&mut row);
    row.counts
}

/// Sides that differ from triangle to triangle.
const EACH: Sides<'static> = Sides::Each(&[0x5bd1_e995_cc9e_2d51; 8]);

/// Options of a question, which every structure has.
#[derive(Clone, Copy)]
struct Asked {
    level: SimdLevel,
    sides: usize,
    threads: usize,
    is_parallel: bool,
}

const SIDES: [Sides<'static>; 3] = [Sides::Both, Sides::Front, EACH];

fn asked(row: &mut Row<'_>) -> Asked {
    Asked {
        level: row.pick("SIMD level", &SimdLevel::available()),
        sides: row.pick("sides", &[0, 1, 2]),
        threads: row.pick("threads", &[1, 2, 5]),
        is_parallel: row.pick("parallel camera", &[false, true]),
    }
}

/// Three frames of the same triangles, some of which move as bodies and some don't, and one frame of other triangles.
fn frames() -> Vec<Mesh> {
    let mut random = Random(72);
    let mut rest = Mesh::soup(&mut random, 40, 0.05);
    rest.append(&Mesh::bumpy_ball(Vec3::new(0.3, 0.2, 0.0), 0.8, 5));
    rest.append(&Mesh::floor(3, 3.0).moved(1.0, Vec3::NEG_Y));
    let at = |time: f32| {
        let mut mesh = rest.clone();
        for (vertex, position) in mesh.positions.iter_mut().enumerate() {
            match vertex % 240 / 60 {
                0 => *position += Vec3::new(0.4, -0.3, 0.2) * time,
                1 => *position *= 1.0 + 0.5 * time * (position.x * 3.0).sin(),
                _ => {}
            }
        }
        mesh
    };
    let mut other = at(0.5);
    other.indices.truncate(90);
    other.positions[7].y = f32::NAN;
    vec![at(0.0), at(1.0), at(2.0), other]
}

const LIGHTS: [LightSource; 3] = [
    LightSource::Point { position: Vec3::new(2.0, 3.0, -1.0) },
    LightSource::Directional { direction: Vec3::new(0.3, -1.0, -0.2) },
    LightSource::Spot {
        position: Vec3::new(0.5, 2.5, 1.0),
        direction: Vec3::new(-0.1, -1.0, -0.3),
        inner_radians: 0.3,
        outer_radians: 0.6,
    },
];

const SIZE: [u32; 2] = [18, 13];

fn shot(mesh: &Mesh, sides: usize, is_parallel: bool) -> Shot<'_> {
    let camera = Camera::look_at(Vec3::new(1.0, 1.5, 4.0), Vec3::new(0.0, -0.2, 0.0), Vec3::Y, 0.8);
    let projection = if is_parallel { Projection::Orthographic { half_height: 1.7 } } else { camera.projection };
    let view = View { camera: Camera { projection, ..camera }, width: SIZE[0], height: SIZE[1] };
    Shot { sides: SIDES[sides], ..Shot::new(mesh.triangles(), view) }
}

/// The expected answer for each pixel: its triangle, and whether each light reaches it.
type Truth = Vec<(u32, [bool; LIGHTS.len()])>;

fn truth(shot: &Shot<'_>) -> Truth {
    let triangles = shot.triangles;
    let pixel = |index: u32| {
        let ray = shot.ray(index % SIZE[0], index / SIZE[0]);
        let stops = |hit: &umbrage_rays::Hit| shot.sides.stop(&ray, hit.triangle, triangles.corners(hit.triangle));
        let Some(hit) = nearest_of_all(triangles, &ray, stops) else {
            return (SeenPixels::NONE, [false; LIGHTS.len()]);
        };
        let is_lit = LIGHTS.map(|light| {
            let shadow_ray = ShadowRay::new(&light, HitPoint::new(&ray, hit.t));
            let stops = |id: u32, _| {
                // Sides depend on the direction of light: along the shadow ray, or against it for parallel light.
                let is_parallel = matches!(light, LightSource::Directional { .. });
                let direction = shadow_ray.ray.direction * if is_parallel { -1.0 } else { 1.0 };
                let ray = umbrage_rays::Ray { direction, ..shadow_ray.ray };
                shot.sides.stop(&ray, id, triangles.corners(id))
            };
            Cone::of(&light).is_none_or(|cone| cone.contains(shadow_ray.point()))
                && !blocked_by_any(triangles, &shadow_ray, hit.triangle, stops)
        });
        (hit.triangle, is_lit)
    };
    (0..SIZE[0] * SIZE[1]).map(pixel).collect()
}

/// Compares the structure of each row with the expected answers for all frames.
pub(crate) fn check(structure: impl Fn(&mut Row<'_>, SimdLevel) -> Box<dyn Structure>) {
    let frames = frames();
    let cases = || (0..SIDES.len()).flat_map(|sides| [false, true].map(|is_parallel| (sides, is_parallel)));
    let truths: Vec<Vec<Truth>> = cases()
        .map(|(sides, is_parallel)| frames.iter().map(|mesh| truth(&shot(mesh, sides, is_parallel))).collect())
        .collect();
    let pool = |threads| rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
    let pools = [1, 2, 5].map(|threads| (threads, pool(threads)));
    let make = |row: &mut Row<'_>| {
        let asked = asked(row);
        (asked, structure(row, asked.level))
    };
    for values in covering(&counts(&make)) {
        let mut row = Row { values: &values, next: 0, counts: Vec::new(), text: String::new() };
        let (Asked { sides, threads, is_parallel, .. }, mut structure) = make(&mut row);
        let (_, pool) = pools.iter().find(|(of_pool, _)| *of_pool == threads).expect("a pool");
        let case = cases().position(|case| case == (sides, is_parallel)).expect("a case");
        for (frame, (mesh, truth)) in frames.iter().zip(&truths[case]).enumerate() {
            let shot = shot(mesh, sides, is_parallel);
            let parts: Vec<u32> = (0..mesh.indices.len() as u32).map(|id| id / 20 % 3).collect();
            let (mut seen, mut masks) = (SeenPixels::default(), vec![LightMask::default(); LIGHTS.len()]);
            pool.install(|| {
                structure.build_parts(shot.triangles, Parts { of_triangle: &parts, objects: &[] });
                structure.see(&shot, &mut seen).expect("a small image");
                structure.shadow(&shot, &seen, &LIGHTS, &mut masks);
            });
            for (index, (triangle, is_lit)) in truth.iter().enumerate() {
                let (x, y) = (index as u32 % SIZE[0], index as u32 / SIZE[0]);
                let found = (seen.triangle_at(x, y), [0, 1, 2].map(|light: usize| masks[light].is_lit(x, y)));
                assert_eq!(found, (*triangle, *is_lit), "frame {frame}, pixel {x}, {y}: {}", row.text);
            }
        }
    }
}
