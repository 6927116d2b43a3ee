//! Numbered files as an animation.

mod names;
mod search;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use glam::DVec3;
use umbrage_scene::{Animated, Error, Frame};

use crate::folder::Files;
use crate::{OpenOptions, obj, open::read_still, still::Still};

/// Numbered files, one for each frame of an animation; each may have its own topology.
///
/// Frame k shows from k / fps to (k + 1) / fps. Files are read on demand.
#[derive(Debug)]
pub(crate) struct Sequence {
    /// In display order; never empty.
    paths: Vec<PathBuf>,
    fps: f64,
    warnings: Vec<String>,
    /// Origin of all files: the first file's.
    origin: DVec3,
    recent: Mutex<Recent>,
}

/// The files read last, so that posing a moment twice, or two neighbours in turn, reads nothing again.
#[derive(Debug)]
struct Recent {
    /// With their indices in `paths`; the latest last.
    stills: Vec<(usize, Arc<Still>)>,
    materials: obj::SharedMaterials,
}

impl Recent {
    const CAPACITY: usize = 2;
}

impl Sequence {
    /// The sequence that `address` means: a pattern with `%04d` or `*`, or a folder; `None` for a plain file.
    ///
    /// In a pattern, only the file name may have wildcards, and only OBJ, PLY and STL files match. In a folder, the
    /// sequence is the largest set of files whose names differ in one number only.
    ///
    /// # Errors
    /// Where `address` is a pattern or folder that has no such files, their number a second isn't above 0, or the first
    /// file can't be read.
    pub(crate) fn find(address: &Path, options: &OpenOptions) -> Result<Option<Self>, Error> {
        let Some((paths, warnings)) = search::find(address)? else { return Ok(None) };
        let fps = options.sequence_fps;
        if !(fps.is_finite() && fps > 0.0) {
            let cause = format!("{fps} files a second: give a number above 0");
            return Err(Error::address(address.display().to_string(), cause));
        }
        let recent = Recent { stills: Vec::new(), materials: obj::SharedMaterials::new(options, Files::OnDisk) };
        let mut sequence = Self { paths, fps, warnings, origin: DVec3::ZERO, recent: Mutex::new(recent) };
        // The others usually lack the same content as the first file.
        let first = sequence.still(0)?;
        sequence.origin = first.origin;
        let name = sequence.paths[0].display().to_string();
        sequence.warnings.extend(first.warnings.iter().map(|warning| format!("{name}: {warning}")));
        Ok(Some(sequence))
    }

    /// The files that it is read from, as far as they are known before posing.
    ///
    /// # Errors
    /// Where the first file can't be read.
    pub(crate) fn files(&self) -> Result<BTreeSet<PathBuf>, Error> {
        // Exporters give each file a library of its name.
        let libraries = self.paths.iter().map(|path| path.with_extension("mtl")).filter(|path| path.is_file());
        Ok(self.paths.iter().cloned().chain(libraries).chain(self.still(0)?.files.iter().cloned()).collect())
    }

    /// The index of the file that shows at `seconds`.
    fn index_at(&self, seconds: f64) -> usize {
        /// Tolerance in frames: a file shows this much early, so that k / fps is always frame k, despite rounding.
        const EARLY: f64 = 1e-6;
        // The cast keeps numbers in range and makes NaN 0.
        ((seconds * self.fps + EARLY).floor() as usize).min(self.paths.len() - 1)
    }

    fn still(&self, index: usize) -> Result<Arc<Still>, Error> {
        // A panic elsewhere can't leave the list half written.
        let mut recent = self.recent.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, still)) = recent.stills.iter().find(|(read, _)| *read == index) {
            return Ok(Arc::clone(still));
        }
        let still = Arc::new(read_still(&self.paths[index], &mut recent.materials)?);
        if recent.stills.len() == Recent::CAPACITY {
            recent.stills.remove(0);
        }
        recent.stills.push((index, Arc::clone(&still)));
        recent.materials.origin.get_or_insert(still.origin);
        Ok(still)
    }
}

impl Animated for Sequence {
    fn duration_seconds(&self) -> f64 {
        self.paths.len() as f64 / self.fps
    }

    /// Sets `frame` to the file of the moment `seconds`, clamped to the first and the last file.
    fn pose(&self, seconds: f64, frame: &mut Frame) -> Result<(), Error> {
        frame.copy_surfaces(&self.still(self.index_at(seconds))?.frame);
        Ok(())
    }

    fn origin(&self) -> [f64; 3] {
        self.origin.into()
    }

    fn warnings(&self) -> &[String] {
        &self.warnings
    }
}
