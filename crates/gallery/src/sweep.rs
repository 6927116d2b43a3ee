use glam::Vec3;

/// A soft tube through a few elliptical sections: limbs, noses, hats, branches and handles.
///
/// The coordinate `along` runs from 0 at the first section to 1 at the last one; the sections are spaced evenly in it and
/// joined by Catmull–Rom curves.
#[derive(Clone, Debug)]
pub(super) struct Sweep {
    /// At least two.
    sections: Vec<Section>,
    /// Roughly where each section's width points; never along the tube.
    side: Vec3,
    /// Fraction of the length that is rounded off at the start and at the end; an end with 0 is left open.
    rounded: [f32; 2],
}

/// An ellipse across a sweep.
#[derive(Clone, Copy, Debug)]
pub(super) struct Section {
    pub(super) center: Vec3,
    pub(super) half_width: f32,
    pub(super) half_depth: f32,
}

/// A sweep cut across at one point, ready to give the points around it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ring {
    center: Vec3,
    tangent: Vec3,
    width_axis: Vec3,
    depth_axis: Vec3,
    half_width: f32,
    half_depth: f32,
    /// Half-depth over half-width, before the ends are rounded off.
    flatness: f32,
    /// Slope along the curve of half the square of the half-width, and of the half-depth.
    growth: [f32; 2],
}

impl Section {
    pub(super) const fn round(center: Vec3, radius: f32) -> Self {
        Self { center, half_width: radius, half_depth: radius }
    }

    pub(super) const fn new(center: Vec3, half_width: f32, half_depth: f32) -> Self {
        Self { center, half_width, half_depth }
    }

    /// The section opposite to `other`, at the same distance from this one.
    fn mirrored(self, other: Self) -> Self {
        Self {
            center: 2.0 * self.center - other.center,
            half_width: 2.0 * self.half_width - other.half_width,
            half_depth: 2.0 * self.half_depth - other.half_depth,
        }
    }
}

impl Sweep {
    /// A sweep through `sections`, at least two.
    pub(super) fn new(sections: &[Section], side: Vec3, rounded: [f32; 2]) -> Self {
        Self { sections: sections.to_vec(), side, rounded }
    }

    /// An ellipsoid whose poles are at `center ± axis`.
    pub(super) fn ellipsoid(center: Vec3, axis: Vec3, side: Vec3, half_width: f32, half_depth: f32) -> Self {
        let ends = [center - axis, center + axis].map(|end| Section::new(end, half_width, half_depth));
        Self::new(&ends, side, [0.5, 0.5])
    }

    /// Moves every point by `move_point` and every direction by `turn`.
    pub(super) fn move_by(&mut self, move_point: impl Fn(Vec3) -> Vec3, turn: impl Fn(Vec3) -> Vec3) {
        for section in &mut self.sections {
            section.center = move_point(section.center);
        }
        self.side = turn(self.side);
    }

    /// Position along the sweep of ring `ring` of `rings + 1`: closer together towards rounded ends.
    pub(super) fn along(&self, ring: u32, rings: u32) -> f32 {
        let even = ring as f32 / rings.max(1) as f32;
        let crowding = if self.rounded.iter().all(|&length| length > 0.0) { 0.8 } else { 0.0 };
        (even - crowding * libm::sinf(std::f32::consts::TAU * even) / std::f32::consts::TAU).clamp(0.0, 1.0)
    }

    /// The sweep's section at `along`, 0 … 1.
    pub(super) fn ring(&self, along: f32) -> Ring {
        let spans = (self.sections.len() - 1) as f32;
        let span = ((along * spans) as usize).min(self.sections.len() - 2);
        let part = along * spans - span as f32;
        let [from, to] = [self.sections[span], self.sections[span + 1]];
        // Beyond the ends the curve goes on straight, which keeps two sections a straight tube.
        let before = if span == 0 { from.mirrored(to) } else { self.sections[span - 1] };
        let after = if span + 2 == self.sections.len() { to.mirrored(from) } else { self.sections[span + 2] };
        let four = [before, from, to, after];
        let (weights, slopes) = catmull_rom(part);
        let mix = |weights: [f32; 4]| {
            four.iter().zip(weights).fold((Vec3::ZERO, 0.0, 0.0), |(center, width, depth), (section, weight)| {
                (
                    center + section.center * weight,
                    width + section.half_width * weight,
                    depth + section.half_depth * weight,
                )
            })
        };
        let (center, width, depth) = mix(weights);
        let (center_slope, width_slope, depth_slope) = mix(slopes.map(|slope| slope * spans));
        let (width, depth) = (width.max(0.0), depth.max(0.0));
        let (cap, cap_slope) = self.squared_cap(along);
        let speed = center_slope.length().max(1e-9);
        let tangent = center_slope / speed;
        let width_axis = (self.side - tangent * tangent.dot(self.side)).normalize_or(tangent.any_orthonormal_vector());
        let growth = |size: f32, slope: f32| (size * slope * cap + 0.5 * size * size * cap_slope) / speed;
        Ring {
            center,
            tangent,
            width_axis,
            depth_axis: tangent.cross(width_axis),
            half_width: width * cap.sqrt(),
            half_depth: depth * cap.sqrt(),
            flatness: if width > 0.0 { (depth / width).max(1e-3) } else { 1.0 },
            growth: [growth(width, width_slope), growth(depth, depth_slope)],
        }
    }

    /// Square of the factor by which the rounding of the ends scales the size, and its slope.
    fn squared_cap(&self, along: f32) -> (f32, f32) {
        let [start, end] = self.rounded;
        let one_end = |distance: f32, length: f32| {
            let missing = 1.0 - distance / length;
            (1.0 - missing * missing, 2.0 * missing / length)
        };
        if along < start {
            one_end(along, start)
        } else if 1.0 - along < end {
            let (cap, slope) = one_end(1.0 - along, end);
            (cap, -slope)
        } else {
            (1.0, 0.0)
        }
    }
}

impl Ring {
    /// The point and the outward unit normal in the direction whose cosine (along the width) and sine are given.
    pub(super) fn point(&self, cosine: f32, sine: f32) -> (Vec3, Vec3) {
        let position =
            self.center + self.width_axis * (self.half_width * cosine) + self.depth_axis * (self.half_depth * sine);
        // The gradient of (x/a)² + (y/b)² with both half-axes growing along the tube, times ab/2: finite at the ends,
        // where both half-axes vanish.
        let cap = self.half_width;
        let across = self.width_axis * (cap * self.flatness * cosine) + self.depth_axis * (cap * sine);
        let [width_growth, depth_growth] = self.growth;
        let along = self.flatness * width_growth * cosine * cosine + depth_growth * sine * sine / self.flatness;
        let normal = (across - self.tangent * along).normalize_or(self.tangent);
        (position, normal)
    }
}

/// The weights of four evenly spaced values at `part` of the way from the second to the third, and their slopes.
pub(super) fn catmull_rom(part: f32) -> ([f32; 4], [f32; 4]) {
    let (square, cube) = (part * part, part * part * part);
    let weights = [
        0.5 * (-cube + 2.0 * square - part),
        0.5 * (3.0 * cube - 5.0 * square + 2.0),
        0.5 * (-3.0 * cube + 4.0 * square + part),
        0.5 * (cube - square),
    ];
    let slopes = [
        0.5 * (-3.0 * square + 4.0 * part - 1.0),
        0.5 * (9.0 * square - 10.0 * part),
        0.5 * (-9.0 * square + 8.0 * part + 1.0),
        0.5 * (3.0 * square - 2.0 * part),
    ];
    (weights, slopes)
}

#[cfg(test)]
mod tests {
    use std::f32::consts::TAU;

    use super::*;

    fn samples() -> impl Iterator<Item = (f32, f32)> {
        (0..=20).flat_map(|row| (0..16).map(move |column| (row as f32 / 20.0, column as f32 / 16.0)))
    }

    fn point(sweep: &Sweep, along: f32, turns: f32) -> (Vec3, Vec3) {
        let (sin, cos) = libm::sincosf(TAU * turns);
        sweep.ring(along).point(cos, sin)
    }

    #[test]
    fn an_ellipsoid_has_its_closed_form() {
        let (center, half) = (Vec3::new(1.0, 2.0, 3.0), Vec3::new(0.5, 2.0, 0.8));
        let sweep = Sweep::ellipsoid(center, Vec3::Y * half.y, Vec3::X, half.x, half.z);
        for (along, turns) in samples() {
            let (position, normal) = point(&sweep, along, turns);
            let unit = (position - center) / half;
            assert!((unit.length() - 1.0).abs() < 1e-4, "{along} {turns}: {unit}");
            let exact = (unit / half).normalize();
            assert!(normal.dot(exact) > 0.9999, "{along} {turns}: {normal}, not {exact}");
        }
    }

    #[test]
    fn normals_of_a_bent_tube_stand_on_it() {
        let sections = [(0.0, 0.3), (1.0, 0.25), (2.0, 0.4), (3.0, 0.2)]
            .map(|(x, size)| Section::new(Vec3::new(x, 0.1 * x * x, 0.0), size, 0.7 * size));
        let sweep = Sweep::new(&sections, Vec3::Z, [0.1, 0.1]);
        for (along, turns) in samples().filter(|(along, _)| (0.12..0.88).contains(along)) {
            let (_, normal) = point(&sweep, along, turns);
            let around = point(&sweep, along, turns + 1e-3).0 - point(&sweep, along, turns - 1e-3).0;
            let ahead = point(&sweep, along + 1e-3, turns).0 - point(&sweep, along - 1e-3, turns).0;
            assert!(normal.dot(around.cross(ahead).normalize()) > 0.99, "{along} {turns}: {normal}");
        }
    }
}
