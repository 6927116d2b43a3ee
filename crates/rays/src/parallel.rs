//! Loops on the threads of the current rayon pool, compiled once.
//!
//! rayon's own loops compile its scheduler anew for each closure: that was a fifth of this library's code. Here rayon
//! sees only `join`, which isn't generic, and loops are divided as rayon divides them.

use rayon::iter::IndexedParallelIterator;
use rayon::iter::plumbing::{Producer, ProducerCallback};

/// Loops over rayon's iterators of known length.
pub trait Parallel: IndexedParallelIterator {
    /// As `for_each`: calls `work` with every item, on all threads.
    fn each(self, work: impl Fn(Self::Item) + Sync) {
        let count = self.len();
        let _: Option<()> = self.with_producer(Callback { count, work: &work, merge: &|(), ()| () });
    }

    /// As `reduce_with`: all items, merged two by two in their order; `None` where there are none. The order of merging
    /// depends on the threads.
    fn merge(self, merge: impl Fn(Self::Item, Self::Item) -> Self::Item + Sync) -> Option<Self::Item> {
        let count = self.len();
        self.with_producer(Callback { count, work: &|item| item, merge: &merge })
    }
}

impl<I: IndexedParallelIterator> Parallel for I {}

/// As `rayon::join`: calls both, on two threads where one is free.
pub fn both<A: Send, B: Send>(a: impl FnOnce() -> A + Send, b: impl FnOnce() -> B + Send) -> (A, B) {
    let (mut a, mut b) = (Some(a), Some(b));
    let (mut of_a, mut of_b) = (None, None);
    join(&mut |_| of_a = a.take().map(|a| a()), &mut |_| of_b = b.take().map(|b| b()));
    of_a.zip(of_b).expect("both have been called")
}

/// Calls both, on two threads where one is free, and tells each whether it runs on another thread than the caller's.
fn join(a: &mut (dyn FnMut(bool) + Send), b: &mut (dyn FnMut(bool) + Send)) {
    rayon::join_context(|context| a(context.migrated()), |context| b(context.migrated()));
}

/// Receives the producer of an iterator, of any type, and runs the loop over it.
struct Callback<'a, W, M> {
    count: usize,
    work: &'a W,
    merge: &'a M,
}

impl<Item, T, W, M> ProducerCallback<Item> for Callback<'_, W, M>
where
    T: Send,
    W: Fn(Item) -> T + Sync,
    M: Fn(T, T) -> T + Sync,
{
    type Output = Option<T>;

    fn callback<P: Producer<Item = Item>>(self, producer: P) -> Option<T> {
        let parts = Parts::new(self.count, [producer.min_len(), producer.max_len()]);
        run(producer, self.count, parts, self.work, self.merge)
    }
}

/// Runs `work` on `count` items: in two halves, on two threads, as long as `parts` allows; then one after the other.
fn run<P: Producer, T: Send>(
    producer: P,
    count: usize,
    parts: Parts,
    work: &(impl Fn(P::Item) -> T + Sync),
    merge: &(impl Fn(T, T) -> T + Sync),
) -> Option<T> {
    if !parts.is_divided(count) {
        return producer.into_iter().map(work).reduce(merge);
    }
    let middle = count / 2;
    let (low, high) = producer.split_at(middle);
    let (mut low, mut high) = (Some(low), Some(high));
    let (mut of_low, mut of_high) = (None, None);
    join(
        &mut |has_moved| of_low = low.take().and_then(|low| run(low, middle, parts.half(has_moved), work, merge)),
        &mut |has_moved| {
            of_high = high.take().and_then(|high| run(high, count - middle, parts.half(has_moved), work, merge));
        },
    );
    match (of_low, of_high) {
        (Some(low), Some(high)) => Some(merge(low, high)),
        (low, high) => low.or(high),
    }
}

/// The number of parts into which the items are still to be divided, and the fewest items of a part. The number of parts
/// starts as that of threads; a half that an idle thread takes over gets at least as many again.
#[derive(Clone, Copy)]
struct Parts {
    count: usize,
    fewest: usize,
}

impl Parts {
    fn new(items: usize, [fewest, most]: [usize; 2]) -> Self {
        let count = rayon::current_num_threads().max(items / most.max(1));
        Self { count, fewest: fewest.max(1) }
    }

    fn is_divided(self, items: usize) -> bool {
        self.count > 0 && items / 2 >= self.fewest
    }

    fn half(self, has_moved: bool) -> Self {
        let count = self.count / 2;
        let count = if has_moved { count.max(rayon::current_num_threads()) } else { count };
        Self { count, ..self }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicU32, Ordering};

    use rayon::prelude::*;

    use super::*;

    #[test]
    fn every_item_has_its_turn_once() {
        for threads in [1, 2, 5] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
            pool.install(|| {
                for count in [0, 1, 2, 3, 64, 1000] {
                    for [fewest, most] in [[1, 1], [1, count.max(1)], [7, 100], [count + 1, count + 1]] {
                        let turns: Vec<_> = (0..count).map(|_| AtomicU32::new(0)).collect();
                        turns.par_iter().with_min_len(fewest).with_max_len(most).each(|turn| {
                            turn.fetch_add(1, Ordering::Relaxed);
                        });
                        assert!(turns.iter().all(|turn| turn.load(Ordering::Relaxed) == 1));
                        let numbers = (0..count).into_par_iter().with_min_len(fewest).with_max_len(most);
                        let in_order = numbers.map(|number| vec![number]).merge(|one, other| [one, other].concat());
                        assert_eq!(in_order.unwrap_or_default(), (0..count).collect::<Vec<_>>());
                    }
                }
                assert_eq!(both(|| 1, || "two"), (1, "two"));
            });
        }
    }

    #[test]
    fn other_threads_help() {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().expect("a pool");
        let barrier = std::sync::Barrier::new(2);
        pool.install(|| {
            // Each waits for the other.
            (0..2).into_par_iter().with_max_len(1).each(|_| {
                barrier.wait();
            });
            both(|| barrier.wait(), || barrier.wait());
        });
    }
}
