use std::ops::ControlFlow;

use fearless_simd::Simd;
use glam::Vec3;

use super::{InstanceTree, InstancedTriangles, Placement};
use crate::bvh::leaf::Leaf;
use crate::bvh::line::Line;
use crate::bvh::trace::{Corners, Stack, walk};
use crate::bvh::{Bvh, Node};
use crate::dispatch;
use crate::predicate::{ShadowRay, hit_of_near};
use crate::simd::lanes::bits_of;
use crate::{Hit, LightSource, LitBits, Ray, RayMasks, Rays, Receivers, Scanned, SingleRays};

/// The corners of a placed mesh in the world.
#[derive(Clone, Copy)]
struct Posed<'a> {
    placement: &'a Placement,
    first: u32,
}

impl Corners for Posed<'_> {
    #[inline(always)]
    fn triangle(&self, bvh: &Bvh, leaf: usize, lane: usize) -> (u32, [Vec3; 3]) {
        let leaf = &bvh.leaves[leaf];
        let lane = lane % Leaf::LANES;
        (self.first + leaf.ids[lane], leaf.corners(lane).map(|corner| self.placement.pose(corner)))
    }
}

/// The nearer of two hits; at equal t the one with the lower id.
fn nearer(hit: Option<Hit>, other: Option<Hit>) -> Option<Hit> {
    let key = |hit: &Hit| (hit.t, hit.triangle);
    match (hit, other) {
        (Some(a), Some(b)) => Some(if key(&a) < key(&b) { a } else { b }),
        (one, other) => one.or(other),
    }
}

/// A ray until a hit, and for hits at its t.
fn until(ray: &Ray, hit: Option<Hit>) -> Ray {
    Ray { t_max: hit.map_or(ray.t_max, |hit| hit.t.next_up()), ..*ray }
}

impl InstanceTree {
    /// The nearest hit of a ray with a mask, without the triangle `own`, for which `stops` is true; at equal t the one with the lowest id.
    /// `None` for a miss. See [`SingleRays::nearest_from`].
    ///
    /// # Panics
    /// If the scene isn't the one of the last build.
    #[must_use]
    pub fn nearest_from(
        &self,
        scene: &InstancedTriangles<'_>,
        (ray, mask): (&Ray, u32),
        own: u32,
        stops: &dyn Fn(&Hit) -> bool,
    ) -> Option<Hit> {
        self.expect(scene);
        if !ray.is_sound() {
            return None;
        }
        let Self { flattened, level, .. } = self;
        let among = flattened.hierarchy.nearest_from(flattened.triangles(), ray, flattened.own(own), &|hit| {
            let hit = flattened.hit(*hit);
            self.sees(scene, mask, hit.triangle) && stops(&hit)
        });
        let best = among.map(|hit| flattened.hit(hit));
        dispatch!(*level, simd => self.nearest_at(simd, scene, (ray, mask), own, stops, best))
    }

    #[inline(always)]
    fn nearest_at<S: Simd>(
        &self,
        simd: S,
        scene: &InstancedTriangles<'_>,
        (ray, mask): (&Ray, u32),
        own: u32,
        stops: &dyn Fn(&Hit) -> bool,
        mut best: Option<Hit>,
    ) -> Option<Hit> {
        let first = until(ray, best);
        let _ = self.visit(
            simd,
            scene,
            (&first, mask),
            #[inline(always)]
            |index| {
                let (placement, placed) = (&scene.placements[index], &self.placed[index]);
                let hierarchy = &self.meshes[placement.mesh as usize].hierarchy;
                let ray = until(ray, best);
                let corners = Posed { placement, first: placed.first };
                let hit = match placed.line(placement, &ray) {
                    Some(line) => {
                        // Wraps to an id that no leaf has.
                        let own = own.wrapping_sub(placed.first);
                        hierarchy.nearest_on(simd, &line, corners, &ray, own, stops)
                    }
                    None => nearest_of_all(hierarchy, corners, &ray, own, stops),
                };
                best = nearer(best, hit);
                ControlFlow::Continue(hit.map(|hit| hit.t))
            },
        );
        best
    }

    /// Whether any triangle but `own` for which `stops` is true shadows the point of a shadow ray with a mask. See
    /// [`SingleRays::blocked`].
    ///
    /// # Panics
    /// If the scene isn't the one of the last build.
    #[must_use]
    pub fn blocked(
        &self,
        scene: &InstancedTriangles<'_>,
        (shadow_ray, mask): (&ShadowRay, u32),
        own: u32,
        stops: &dyn Fn(u32, [f32; 2]) -> bool,
    ) -> bool {
        self.expect(scene);
        if !shadow_ray.ray.is_sound() {
            return false;
        }
        let Self { flattened, level, .. } = self;
        let by_flattened =
            flattened.hierarchy.blocked(flattened.triangles(), shadow_ray, flattened.own(own), &|triangle, weights| {
                let id = flattened.ids[triangle as usize];
                self.sees(scene, mask, id) && stops(id, weights)
            });
        by_flattened || dispatch!(*level, simd => self.blocked_at(simd, scene, (shadow_ray, mask), own, stops))
    }

    #[inline(always)]
    fn blocked_at<S: Simd>(
        &self,
        simd: S,
        scene: &InstancedTriangles<'_>,
        (shadow_ray, mask): (&ShadowRay, u32),
        own: u32,
        stops: &dyn Fn(u32, [f32; 2]) -> bool,
    ) -> bool {
        let visited = self.visit(
            simd,
            scene,
            (&shadow_ray.ray, mask),
            #[inline(always)]
            |index| {
                let (placement, placed) = (&scene.placements[index], &self.placed[index]);
                let hierarchy = &self.meshes[placement.mesh as usize].hierarchy;
                let corners = Posed { placement, first: placed.first };
                let blocks = |leaf: usize, lane: usize| {
                    let (id, corners) = corners.triangle(hierarchy, leaf, lane);
                    id != own && shadow_ray.blocked_by(corners).is_some_and(|weights| stops(id, weights))
                };
                let is_blocked = match placed.line(placement, &shadow_ray.ray) {
                    Some(line) => hierarchy
                        .visit(
                            simd,
                            (&line, &mut Stack::default()),
                            &mut line.far.clone(),
                            #[inline(always)]
                            |leaf, found, _| {
                                let is_blocked = bits_of(found.possible).any(|lane| blocks(leaf, lane));
                                if is_blocked { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
                            },
                        )
                        .is_break(),
                    None => hierarchy.slots().any(|(leaf, lane)| blocks(leaf, lane)),
                };
                if is_blocked { ControlFlow::Break(()) } else { ControlFlow::Continue(None) }
            },
        );
        visited.is_break()
    }

    /// Whether a ray with a mask sees the placement of a triangle.
    fn sees(&self, scene: &InstancedTriangles<'_>, mask: u32, id: u32) -> bool {
        scene.placements[self.of_triangle(id)[0] as usize].mask & mask != 0
    }

    /// Calls `test` with the index of each placement that a ray sees and whose box it enters, nearer ones first. It returns
    /// the t of a hit, after which no box matters, or breaks off.
    #[inline(always)]
    fn visit<S: Simd>(
        &self,
        simd: S,
        scene: &InstancedTriangles<'_>,
        (ray, mask): (&Ray, u32),
        mut test: impl FnMut(usize) -> ControlFlow<(), Option<f64>>,
    ) -> ControlFlow<()> {
        if self.nodes.is_empty() {
            return ControlFlow::Continue(());
        }
        let is_seen = |index: usize| scene.placements[index].mask & mask != 0;
        let Some(line) = Line::new(ray, 1.0) else {
            let is_there = |&index: &usize| {
                let mesh = &self.meshes[scene.placements[index].mesh as usize];
                !self.placed[index].is_flattened() && !mesh.hierarchy.nodes.is_empty() && is_seen(index)
            };
            let mut there = (0..self.placed.len()).filter(is_there);
            return there.try_for_each(|index| {
                test(index)?;
                ControlFlow::Continue(())
            });
        };
        let mut far = line.far;
        walk(
            simd,
            (self.nodes.as_slice(), self.root),
            (&line, &mut Stack::default()),
            &mut far,
            #[inline(always)]
            |index, _, far| {
                if is_seen(index)
                    && let Some(t) = test(index)?
                {
                    *far = far.min(line.at_least(t));
                }
                ControlFlow::Continue(())
            },
        )
    }

    /// # Panics
    /// If the scene has another number of placements.
    fn expect(&self, scene: &InstancedTriangles<'_>) {
        let (built, count) = (self.placed.len(), scene.placements.len());
        assert_eq!(built, count, "built for {built} placements, and asked about {count}");
    }

    /// Finds the first hit of each ray, with their masks; at equal t the one with the lowest id.
    ///
    /// `traced` has one hit for each ray, in their order. Rays whose direction is zero or not finite hit nothing and are
    /// counted in [`Scanned::without_direction`]. Rays whose origin isn't finite or whose interval is empty hit nothing
    /// either.
    ///
    /// # Panics
    /// If the scene isn't the one of the last build, or a ray has no mask.
    pub fn trace<'a>(
        &self,
        scene: &InstancedTriangles<'_>,
        rays: impl Into<Rays<'a>>,
        masks: RayMasks<'_>,
        traced: &mut Scanned,
    ) {
        self.expect(scene);
        let nearest =
            |index: usize, ray: &Ray| self.nearest_from(scene, (ray, masks.at(index)), Scanned::NONE, &|_| true);
        traced.fill_nearest(rays.into(), nearest);
    }

    /// Finds the points that each light, with its mask, reaches, as [`Scanner::lit`](crate::Scanner::lit) does.
    ///
    /// # Panics
    /// If the scene isn't the one of the last build, a light has no mask, or `own` of the points is neither empty nor as long
    /// as these.
    pub fn lit(
        &self,
        scene: &InstancedTriangles<'_>,
        receivers: Receivers<'_>,
        lights: &[LightSource],
        masks: RayMasks<'_>,
        bits: &mut LitBits,
    ) {
        self.expect(scene);
        let count = receivers.count_among(scene.len());
        let point = |index: usize| receivers.point_among(|id| self.usable_corners(scene, id), index);
        let is_blocked =
            |light: usize, ray: &ShadowRay, own: u32| self.blocked(scene, (ray, masks.at(light)), own, &|_, _| true);
        bits.fill(count, lights, point, is_blocked);
    }
}

impl Bvh {
    /// The leaf and the lane of all triangles.
    fn slots(&self) -> impl Iterator<Item = (usize, usize)> {
        self.nodes.iter().flat_map(Node::leaves).flat_map(|(leaf, lanes)| bits_of(lanes).map(move |lane| (leaf, lane)))
    }
}

#[cold]
fn nearest_of_all(
    hierarchy: &Bvh,
    corners: Posed<'_>,
    ray: &Ray,
    own: u32,
    stops: &dyn Fn(&Hit) -> bool,
) -> Option<Hit> {
    let hits = hierarchy.slots().filter_map(|(leaf, lane)| {
        let (id, corners) = corners.triangle(hierarchy, leaf, lane);
        hit_of_near(ray, corners, id).filter(|hit| id != own && stops(hit))
    });
    hits.fold(None, |best, hit| nearer(best, Some(hit)))
}
