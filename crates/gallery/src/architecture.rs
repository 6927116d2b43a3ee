//! Columns, walls with pointed openings, rib vaults and tracery.

use glam::{Affine3A, Vec2, Vec3, Vec3Swizzles};

use super::build::math::{around, mix, sin_cos, smoothstep, wave};
use super::build::{Detail, MeshBuilder, Sheet};
use super::hall_paints as paints;

/// A wall in its own space: along x around 0, y up, its front towards +Z.
#[derive(Clone, Copy, Debug)]
pub(super) struct Wall {
    pub(super) half_width: f32,
    pub(super) bottom: f32,
    pub(super) top: f32,
    pub(super) thickness: f32,
    pub(super) opening: Opening,
}

/// An opening with a pointed arch, in the space of its wall.
#[derive(Clone, Copy, Debug)]
pub(super) struct Opening {
    pub(super) half_width: f32,
    /// Height of its lower edge.
    pub(super) sill: f32,
    /// Height at which the arch begins.
    pub(super) spring: f32,
}

impl Opening {
    /// The left half of the arch at `part`, from its spring at 0 to its point at 1.
    fn arch(&self, part: f32) -> Vec2 {
        // An arc about a point a third of the half-width beyond the middle.
        let beyond = self.half_width / 3.0;
        let radius = self.half_width + beyond;
        let (sin, cos) = sin_cos(part * libm::acosf(beyond / radius));
        Vec2::new(beyond - radius * cos, self.spring + radius * sin)
    }

    /// The way around the opening from its lower left corner to the lower right one, `2·steps + 3` points.
    fn outline(&self, steps: u32) -> Vec<Vec2> {
        let left: Vec<Vec2> = std::iter::once(Vec2::new(-self.half_width, self.sill))
            .chain((0..=steps).map(|step| self.arch(step as f32 / steps as f32)))
            .collect();
        let right = left.iter().rev().skip(1).map(|point| Vec2::new(-point.x, point.y));
        left.iter().copied().chain(right).collect()
    }
}

/// Adds a wall with its opening.
pub(super) fn wall(builder: &mut MeshBuilder, wall: Wall, detail: Detail) {
    let Wall { half_width, bottom, top, thickness, opening } = wall;
    // Even, so that a point of the outline faces each upper corner.
    let steps = 2 * detail.quads(5, 1);
    let inner = opening.outline(steps);
    let outer = |point: usize| {
        let mirrored = point.min(inner.len() - 1 - point);
        let part = mirrored.saturating_sub(1) as f32 / steps as f32;
        let left = match mirrored {
            0 => Vec2::new(-half_width, opening.sill),
            _ if part <= 0.5 => Vec2::new(-half_width, mix(opening.spring, top, 2.0 * part)),
            _ => Vec2::new(mix(-half_width, 0.0, 2.0 * part - 1.0), top),
        };
        if mirrored == point { left } else { Vec2::new(-left.x, left.y) }
    };
    let columns = inner.len() as u32 - 1;
    let point = |u: f32| (u * columns as f32).round() as usize;
    let first = builder.positions.len();
    builder.paint(paints::ASHLAR);
    let faces: &[f32] = if detail.is_ornate() { &[1.0, -1.0] } else { &[1.0] };
    for &side in faces {
        let z = 0.5 * side * thickness;
        builder.sheet(Sheet::open(columns, 1), |u, v| {
            let outwards = (v > 0.5) == (side > 0.0);
            (if outwards { outer(point(u)) } else { inner[point(u)] }).extend(z)
        });
        if opening.sill > bottom {
            let [left, right] = [-side * half_width, side * half_width];
            let corners = [[left, bottom], [right, bottom], [right, opening.sill], [left, opening.sill]];
            builder.quad(corners.map(|[x, y]| Vec3::new(x, y, z)), Vec2::ONE);
        }
    }
    if detail.is_ornate() {
        reveal(builder, wall, &inner, detail);
    }
    builder.wrap(first, |position| position.xy() * Vec2::new(1.0, -1.0));
}

/// Adds the inside of an opening with the outline `inner`, and a moulding around its front.
fn reveal(builder: &mut MeshBuilder, wall: Wall, inner: &[Vec2], detail: Detail) {
    let Wall { thickness, opening, .. } = wall;
    let columns = inner.len() as u32 - 1;
    builder.paint(paints::STONE).sheet(Sheet::open(columns, 1), |u, v| {
        inner[(u * columns as f32).round() as usize].extend((v - 0.5) * thickness)
    });
    let sill = [(-1.0, 1.0), (1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)]
        .map(|(x, z)| Vec3::new(x * opening.half_width, opening.sill, 0.5 * z * thickness));
    builder.quad(sill, Vec2::ONE);
    let path: Vec<Vec3> = inner.iter().map(|point| point.extend(0.5 * thickness)).collect();
    builder.tube(&path, |_| 0.075, detail.quads(8, 3));
}

/// Adds the bars of a window: two lights with pointed heads, a ring above them, and panes between lead. A plain
/// building has none.
pub(super) fn tracery(builder: &mut MeshBuilder, opening: Opening, detail: Detail) {
    if !detail.is_ornate() {
        return;
    }
    let columns = detail.quads(8, 3);
    let Opening { half_width, sill, spring } = opening;
    let lower = spring - 0.25 * half_width;
    builder.paint(paints::STONE);
    let mullion = [Vec3::new(0.0, sill, 0.0), Vec3::new(0.0, lower + 0.5 * half_width, 0.0)];
    builder.tube(&mullion, |_| 0.055, columns);
    for side in [-0.5, 0.5] {
        let light = Opening { half_width: 0.5 * half_width, sill: lower, spring: lower };
        let head: Vec<Vec3> = light
            .outline(detail.quads(7, 2))
            .into_iter()
            .map(|point| Vec3::new(point.x + side * half_width, point.y, 0.0))
            .collect();
        builder.tube(&head, |_| 0.045, columns);
    }
    let ring = Vec3::new(0.0, spring + 0.62 * half_width, 0.0);
    for (radius, thickness) in [(0.3 * half_width, 0.045), (0.16 * half_width, 0.02)] {
        builder.ring(ring, radius, [thickness; 2], [columns, detail.quads(24, 5)]);
    }
    builder.paint(paints::LEAD);
    let bars = detail.things(((spring - sill) / 0.3) as u32);
    for bar in 1..bars {
        let y = mix(sill, lower, bar as f32 / bars as f32);
        builder.tube(&[Vec3::new(-half_width, y, 0.0), Vec3::new(half_width, y, 0.0)], |_| 0.012, 4);
    }
    for x in [-0.5, 0.5] {
        let ends = [sill, lower + 0.5 * half_width].map(|y| Vec3::new(x * half_width, y, 0.0));
        builder.tube(&ends, |_| 0.012, 4);
    }
}

/// Adds a clustered column that stands on the origin, up to the top of its capital at `height`.
pub(super) fn column(builder: &mut MeshBuilder, radius: f32, height: f32, detail: Detail) {
    let columns = detail.quads(40, 6);
    let capital = 1.5 * radius;
    builder.paint(paints::STONE);
    if !detail.is_ornate() {
        builder.lathe(&[Vec2::new(radius, 0.0), Vec2::new(radius, height)], columns);
        return;
    }
    let base = [
        (1.62, 0.0),
        (1.62, 0.36),
        (1.62, 0.36),
        (1.55, 0.42),
        (1.55, 0.5),
        (1.47, 0.58),
        (1.3, 0.62),
        (1.22, 0.72),
        (1.3, 0.82),
        (1.24, 0.92),
        (1.1, 0.96),
    ]
    .map(|(out, up)| Vec2::new(out, up) * radius);
    builder.lathe(&base, columns);
    builder.sheet(Sheet::tube(columns, detail.quads(6, 1)), |u, v| {
        around(u, radius * (0.84 + 0.2 * wave(4.0 * u).abs()), mix(0.9 * radius, height - 0.9 * capital, v))
    });
    // The capital: a bell of leaves that curl out under a slab.
    builder.sheet(Sheet::tube(columns, detail.quads(14, 2)), |u, v| {
        let leaves = wave(8.0 * u).abs() * smoothstep(0.1, 0.5, v) * smoothstep(1.0, 0.75, v);
        let collar = 0.14 * smoothstep(0.12, 0.06, (v - 0.06).abs());
        around(u, radius * (0.98 + collar + 0.5 * v * v + 0.16 * leaves), height - capital * (0.95 - 0.8 * v))
    });
    let slab = [(1.5, -0.16), (1.62, -0.13), (1.62, -0.05), (1.62, -0.05), (1.56, 0.0), (1.56, 0.0), (0.0, 0.0)]
        .map(|(out, up)| Vec2::new(out * radius, height + up * capital));
    builder.lathe(&slab, columns);
}

/// A vault over a rectangle: its half-sizes along x and z, where it begins, and how much higher its middle is.
#[derive(Clone, Copy, Debug)]
pub(super) struct Vault {
    pub(super) half_size: Vec2,
    pub(super) spring: f32,
    pub(super) rise: f32,
}

impl Vault {
    /// Height of the pointed arch at `out`, 0 in its middle and 1 at its foot.
    fn height(&self, out: f32) -> f32 {
        const RADIUS: f32 = 1.5;
        const BEYOND: f32 = RADIUS - 1.0;
        let out = out.abs().min(1.0) + BEYOND;
        let point = (RADIUS * RADIUS - BEYOND * BEYOND).sqrt();
        self.spring + self.rise * ((RADIUS * RADIUS - out * out).max(0.0).sqrt() / point)
    }

    /// The point of the rib or web at (x, z), each −1 … 1 from side to side.
    fn at(&self, x: f32, z: f32) -> Vec3 {
        let height = self.height(x.abs().min(z.abs()));
        Vec3::new(x * self.half_size.x, height, z * self.half_size.y)
    }
}

/// Adds a vault of four webs and their ribs around the origin, with the arch at its end towards +Z.
pub(super) fn vault(builder: &mut MeshBuilder, vault: Vault, rib_radius: f32, detail: Detail) {
    let sheet = Sheet::open(2 * detail.quads(5, 1), detail.quads(9, 1));
    builder.paint(paints::PLASTER);
    for quarter in 0..4 {
        builder.sheet(sheet, |u, v| {
            let (across, out) = ((2.0 * u - 1.0) * v, v);
            match quarter {
                0 => vault.at(across, out),
                1 => vault.at(out, -across),
                2 => vault.at(-across, -out),
                _ => vault.at(-out, across),
            }
        });
    }
    if !detail.is_ornate() {
        return;
    }
    let rows = 2 * detail.quads(9, 1);
    let columns = detail.quads(8, 3);
    let mut rib = |from: Vec2, to: Vec2, radius: f32| {
        let path: Vec<Vec3> = (0..=rows)
            .map(|row| {
                let point = from.lerp(to, row as f32 / rows as f32);
                vault.at(point.x, point.y)
            })
            .collect();
        builder.paint(paints::STONE).tube(&path, |_| radius, columns);
    };
    rib(Vec2::NEG_ONE, Vec2::ONE, rib_radius);
    rib(Vec2::new(-1.0, 1.0), Vec2::new(1.0, -1.0), rib_radius);
    rib(Vec2::new(-1.0, 1.0), Vec2::ONE, 1.4 * rib_radius);
    rib(Vec2::new(0.0, -1.0), Vec2::new(0.0, 1.0), 0.6 * rib_radius);
    let boss = Affine3A::from_translation(Vec3::new(0.0, vault.height(0.0) - 1.4 * rib_radius, 0.0));
    builder.place(boss, |builder| {
        let around = detail.quads(20, 4);
        builder.sphere(Vec3::ZERO, 2.0 * rib_radius, around, detail.quads(10, 3));
    });
}
