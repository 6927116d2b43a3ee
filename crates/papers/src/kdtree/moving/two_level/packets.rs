//! Packets of rays go through the largest trees of objects that haven't moved; their rays go alone through the other trees.

use std::ops::ControlFlow;

use super::TwoLevelKdTree;
use crate::kdtree::packet::{NO_RAY, PacketRays, SQUARE_PIXELS};
use crate::single::{Visit, answers_single_rays};
use umbrage_rays::predicate::{HitPoint, ShadowRay};
use umbrage_rays::{Hit, LightSource, Ray, SimdLevel, SingleRays as _, Triangles};

impl TwoLevelKdTree {
    /// The largest number of trees that packets go through.
    const MOST_TOGETHER: usize = 4;

    /// The least number of triangles of such a tree.
    const LEAST_TOGETHER: usize = 256;

    /// Chooses the trees that packets go through.
    pub(super) fn choose_together(&mut self) {
        let (objects, together) = (&self.objects, &mut self.together);
        together.clear();
        together.extend((0..objects.len()).filter(|&index| {
            let object = &objects[index];
            object.is_in_place() && object.ids.len() >= Self::LEAST_TOGETHER && !object.extent.is_empty()
        }));
        together.sort_by_key(|&index| (usize::MAX - objects[index].ids.len(), index));
        together.truncate(Self::MOST_TOGETHER);
    }
}

/// The trees that packets don't go through.
struct Others<'a>(&'a TwoLevelKdTree);

answers_single_rays!(Others<'_>);

impl Visit for Others<'_> {
    fn visit(
        &self,
        triangles: Triangles<'_>,
        ray: &Ray,
        test: impl FnMut(u32, &mut f64) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        let is_other = |object: usize| !self.0.together.contains(&object);
        self.0.visit_some(triangles, ray, is_other, test)
    }
}

impl PacketRays for TwoLevelKdTree {
    fn level(&self) -> SimdLevel {
        self.level
    }

    fn nearest(&self, triangles: Triangles<'_>, rays: &[Ray], stops: impl Fn(&Hit) -> bool, hits: &mut [Option<Hit>]) {
        // Ends rays just beyond the nearest hit so far: at equal t the lowest id counts.
        let until = |ray: &Ray, hit: &Option<Hit>| {
            let t_max = hit.map_or(ray.t_max, |hit| hit.t.next_up());
            Ray { t_max, ..*ray }
        };
        let take = |hit: &mut Option<Hit>, found: Option<Hit>| {
            if let Some(found) = found
                && hit.is_none_or(|hit| (found.t, found.triangle) < (hit.t, hit.triangle))
            {
                *hit = Some(found);
            }
        };
        hits.fill(None);
        for &object in &self.together {
            let object = &self.objects[object];
            let in_frame = |hit: Hit| Hit { triangle: object.ids[hit.triangle as usize], ..hit };
            let mut own_rays = [NO_RAY; SQUARE_PIXELS];
            let mut found = [None; SQUARE_PIXELS];
            let (own_rays, found) = (&mut own_rays[..rays.len()], &mut found[..rays.len()]);
            for ((own, ray), hit) in own_rays.iter_mut().zip(rays).zip(&*hits) {
                *own = until(ray, hit);
            }
            object.tree.nearest_of_packet(object.of(triangles), own_rays, |hit| stops(&in_frame(*hit)), found);
            hits.iter_mut().zip(found).for_each(|(hit, found)| take(hit, found.map(in_frame)));
        }
        if self.together.len() < self.objects.len() {
            for (hit, ray) in hits.iter_mut().zip(rays) {
                let found = Others(self).nearest(triangles, &until(ray, hit), &stops);
                take(hit, found);
            }
        }
    }

    fn blocked(
        &self,
        triangles: Triangles<'_>,
        rays: &[ShadowRay],
        own: &[u32],
        stops: impl Fn(u32, [f32; 2]) -> bool,
        blocked: &mut [bool],
    ) {
        blocked.fill(false);
        for &object in &self.together {
            let object = &self.objects[object];
            // The rays that nothing blocks so far.
            let nothing =
                ShadowRay::new(&LightSource::Point { position: glam::Vec3::ZERO }, HitPoint::new(&NO_RAY, 0.0));
            let mut own_rays = [nothing; SQUARE_PIXELS];
            let mut indices = [(0, u32::MAX); SQUARE_PIXELS];
            let mut count = 0;
            for index in (0..rays.len()).filter(|&index| !blocked[index]) {
                let in_object = object.ids.binary_search(&own[index]).map_or(u32::MAX, |local| local as u32);
                (own_rays[count], indices[count]) = (rays[index], (index, in_object));
                count += 1;
            }
            let in_object = indices.map(|(_, own)| own);
            let mut found = [false; SQUARE_PIXELS];
            let stops = |id: u32, barycentric| stops(object.ids[id as usize], barycentric);
            let own_triangles = object.of(triangles);
            object.tree.blocked_of_packet(
                own_triangles,
                &own_rays[..count],
                &in_object[..count],
                stops,
                &mut found[..count],
            );
            indices[..count].iter().zip(found).for_each(|(&(index, _), found)| blocked[index] = found);
        }
        if self.together.len() < self.objects.len() {
            for index in 0..rays.len() {
                blocked[index] = blocked[index] || Others(self).blocked(triangles, &rays[index], own[index], &stops);
            }
        }
    }
}
