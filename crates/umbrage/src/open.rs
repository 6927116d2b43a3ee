use std::path::Path;

use umbrage_files::{Clip, OpenOptions};
use umbrage_gallery as gallery;
use umbrage_scene::{Error, Scene};

/// Opens a scene: a file's path, a sequence's pattern or folder, or `demo:NAME?triangles=N` for one of the
/// [gallery](gallery::DEMOS).
///
/// # Errors
/// Where the file can't be read, breaks its format or needs something unsupported, or there is no such demo.
pub fn open(address: impl AsRef<Path>) -> Result<Scene, Error> {
    open_with(address, &OpenOptions::default())
}

/// As [`open`], with options.
///
/// # Errors
/// As [`open`], and where `options` name a clip, a variant or an object that the file doesn't have, or want textures of the
/// gallery on demand: these are made in memory, of a few megabytes.
pub fn open_with(address: impl AsRef<Path>, options: &OpenOptions) -> Result<Scene, Error> {
    let address = address.as_ref();
    let text = address.to_string_lossy();
    let is_demo = text.starts_with(gallery::PREFIX);
    if is_demo && options.texture_memory.is_some() {
        let cause =
            "the built-in scenes make their few textures in memory; leave out --texture-memory, which is for files";
        return Err(Error::Address { address: text.into_owned(), cause: cause.to_owned() });
    }
    if let (true, Some(variant)) = (is_demo, &options.variant) {
        let cause = format!("there is no variant `{variant}`: only glTF files have any");
        return Err(Error::Address { address: text.into_owned(), cause });
    }
    let mut scene = if is_demo { gallery::open(&text)? } else { umbrage_files::open_with(address, options)? };
    if is_demo {
        scene.choose_ground(options.ground);
        let wrong = |cause| Error::Address { address: text.clone().into_owned(), cause };
        scene = scene.hiding(&options.hidden).map_err(wrong)?;
    }
    match &options.clip {
        // An animation without a name is number 0.
        Clip::Named(name) if scene.animations().is_empty() && (name != "0" || scene.duration_seconds() == 0.0) => {
            let cause = format!("there is no animation `{name}` to choose: it has none with a name or number");
            Err(Error::Address { address: text.into_owned(), cause })
        }
        _ => Ok(scene),
    }
}
