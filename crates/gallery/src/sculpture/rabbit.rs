use glam::Vec3;

use super::{Lump, Relief, Sculpture};
use crate::build::math::{rotation, smoothstep};
use crate::build::noise;

/// A rabbit that sits upright and looks along +Z, about 2.4 high, its feet on y = 0.
pub(crate) fn rabbit() -> Sculpture {
    let mut rabbit = Sculpture::new(Vec3::new(0.0, 1.15, 0.0), 1.35, 9.0, RELIEF);
    let (ellipsoid, rod) = (Lump::ellipsoid, Lump::rod);
    let ear = rotation(Vec3::Z, -0.20) * rotation(Vec3::X, -0.22);
    rabbit.add([
        // Body.
        ellipsoid([0.0, 0.58, -0.14], [0.43, 0.56, 0.50]),
        ellipsoid([0.0, 0.88, 0.10], [0.34, 0.44, 0.34]).blend(0.16),
        ellipsoid([0.32, 0.38, -0.06], [0.24, 0.35, 0.42]).both().blend(0.07),
        ellipsoid([0.0, 0.30, -0.68], [0.17, 0.17, 0.16]).blend(0.05),
        ellipsoid([0.30, 0.08, 0.30], [0.13, 0.085, 0.32]).both().blend(0.06),
        // Arms and paws.
        rod([0.20, 0.82, 0.30], [0.15, 0.16, 0.42], [0.12, 0.085]).both().blend(0.09),
        ellipsoid([0.15, 0.075, 0.50], [0.095, 0.075, 0.15]).both().blend(0.05),
        // Head.
        rod([0.0, 1.1, 0.14], [0.0, 1.36, 0.24], [0.22, 0.2]).blend(0.14),
        ellipsoid([0.0, 1.46, 0.27], [0.27, 0.26, 0.32]).blend(0.12),
        ellipsoid([0.12, 1.37, 0.40], [0.13, 0.13, 0.15]).both().blend(0.08),
        ellipsoid([0.0, 1.385, 0.55], [0.105, 0.085, 0.09]).blend(0.07),
        ellipsoid([0.055, 1.355, 0.585], [0.06, 0.055, 0.06]).both().blend(0.03),
        ellipsoid([0.0, 1.30, 0.53], [0.07, 0.055, 0.07]).blend(0.04),
        // Ears, hollow in front.
        ellipsoid([0.19, 1.98, 0.10], [0.115, 0.46, 0.065]).turn(ear).both().blend(0.08),
        ellipsoid([0.195, 2.00, 0.165], [0.065, 0.35, 0.05]).turn(ear).both().carve().blend(0.04),
        // Face.
        ellipsoid([0.0, 1.425, 0.635], [0.042, 0.03, 0.025]).blend(0.012),
        rod([0.0, 1.40, 0.655], [0.0, 1.345, 0.65], [0.008, 0.008]).carve().blend(0.015),
        rod([0.0, 1.345, 0.645], [0.075, 1.315, 0.60], [0.008, 0.006]).both().carve().blend(0.015),
        ellipsoid([0.235, 1.505, 0.405], [0.06, 0.062, 0.066]).both().carve().blend(0.05),
        ellipsoid([0.197, 1.505, 0.39], [0.052, 0.052, 0.052]).both().blend(0.006),
    ]);
    // Toes, and folds between haunch and belly.
    for toe in [-0.05, 0.0, 0.05] {
        rabbit.add(
            [
                rod([0.15 + toe + 0.025, 0.09, 0.62], [0.15 + toe + 0.025, 0.03, 0.66], [0.007, 0.007]),
                rod([0.30 + toe * 1.3 + 0.03, 0.12, 0.56], [0.30 + toe * 1.3 + 0.03, 0.04, 0.63], [0.009, 0.009]),
            ]
            .map(|groove| groove.both().carve().blend(0.02)),
        );
    }
    rabbit
}

const RELIEF: Relief = Relief { height: |_| 0.0, greatest: 0.0, tooth: fur, greatest_tooth: 0.016 };

/// Strokes of a chisel that follow the coat downwards, coarse on the body and fine on the head, none on the eyes.
fn fur(point: Vec3) -> f32 {
    let eye = point.with_x(point.x.abs()).distance(Vec3::new(0.197, 1.505, 0.39));
    let bare = smoothstep(0.055, 0.10, eye) * smoothstep(0.64, 0.58, point.z);
    if bare <= 0.0 {
        return 0.0;
    }
    let head = smoothstep(1.15, 1.45, point.y);
    let sway = 0.08 * noise(point * 2.0);
    let stretched = Vec3::new(point.x + sway, point.y * 0.32, point.z + sway);
    let strokes = noise(stretched * (16.0 + 6.0 * head));
    let hairs = noise(stretched * 45.0 + 9.0);
    (0.0085 - 0.0045 * head) * bare * (1.2 * strokes + 0.6 * hairs)
}
