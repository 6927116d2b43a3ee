//! How far the nearest surface of a moving mesh is: the clearance of a robot's sample points, in each frame.
//!
//! `cargo run --release --example distances` prints its results.

use std::error::Error;

use umbrage::glam::Vec3;
use umbrage::rays::{Closest, ClosestPoints, Nearest};

const SIDE: u16 = 20;

fn main() -> Result<(), Box<dyn Error>> {
    let scene = umbrage::open("demo:cloth?triangles=20000")?;
    // Kept from frame to frame, so that their memory is used again.
    let (mut nearest, mut closest) = (Nearest::default(), ClosestPoints::default());
    for step in 0..5_u8 {
        let frame = scene.at(f64::from(step) * 0.5)?;
        let triangles = frame.triangles();
        let (low, size) = (triangles.bounds().min, triangles.bounds().size());
        let share = |index: u16| f32::from(index) / f32::from(SIDE - 1);
        let points: Vec<Vec3> = (0..SIDE * SIDE)
            .map(|index| low + size * Vec3::new(share(index % SIDE), 0.5, share(index / SIDE)))
            .collect();

        nearest.build(triangles);
        // Surfaces farther than a fifth of the scene's height don't matter.
        let max = f64::from(size.y) / 5.0;
        nearest.closest_points(&Closest { max, ..Closest::new(triangles, &points) }, &mut closest);

        let near = closest.triangle.iter().filter(|&&id| id != ClosestPoints::NONE).count();
        let least = (0..points.len()).min_by(|&a, &b| closest.distance[a].total_cmp(&closest.distance[b]));
        let least = least.expect("there are points");
        println!(
            "{:.1} s: {near} of {} points are within {max:.2}, the nearest at {:.4} from triangle {} at {:.3}",
            f64::from(step) * 0.5,
            points.len(),
            closest.distance[least],
            closest.triangle[least],
            closest.position[least]
        );
    }
    Ok(())
}
