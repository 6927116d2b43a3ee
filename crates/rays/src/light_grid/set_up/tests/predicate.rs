//! The filter compared with the predicate, which wants more of a point than to be behind a triangle: its whole error box
//! must be behind.

use super::*;
use crate::LightSource;
use crate::predicate::{HitPoint, ShadowRay};

/// Sixteen triangles before a light at zero, and points behind these by about the predicate's margin.
struct PointsBehind {
    random: Random,
    level: SimdLevel,
    face: Face,
    light: LightSource,
}

impl PointsBehind {
    fn new(mut random: Random, level: SimdLevel) -> Self {
        let is_parallel = random.unit() < 0.5;
        let light = if is_parallel {
            LightSource::Directional { direction: Vec3::NEG_Z }
        } else {
            LightSource::Point { position: Vec3::ZERO }
        };
        let scale = DVec3::new(random.power(-1.0, 4.0), random.power(-1.0, 4.0), 1.0);
        let scale = if is_parallel { scale.with_z(random.power(-1.0, 4.0)) } else { scale };
        let point_error = random.power(-10.8, -5.0) / if is_parallel { scale.max_element() } else { 1.0 };
        let [x, y, z] = [DVec3::X * scale.x, DVec3::Y * scale.y, DVec3::Z * scale.z];
        let face = Face { x, y, z, near: 1.0, is_parallel, scale, point_error, ..Face::default() };
        Self { random, level, face, light }
    }

    /// A world position that is at X, Y and W of the face.
    fn position(&self, [x, y, w]: [f64; 3]) -> DVec3 {
        let Face { scale, is_parallel, .. } = self.face;
        if is_parallel { DVec3::new(x, y, w) / scale } else { DVec3::new(x / scale.x, y / scale.y, 1.0) / w }
    }

    /// X, Y and W of a world position.
    fn on_face(&self, position: DVec3) -> DVec3 {
        let p = self.face.homogeneous(position);
        if self.face.is_parallel { p } else { DVec3::new(p.x, p.y, self.face.near) / p.z }
    }

    fn corners(&mut self) -> [Vec3; 3] {
        let size = self.random.power(-3.0, -0.3);
        let [x, y] = [self.random.signed(), self.random.signed()].map(|middle| middle * (1.0 - size));
        let w = if self.face.is_parallel { 0.5 * self.random.signed() } else { self.random.power(-1.0, 1.0) };
        let rise = self.random.power(-4.0, -0.6) * if self.face.is_parallel { 1.0 } else { w };
        [(); 3].map(|()| {
            let mut signed = |size: f64| size * self.random.signed();
            let at = [x + signed(size), y + signed(size), w + signed(rise)];
            self.position(at).as_vec3()
        })
    }

    /// A point behind some position of a triangle.
    fn point(&mut self, corners: [Vec3; 3], depth_error: f64) -> HitPoint {
        let [a, b, c] = corners.map(Vec3::as_dvec3);
        let (u, v) = (self.random.unit(), self.random.unit());
        let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
        let at = self.on_face(a + (b - a) * u + (c - a) * v);
        let behind = depth_error.min(0.1 * at.z.abs()) * self.random.power(-1.0, 0.7);
        let position = self.position((at - DVec3::Z * behind).to_array());
        let depth = if self.face.is_parallel { 1.0 } else { position.z };
        HitPoint { position, error: self.face.point_error * depth }
    }

    /// The number of points in shadow for certain, and of those that only the predicate calls shadowed.
    fn run(&mut self) -> [u32; 2] {
        let triangles: [[Vec3; 3]; LANES] = std::array::from_fn(|_| self.corners());
        let at = triangles.map(|corners| corners.map(|corner| self.on_face(corner.as_dvec3())));
        let vertices: Vec<_> = at.as_flattened().iter().map(|at| at.extend(0.0).as_vec4().to_array()).collect();
        let (face, vertex_errors) = (self.face, VertexErrors::new(&self.face));
        let mut setting = Setting {
            level: self.level,
            face: &face,
            vertex_errors: &vertex_errors,
            origin: [0.0; 3],
            // Of rounding to f32.
            errors: [HALF_ULP as f32 * 1.01; 2],
            one_sided: 0,
            filled: u16::MAX,
            vertices: &vertices,
        };
        let deepest = at.as_flattened().iter().fold(1.0, |deepest: f64, at| deepest.max(at.z));
        setting.errors[1] *= deepest as f32;
        let mut set_up = SetUp::EMPTY;
        setting.fill(&mut set_up, &setting.extent());
        let hits: [[HitPoint; LANES]; LANES] = std::array::from_fn(|triangle| {
            let depth_error = f64::from(set_up.errors(triangle)[1]) / 2.0;
            std::array::from_fn(|_| self.point(triangles[triangle], depth_error))
        });
        let points = hits.map(|hits| hits.map(|hit| self.on_face(hit.position).as_vec3().to_array()));
        let mut counts = [0; 2];
        for ((corners, hits), [_, certain]) in triangles.iter().zip(&hits).zip(setting.decide(&points)) {
            for (lane, &hit) in hits.iter().enumerate() {
                let is_shadowed = ShadowRay::new(&self.light, hit).blocked_by(*corners).is_some();
                let is_certain = certain >> lane & 1 == 1;
                assert!(is_shadowed || !is_certain, "{corners:?} and {hit:?} on {:?}", self.face);
                counts[usize::from(!is_certain)] += u32::from(is_shadowed);
            }
        }
        counts
    }
}

#[test]
fn what_is_certain_is_so_for_the_predicate() {
    let levels = SimdLevel::available();
    let of_trial = |seed: u32| PointsBehind::new(Random::new(seed.into()), levels[seed as usize % levels.len()]).run();
    let counts = (0..TRIALS / 10).into_par_iter().map(of_trial).collect::<Vec<_>>();
    let counts = counts.into_iter().fold([0; 2], |sum, one| [sum[0] + one[0], sum[1] + one[1]]);
    let all = TRIALS / 10 * (LANES * LANES) as u32;
    assert!(counts.iter().all(|&count| count > all / 20), "certain, only for the predicate: {counts:?} of {all}");
}
