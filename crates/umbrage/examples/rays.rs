//! Rays from anywhere to anywhere: the nearest triangle along each, exactly.
//!
//! `cargo run --release --example rays`

use umbrage::Error;
use umbrage::glam::DVec3;
use umbrage::rays::{KdTree, Ray};

fn main() -> Result<(), Error> {
    let frame = umbrage::open("demo:marbles?triangles=5000")?.at(0.0)?;
    let triangles = frame.triangles();
    // Triangles that move ask for another build; the tree's memory is used again.
    let mut tree = KdTree::default();
    tree.build(triangles);

    // A scanner above the scene that looks all around and down.
    let bounds = triangles.bounds();
    let [low, high] = [bounds.min.as_dvec3(), bounds.max.as_dvec3()];
    let origin = (low + high) / 2.0 + DVec3::Y * (high.y - low.y);
    let rays = (0..3600).map(|number| {
        let (turn, tilt) = (f64::from(number % 360).to_radians(), f64::from(number / 360 - 10) * 0.15);
        Ray::new(origin, DVec3::new(turn.cos() * tilt.cos(), tilt.sin(), turn.sin() * tilt.cos()))
    });

    let (mut hits, mut nearest) = (0, None);
    for ray in rays {
        // The last argument may let the ray through what it hits: holes in leaves, or back faces.
        let Some(hit) = tree.nearest(triangles, &ray, |hit| frame.is_solid(hit.triangle, hit.barycentric)) else {
            continue;
        };
        hits += 1;
        if nearest.is_none_or(|(t, _)| hit.t < t) {
            nearest = Some((hit.t, hit.triangle));
        }
    }
    println!("{hits} of 3600 rays hit something");
    if let Some((t, triangle)) = nearest {
        println!("the nearest is triangle {triangle}, {t:.3} away: {:?}", triangles.corners(triangle));
    }
    Ok(())
}
