//! Triangles of your own that change in each frame: a waving cloth of 20,000 triangles.
//!
//! `cargo run --release --example own_triangles`

use umbrage::glam::Vec3;
use umbrage::rays::{Camera, LightSource};
use umbrage::scene::{Frame, Light};
use umbrage::{Error, Film, Renderer, Settings};

/// Squares along each side of the cloth.
const SIDE: u32 = 100;

fn main() -> Result<(), Error> {
    // The triangles' vertex indices stay; positions change below.
    let corner = |column: u32, row: u32| row * (SIDE + 1) + column;
    let squares = (0..SIDE).flat_map(|row| (0..SIDE).map(move |column| (column, row)));
    let triangles = squares.flat_map(|(x, y)| {
        let (a, b, c, d) = (corner(x, y), corner(x + 1, y), corner(x + 1, y + 1), corner(x, y + 1));
        [[a, b, c], [a, c, d]]
    });
    let vertices = (SIDE + 1) * (SIDE + 1);
    let mut frame = Frame::from_triangles(vec![Vec3::ZERO; vertices as usize], triangles.collect());
    frame.lights = vec![Light {
        name: "sun".into(),
        ..Light::new(LightSource::Directional { direction: Vec3::new(-0.5, -1.0, -0.3) }, 3.0)
    }];

    let camera = Camera::look_at(Vec3::new(0.0, 1.0, 1.6), Vec3::ZERO, Vec3::Y, 0.8);
    let settings = Settings { width: 320, height: 180, camera: camera.into(), ..Settings::default() };
    let mut renderer = Renderer::default();
    for number in 0..5 {
        let seconds = 0.1 * number as f32;
        for (vertex, position) in frame.positions.iter_mut().enumerate() {
            let (column, row) = (vertex as u32 % (SIDE + 1), vertex as u32 / (SIDE + 1));
            let [x, z] = [column, row].map(|steps| steps as f32 / SIDE as f32 - 0.5);
            *position = Vec3::new(x, 0.1 * (12.0 * x + 9.0 * seconds).sin() * (7.0 * z).cos(), z);
        }
        // The frame is borrowed, and the structures over its triangles are rebuilt.
        let film = renderer.render_frame(&frame, &settings)?;
        let shown = film.triangle.iter().filter(|&&triangle| triangle != Film::NO_TRIANGLE).count();
        println!("frame {number}: {shown} pixels show the cloth, {:.1} ms", renderer.stats().total_milliseconds());
    }
    Ok(())
}
