//! Rays from anywhere to anywhere: the nearest triangle along each, exactly.
//!
//! `cargo run --release --example rays`

use umbrage::Error;
use umbrage::glam::DVec3;
use umbrage::rays::{Hit, KdTree, Opacity, Ray, SingleRays};

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

    // Says which hits stop the ray: it goes through holes in leaves here, and could go through back faces.
    let opacity = frame.camera_opacity();
    let stops = |hit: &Hit| opacity.stops(hit.triangle, hit.barycentric);
    let (mut hits, mut nearest) = (0, None);
    for ray in rays {
        let Some(hit) = tree.nearest(triangles, &ray, &stops) else { continue };
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
