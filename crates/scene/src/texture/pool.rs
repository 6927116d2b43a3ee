//! Textures on demand: tiles in a temporary file, cached in memory (Peachey, *Texture on Demand*, 1990).

use std::env;
use std::fs::File;
use std::io;
use std::sync::atomic::{AtomicBool, AtomicU32, AtomicU64, AtomicUsize, Ordering};
use std::sync::{OnceLock, PoisonError, RwLock, RwLockWriteGuard, TryLockError};
use std::thread;

use bytesize::ByteSize;
use serde::Serialize;

/// Texels along each side of a tile.
pub(super) const SIDE: usize = 32;
/// Texels of a tile, in rows.
pub(super) const TEXELS: usize = SIDE * SIDE;
const TILE_BYTES: usize = 4 * TEXELS;

/// Storage of texture tiles: all tiles are in an unnamed file, deleted when closed; recently read tiles are in a fixed
/// number of slots in memory.
///
/// A reader looks into the tile's last slot, and checks that it still holds that tile. If not, a clock hand finds a slot
/// that wasn't read since its last pass, and the tile is loaded into that. Each slot has a read-write lock, and no thread
/// waits for a second lock while it holds one.
///
/// Takes 4 KiB and 64 bytes per slot. The levels keep four more bytes per tile of the file.
#[derive(Debug)]
pub struct TilePool {
    file: File,
    /// Number of tiles in the file.
    tiles: AtomicU64,
    /// Maximum number of tiles in memory.
    most_slots: usize,
    /// Created for the first tile read; at most one per tile.
    slots: OnceLock<Box<[Slot]>>,
    hand: AtomicUsize,
    loaded: AtomicU64,
    failure: OnceLock<String>,
}

#[derive(Debug, Default)]
struct Slot {
    resident: RwLock<Resident>,
    /// Whether the slot was read since the hand's last pass.
    is_used: AtomicBool,
    /// Number of cache hits.
    found: AtomicU64,
}

#[derive(Debug)]
struct Resident {
    tile: u64,
    /// Empty before the first tile.
    texels: Vec<[u8; 4]>,
}

/// No tile.
const NONE: u64 = u64::MAX;

impl Default for Resident {
    fn default() -> Self {
        Self { tile: NONE, texels: Vec::new() }
    }
}

/// Index of the slot that last held a tile.
#[derive(Debug)]
pub(super) struct LastSlot(AtomicU32);

impl Default for LastSlot {
    fn default() -> Self {
        Self(AtomicU32::new(u32::MAX))
    }
}

/// Cache statistics of textures on demand ([`Texture::kept_in`](super::Texture::kept_in)).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct TextureTraffic {
    /// Number of tile accesses found in memory; a tile has 32×32 texels.
    pub found: u64,
    /// Number of tiles read from the file.
    pub loaded: u64,
    /// Bytes of the tiles in memory, including each slot's overhead.
    pub resident_bytes: u64,
    /// Bytes of all tiles in the file.
    pub file_bytes: u64,
}

impl TilePool {
    /// The fewest bytes in memory: fifteen tiles.
    pub const MIN_BYTES: u64 = 64 << 10;

    /// Makes a pool of at most `bytes` in memory, or [`MIN_BYTES`](Self::MIN_BYTES) if these are more.
    ///
    /// # Errors
    /// A message why the temporary file can't be made.
    pub fn new(bytes: u64) -> Result<Self, String> {
        let file = tempfile::tempfile().map_err(|error| refused("making it failed", &error))?;
        Ok(Self::with_file(file, bytes))
    }

    /// Makes a pool on a given file.
    pub(super) fn with_file(file: File, bytes: u64) -> Self {
        let bytes = usize::try_from(bytes.max(Self::MIN_BYTES)).unwrap_or(usize::MAX);
        Self {
            file,
            tiles: AtomicU64::new(0),
            most_slots: (bytes / Self::BYTES_OF_SLOT).min(u32::MAX as usize),
            slots: OnceLock::new(),
            hand: AtomicUsize::new(0),
            loaded: AtomicU64::new(0),
            failure: OnceLock::new(),
        }
    }

    const BYTES_OF_SLOT: usize = TILE_BYTES + size_of::<Slot>();

    /// The file's first error, if there was one; some texels are then wrongly black.
    #[must_use]
    pub fn failure(&self) -> Option<&str> {
        self.failure.get().map(String::as_str)
    }

    pub(crate) fn traffic(&self) -> TextureTraffic {
        let slots = self.slots.get().map_or(&[][..], |slots| slots);
        let filled = self.hand.load(Ordering::Relaxed).min(slots.len());
        TextureTraffic {
            found: slots.iter().map(|slot| slot.found.load(Ordering::Relaxed)).sum(),
            loaded: self.loaded.load(Ordering::Relaxed),
            resident_bytes: (filled * TILE_BYTES + size_of_val(slots)) as u64,
            file_bytes: self.tiles.load(Ordering::Relaxed) * TILE_BYTES as u64,
        }
    }

    /// Reserves tiles at the end of the file, and returns the first one's number.
    pub(super) fn reserve(&self, tiles: u64) -> u64 {
        self.tiles.fetch_add(tiles, Ordering::Relaxed)
    }

    /// Writes tiles, starting at number `first`.
    ///
    /// # Errors
    /// A message why it failed, which [`TilePool::failure`] returns from then on, unless an earlier one is kept.
    pub(super) fn write(&self, first: u64, tiles: &[[u8; 4]]) -> Result<(), String> {
        write_all_at(&self.file, tiles.as_flattened(), first * TILE_BYTES as u64).map_err(|error| {
            let all = ByteSize::b(self.tiles.load(Ordering::Relaxed) * TILE_BYTES as u64);
            let why = refused(&format!("writing the first {all} failed"), &error);
            self.failure.get_or_init(|| why.clone());
            why
        })
    }

    /// Reads tiles, starting at number `first`, without caching. Tiles become black where that fails;
    /// see [`TilePool::failure`].
    pub(super) fn read_past(&self, first: u64, tiles: &mut [[u8; 4]]) {
        if let Err(error) = read_exact_at(&self.file, tiles.as_flattened_mut(), first * TILE_BYTES as u64) {
            self.failure.get_or_init(|| refused("reading it failed", &error));
            tiles.fill([0; 4]);
        }
    }

    /// Applies `get` to a tile; `last` is its last slot, which is tried first and updated.
    #[inline]
    pub(super) fn read<R>(&self, tile: u64, last: &LastSlot, get: impl FnOnce(&[[u8; 4]]) -> R) -> R {
        let slots = self.slots();
        if let Some(slot) = slots.get(last.0.load(Ordering::Relaxed) as usize) {
            let resident = slot.resident.read().unwrap_or_else(PoisonError::into_inner);
            if resident.tile == tile {
                if !slot.is_used.load(Ordering::Relaxed) {
                    slot.is_used.store(true, Ordering::Relaxed);
                }
                slot.found.fetch_add(1, Ordering::Relaxed);
                return get(&resident.texels);
            }
        }
        self.load(slots, tile, last, get)
    }

    #[cold]
    fn load<R>(&self, slots: &[Slot], tile: u64, last: &LastSlot, get: impl FnOnce(&[[u8; 4]]) -> R) -> R {
        let (index, mut resident) = self.free_slot(slots);
        let Resident { tile: held, texels } = &mut *resident;
        *held = NONE;
        texels.resize(TEXELS, [0; 4]);
        self.read_past(tile, texels);
        *held = tile;
        self.loaded.fetch_add(1, Ordering::Relaxed);
        slots[index].is_used.store(true, Ordering::Relaxed);
        last.0.store(index as u32, Ordering::Relaxed);
        get(texels)
    }

    /// Finds a slot to evict, and locks it for writing.
    fn free_slot<'a>(&self, slots: &'a [Slot]) -> (usize, RwLockWriteGuard<'a, Resident>) {
        loop {
            for _ in 0..2 * slots.len() {
                let index = self.hand.fetch_add(1, Ordering::Relaxed) % slots.len();
                let slot = &slots[index];
                if slot.is_used.swap(false, Ordering::Relaxed) {
                    continue;
                }
                match slot.resident.try_write() {
                    Ok(resident) => return (index, resident),
                    Err(TryLockError::Poisoned(poisoned)) => return (index, poisoned.into_inner()),
                    Err(TryLockError::WouldBlock) => {}
                }
            }
            // More threads load than there are slots.
            thread::yield_now();
        }
    }

    #[inline]
    fn slots(&self) -> &[Slot] {
        self.slots.get_or_init(|| {
            let tiles = usize::try_from(self.tiles.load(Ordering::Relaxed)).unwrap_or(usize::MAX);
            (0..self.most_slots.min(tiles).max(1)).map(|_| Slot::default()).collect()
        })
    }
}

/// The message for an error of the temporary file, with remedies.
fn refused(what: &str, error: &io::Error) -> String {
    format!(
        "{what}: {error}; it is in {}: free some room there, name another folder (TMPDIR), or hold all textures in memory",
        env::temp_dir().display()
    )
}

/// Reads at a position, so that several threads can use one file.
#[cfg(unix)]
fn read_exact_at(file: &File, bytes: &mut [u8], at: u64) -> io::Result<()> {
    std::os::unix::fs::FileExt::read_exact_at(file, bytes, at)
}

#[cfg(unix)]
fn write_all_at(file: &File, bytes: &[u8], at: u64) -> io::Result<()> {
    std::os::unix::fs::FileExt::write_all_at(file, bytes, at)
}

/// Systems without files, such as browsers.
#[cfg(not(any(unix, windows)))]
fn read_exact_at(_: &File, _: &mut [u8], _: u64) -> io::Result<()> {
    Err(io::ErrorKind::Unsupported.into())
}

#[cfg(not(any(unix, windows)))]
fn write_all_at(_: &File, _: &[u8], _: u64) -> io::Result<()> {
    Err(io::ErrorKind::Unsupported.into())
}

#[cfg(windows)]
fn read_exact_at(file: &File, mut bytes: &mut [u8], mut at: u64) -> io::Result<()> {
    while !bytes.is_empty() {
        match std::os::windows::fs::FileExt::seek_read(file, bytes, at)? {
            0 => return Err(io::ErrorKind::UnexpectedEof.into()),
            read => (bytes, at) = (&mut bytes[read..], at + read as u64),
        }
    }
    Ok(())
}

#[cfg(windows)]
fn write_all_at(file: &File, mut bytes: &[u8], mut at: u64) -> io::Result<()> {
    while !bytes.is_empty() {
        match std::os::windows::fs::FileExt::seek_write(file, bytes, at)? {
            0 => return Err(io::ErrorKind::WriteZero.into()),
            written => (bytes, at) = (&bytes[written..], at + written as u64),
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A pool of minimum size over constant tiles.
    fn pool(tiles: u8) -> (TilePool, Vec<LastSlot>) {
        let pool = TilePool::new(TilePool::MIN_BYTES).unwrap();
        assert_eq!(pool.reserve(u64::from(tiles)), 0);
        for tile in 0..tiles {
            pool.write(u64::from(tile), &[[tile; 4]; TEXELS]).unwrap();
        }
        (pool, (0..tiles).map(|_| LastSlot::default()).collect())
    }

    #[test]
    fn tiles_come_and_stay_while_they_are_read() {
        let (pool, last) = pool(60);
        assert_eq!(pool.traffic(), TextureTraffic { file_bytes: 60 << 12, ..TextureTraffic::default() });
        let first = |tile: usize| pool.read(tile as u64, &last[tile], |texels| texels[TEXELS - 1][0]);
        // The tile that is read all the time stays; the others are evicted in turn.
        for _ in 0..2 {
            for tile in 1..60 {
                assert_eq!((first(0), first(tile)), (0, tile as u8));
            }
        }
        let traffic = pool.traffic();
        assert_eq!(traffic.found + traffic.loaded, 4 * 59);
        assert!((1 + 2 * 59..=2 + 2 * 59).contains(&traffic.loaded), "{traffic:?}");
        assert!(traffic.resident_bytes <= TilePool::MIN_BYTES, "{traffic:?}");
    }

    #[test]
    fn a_pool_that_has_room_for_all_loads_each_once() {
        let (pool, last) = pool(12);
        for tile in (0..12).chain(0..12) {
            assert_eq!(pool.read(tile, &last[tile as usize], |texels| texels[0][3]), tile as u8);
        }
        let TextureTraffic { found, loaded, .. } = pool.traffic();
        assert_eq!((found, loaded), (12, 12));
        // There are no more slots than tiles.
        assert_eq!(pool.slots().len(), 12);
    }

    #[test]
    fn threads_read_what_they_ask_for() {
        let (pool, last) = pool(200);
        let read = |thread: u64| {
            for step in 0..4_000 {
                let tile = (step * (2 * thread + 1) + thread) % 200;
                assert_eq!(pool.read(tile, &last[tile as usize], |texels| texels[7][1]), tile as u8);
            }
        };
        // More threads than slots.
        thread::scope(|scope| {
            for thread in 0..24 {
                scope.spawn(move || read(thread));
            }
        });
        let TextureTraffic { found, loaded, .. } = pool.traffic();
        assert_eq!(found + loaded, 24 * 4_000);
    }

    #[test]
    fn a_file_that_is_cut_off_is_told_and_reads_black() {
        let (pool, last) = pool(3);
        pool.file.set_len(2 << 12).unwrap();
        assert_eq!(pool.read(1, &last[1], |texels| texels[0]), [1; 4]);
        assert_eq!(pool.failure(), None);
        assert_eq!(pool.read(2, &last[2], |texels| texels[0]), [0; 4]);
        assert!(pool.failure().is_some_and(|why| why.starts_with("reading it failed")));
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_full_disk_says_what_to_do() {
        let full = File::options().write(true).open("/dev/full").unwrap();
        let pool = TilePool::with_file(full, 1 << 20);
        let first = pool.reserve(256);
        let why = pool.write(first, &[[0; 4]; TEXELS]).unwrap_err();
        assert!(why.starts_with("writing the first 1.0 MiB failed: No space left on device"), "{why}");
        assert!(why.contains("free some room there, name another folder (TMPDIR)"), "{why}");
        assert_eq!(pool.failure(), Some(&why[..]));
    }
}
