use glam::Vec3;
use std::time::Instant;
use umbrage_rays::{
    Camera, DirectGrids, LightMask, LightSource, Projection, SeenPixels, Shot, SimdLevel, Structure, Triangles, View,
};
fn median(mut v: Vec<f64>) -> f64 {
    v.sort_by(f64::total_cmp);
    v[v.len() / 2]
}
fn main() {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let get = |k: &str, d: usize| args.iter().find_map(|a| a.strip_prefix(k)?.parse().ok()).unwrap_or(d);
    let (rounds, light_no, size) = (get("--rounds=", 11), get("--light=", 0), get("--size=", 1024) as u32);
    let level: SimdLevel = args.iter().find_map(|a| a.strip_prefix("--simd=")?.parse().ok()).unwrap_or_default();
    let only = args.iter().any(|a| a == "--only");
    let brief = args.iter().any(|a| a == "--brief");
    let (mut product, mut count) = (0.0, 0.0);
    for name in args.iter().filter(|a| !a.starts_with("--")) {
        let bytes = std::fs::read(format!("/tmp/scenes/{name}.bin")).unwrap();
        let mut at = 0;
        let mut word = || {
            at += 4;
            [bytes[at - 4], bytes[at - 3], bytes[at - 2], bytes[at - 1]]
        };
        let [nv, nt, nl] = [(); 3].map(|_| u32::from_le_bytes(word()) as usize);
        let mut vec = || Vec3::from_array([(); 3].map(|_| f32::from_le_bytes(word())));
        let (position, right, up, forward, p) = (vec(), vec(), vec(), vec(), vec());
        let projection = if p.x == 0.0 {
            Projection::Perspective { tan_half_height: p.y }
        } else {
            Projection::Orthographic { half_height: p.y }
        };
        let lights: Vec<LightSource> = (0..nl)
            .map(|_| {
                let (a, b) = (vec(), vec());
                if b == Vec3::ZERO {
                    LightSource::Point { position: a }
                } else {
                    LightSource::Directional { direction: a }
                }
            })
            .collect();
        let positions: Vec<Vec3> = (0..nv).map(|_| vec()).collect();
        let indices: Vec<[u32; 3]> = (0..nt).map(|_| [(); 3].map(|_| u32::from_le_bytes(word()))).collect();
        let light = lights[light_no.min(nl - 1)];
        let view = View { camera: Camera { position, right, up, forward, projection }, width: size, height: size };
        let shot = Shot::new(Triangles { positions: &positions, indices: &indices }, view);
        let mut grids = DirectGrids::with_level(level);
        let mut seen = SeenPixels::default();
        let (mut see_times, mut times, mut builds) = (vec![], vec![], vec![]);
        let mut masks = vec![LightMask::default()];
        let mut work = umbrage_rays::Work::default();
        for round in 0..rounds + 3 {
            let start = Instant::now();
            grids.build(shot.triangles);
            let built = Instant::now();
            grids.see(&shot, &mut seen).unwrap();
            let saw = Instant::now();
            work = grids.shadow(&shot, &seen, &[light], &mut masks);
            if round >= 3 {
                builds.push((built - start).as_secs_f64() * 1e3);
                see_times.push((saw - built).as_secs_f64() * 1e3);
                times.push(saw.elapsed().as_secs_f64() * 1e3);
            }
        }
        if !only {
            let mut other = umbrage_rays::ListedGrids::default();
            let mut expected = vec![LightMask::default()];
            other.shadow(&shot, &seen, &[light], &mut expected);
            let (mut lit, mut dark) = (0, 0);
            for (new, old) in masks[0].blocks().iter().zip(expected[0].blocks()) {
                lit += (new & !old).count_ones();
                dark += (old & !new).count_ones();
            }
            if lit + dark > 0 {
                println!("WRONG: lit {lit}, dark {dark}");
            }
        }
        let new = median(times);
        product += new.ln();
        count += 1.0;
        println!(
            "{name}: {} triangles; build {:.2} see {:.2} shadow {new:.2}; bytes {:?}",
            shot.triangles.len(),
            median(builds),
            median(see_times),
            grids.bytes()
        );
        if brief {
            continue;
        }
        let s: Vec<String> =
            work.seconds.named().filter(|(_, v)| *v > 0.0).map(|(n, v)| format!("{n} {:.2}", v * 1e3)).collect();
        let c: Vec<String> = work.counts.named().filter(|(_, v)| *v > 0).map(|(n, v)| format!("{n} {v}")).collect();
        println!("   {}\n      {}", s.join(", "), c.join(", "));
    }
    println!("mean {:.3}", f64::exp(product / count));
}
