//! Expansions of solid angles around the middle of many triangles.

use glam::DVec3;

/// A form of degree two: factors of x², y², z², xy, xz, yz.
#[derive(Clone, Copy, Debug, Default)]
struct Quadratic([f64; 6]);

/// A form of degree three: factors of x³, y³, z³, x²y, x²z, y²x, y²z, z²x, z²y, xyz.
#[derive(Clone, Copy, Debug, Default)]
struct Cubic([f64; 10]);

/// The solid angle of triangles, seen from far away: d · N ÷ |d|³ of its first term, for the vector d to the middle.
///
/// An area dA with normal n̂ at d + s has the solid angle n̂ · K(d + s) dA with K(r) = r ÷ |r|³. Each derivative of K is
/// symmetric and without trace, so the terms of its Taylor series are P₁ ÷ |d|³, −3 P₂ ÷ |d|⁵ and 15 P₃ ÷ |d|⁷, where
/// Pₖ are the parts without trace of ∫ n̂ · d dA, ∫ (n̂ · d) (s · d) dA and ½ ∫ (n̂ · d) (s · d)² dA. (Barill et al., *Fast
/// winding numbers for soups and clouds*, 2018, sections 3.1 and 3.2) 152 bytes.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Moments {
    first: DVec3,
    second: Quadratic,
    third: Cubic,
}

/// The product of two linear forms.
fn product(a: DVec3, b: DVec3) -> Quadratic {
    Quadratic([a.x * b.x, a.y * b.y, a.z * b.z, a.x * b.y + a.y * b.x, a.x * b.z + a.z * b.x, a.y * b.z + a.z * b.y])
}

impl Quadratic {
    fn add(&mut self, other: Self, factor: f64) {
        self.0.iter_mut().zip(other.0).for_each(|(to, other)| *to += factor * other);
    }

    /// Its product with a linear form.
    fn times(&self, a: DVec3) -> Cubic {
        let Self([xx, yy, zz, xy, xz, yz]) = *self;
        Cubic([
            xx * a.x,
            yy * a.y,
            zz * a.z,
            xx * a.y + xy * a.x,
            xx * a.z + xz * a.x,
            yy * a.x + xy * a.y,
            yy * a.z + yz * a.y,
            zz * a.x + xz * a.z,
            zz * a.y + yz * a.z,
            xy * a.z + xz * a.y + yz * a.x,
        ])
    }

    /// Without the part that is a multiple of x² + y² + z².
    fn without_trace(mut self) -> Self {
        let third = (self.0[0] + self.0[1] + self.0[2]) / 3.0;
        self.0[..3].iter_mut().for_each(|square| *square -= third);
        self
    }
}

impl Cubic {
    fn add(&mut self, other: Self, factor: f64) {
        self.0.iter_mut().zip(other.0).for_each(|(to, other)| *to += factor * other);
    }

    /// Without the part that is a multiple of x² + y² + z²: a tenth of the Laplacian.
    fn without_trace(self) -> Self {
        let [xxx, yyy, zzz, xxy, xxz, yyx, yyz, zzx, zzy, xyz] = self.0;
        let x = (3.0 * xxx + yyx + zzx) / 5.0;
        let y = (3.0 * yyy + xxy + zzy) / 5.0;
        let z = (3.0 * zzz + xxz + yyz) / 5.0;
        Self([xxx - x, yyy - y, zzz - z, xxy - y, xxz - z, yyx - x, yyz - z, zzx - x, zzy - y, xyz])
    }
}

impl Moments {
    /// Adds a triangle with corners relative to the middle.
    pub(super) fn add_triangle(&mut self, [a, b, c]: [DVec3; 3]) {
        let area = (b - a).cross(c - a) * 0.5;
        let mean = (a + b + c) / 3.0;
        self.first += area;
        self.second.add(product(area, mean), 1.0);
        // The mean of (s · d)² over a triangle.
        let mut square = Quadratic::default();
        for (corner, factor) in [(a, 1.0), (b, 1.0), (c, 1.0), (mean, 9.0)] {
            square.add(product(corner, corner), factor / 12.0);
        }
        self.third.add(square.times(area), 0.5);
    }

    /// Adds what is around another middle, which is at `offset` from this one.
    pub(super) fn add_moved(&mut self, other: &Self, offset: DVec3) {
        self.first += other.first;
        self.second.add(other.second, 1.0);
        self.second.add(product(other.first, offset), 1.0);
        self.third.add(other.third, 1.0);
        self.third.add(other.second.times(offset), 1.0);
        self.third.add(product(other.first, offset).times(offset), 0.5);
    }

    /// Without the parts that add nothing to solid angles. Nothing is lost where it is moved: they become such parts.
    pub(super) fn without_trace(self) -> Self {
        Self { second: self.second.without_trace(), third: self.third.without_trace(), ..self }
    }

    /// The solid angle as seen from a point, in steradians, for the vector from it to the middle and its square.
    #[inline(always)]
    pub(super) fn solid_angle(&self, [x, y, z]: [f64; 3], square: f64) -> f64 {
        let [xx, yy, zz, xy, xz, yz] = self.second.0;
        let [xxx, yyy, zzz, xxy, xxz, yyx, yyz, zzx, zzy, xyz] = self.third.0;
        let first = self.first.x * x + self.first.y * y + self.first.z * z;
        let second = x * (xx * x + xy * y + xz * z) + y * (yy * y + yz * z) + zz * z * z;
        let third = x * x * (xxx * x + xxy * y + xxz * z)
            + y * y * (yyx * x + yyy * y + yyz * z)
            + z * z * (zzx * x + zzy * y + zzz * z)
            + xyz * x * y * z;
        let inverse = 1.0 / square;
        (first + (15.0 * third * inverse - 3.0 * second) * inverse) * (inverse * inverse.sqrt())
    }
}
