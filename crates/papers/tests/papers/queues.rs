use std::sync::atomic::AtomicUsize;
use std::sync::atomic::Ordering::Relaxed;

use umbrage_papers::queue::Queue;

#[test]
fn every_group_is_done_once() {
    for threads in [1, 2, 5] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        for queue in Queue::ALL {
            for groups in [0, 1, 4, 1000] {
                let done: Vec<AtomicUsize> = (0..groups).map(|_| AtomicUsize::new(0)).collect();
                pool.install(|| queue.for_each(groups, |group| _ = done[group].fetch_add(1, Relaxed)));
                let counts: Vec<usize> = done.into_iter().map(AtomicUsize::into_inner).collect();
                assert!(counts.iter().all(|&count| count == 1), "{queue:?}, {threads} threads: {counts:?}");
            }
        }
    }
}

#[test]
fn simulated_threads_take_what_comes_next() {
    let costs = [4.0, 1.0, 1.0, 1.0, 1.0];
    assert_eq!(Queue::RoundRobin.simulated(&costs, 2), 6.0);
    for queue in [Queue::Locked, Queue::Swapped, Queue::Stealing, Queue::Decreasing] {
        assert_eq!(queue.simulated(&costs, 2), 4.0, "{queue:?}");
        assert_eq!(queue.simulated(&costs, 1), 8.0, "{queue:?}");
        assert_eq!(queue.simulated(&[], 3), 0.0);
    }
    // The first thread of two takes a quarter of all at once.
    assert_eq!(Queue::Decreasing.simulated(&[1.0; 8], 2), 4.0);
}
