//! What a frame takes from the heap that is like the last one.

use umbrage::rays::Choice as _;
use umbrage::scene::Frame;
use umbrage::{Renderer, Settings, Structure};

/// How often the third of three frames asks for memory, on one thread that does all the work.
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
        for &(structure_name, structure, _) in Structure::CHOICES {
            let of_samples = [1, 4].map(|samples| {
                let settings = Settings { width: 70, height: 50, structure, samples, ..Settings::default() };
                allocations(&frame, &settings)
            });
            // Trees are built anew for a frame, in memory of their own: see, shadow and shade take nothing.
            let is_tree = matches!(structure, Structure::KdTree(..) | Structure::Bvh);
            assert!(is_tree || of_samples[0] == 0, "{name}, {structure_name}: {of_samples:?}");
            assert_eq!(of_samples[0], of_samples[1], "{name}, {structure_name}");
        }
    }
}
