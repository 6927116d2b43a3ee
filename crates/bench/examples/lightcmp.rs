use glam::Vec3;
use std::sync::atomic::Ordering;
use std::time::Instant;
use umbrage::rays::{Camera, DirectGrids, LightMask, LightSource, SeenPixels, Shot, Structure, View, internals::MODE};
use umbrage::scene::Frame;
fn median(mut v: Vec<f64>) -> f64 {
    v.sort_by(f64::total_cmp);
    v[v.len() / 2]
}
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
    let args: Vec<String> = std::env::args().skip(1).collect();
    let get = |k: &str, d: usize| args.iter().find_map(|a| a.strip_prefix(k)?.parse().ok()).unwrap_or(d);
    let (rounds, light_no, size) = (get("--rounds=", 11), get("--light=", 0), get("--size=", 1024) as u32);
    let only = args.iter().any(|a| a == "--only");
    for address in args.iter().filter(|a| !a.starts_with("--")) {
        let scene = umbrage::open(address).unwrap();
        let mut frame = Frame::default();
        scene.pose(scene.duration_seconds() * 4.0 / 9.0, &mut frame).unwrap();
        let inside = interior(address);
        let camera = inside.map_or_else(
            || frame.camera(1.0),
            |(eye, target, fov, _)| Camera::look_at(eye, target, Vec3::Y, fov.to_radians()),
        );
        let light = inside.map_or_else(
            || frame.lights[light_no.min(frame.lights.len() - 1)].source,
            |i| LightSource::Point { position: i.3 },
        );
        let view = View { camera, width: size, height: size };
        let shot = Shot::new(frame.triangles(), view);
        let mut grids = DirectGrids::default();
        let mut seen = SeenPixels::default();
        let (mut see_times, mut times) = (vec![], [vec![], vec![]]);
        let mut masks = vec![LightMask::default()];
        let mut works = [None; 2];
        for round in 0..rounds + 2 {
            grids.build(shot.triangles);
            let start = Instant::now();
            grids.see(&shot, &mut seen).unwrap();
            if round >= 2 {
                see_times.push(start.elapsed().as_secs_f64() * 1e3);
            }
            for mode in [1, 0] {
                if only && mode == 1 {
                    continue;
                }
                MODE.store(mode, Ordering::Relaxed);
                let start = Instant::now();
                let work = grids.shadow(&shot, &seen, &[light], &mut masks);
                let t = start.elapsed().as_secs_f64() * 1e3;
                if round >= 2 {
                    times[usize::from(mode)].push(t);
                    works[usize::from(mode)] = Some(work);
                }
            }
        }
        MODE.store(2, Ordering::Relaxed);
        grids.shadow(&shot, &seen, &[light], &mut masks);
        let new = median(times[0].clone());
        let old = if only { f64::NAN } else { median(times[1].clone()) };
        println!(
            "{address}: {} triangles; see {:.2}; old {old:.2} new {new:.2}: {:.2} times",
            shot.triangles.len(),
            median(see_times),
            old / new
        );
        for work in works.iter().flatten() {
            let s: Vec<String> =
                work.seconds.named().filter(|(_, v)| *v > 0.0).map(|(n, v)| format!("{n} {:.2}", v * 1e3)).collect();
            let c: Vec<String> = work.counts.named().filter(|(_, v)| *v > 0).map(|(n, v)| format!("{n} {v}")).collect();
            println!("   {}\n      {}", s.join(", "), c.join(", "));
        }
    }
}
