//! Simple solids and surfaces.

use std::f32::consts::{FRAC_PI_4, PI, TAU};

use glam::{Vec2, Vec3, Vec3Swizzles};

use super::math::{around, sin_cos};
use super::{MeshBuilder, Sheet};

impl MeshBuilder {
    /// Adds a flat quad with corners counterclockwise; texture coordinates span (0, 0) … `repeats`, the first
    /// corner being the lower left one.
    pub(crate) fn quad(&mut self, corners: [Vec3; 4], repeats: Vec2) -> &mut Self {
        let coords = [Vec2::new(0.0, 1.0), Vec2::ONE, Vec2::new(1.0, 0.0), Vec2::ZERO];
        let [a, b, c, d] =
            std::array::from_fn(|corner| self.vertex(corners[corner], Vec3::ZERO, coords[corner] * repeats));
        self.triangle([a, b, c]);
        self.triangle([a, c, d]);
        self
    }

    /// Adds a horizontal rectangle around `center`, facing up, of `size` along x and z in `columns` × `rows`
    /// quads. Texture coordinates are world x and z.
    pub(crate) fn floor(&mut self, center: Vec3, size: Vec2, [columns, rows]: [u32; 2]) -> &mut Self {
        let first = self.positions.len();
        let sheet = Sheet::open(columns, rows);
        for index in 0..sheet.vertices() {
            let at = sheet.coords(index) - 0.5;
            let position = center + Vec3::new(at.x * size.x, 0.0, -at.y * size.y);
            self.vertex(position, Vec3::ZERO, position.xz());
        }
        self.triangles_from(first, sheet.triangles());
        self
    }

    /// Adds a box with sharp edges: 12 triangles. Each side's texture coordinates are lengths in world units.
    pub(crate) fn cuboid(&mut self, min: Vec3, max: Vec3) -> &mut Self {
        let size = max - min;
        let at = |x: f32, y: f32, z: f32| min + size * Vec3::new(x, y, z);
        let side = |builder: &mut Self, a: Vec3, across: Vec3, along: Vec3| {
            let repeats = Vec2::new(across.length(), along.length());
            builder.quad([a, a + across, a + across + along, a + along], repeats);
        };
        let [x, y, z] = [Vec3::X * size.x, Vec3::Y * size.y, Vec3::Z * size.z];
        side(self, at(0.0, 0.0, 1.0), x, y);
        side(self, at(1.0, 0.0, 0.0), -x, y);
        side(self, at(1.0, 0.0, 1.0), -z, y);
        side(self, at(0.0, 0.0, 0.0), z, y);
        side(self, at(0.0, 1.0, 1.0), x, -z);
        side(self, at(0.0, 0.0, 0.0), x, z);
        self
    }

    /// Adds a box around the origin whose edges and corners are rounded by `radius`, at most the least of
    /// `half_size`; `bevels` above zero quads to each eighth of a circle: 12·(2·bevels + 1)² triangles.
    pub(crate) fn rounded_cuboid(&mut self, half_size: Vec3, radius: f32, bevels: u32) -> &mut Self {
        let core = half_size - radius;
        // One side's lines: an arc, the flat middle, an arc. Which end of the core, and the tangent of the angle.
        let line = |at: u32| {
            let eighth = if at <= bevels { at as f32 - bevels as f32 } else { (at - bevels - 1) as f32 };
            let (sin, cos) = sin_cos(eighth / bevels as f32 * FRAC_PI_4);
            (if at <= bevels { -1.0 } else { 1.0 }, sin / cos)
        };
        let sheet = Sheet::open(2 * bevels + 1, 2 * bevels + 1);
        let stride = sheet.columns + 1;
        for axis in 0..3 {
            for side in [-1.0, 1.0] {
                let first = self.positions.len();
                let [out, mut across, along] = [0, 1, 2].map(|offset| Vec3::AXES[(axis + offset) % 3]);
                across *= side;
                for index in 0..sheet.vertices() as u32 {
                    let (u, v) = (line(index % stride), line(index / stride));
                    let normal = (out * side + across * u.1 + along * v.1).normalize();
                    let corner = out * side + across * u.0 + along * v.0;
                    let position = corner * core + normal * radius;
                    let coords = Vec2::new(position.dot(across), -position.dot(along));
                    self.vertex(position, normal, coords);
                }
                self.triangles_from(first, sheet.triangles());
            }
        }
        self
    }

    /// Adds a sphere of meridians and parallels: 2·columns·(rows − 1) triangles.
    pub(crate) fn sphere(&mut self, center: Vec3, radius: f32, columns: u32, rows: u32) -> &mut Self {
        let sheet = Sheet::tube(columns, rows.max(2));
        let first = self.positions.len();
        self.sheet(sheet, |u, v| center + radius * on_sphere(u, v));
        for index in first..self.positions.len() {
            self.normals[index] = (self.positions[index] - center).normalize_or_zero();
        }
        self
    }

    /// Adds a geodesic sphere: 20·frequency² triangles of nearly one size, 10·frequency² + 2 vertices.
    ///
    /// Texture coordinates are the direction's x and y, from 0 to 1.
    pub(crate) fn icosphere(&mut self, center: Vec3, radius: f32, frequency: u32) -> &mut Self {
        let first = self.positions.len();
        let (directions, triangles) = icosphere(frequency);
        for &direction in &directions {
            self.vertex(center + direction * radius, direction, direction.xy() * 0.5 + 0.5);
        }
        self.triangles_from(first, triangles);
        self
    }

    /// Adds a surface of revolution about the y axis. `profile` holds (distance from the axis, height) from the
    /// bottom up along the outside; a point given twice is a sharp edge. Two triangles for each side of the profile
    /// and column, one where it meets the axis.
    pub(crate) fn lathe(&mut self, profile: &[Vec2], columns: u32) -> &mut Self {
        let mut start = 0;
        for end in 1..=profile.len() {
            if end < profile.len() && profile[end] != profile[end - 1] {
                continue;
            }
            let smooth = &profile[start..end];
            start = end;
            let Some(rows) = smooth.len().checked_sub(1).filter(|&rows| rows > 0) else { continue };
            self.sheet(Sheet::tube(columns, rows as u32), |u, v| {
                let point = smooth[(v * rows as f32 + 0.5) as usize];
                around(u, point.x, point.y)
            });
        }
        self
    }

    /// Adds a cylinder with flat ends that stands on the origin: 4·columns triangles.
    pub(crate) fn cylinder(&mut self, radius: f32, height: f32, columns: u32) -> &mut Self {
        self.cone(radius, radius, height, columns)
    }

    /// Adds a cylinder with flat ends that stands on the origin and whose ends have unequal radii, one may be zero.
    pub(crate) fn cone(&mut self, lower_radius: f32, upper_radius: f32, height: f32, columns: u32) -> &mut Self {
        let (lower, upper) = (Vec2::new(lower_radius, 0.0), Vec2::new(upper_radius, height));
        self.lathe(&[Vec2::ZERO, lower, lower, upper, upper, Vec2::new(0.0, height)], columns)
    }

    /// Adds a smooth tube along `path`, two points or more. `radius` gives its radius for the fraction, 0 … 1, of the
    /// path's points passed. A radius of zero at an end closes it.
    pub(crate) fn tube(&mut self, path: &[Vec3], radius: impl Fn(f32) -> f32 + Sync, columns: u32) -> &mut Self {
        self.any_tube(path, &radius, columns)
    }

    /// Adds a [`tube`](Self::tube): compiled once, not for each shape.
    fn any_tube(&mut self, path: &[Vec3], radius: &(dyn Fn(f32) -> f32 + Sync), columns: u32) -> &mut Self {
        let Some(last) = path.len().checked_sub(1).filter(|&last| last > 0) else { return self };
        let sides = transported_sides(path);
        self.sheet(Sheet::tube(columns, last as u32), |u, v| {
            let point = (v * last as f32 + 0.5) as usize;
            let [side, other] = sides[point];
            let (sin, cos) = sin_cos(TAU * u);
            path[point] + (side * cos + other * sin) * radius(v)
        })
    }

    /// Adds a ring around the z axis: the circle of `radius` around `center`; `thickness` is half its thickness along
    /// the radius and along the axis.
    pub(crate) fn ring(&mut self, center: Vec3, radius: f32, thickness: [f32; 2], sheet: [u32; 2]) -> &mut Self {
        let [across, along] = thickness;
        self.sheet(Sheet::ring(sheet[0], sheet[1]), |u, v| {
            let (sin_u, cos_u) = sin_cos(TAU * u);
            let (sin_v, cos_v) = sin_cos(TAU * v);
            let out = radius + across * cos_u;
            center + Vec3::new(out * cos_v, out * sin_v, -along * sin_u)
        })
    }

    /// Adds a prism: the polygon `outline`, convex and counterclockwise seen from +Z, from z = 0 to `depth`, with
    /// sharp edges.
    pub(crate) fn prism(&mut self, outline: &[Vec2], depth: f32) -> &mut Self {
        let first = self.positions.len() as u32;
        let count = outline.len() as u32;
        for z in [0.0, depth] {
            for &point in outline {
                self.vertex(point.extend(z), Vec3::ZERO, point);
            }
        }
        for corner in 1..count.saturating_sub(1) {
            self.triangle([first, first + corner + 1, first + corner]);
            self.triangle([first + count, first + count + corner, first + count + corner + 1]);
        }
        for (corner, &from) in outline.iter().enumerate() {
            let to = outline[(corner + 1) % outline.len()];
            let corners = [from.extend(0.0), to.extend(0.0), to.extend(depth), from.extend(depth)];
            self.quad(corners, Vec2::new((to - from).length(), depth));
        }
        self
    }
}

/// The point of the unit sphere at longitude u and latitude v, each 0 … 1, v = 1 being the upper pole exactly.
pub(crate) fn on_sphere(u: f32, v: f32) -> Vec3 {
    if v <= 0.0 || v >= 1.0 {
        return if v <= 0.0 { Vec3::NEG_Y } else { Vec3::Y };
    }
    let (sin_u, cos_u) = sin_cos(TAU * u);
    let (sin_v, cos_v) = sin_cos(PI * (v - 0.5));
    Vec3::new(cos_v * cos_u, sin_v, -cos_v * sin_u)
}

/// Directions and triangles of the geodesic sphere that splits each side of the icosahedron into `frequency`² ≥ 1.
pub(crate) fn icosphere(frequency: u32) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let frequency = frequency.max(1);
    let corners = icosahedron_corners();
    let mut directions = corners.to_vec();
    // The points inside each edge come once, from its lower corner to its higher one; then those inside each face.
    let mut edges: Vec<[u32; 2]> = Vec::new();
    let between = |from: Vec3, to: Vec3, step: u32| from + (to - from) * (step as f32 / frequency as f32);
    let mut edge_start = |directions: &mut Vec<Vec3>, low: u32, high: u32| {
        let edge = edges.iter().position(|known| *known == [low, high]).unwrap_or_else(|| {
            edges.push([low, high]);
            let ends = [low, high].map(|corner| corners[corner as usize]);
            directions.extend((1..frequency).map(|step| between(ends[0], ends[1], step)));
            edges.len() - 1
        });
        // Twelve corners come first; the edges are all made before the first inner point.
        12 + edge as u32 * (frequency - 1)
    };
    for [a, b, c] in ICOSAHEDRON {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            edge_start(&mut directions, from.min(to), from.max(to));
        }
    }
    let mut triangles = Vec::new();
    for face in ICOSAHEDRON {
        let [a, b, c] = face;
        let inner = directions.len() as u32;
        let [pa, pb, pc] = face.map(|corner| corners[corner as usize]);
        for row in 1..frequency {
            for column in 1..frequency - row {
                let (i, j) = (column as f32 / frequency as f32, row as f32 / frequency as f32);
                directions.push(pa + (pb - pa) * i + (pc - pa) * j);
            }
        }
        let mut on_edge = |from: u32, to: u32, step: u32| match step {
            0 => from,
            step if step == frequency => to,
            step if from < to => edge_start(&mut directions, from, to) + step - 1,
            step => edge_start(&mut directions, to, from) + frequency - step - 1,
        };
        let mut vertex = |column: u32, row: u32| match (column, row) {
            (column, 0) => on_edge(a, b, column),
            (0, row) => on_edge(a, c, row),
            (column, row) if column + row == frequency => on_edge(b, c, row),
            // Rows before this one hold frequency − 2, frequency − 3, … inner points.
            (column, row) => inner + (row - 1) * (frequency - 2) - (row - 1) * (row.max(2) - 2) / 2 + column - 1,
        };
        for row in 0..frequency {
            for column in 0..frequency - row {
                let right = vertex(column + 1, row);
                let above = vertex(column, row + 1);
                triangles.push([vertex(column, row), right, above]);
                if column + row + 1 < frequency {
                    triangles.push([right, vertex(column + 1, row + 1), above]);
                }
            }
        }
    }
    for direction in &mut directions {
        *direction = direction.normalize();
    }
    (directions, triangles)
}

fn icosahedron_corners() -> [Vec3; 12] {
    let golden = 0.5 + 0.5 * 5.0_f32.sqrt();
    let corner = |at: usize| {
        let (short, long) = (if at & 1 == 0 { 1.0 } else { -1.0 }, if at & 2 == 0 { golden } else { -golden });
        match at / 4 {
            0 => Vec3::new(0.0, short, long),
            1 => Vec3::new(short, long, 0.0),
            _ => Vec3::new(long, 0.0, short),
        }
        .normalize()
    };
    std::array::from_fn(corner)
}

/// The icosahedron's sides over [`icosahedron_corners`], counterclockwise seen from outside.
const ICOSAHEDRON: [[u32; 3]; 20] = [
    [0, 1, 8],
    [0, 8, 4],
    [0, 4, 5],
    [0, 5, 10],
    [0, 10, 1],
    [1, 10, 7],
    [1, 7, 6],
    [1, 6, 8],
    [8, 6, 9],
    [8, 9, 4],
    [4, 9, 2],
    [4, 2, 5],
    [5, 2, 11],
    [5, 11, 10],
    [10, 11, 7],
    [3, 2, 9],
    [3, 9, 6],
    [3, 6, 7],
    [3, 7, 11],
    [3, 11, 2],
];

/// Two unit vectors across the path at each of its points, carried along it without twisting.
fn transported_sides(path: &[Vec3]) -> Vec<[Vec3; 2]> {
    let direction = |from: usize, to: usize| (path[to] - path[from]).normalize_or(Vec3::Y);
    let mut side = direction(0, 1).any_orthonormal_vector();
    (0..path.len())
        .map(|point| {
            let tangent = direction(point.saturating_sub(1), (point + 1).min(path.len() - 1));
            side = (side - tangent * side.dot(tangent)).normalize_or(tangent.any_orthonormal_vector());
            [side, tangent.cross(side)]
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use glam::{Affine3A, Quat};

    use super::super::Paint;
    use super::*;

    /// The volume inside a closed mesh whose triangles face outwards.
    fn volume(builder: &MeshBuilder) -> f32 {
        let inside = |triangle: &[u32; 3]| {
            let [a, b, c] = triangle.map(|vertex| builder.positions[vertex as usize]);
            a.dot(b.cross(c)) / 6.0
        };
        builder.triangles.iter().map(inside).sum()
    }

    /// Makes a shape away from the origin, checks its volume and that normals face outwards, and returns its size.
    fn solid(exact: f32, tolerance: f32, make: impl FnOnce(&mut MeshBuilder) -> &mut MeshBuilder) -> usize {
        let mut builder = MeshBuilder::new();
        let moved =
            Affine3A::from_rotation_translation(Quat::from_xyzw(0.5, 0.5, -0.5, 0.5), Vec3::new(3.0, 1.0, -2.0));
        builder.place(moved, |builder| {
            make(builder);
        });
        let found = volume(&builder);
        assert!((found - exact).abs() < tolerance * exact, "volume {found}, not {exact}");
        for triangle in &builder.triangles {
            let [a, b, c] = triangle.map(|vertex| builder.positions[vertex as usize]);
            let outward = (b - a).cross(c - a);
            for normal in triangle.map(|vertex| builder.normals[vertex as usize]) {
                assert!(normal == Vec3::ZERO || normal.is_normalized());
                assert!(normal.dot(outward) >= 0.0, "a normal points inwards");
            }
        }
        builder.triangles.len()
    }

    #[test]
    fn solids_have_their_volumes_and_counts() {
        let sphere = 4.0 / 3.0 * PI;
        assert_eq!(solid(24.0, 1e-5, |b| b.cuboid(Vec3::ZERO, Vec3::new(2.0, 3.0, 4.0))), 12);
        assert_eq!(solid(sphere, 0.01, |b| b.sphere(Vec3::ONE, 1.0, 64, 32)), 2 * 64 * 31);
        assert_eq!(solid(PI * 0.75, 0.01, |b| b.cylinder(0.5, 3.0, 64)), 256);
        assert_eq!(solid(PI / 3.0, 0.01, |b| b.cone(1.0, 0.0, 1.0, 64)), 64 * 2);
        assert_eq!(solid(sphere, 0.02, |b| b.rounded_cuboid(Vec3::ONE, 1.0, 8)), 12 * 17 * 17);
        assert_eq!(solid(8.0, 0.02, |b| b.rounded_cuboid(Vec3::ONE, 0.05, 1)), 12 * 9);
        assert_eq!(solid(0.5, 1e-5, |b| b.prism(&[Vec2::ZERO, Vec2::X, Vec2::Y], 1.0)), 8);
        let path: Vec<Vec3> = (0..=20).map(|i| Vec3::new(0.0, i as f32 * 0.1, 0.0)).collect();
        solid(PI * 0.09 * 1.9, 0.03, |b| b.tube(&path, |part| if part <= 0.0 || part >= 1.0 { 0.0 } else { 0.3 }, 32));
    }

    #[test]
    fn rings_have_their_analytic_normals_and_are_closed() {
        let mut builder = MeshBuilder::new();
        builder.ring(Vec3::ZERO, 2.0, [0.5; 2], [48, 96]);
        assert_eq!(builder.triangles.len(), 2 * 48 * 96);
        for (position, normal) in builder.positions.iter().zip(&builder.normals) {
            let core = position.with_z(0.0).normalize() * 2.0;
            assert!(normal.dot((*position - core).normalize()).abs() > 0.999, "{position} {normal}");
        }
        let exact = TAU * 2.0 * PI * 0.5 * 0.5;
        assert!((volume(&builder).abs() / exact - 1.0).abs() < 0.01, "{} {exact}", volume(&builder));
    }

    #[test]
    fn geodesic_spheres_are_closed_and_share_their_vertices() {
        for frequency in 1..=7 {
            let (directions, triangles) = icosphere(frequency);
            assert_eq!(triangles.len() as u32, 20 * frequency * frequency);
            assert_eq!(directions.len() as u32, 10 * frequency * frequency + 2);
            let mut edges: Vec<[u32; 2]> = triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]).collect();
            edges.sort_unstable();
            edges.dedup();
            assert_eq!(edges.len(), 3 * triangles.len(), "each edge once in each direction");
            assert!(edges.iter().all(|&[a, b]| edges.binary_search(&[b, a]).is_ok()));
        }
        assert_eq!(solid(4.0 / 3.0 * PI, 0.02, |b| b.icosphere(Vec3::X, 1.0, 8)), 20 * 64);
    }

    #[test]
    fn instances_keep_their_materials_and_tints() {
        let mut part = MeshBuilder::new();
        let [one, two, three] = ["one", "two", "three"].map(|name| Paint::dull(name, 0, 0.5));
        part.paint(three).tint(Vec3::X).cuboid(Vec3::ZERO, Vec3::ONE);
        let mut whole = MeshBuilder::new();
        whole.paint(one).cuboid(Vec3::ZERO, Vec3::ONE).instance(&part, Affine3A::from_translation(Vec3::Y * 2.0));
        whole.paint(two).cuboid(Vec3::ZERO, Vec3::ONE);
        let still = whole.finish();
        assert_eq!(*still.materials.materials[still.mesh.material_of_triangle[12] as usize].name, *"three");
        assert_eq!(still.mesh.material_of_triangle, [[0; 12], [1; 12], [2; 12]].concat());
        assert_eq!(still.mesh.colors.len(), still.positions.len());
        assert_eq!(still.mesh.colors[23..25], [glam::Vec4::ONE, Vec3::X.extend(1.0)]);
        assert_eq!(still.positions[24..48].iter().map(|position| position.y).fold(9.0, f32::min), 2.0);
    }
}
