//! Allocations of a frame that is like the last one.

use glam::{DVec3, Vec3};
use umbrage::rays::{
    Closest, ClosestPoints, LightSource, Lit, LitBits, Nearest, Ray, Receivers, Scan, Scanned, Scanner, Sweep, Trace,
    TracedBy, Tracer,
};
use umbrage::scene::Frame;
use umbrage::{Renderer, Settings};
use umbrage_papers::structures;

/// Number of allocations of the third of three frames, on one thread that does all the work.
fn allocations(frame: &Frame, settings: &Settings) -> usize {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
    pool.install(|| {
        let mut renderer = Renderer::default();
        let counted = [(); 3].map(|()| {
            let before = allocations::on_this_thread();
            renderer.render_frame(frame, settings).expect("a picture");
            allocations::on_this_thread() - before
        });
        assert!(counted[0] > 0, "the first frame is counted");
        counted[2]
    })
}

#[test]
fn steady_frames_take_nothing_from_the_heap() {
    for name in ["demo:cloth?triangles=800", "demo:shatter?triangles=800", "demo:forest?triangles=3000"] {
        let frame = umbrage::open(name).and_then(|scene| scene.at(0.25)).expect("a frame");
        for structure in structures().iter() {
            let structure_name = structure.name();
            let of_samples = [1, 4].map(|samples| {
                let settings =
                    Settings { width: 70, height: 50, structure: structure.clone(), samples, ..Settings::default() };
                allocations(&frame, &settings)
            });
            // Trees are rebuilt for a frame, in memory of their own: see, shadow and shade allocate nothing.
            let is_tree = matches!(structure_name, "kdtree" | "bvh");
            assert!(is_tree || of_samples[0] == 0, "{name}, {structure_name}: {of_samples:?}");
            assert_eq!(of_samples[0], of_samples[1], "{name}, {structure_name}");
        }
    }
}

#[test]
fn steady_scans_take_nothing_from_the_heap() {
    let frame = umbrage::open("demo:cloth?triangles=3000").and_then(|scene| scene.at(0.25)).expect("a frame");
    let triangles = frame.triangles();
    let directions: Vec<Vec3> =
        (0..9000).map(|of| Vec3::new((of as f32).sin(), (of as f32 * 0.7).cos(), 0.3)).collect();
    let sweeps = [Sweep { origin: DVec3::new(0.0, 1.0, 0.0), directions: &directions }];
    let lamps = [LightSource::Point { position: Vec3::new(0.3, 3.0, 0.1) }];
    let suns = [-0.3, -0.1, 0.2].map(|x| LightSource::Directional { direction: Vec3::new(x, -1.0, 0.1) });
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
    pool.install(|| {
        let (mut scanner, mut scanned, mut bits) = (Scanner::default(), Scanned::default(), LitBits::default());
        let (mut hit, mut of_lamps, mut first) = (Vec::new(), LitBits::default(), Scanned::default());
        let (mut nearest, mut closest) = (Nearest::default(), ClosestPoints::default());
        let counted = [(); 3].map(|()| {
            let before = allocations::on_this_thread();
            scanner.build(triangles);
            scanner.scan(&Scan::new(triangles, &sweeps), 2, &mut scanned);
            scanner.hits_any(&Scan::new(triangles, &sweeps), &mut hit);
            scanner.scan(&Scan::new(triangles, &sweeps), 1, &mut first);
            nearest.build(triangles);
            nearest.signed_distances(&Closest::new(triangles, &directions), &mut closest);
            // So many lights that each thread takes its own, and fewer.
            scanner.lit(&Lit::new(triangles, Receivers::Faces), &suns, &mut bits);
            scanner.lit(&Lit::new(triangles, Receivers::Samples(2)), &lamps, &mut of_lamps);
            allocations::on_this_thread() - before
        });
        assert!(counted[0] > 0, "the first frame is counted");
        assert_eq!(counted[2], 0, "{counted:?}");
        assert!(scanned.triangle.iter().any(|&id| id != Scanned::NONE));
    });
}

#[test]
fn steady_rays_take_nothing_from_the_heap() {
    let frame = umbrage::open("demo:cloth?triangles=3000").and_then(|scene| scene.at(0.25)).expect("a frame");
    let triangles = frame.triangles();
    let direction = |of: u16| Vec3::new(f32::from(of).sin(), (f32::from(of) * 0.7).cos(), 0.3).as_dvec3();
    let together: Vec<Ray> = (0..9000).map(|of| Ray::new(DVec3::Y, direction(of))).collect();
    let apart: Vec<Ray> = (0..9000).map(|of| Ray::new(direction(of), direction(of + 1))).collect();
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
    for (rays, by) in [(together, TracedBy::Scanner), (apart, TracedBy::Hierarchy)] {
        let counted = pool.install(|| {
            let (mut tracer, mut traced) = (Tracer::default(), Scanned::default());
            [(); 4].map(|()| {
                // A hierarchy is built in memory of its own.
                if by == TracedBy::Scanner {
                    tracer.forget();
                }
                let before = allocations::on_this_thread();
                assert_eq!(tracer.trace(&Trace::new(triangles, &rays), &mut traced), by);
                allocations::on_this_thread() - before
            })
        });
        assert!(counted[0] > 0 && counted[3] == 0, "{by}: {counted:?}");
    }
}
