//! Single rays, from anywhere to anywhere, through every structure that answers them.

mod rays;

use std::sync::LazyLock;

use rayon::prelude::*;
use umbrage_rays::predicate::{HitPoint, ShadowRay};
use umbrage_rays::{Hit, Ray, SimdLevel, Triangles};
use umbrage_verify::lights::{point, sun};
use umbrage_verify::{Oracle, TestMesh};

use rays::all;

use umbrage_verify::structures::Make;

/// Rays through a mesh, and the oracle's answers.
pub(crate) struct Rays {
    pub(crate) name: String,
    pub(crate) mesh: TestMesh,
    pub(crate) rays: Vec<Ray>,
    /// The nearest hit of each.
    pub(crate) nearest: Vec<Option<Hit>>,
    /// The nearest of the hits that are [picked](is_picked).
    pub(crate) nearest_picked: Vec<Option<Hit>>,
    /// Shadow rays from some of the hits towards lights.
    pub(crate) shadows: Vec<Shadow>,
}

pub(crate) struct Shadow {
    pub(crate) ray: ShadowRay,
    /// The triangle that the point is on.
    pub(crate) own: u32,
    pub(crate) is_blocked: bool,
    /// Whether a triangle blocks it at a point that [casts](casts) a shadow.
    pub(crate) is_blocked_by_casting: bool,
}

/// Whether a hit stops a ray, as a mask decides it.
pub(crate) fn is_picked(hit: &Hit) -> bool {
    hit.triangle % 3 != 1 && hit.barycentric[0] < 0.7
}

/// Whether a triangle stops light at a point, as a mask decides it.
pub(crate) fn casts(id: u32, barycentric: [f32; 2]) -> bool {
    !id.is_multiple_of(5) || barycentric[1] < 0.5
}

impl Rays {
    pub(crate) fn new(name: impl Into<String>, mesh: TestMesh, rays: Vec<Ray>) -> Self {
        let oracle = Oracle::new(mesh.triangles());
        let ask = |pick: fn(&Hit) -> bool| rays.par_iter().map(|ray| oracle.nearest(ray, pick)).collect::<Vec<_>>();
        let (nearest, nearest_picked) = (ask(|_| true), ask(is_picked));
        // Lights are placed relative to the mesh, for any size.
        let bounds = mesh.triangles().bounds();
        let at = |x: f32, y: f32, z: f32| point(bounds.center() + bounds.size() * glam::Vec3::new(x, y, z));
        let lights = [at(1.0, 1.5, 0.6), at(0.05, 0.1, 0.07), sun(0.3, -0.9, 0.1), sun(0.0, -1.0, 0.0)];
        let hits = rays.iter().zip(&nearest).filter_map(|(ray, hit)| Some((ray, hit.as_ref()?))).enumerate();
        let some: Vec<_> = hits.step_by(3).collect();
        let shadows = some.into_par_iter().map(|(number, (ray, hit))| {
            let (own, ray) = (hit.triangle, ShadowRay::new(&lights[number / 3 % 4], HitPoint::new(ray, hit.t)));
            let [is_blocked, is_blocked_by_casting] =
                [|_: u32, _: [f32; 2]| true, casts].map(|casts| oracle.blocked(&ray, own, casts));
            Shadow { ray, own, is_blocked, is_blocked_by_casting }
        });
        let shadows = shadows.collect();
        Self { name: name.into(), mesh, rays, nearest, nearest_picked, shadows }
    }

    pub(crate) fn triangles(&self) -> Triangles<'_> {
        self.mesh.triangles()
    }
}

/// All rays, made when a first structure needs them.
pub(crate) static ALL: LazyLock<Vec<Rays>> = LazyLock::new(all);

/// To the last bit.
pub(crate) fn bits(hit: &Option<Hit>) -> Option<(u32, u64, [u32; 2])> {
    hit.map(|hit| (hit.triangle, hit.t.to_bits(), hit.barycentric.map(f32::to_bits)))
}

/// Compares a structure with the oracle, if it answers single rays.
pub(crate) fn check(make: Make) {
    let mut structure = make(SimdLevel::default());
    if structure.single_rays().is_none() {
        return;
    }
    let anything: fn(&Hit) -> bool = |_| true;
    let empty = structure.single_rays().expect("it has them");
    assert_eq!(empty.nearest(Triangles::default(), &Ray::new(glam::DVec3::ZERO, glam::DVec3::X), &anything), None);
    for rays in &*ALL {
        let triangles = rays.triangles();
        structure.build(triangles);
        let single = structure.single_rays().expect("it has them");
        for (stops, truth) in [(anything, &rays.nearest), (is_picked, &rays.nearest_picked)] {
            for (ray, truth) in rays.rays.iter().zip(truth) {
                let found = single.nearest(triangles, ray, &stops);
                assert_eq!(bits(&found), bits(truth), "{}: {ray:?} of {structure:?}", rays.name);
            }
        }
        for (ray, truth) in rays.rays.iter().zip(&rays.nearest).step_by(5) {
            let Some(Hit { triangle: own, t, .. }) = *truth else { continue };
            for ray in [*ray, Ray::new(HitPoint::new(ray, t).position, ray.direction)] {
                let expected = single.nearest(triangles, &ray, &|hit| hit.triangle != own);
                let found = single.nearest_from(triangles, &ray, own, &anything);
                assert_eq!(bits(&found), bits(&expected), "{}: {ray:?} from {own} of {structure:?}", rays.name);
            }
        }
        for Shadow { ray, own, is_blocked, is_blocked_by_casting } in &rays.shadows {
            let found =
                [single.blocked(triangles, ray, *own, &|_, _| true), single.blocked(triangles, ray, *own, &casts)];
            assert_eq!(found, [*is_blocked, *is_blocked_by_casting], "{}: {ray:?} of {structure:?}", rays.name);
        }
    }
}
