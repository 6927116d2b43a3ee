//! The memory budget for opening a file.

use std::collections::{BTreeSet, HashMap};
use std::fmt::Display;
use std::hash::Hash;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, LazyLock, Mutex, OnceLock, PoisonError};

use bytesize::ByteSize;
use sysinfo::{MemoryRefreshKind, System};
use umbrage_scene::{Marks, TilePool};

use crate::folder::Files;

/// Default budget: half of the smallest of the machine's memory, the container's, and the shell's limit of the address space
/// (`ulimit -v`). 4 GiB where the memory isn't known.
pub(crate) static DEFAULT_BYTES: LazyLock<u64> = LazyLock::new(|| {
    let half = System::new().map(|mut system| {
        system.refresh_memory_specifics(MemoryRefreshKind::nothing().with_ram());
        let of_container = system.cgroup_limits().map_or(u64::MAX, |limits| limits.total_memory);
        system.total_memory().min(of_container) / 2
    });
    let half = half.ok().filter(|&half| half > 0).unwrap_or(4 << 30);
    half.min(address_space().unwrap_or(u64::MAX) / 2)
});

/// Limit of this process's address space in bytes, where Linux reports it.
fn address_space() -> Option<u64> {
    let limits = std::fs::read_to_string("/proc/self/limits").ok()?;
    let line = limits.lines().find_map(|line| line.strip_prefix("Max address space"))?;
    line.split_whitespace().next()?.parse().ok()
}

/// The shared memory budget of all readers of a scene's files. Memory taken isn't given back, except by
/// [temporary budgets](Budget::in_passing), so that success doesn't depend on the threads' timing.
#[derive(Clone, Debug)]
pub(crate) struct Budget {
    account: Arc<Account>,
    /// Bytes taken temporarily, on top of the account's.
    passing: Option<Arc<AtomicU64>>,
}

/// Limits for opening a file.
#[derive(Clone, Debug)]
pub(crate) struct Limits {
    pub(crate) files: Files,
    pub(crate) bytes: u64,
    /// Maximum bytes of texels in memory; `None` for no limit.
    pub(crate) texture_bytes: Option<u64>,
}

#[derive(Debug)]
struct Account {
    limits: Limits,
    taken: AtomicU64,
    refusal: OnceLock<String>,
    /// Created for the first texture.
    pool: OnceLock<Result<Arc<TilePool>, String>>,
    /// The files that were read.
    files: Mutex<BTreeSet<PathBuf>>,
}

/// Unlimited.
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

    /// The readable files.
    pub(crate) fn may_read(&self) -> &Files {
        &self.account.limits.files
    }

    /// The budget's total bytes.
    pub(crate) fn all(&self) -> u64 {
        self.account.limits.bytes
    }

    /// Records that a file is read.
    pub(crate) fn note(&self, file: &Path) {
        self.account.files.lock().unwrap_or_else(PoisonError::into_inner).insert(file.to_owned());
    }

    /// The files that were read so far.
    pub(crate) fn files(&self) -> BTreeSet<PathBuf> {
        self.account.files.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// The first refusal's message, if there was one.
    pub(crate) fn refusal(&self) -> Option<&str> {
        self.account.refusal.get().map(String::as_str)
    }

    /// The error of the file of textures on demand, if there was one.
    pub(crate) fn texture_failure(&self) -> Option<&str> {
        match self.account.pool.get()? {
            Ok(pool) => pool.failure(),
            Err(why) => Some(why),
        }
    }

    /// Whether textures are kept on demand; images are then in memory one at a time.
    pub(crate) fn keeps_textures_on_demand(&self) -> bool {
        self.account.limits.texture_bytes.is_some()
    }

    /// The pool that keeps textures' texels on demand; `None` where they stay in memory.
    ///
    /// # Errors
    /// A message why the pool's file can't be made.
    pub(crate) fn tile_pool(&self) -> Result<Option<&Arc<TilePool>>, String> {
        let Some(bytes) = self.account.limits.texture_bytes else { return Ok(None) };
        let pool = self.account.pool.get_or_init(|| TilePool::new(bytes).map(Arc::new));
        pool.as_ref().map(Some).map_err(String::clone)
    }

    /// A temporary budget for making one texture. With textures on demand, its memory counts only until that texture is
    /// made, so that the next one may use as much. Only one texture may be made at a time.
    pub(crate) fn in_passing(&self) -> Self {
        let passing = self.keeps_textures_on_demand().then(Arc::default);
        Self { account: Arc::clone(&self.account), passing }
    }

    /// Takes memory permanently, even in a temporary budget.
    ///
    /// # Errors
    /// As [`Budget::take`].
    pub(crate) fn keep(&self, bytes: u64, what: impl Display) -> Result<(), String> {
        Self { account: Arc::clone(&self.account), passing: None }.take(bytes, what)
    }

    /// Takes memory for `what`, before it is allocated.
    ///
    /// # Errors
    /// A message, where too little is left.
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

    /// Reserves room for `more` values in a list, which at least doubles, as `Vec` does.
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

    /// As [`Budget::reserve`], for points and lines.
    ///
    /// # Errors
    /// As [`Budget::reserve`].
    pub(crate) fn reserve_marks(&self, marks: &mut Marks, points: usize, lines: usize) -> Result<(), String> {
        self.take_for::<u32>(points, "points")?;
        self.take_for::<[u32; 2]>(lines, "lines")?;
        marks.reserve(points, lines).map_err(|error| self.refuse(format!("points and lines: {error}")))
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
        // The first refusal is the one reported.
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
