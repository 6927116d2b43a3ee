use std::f32::consts::TAU;

use glam::Vec3;

use super::{Lump, Relief, Sculpture};
use crate::build::math::{rotation, sin_cos, smoothstep, wave};
use crate::build::noise;

/// A Buddha seated on a lotus, looking along +Z, about 2.6 high, the lotus on y = 0.
pub(crate) fn buddha() -> Sculpture {
    let mut buddha = Sculpture::new(Vec3::new(0.0, 1.3, 0.1), 1.5, 16.0, RELIEF);
    lotus(&mut buddha);
    body(&mut buddha);
    robe(&mut buddha);
    head(&mut buddha);
    face(&mut buddha);
    curls(&mut buddha);
    buddha
}

/// Two rows of petals around a seat.
fn lotus(buddha: &mut Sculpture) {
    buddha.add([
        Lump::ellipsoid([0.0, 0.24, 0.12], [0.94, 0.17, 0.80]),
        Lump::rod([0.0, -0.35, 0.12], [0.0, -0.3, 0.12], [0.45, 0.45]).blend(0.03),
    ]);
    const PETALS: u32 = 20;
    for petal in 0..2 * PETALS {
        let upper = petal % 2 == 0;
        let turn = rotation(Vec3::Y, TAU * petal as f32 / (2 * PETALS) as f32);
        let (reach, height, lean) = if upper { (0.90, 0.27, 0.45) } else { (0.86, 0.12, 1.0) };
        // The seat is a little deeper than wide at the front: squeeze the ring, not the petals.
        let out = turn * Vec3::Z;
        let at = Vec3::new(out.x * reach * 1.04, height, 0.12 + out.z * reach * 0.88);
        let radii = if upper { [0.125, 0.17, 0.034] } else { [0.125, 0.16, 0.034] };
        let tilt = turn * rotation(Vec3::X, lean);
        buddha.add([
            Lump::ellipsoid(at.to_array(), radii).turn(tilt).blend(0.015),
            Lump::ellipsoid((at + out * 0.024).to_array(), [radii[0] * 0.55, radii[1] * 0.62, 0.026])
                .turn(tilt)
                .blend(0.02),
            // The tip, which bends outwards.
            Lump::rod(
                (at + tilt * Vec3::Y * 0.11).to_array(),
                (at + tilt * Vec3::new(0.0, 0.205, 0.015)).to_array(),
                [0.05, 0.004],
            )
            .blend(0.05),
        ]);
    }
}

fn body(buddha: &mut Sculpture) {
    let (ellipsoid, rod) = (Lump::ellipsoid, Lump::rod);
    buddha.add([
        // Torso.
        ellipsoid([0.0, 0.78, 0.0], [0.46, 0.34, 0.36]).blend(0.08),
        ellipsoid([0.0, 1.08, 0.02], [0.37, 0.46, 0.27]).blend(0.14),
        ellipsoid([0.0, 1.38, 0.02], [0.42, 0.26, 0.25]).blend(0.12),
        ellipsoid([0.16, 1.38, 0.17], [0.19, 0.13, 0.10]).both().blend(0.10),
        rod([0.18, 1.53, -0.02], [0.45, 1.48, -0.03], [0.14, 0.145]).both().blend(0.12),
        rod([0.0, 1.52, 0.0], [0.0, 1.84, 0.04], [0.17, 0.125]).blend(0.08),
        // Arms.
        rod([0.50, 1.46, -0.03], [0.62, 1.02, 0.02], [0.145, 0.115]).both().blend(0.05),
        rod([0.62, 1.02, 0.02], [0.24, 0.73, 0.44], [0.115, 0.075]).both().blend(0.05),
        // Legs, crossed.
        rod([0.22, 0.56, 0.05], [0.74, 0.50, 0.40], [0.24, 0.17]).both().blend(0.08),
        rod([0.76, 0.49, 0.40], [0.12, 0.46, 0.70], [0.165, 0.11]).both().blend(0.06),
        ellipsoid([0.30, 0.60, 0.60], [0.20, 0.065, 0.10]).both().blend(0.03),
        // Hands, one in the other, thumbs touching.
        ellipsoid([0.09, 0.675, 0.56], [0.20, 0.05, 0.12]).both().blend(0.03),
        ellipsoid([-0.04, 0.735, 0.55], [0.20, 0.045, 0.11]).blend(0.015),
        rod([0.17, 0.77, 0.58], [0.0, 0.86, 0.60], [0.036, 0.028]).both().blend(0.03),
    ]);
    for finger in 0..4 {
        let z = 0.49 + 0.045 * finger as f32;
        let groove = rod([-0.20, 0.79, z], [0.12, 0.785, z], [0.005, 0.005]);
        buddha.add([groove.carve().blend(0.02)]);
    }
    for toe in 0..4 {
        let x = 0.36 + 0.035 * toe as f32;
        buddha.add([rod([x, 0.66, 0.52], [x + 0.02, 0.63, 0.70], [0.005, 0.005]).both().carve().blend(0.015)]);
    }
}

/// The hem that leaves one shoulder bare, the sash, and the cloth's fan between the knees.
fn robe(buddha: &mut Sculpture) {
    let (ellipsoid, rod) = (Lump::ellipsoid, Lump::rod);
    let hem = [
        [0.27, 1.64, -0.02],
        [0.20, 1.56, 0.20],
        [0.06, 1.42, 0.275],
        [-0.10, 1.26, 0.285],
        [-0.25, 1.12, 0.235],
        [-0.36, 1.02, 0.10],
    ];
    for (from, to) in hem.iter().zip(&hem[1..]) {
        let lower = |at: [f32; 3]| [at[0] + 0.045, at[1] - 0.075, at[2]];
        buddha.add([
            rod(*from, *to, [0.030, 0.030]).blend(0.035),
            rod(lower(*from), lower(*to), [0.024, 0.024]).blend(0.035),
        ]);
    }
    for (x, z) in [(0.0, 0.30), (0.16, 0.27), (0.29, 0.19)] {
        let next = if x < 0.1 {
            [0.16, 0.885, 0.27]
        } else if x < 0.2 {
            [0.29, 0.89, 0.19]
        } else {
            [0.38, 0.90, 0.05]
        };
        buddha.add([rod([x, 0.88, z], next, [0.03, 0.03]).both().blend(0.02)]);
    }
    for fold in -4_i32..=4 {
        let x = fold as f32 * 0.075;
        let out = 0.86 - 0.35 * x * x;
        buddha.add([rod([x * 0.55, 0.50, 0.66], [x, 0.38, out], [0.035, 0.045]).blend(0.03)]);
    }
    buddha.add([ellipsoid([0.0, 0.40, 0.70], [0.34, 0.04, 0.18]).blend(0.04)]);
}

fn head(buddha: &mut Sculpture) {
    let (ellipsoid, rod) = (Lump::ellipsoid, Lump::rod);
    buddha.add([
        ellipsoid([0.0, 2.09, 0.05], [0.235, 0.29, 0.255]).blend(0.05),
        ellipsoid([0.0, 1.95, 0.11], [0.185, 0.165, 0.185]).blend(0.09),
        ellipsoid([0.10, 1.99, 0.20], [0.09, 0.10, 0.085]).both().blend(0.08),
        ellipsoid([0.0, 1.835, 0.235], [0.062, 0.045, 0.045]).blend(0.05),
        // Hair and the crown of the head.
        ellipsoid([0.0, 2.17, -0.015], [0.262, 0.245, 0.275]).blend(0.012),
        ellipsoid([0.0, 2.40, -0.03], [0.145, 0.125, 0.145]).blend(0.05),
        // Ears with long lobes.
        ellipsoid([0.255, 2.05, 0.02], [0.035, 0.125, 0.065]).turn(rotation(Vec3::Y, 0.3)).both().blend(0.03),
        ellipsoid([0.275, 2.055, 0.045], [0.02, 0.085, 0.035]).both().carve().blend(0.02),
        rod([0.255, 1.97, 0.04], [0.265, 1.80, 0.05], [0.03, 0.034]).both().blend(0.02),
        rod([0.285, 1.92, 0.055], [0.295, 1.81, 0.06], [0.008, 0.012]).both().carve().blend(0.015),
    ]);
}

fn face(buddha: &mut Sculpture) {
    let (ellipsoid, rod) = (Lump::ellipsoid, Lump::rod);
    buddha.add([
        // Sockets below the brow, then the brow's arch, which runs into the nose.
        ellipsoid([0.095, 2.075, 0.315], [0.075, 0.035, 0.04]).both().carve().blend(0.05),
        rod([0.022, 2.118, 0.300], [0.085, 2.155, 0.283], [0.012, 0.012]).both().blend(0.03),
        rod([0.085, 2.155, 0.283], [0.165, 2.130, 0.228], [0.012, 0.008]).both().blend(0.03),
        rod([0.0, 2.12, 0.298], [0.0, 2.005, 0.335], [0.016, 0.023]).blend(0.04),
        ellipsoid([0.0, 2.0, 0.338], [0.026, 0.022, 0.022]).blend(0.02),
        ellipsoid([0.032, 1.992, 0.317], [0.022, 0.019, 0.024]).both().blend(0.02),
        ellipsoid([0.016, 1.976, 0.34], [0.008, 0.008, 0.012]).both().carve().blend(0.008),
        // Eyes nearly closed: the lid's bulge, and the slit that curves down.
        ellipsoid([0.095, 2.07, 0.262], [0.058, 0.034, 0.036]).both().blend(0.02),
        rod([0.045, 2.058, 0.305], [0.095, 2.05, 0.306], [0.004, 0.005]).both().carve().blend(0.014),
        rod([0.095, 2.05, 0.306], [0.155, 2.062, 0.265], [0.005, 0.003]).both().carve().blend(0.014),
        // Lips with a slight smile.
        rod([0.0, 1.937, 0.305], [0.052, 1.934, 0.282], [0.014, 0.008]).both().blend(0.02),
        rod([0.0, 1.909, 0.303], [0.040, 1.915, 0.285], [0.017, 0.010]).both().blend(0.02),
        rod([0.0, 1.923, 0.322], [0.045, 1.926, 0.300], [0.004, 0.004]).both().carve().blend(0.012),
        rod([0.045, 1.926, 0.300], [0.072, 1.936, 0.278], [0.004, 0.003]).both().carve().blend(0.012),
        rod([0.0, 1.966, 0.330], [0.0, 1.950, 0.324], [0.004, 0.005]).carve().blend(0.012),
        // The mark between the brows.
        ellipsoid([0.0, 2.165, 0.292], [0.016, 0.016, 0.014]).blend(0.006),
    ]);
}

/// Rows of curls over the hair: points of a Fibonacci spiral on its two ellipsoids.
fn curls(buddha: &mut Sculpture) {
    const GOLDEN_TURN: f32 = 2.399_963;
    let mut cover = |count: u32, center: Vec3, radii: Vec3, keep: fn(Vec3) -> bool| {
        for curl in 0..count {
            let y = 1.0 - (curl as f32 + 0.5) * 2.0 / count as f32;
            let across = (1.0 - y * y).sqrt();
            let (sin, cos) = sin_cos(GOLDEN_TURN * curl as f32);
            let point = center + Vec3::new(across * cos, y, across * sin) * radii;
            if keep(point) {
                buddha.add([Lump::ellipsoid(point.to_array(), [0.027; 3]).blend(0.008)]);
            }
        }
    };
    cover(420, Vec3::new(0.0, 2.17, -0.015), Vec3::new(0.262, 0.245, 0.275), |point| {
        let hairline = point.y > 2.0 + 1.05 * (point.z - 0.02).max(0.0) + 0.25 * point.z.max(0.0);
        let crown = point.distance(Vec3::new(0.0, 2.40, -0.03)) > 0.135;
        hairline && crown
    });
    cover(110, Vec3::new(0.0, 2.40, -0.03), Vec3::new(0.145, 0.125, 0.145), |point| point.y > 2.385);
}

const RELIEF: Relief = Relief { height: folds, greatest: 0.02, tooth, greatest_tooth: 0.003 };

/// The tooth of carved stone.
fn tooth(point: Vec3) -> f32 {
    0.0012 * noise(point * 60.0) + 0.0016 * noise(point * 17.0)
}

/// The robe's folds: slanting over the body but for the bare shoulder, and around the knees.
fn folds(point: Vec3) -> f32 {
    if point.y > 1.62 || point.y < 0.34 {
        return 0.0;
    }
    let covered = smoothstep(-0.04, 0.06, point.x + 0.75 * (point.y - 1.33)).max(smoothstep(-0.02, -0.10, point.z));
    let torso = covered * smoothstep(1.62, 1.55, point.y) * smoothstep(0.95, 1.02, point.y);
    let legs = smoothstep(0.34, 0.42, point.y) * smoothstep(0.66, 0.58, point.y);
    if torso <= 0.0 && legs <= 0.0 {
        return 0.0;
    }
    let sway = 0.35 * noise(point * 2.3);
    // Sharp ridges and wide valleys, like hanging cloth.
    let ridge = |turns: f32| {
        let height = wave(turns + sway);
        0.5 * height + 0.5 * height * height.abs()
    };
    let outwards = point.x.abs();
    if torso > 0.0 {
        0.019 * torso * ridge(5.2 * (0.55 * outwards + 0.8 * point.y + 0.25 * point.z))
    } else {
        0.012 * legs * ridge(7.0 * (0.5 * outwards + 0.9 * point.z))
    }
}
