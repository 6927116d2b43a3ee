//! Small scenes that structures get wrong when they are careless.

use glam::Vec3;
use umbrage_rays::Triangles;

/// Reproducible random numbers (`SplitMix64`).
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mixed = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        mixed ^ (mixed >> 31)
    }

    /// From [0, 1).
    pub(crate) fn unit(&mut self) -> f32 {
        (self.bits() >> 40) as f32 / (1_u64 << 24) as f32
    }

    /// From the cube [−1, 1)³.
    pub(crate) fn point(&mut self) -> Vec3 {
        Vec3::new(self.unit(), self.unit(), self.unit()) * 2.0 - 1.0
    }
}

#[derive(Clone, Default)]
pub(crate) struct Mesh {
    pub(crate) positions: Vec<Vec3>,
    pub(crate) indices: Vec<[u32; 3]>,
}

impl Mesh {
    pub(crate) fn triangles(&self) -> Triangles<'_> {
        Triangles { positions: &self.positions, indices: &self.indices }
    }

    pub(crate) fn push(&mut self, corners: [Vec3; 3]) {
        let first = self.positions.len() as u32;
        self.positions.extend(corners);
        self.indices.push([first, first + 1, first + 2]);
    }

    /// Two triangles between four corners.
    pub(crate) fn quad(&mut self, [a, b, c, d]: [Vec3; 4]) {
        let first = self.positions.len() as u32;
        self.positions.extend([a, b, c, d]);
        self.indices.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
    }

    /// A ball of `rings` by twice as many parts with shared vertices, bumpy by `bump`.
    pub(crate) fn ball(&mut self, center: Vec3, radius: f32, rings: u32, bump: f32) {
        let first = self.positions.len() as u32;
        let parts = 2 * rings;
        for ring in 0..=rings {
            for part in 0..parts {
                let (polar, around) = (
                    std::f32::consts::PI * ring as f32 / rings as f32,
                    std::f32::consts::TAU * part as f32 / parts as f32,
                );
                let radius = radius * (1.0 + bump * (9.0 * polar).sin() * (7.0 * around).cos());
                let (sin, cos) = polar.sin_cos();
                let direction = Vec3::new(sin * around.cos(), cos, sin * around.sin());
                self.positions.push(center + direction * radius);
            }
        }
        for ring in 0..rings {
            for part in 0..parts {
                let at = |ring: u32, part: u32| first + ring * parts + part % parts;
                let [a, b, c, d] = [at(ring, part), at(ring, part + 1), at(ring + 1, part + 1), at(ring + 1, part)];
                self.indices.extend([[a, b, c], [a, c, d]]);
            }
        }
    }

    pub(crate) fn placed(mut self, scale: f32, offset: Vec3) -> Self {
        self.positions.iter_mut().for_each(|position| *position = *position * scale + offset);
        self
    }
}
