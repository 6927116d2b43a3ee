//! How much memory opening a file may take.

use std::collections::HashMap;
use std::fmt::Display;
use std::hash::Hash;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, LazyLock, OnceLock};

use bytesize::ByteSize;
use sysinfo::{MemoryRefreshKind, System};

/// Half of the memory that this process may have: the machine's, or the container's where that is less. 4 GiB where it isn't known.
pub(crate) static DEFAULT_BYTES: LazyLock<u64> = LazyLock::new(|| {
    let half = System::new().map(|mut system| {
        system.refresh_memory_specifics(MemoryRefreshKind::nothing().with_ram());
        let of_container = system.cgroup_limits().map_or(u64::MAX, |limits| limits.total_memory);
        system.total_memory().min(of_container) / 2
    });
    half.ok().filter(|&half| half > 0).unwrap_or(4 << 30)
});

/// What is left of the memory that a scene's files may take, for all who read them. What is taken isn't given back, so
/// that it doesn't depend on anybody's speed whether a file can be opened.
#[derive(Clone, Debug)]
pub(crate) struct Budget(Arc<Account>);

#[derive(Debug)]
struct Account {
    bytes: u64,
    taken: AtomicU64,
    refusal: OnceLock<String>,
}

/// Without an end.
impl Default for Budget {
    fn default() -> Self {
        Self::new(u64::MAX)
    }
}

impl Budget {
    pub(crate) fn new(bytes: u64) -> Self {
        Self(Arc::new(Account { bytes, taken: AtomicU64::new(0), refusal: OnceLock::new() }))
    }

    /// How many bytes there were at first.
    pub(crate) fn all(&self) -> u64 {
        self.0.bytes
    }

    /// Why something was refused, if anything was.
    pub(crate) fn refusal(&self) -> Option<&str> {
        self.0.refusal.get().map(String::as_str)
    }

    /// Takes memory for `what`, before it is allocated.
    ///
    /// # Errors
    /// Says in words that there isn't enough left.
    pub(crate) fn take(&self, bytes: u64, what: impl Display) -> Result<(), String> {
        let Account { bytes: all, taken, .. } = &*self.0;
        let fits = |taken: u64| taken.checked_add(bytes).filter(|sum| sum <= all);
        match taken.fetch_update(Ordering::Relaxed, Ordering::Relaxed, fits) {
            Ok(_) => Ok(()),
            Err(taken) => {
                let [bytes, taken, all] = [bytes, taken, *all].map(ByteSize::b);
                Err(self.refuse(format!(
                    "{what} would take {bytes}, where {taken} of {all} are taken already; allow more (--max-memory)"
                )))
            }
        }
    }

    /// Takes memory for `count` values of some type.
    ///
    /// # Errors
    /// As [`Budget::take`].
    pub(crate) fn take_for<T>(&self, count: usize, what: impl Display) -> Result<(), String> {
        self.take((count as u64).saturating_mul(size_of::<T>() as u64), what)
    }

    /// Makes room for `more` values at the end of a list, as lists grow by themselves.
    ///
    /// # Errors
    /// As [`Budget::take`], and where the system has no such memory.
    #[inline]
    pub(crate) fn reserve<T>(&self, list: &mut Vec<T>, more: usize, what: impl Display) -> Result<(), String> {
        if list.capacity() - list.len() >= more { Ok(()) } else { self.grow(list, more, what) }
    }

    #[cold]
    fn grow<T>(&self, list: &mut Vec<T>, more: usize, what: impl Display) -> Result<(), String> {
        let doubled = list.capacity().saturating_mul(2);
        let wanted = list.len().saturating_add(more).max(doubled);
        self.take_for::<T>(wanted - list.capacity(), &what)?;
        list.try_reserve_exact(wanted - list.len()).map_err(|error| self.refuse(format!("{what}: {error}")))
    }

    /// As [`Budget::reserve`], for a map.
    ///
    /// # Errors
    /// As [`Budget::reserve`].
    #[inline]
    pub(crate) fn reserve_map<K: Eq + Hash, V>(
        &self,
        map: &mut HashMap<K, V>,
        more: usize,
        what: impl Display,
    ) -> Result<(), String> {
        if map.capacity() - map.len() >= more {
            return Ok(());
        }
        let wanted = (map.len() + more).max(2 * map.capacity());
        self.take_for::<(K, V)>(wanted - map.capacity(), &what)?;
        map.try_reserve(wanted - map.len()).map_err(|error| self.refuse(format!("{what}: {error}")))
    }

    fn refuse(&self, why: String) -> String {
        self.0.refusal.get_or_init(|| why.clone());
        why
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_taken_is_gone() {
        let budget = Budget::new(1000);
        budget.take(600, "the first").unwrap();
        assert_eq!(budget.refusal(), None);
        let refusal = budget.take(401, "the second").unwrap_err();
        assert_eq!(
            refusal,
            "the second would take 401 B, where 600 B of 1000 B are taken already; allow more (--max-memory)"
        );
        budget.take(400, "the third").unwrap();
        // The first refusal is the one that is told.
        budget.clone().take(u64::MAX, "the last").unwrap_err();
        assert_eq!(budget.refusal(), Some(&refusal[..]));
    }

    #[test]
    fn lists_and_maps_take_what_they_hold() {
        let budget = Budget::new(10_000);
        let (mut list, mut map) = (Vec::new(), HashMap::new());
        for number in 0..1000_u32 {
            budget.reserve(&mut list, 1, "a list").unwrap();
            list.push(number);
        }
        assert_eq!(budget.0.taken.load(Ordering::Relaxed), 4 * list.capacity() as u64);
        assert!(budget.reserve(&mut list, 10_000, "a list").is_err() && list.capacity() < 5000);
        let error = (0..10_000_u32).find_map(|number| {
            let refused = budget.reserve_map(&mut map, 1, "a map").err();
            map.insert(number, number);
            refused
        });
        assert!(error.is_some_and(|error| error.starts_with("a map would take")));
        assert!(Budget::default().reserve(&mut vec![0_u8], usize::MAX, "all").is_err());
    }

    #[test]
    fn the_default_is_known() {
        assert!(*DEFAULT_BYTES > 1 << 20);
    }
}
