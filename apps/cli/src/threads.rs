//! The threads that render.

use std::hint::black_box;
use std::thread;

use crate::failure::{Failure, say};

/// Starts the thread pool: `threads`, or one thread for each processor.
///
/// No more threads are started than pictures of `size` have work for, since idle threads slow down the others.
pub(crate) fn use_threads(threads: Option<u16>, size: Option<[u32; 2]>) -> Result<(), Failure> {
    const PIXELS_OF_THREAD: u64 = 1024;
    const ALWAYS_ALLOWED: usize = 16;
    let asked = usize::from(threads.unwrap_or(0));
    let processors = thread::available_parallelism().map_or(1, usize::from);
    let most = size.map_or(usize::MAX, |[width, height]| {
        let busy = u64::from(width) * u64::from(height) / PIXELS_OF_THREAD;
        usize::try_from(busy).unwrap_or(usize::MAX).max(processors).max(ALWAYS_ALLOWED)
    });
    if asked > most {
        say(format_args!("note: --threads {asked}: {most} work, since the picture is too small for more"));
    }
    let count = asked.min(most);
    let built = if has_room_for_threads(if count == 0 { processors } else { count }) {
        rayon::ThreadPoolBuilder::new().num_threads(count).build_global().map_err(|error| error.to_string())
    } else {
        Err("no memory for their stacks".to_owned())
    };
    built.map_err(|error| match threads {
        Some(threads) => Failure::Work(format!("--threads {threads}: {error}; fewer may do")),
        None => Failure::Work(format!("no threads could be started: {error}; fewer may do (--threads 1)")),
    })
}

/// Whether the stacks of `count` threads fit into memory.
///
/// A thread that starts when they have taken all of it can't allocate its own tables, and aborts the program.
fn has_room_for_threads(count: usize) -> bool {
    const STACK: usize = 2 << 20;
    const TABLES: usize = 256 << 10;
    let mut room = Vec::<u8>::new();
    let has_room = room.try_reserve_exact(count.saturating_mul(STACK + TABLES)).is_ok();
    // Without this the compiler may leave out memory that nothing uses.
    black_box(&room);
    has_room
}
