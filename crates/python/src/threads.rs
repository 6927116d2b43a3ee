//! The threads that compute, without Python's lock.

use std::collections::HashMap;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, LazyLock, Mutex, PoisonError};
use std::thread::available_parallelism;

use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};

/// Maximum threads of a pool.
const MOST: usize = 1024;

/// The number of threads given to [`set_threads`]; 0 for one a processor.
static CHOSEN: AtomicUsize = AtomicUsize::new(0);

/// Pools by process and number of threads: a forked process has none of the threads of the one it came from.
static POOLS: LazyLock<Mutex<Pools>> = LazyLock::new(Mutex::default);

type Pools = HashMap<(u32, usize), Arc<ThreadPool>>;

/// Sets how many threads compute where a call doesn't say.
///
/// Answers are the same, bit for bit, for any number.
///
/// Parameters
/// ----------
/// n : int
///     1 to 1024, or 0 for one a processor, as it is at first.
///
/// Examples
/// --------
/// >>> umbrage.set_threads(2)
/// >>> umbrage.get_threads()
/// 2
/// >>> umbrage.set_threads(0)
#[pyfunction]
pub(crate) fn set_threads(n: usize) -> PyResult<()> {
    check(n, "n")?;
    CHOSEN.store(n, Ordering::Relaxed);
    Ok(())
}

/// How many threads compute where a call doesn't say.
///
/// Returns
/// -------
/// int
///     At least 1.
#[pyfunction]
pub(crate) fn get_threads() -> usize {
    match CHOSEN.load(Ordering::Relaxed) {
        0 => available_parallelism().map_or(1, usize::from).min(MOST),
        chosen => chosen,
    }
}

fn check(threads: usize, name: &str) -> PyResult<()> {
    let is_possible = threads <= MOST;
    let error = || PyValueError::new_err(format!("{name}: expected 0 to {MOST} threads, found {threads}"));
    is_possible.then_some(()).ok_or_else(error)
}

/// The threads of a call; 0 for as many as [`set_threads`] says.
pub(crate) fn pool(nthreads: usize) -> PyResult<Arc<ThreadPool>> {
    check(nthreads, "nthreads")?;
    let threads = if nthreads == 0 { get_threads() } else { nthreads };
    let mut pools = POOLS.lock().unwrap_or_else(PoisonError::into_inner);
    let process = std::process::id();
    if let Some(pool) = pools.get(&(process, threads)) {
        return Ok(pool.clone());
    }
    let pool = ThreadPoolBuilder::new().num_threads(threads).thread_name(|index| format!("umbrage-{index}")).build();
    let pool =
        Arc::new(pool.map_err(|why| PyRuntimeError::new_err(format!("{threads} threads can't be made: {why}")))?);
    pools.insert((process, threads), pool.clone());
    Ok(pool)
}

/// Computes on a pool without Python's lock.
pub(crate) fn compute<R: Send>(py: Python<'_>, pool: &ThreadPool, work: impl FnOnce() -> R + Send) -> R {
    py.detach(|| pool.install(work))
}

/// A call that may take long: its work is in pieces, and after each of them Python's signals are handled.
pub(crate) struct Call {
    pool: Arc<ThreadPool>,
}

impl Call {
    /// Computes a piece; on a thread without Python's lock.
    ///
    /// # Errors
    /// The exception that a signal's handler raises, as `KeyboardInterrupt`.
    pub(crate) fn piece<R: Send>(&self, work: impl FnOnce() -> R + Send) -> PyResult<R> {
        let done = self.pool.install(work);
        handle_signals()?;
        Ok(done)
    }
}

/// Computes in pieces without Python's lock.
pub(crate) fn in_pieces<R: Send>(
    py: Python<'_>,
    nthreads: usize,
    work: impl FnOnce(&Call) -> PyResult<R> + Send,
) -> PyResult<R> {
    let call = Call { pool: pool(nthreads)? };
    py.detach(|| work(&call))
}

/// Handles the signals that came, from a thread without Python's lock.
///
/// # Errors
/// The exception that a signal's handler raises.
#[expect(clippy::redundant_closure_for_method_calls, reason = "the method itself has one lifetime only")]
pub(crate) fn handle_signals() -> PyResult<()> {
    Python::attach(|py| py.check_signals())
}
