//! Tries mutants, one after the other, and records the current one.

use std::collections::HashSet;
use std::fs::{self, File};
use std::io::{Seek as _, Write as _};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};

use anyhow::{Context as _, Result};
use umbrage_verify::Random;

use crate::targets::{self, Answer};

/// Limit on the process's memory in bytes.
const MOST_BYTES: usize = 3 << 29;

/// Progress of a worker.
#[derive(Debug, Default)]
pub(crate) struct Progress {
    /// Number of the current or next mutant.
    pub(crate) next: u64,
    /// Numbers of accepted mutants, refused mutants, and findings.
    pub(crate) answers: [u64; 3],
    /// Name of the mutant's file, if it is a file.
    pub(crate) file: String,
}

impl Progress {
    /// Reads the last record of the worker in a folder.
    pub(crate) fn read(folder: &Path) -> Self {
        let text = fs::read_to_string(folder.join("progress")).unwrap_or_default();
        let mut words = text.split_whitespace();
        let mut number = || words.next().and_then(|word| word.parse().ok()).unwrap_or_default();
        let (next, answers) = (number(), [(); 3].map(|()| number()));
        Self { next, answers, file: words.next().unwrap_or_default().to_owned() }
    }

    fn write(&self, file: &mut File) -> Result<()> {
        let Self { next, answers: [accepted, refused, findings], file: name } = self;
        file.rewind()?;
        // Padded, so that it covers the last record.
        Ok(file.write_all(format!("{next} {accepted} {refused} {findings} {name:80}\n").as_bytes())?)
    }

    /// Prints the fault of the current mutant of the worker in a folder, and keeps its file.
    pub(crate) fn tell(&self, target: &str, why: &str, folder: &Path, keep: &Path) -> Result<()> {
        let Self { next, file, .. } = self;
        println!("--target {target} --seed {next}: {file} {why}");
        if !file.is_empty() {
            fs::create_dir_all(keep)?;
            fs::copy(folder.join(file), keep.join(format!("{target}-{next}-{file}")))?;
        }
        Ok(())
    }
}

/// A worker's folder and progress.
pub(crate) struct Workplace<'a> {
    pub(crate) folder: &'a Path,
    progress: Progress,
    progress_file: File,
}

impl Workplace<'_> {
    /// Writes the mutant's file.
    pub(crate) fn write_mutant(&mut self, name: &str, bytes: &[u8]) -> Result<()> {
        name.clone_into(&mut self.progress.file);
        self.progress.write(&mut self.progress_file)?;
        self.write(name, bytes)
    }

    pub(crate) fn write(&self, name: &str, bytes: &[u8]) -> Result<()> {
        let path = self.folder.join(name);
        // Some file systems wait for the disk when a file is overwritten, but not when it is new.
        fs::remove_file(&path).ok();
        fs::write(&path, bytes).with_context(|| path.display().to_string())
    }
}

/// Tries `mutants` mutants of a target, beginning with `first`, in a folder.
pub(crate) fn run(target: &str, first: u64, mutants: u64, folder: &Path, keep: &Path) -> Result<()> {
    let progress = Progress { next: first, ..Progress::default() };
    let mut place = Workplace { folder, progress, progress_file: File::create(folder.join("progress"))? };
    let mut tried = targets::open(target, &place)?;
    let panic = record_panics();
    allocations::refuse_beyond(MOST_BYTES);
    let mut told = HashSet::new();
    while place.progress.next < first.saturating_add(mutants) {
        place.progress.file.clear();
        place.progress.write(&mut place.progress_file)?;
        let mut random = Random::new(place.progress.next.wrapping_mul(0x9E37_79B9_7F4A_7C15));
        let judged = catch_unwind(AssertUnwindSafe(|| tried.run(&mut random, &mut place)));
        let wrong = match judged {
            Ok(Ok(answer)) => {
                place.progress.answers[usize::from(answer == Answer::Refused)] += 1;
                None
            }
            Ok(Err(wrong)) => Some(format!("{wrong:#}")),
            Err(_) => Some(std::mem::take(&mut *panic.lock().unwrap_or_else(PoisonError::into_inner))),
        };
        if let Some(wrong) = wrong {
            place.progress.answers[2] += 1;
            // Digits differ between mutants with the same fault.
            if told.insert(wrong.replace(|c: char| c.is_ascii_digit(), "")) {
                place.progress.tell(target, &wrong, folder, keep)?;
            }
        }
        place.progress.next += 1;
    }
    place.progress.write(&mut place.progress_file)
}

/// Keeps the last panic's message instead of printing it.
fn record_panics() -> Arc<Mutex<String>> {
    let last = Arc::new(Mutex::new(String::new()));
    let record = Arc::clone(&last);
    std::panic::set_hook(Box::new(move |panic| {
        *record.lock().unwrap_or_else(PoisonError::into_inner) = panic.to_string();
    }));
    last
}
