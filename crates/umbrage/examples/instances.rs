//! Rigid objects that move: the object that a ray hits, the triangle, and the position on the object.
//!
//! `cargo run --release --example instances` turns two signs on a pole; with `-- scene.glb` it traces a file's nodes.

use std::error::Error;

use umbrage::glam::{DAffine3, DVec3, Vec3};
use umbrage::rays::{Ray, Scanned, Trace, Tracer};
use umbrage::scene::Instances;

fn main() -> Result<(), Box<dyn Error>> {
    let (mut tracer, mut traced) = (Tracer::default(), Scanned::default());
    if let Some(path) = std::env::args_os().nth(1) {
        let instances = Instances::of_scene(&umbrage::open(path)?, 0.0)?;
        print(&instances, &mut tracer, &mut traced);
        return Ok(());
    }

    // A square of side 2 around its own origin, twice.
    let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|[x, y]| Vec3::new(x, y, 0.0));
    let square = [[0, 1, 2], [0, 2, 3]];
    let mut instances = Instances::default();
    let low = instances.add("low sign", &corners, &square)?;
    let high = instances.add("high sign", &corners, &square)?;
    for step in 0..4_u8 {
        let turn = f64::from(step) * 0.4;
        for (sign, height, turn) in [(low, 1.0, turn), (high, 3.5, -turn)] {
            let place = DAffine3::from_rotation_y(turn);
            instances.set_transform(sign, DAffine3 { translation: DVec3::Y * height, ..place });
        }
        println!("turned by {turn:.1}:");
        // The tracer's structures are of the old positions.
        tracer.forget();
        print(&instances, &mut tracer, &mut traced);
    }
    Ok(())
}

/// Prints the hits of five rays from the front.
fn print(instances: &Instances, tracer: &mut Tracer, traced: &mut Scanned) {
    let bounds = instances.triangles().bounds();
    let [low, high] = [bounds.min.as_dvec3(), bounds.max.as_dvec3()];
    let front = DVec3::new(0.5 * (low.x + high.x), low.y, high.z + (high - low).length());
    let rays: Vec<Ray> = (0..5_u8)
        .map(|step| Ray::new(front.with_y(low.y + (high.y - low.y) * (0.1 + 0.2 * f64::from(step))), DVec3::NEG_Z))
        .collect();
    tracer.trace(&Trace::new(instances.triangles(), &rays), traced);
    for (index, ray) in rays.iter().enumerate() {
        let Some(hit) = traced.hits(index).next() else {
            println!("  at height {:5.2}: nothing", ray.origin.y);
            continue;
        };
        let there = instances.hit(&hit);
        let name = instances.all()[there.instance as usize].name();
        println!(
            "  at height {:5.2}: {name}, triangle {}, at {:.2} of it",
            ray.origin.y, there.triangle, there.position
        );
    }
}
