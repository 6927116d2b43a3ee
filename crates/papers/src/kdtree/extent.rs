use glam::Vec3;

use super::Clipping;

/// A box that includes its faces. 24 bytes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extent {
    /// The lowest coordinates.
    pub min: [f32; 3],
    /// The highest coordinates.
    pub max: [f32; 3],
}

impl Default for Extent {
    fn default() -> Self {
        Self::EMPTY
    }
}

impl Extent {
    /// The box that holds no point.
    pub const EMPTY: Self = Self { min: [f32::INFINITY; 3], max: [f32::NEG_INFINITY; 3] };

    /// Returns the box around points. A zero has no sign, so that equal coordinates have equal bits.
    #[inline(always)]
    pub fn around<const N: usize>(points: [Vec3; N]) -> Self {
        let mut extent = Self::EMPTY;
        for point in points {
            extent.include((point + 0.0).to_array());
        }
        extent
    }

    #[inline(always)]
    fn include(&mut self, point: [f32; 3]) {
        for (axis, coordinate) in point.into_iter().enumerate() {
            self.min[axis] = self.min[axis].min(coordinate);
            self.max[axis] = self.max[axis].max(coordinate);
        }
    }

    /// The box around both.
    #[inline(always)]
    pub fn union(self, other: Self) -> Self {
        Self {
            min: std::array::from_fn(|axis| self.min[axis].min(other.min[axis])),
            max: std::array::from_fn(|axis| self.max[axis].max(other.max[axis])),
        }
    }

    /// Returns the box that both share; `None` if they don't even touch.
    #[inline(always)]
    pub fn intersection(self, other: Self) -> Option<Self> {
        let both = Self {
            min: std::array::from_fn(|axis| self.min[axis].max(other.min[axis])),
            max: std::array::from_fn(|axis| self.max[axis].min(other.max[axis])),
        };
        (0..3).all(|axis| both.min[axis] <= both.max[axis]).then_some(both)
    }

    /// The largest magnitude of a coordinate; zero if empty.
    pub fn reach(&self) -> f32 {
        let faces = self.min.into_iter().chain(self.max);
        if self.is_empty() { 0.0 } else { faces.fold(0.0, |reach, face| reach.max(face.abs())) }
    }

    /// Whether no point is inside.
    pub fn is_empty(&self) -> bool {
        (0..3).any(|axis| self.min[axis] > self.max[axis])
    }

    /// The parts below and above a plane through the box.
    pub fn cut(self, plane: Plane) -> [Self; 2] {
        let [mut below, mut above] = [self, self];
        below.max[plane.axis] = plane.at;
        above.min[plane.axis] = plane.at;
        [below, above]
    }

    /// Half the area of the box's surface.
    pub fn half_area(&self) -> f64 {
        let [x, y, z] = [0, 1, 2].map(|axis| f64::from(self.max[axis]) - f64::from(self.min[axis]));
        x * y + y * z + z * x
    }
}

/// A plane across an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    /// Index of the axis, 0 to 2.
    pub axis: usize,
    /// Coordinate of the plane along that axis.
    pub at: f32,
}

/// A triangle in a cell: its id, and a box around the part of it in that cell. 28 bytes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Reference {
    /// Bounds of the part in the cell.
    pub extent: Extent,
    /// The triangle's id.
    pub id: u32,
}

/// The sides of a plane on which a reference is listed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Sides {
    /// Below.
    Left,
    /// Above.
    Right,
    /// On both.
    Both,
}

impl Reference {
    /// Returns the sides on which it is listed. `planar_left` decides for a reference inside the plane.
    #[inline(always)]
    pub(crate) fn sides(&self, plane: Plane, planar_left: bool) -> Sides {
        let (low, high) = (self.extent.min[plane.axis], self.extent.max[plane.axis]);
        if high < plane.at || (high == plane.at && (low < high || planar_left)) {
            Sides::Left
        } else if low >= plane.at {
            Sides::Right
        } else {
            Sides::Both
        }
    }

    /// Returns the parts below and above a plane that goes through the box; `None` where the triangle certainly has none.
    pub(crate) fn cut(
        &self,
        plane: Plane,
        clipping: Clipping,
        corners: impl FnOnce() -> [Vec3; 3],
    ) -> [Option<Self>; 2] {
        let halves = self.extent.cut(plane);
        let parts = match clipping {
            Clipping::Boxes => halves.map(Some),
            Clipping::Triangles => {
                let [below, above] = clip(corners(), plane);
                [halves[0].intersection(below), halves[1].intersection(above)]
            }
        };
        parts.map(|part| part.map(|extent| Self { extent, id: self.id }))
    }
}

/// Returns boxes around the parts of a triangle below and above a plane (Soupikov et al. 2008): around its corners there and
/// the points where its edges cross the plane, rounded outwards.
fn clip(corners: [Vec3; 3], plane: Plane) -> [Extent; 2] {
    let [mut below, mut above] = [Extent::EMPTY; 2];
    let corners = corners.map(|corner| (corner + 0.0).to_array());
    for index in 0..3 {
        let (from, to) = (corners[index], corners[(index + 1) % 3]);
        let (start, end) = (from[plane.axis], to[plane.axis]);
        if start <= plane.at {
            below.include(from);
        }
        if start >= plane.at {
            above.include(from);
        }
        if start.min(end) < plane.at && plane.at < start.max(end) {
            let crossing = crossing(from, to, plane);
            below = below.union(crossing);
            above = above.union(crossing);
        }
    }
    [below, above]
}

/// A box around the point where an edge crosses a plane that is strictly between its ends.
///
/// Computed in f64 with seven roundings of numbers no larger than the sum of the ends' magnitudes; the margin, 2⁻⁴⁹ of that
/// sum, is more than twice as much.
fn crossing(from: [f32; 3], to: [f32; 3], plane: Plane) -> Extent {
    const MARGIN: f64 = 1.0 / (1_u64 << 49) as f64;
    let at = f64::from(plane.at);
    let start = f64::from(from[plane.axis]);
    let weight = (at - start) / (f64::from(to[plane.axis]) - start);
    let mut extent = Extent { min: [plane.at; 3], max: [plane.at; 3] };
    for axis in (0..3).filter(|&axis| axis != plane.axis) {
        let (a, b) = (f64::from(from[axis]), f64::from(to[axis]));
        let value = a + (b - a) * weight;
        let margin = (a.abs() + b.abs()) * MARGIN;
        // Rounding might lead beyond the ends.
        let (low, high) = (from[axis].min(to[axis]), from[axis].max(to[axis]));
        extent.min[axis] = round_down(value - margin).max(low) + 0.0;
        extent.max[axis] = round_up(value + margin).min(high) + 0.0;
    }
    extent
}

fn round_down(value: f64) -> f32 {
    let rounded = value as f32;
    if f64::from(rounded) > value { rounded.next_down() } else { rounded }
}

fn round_up(value: f64) -> f32 {
    let rounded = value as f32;
    if f64::from(rounded) < value { rounded.next_up() } else { rounded }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clipped_boxes_hold_their_part_and_little_else() {
        let corners = [Vec3::new(0.0, 0.0, 0.0), Vec3::new(3.0, 1.0, 0.5), Vec3::new(1.0, 3.0, 7.0)];
        let [below, above] = clip(corners, Plane { axis: 0, at: 1.0 });
        // The edge from the first to the second corner is at y = 1/3, z = 1/6 there.
        assert_eq!((below.min, below.max), ([0.0; 3], [1.0, 3.0, 7.0]));
        let exact = [1.0, 1.0 / 3.0, 0.5 / 3.0];
        for (min, exact) in above.min.into_iter().zip(exact) {
            assert!(f64::from(min) <= exact && f64::from(min) > exact - 1e-7);
        }
        assert_eq!((above.min[0], above.max), (1.0, [3.0, 3.0, 7.0]));
    }

    #[test]
    fn sides_follow_the_plane() {
        let at =
            |low: f32, high: f32| Reference { extent: Extent { min: [low, 0.0, 0.0], max: [high, 1.0, 1.0] }, id: 0 };
        let plane = Plane { axis: 0, at: 1.0 };
        for planar_left in [false, true] {
            assert_eq!(at(0.0, 1.0).sides(plane, planar_left), Sides::Left);
            assert_eq!(at(1.0, 2.0).sides(plane, planar_left), Sides::Right);
            assert_eq!(at(0.0, 2.0).sides(plane, planar_left), Sides::Both);
        }
        assert_eq!(at(1.0, 1.0).sides(plane, true), Sides::Left);
        assert_eq!(at(1.0, 1.0).sides(plane, false), Sides::Right);
    }
}
