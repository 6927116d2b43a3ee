//! Triangles with corners that are no numbers are left out, counted, and change nothing.

use glam::Vec3;
use umbrage_rays::{Bvh, Camera, DirectGrids, LightMask, LightSource, ListedGrids, SeenPixels, Shot, Structure, View};
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
    let view = View { camera, width: 20, height: 17 };
    let lights = [
        LightSource::Point { position: Vec3::new(1.0, 3.0, 1.0) },
        LightSource::Point { position: Vec3::new(0.1, 0.0, 0.0) },
        LightSource::Directional { direction: Vec3::NEG_Y },
    ];
    let look = |mesh: &TestMesh| {
        let shot = Shot::new(mesh.triangles(), view);
        let answer = |structure: &mut dyn Structure| {
            let (mut seen, mut masks) = (SeenPixels::default(), lights.map(|_| LightMask::default()));
            structure.build(mesh.triangles());
            structure.see(&shot, &mut seen).expect("a small image");
            structure.shadow(&shot, &seen, &lights, &mut masks.each_mut());
            (seen.triangle, masks, structure.omitted().clone())
        };
        let (seen, masks, omitted) = answer(&mut DirectGrids::default());
        assert!(answer(&mut ListedGrids::default()) == (seen.clone(), masks.clone(), omitted.clone()));
        assert!(answer(&mut Bvh::default()) == (seen.clone(), masks.clone(), omitted.clone()));
        // Ids differ between the meshes; corners don't.
        let corners = |&id: &u32| (id != SeenPixels::NONE).then(|| mesh.triangles().corners(id));
        let shown: Vec<_> = seen.iter().map(corners).collect();
        (shown, masks, omitted.total())
    };
    let (shown, masks, omitted) = look(&mesh);
    let (shown_alone, masks_alone, none) = look(&numbers);
    assert_eq!((shown, masks), (shown_alone, masks_alone));
    assert_eq!((omitted, none), (4_u32.pow(9) - 1, 0));
}
