use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// Counts the bytes of a device's buffers against a limit.
#[derive(Debug)]
pub(crate) struct Memory {
    taken: AtomicU64,
    limit: u64,
}

/// One buffer's bytes, returned when this is dropped.
#[derive(Debug)]
pub(crate) struct Taken {
    memory: Arc<Memory>,
    bytes: u64,
}

impl Memory {
    pub(crate) fn with_limit(limit: u64) -> Arc<Self> {
        Arc::new(Self { taken: AtomicU64::new(0), limit })
    }

    /// Bytes in use.
    pub(crate) fn taken(&self) -> u64 {
        self.taken.load(Ordering::Relaxed)
    }

    /// Takes `bytes` bytes; `None` if that exceeds the limit.
    pub(crate) fn take(self: &Arc<Self>, bytes: u64) -> Option<Taken> {
        let more = |taken: u64| taken.checked_add(bytes).filter(|taken| *taken <= self.limit);
        self.taken.fetch_update(Ordering::Relaxed, Ordering::Relaxed, more).ok()?;
        Some(Taken { memory: Arc::clone(self), bytes })
    }
}

impl Taken {
    pub(crate) fn bytes(&self) -> u64 {
        self.bytes
    }
}

impl Drop for Taken {
    fn drop(&mut self) {
        self.memory.taken.fetch_sub(self.bytes, Ordering::Relaxed);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_dropped_is_there_again() {
        let memory = Memory::with_limit(100);
        let first = memory.take(60).expect("room");
        assert!(memory.take(41).is_none() && memory.take(u64::MAX).is_none());
        let second = memory.take(40).expect("room");
        assert_eq!(memory.taken(), 100);
        drop(first);
        assert_eq!(memory.taken(), 40);
        drop((second, memory.take(60).expect("room")));
        assert_eq!(memory.taken(), 0);
    }
}
