//! Triangles with corners that are no numbers are left out, counted, and change nothing.

use glam::{DVec2, Vec3};
use umbrage_rays::{
    Bvh, Camera, LightGrid, LightSource, ListedGrid, ListedLightGrid, ListedOptions, PerspectiveGrid, SeenImage,
    SeenPixels, Unmasked, View,
};
use umbrage_verify::TestMesh;

/// A ball and, in between its triangles, one triangle for every way in which nine coordinates can be a number, NaN and
/// either infinity, but for the one way that is all numbers.
fn ball_among_all_patterns() -> (TestMesh, TestMesh) {
    const WAYS: u32 = 4_u32.pow(9);
    let ball = TestMesh::ball(2);
    let mut mesh = TestMesh::default();
    for pattern in 1..WAYS {
        if pattern % 1000 == 1 && ((pattern / 1000) as usize) < ball.indices.len() {
            mesh.push(ball.triangles().corners(pattern / 1000));
        }
        let coordinate = |place: u32| {
            let number = 0.3 * place as f32 - 1.0;
            [number, f32::NAN, f32::INFINITY, f32::NEG_INFINITY][(pattern >> (2 * place) & 3) as usize]
        };
        mesh.push([0, 3, 6].map(|place| Vec3::new(coordinate(place), coordinate(place + 1), coordinate(place + 2))));
    }
    let mut numbers = TestMesh::default();
    let finite = |&id: &u32| mesh.triangles().corners(id).iter().all(|corner| corner.is_finite());
    (0..mesh.indices.len() as u32).filter(finite).for_each(|id| numbers.push(mesh.triangles().corners(id)));
    (mesh, numbers)
}

#[test]
fn every_pattern_of_nan_and_infinity_is_left_out_and_counted() {
    let (mesh, numbers) = ball_among_all_patterns();
    assert_eq!(numbers.indices.len(), 263);
    let camera = Camera::look_at(Vec3::new(1.0, 2.0, 4.0), Vec3::ZERO, Vec3::Y, 0.8);
    let (view, offset_pixels) = (View { camera, width: 20, height: 17 }, DVec2::splat(0.5));
    let lights = [
        LightSource::Point { position: Vec3::new(1.0, 3.0, 1.0) },
        LightSource::Point { position: Vec3::new(0.1, 0.0, 0.0) },
        LightSource::Directional { direction: Vec3::NEG_Y },
    ];
    let look = |mesh: &TestMesh| {
        let (mut grid, mut seen) = (PerspectiveGrid::default(), SeenPixels::default());
        grid.build(mesh.triangles(), &view, offset_pixels, |_| false).expect("a small image");
        grid.trace(mesh.triangles(), Unmasked, &mut seen);
        let mut light_grid = LightGrid::default();
        let image = SeenImage { triangles: mesh.triangles(), view, offset_pixels, seen: &seen };
        light_grid.survey(&image);
        let masks = lights.map(|light| {
            let mut lit = vec![0_u16; seen.triangle.len() / 16];
            light_grid.shadow(&image, &light, |_| true, &Unmasked, &mut lit);
            lit
        });
        let (mut listed_grid, mut listed_seen) = (ListedGrid::default(), SeenPixels::default());
        let options = ListedOptions::DEFAULT;
        listed_grid.build(mesh.triangles(), &view, offset_pixels, options, |_| false).expect("a small image");
        listed_grid.trace(mesh.triangles(), Unmasked, &mut listed_seen);
        assert_eq!((listed_seen.triangle, listed_grid.omitted()), (seen.triangle.clone(), grid.omitted()));
        let mut listed_light_grid = ListedLightGrid::default();
        listed_light_grid.survey(&image);
        for (light, mask) in lights.iter().zip(&masks) {
            let mut lit = vec![0_u16; mask.len()];
            listed_light_grid.shadow(&image, light, |_| true, &Unmasked, &mut lit);
            assert_eq!(&lit, mask, "{light:?} through lists");
        }
        // Ids differ between the meshes; places don't.
        let corners = |&id: &u32| (id != SeenPixels::NONE).then(|| mesh.triangles().corners(id));
        let shown: Vec<_> = seen.triangle.iter().map(corners).collect();
        (shown, masks, grid.omitted().total())
    };
    let (shown, masks, omitted) = look(&mesh);
    let (shown_alone, masks_alone, none) = look(&numbers);
    assert_eq!((shown, masks), (shown_alone, masks_alone));
    assert_eq!((omitted, none), (4_u32.pow(9) - 1, 0));
    let mut bvh = Bvh::default();
    bvh.build(mesh.triangles());
    assert_eq!(bvh.omitted().total(), omitted);
}
