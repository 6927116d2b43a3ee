//! Masks: answers are those among the triangles that are left when hidden ones are taken out of the mesh.

use glam::{DVec3, Vec3};
use umbrage_rays::predicate::{ShadowRay, hit};
use umbrage_rays::{
    Camera, DirectGrids, Hit, LightSource, Lit, LitBits, Masks, Opaque, Ray, RayMasks, Receivers, Scan, Scanned,
    Scanner, SeenPixels, Shot, SimdLevel, Structure as _, Sweep, Trace, TracedBy, Tracer, View,
};

use crate::support::{Mesh, Random, blocked_by_any, is_usable, nearest_of_all, scene};

/// Masks of rays: everything, some bits, and nothing.
const RAY_MASKS: [u32; 5] = [u32::MAX, 0b1, 0b10, 0b110, 0];

/// One frame: a mesh, and a mask for each triangle but perhaps the last ones.
struct Frame {
    mesh: Mesh,
    masks: Vec<u32>,
}

/// A mesh without the triangles that a ray mask hides.
struct Left {
    mesh: Mesh,
    /// The ids of its triangles in the whole mesh.
    ids: Vec<u32>,
}

impl Frame {
    /// A sensor's housing around the origin, in a scene that is elsewhere in each frame. Masks are those of whole objects,
    /// or of each triangle.
    fn new(number: usize, random: &mut Random) -> Self {
        let offset = Vec3::new(0.1, 0.0, 0.05 * number as f32);
        let mut mesh = scene(&mut Random(5)).moved(1.0 + 0.1 * number as f32, offset);
        let others = mesh.indices.len();
        mesh.append(&Mesh::bumpy_ball(Vec3::ZERO, 0.2, 6));
        let mut any = || [0, 0b1, 0b10, 0b100, 0b111, u32::MAX][(random.bits() % 6) as usize];
        let masks = match number {
            0 => vec![0b10; others],
            1 => (0..mesh.indices.len()).map(|id| if id < others { 0b11 } else { 0b100 }).collect(),
            _ => (0..mesh.indices.len()).map(|_| any()).collect(),
        };
        Self { mesh, masks }
    }

    fn sees(&self, ray_mask: u32, id: u32) -> bool {
        self.masks.get(id as usize).is_none_or(|mask| mask & ray_mask != 0) && ray_mask != 0
    }

    fn left(&self, ray_mask: u32) -> Left {
        let ids: Vec<u32> = (0..self.mesh.indices.len() as u32).filter(|&id| self.sees(ray_mask, id)).collect();
        let indices = ids.iter().map(|&id| self.mesh.indices[id as usize]).collect();
        Left { mesh: Mesh { positions: self.mesh.positions.clone(), indices }, ids }
    }
}

/// Triangle, t and weights of a hit, bit for bit.
type Bits = (u32, u64, [u32; 2]);

fn bits(Hit { triangle, t, barycentric }: Hit) -> Bits {
    (triangle, t.to_bits(), barycentric.map(f32::to_bits))
}

impl Left {
    /// A hit by the id that its triangle has in the whole mesh.
    fn bits(&self, hit: Hit) -> Bits {
        bits(Hit { triangle: self.ids[hit.triangle as usize], ..hit })
    }

    fn nearest(&self, ray: &Ray) -> Option<Bits> {
        nearest_of_all(self.mesh.triangles(), ray, |_| true).map(|hit| self.bits(hit))
    }

    /// The first hits of a ray.
    fn first(&self, ray: &Ray, most: usize) -> Vec<Bits> {
        let triangles = self.mesh.triangles();
        let ids = (0..triangles.len() as u32).filter(|&id| is_usable(triangles, id));
        let mut hits: Vec<Hit> = ids.filter_map(|id| hit(ray, triangles, id)).collect();
        hits.sort_by(|a, b| a.t.total_cmp(&b.t).then(a.triangle.cmp(&b.triangle)));
        hits.into_iter().take(most).map(|hit| self.bits(hit)).collect()
    }
}

/// Inside of the housing, and outside of everything.
const ORIGINS: [DVec3; 2] = [DVec3::ZERO, DVec3::new(4.0, 3.0, -5.0)];

fn directions(origin: DVec3, random: &mut Random, count: usize) -> Vec<Vec3> {
    (0..count).map(|_| random.point() * 2.0 - origin.as_vec3()).collect()
}

#[test]
fn rays_pass_what_their_masks_hide() {
    let mut random = Random(81);
    let mut by = [0, 0];
    for level in SimdLevel::available() {
        let mut tracer = Tracer::with_level(level);
        for number in 0..4 {
            let frame = Frame::new(number, &mut random);
            tracer.forget();
            let (mut rays, mut ray_masks, mut expected) = (Vec::new(), Vec::new(), Vec::new());
            for (origin, mask) in ORIGINS.into_iter().flat_map(|origin| RAY_MASKS.map(|mask| (origin, mask))) {
                let left = frame.left(mask);
                for direction in directions(origin, &mut random, 500) {
                    let ray = Ray::new(origin, direction.as_dvec3());
                    expected.push(left.nearest(&ray));
                    rays.push(ray);
                    ray_masks.push(mask);
                }
            }
            let mut check = |order: &[usize]| {
                let these: Vec<Ray> = order.iter().map(|&index| rays[index]).collect();
                let of_these: Vec<u32> = order.iter().map(|&index| ray_masks[index]).collect();
                let masks = Masks { triangles: &frame.masks, rays: RayMasks::Each(&of_these) };
                let trace = Trace { masks, ..Trace::new(frame.mesh.triangles(), &these) };
                let mut traced = Scanned::default();
                let structure = tracer.trace(&trace, &mut traced);
                for (index, &of) in order.iter().enumerate() {
                    let found = traced.hits(index).next().map(bits);
                    assert_eq!(found, expected[of], "{:?} with {:b}, frame {number}", rays[of], ray_masks[of]);
                }
                by[usize::from(structure == TracedBy::Scanner)] += 1;
            };
            check(&(0..rays.len()).collect::<Vec<_>>());
            // Neighbours with other masks.
            check(&(0..rays.len()).map(|index| index * 997 % rays.len()).collect::<Vec<_>>());
        }
    }
    assert!(by[0] > 0 && by[1] > 0, "{by:?} by hierarchy and scanner");
}

#[test]
fn scans_pass_what_their_masks_hide() {
    const RETURNS: usize = 3;
    let mut random = Random(82);
    let mut hits = 0;
    for level in SimdLevel::available() {
        let mut scanner = Scanner::with_level(level);
        for number in 0..4 {
            let frame = Frame::new(number, &mut random);
            let triangles = frame.mesh.triangles();
            scanner.build(triangles);
            let ray_masks: Vec<u32> = ORIGINS.iter().flat_map(|_| RAY_MASKS).collect();
            let origins = || ORIGINS.iter().flat_map(|&origin| RAY_MASKS.map(|_| origin));
            let each: Vec<Vec<Vec3>> = origins().map(|origin| directions(origin, &mut random, 300)).collect();
            let sweeps: Vec<Sweep<'_>> =
                origins().zip(&each).map(|(origin, directions)| Sweep { origin, directions }).collect();
            let masks = Masks { triangles: &frame.masks, rays: RayMasks::Each(&ray_masks) };
            let scan = Scan { masks, ..Scan::new(triangles, &sweeps) };
            let (mut first, mut several, mut any) = (Scanned::default(), Scanned::default(), Vec::new());
            scanner.scan(&scan, 1, &mut first);
            scanner.scan(&scan, RETURNS, &mut several);
            scanner.hits_any(&scan, &mut any);
            let mut index = 0;
            for (sweep, &mask) in sweeps.iter().zip(&ray_masks) {
                let left = frame.left(mask);
                for direction in sweep.directions {
                    let expected = left.first(&Ray::new(sweep.origin, direction.as_dvec3()), RETURNS);
                    let name = || format!("{direction} with {mask:b}, frame {number}");
                    assert_eq!(several.hits(index).map(bits).collect::<Vec<_>>(), expected, "{}", name());
                    assert_eq!(first.hits(index).next().map(bits), expected.first().copied(), "{}", name());
                    assert_eq!(any[index / 64] >> (index % 64) & 1 == 1, !expected.is_empty(), "{}", name());
                    hits += expected.len();
                    index += 1;
                }
            }
        }
    }
    assert!(hits > 20_000, "{hits} hits");
}

#[test]
fn light_passes_what_its_mask_hides() {
    let mut random = Random(83);
    let suns = [Vec3::NEG_Y, Vec3::new(0.3, -1.0, 0.2), Vec3::new(-1.0, 0.1, 0.4)];
    let suns = suns.map(|direction| LightSource::Directional { direction });
    let points = [Vec3::ZERO, Vec3::new(0.5, 2.5, -0.3)].map(|position| LightSource::Point { position });
    let lights: Vec<LightSource> = suns.into_iter().chain(points).collect();
    let mut counts = [0, 0];
    for level in SimdLevel::available() {
        let mut scanner = Scanner::with_level(level);
        for number in 0..4 {
            let frame = Frame::new(number, &mut random);
            let triangles = frame.mesh.triangles();
            let (mut positions, mut own) = (Vec::new(), Vec::new());
            for id in (0..triangles.len() as u32).filter(|&id| is_usable(triangles, id)) {
                let [a, b, c] = triangles.corners(id);
                positions.extend([a.lerp(b, random.unit()).lerp(c, random.unit()), random.point() * 2.0]);
                own.extend([id, Scanned::NONE]);
            }
            scanner.build(triangles);
            let receivers = Receivers::Points { positions: &positions, own: &own };
            // Lights with the same mask, and each with its own.
            let ray_masks: Vec<u32> = (number..).take(lights.len()).map(|of| RAY_MASKS[of % RAY_MASKS.len()]).collect();
            for rays in [RayMasks::All(0b1), RayMasks::Each(&ray_masks)] {
                let masks = Masks { triangles: &frame.masks, rays };
                let (lit, mut found) = (Lit { masks, ..Lit::new(triangles, receivers) }, LitBits::default());
                scanner.lit(&lit, &lights, &mut found);
                for (light, source) in lights.iter().enumerate() {
                    let left = frame.left(masks.of_ray(light));
                    for (point, &own) in own.iter().enumerate() {
                        let (at, _) = receivers.point(triangles, point).expect("a finite point");
                        let own = left.ids.binary_search(&own).map_or(u32::MAX, |own| own as u32);
                        let ray = ShadowRay::new(source, at);
                        let expected = !blocked_by_any(left.mesh.triangles(), &ray, own, |_, _| true);
                        assert_eq!(
                            found.is_lit(light, point),
                            expected,
                            "{source:?}, {at:?}, frame {number}, {rays:?}"
                        );
                        counts[usize::from(expected)] += 1;
                    }
                }
            }
        }
    }
    assert!(counts[0] > 5_000 && counts[1] > 5_000, "{counts:?} dark and lit");
}

/// Shots have no masks of their own, but their opacity may.
#[test]
fn cameras_see_through_what_a_mask_hides() {
    let mut random = Random(84);
    let camera = Camera::look_at(Vec3::new(0.05, 0.1, 0.0), Vec3::new(1.0, -0.2, 0.4), Vec3::Y, 1.2);
    let view = View { camera, width: 75, height: 50 };
    for level in SimdLevel::available() {
        let (mut grids, mut expected) = (DirectGrids::with_level(level), DirectGrids::default());
        for number in 0..4 {
            let frame = Frame::new(number, &mut random);
            let triangles = frame.mesh.triangles();
            grids.build(triangles);
            for mask in RAY_MASKS {
                let masks = Masks { triangles: &frame.masks, rays: RayMasks::All(mask) };
                let (mut seen, mut of_left) = (SeenPixels::default(), SeenPixels::default());
                let opacity = &masks.opacity(mask, &Opaque);
                grids.see(&Shot { opacity, ..Shot::new(triangles, view) }, &mut seen).expect("a small image");
                let left = frame.left(mask);
                expected.build(left.mesh.triangles());
                expected.see(&Shot::new(left.mesh.triangles(), view), &mut of_left).expect("a small image");
                for (x, y) in (0..view.height).flat_map(|y| (0..view.width).map(move |x| (x, y))) {
                    let truth = of_left.triangle_at(x, y);
                    let truth = left.ids.get(truth as usize).copied().unwrap_or(SeenPixels::NONE);
                    assert_eq!(seen.triangle_at(x, y), truth, "({x}, {y}) with {mask:b}, frame {number}");
                }
            }
        }
    }
}
