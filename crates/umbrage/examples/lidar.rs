//! A spinning lidar among moving triangles: two hits of each beam, and the faces that the sun reaches.
//!
//! `cargo run --release --example lidar` prints its results; with `-- points.ply` it writes the points of the last turn.

use std::error::Error;
use std::f32::consts::TAU;
use std::fmt::Write as _;

use umbrage::glam::{DVec3, Vec3};
use umbrage::rays::{LightSource, Lit, LitBits, Receivers, Scan, Scanned, Scanner, Sweep};

const BEAMS: u16 = 32;
const AROUND: u16 = 1024;
const RETURNS: usize = 2;

fn main() -> Result<(), Box<dyn Error>> {
    // 32 beams from 22.5° below to 22.5° above the horizon, in 1024 directions around; any other order works too.
    let directions: Vec<Vec3> = (0..AROUND)
        .flat_map(|step| (0..BEAMS).map(move |beam| (f32::from(step) / f32::from(AROUND), f32::from(beam))))
        .map(|(turn, beam)| {
            let (azimuth, elevation) = (turn * TAU, ((beam + 0.5) / f32::from(BEAMS) - 0.5) * 45_f32.to_radians());
            Vec3::new(azimuth.cos() * elevation.cos(), elevation.sin(), azimuth.sin() * elevation.cos())
        })
        .collect();
    let sun = LightSource::Directional { direction: Vec3::new(-0.5, -0.8, 0.3).normalize() };

    let scene = umbrage::open("demo:shatter?triangles=5000")?;
    // Kept from frame to frame, so that their memory is used again.
    let (mut scanner, mut scanned, mut lit) = (Scanner::default(), Scanned::default(), LitBits::default());
    let mut points = Vec::new();
    for turn in 0..5_u8 {
        let frame = scene.at(f64::from(turn) * 0.1)?;
        let triangles = frame.triangles();
        let origin = triangles.bounds().center().as_dvec3();
        scanner.build(triangles);
        let sweeps = [Sweep { origin, directions: &directions }];
        scanner.scan(&Scan::new(triangles, &sweeps), RETURNS, &mut scanned);
        scanner.lit(&Lit::new(triangles, Receivers::Faces), &[sun], &mut lit);

        points.clear();
        for (index, direction) in directions.iter().enumerate() {
            points.extend(scanned.hits(index).map(|hit| origin + direction.as_dvec3() * hit.t));
        }
        let nearest = scanned.t.iter().copied().fold(f64::INFINITY, f64::min);
        let faces: u32 = lit.of_light(0).iter().map(|word| word.count_ones()).sum();
        println!(
            "turn {turn}: {} hits of {} directions, the nearest {nearest:.3} away; {faces} of {} faces in the sun",
            points.len(),
            scanned.len(),
            triangles.len()
        );
    }
    if let Some(path) = std::env::args_os().nth(1) {
        std::fs::write(path, ply(&points)?)?;
    }
    Ok(())
}

/// Points in a format that most viewers of point clouds read.
fn ply(points: &[DVec3]) -> Result<String, std::fmt::Error> {
    let mut text = format!("ply\nformat ascii 1.0\nelement vertex {}\n", points.len());
    text.push_str("property float x\nproperty float y\nproperty float z\nend_header\n");
    points.iter().try_for_each(|point| writeln!(text, "{} {} {}", point.x, point.y, point.z))?;
    Ok(text)
}
