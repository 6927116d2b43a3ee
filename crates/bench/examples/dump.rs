use glam::Vec3;
use std::io::Write;
use umbrage::rays::{Camera, LightSource, Projection};
use umbrage::scene::Frame;
fn interior(address: &str) -> Option<(Vec3, Vec3, f32, Vec3)> {
    match address.rsplit('/').next().unwrap() {
        "sibenik.obj" => Some((Vec3::new(14.0, 6.0, 2.0), Vec3::new(-10.0, 4.0, -1.0), 75.0, Vec3::new(3.0, 8.0, 0.0))),
        "country_kitchen.glb" => {
            Some((Vec3::new(1.211, 1.8, 3.85), Vec3::new(0.0, 1.0, -1.0), 60.0, Vec3::new(1.0, 2.6, 1.0)))
        }
        "dream_apartment.glb" => {
            Some((Vec3::new(8.3, 1.6, -6.8), Vec3::new(11.0, 0.9, -3.0), 75.0, Vec3::new(10.0, 2.4, -5.0)))
        }
        _ => None,
    }
}
fn main() {
    for address in std::env::args().skip(1) {
        let scene = umbrage::open(&address).unwrap();
        let mut frame = Frame::default();
        scene.pose(scene.duration_seconds() * 4.0 / 9.0, &mut frame).unwrap();
        let inside = interior(&address);
        let camera = inside.map_or_else(
            || frame.camera(1.0),
            |(eye, target, fov, _)| Camera::look_at(eye, target, Vec3::Y, fov.to_radians()),
        );
        let lights: Vec<LightSource> = inside.map_or_else(
            || frame.lights.iter().map(|l| l.source).collect(),
            |i| vec![LightSource::Point { position: i.3 }],
        );
        let name = address.rsplit(['/', ':']).next().unwrap().split('.').next().unwrap().to_owned();
        let mut f = std::io::BufWriter::new(std::fs::File::create(format!("/tmp/scenes/{name}.bin")).unwrap());
        let tri = frame.triangles();
        f.write_all(&(tri.positions.len() as u32).to_le_bytes()).unwrap();
        f.write_all(&(tri.indices.len() as u32).to_le_bytes()).unwrap();
        f.write_all(&(lights.len() as u32).to_le_bytes()).unwrap();
        let mut v = |v: Vec3| {
            for x in v.to_array() {
                f.write_all(&x.to_le_bytes()).unwrap();
            }
        };
        v(camera.position);
        v(camera.right);
        v(camera.up);
        v(camera.forward);
        match camera.projection {
            Projection::Perspective { tan_half_height } => v(Vec3::new(0.0, tan_half_height, 0.0)),
            Projection::Orthographic { half_height } => v(Vec3::new(1.0, half_height, 0.0)),
        }
        for l in lights {
            match l {
                LightSource::Point { position } | LightSource::Spot { position, .. } => {
                    v(position);
                    v(Vec3::ZERO)
                }
                LightSource::Directional { direction } => {
                    v(direction);
                    v(Vec3::ONE)
                }
            }
        }
        for &p in tri.positions {
            v(p);
        }
        for t in tri.indices {
            for i in t {
                f.write_all(&i.to_le_bytes()).unwrap();
            }
        }
        println!("{name}");
    }
}
