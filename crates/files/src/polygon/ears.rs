//! Concave polygons by ear clipping (Meisters 1975, *Polygons have ears*; Eberly 2002, *Triangulation by Ear Clipping*).

use glam::{DVec2, DVec3, Vec3};

/// Maximum number of corner-in-ear tests per file; polygons beyond it are cut without tests.
const MOST_TESTS: u64 = 1 << 31;

/// Cuts polygons with notches, and with holes joined to the outline by bridges of zero width.
#[derive(Debug)]
pub(super) struct Ears {
    ring: Vec<Corner>,
    /// Corners that may lie in an ear: the non-convex ones, sorted by x.
    blockers: Vec<u32>,
    /// Number of entries of `blockers` that no longer block.
    stale: usize,
    tests_left: u64,
}

/// A corner of the polygon in the plane, linked to its neighbours that aren't cut off yet.
#[derive(Clone, Copy, Debug)]
struct Corner {
    at: DVec2,
    before: u32,
    after: u32,
    blocks: bool,
}

/// The condition for cutting off a corner; each level is used where the previous one finds no ear in the ring.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Care {
    /// No other corner in the ear or on its outline.
    Full,
    /// No other corner inside of the ear.
    Inside,
    /// Convex corners, even with others in the ear.
    Convex,
    /// Any corner.
    None,
}

impl Default for Ears {
    fn default() -> Self {
        Self { ring: Vec::new(), blockers: Vec::new(), stale: 0, tests_left: MOST_TESTS }
    }
}

impl Ears {
    /// Bytes in memory for each corner of the polygon.
    pub(super) const BYTES_OF_CORNER: usize = size_of::<Corner>() + size_of::<u32>();

    /// Cuts a polygon projected on the axes of [`concave_in`] into triangles of corner indices, two fewer than corners. Returns
    /// whether every triangle was tested against the corners that might lie in it.
    pub(super) fn cut(
        &mut self,
        points: impl ExactSizeIterator<Item = Vec3>,
        axes: ProjectionAxes,
        mut add: impl FnMut([u32; 3]),
    ) -> bool {
        let count = points.len() as u32;
        self.ring.clear();
        self.ring.extend(points.zip(0..).map(|(point, index)| Corner {
            at: axes.project(point),
            before: if index == 0 { count - 1 } else { index - 1 },
            after: if index + 1 == count { 0 } else { index + 1 },
            blocks: false,
        }));
        self.find_blockers();
        let (mut left, mut fruitless) = (self.ring.len(), 0);
        let (mut corner, mut care) = (0, Care::Full);
        while left > 2 {
            if self.tests_left == 0 {
                care = care.max(Care::Convex);
            }
            let Corner { before, after, .. } = self.ring[corner as usize];
            if left == 3 || self.is_ear(corner, care) {
                add([before, corner, after]);
                self.cut_off(corner);
                left -= 1;
                (fruitless, care) = (0, Care::Full);
                // Takes every second corner, so that triangles don't all meet in one.
                corner = self.ring[after as usize].after;
            } else {
                corner = after;
                fruitless += 1;
                if fruitless == left {
                    (fruitless, care) = (0, care.less());
                }
            }
        }
        self.tests_left > 0
    }

    fn find_blockers(&mut self) {
        for corner in 0..self.ring.len() as u32 {
            self.ring[corner as usize].blocks = self.turn(corner) <= 0.0;
        }
        let ring = &self.ring;
        self.stale = 0;
        self.blockers.clear();
        self.blockers.extend((0..ring.len() as u32).filter(|&corner| ring[corner as usize].blocks));
        self.blockers.sort_unstable_by(|&a, &b| ring[a as usize].at.x.total_cmp(&ring[b as usize].at.x));
    }

    /// Positive where the outline turns left at the corner.
    fn turn(&self, corner: u32) -> f64 {
        let Corner { at, before, after, .. } = self.ring[corner as usize];
        side(self.ring[before as usize].at, at, self.ring[after as usize].at)
    }

    fn cut_off(&mut self, corner: u32) {
        let Corner { before, after, .. } = self.ring[corner as usize];
        self.ring[before as usize].after = after;
        self.ring[after as usize].before = before;
        for changed in [corner, before, after] {
            let stays = changed != corner && self.turn(changed) <= 0.0;
            let blocks = &mut self.ring[changed as usize].blocks;
            self.stale += usize::from(*blocks && !stays);
            *blocks &= stays;
        }
        if 2 * self.stale > self.blockers.len() {
            let ring = &self.ring;
            self.blockers.retain(|&blocker| ring[blocker as usize].blocks);
            self.stale = 0;
        }
    }

    fn is_ear(&mut self, corner: u32, care: Care) -> bool {
        let Corner { at: b, before, after, .. } = self.ring[corner as usize];
        let [a, c] = [before, after].map(|corner| self.ring[corner as usize].at);
        // Coincident corners and spikes have no area.
        if care == Care::None || a == b || b == c || c == a {
            return true;
        }
        let is_convex = side(a, b, c) > 0.0;
        if !is_convex || care == Care::Convex {
            return is_convex;
        }
        let (lowest, highest) = (a.min(b).min(c), a.max(b).max(c));
        let x = |&blocker: &u32| self.ring[blocker as usize].at.x;
        let first = self.blockers.partition_point(|blocker| x(blocker) < lowest.x);
        let near = self.blockers[first..].iter().take_while(|blocker| x(blocker) <= highest.x);
        let (mut tests, mut is_ear) = (0, true);
        for &blocker in near {
            tests += 1;
            let Corner { at: p, blocks, before: from, after: to } = self.ring[blocker as usize];
            if !blocks || p.y < lowest.y || p.y > highest.y || [before, corner, after].contains(&blocker) {
                continue;
            }
            let sides = |p| [side(a, b, p), side(b, c, p), side(c, a, p)];
            let corner_at = [[0, 1], [1, 2], [2, 0]].into_iter().zip([b, c, a]).find(|&(_, at)| at == p);
            let is_in = match corner_at {
                // A blocker at a corner of the ear is inside if one of its edges is.
                Some(([one, other], _)) => {
                    care == Care::Full
                        && [from, to]
                            .map(|end| sides(self.ring[end as usize].at))
                            .iter()
                            .any(|sides| sides[one] > 0.0 && sides[other] > 0.0)
                }
                None if care == Care::Full => sides(p).iter().all(|&side| side >= 0.0),
                None => sides(p).iter().all(|&side| side > 0.0),
            };
            if is_in {
                is_ear = false;
                break;
            }
        }
        self.tests_left = self.tests_left.saturating_sub(tests);
        is_ear
    }
}

/// The two axes of the projection in which a polygon is counter-clockwise.
#[derive(Clone, Copy, Debug)]
pub(super) struct ProjectionAxes([usize; 2]);

impl ProjectionAxes {
    fn project(self, point: Vec3) -> DVec2 {
        DVec2::new(f64::from(point[self.0[0]]), f64::from(point[self.0[1]]))
    }
}

/// The axes that a concave polygon is projected on; `None` for convex ones, those without area and those with a coordinate that
/// isn't finite.
///
/// The axis nearest to Newell's normal is dropped, so coordinates stay exact and coincident corners stay coincident.
pub(super) fn concave_in(points: impl DoubleEndedIterator<Item = Vec3> + Clone) -> Option<ProjectionAxes> {
    /// Sine of the largest inward bend that is taken as rounding of a straight outline.
    const STRAIGHT: f64 = 1e-6;
    let first = points.clone().next()?.as_dvec3();
    let from_first = points.clone().map(|point| point.as_dvec3() - first);
    let normal: DVec3 = from_first.clone().zip(from_first.skip(1)).map(|(a, b)| a.cross(b)).sum();
    let axis = normal.abs().max_position();
    if !normal.is_finite() || normal[axis] == 0.0 {
        return None;
    }
    let axes = [(axis + 1) % 3, (axis + 2) % 3];
    let projection = ProjectionAxes(if normal[axis] < 0.0 { [axes[1], axes[0]] } else { axes });
    let corners = points.map(|point| projection.project(point));
    // Consecutive corners at one point are taken as one.
    let start = corners.clone().next()?;
    let mut before = corners.clone().rev().find(|&at| at != start)?;
    let nexts = corners.clone().skip(1).chain([start]);
    let is_concave = corners.zip(nexts).any(|(at, next)| {
        if at == next {
            return false;
        }
        let (arriving, leaving) = (at - before, next - at);
        before = at;
        arriving.perp_dot(leaving) < -STRAIGHT * arriving.length() * leaving.length()
    });
    is_concave.then_some(projection)
}

impl Care {
    fn less(self) -> Self {
        match self {
            Self::Full => Self::Inside,
            Self::Inside => Self::Convex,
            Self::Convex | Self::None => Self::None,
        }
    }
}

/// Twice the area of a triangle, positive where it turns left.
fn side(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    (b - a).perp_dot(c - a)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the triangles of a polygon in a plane, and twice their areas.
    fn cut(outline: &[[f64; 2]]) -> (Vec<[u32; 3]>, Vec<f64>) {
        let mut ears = Ears::default();
        let points = outline.iter().map(|&[x, y]| Vec3::new(x as f32, y as f32, 5.0));
        let plane = concave_in(points.clone()).expect("a concave outline");
        let mut triangles = Vec::new();
        assert!(ears.cut(points, plane, |triangle| triangles.push(triangle)));
        assert_eq!(triangles.len(), outline.len() - 2);
        let at = |corner: u32| DVec2::from(outline[corner as usize].map(|number| f64::from(number as f32)));
        let areas = triangles.iter().map(|&[a, b, c]| side(at(a), at(b), at(c))).collect();
        (triangles, areas)
    }

    /// Checks that triangles cover a simple polygon once, that is, that none is turned over: the sum of their signed areas
    /// is the polygon's anyway.
    fn is_covered_once(outline: &[[f64; 2]], area: f64) {
        for turned in 0..outline.len().min(8) {
            let mut outline = outline.to_vec();
            outline.rotate_left(turned);
            let (_, areas) = cut(&outline);
            assert!(areas.iter().all(|&area| area >= 0.0), "{outline:?}: {areas:?}");
            assert!((areas.iter().sum::<f64>() - 2.0 * area).abs() < 1e-4 * area, "{areas:?}");
        }
    }

    const C: [[f64; 2]; 8] =
        [[0.0, 0.0], [4.0, 0.0], [4.0, 1.0], [1.0, 1.0], [1.0, 3.0], [4.0, 3.0], [4.0, 4.0], [0.0, 4.0]];

    #[test]
    fn a_notch_stays_open() {
        is_covered_once(&C, 10.0);
    }

    #[test]
    fn the_plane_may_have_any_direction() {
        let planes: [fn([f64; 2]) -> Vec3; 4] = [
            |[x, y]| Vec3::new(x as f32, 0.0, y as f32),
            |[x, y]| Vec3::new(7.0, x as f32, y as f32),
            |[x, y]| Vec3::new(y as f32, x as f32, 0.0),
            |[x, y]| Vec3::new(1e6 + x as f32, y as f32, (x + y) as f32),
        ];
        let mut ears = Ears::default();
        for plane in planes {
            let points: Vec<Vec3> = C.into_iter().map(plane).collect();
            let found = concave_in(points.iter().copied()).expect("a concave outline");
            let mut area = 0.0;
            ears.cut(points.iter().copied(), found, |corners| {
                let [a, b, c] = corners.map(|corner| points[corner as usize].as_dvec3());
                area += 0.5 * (b - a).cross(c - a).length();
            });
            // The last plane is inclined so that areas are larger by √3.
            let whole = if points[0].x < 1e5 { 10.0 } else { 10.0 * 3_f64.sqrt() };
            assert!((area - whole).abs() < 1e-9, "{area}");
        }
    }

    #[test]
    fn bridged_holes_stay_open() {
        let hole = [
            [0.0, 0.0],
            [4.0, 0.0],
            [4.0, 4.0],
            [0.0, 4.0],
            [0.0, 0.0],
            [1.0, 1.0],
            [1.0, 3.0],
            [3.0, 3.0],
            [3.0, 1.0],
            [1.0, 1.0],
        ];
        is_covered_once(&hole, 12.0);
        // Two holes; the second touches the first.
        let holes = [
            [0.0, 0.0],
            [6.0, 0.0],
            [5.0, 2.0],
            [2.0, 2.0],
            [2.0, 5.0],
            [5.0, 5.0],
            [5.0, 2.0],
            [6.0, 0.0],
            [6.0, 6.0],
            [0.0, 6.0],
            [0.0, 0.0],
            [1.0, 1.0],
            [1.0, 2.0],
            [2.0, 2.0],
            [2.0, 1.0],
            [1.0, 1.0],
        ];
        is_covered_once(&holes, 36.0 - 1.0 - 9.0);
    }

    #[test]
    fn straight_corners_and_repeated_ones_do_no_harm() {
        let mut outline = Vec::new();
        for (index, [x, y]) in C.into_iter().enumerate() {
            let [to_x, to_y] = C[(index + 1) % C.len()];
            outline.extend((0..5).map(|step| f64::from(step) / 5.0).map(|t| [x + t * (to_x - x), y + t * (to_y - y)]));
        }
        is_covered_once(&outline, 10.0);
        let doubled: Vec<_> = C.into_iter().flat_map(|corner| [corner; 2]).collect();
        is_covered_once(&doubled, 10.0);
        let outline: Vec<_> = outline.into_iter().flat_map(|corner| [corner; 3]).collect();
        is_covered_once(&outline, 10.0);
    }

    #[test]
    fn spirals_combs_and_stars_are_covered_once() {
        let shoelace = |outline: &[[f64; 2]]| {
            let pairs = outline.iter().zip(outline.iter().cycle().skip(1));
            0.5 * pairs.map(|(a, b)| a[0] * b[1] - a[1] * b[0]).sum::<f64>()
        };
        let around = |radius: f64, angle: f64| [radius * libm::cos(angle), radius * libm::sin(angle)];
        let arm = |start: f64| (0..200).map(move |step| around(start + 0.1 * f64::from(step), 0.2 * f64::from(step)));
        let spiral: Vec<_> = arm(1.0).chain(arm(0.5).rev()).collect();
        is_covered_once(&spiral, shoelace(&spiral));
        let star: Vec<_> = (0..1000)
            .map(|step| around(f64::from(1 + step % 2), f64::from(step) * std::f64::consts::TAU / 1000.0))
            .collect();
        is_covered_once(&star, shoelace(&star));
        let teeth = (0..500).flat_map(|tooth| [[f64::from(tooth) + 1.0, 1.0], [f64::from(tooth) + 1.5, 9.0]]).rev();
        let comb: Vec<_> = [[0.0, 0.0], [502.0, 0.0]].into_iter().chain(teeth).collect();
        is_covered_once(&comb, shoelace(&comb));
    }

    #[test]
    fn shapes_without_area_are_not_concave() {
        for shape in [vec![], vec![Vec3::ONE; 6], (0..6).map(|x| Vec3::X * x as f32).collect(), vec![Vec3::NAN; 5]] {
            assert!(concave_in(shape.iter().copied()).is_none(), "{shape:?}");
        }
    }

    #[test]
    fn a_ring_that_crosses_itself_is_cut_into_as_many_triangles() {
        let crossing = [[0.0, 0.0], [4.0, 4.0], [4.0, 0.0], [0.0, 4.0], [2.0, 9.0], [-5.0, 1.0]];
        assert_eq!(cut(&crossing).0.len(), 4);
    }

    #[test]
    fn when_there_are_no_tests_left_the_rest_is_cut_anyway() {
        let mut ears = Ears { tests_left: 3, ..Ears::default() };
        let points = C.iter().map(|&[x, y]| Vec3::new(x as f32, y as f32, 0.0));
        let plane = concave_in(points.clone()).expect("a concave outline");
        let mut count = 0;
        assert!(!ears.cut(points, plane, |_| count += 1));
        assert_eq!(count, 6);
    }
}
