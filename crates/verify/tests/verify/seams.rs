//! Numbers of rays exactly through shared features of a sheet's triangles; the conformance suite tests structures with them.

use glam::Vec3;
use umbrage_verify::{Random, Seams, Sheet, SheetShape};

fn shapes() -> impl Iterator<Item = SheetShape> {
    let sizes = [(16, 1), (16, 2), (32, 4)].into_iter().flat_map(|size| [false, true].map(|shell| (size, shell)));
    let sizes = sizes.flat_map(|size| [false, true].map(|is_orthographic| (size, is_orthographic)));
    sizes.flat_map(|(((side, step), shell), is_orthographic)| {
        SheetShape::PLACES.map(|(position, scale)| {
            let has_shell = shell && position == Vec3::ZERO;
            SheetShape { side, step, position, scale, is_orthographic, has_shell }
        })
    })
}

#[test]
fn seams_are_counted_where_rays_meet_them_exactly() {
    let mut random = Random::new(22);
    for shape in shapes() {
        let sheet = Sheet::new(shape, &mut random);
        let mut seams = Seams::default();
        for (x, y) in (0..shape.side).flat_map(|y| (0..shape.side).map(move |x| (x, y))) {
            let ray = sheet.view.ray(f64::from(x), f64::from(y));
            // All numbers are small multiples of a power of two: f64 has no roundings here.
            let from_ray = |vertex: u32| sheet.mesh.positions[vertex as usize].as_dvec3() - ray.origin;
            let away = |&[a, b]: &[u32; 2]| {
                // Both are at right angles to the ray, and as long as the vertices' distances from it.
                let (a, b) = (from_ray(a).cross(ray.direction), from_ray(b).cross(ray.direction));
                let meets = a.cross(b).length_squared() == 0.0 && a.dot(b) <= 0.0;
                meets.then(|| a.length_squared().min(b.length_squared()))
            };
            let front = &sheet.mesh.indices[..sheet.front as usize];
            let edges = front.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
            let nearest = edges.filter_map(|edge| away(&edge)).reduce(f64::min);
            match nearest {
                Some(0.0) => seams.vertices += 1,
                Some(_) => seams.edges += 1,
                None => assert!(shape.step > 2, "{shape:?}"),
            }
        }
        assert_eq!(sheet.seams(), seams, "{shape:?}");
    }
}
