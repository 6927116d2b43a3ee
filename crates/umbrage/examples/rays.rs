//! Rays from anywhere to anywhere: the nearest triangle along each, exactly, through the cheapest structure.
//!
//! `cargo run --release --example rays`

use umbrage::Error;
use umbrage::glam::DVec3;
use umbrage::rays::{Ray, Scanned, Trace, Tracer};

fn main() -> Result<(), Error> {
    let frame = umbrage::open("demo:marbles?triangles=5000")?.at(0.0)?;
    let triangles = frame.triangles();
    let bounds = triangles.bounds();
    let [low, high] = [bounds.min.as_dvec3(), bounds.max.as_dvec3()];
    let direction = |number: u32| {
        let (turn, tilt) = (f64::from(number % 360).to_radians(), (f64::from(number / 360) - 10.0) * 0.15);
        let direction = DVec3::new(turn.cos() * tilt.cos(), tilt.sin(), turn.sin() * tilt.cos());
        // Rounded to single precision, so that a scanner may answer.
        direction.as_vec3().as_dvec3()
    };
    // From above, all around and down; and each from another position.
    let above = (low + high) / 2.0 + DVec3::Y * (high.y - low.y);
    let from_above: Vec<Ray> = (0..3600).map(|number| Ray::new(above, direction(number))).collect();
    let from_anywhere: Vec<Ray> = (0..3600)
        .map(|number| Ray::new(low + (high - low) * (direction(number * 7 % 3600) * 0.5 + 0.5), direction(number)))
        .collect();

    // Kept from frame to frame, so that its memory is used again: `tracer.forget()` when triangles have moved.
    let (mut tracer, mut traced) = (Tracer::default(), Scanned::default());
    for (name, rays) in [("above", from_above), ("anywhere", from_anywhere)] {
        // The opacity decides about hits: rays pass through holes in leaves, and could pass through back faces.
        let trace = Trace { opacity: &frame.camera_opacity(), ..Trace::new(triangles, &rays) };
        let by = tracer.trace(&trace, &mut traced);
        let hits = traced.t.iter().filter(|t| t.is_finite()).count();
        println!("{hits} of {} rays from {name} hit something, says the {by}", rays.len());
        if let Some((index, t)) = traced.t.iter().enumerate().min_by(|(_, a), (_, b)| a.total_cmp(b)) {
            println!("  the nearest is triangle {}, {t:.3} away", traced.triangle[index]);
        }
    }
    Ok(())
}
