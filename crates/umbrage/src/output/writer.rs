use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::ops::Range;
use std::path::{Path, PathBuf};

use umbrage_rays::Choice;

use super::apng::ApngWriter;
use super::gif::{self, GifWriter};
use super::mp4::Mp4Writer;
use super::partial_file::{self, Look, PartialFile};
use super::png::{Coding, Rows};
use super::y4m::Y4mWriter;
use super::{
    BitDepth, Chroma, Compression, Error, FloatDepth, Format, FrameRate, JpegQuality, NumberedPath, eight_bits, exr,
    extensions, mp4, png,
};
use crate::{Background, Film, Image, Settings};

/// Destination of pictures.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Target {
    /// A file, or a numbered file for each frame, see [`NumberedPath`].
    Path(PathBuf),
    /// Standard output, for [`Format::Y4m`].
    Stdout,
}

/// Options of written pictures.
#[derive(Clone, Copy, Debug, Default)]
pub struct Options {
    /// Frames a second of animations and video.
    pub rate: FrameRate,
    /// Bits for each channel of a PNG or APNG.
    pub bit_depth: BitDepth,
    /// How hard a PNG or APNG is compressed.
    pub compression: Compression,
    /// Colours of an EXR.
    pub float_depth: FloatDepth,
    /// Quality of a JPEG.
    pub jpeg_quality: JpegQuality,
    /// Colours of raw video.
    pub chroma: Chroma,
}

/// A film's picture as files of a format hold it.
#[derive(Debug, Default)]
pub struct Picture {
    size: [u32; 2],
    has_alpha: bool,
    /// Of stills of whole numbers.
    rows: Vec<u8>,
    /// Of animations.
    image: Image,
    /// Of EXR files.
    film: Film,
}

/// The form of the pictures that a [`Writer`] writes.
#[derive(Clone, Copy, Debug)]
pub struct PictureForm {
    format: Format,
    depth: BitDepth,
}

impl PictureForm {
    /// The rows of a picture, if its form is opaque rows with eight bits a channel.
    pub(crate) fn rows<'a>(self, settings: &Settings, picture: &'a mut Picture) -> Option<&'a mut Vec<u8>> {
        let has_alpha = settings.background == Background::Transparent;
        let is_rows = self.format != Format::Exr && !self.format.is_animation();
        if has_alpha || !is_rows || self.depth != BitDepth::Eight {
            return None;
        }
        (picture.size, picture.has_alpha) = ([settings.width, settings.height], false);
        Some(&mut picture.rows)
    }

    /// Develops a film to a picture, in the memory of an earlier one. A format of linear colours (EXR) takes the film
    /// itself, and leaves the picture's earlier film in its place.
    pub fn develop(self, film: &mut Film, settings: &Settings, picture: &mut Picture) {
        picture.size = [film.width, film.height];
        picture.has_alpha = settings.background == Background::Transparent;
        if self.format == Format::Exr {
            std::mem::swap(&mut picture.film, film);
        } else if self.format.is_animation() {
            picture.image = film.develop(settings);
        } else if picture.has_alpha || self.depth == BitDepth::Sixteen {
            picture.rows = png::rows(&film.develop(settings), self.depth);
        } else {
            film.develop_rows(settings, &mut picture.rows);
        }
    }
}

/// Writes the frames of one render, in order. Its file is complete only after [`Writer::finish`]; files of numbered
/// frames are complete one by one.
pub struct Writer {
    kind: Kind,
    form: PictureForm,
    /// The file, or `-` for standard output, for errors.
    path: PathBuf,
}

enum Kind {
    Stills(Stills),
    /// The first is dropped first, since it holds the file open.
    Animation(Box<dyn Animation + Send>, Option<PartialFile>),
}

/// Where an animation is written to.
pub(super) type Sink = BufWriter<Box<dyn Write + Send>>;

/// All frames in one file.
pub(super) trait Animation {
    /// Writes the next frame.
    fn write(&mut self, image: &Image) -> io::Result<()>;

    /// Writes the end of the file, after the last frame.
    fn finish(self: Box<Self>) -> io::Result<()>;
}

impl Writer {
    /// Gets ready to write `frames`, each as large as `settings` say.
    ///
    /// # Errors
    /// Where the target can't be created, or doesn't suit the format or the number of frames.
    pub fn create(
        target: &Target,
        format: Format,
        frames: &Range<u32>,
        settings: &Settings,
        options: &Options,
    ) -> Result<Self, Error> {
        let Options { rate, bit_depth, compression, chroma, .. } = *options;
        let size = [settings.width, settings.height];
        let path = target.path();
        if *target == Target::Stdout && format != Format::Y4m {
            return Err(Error::unsuitable(path, "only y4m goes to standard output"));
        }
        if frames.is_empty() || settings.width == 0 || settings.height == 0 {
            return Err(Error::unsuitable(path, "there is nothing to write: no frame, or frames without pixels"));
        }
        let has_alpha = settings.background == Background::Transparent;
        if has_alpha && !format.has_alpha() {
            let others = extensions(Format::has_alpha);
            let cause = format!("{} files can't say what is transparent: write {others}", format.name());
            return Err(Error::unsuitable(path, cause));
        }
        if let Target::Path(path) = target {
            partial_file::sweep(path);
        }
        let kind = match format {
            Format::Png | Format::Jpeg | Format::WebP | Format::Exr => {
                Kind::Stills(Stills::new(path, format, frames, *options)?)
            }
            Format::Gif => {
                let size = gif::size(path, size, rate)?;
                Kind::animation(target, |sink| GifWriter::new(sink, size, rate))?
            }
            Format::Apng => {
                let count = frames.end - frames.start;
                let coding = Coding { depth: bit_depth, compression, has_alpha };
                Kind::animation(target, |sink| ApngWriter::new(sink, size, count, rate, coding))?
            }
            Format::Mp4 => {
                mp4::check_size(path, size)?;
                let partial = PartialFile::create(path)?;
                let animation = Mp4Writer::new(mp4::FFMPEG.as_ref(), partial.hidden_path(), path, size, rate)?;
                Kind::Animation(Box::new(animation), Some(partial))
            }
            Format::Y4m => Kind::animation(target, |sink| Y4mWriter::new(sink, size, rate, chroma))?,
        };
        let depth = if format == Format::Png { bit_depth } else { BitDepth::Eight };
        Ok(Self { kind, form: PictureForm { format, depth }, path: path.to_owned() })
    }

    /// The form of its pictures, which other threads can develop while it writes.
    #[must_use]
    pub fn form(&self) -> PictureForm {
        self.form
    }

    /// Writes frame `number`, whose picture was developed to [the writer's form](Self::form).
    ///
    /// # Errors
    /// Where the system refuses to write.
    pub fn write(&mut self, number: u32, picture: &Picture) -> Result<(), Error> {
        self.write_and_look(number, picture, &mut |_| Ok(()))
    }

    /// As [`Writer::write`], and calls `look` with the whole file of a single or numbered frame, before it takes its
    /// name. Not called for animations.
    ///
    /// # Errors
    /// As [`Writer::write`], and where `look` fails.
    pub fn write_and_look(
        &mut self,
        number: u32,
        picture: &Picture,
        look: &mut dyn FnMut(&File) -> io::Result<()>,
    ) -> Result<(), Error> {
        match &mut self.kind {
            Kind::Stills(stills) => stills.write(&self.path, number, picture, look),
            Kind::Animation(animation, _) => {
                animation.write(&picture.image).map_err(|source| Error::write(&self.path, source))
            }
        }
    }

    /// Completes an animation's file and gives it its name.
    ///
    /// # Errors
    /// Where the system refuses to write, or fewer frames were written than [`Writer::create`] was told.
    pub fn finish(self) -> Result<(), Error> {
        let Kind::Animation(animation, partial) = self.kind else { return Ok(()) };
        animation.finish().map_err(|source| Error::write(&self.path, source))?;
        partial.map_or(Ok(()), PartialFile::keep)
    }
}

impl Target {
    /// The file, or `-` for standard output.
    fn path(&self) -> &Path {
        match self {
            Self::Path(path) => path,
            Self::Stdout => Path::new("-"),
        }
    }
}

impl Kind {
    fn animation<A: Animation + Send + 'static>(
        target: &Target,
        start: impl FnOnce(Sink) -> io::Result<A>,
    ) -> Result<Self, Error> {
        let (sink, partial): (Box<dyn Write + Send>, _) = match target {
            Target::Path(path) => {
                let partial = PartialFile::create(path)?;
                (Box::new(partial.file()), Some(partial))
            }
            Target::Stdout => (Box::new(io::stdout()), None),
        };
        let animation = start(BufWriter::new(sink)).map_err(|source| Error::write(target.path(), source))?;
        Ok(Self::Animation(Box::new(animation), partial))
    }
}

/// One file for each frame.
struct Stills {
    /// `None` for a single frame.
    numbered: Option<NumberedPath>,
    format: Format,
    options: Options,
}

impl Stills {
    fn new(path: &Path, format: Format, frames: &Range<u32>, options: Options) -> Result<Self, Error> {
        let numbered = NumberedPath::parse(path)?;
        if numbered.is_none() && frames.len() > 1 {
            let stem = path.file_stem().unwrap_or_default().to_string_lossy();
            let cause = format!(
                "one name for {} frames; number them ({stem}_%04d.{}) or use an animation ({})",
                frames.len(),
                format.name(),
                extensions(Format::is_animation)
            );
            return Err(Error::unsuitable(path, cause));
        }
        // Found before the render rather than after it.
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        if !folder.is_dir() {
            return Err(Error::unsuitable(path, format!("there is no folder {}", folder.display())));
        }
        if path.is_dir() {
            return Err(Error::unsuitable(path, "is a folder; name a file in it"));
        }
        Ok(Self { numbered, format, options })
    }

    fn write(&self, path: &Path, number: u32, picture: &Picture, look: Look<'_>) -> Result<(), Error> {
        let Self { numbered, format, options } = self;
        let Options { rate, bit_depth, compression, float_depth, jpeg_quality, .. } = *options;
        let path = numbered.as_ref().map_or_else(|| path.to_owned(), |numbered| numbered.path(number));
        let &Picture { size, has_alpha, ref rows, ref film, .. } = picture;
        let rows = Rows { size, has_alpha, bytes: rows };
        match format {
            Format::Exr => exr::write(film, &path, float_depth, numbered.as_ref().map(|_| rate), look),
            Format::Jpeg => eight_bits::write_jpeg(&rows, &path, jpeg_quality, look),
            Format::WebP => eight_bits::write_webp(&rows, &path, look),
            _ => png::write(&rows, &path, bit_depth, compression, look),
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::{Vec3, Vec4};
    use umbrage_rays::Camera;

    use super::*;
    use crate::Renderer;

    fn settings() -> Settings {
        Settings { width: 4, height: 3, ..Settings::default() }
    }

    fn film() -> Film {
        Film {
            width: 4,
            height: 3,
            color: vec![Vec4::splat(0.5); 12],
            flat: Vec::new(),
            depth: vec![1.0; 12],
            normal: vec![Vec3::Z; 12],
            triangle: vec![0; 12],
            ..Film::default()
        }
    }

    fn picture(form: PictureForm) -> Picture {
        let mut picture = Picture::default();
        form.develop(&mut film(), &settings(), &mut picture);
        picture
    }

    fn create(path: &Path, format: Format, frames: Range<u32>) -> Result<Writer, Error> {
        let target = Target::Path(path.to_owned());
        Writer::create(&target, format, &frames, &settings(), &Options::default())
    }

    fn names(folder: &Path) -> Vec<String> {
        let entries = std::fs::read_dir(folder).unwrap();
        let mut names: Vec<String> = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    /// For each format that needs no other program, a writer of `frames` of which those of the numbers `written` are.
    fn writers(folder: &Path, frames: Range<u32>, written: Range<u32>) -> impl Iterator<Item = Writer> {
        Format::all().filter(|format| *format != Format::Mp4).map(move |format| {
            let name = if format.is_animation() { "out" } else { "out_%03d" };
            let path = folder.join(format!("{name}.{}", format.name()));
            let mut writer = create(&path, format, frames.clone()).unwrap();
            let picture = picture(writer.form());
            written.clone().for_each(|number| writer.write(number, &picture).unwrap());
            writer
        })
    }

    #[test]
    fn every_format_writes_every_frame() {
        let folder = tempfile::tempdir().unwrap();
        writers(folder.path(), 5..7, 5..7).for_each(|writer| writer.finish().unwrap());
        let stills = ["exr", "jpg", "png", "webp"].map(|name| [5, 6].map(|number| format!("out_00{number}.{name}")));
        let animations = ["out.apng", "out.gif", "out.y4m"].map(str::to_owned);
        let mut expected = [&animations[..], stills.as_flattened()].concat();
        expected.sort();
        assert_eq!(names(folder.path()), expected);
    }

    #[test]
    fn pictures_are_those_of_films_developed() {
        let folder = tempfile::tempdir().unwrap();
        let plain = Settings { width: 61, height: 43, first_hits: false, ..Settings::default() };
        let above_the_horizon = Camera::look_at(Vec3::new(0.0, 2.0, 9.0), Vec3::new(0.0, 3.0, 0.0), Vec3::Y, 0.8);
        let background = Background::Color(Vec3::new(0.2, 0.4, 0.6));
        let flat = Settings { background, camera: above_the_horizon.into(), ..plain.clone() };
        // With the last two, a film is developed.
        let clear = Settings { background: Background::Transparent, ..plain.clone() };
        let smooth = Settings { samples: 2, bounces: 2, ..plain.clone() };
        let mirrors = Settings { bounces: 2, ..plain.clone() };
        let (mut renderer, mut picture) = (Renderer::default(), Picture::default());
        for (name, settings, has_film) in [
            ("demo:hall", &plain, false),
            ("demo:marbles", &mirrors, false),
            ("demo:marbles", &flat, false),
            ("demo:glass", &clear, true),
            ("demo:glass", &smooth, true),
            ("demo:forest", &plain, false),
        ] {
            let scene = crate::open(name).unwrap();
            for format in [Format::Png, Format::Jpeg, Format::Gif] {
                let file = |name: &str| folder.path().join(format!("{name}.{}", format.name()));
                let target = Target::Path(file("a"));
                let Ok(mut writer) = Writer::create(&target, format, &(0..1), settings, &Options::default()) else {
                    assert!(*settings == clear);
                    continue;
                };
                let form = writer.form();
                renderer.render_picture(&scene, 0.3, settings, (form, &mut picture)).unwrap();
                let has_film = has_film || format == Format::Gif;
                assert_eq!(!renderer.film().color.is_empty(), has_film, "{name} as {format:?}");
                assert_eq!(renderer.stats().stages.iter().any(|stage| stage.name == "develop"), has_film);
                writer.write(0, &picture).unwrap();
                writer.finish().unwrap();
                let mut film = Renderer::default().render(&scene, 0.3, settings).unwrap().clone();
                let shows_background = film.flat.iter().any(|flat| flat.w > 0.5);
                assert_eq!(shows_background, *settings == flat, "{name}");
                let mut developed = Picture::default();
                form.develop(&mut film, settings, &mut developed);
                let mut writer = create_as(&file("b"), format, settings);
                writer.write(0, &developed).unwrap();
                writer.finish().unwrap();
                assert!(std::fs::read(file("a")).unwrap() == std::fs::read(file("b")).unwrap(), "{name} as {format:?}");
            }
        }
    }

    fn create_as(path: &Path, format: Format, settings: &Settings) -> Writer {
        Writer::create(&Target::Path(path.to_owned()), format, &(0..1), settings, &Options::default()).unwrap()
    }

    #[test]
    fn an_interrupted_render_keeps_its_whole_frames_only() {
        let folder = tempfile::tempdir().unwrap();
        writers(folder.path(), 0..3, 0..1).for_each(drop);
        assert_eq!(names(folder.path()), ["out_000.exr", "out_000.jpg", "out_000.png", "out_000.webp"]);
    }

    #[test]
    fn files_are_looked_at_before_they_have_their_name() {
        use std::io::{Read, Seek};

        let folder = tempfile::tempdir().unwrap();
        for format in [Format::Png, Format::Jpeg, Format::WebP, Format::Exr] {
            let path = folder.path().join(format!("%d.{}", format.name()));
            let mut writer = create(&path, format, 7..9).unwrap();
            let picture = picture(writer.form());
            let numbered = |number: u32| folder.path().join(format!("{number}.{}", format.name()));
            let mut seen = Vec::new();
            let mut look = |mut file: &File| {
                assert!(!numbered(7).exists());
                file.rewind()?;
                file.read_to_end(&mut seen).map(drop)
            };
            writer.write_and_look(7, &picture, &mut look).unwrap();
            assert_eq!(std::fs::read(numbered(7)).unwrap(), seen);
            let refused = writer.write_and_look(8, &picture, &mut |_| Err(io::Error::other("no")));
            assert!(refused.unwrap_err().to_string().contains("can't be written: no") && !numbered(8).exists());
        }
        assert_eq!(names(folder.path()), ["7.exr", "7.jpg", "7.png", "7.webp"]);
    }

    #[test]
    fn unsuitable_targets_are_refused_before_any_frame() {
        let folder = tempfile::tempdir().unwrap();
        let refused =
            |name: &str, format, frames| create(&folder.path().join(name), format, frames).err().unwrap().to_string();
        assert!(refused("a.png", Format::Png, 0..2).contains("a_%04d.png"));
        assert!(refused("a.gif", Format::Gif, 2..2).contains("nothing to write"));
        let transparent = Settings { background: Background::Transparent, ..settings() };
        let target = Target::Path(folder.path().join("a.gif"));
        let refusal = Writer::create(&target, Format::Gif, &(0..1), &transparent, &Options::default());
        assert!(refusal.err().unwrap().to_string().contains("write .png, .webp, .exr or .apng"));
        assert!(refused("none/a.png", Format::Png, 0..1).contains("there is no folder"));
        assert!(refused("", Format::Exr, 0..1).contains("is a folder"));
        let stdout = Writer::create(&Target::Stdout, Format::Png, &(0..1), &settings(), &Options::default());
        assert!(stdout.err().unwrap().to_string().contains("only y4m"));
        assert!(names(folder.path()).is_empty());
    }
}
