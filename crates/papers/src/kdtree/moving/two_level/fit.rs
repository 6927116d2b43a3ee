//! The affine map that takes points nearest to others.

use glam::{DAffine3, DMat3, DVec3};

/// The weight of the normal of three points, relative to all points: if these are in a plane, only the normal determines the
/// map beside it.
const NORMAL: f64 = 1e-6;

/// Returns the map with the least sum of squared distances between the second point of each pair and the mapped first one;
/// `None` if there is none, as for points of a line.
pub fn fit(pairs: &[[DVec3; 2]]) -> Option<DAffine3> {
    let middle = |side: usize| pairs.iter().map(|pair| pair[side]).sum::<DVec3>() / pairs.len() as f64;
    let (from_middle, to_middle) = (middle(0), middle(1));
    let (mut own, mut both) = (DMat3::ZERO, DMat3::ZERO);
    let mut add = |from: DVec3, to: DVec3, weight: f64| {
        own += outer(from * weight, from);
        both += outer(to * weight, from);
    };
    for [from, to] in pairs {
        add(*from - from_middle, *to - to_middle, 1.0);
    }
    let corners = far_apart(pairs)?;
    let normal = |side: usize| {
        let [a, b, c] = corners.map(|corner| corner[side]);
        let area = (b - a).cross(c - a);
        area / area.length().sqrt()
    };
    add(normal(0), normal(1), NORMAL * pairs.len() as f64);
    let matrix3 = both * own.inverse();
    let map = DAffine3 { matrix3, translation: to_middle - matrix3 * from_middle };
    map.is_finite().then_some(map)
}

/// Returns three pairs whose second points are far from each other, and not in a line if others aren't; `None` of no pairs.
fn far_apart(pairs: &[[DVec3; 2]]) -> Option<[[DVec3; 2]; 3]> {
    let farthest = |distance: &dyn Fn(DVec3) -> f64| {
        let far = |a: &&[DVec3; 2], b: &&[DVec3; 2]| distance(a[1]).total_cmp(&distance(b[1]));
        pairs.iter().max_by(far).copied()
    };
    let from = pairs.first()?[1];
    let first = farthest(&|at| (at - from).length_squared())?;
    let second = farthest(&|at| (at - first[1]).length_squared())?;
    let along = second[1] - first[1];
    let third = farthest(&|at| (at - first[1]).cross(along).length_squared())?;
    Some([first, second, third])
}

/// The matrix that takes v to a (b · v).
fn outer(a: DVec3, b: DVec3) -> DMat3 {
    DMat3::from_cols(a * b.x, a * b.y, a * b.z)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn maps_of_bodies_and_of_planes_are_found() {
        let turn = glam::DQuat::from_rotation_x(0.7) * glam::DQuat::from_rotation_z(-2.0);
        let map = DAffine3::from_rotation_translation(turn, DVec3::new(3.0, -200.0, 0.5));
        let body = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::new(0.3, 0.2, 0.1)];
        for points in [&body[..], &body[..3]] {
            let pairs: Vec<_> = points.iter().map(|&point| [point, map.transform_point3(point)]).collect();
            let found = fit(&pairs).expect("a map");
            assert!(found.abs_diff_eq(map, 1e-6), "{found:?}");
        }
        assert_eq!(fit(&[[DVec3::X; 2], [DVec3::Y; 2], [(DVec3::X + DVec3::Y) * 0.5; 2]]), None);
        assert_eq!(fit(&[]), None);
    }
}
