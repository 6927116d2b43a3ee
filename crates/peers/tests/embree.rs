//! Embree's and tinybvh's answers are those of the reference predicate, but for a few that their arithmetic gets wrong.
//! Skipped if there is no library, which `UMBRAGE_EMBREE` and `UMBRAGE_TINYBVH` may name.

use std::sync::Arc;

use glam::{DVec2, Vec3, Vec4};
use umbrage_peers::{BuildMethod, Embree, Error, Image, Layout, PixelRays, Posed, Quality, Scene, TinyBvh, TinyScene};
use umbrage_rays::predicate::{HitPoint, ShadowRay};
use umbrage_rays::{
    Bounds, Camera, Closest, ClosestPoints, LightSource, Nearest, Opacity as _, Shifts, Shot, Triangles, View,
};
use umbrage_scene::{Alpha, Frame, Material, Materials, Mesh};
use umbrage_verify::{Oracle, Random, TestMesh};

/// Width and height in pixels.
const SIDE: u32 = 60;

fn embree() -> Option<Arc<Embree>> {
    let path = std::env::var_os("UMBRAGE_EMBREE").map(std::path::PathBuf::from);
    match Embree::load(path.as_deref(), 2) {
        Ok(embree) => Some(embree),
        Err(error @ Error::NotFound { .. }) => {
            println!("skipped: {error}");
            None
        }
        Err(error) => panic!("{error}"),
    }
}

fn tinybvh() -> Option<Arc<TinyBvh>> {
    let path = std::env::var_os("UMBRAGE_TINYBVH").map(std::path::PathBuf::from);
    if path.is_none() {
        println!("skipped: UMBRAGE_TINYBVH names no library");
    }
    path.map(|path| TinyBvh::load(&path).unwrap_or_else(|error| panic!("{error}")))
}

/// A ball above a floor. Materials of triangles repeat: opaque, and cut away by an alpha mask.
fn frame(is_cut: impl Fn(usize) -> bool) -> Frame {
    let mut mesh = TestMesh::ball(2);
    let corner = |x: f32, z: f32| Vec3::new(x, -1.2, z);
    mesh.push([corner(-6.0, -6.0), corner(-6.0, 6.0), corner(6.0, -6.0)]);
    mesh.push([corner(6.0, 6.0), corner(-6.0, 6.0), corner(6.0, -6.0)]);
    let cut = Material { base_color: Vec4::ZERO, alpha: Alpha::Mask { cutoff: 0.5 }, ..Material::default() };
    let material_of_triangle = (0..mesh.indices.len()).map(|triangle| u32::from(is_cut(triangle))).collect();
    Frame {
        positions: mesh.positions,
        mesh: Arc::new(Mesh { triangles: mesh.indices, material_of_triangle, ..Mesh::default() }),
        materials: Arc::new(Materials { materials: vec![Material::default(), cut], ..Materials::default() }),
        ..Frame::default()
    }
}

/// A frame with a light, seen by a camera, and the oracle's answers for its pixels.
struct Case {
    frame: Frame,
    light: LightSource,
    /// Each pixel's triangle and distance, row by row, and whether the light reaches its point.
    truth: Vec<Option<(u32, f64, bool)>>,
}

const OFFSET_PIXELS: DVec2 = DVec2::new(0.4, 0.7);

fn view() -> View {
    let camera = Camera::look_at(Vec3::new(1.0, 1.5, 4.0), Vec3::new(0.0, -0.3, 0.0), Vec3::Y, 0.8);
    View { camera, width: SIDE, height: SIDE }
}

/// Rays with offsets that differ from pixel to pixel, and aren't the pixels' middles.
fn shot(triangles: Triangles<'_>) -> Shot<'_> {
    let shifts = [(-0.25, 0.125), (0.25, -0.375), (0.5, 0.0), (0.0, 0.5)].map(DVec2::from);
    let shifts = Shifts::new(shifts).expect("possible shifts");
    Shot { offset_pixels: OFFSET_PIXELS, shifts, ..Shot::new(triangles, view()) }
}

impl Case {
    fn new(frame: Frame, light: LightSource) -> Self {
        let oracle = Oracle::new(frame.triangles());
        let truth = |pixel| {
            let (x, y) = (pixel % SIDE, pixel / SIDE);
            let ray = shot(frame.triangles()).ray(x, y);
            let hit = oracle.nearest(&ray, |hit| frame.camera_opacity().stops(hit.triangle, hit.barycentric))?;
            let shadow_ray = ShadowRay::new(&light, HitPoint::new(&ray, hit.t));
            let is_blocked =
                oracle.blocked(&shadow_ray, hit.triangle, |id, weights| frame.shadow_opacity().stops(id, weights));
            Some((hit.triangle, hit.t, !is_blocked))
        };
        let truth: Vec<_> = (0..SIDE * SIDE).map(truth).collect();
        let (lit, dark): (Vec<bool>, Vec<bool>) = truth.iter().flatten().map(|&(_, _, lit)| lit).partition(|&lit| lit);
        assert!(lit.len() > truth.len() / 4 && dark.len() > truth.len() / 16, "{} lit, {} dark", lit.len(), dark.len());
        Self { frame, light, truth }
    }

    /// Asserts that Embree's answers agree with the oracle's in nearly all pixels.
    fn assert_agrees(&self, scene: &mut Scene) {
        let posed = self.posed();
        scene.build(&posed).expect("a scene");
        let (mut image, rays) = (Image::default(), PixelRays::new(&shot(self.frame.triangles())));
        image.see(&rays, |valid, packet| scene.nearest(valid, packet));
        image.shadow(&rays, self.light(), |valid, packet| scene.occluded(valid, packet));
        self.assert_shown(&posed, &image);
    }

    /// Asserts the same of tinybvh's answers.
    fn assert_tinybvh_agrees(&self, scene: &mut TinyScene) {
        let posed = self.posed();
        scene.pose(&posed).expect("opaque triangles");
        scene.build();
        let (mut image, rays) = (Image::default(), PixelRays::new(&shot(self.frame.triangles())));
        image.see(&rays, |valid, packet| scene.nearest(valid, packet));
        image.shadow(&rays, self.light(), |valid, packet| scene.occluded(valid, packet));
        self.assert_shown(&posed, &image);
    }

    fn posed(&self) -> Arc<Posed> {
        Arc::new(Posed::new(&self.frame, true).expect("indices in range"))
    }

    fn light(&self) -> (&LightSource, Bounds) {
        (&self.light, self.frame.triangles().bounds())
    }

    fn assert_shown(&self, posed: &Posed, image: &Image) {
        let is_wrong = |&(pixel, truth): &(u32, &Option<(u32, f64, bool)>)| {
            let (x, y) = (pixel % SIDE, pixel / SIDE);
            match (truth, image.seen(x, y)) {
                (None, None) => false,
                (&Some((triangle, t, is_lit)), Some((name, seen_t))) => {
                    let is_near = (f64::from(seen_t) - t).abs() < 1e-5 * t;
                    posed.triangle(name) != triangle || !is_near || image.is_lit(x, y) != is_lit
                }
                _ => true,
            }
        };
        let wrong = (0..).zip(&self.truth).filter(is_wrong).count();
        // Wrong ones are rays through edges, and points at grazing light.
        assert!(wrong < self.truth.len() / 200, "{wrong} of {} pixels are wrong", self.truth.len());
    }
}

#[test]
fn pixels_show_what_the_oracle_says() {
    let Some(embree) = embree() else { return };
    let point = LightSource::Point { position: Vec3::new(1.5, 4.0, 1.0) };
    let sun = LightSource::Directional { direction: Vec3::new(-0.4, -1.0, -0.2).normalize() };
    let cases = [
        Case::new(frame(|_| false), point),
        Case::new(frame(|triangle| triangle % 3 == 1 && triangle < 320), point),
        Case::new(frame(|_| false), sun),
    ];
    for quality in [Quality::Low, Quality::Medium] {
        for kept in [false, true] {
            let mut scene = Scene::new(&embree, BuildMethod { quality, kept });
            cases.iter().for_each(|case| case.assert_agrees(&mut scene));
        }
    }
}

#[test]
fn pixels_show_what_the_oracle_says_to_tinybvh() {
    let Some(tinybvh) = tinybvh() else { return };
    let point = LightSource::Point { position: Vec3::new(1.5, 4.0, 1.0) };
    let sun = LightSource::Directional { direction: Vec3::new(-0.4, -1.0, -0.2).normalize() };
    let cases = [point, sun].map(|light| Case::new(frame(|_| false), light));
    for layout in [Layout::Binary, Layout::Wide] {
        let mut scene = TinyScene::new(&tinybvh, layout);
        // A second round reuses the memory of earlier frames.
        cases.iter().chain(&cases).for_each(|case| case.assert_tinybvh_agrees(&mut scene));
        let masked = Posed::new(&frame(|triangle| triangle == 3), true).expect("indices in range");
        assert!(matches!(scene.pose(&Arc::new(masked)), Err(Error::NotOpaque)));
    }
}

#[test]
fn a_scene_of_masks_alone_can_be_built() {
    let Some(embree) = embree() else { return };
    let frame = frame(|_| true);
    let posed = Arc::new(Posed::new(&frame, true).expect("indices in range"));
    let mut scene = Scene::new(&embree, BuildMethod { quality: Quality::Low, kept: false });
    scene.build(&posed).expect("a scene");
    let view = View { camera: Camera::look_at(Vec3::Z * 5.0, Vec3::ZERO, Vec3::Y, 0.5), width: 16, height: 16 };
    let mut image = Image::default();
    image.see(&PixelRays::new(&Shot::new(frame.triangles(), view)), |valid, packet| scene.nearest(valid, packet));
    assert!((0..16).all(|at| image.seen(at, at).is_none()));
}

#[test]
fn indices_out_of_range_are_refused() {
    let mut frame = frame(|_| false);
    let mut mesh = (*frame.mesh).clone();
    mesh.triangles[7][2] = frame.positions.len() as u32;
    frame.mesh = Arc::new(mesh);
    assert!(matches!(Posed::new(&frame, false), Err(Error::IndexOutOfRange { triangle: 7 })));
}

#[test]
fn nearest_triangles_are_those_of_exact_distances() {
    let Some(embree) = embree() else { return };
    let frame = frame(|triangle| triangle % 3 == 1);
    let (triangles, mut random) = (frame.triangles(), Random::new(3));
    let points: Vec<Vec3> = (0..1000).map(|_| random.point() * 2.0).collect();
    let (mut nearest, mut closest) = (Nearest::default(), ClosestPoints::default());
    nearest.build(triangles);
    nearest.closest_points(&Closest::new(triangles, &points), &mut closest);
    for masks in [false, true] {
        let posed = Arc::new(Posed::new(&frame, masks).expect("indices in range"));
        let mut scene = Scene::new(&embree, BuildMethod { quality: Quality::Medium, kept: true });
        assert_eq!(scene.closest_point(points[0]), None);
        scene.build(&posed).expect("a scene");
        let mut others = 0;
        for (index, point) in points.iter().enumerate() {
            let (name, distance) = scene.closest_point(*point).expect("a triangle");
            assert!((f64::from(distance) - closest.distance[index]).abs() < 1e-6, "{point}");
            others += usize::from(posed.triangle(name) != closest.triangle[index]);
        }
        // Those that are equally near, at an edge or a corner.
        assert!(others < points.len() / 2, "{others} other triangles");
    }
}
