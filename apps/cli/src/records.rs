//! Records of finished frames, so that the same command resumes where it ended.

use std::fs::{self, File};
use std::io::{self, Read, Seek};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::time::UNIX_EPOCH;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use umbrage::output::{self, NumberedPath};
use umbrage::{Background, Scene, Settings, Structure};

use crate::failure::Failure;
use crate::job::{Job, Schedule};

/// The folder of the records, beside the pictures.
const FOLDER: &str = ".umbrage";

/// Maximum total bytes of a scene's files to be compared by content. Larger ones take long to open already, and are compared
/// by size and time of modification.
const MOST_BYTES: u64 = 256 << 20;

/// Maximum bytes of a record.
const MOST_BYTES_OF_RECORD: u64 = 4096;

/// The records of numbered frames: one file per frame, so that several processes can write to one folder.
pub(crate) struct Records<'a> {
    pictures: NumberedPath,
    records: NumberedPath,
    /// The path of the records, with the frame's number in its pattern.
    pattern: PathBuf,
    schedule: &'a Schedule,
    scene: String,
    /// The settings that affect the pictures of all frames.
    settings: String,
    has_orbit: bool,
}

/// The sources of a picture and the hash of its file. Hashes are SHA-256 in hexadecimal digits.
#[derive(Debug, Deserialize, PartialEq, Serialize)]
struct Record {
    /// The version of the program.
    umbrage: String,
    frame: u32,
    /// Hash of the scene's address and its files.
    scene: String,
    /// Hash of all settings that affect the picture, and its time.
    settings: String,
    bytes: u64,
    /// Hash of the picture's file.
    picture: String,
}

impl<'a> Records<'a> {
    /// The records beside the pictures `target`; `None` where that isn't numbered.
    ///
    /// # Errors
    /// Where the scene's files can no longer be read.
    pub(crate) fn new(
        job: &Job,
        target: &Path,
        scene: &Scene,
        schedule: &'a Schedule,
    ) -> Result<Option<Self>, Failure> {
        let name = target.file_name().unwrap_or_default().to_string_lossy();
        let pattern = target.with_file_name(FOLDER).join(format!("{name}.json"));
        let (Some(pictures), Some(records)) = (NumberedPath::parse(target)?, NumberedPath::parse(&pattern)?) else {
            return Ok(None);
        };
        let (scene, settings) = (of_scene(job, scene)?, settings(job));
        let has_orbit = job.flags.orbit_light.is_some();
        Ok(Some(Self { pictures, records, pattern, schedule, scene, settings, has_orbit }))
    }

    /// The frames whose picture is missing, incomplete or outdated.
    pub(crate) fn missing(&self, frames: Range<u32>) -> Vec<u32> {
        frames.into_par_iter().filter(|&frame| !self.is_there(frame)).collect()
    }

    fn is_there(&self, frame: u32) -> bool {
        let Some(record) = read(&self.records.path(frame)) else { return false };
        let path = self.pictures.path(frame);
        let has_length = || fs::metadata(&path).is_ok_and(|picture| picture.len() == record.bytes);
        let is_same = || File::open(&path).and_then(hash).is_ok_and(|(_, picture)| picture == record.picture);
        record == self.record(frame, record.bytes, record.picture.clone()) && has_length() && is_same()
    }

    /// Prepares to [`write`](Self::write).
    ///
    /// # Errors
    /// Where the folder can't be made.
    pub(crate) fn prepare(&self) -> Result<(), Failure> {
        let folder = self.pattern.parent().unwrap_or(Path::new(FOLDER));
        match fs::create_dir(folder) {
            Err(error) if error.kind() != io::ErrorKind::AlreadyExists => {
                return Err(Failure::Work(format!("{}: can't be made: {error}", folder.display())));
            }
            _ => {}
        }
        output::sweep(&self.pattern);
        Ok(())
    }

    /// Records a frame's picture with its number of bytes and its hash.
    ///
    /// # Errors
    /// Where the record can't be written.
    pub(crate) fn write(&self, frame: u32, (bytes, picture): (u64, String)) -> Result<(), Failure> {
        let json = serde_json::to_string(&self.record(frame, bytes, picture));
        let json = json.map_err(|error| Failure::Work(error.to_string()))?;
        Ok(output::write_whole(&self.records.path(frame), format!("{json}\n").as_bytes())?)
    }

    fn record(&self, frame: u32, bytes: u64, picture: String) -> Record {
        let (seconds, turn) = (self.schedule.seconds(frame), self.schedule.turn(frame));
        // The positions of orbiting lights depend on the number of frames; nothing else does.
        let turn = self.has_orbit.then_some(turn);
        let settings = digest(format!("{} second {seconds:?} turn {turn:?}", self.settings).as_bytes());
        let umbrage = env!("CARGO_PKG_VERSION").to_owned();
        Record { umbrage, frame, scene: self.scene.clone(), settings, bytes, picture }
    }
}

/// Reads a frame's record; `None` if it is missing or unreadable.
fn read(path: &Path) -> Option<Record> {
    let mut json = String::new();
    File::open(path).ok()?.take(MOST_BYTES_OF_RECORD).read_to_string(&mut json).ok()?;
    serde_json::from_str(&json).ok()
}

/// All settings that affect pictures, as text, without the time.
fn settings(job: &Job) -> String {
    let Job { flags, settings, format, output_options, .. } = job;
    // Every structure gives the same picture. A background image is among the scene's files.
    let background = match settings.background {
        Background::Image(_) => Background::default(),
        ref other => other.clone(),
    };
    let settings = Settings { structure: Structure::default(), background, ..settings.clone() };
    format!("{settings:?} {format:?} {output_options:?} {}", flags.beside_settings())
}

/// The hash of the scene's address and its files, including the background's.
fn of_scene(job: &Job, scene: &Scene) -> Result<String, Failure> {
    let files: Vec<&Path> = scene.files().iter().map(PathBuf::as_path).chain(job.background_file()).collect();
    let named = |path: &Path, error: io::Error| Failure::Work(format!("{}: can't be read: {error}", path.display()));
    let bytes: Result<u64, Failure> =
        files.iter().map(|path| Ok(fs::metadata(path).map_err(|error| named(path, error))?.len())).sum();
    let by_bytes = bytes? <= MOST_BYTES;
    let of_files: Result<Vec<String>, Failure> = files
        .par_iter()
        .map(|path| {
            let told = if by_bytes { File::open(path).and_then(hash) } else { size_and_time(path) };
            let (length, told) = told.map_err(|error| named(path, error))?;
            Ok(format!("{} {length} {told}", path.display()))
        })
        .collect();
    Ok(digest(format!("{}\n{}", job.scene.display(), of_files?.join("\n")).as_bytes()))
}

fn size_and_time(path: &Path) -> io::Result<(u64, String)> {
    let about = fs::metadata(path)?;
    let since = about.modified()?.duration_since(UNIX_EPOCH).unwrap_or_default();
    Ok((about.len(), format!("at {since:?}")))
}

/// Length of a file in bytes, and its hash.
pub(crate) fn hash(mut file: impl Read + Seek) -> io::Result<(u64, String)> {
    file.rewind()?;
    let mut hasher = Sha256::new();
    let (mut length, mut piece) = (0, vec![0; 1 << 16]);
    loop {
        match file.read(&mut piece) {
            Ok(0) => return Ok((length, hexadecimal(&hasher.finalize()))),
            Ok(bytes) => {
                hasher.update(&piece[..bytes]);
                length += bytes as u64;
            }
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Err(error) => return Err(error),
        }
    }
}

fn digest(bytes: &[u8]) -> String {
    hexadecimal(&Sha256::digest(bytes))
}

fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use super::*;

    #[test]
    fn hashes_are_those_of_other_programs() {
        let (length, hash) = hash(Cursor::new(b"abc")).unwrap();
        let known = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
        assert_eq!((length, hash.as_str(), digest(b"abc").as_str()), (3, known, known));
    }
}
