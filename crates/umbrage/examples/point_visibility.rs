//! Which points of a set does a light reach, and which does a camera see?
//!
//! `cargo run --release --example point_visibility`

use umbrage::Error;
use umbrage::glam::{DVec3, Vec3};
use umbrage::rays::predicate::{HitPoint, ShadowRay};
use umbrage::rays::{Bvh, LightSource, Opacity, SeenPixels, SingleRays};

fn main() -> Result<(), Error> {
    let frame = umbrage::open("demo:shatter?triangles=2000")?.at(0.5)?;
    let triangles = frame.triangles();
    // Every structure that answers single rays has the same methods.
    let mut bvh = Bvh::default();
    bvh.build(triangles);

    // Whether a point in the air is lit. The point is on no triangle, so none is left out.
    let opacity = frame.shadow_opacity();
    let is_reached = |light: &LightSource, position: DVec3| {
        let segment = ShadowRay::new(light, HitPoint { position, error: 0.0 });
        !bvh.blocked(triangles, &segment, SeenPixels::NONE, &|id, barycentric| opacity.stops(id, barycentric))
    };

    // Points all over the triangles' bounds.
    let bounds = triangles.bounds();
    let points: Vec<DVec3> = (0..1000)
        .map(|number| {
            let steps = Vec3::new((number % 10) as f32, (number / 10 % 10) as f32, (number / 100) as f32);
            (bounds.min + (bounds.max - bounds.min) * (steps + 0.5) / 10.0).as_dvec3()
        })
        .collect();
    for light in &frame.lights {
        let lit = points.iter().filter(|&&point| is_reached(&light.source, point)).count();
        println!("the light `{}` reaches {lit} of {} points", light.name, points.len());
    }
    // A camera sees the points that a light at its position would reach; points outside of its picture must still be left
    // out.
    let eye = LightSource::Point { position: frame.camera(16.0 / 9.0).position };
    let seen = points.iter().filter(|&&point| is_reached(&eye, point)).count();
    println!("the camera's position sees {seen} of {} points", points.len());
    Ok(())
}
