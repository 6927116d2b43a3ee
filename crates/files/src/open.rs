//! Opening a scene by the reader of its format, and the options for it.

use std::mem;
use std::path::{Path, PathBuf};

use bytesize::ByteSize;
use umbrage_scene::{Animated, Error, GroundChoice, Scene, TilePool};

use crate::folder::Files;
use crate::formats::{self, Format};
use crate::gltf::{GltfScene, variants};
use crate::memory::{Budget, DEFAULT_BYTES, Limits};
use crate::obj::{self, SharedMaterials};
use crate::point_cache::PointCache;
use crate::sequence::Sequence;
use crate::smooth::{self, FlatTriangles};
use crate::still::Still;
use crate::{foreign, ply, stl};

/// How a scene is opened.
#[derive(Clone, Debug)]
pub struct OpenOptions {
    /// Which of a file's animations play.
    pub clip: Clip,
    /// Which of a file's variants has its materials shown, by name; `None` for the file's default ones.
    pub variant: Option<String>,
    /// Files a second of a numbered sequence, or frames a second of a PC2 point cache; 24 by default.
    pub sequence_fps: f64,
    /// Whether a file may name others outside of its own folder: for files that you trust.
    pub allow_outside: bool,
    /// Maximum memory for opening, in bytes: for all files that are read, and for the data made of them. Allocations that
    /// files ask for are compared with the remainder first. Temporary memory, as much again at worst, isn't counted. Each
    /// file of a sequence has this limit of its own.
    ///
    /// The default is half of the memory that the process may have, or 4 GiB where that isn't known.
    pub max_memory: u64,
    /// Maximum memory for texels at a time, in bytes, at least [`OpenOptions::MIN_TEXTURE_MEMORY`]; `None` for all
    /// texels.
    ///
    /// With a limit, texels are decoded one image at a time into a temporary file, and tiles of 32×32 are loaded when
    /// they are read; colours and masks are the same. The file is in the system's folder for temporary files (`TMPDIR`,
    /// else `/tmp` on Unix), which should be on a disk: some systems have it in memory. Four bytes a tile, a thousandth
    /// of all texels, stay in memory. Each file of a sequence has this limit of its own. A texture counts towards
    /// [`OpenOptions::max_memory`] only while it is made.
    pub texture_memory: Option<u64>,
    /// The names of objects that aren't shown ([`Scene::hiding`]).
    pub hidden: Vec<String>,
    /// Crease angle in degrees, 0 to 180: in files without normals (OBJ, PLY, STL), the surface between neighbouring
    /// triangles is smooth up to this angle; with 0, all triangles are flat. 60 by default.
    pub crease_degrees: f32,
    /// A floor under the scene.
    pub ground: GroundChoice,
}

impl Default for OpenOptions {
    fn default() -> Self {
        Self {
            clip: Clip::Auto,
            variant: None,
            sequence_fps: 24.0,
            allow_outside: false,
            max_memory: *DEFAULT_BYTES,
            texture_memory: None,
            hidden: Vec::new(),
            crease_degrees: smooth::DEFAULT_CREASE_DEGREES,
            ground: GroundChoice::None,
        }
    }
}

impl OpenOptions {
    /// Options for pictures: files that need a ground have one.
    #[must_use]
    pub fn for_pictures() -> Self {
        Self { ground: GroundChoice::Auto, ..Self::default() }
    }

    /// The fewest bytes of texels that may be in memory: fifteen tiles.
    pub const MIN_TEXTURE_MEMORY: u64 = TilePool::MIN_BYTES;

    /// # Errors
    /// Where an option is out of its range.
    fn check(&self, address: &Path) -> Result<(), Error> {
        if !(0.0..=180.0).contains(&self.crease_degrees) {
            let cause = format!("creases of {} degrees: give 0 to 180 (--crease)", self.crease_degrees);
            return Err(Error::address(address.display().to_string(), cause));
        }
        let Some(bytes) = self.texture_memory.filter(|&bytes| bytes < Self::MIN_TEXTURE_MEMORY) else { return Ok(()) };
        let [bytes, least] = [bytes, Self::MIN_TEXTURE_MEMORY].map(ByteSize::b);
        let cause = format!("textures in {bytes} of memory: give {least} or more (--texture-memory)");
        Err(Error::address(address.display().to_string(), cause))
    }

    pub(crate) fn limits(&self, files: Files) -> Limits {
        Limits { files, bytes: self.max_memory, texture_bytes: self.texture_memory }
    }
}

/// Which of a file's animations play.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Clip {
    /// All of them where no two move the same thing, else the first.
    #[default]
    Auto,
    /// All of them, the last one winning where two move the same thing.
    All,
    /// None: the file's rest pose.
    Rest,
    /// The one with this name, or else this number, counted from 0.
    Named(String),
}

/// Opens a scene: a file's path, or a sequence's pattern or folder.
///
/// # Errors
/// Where the file can't be read, breaks its format or needs something unsupported.
pub fn open(address: impl AsRef<Path>) -> Result<Scene, Error> {
    open_with(address, &OpenOptions::default())
}

/// Opens a scene with options.
///
/// # Errors
/// As [`open`], and where `options` name a clip that the file doesn't have or allow less memory than it takes, or
/// there is no room for textures on demand.
pub fn open_with(address: impl AsRef<Path>, options: &OpenOptions) -> Result<Scene, Error> {
    let address = address.as_ref();
    options.check(address)?;
    match Sequence::find(address, options)? {
        Some(sequence) => {
            let files = sequence.files()?;
            scene_of(address, Box::new(sequence), files, options)
        }
        None => open_file(address, Files::OnDisk, options),
    }
}

/// Opens a scene from a single file in memory. `name` stands for it in messages, and its extension gives the format.
/// [`open_files`] takes several files.
///
/// ```
/// let triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
/// let scene = umbrage_files::open_bytes("triangle.obj", triangle)?;
/// assert_eq!(scene.at(0.0)?.triangles().len(), 1);
/// # Ok::<(), umbrage_scene::Error>(())
/// ```
///
/// # Errors
/// As [`open`].
pub fn open_bytes(name: impl AsRef<Path>, bytes: impl Into<Vec<u8>>) -> Result<Scene, Error> {
    let name = name.as_ref();
    open_files(name, [(name, bytes)], &OpenOptions::default())
}

/// Opens the scene `name`, one of `files`, each a path and its content. A file that the scene names is looked up by
/// its path, or else by its file name where only one file has it. No other file is read.
///
/// # Errors
/// As [`open_with`].
pub fn open_files<P: Into<PathBuf>, B: Into<Vec<u8>>>(
    name: impl AsRef<Path>,
    files: impl IntoIterator<Item = (P, B)>,
    options: &OpenOptions,
) -> Result<Scene, Error> {
    options.check(name.as_ref())?;
    let files = Files::given(files.into_iter().map(|(path, bytes)| (path.into(), bytes.into())));
    open_file(name.as_ref(), files, options)
}

/// Opens a single file, not a sequence.
fn open_file(path: &Path, files: Files, options: &OpenOptions) -> Result<Scene, Error> {
    let format = Format::of(path);
    let mut shared = SharedMaterials::new(options, files);
    if let Some(Format::Gltf | Format::PointCache) = format {
        let limits = shared.limits.clone();
        let mut read = |budget: &Budget| -> Result<Box<dyn Animated>, Error> {
            Ok(match format {
                Some(Format::Gltf) => Box::new(GltfScene::open(path, options, budget)?),
                _ => Box::new(PointCache::read(path, options.sequence_fps, &mut shared, budget)?),
            })
        };
        let (scene, files) = within(path, limits, |budget| Ok((read(budget)?, budget.files())))?;
        return scene_of(path, scene, files, options);
    }
    let mut still = read_still(path, &mut shared)?;
    let files = mem::take(&mut still.files);
    scene_of(path, Box::new(still), files, options)
}

/// Makes a scene of an opened source, with the ground and the hidden objects of `options`.
fn scene_of(
    address: &Path,
    source: Box<dyn Animated>,
    files: impl IntoIterator<Item = PathBuf>,
    options: &OpenOptions,
) -> Result<Scene, Error> {
    if let Some(variant) = options.variant.as_deref().filter(|_| source.variants().is_empty()) {
        return Err(variants::unknown(address, variant, &[]));
    }
    let mut scene = Scene::new(source)?.with_files(files);
    scene.choose_ground(options.ground);
    scene.hiding(&options.hidden).map_err(|cause| Error::address(address.to_string_lossy(), cause))
}

/// The error for a name that a file doesn't have, with those that it has.
pub(crate) fn unknown_name(path: &Path, kind: &str, wanted: &str, names: &[String]) -> Error {
    let cause = if names.is_empty() {
        format!("there is no {kind} `{wanted}`, as the file has none")
    } else {
        format!("there is no {kind} `{wanted}`; the file has {}", names.join(", "))
    };
    Error::address(path.to_string_lossy(), cause)
}

/// Reads a file whose triangles don't move; its materials may be shared with the last one's.
pub(crate) fn read_still(path: &Path, shared: &mut SharedMaterials) -> Result<Still, Error> {
    let (limits, crease_degrees) = (shared.limits.clone(), shared.crease_degrees);
    let mut read = |budget: &Budget| match Format::of(path) {
        Some(Format::Obj) => obj::read(path, shared, budget),
        Some(Format::Ply) => ply::read(path, shared.origin, budget),
        Some(Format::Stl) => stl::read(path, shared.origin, budget),
        Some(Format::Gltf | Format::PointCache) | None => Err(formats::unread(path)),
    };
    within(path, limits, |budget| {
        let mut still = read(budget)?;
        smooth::smooth(&mut still.frame, crease_degrees, FlatTriangles::Shared, budget)
            .map_err(|cause| Error::malformed(path, "the normals", cause))?;
        Ok(Still { files: budget.files(), ..still })
    })
}

/// Reads a file within limits. An exceeded limit is the error, in place of the result of `read`.
fn within<T>(path: &Path, limits: Limits, read: impl FnOnce(&Budget) -> Result<T, Error>) -> Result<T, Error> {
    let budget = Budget::new(limits);
    let result = read(&budget);
    if let Some(cause) = budget.refusal() {
        return Err(Error::Memory { path: path.to_owned(), cause: cause.to_owned() });
    }
    match budget.texture_failure() {
        Some(cause) => Err(Error::TextureFile(cause.to_owned())),
        None => result.map_err(|error| foreign::or_what_it_is(error, path, &budget)),
    }
}
