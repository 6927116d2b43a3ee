use glam::{DVec2, DVec3};

use super::face::{Face, POINT_LIMIT, ROUNDING};
use super::survey::SurveyedTile;
use crate::LightSource;
use crate::shot::Cone;

/// The largest scale of a face: the limit keeps f64's rounding errors small beside those of f32.
const LARGEST_SCALE: f64 = (1 << 18) as f64;

/// Points farther than this from a face's axis, as a tangent, need a cube.
///
/// Up to 6 would do for [`VertexErrors`](super::face::VertexErrors), but far from the axis blocks of pixels are long and
/// thin: in the statue's second light 6 made 2.3 times as many tests of 16 points as four sides of a cube.
const WIDEST: f64 = 1.6;

/// A side of a cube around the light.
#[derive(Clone, Copy, Debug)]
struct Side {
    axis: usize,
    is_positive: bool,
}

impl Side {
    const ALL: [Self; 6] = [
        Self { axis: 0, is_positive: true },
        Self { axis: 0, is_positive: false },
        Self { axis: 1, is_positive: true },
        Self { axis: 1, is_positive: false },
        Self { axis: 2, is_positive: true },
        Self { axis: 2, is_positive: false },
    ];

    fn axes(self) -> [DVec3; 3] {
        let forward = DVec3::AXES[self.axis] * if self.is_positive { 1.0 } else { -1.0 };
        [DVec3::AXES[(self.axis + 1) % 3], DVec3::AXES[(self.axis + 2) % 3], forward]
    }
}

/// Chooses the faces through which a light sees all points of `tiles`, with X `along` a direction where that can be; `None`
/// where the light is no light at all and reaches everything.
pub fn choose(light: &LightSource, along: DVec3, tiles: &[SurveyedTile], faces: &mut Vec<Face>) -> Option<()> {
    faces.clear();
    match *light {
        LightSource::Point { position } | LightSource::Spot { position, .. } => {
            let origin = position.is_finite().then(|| position.as_dvec3())?;
            if let Some((axes, widest)) = Cone::of(light).and_then(|cone| around_cone(&cone, along)) {
                faces.extend(seen_within(origin, axes, widest, tiles));
            } else if let Some(face) = in_one(origin, along, tiles) {
                faces.push(face);
            } else {
                faces.extend(Side::ALL.iter().filter_map(|side| seen_within(origin, side.axes(), 1.0, tiles)));
            }
        }
        LightSource::Directional { direction } => {
            let direction = direction.as_dvec3();
            let direction = direction.is_finite().then(|| direction.try_normalize()).flatten()?;
            faces.push(parallel(direction, along, tiles));
        }
    }
    Some(())
}

fn filled(tiles: &[SurveyedTile]) -> impl Iterator<Item = &SurveyedTile> {
    tiles.iter().filter(|tile| tile.points > 0)
}

fn corners(tiles: &[SurveyedTile]) -> impl Iterator<Item = DVec3> {
    filled(tiles).flat_map(|tile| tile.corners)
}

/// Two vectors that with `forward` make a right-angled frame, the first as near as possible to `along`.
///
/// Along the image's rows, the points of 4×4 pixels fill more of their bounds: 5 to 20 % fewer tests of 16 points in the
/// cloth, the statue, the marbles and the hall than along any other, but 7 % more in the forest and 21 % in the shards.
pub fn across(forward: DVec3, along: DVec3) -> (DVec3, DVec3) {
    let across = |along: DVec3| (along - forward * forward.dot(along)).normalize_or_zero();
    // Repeated for the rounding error left where they are nearly parallel: positions along parallel light share X and Y.
    let right = across(across(along));
    let is_across = right.is_normalized() && forward.dot(right).abs() < 8.0 * ROUNDING;
    let right = if is_across { right } else { forward.any_orthonormal_vector() };
    (right, forward.cross(right))
}

/// A rectangle by its middle and half its sides.
struct Rectangle {
    middle: DVec2,
    half: DVec2,
}

impl Rectangle {
    fn around(points: impl Iterator<Item = DVec2>, smallest: f64) -> Self {
        let (min, max) =
            points.fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(min, max), point| (min.min(point), max.max(point)));
        if min.cmpgt(max).any() {
            return Self { middle: DVec2::ZERO, half: DVec2::ONE };
        }
        let half = (max - min) * 0.5;
        Self { middle: min + half, half: half.max(DVec2::splat(smallest)) }
    }
}

/// The one face that sees everything, if the light is outside and the points aren't spread too wide for one.
fn in_one(origin: DVec3, along: DVec3, tiles: &[SurveyedTile]) -> Option<Face> {
    let towards = |tile: &SurveyedTile| (tile.corners.iter().sum::<DVec3>() * 0.125 - origin).normalize_or_zero();
    let mut middle = filled(tiles).map(towards).sum::<DVec3>().try_normalize()?;
    // Towards the middle of the smallest ball around all directions: each step moves a shorter way to the farthest one. The
    // result needn't be exact, so every third corner will do, which is another one of each tile.
    for step in 2..16 {
        let directions = corners(tiles).step_by(3).map(|corner| (corner - origin).normalize_or_zero());
        let (_, farthest) = directions.fold((0.0, middle), |(most, farthest), direction| {
            let distance = direction.distance_squared(middle);
            if distance > most { (distance, direction) } else { (most, farthest) }
        });
        middle += (farthest - middle) / f64::from(step);
    }
    let forward = middle.try_normalize()?;
    let (right, up) = across(forward, along);
    let mut nearest = f64::INFINITY;
    for corner in corners(tiles) {
        let v = corner - origin;
        let z = forward.dot(v);
        // Written so that NaN is too wide.
        let fits = z > 0.0 && right.dot(v).abs().max(up.dot(v).abs()) < WIDEST * z;
        if !fits {
            return None;
        }
        nearest = nearest.min(z);
    }
    let seen = corners(tiles).map(|corner| {
        let v = corner - origin;
        DVec2::new(right.dot(v), up.dot(v)) / forward.dot(v)
    });
    Some(perspective(origin, [right, up, forward], &Rectangle::around(seen, 1.0 / LARGEST_SCALE), nearest, None))
}

fn perspective(
    origin: DVec3,
    [right, up, forward]: [DVec3; 3],
    rectangle: &Rectangle,
    near: f64,
    widest: Option<f64>,
) -> Face {
    let scale = rectangle.half.recip();
    // The limits where other sides of a cube begin, or the cone ends, plus half of the margin by which points may be outside
    // of the face.
    let overlap = 0.5 * (POINT_LIMIT - 1.0);
    let owned = |axis: usize, widest: f64| {
        let end = |sign: f64| (sign * widest - rectangle.middle[axis]) * scale[axis] + sign * overlap;
        [end(-1.0), end(1.0)]
    };
    Face {
        origin,
        x: (right - forward * rectangle.middle.x) * scale.x,
        y: (up - forward * rectangle.middle.y) * scale.y,
        z: forward,
        near,
        is_parallel: false,
        scale: scale.extend(1.0),
        owned: widest.map(|widest| [owned(0, widest), owned(1, widest)]),
        point_error: 0.0,
    }
}

/// The axes of a face around a cone, and its half width, as a tangent; `None` if it is too wide for one.
fn around_cone(cone: &Cone, along: DVec3) -> Option<([DVec3; 3], f64)> {
    let forward = cone.axis.try_normalize()?;
    // Far more than rounding moves the cone's edge, in the predicate or when points are shaded.
    let squared_cosine = cone.squared_cosine / cone.axis.length_squared() - 4e-5;
    let widest = (1.0 / squared_cosine - 1.0).sqrt();
    let (right, up) = across(forward, along);
    (squared_cosine > 0.0 && widest < WIDEST).then_some(([right, up, forward], widest))
}

/// The face that sees all points at most `widest` from its axis, as a tangent, if there are any: a side of a cube with one.
fn seen_within(origin: DVec3, [right, up, forward]: [DVec3; 3], widest: f64, tiles: &[SurveyedTile]) -> Option<Face> {
    let (mut min, mut max) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
    let (mut nearest, mut farthest) = (f64::INFINITY, 0.0_f64);
    for tile in filled(tiles) {
        let corners = tile.corners.map(|corner| corner - origin);
        let depths = corners.map(|v| forward.dot(v));
        let nearest_here = depths.into_iter().fold(f64::INFINITY, f64::min);
        let farthest_here = depths.into_iter().fold(f64::NEG_INFINITY, f64::max);
        // Far more than rounding, where corners are about in the light's plane.
        let size = corners.into_iter().fold(0.0, |size: f64, v| v.abs().max_element().max(size));
        if farthest_here < size * -1e-12 {
            continue;
        }
        farthest = farthest.max(farthest_here);
        let limit = DVec2::splat(widest);
        let (mut low, mut high) = (-limit, limit);
        if nearest_here > 0.0 {
            let seen = corners.map(|v| DVec2::new(right.dot(v), up.dot(v)) / forward.dot(v));
            low = seen.into_iter().fold(DVec2::INFINITY, DVec2::min).max(-limit);
            high = seen.into_iter().fold(DVec2::NEG_INFINITY, DVec2::max).min(limit);
            if low.cmpgt(high).any() {
                continue;
            }
        }
        nearest = nearest.min(nearest_here);
        (min, max) = (min.min(low), max.max(high));
    }
    if min.cmpgt(max).any() {
        return None;
    }
    let rectangle = Rectangle::around([min, max].into_iter(), 1.0 / LARGEST_SCALE);
    // Any depth will do: it only keeps numbers near one.
    let near = if nearest > 0.0 { nearest } else { farthest * 1e-3 };
    Some(perspective(origin, [right, up, forward], &rectangle, near.max(f64::MIN_POSITIVE), Some(widest)))
}

/// The face of light that travels along `direction`.
fn parallel(direction: DVec3, along: DVec3, tiles: &[SurveyedTile]) -> Face {
    let (right, up) = across(direction, along);
    let map = |axis: DVec3| {
        let range = corners(tiles).map(|corner| axis.dot(corner));
        range.fold((f64::INFINITY, f64::NEG_INFINITY), |(min, max), at| (min.min(at), max.max(at)))
    };
    let ranges = [right, up, -direction].map(map);
    let middle = ranges.map(|(min, max)| if min <= max { min * 0.5 + max * 0.5 } else { 0.0 });
    let half = ranges.map(|(min, max)| if min <= max { (max - min) * 0.5 } else { 1.0 });
    // The scale stays bounded where all points share a coordinate.
    let size = half.into_iter().fold(0.0, f64::max);
    let size = if size > 0.0 { size } else { middle.into_iter().fold(1e-30, |size, at| at.abs().max(size)) };
    let scale = DVec3::from_array(half.map(|half| half.max(size / LARGEST_SCALE).recip()));
    let origin = right * middle[0] + up * middle[1] - direction * middle[2];
    Face {
        origin,
        x: right * scale.x,
        y: up * scale.y,
        z: -direction * scale.z,
        near: 1.0,
        is_parallel: true,
        scale,
        owned: None,
        point_error: 0.0,
    }
}

#[cfg(test)]
pub(crate) mod tests;
