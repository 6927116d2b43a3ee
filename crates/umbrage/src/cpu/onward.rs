//! Secondary rays: straight on behind surfaces, from mirrors and through glass. They are queued and traced together.

use std::mem;

use glam::{DVec2, DVec3, Vec3};
use umbrage_rays::predicate::{HitPoint, ShadowRay};
use umbrage_rays::{Hit, LightSource, Ray};
use umbrage_rays::{SimdLevel, dispatch};
use umbrage_scene::Material;

use super::marks::{MarkStrip, Marks};
use super::met::Ways;
use super::shade::Shading;
use super::stops;
use super::strip::Strip;
use crate::plan::Plan;
use crate::points::pair_of_pixel;
use crate::shade::glass::{Media, attenuation, reflected_part, refracted};
use crate::shade::gloss::{Facets, Gloss, scattered};
use crate::shade::lanes::{Each, LANES, at_most_brightest, lanes_of, put, vector_of};

/// The path from a ray back to the camera.
#[derive(Clone, Copy, Debug)]
pub(super) struct Path {
    /// Index of the path's pixel in a [`Strip`].
    pub(super) pixel: u32,
    /// Key of the path's random points.
    pub(super) drawn: Drawn,
    /// Throughput: the part of the ray's light that reaches the camera.
    pub(super) through: Vec3,
    /// Length of the path from the ray's origin to the camera, in world units.
    pub(super) travelled: f32,
    /// Largest GGX width of the rough surfaces on the path.
    pub(super) blur: f32,
    /// Number of mirrors, and of crossings into or out of glass, on the path.
    pub(super) bounces: u32,
    /// Number of surfaces passed straight on since the last of these.
    pub(super) layers: u32,
    /// Media that surround the ray.
    pub(super) media: Media,
}

/// Key of a path's random points: the pixel among all, and the index of its sample.
#[derive(Clone, Copy, Debug)]
pub(super) struct Drawn {
    pub(super) pixel: u32,
    pub(super) sample: u32,
}

impl Path {
    /// Number of random points for each bounce.
    const POINTS: u32 = 2;
    const FACET: u32 = 0;
    const AROUND: u32 = 1;

    /// A point of the unit square for a purpose at the end of the path.
    fn point(&self, purpose: u32) -> DVec2 {
        pair_of_pixel(self.drawn.sample, self.drawn.pixel, self.bounces * Self::POINTS + purpose)
    }
}

/// A secondary ray.
#[derive(Clone, Copy, Debug)]
pub(super) struct Onward {
    pub(super) ray: Ray,
    pub(super) path: Path,
    from: From,
}

/// Where a ray starts.
#[derive(Clone, Copy, Debug)]
enum From {
    /// On the line of the ray that it continues, behind that ray's hit.
    Behind,
    /// At a point of a triangle.
    Surface { point: HitPoint, triangle: u32 },
}

/// A ray's hit, with the path of the ray to the camera.
#[derive(Clone, Copy, Debug)]
pub(super) struct Meeting {
    pub(super) ray: Ray,
    pub(super) hit: Hit,
    pub(super) path: Path,
}

impl Meeting {
    /// The ray that goes straight on into `media`, with the throughput `through`.
    pub(super) fn behind(&self, through: Vec3, media: Media) -> Onward {
        let ray = Ray { t_min: self.hit.t, ..self.ray };
        let path = Path { through, layers: self.path.layers + 1, media, ..self.path };
        Onward { ray, path, from: From::Behind }
    }

    /// The ray that starts in a `direction` of about unit length into `media`, with the throughput `through`; its path
    /// to the camera has the length `travelled`.
    pub(super) fn towards(&self, direction: DVec3, through: Vec3, media: Media, travelled: f32) -> Onward {
        let point = HitPoint::new(&self.ray, self.hit.t);
        let ray = Ray::new(point.position, direction);
        let path = Path { through, travelled, bounces: self.path.bounces + 1, layers: 0, media, ..self.path };
        Onward { ray, path, from: From::Surface { point, triangle: self.hit.triangle } }
    }
}

/// A light's contribution to a pixel, unless its shadow ray is blocked.
pub(super) struct Shadow {
    pub(super) ray: ShadowRay,
    /// The triangle that the point is on.
    pub(super) triangle: u32,
    /// The light.
    pub(super) source: LightSource,
    pub(super) pixel: u32,
    pub(super) radiance: Vec3,
    /// Coverage that it adds: negative on shadow catchers, else 0.
    pub(super) coverage: f32,
}

/// Secondary rays that wait, generation by generation. Shading is added in the order of the queue, so that pictures
/// don't depend on the order in which its rays are traced.
#[derive(Default)]
pub(super) struct Queue {
    /// The next generation.
    pub(super) next: Vec<Onward>,
    /// The current generation, and its hits.
    now: Vec<Onward>,
    found: Vec<Option<Hit>>,
    /// Contributions of lights that wait for their shadow rays.
    pub(super) shadows: Vec<Shadow>,
}

impl Queue {
    /// Traces all rays and those that they spawn, and adds their shading to the film: with points and lines in between,
    /// if there are any.
    pub(super) fn follow(
        &mut self,
        level: SimdLevel,
        shading: &Shading<'_>,
        marks: Option<(&Marks, &MarkStrip)>,
        film: &mut Strip<'_>,
    ) {
        let Self { next, now, found, shadows } = self;
        shading.light(shadows, film);
        while !next.is_empty() {
            mem::swap(next, now);
            next.clear();
            found.clear();
            found.extend(now.iter().map(|onward| shading.nearest(onward)));
            if let Some((marks, drawn)) = marks {
                drawn.stop(marks, now, found, film);
            }
            for (now, found) in now.chunks(LANES).zip(found.chunks(LANES)) {
                dispatch!(level, simd => shading.shade_onward(simd, now, found, next, shadows, film));
            }
            shading.light(shadows, film);
        }
    }
}

impl Shading<'_> {
    /// Traces the shadow rays, and adds the contributions that arrive, tinted by the surfaces on their way.
    fn light(&self, shadows: &mut Vec<Shadow>, film: &mut Strip<'_>) {
        for Shadow { ray, triangle, source, pixel, radiance, coverage } in shadows.drain(..) {
            if let Some(tint) = self.arriving_through(&source, &ray, triangle) {
                // Zero coverage stays zero under any tint.
                let covered =
                    if coverage == 0.0 { 0.0 } else { at_most_brightest(coverage * tint.element_sum() / 3.0) };
                let radiance = (radiance * tint).map(at_most_brightest);
                film.add_light(pixel, radiance, covered, self.surroundings.are_flat());
            }
        }
    }

    /// Queues a contribution from the surroundings to a surface with this unit normal: it is blocked by anything within
    /// the ambient-occlusion radius in one random direction.
    pub(super) fn look_around(
        &self,
        meeting: &Meeting,
        normal: DVec3,
        radiance: Vec3,
        coverage: f32,
        shadows: &mut Vec<Shadow>,
    ) {
        let Meeting { ray, hit, path } = meeting;
        let point = self.lit_point(ray, hit);
        let direction = scattered(normal, path.point(Path::AROUND));
        let position = (point.position + direction * f64::from(self.plan.around)).as_vec3();
        let source = LightSource::Point { position: position.clamp(Vec3::MIN, Vec3::MAX) };
        let (triangle, pixel) = (hit.triangle, path.pixel);
        shadows.push(Shadow { ray: ShadowRay::new(&source, point), triangle, source, pixel, radiance, coverage });
    }

    /// The nearest hit that stops a ray.
    fn nearest(&self, Onward { ray, path, from }: &Onward) -> Option<Hit> {
        debug_assert!(self.plan.goes_on(), "the structure for secondary rays was built");
        if path.layers >= Plan::MANY_LAYERS && path.through.max_element() < Plan::LEAST_PART {
            return None;
        }
        let triangles = self.frame.triangles();
        let stops = |other: &Hit| {
            stops(self.frame, ray, other, self.sides)
                && (path.layers < Plan::MOST_LAYERS || !self.frame.material(other.triangle).is_see_through())
        };
        match from {
            From::Behind => self.rays_onward.nearest(triangles, ray, &stops),
            // As with shadows, the surface itself and triangles that the point may touch are excluded.
            From::Surface { point, triangle } => self.rays_onward.nearest_from(triangles, ray, *triangle, &|other| {
                !point.is_on(triangles.corners(other.triangle)) && stops(other)
            }),
        }
    }
}

/// Secondary rays, one a lane. Lanes without one have an arbitrary ray without a hit, whose throughput is 0.
pub(super) struct Lanes {
    pub(super) rays: Each<Ray>,
    pub(super) found: Each<Option<Hit>>,
    pub(super) through: [Each<f32>; 3],
    pub(super) travelled: Each<f32>,
    /// Largest GGX width of the rough surfaces on the path.
    pub(super) blur: Each<f32>,
    pub(super) bounces: Each<u32>,
}

impl Lanes {
    pub(super) fn new(onward: &[Onward], found: &[Option<Hit>], materials: &[Material]) -> Self {
        let mut lanes = Self {
            rays: [Ray::new(DVec3::ZERO, DVec3::Z); LANES],
            found: [None; LANES],
            through: [[0.0; LANES]; 3],
            travelled: [0.0; LANES],
            blur: [0.0; LANES],
            bounces: [0; LANES],
        };
        for (lane, (Onward { ray, path, .. }, found)) in onward.iter().zip(found).enumerate() {
            (lanes.rays[lane], lanes.found[lane]) = (*ray, *found);
            (lanes.travelled[lane], lanes.bounces[lane]) = (path.travelled, path.bounces);
            lanes.blur[lane] = path.blur;
            let mut through = path.through;
            if let (Some(hit), Some(medium)) = (found, path.media.innermost()) {
                let distance = (hit.t - ray.t_min) * ray.direction.length();
                through *= attenuation(&materials[medium as usize], distance as f32);
            }
            put(lane, through, &mut lanes.through);
        }
        lanes
    }
}

impl Shading<'_> {
    /// Queues the secondary rays of sixteen hits.
    #[cold]
    pub(super) fn go_on(&self, meeting: &dyn Fn(usize) -> Option<Meeting>, ways: &Ways, queue: &mut Vec<Onward>) {
        for lane in lanes_of(ways.mirrors | ways.glass | ways.behind) {
            let Some(meeting) = meeting(lane) else { continue };
            let (bit, media) = (1 << lane, meeting.path.media);
            if ways.mirrors & bit != 0 {
                match &ways.gloss {
                    Some(gloss) => queue.extend(mirrored_by_one(&meeting, lane, ways, gloss)),
                    None => queue.push(mirrored(&meeting, lane, ways, 1.0)),
                }
            }
            let across = || {
                let material = self.frame.mesh.material_of_triangle[meeting.hit.triangle as usize];
                media.across(material, ways.front & bit != 0)
            };
            if ways.behind & bit != 0 {
                // Where glass isn't followed any further, it is as thin as a pane.
                let is_left = ways.volume & bit != 0 && !media.is_empty();
                let media = if is_left { across() } else { media };
                queue.push(meeting.behind(vector_of(lane, &ways.passing), media));
            }
            if ways.glass & bit != 0 {
                self.go_through_glass(&meeting, lane, ways, across(), queue);
            }
        }
    }

    /// Queues the rays that a glass surface reflects, and those that it refracts into the media behind.
    fn go_through_glass(&self, meeting: &Meeting, lane: usize, ways: &Ways, behind: Media, queue: &mut Vec<Onward>) {
        let mut meeting = *meeting;
        let Meeting { ray, hit, path } = meeting;
        let materials = &self.frame.materials.materials;
        let material = self.frame.mesh.material_of_triangle[hit.triangle as usize];
        let from_front = ways.front >> lane & 1 == 1;
        let [normal, geometric_normal] =
            [&ways.normal, &ways.geometric_normal].map(|normal| vector_of(lane, normal).as_dvec3().normalize());
        let direction = ray.direction.normalize();
        let is_smooth = ways.is_smooth >> lane & 1 == 1;
        let facets = ways.gloss.as_ref().filter(|_| !is_smooth).map(|gloss| gloss.facets(lane, normal));
        let mut normal = normal;
        if let Some(facets) = &facets {
            normal = facets.visible(-direction, path.point(Path::FACET));
            meeting.path.blur = path.blur.max(facets.mean_width() as f32);
        }
        let unshadowed = |to: DVec3| facets.map_or(1.0, |facets| facets.unshadowed_behind(to) as f32);
        let cosine = (-direction.dot(normal)).clamp(0.0, 1.0);
        let through = vector_of(lane, &ways.surface_through);
        let transmitted = vector_of(lane, &ways.transmitted);
        let colors: &[(Vec3, f64)] = if path.media.disperse(material, materials) {
            &[(Vec3::X, -1.0), (Vec3::Y, 0.0), (Vec3::Z, 1.0)]
        } else {
            &[(Vec3::ONE, 0.0)]
        };
        let mut mirrored = Vec3::ZERO;
        for &(channels, color) in colors {
            let ratio = path.media.ratio(material, from_front, materials, color);
            let reflected = reflected_part(cosine, ratio) as f32;
            mirrored += through * channels * reflected;
            let through = through * channels * transmitted * (1.0 - reflected);
            if through.max_element() > self.plan.least {
                let by =
                    |normal: DVec3| refracted(direction, normal, ratio).filter(|to| to.dot(geometric_normal) < 0.0);
                // A bent normal may refract rays out of the triangle.
                if let Some(direction) = by(normal).or_else(|| by(geometric_normal)) {
                    let through = through * unshadowed(direction);
                    queue.push(meeting.towards(direction, through, behind, ways.travelled[lane]));
                }
            }
        }
        if (is_smooth || facets.is_some()) && mirrored.max_element() > self.plan.least {
            let direction = direction + normal * (2.0 * cosine);
            if direction.dot(geometric_normal) > 0.0 {
                let mirrored = mirrored * unshadowed(direction);
                queue.push(meeting.towards(direction, mirrored, path.media, ways.travelled[lane]));
            }
        }
    }
}

/// The mirrored ray, which is sent with the probability `share`.
fn mirrored(meeting: &Meeting, lane: usize, ways: &Ways, share: f64) -> Onward {
    let direction = vector_of(lane, &ways.mirrored).as_dvec3();
    let through = vector_of(lane, &ways.mirrored_through) / share as f32;
    meeting.towards(direction, through, meeting.path.media, ways.travelled[lane])
}

/// The mirrored ray of a surface's coat or of the base below it, drawn by their reflectances; `None` where it would go
/// into the surface.
fn mirrored_by_one(meeting: &Meeting, lane: usize, ways: &Ways, gloss: &Gloss) -> Option<Onward> {
    let is_smooth = ways.is_smooth >> lane & 1 == 1;
    let coat = gloss.coat(lane);
    let mut point = meeting.path.point(Path::FACET);
    let mut share = 1.0;
    // If both are mirrors, one ray serves both.
    if let Some(coat) = coat.filter(|coat| !(is_smooth && coat.is_mirror)) {
        let is_of_coat = point.x < coat.share;
        // The rescaled number is as evenly spread.
        (point.x, share) = if is_of_coat {
            (point.x / coat.share, coat.share)
        } else {
            ((point.x - coat.share) / (1.0 - coat.share), 1.0 - coat.share)
        };
        if is_of_coat && !coat.is_mirror {
            // Its bumps may face away, and mirror as much then.
            let faces = meeting.ray.direction.dot(coat.normal) <= 0.0;
            let normal = if faces { coat.normal } else { -coat.normal };
            let facets = Facets::round(normal, coat.alpha.into());
            let reflected = |_: f32| Vec3::splat(coat.part / share as f32);
            return mirrored_roughly(meeting, lane, ways, (facets, normal), point, reflected);
        }
        if is_of_coat {
            return Some(mirrored(meeting, lane, ways, share));
        }
    }
    if is_smooth {
        return Some(mirrored(meeting, lane, ways, share));
    }
    let normal = vector_of(lane, &ways.normal).as_dvec3().normalize();
    let reflected = |cosine: f32| gloss.reflected(lane, cosine) / share as f32;
    mirrored_roughly(meeting, lane, ways, (gloss.facets(lane, normal), normal), point, reflected)
}

/// The ray mirrored by one visible microfacet of a rough surface with this normal. `reflected` is its reflectance by
/// the cosine to the view. `None` where the ray would go into that surface.
fn mirrored_roughly(
    meeting: &Meeting,
    lane: usize,
    ways: &Ways,
    (facets, normal): (Facets, DVec3),
    point: DVec2,
    reflected: impl Fn(f32) -> Vec3,
) -> Option<Onward> {
    let view = -meeting.ray.direction.normalize();
    let facet = facets.visible(view, point);
    let cosine = view.dot(facet);
    let mut direction = facet * (2.0 * cosine) - view;
    if direction.dot(normal) <= 0.0 {
        return None;
    }
    let kept = facets.unshadowed(view, direction) as f32;
    let geometric_normal = vector_of(lane, &ways.geometric_normal).as_dvec3().normalize();
    let height = direction.dot(geometric_normal);
    if height <= 0.0 {
        // A bent normal mirrors it into the triangle: it is flipped to the front, or rims would be black.
        direction -= geometric_normal * (2.0 * height);
    }
    let through = vector_of(lane, &ways.surface_through) * reflected(cosine as f32) * kept;
    let mut onward = meeting.towards(direction, through, meeting.path.media, ways.travelled[lane]);
    onward.path.blur = onward.path.blur.max(facets.mean_width() as f32);
    Some(onward)
}
