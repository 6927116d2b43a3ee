use std::ffi::{OsStr, OsString};
use std::fs::File;
use std::io::{self, BufWriter, Read, Seek};
use std::mem;
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::sleep;
use std::time::Duration;

use super::writer::Animation;
use super::y4m::Y4mWriter;
use super::{Chroma, Error, FrameRate};
use crate::Image;

/// The program that makes MP4 files.
pub(super) const FFMPEG: &str = "ffmpeg";

/// The encoders of this process that run.
static RUNNING: Mutex<Vec<Arc<Mutex<Child>>>> = Mutex::new(Vec::new());

fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    // A panic elsewhere leaves children and their list whole.
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Ends the encoders of this process, so that none of them makes its file again. Later, starting or dropping one waits
/// for ever.
pub(super) fn end_encoders() {
    let running = locked(&RUNNING);
    for child in &*running {
        end(child);
    }
    mem::forget(running);
}

fn end(child: &Mutex<Child>) {
    let mut child = locked(child);
    // One that has ended needs neither.
    let _ = child.kill();
    let _ = child.wait();
}

/// Writes video through ffmpeg, which gets raw video, chooses the codec and writes the file itself: it seeks to the file's
/// start in the end.
pub(super) struct Mp4Writer {
    /// Dropped first, so that the video isn't flushed to an encoder that nobody waits for.
    encoder: Encoder,
    /// `None` once the video has ended.
    video: Option<Box<Y4mWriter>>,
}

struct Encoder {
    child: Arc<Mutex<Child>>,
    said: File,
}

impl Mp4Writer {
    /// Starts a video of frames `size` pixels wide and high in the file `to`, by a program that takes the arguments of
    /// ffmpeg. Errors name `path`.
    pub(super) fn new(program: &OsStr, to: &Path, path: &Path, size: [u32; 2], rate: FrameRate) -> Result<Self, Error> {
        let refused = |source| Error::write(path, source);
        let said = tempfile::tempfile().map_err(refused)?;
        let mut command = Command::new(program);
        command.args(arguments(to)).stdin(Stdio::piped()).stdout(Stdio::null());
        command.stderr(said.try_clone().map_err(refused)?);
        // Ctrl-C is for this process, which ends its encoders.
        #[cfg(unix)]
        std::os::unix::process::CommandExt::process_group(&mut command, 0);
        let mut running = locked(&RUNNING);
        let mut child = command.spawn().map_err(|source| match source.kind() {
            io::ErrorKind::NotFound => Error::unsuitable(path, NO_FFMPEG),
            _ => refused(io::Error::other(format!("{FFMPEG} can't be run: {source}"))),
        })?;
        let input = child.stdin.take();
        let child = Arc::new(Mutex::new(child));
        running.push(Arc::clone(&child));
        drop(running);
        let mut encoder = Encoder { child, said };
        let input = input.ok_or_else(|| refused(io::ErrorKind::BrokenPipe.into()))?;
        match Y4mWriter::new(BufWriter::new(Box::new(input)), size, rate, Chroma::Quarter) {
            Ok(video) => Ok(Self { encoder, video: Some(Box::new(video)) }),
            Err(source) => Err(refused(encoder.failure(&source))),
        }
    }
}

/// The error without ffmpeg.
const NO_FFMPEG: &str = "MP4 files are made by the program ffmpeg, which isn't found: install it (the package `ffmpeg` of apt, \
                         dnf, brew or winget), or write .y4m or .gif";

/// The arguments of ffmpeg: raw video comes on standard input, and its colours are those of BT.709.
fn arguments(to: &Path) -> Vec<OsString> {
    const BEFORE: &str = "-v error -y -f yuv4mpegpipe -i - \
                          -vf setparams=color_primaries=bt709:color_trc=bt709:colorspace=bt709 \
                          -color_primaries bt709 -color_trc bt709 -colorspace bt709 \
                          -pix_fmt yuv420p -crf 18 -movflags +faststart -f mp4";
    // Without `file:`, a colon in a folder's name would end the name of a protocol.
    let mut file = OsString::from("file:");
    file.push(to);
    BEFORE.split(' ').map(OsString::from).chain([file]).collect()
}

/// Checks that a video can have frames of this size.
///
/// # Errors
/// Where a side is odd, since a colour is that of two by two pixels.
pub(super) fn check_size(path: &Path, [width, height]: [u32; 2]) -> Result<(), Error> {
    if width % 2 == 0 && height % 2 == 0 {
        return Ok(());
    }
    let [wide, high] = [width, height].map(|side| side.next_multiple_of(2));
    Err(Error::unsuitable(path, format!("an MP4's sides are even: {wide}x{high} in place of {width}x{height}")))
}

impl Animation for Mp4Writer {
    fn write(&mut self, image: &Image) -> io::Result<()> {
        let Some(video) = &mut self.video else { return Err(io::ErrorKind::BrokenPipe.into()) };
        video.write(image).map_err(|source| self.encoder.failure(&source))
    }

    fn finish(mut self: Box<Self>) -> io::Result<()> {
        let flushed = self.video.take().map_or(Ok(()), Animation::finish);
        flushed.map_err(|source| self.encoder.failure(&source))?;
        let status = self.encoder.wait()?;
        if status.success() { Ok(()) } else { Err(self.encoder.failure(&io::Error::other(status.to_string()))) }
    }
}

impl Encoder {
    /// Waits until it has ended. In between, [`end_encoders`] may end it.
    fn wait(&self) -> io::Result<ExitStatus> {
        loop {
            if let Some(status) = locked(&self.child).try_wait()? {
                return Ok(status);
            }
            sleep(Duration::from_millis(5));
        }
    }

    /// The encoder's last line of standard error, or else `source`; never a broken pipe, which means that a reader has gone.
    fn failure(&mut self, source: &io::Error) -> io::Error {
        end(&self.child);
        let mut said = Vec::new();
        let read = self.said.rewind().and_then(|()| self.said.read_to_end(&mut said));
        let said = String::from_utf8_lossy(&said);
        let last = said.lines().rfind(|line| !line.trim().is_empty()).filter(|_| read.is_ok());
        io::Error::other(format!("{FFMPEG} failed: {}", last.unwrap_or(&source.to_string())))
    }
}

impl Drop for Encoder {
    fn drop(&mut self) {
        end(&self.child);
        locked(&RUNNING).retain(|child| !Arc::ptr_eq(child, &self.child));
    }
}

#[cfg(test)]
#[cfg(unix)]
mod tests {
    use std::fs;
    use std::os::unix::fs::PermissionsExt;

    use super::*;

    /// Held while a script is written and run: a process that starts in between would have the script open for writing.
    static ONE_AT_A_TIME: Mutex<()> = Mutex::new(());

    /// A video of two frames of 4 by 2 pixels, made by a script that stands in for ffmpeg and knows the file as `$to`.
    fn made_by(script: &str) -> (Result<(), String>, Option<Vec<u8>>) {
        let _alone = locked(&ONE_AT_A_TIME);
        let folder = tempfile::tempdir().unwrap();
        let (program, to) = (folder.path().join("stand-in"), folder.path().join("a:b.mp4"));
        fs::write(&program, format!("#!/bin/sh\nfor to; do :; done\nto=${{to#file:}}\n{script}\n")).unwrap();
        fs::set_permissions(&program, fs::Permissions::from_mode(0o755)).unwrap();
        let image = Image { width: 4, height: 2, pixels: vec![[0; 3]; 8], ..Image::default() };
        let make = || -> Result<(), String> {
            let rate = FrameRate::default();
            let mut writer = Mp4Writer::new(program.as_os_str(), &to, Path::new("b.mp4"), [4, 2], rate)
                .map_err(|error| error.to_string())?;
            writer.write(&image).and_then(|()| writer.write(&image)).map_err(|error| error.to_string())?;
            Box::new(writer).finish().map_err(|error| error.to_string())
        };
        (make(), fs::read(&to).ok())
    }

    #[test]
    fn the_encoder_gets_raw_video_and_writes_the_file() {
        let (made, file) = made_by("cat > $to");
        assert_eq!(made, Ok(()));
        let file = file.unwrap();
        assert!(file.starts_with(b"YUV4MPEG2 W4 H2 F24:1 "));
        let frames = file
            .windows(6)
            .filter(|bytes| {
                bytes
                    == b"FRAME
"
            })
            .count();
        assert_eq!(frames, 2);
    }

    #[test]
    fn an_encoder_that_fails_is_quoted_and_no_broken_pipe() {
        for script in
            ["echo first >&2; echo 'no such codec' >&2; exit 1", "cat > /dev/null; echo 'no such codec' >&2; exit 3"]
        {
            assert_eq!(made_by(script).0.unwrap_err(), "ffmpeg failed: no such codec");
        }
        assert_eq!(made_by("cat > /dev/null; exit 3").0.unwrap_err(), "ffmpeg failed: exit status: 3");
    }

    #[test]
    fn a_missing_encoder_is_named_with_what_to_do() {
        let _alone = locked(&ONE_AT_A_TIME);
        let missing = Mp4Writer::new(
            OsStr::new("./no-such-program"),
            Path::new("x"),
            Path::new("b.mp4"),
            [4, 2],
            FrameRate::default(),
        );
        let said = missing.err().unwrap().to_string();
        assert!(said.starts_with("b.mp4: MP4 files") && said.contains("install it") && said.contains(".y4m"), "{said}");
    }

    #[test]
    fn sides_are_even() {
        let refused = |size| check_size(Path::new("a.mp4"), size).err().map(|error| error.to_string());
        assert_eq!(refused([640, 360]), None);
        assert_eq!(refused([641, 359]).unwrap(), "a.mp4: an MP4's sides are even: 642x360 in place of 641x359");
    }
}
