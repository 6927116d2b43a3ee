// Angles around a light as integers, and the arcs of triangles there. Integers decide which cells a triangle is in,
// because two pipelines may round differently.

import package::grid::header::{HEADER_ANGLES, HEADER_ANGLES_DIVIDED};
import package::grid::space::{ordered_bits};
import package::light::cells::{BINS};
import package::light::sphere::turn::{ANGLE_NOWHERE, HALF_TURN, TURN};
import stage::{header};

// Log2 of the inverse relative error of an angle. With ε = 2⁻²⁴: each coordinate has a rounding, which is 2 ε of the
// quotient; the sum has ε, the quotient 5 ε (2.5 units in the last place), and on the far side the difference from half
// a turn has 2 ε of an angle that is larger. Together they are below 2⁻²⁰.
const ANGLE_ERROR_BITS: u32 = 20u;
// Error of angles besides, in units. For a corner 16, since its coordinates have an error of 2⁻⁴⁹ of the largest, and
// are above 2⁻²⁴ of that, which moves the quotient by 2⁻⁴⁸⁺²⁴; for a corner and for a point 2 more for truncation.
const ANGLE_SPARE: i32 = 32;
// Minimum difference between half a turn and the angle between two corners, for it to be known which of two arcs a
// triangle covers: far above both corners' errors of at most 2²⁹⁻²⁰ + 32 units each.
const HALF_TURN_MARGIN: i32 = 4096;

// From one angle to another, which may be beyond half a turn.
struct Arc {
    start: i32,
    end: i32,
}

const ARC_EVERYTHING: Arc = Arc(-TURN, TURN);

// Range of all points' angles: of α with number 0, of β with 1.
struct SeenAngles {
    low: i32,
    high: i32,
    error: i32,
    // The range that is divided into bins; the first and the last bin also have everything outside of it.
    first: i32,
    last: i32,
}

fn ordered_angle(angle: i32) -> u32 {
    return u32(angle) ^ 0x80000000u;
}

fn seen_angles(plane: u32) -> SeenAngles {
    let word = HEADER_ANGLES + 3u * plane;
    let low = i32(~atomicLoad(&header[word]) ^ 0x80000000u);
    let high = i32(atomicLoad(&header[word + 1u]) ^ 0x80000000u);
    let error = i32(atomicLoad(&header[word + 2u]));
    let first = i32(atomicLoad(&header[HEADER_ANGLES_DIVIDED + plane]));
    let last = i32(atomicLoad(&header[HEADER_ANGLES_DIVIDED + 2u + plane]));
    // By default the range of the points.
    if first >= last {
        return SeenAngles(low, high, error, low, high);
    }
    return SeenAngles(low, high, error, first, last);
}

// The bin of an angle: never below that of a smaller angle.
fn bin_of(angle: i32, seen: SeenAngles) -> u32 {
    let range = u32(seen.last - seen.first);
    let part = u32(clamp(angle, seen.first, seen.last) - seen.first);
    // To 20 bits, so that products with the number of bins stay below 2³².
    let shift = u32(max(12 - i32(countLeadingZeros(range)), 0));
    return (part >> shift) * BINS / ((range >> shift) + 1u);
}

// The arc that a triangle covers, from its corners' angles.
//
// Look along the normal of the angles' plane. If the line through the light along this normal misses the triangle, the
// triangle covers less than half a turn around the light, with a corner at either end. If the line meets it, it may be
// all around.
fn arc_of(corners: vec3<i32>, seen: SeenAngles) -> Arc {
    let low = min(min(corners.x, corners.y), corners.z);
    let high = max(max(corners.x, corners.y), corners.z);
    let middle = max(min(corners.x, corners.y), min(max(corners.x, corners.y), corners.z));
    const ENOUGH: i32 = HALF_TURN + HALF_TURN_MARGIN;
    var arc = Arc(low, high);
    // The error of the ends, and of the points in between, is relative to the largest angle there.
    var largest = max(abs(low), abs(high));
    if high >= ANGLE_NOWHERE {
        return ARC_EVERYTHING;
    } else if TURN - (high - low) <= ENOUGH {
        largest = HALF_TURN;
        if high - middle > ENOUGH {
            arc = Arc(high, middle + TURN);
        } else if middle - low > ENOUGH {
            arc = Arc(middle, low + TURN);
        } else {
            return ARC_EVERYTHING;
        }
    }
    let margin = 2 * ((largest >> ANGLE_ERROR_BITS) + ANGLE_SPARE) + seen.error;
    return Arc(arc.start - margin, arc.end + margin);
}

// The bins of an arc before and beyond the seam at half a turn: first and last of each, empty if first > last.
fn bins_of(arc: Arc, seen: SeenAngles) -> vec4<i32> {
    var beyond = Arc(TURN, -TURN);
    if arc.end > HALF_TURN {
        beyond = Arc(-TURN, arc.end - TURN);
    } else if arc.start < -HALF_TURN {
        beyond = Arc(arc.start + TURN, TURN);
    }
    return vec4<i32>(bins_of_part(arc, seen), bins_of_part(beyond, seen));
}

fn bins_of_part(part: Arc, seen: SeenAngles) -> vec2<i32> {
    if part.start > part.end || part.start > seen.high || part.end < seen.low {
        return vec2<i32>(0, -1);
    }
    return vec2<i32>(i32(bin_of(part.start, seen)), i32(bin_of(part.end, seen)));
}

// Two ranges, or one where they overlap.
fn merged(ranges: vec4<i32>) -> vec4<i32> {
    let are_two = ranges.x <= ranges.y && ranges.z <= ranges.w;
    if !are_two || ranges.x > ranges.w || ranges.z > ranges.y {
        return ranges;
    }
    return vec4<i32>(min(ranges.x, ranges.z), max(ranges.y, ranges.w), 0, -1);
}

// Ordered bits of at least the key of the point of the corners' bounds that is nearest to the light, from the bits of
// coordinates.
fn nearest_key(a: vec3<u32>, b: vec3<u32>, c: vec3<u32>) -> u32 {
    // Ordered bits of negative numbers and of 0 are below this.
    const ZERO: u32 = 0x80000000u;
    var nearest = ZERO;
    for (var axis = 0u; axis < 3u; axis++) {
        let corners = bitcast<vec3<f32>>(vec3<u32>(a[axis], b[axis], c[axis]));
        let of_corners = vec3<u32>(ordered_bits(corners.x), ordered_bits(corners.y), ordered_bits(corners.z));
        let low = min(min(of_corners.x, of_corners.y), of_corners.z);
        let high = max(max(of_corners.x, of_corners.y), of_corners.z);
        // The complement is the negative number.
        nearest = max(nearest, max(low, ~high));
    }
    // Coordinates have an error of a unit in the last place.
    return ~nearest + 8u;
}
