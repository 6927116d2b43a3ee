/// The most corners of polygons that become fans.
const MOST_IN_A_FAN: usize = 256;

/// Cuts a polygon, given by its corners, into triangles, two fewer than it has corners.
///
/// Those of up to [`MOST_IN_A_FAN`] corners become the fan around the first. Of larger ones every second corner is cut off,
/// and again of what is left, until nothing is: triangles between near corners, where a fan would have a million slivers
/// from one side to the other, which take minutes to render.
///
/// Both are exact for convex polygons; for concave ones they may reach outside of the outline. Both take as long as there
/// are corners.
pub(crate) fn triangles(corners: &[u32], mut add: impl FnMut([u32; 3])) {
    if corners.len() <= MOST_IN_A_FAN {
        if let Some((&first, others)) = corners.split_first() {
            others.windows(2).for_each(|two| add([first, two[0], two[1]]));
        }
        return;
    }
    let count = corners.len();
    let mut step = 1;
    // While there are more than two corners left.
    while 2 * step < count {
        for at in (0..count - step).step_by(2 * step) {
            let behind = corners.get(at + 2 * step).unwrap_or(&corners[0]);
            add([corners[at], corners[at + step], *behind]);
        }
        step *= 2;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cut(count: u32) -> Vec<[u32; 3]> {
        let corners: Vec<u32> = (0..count).map(|corner| 10 * corner).collect();
        let mut cut = Vec::new();
        triangles(&corners, |triangle| cut.push(triangle));
        cut
    }

    #[test]
    fn small_polygons_are_fans() {
        assert!((0..3).all(|count| cut(count).is_empty()));
        assert_eq!(cut(5), [[0, 10, 20], [0, 20, 30], [0, 30, 40]]);
        assert!(cut(256).iter().all(|triangle| triangle[0] == 0));
    }

    #[test]
    fn large_polygons_are_covered_once_by_triangles_that_share_their_edges() {
        for count in [257, 258, 300, 511, 512, 513, 1000] {
            let triangles = cut(count);
            assert_eq!(triangles.len() as u32, count - 2, "{count}");
            let edges = triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
            let mut alone = std::collections::BTreeSet::new();
            for [from, to] in edges {
                assert!(from != to);
                if !alone.remove(&[to, from]) {
                    assert!(alone.insert([from, to]), "{count}: {from} to {to} twice");
                }
            }
            let outline = (0..count).map(|corner| [10 * corner, 10 * ((corner + 1) % count)]);
            assert!(alone.into_iter().eq(std::collections::BTreeSet::from_iter(outline)), "{count}");
            let longest = triangles.iter().filter(|triangle| triangle[0] == 0).count();
            assert!(longest < 24, "{longest} triangles of {count} meet in a corner");
        }
    }
}
