//! How much memory opening a file may take.

use std::collections::{BTreeSet, HashMap};
use std::fmt::Display;
use std::hash::Hash;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, LazyLock, Mutex, OnceLock, PoisonError};

use bytesize::ByteSize;
use sysinfo::{MemoryRefreshKind, System};

use crate::folder::Files;
use crate::texture::TilePool;

/// Half of the memory that this process may have: the machine's, the container's, or the address space that the shell allows
/// (`ulimit -v`), the least of them. 4 GiB where none is known.
pub(crate) static DEFAULT_BYTES: LazyLock<u64> = LazyLock::new(|| {
    let half = System::new().map(|mut system| {
        system.refresh_memory_specifics(MemoryRefreshKind::nothing().with_ram());
        let of_container = system.cgroup_limits().map_or(u64::MAX, |limits| limits.total_memory);
        system.total_memory().min(of_container) / 2
    });
    let half = half.ok().filter(|&half| half > 0).unwrap_or(4 << 30);
    half.min(address_space().unwrap_or(u64::MAX) / 2)
});

/// Bytes of addresses that this process may use, where Linux says so.
fn address_space() -> Option<u64> {
    let limits = std::fs::read_to_string("/proc/self/limits").ok()?;
    let line = limits.lines().find_map(|line| line.strip_prefix("Max address space"))?;
    line.split_whitespace().next()?.parse().ok()
}

/// What is left of the memory that a scene's files may take, for all who read them. What is taken isn't given back, so
/// that it doesn't depend on anybody's speed whether a file can be opened: but for [what is made in passing](Budget::in_passing).
#[derive(Clone, Debug)]
pub(crate) struct Budget {
    account: Arc<Account>,
    /// Bytes taken in passing, on top of those of the account.
    passing: Option<Arc<AtomicU64>>,
}

/// What opening a file may take.
#[derive(Clone, Debug)]
pub(crate) struct Limits {
    pub(crate) files: Files,
    pub(crate) bytes: u64,
    /// Bytes of textures' texels in memory; `None` for all of them.
    pub(crate) texture_bytes: Option<u64>,
}

#[derive(Debug)]
struct Account {
    limits: Limits,
    taken: AtomicU64,
    refusal: OnceLock<String>,
    /// Made for the first texture.
    pool: OnceLock<Result<Arc<TilePool>, String>>,
    /// The files that were read.
    files: Mutex<BTreeSet<PathBuf>>,
}

/// Without an end.
impl Default for Budget {
    fn default() -> Self {
        Self::new(Limits { files: Files::OnDisk, bytes: u64::MAX, texture_bytes: None })
    }
}

impl Budget {
    pub(crate) fn new(limits: Limits) -> Self {
        let account = Account {
            limits,
            taken: AtomicU64::new(0),
            refusal: OnceLock::new(),
            pool: OnceLock::new(),
            files: Mutex::default(),
        };
        Self { account: Arc::new(account), passing: None }
    }

    /// The files there are to read.
    pub(crate) fn may_read(&self) -> &Files {
        &self.account.limits.files
    }

    /// How many bytes there were at first.
    pub(crate) fn all(&self) -> u64 {
        self.account.limits.bytes
    }

    /// Keeps in mind that a file is read.
    pub(crate) fn note(&self, file: &Path) {
        self.account.files.lock().unwrap_or_else(PoisonError::into_inner).insert(file.to_owned());
    }

    /// The files that were read so far.
    pub(crate) fn files(&self) -> BTreeSet<PathBuf> {
        self.account.files.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Why something was refused, if anything was.
    pub(crate) fn refusal(&self) -> Option<&str> {
        self.account.refusal.get().map(String::as_str)
    }

    /// What went wrong with the file of textures on demand, if anything did.
    pub(crate) fn texture_failure(&self) -> Option<&str> {
        match self.account.pool.get()? {
            Ok(pool) => pool.failure(),
            Err(why) => Some(why),
        }
    }

    /// Whether textures are kept on demand, so that images are in memory one at a time.
    pub(crate) fn keeps_textures_on_demand(&self) -> bool {
        self.account.limits.texture_bytes.is_some()
    }

    /// Where the texels of textures are kept; `None` for memory.
    ///
    /// # Errors
    /// Says in words why there is no file for them.
    pub(crate) fn tile_pool(&self) -> Result<Option<&Arc<TilePool>>, String> {
        let Some(bytes) = self.account.limits.texture_bytes else { return Ok(None) };
        let pool = self.account.pool.get_or_init(|| TilePool::new(bytes).map(Arc::new));
        pool.as_ref().map(Some).map_err(String::clone)
    }

    /// The same budget for one texture: where textures are kept on demand, what it takes is taken only until the texture
    /// is made, and so that of the next one can be as much. Only one may be made at a time.
    pub(crate) fn in_passing(&self) -> Self {
        let passing = self.keeps_textures_on_demand().then(Arc::default);
        Self { account: Arc::clone(&self.account), passing }
    }

    /// Takes memory that is kept, whatever else is taken in passing.
    ///
    /// # Errors
    /// As [`Budget::take`].
    pub(crate) fn keep(&self, bytes: u64, what: impl Display) -> Result<(), String> {
        Self { account: Arc::clone(&self.account), passing: None }.take(bytes, what)
    }

    /// Takes memory for `what`, before it is allocated.
    ///
    /// # Errors
    /// Says in words that there isn't enough left.
    pub(crate) fn take(&self, bytes: u64, what: impl Display) -> Result<(), String> {
        let (taken, others) = match &self.passing {
            None => (&self.account.taken, 0),
            Some(passing) => (&**passing, self.account.taken.load(Ordering::Relaxed)),
        };
        let left = self.all().saturating_sub(others);
        let fits = |taken: u64| taken.checked_add(bytes).filter(|sum| *sum <= left);
        match taken.fetch_update(Ordering::Relaxed, Ordering::Relaxed, fits) {
            Ok(_) => Ok(()),
            Err(taken) => {
                let [bytes, taken, all] = [bytes, others + taken, self.all()].map(ByteSize::b);
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
        self.account.refusal.get_or_init(|| why.clone());
        why
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_taken_is_gone() {
        let budget = Budget::new(Limits { files: Files::OnDisk, bytes: 1000, texture_bytes: None });
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
        let budget = Budget::new(Limits { files: Files::OnDisk, bytes: 10_000, texture_bytes: None });
        let (mut list, mut map) = (Vec::new(), HashMap::new());
        for number in 0..1000_u32 {
            budget.reserve(&mut list, 1, "a list").unwrap();
            list.push(number);
        }
        assert_eq!(budget.account.taken.load(Ordering::Relaxed), 4 * list.capacity() as u64);
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
