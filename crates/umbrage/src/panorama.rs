use std::fmt::Display;
use std::fs;
use std::io::{self, Cursor, Read};
use std::path::Path;

use exr::math::Vec2 as Size;
use exr::meta::MetaData;
use exr::prelude::{ReadChannels as _, ReadLayers as _};
use glam::{Vec2, Vec3};
use umbrage_files::image_file::{self, ImageFormat};

use crate::background::panorama_coords;

/// A latitude–longitude image of linear radiance, with its smaller copies.
#[derive(Clone, Debug, PartialEq)]
pub struct Panorama {
    levels: Vec<Level>,
}

#[derive(Clone, Debug, PartialEq)]
struct Level {
    width: usize,
    height: usize,
    texels: Vec<Vec3>,
}

impl Panorama {
    /// A panorama from rows of linear radiance, the zenith's first.
    ///
    /// # Errors
    /// Where the sides are zero or don't fit the number of texels, or one of these is NaN or infinite.
    pub fn new(width: usize, height: usize, texels: Vec<Vec3>) -> Result<Self, String> {
        if width == 0 || height == 0 || texels.len() != width * height {
            return Err(format!("{} texels are no image of {width}x{height}", texels.len()));
        }
        let mut broken = (0..texels.len()).filter(|&texel| !texels[texel].is_finite());
        if let Some(first) = broken.next() {
            let (column, row, others) = (first % width, first / width, broken.count());
            return Err(format!(
                "{} texels are NaN or infinite, the first in column {column} of row {row}",
                others + 1
            ));
        }
        let mut levels = vec![Level { width, height, texels }];
        while let Some(smaller) = levels.last().and_then(Level::halved) {
            levels.push(smaller);
        }
        Ok(Self { levels })
    }

    /// Reads an image file within `max_memory` bytes.
    pub(crate) fn open(path: &Path, max_memory: u64) -> Result<Self, String> {
        let bytes = read(path, max_memory).map_err(|error| error.to_string())?;
        let format = image_file::format(&bytes).ok_or("not a usable image: its format is none that is known")?;
        if format == ImageFormat::OpenExr {
            return Self::open_exr(&bytes, max_memory);
        }
        let image = image_file::decode(&bytes, format, max_memory, &mut |[width, height]| {
            let takes = of_texels(OF_TEXEL, width.into(), height.into());
            check(format_args!("an image of {width}x{height} texels"), takes, max_memory)
        })?;
        // Eight-bit images are sRGB-encoded, Radiance files are linear.
        let linear = |value: f32| if image.is_linear() { value } else { linear_from_srgb(value) };
        let texels = image.rgb().into_iter().map(|texel| Vec3::from_array(texel.map(linear))).collect();
        let [width, height] = image.size.map(|side| side as usize);
        Self::new(width, height, texels)
    }

    /// The first layer of an OpenEXR file that has colours, in its display window.
    fn open_exr(bytes: &[u8], max_memory: u64) -> Result<Self, String> {
        // Whole blocks of the image are decoded, which may be larger than its display window.
        let meta = MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(|error| error.to_string())?;
        for header in &meta.headers {
            for Size(width, height) in [header.layer_size, header.shared_attributes.display_window.size] {
                let of_texel = OF_TEXEL.max(header.channels.bytes_per_pixel as u64);
                let takes = of_texels(of_texel, width as u64, height as u64);
                check(format_args!("a layer of {width}x{height} texels"), takes, max_memory)?;
            }
        }
        let layer = exr::prelude::read()
            .no_deep_data()
            .largest_resolution_level()
            .rgb_channels(
                |size, _| (size.width(), vec![Vec3::ZERO; size.area()]),
                |(width, texels), at, (red, green, blue): (f32, f32, f32)| {
                    texels[at.y() * *width + at.x()] = Vec3::new(red, green, blue);
                },
            )
            .first_valid_layer()
            .all_attributes()
            .from_buffered(Cursor::new(bytes))
            .map_err(|error| format!("not a usable image: {error}"))?;
        let (stored_width, stored) = &layer.layer_data.channel_data.pixels;
        let shown = layer.attributes.display_window;
        let offset = layer.layer_data.attributes.layer_position - shown.position;
        let mut texels = vec![Vec3::ZERO; shown.size.area()];
        for (index, &texel) in stored.iter().enumerate() {
            let at = Size(index % stored_width, index / stored_width).to_i32() + offset;
            if (0..shown.size.width() as i32).contains(&at.x()) && (0..shown.size.height() as i32).contains(&at.y()) {
                texels[at.y() as usize * shown.size.width() + at.x() as usize] = texel;
            }
        }
        Self::new(shown.size.width(), shown.size.height(), texels)
    }

    /// Width and height of the full image, in texels.
    #[cfg(feature = "gpu")]
    pub(crate) fn size(&self) -> [usize; 2] {
        [self.levels[0].width, self.levels[0].height]
    }

    /// The texels of the image and of its smaller copies, each half as wide and high as the one before, rounded down but
    /// at least 1.
    #[cfg(feature = "gpu")]
    pub(crate) fn levels(&self) -> impl ExactSizeIterator<Item = &[Vec3]> {
        self.levels.iter().map(|level| level.texels.as_slice())
    }

    /// Mean radiance around a unit direction, over a patch of about `width` of the sphere's circumference.
    pub(crate) fn radiance(&self, direction: Vec3, width: f32) -> Vec3 {
        let last = self.levels.len() - 1;
        let lod = libm::log2f((width * self.levels[0].width as f32).max(1.0)).min(last as f32);
        let coords = panorama_coords(direction);
        let fine = self.levels[lod as usize].read(coords);
        let coarse = self.levels[(lod as usize + 1).min(last)].read(coords);
        fine.lerp(coarse, lod.fract())
    }
}

/// All bytes of a regular file.
fn read(path: &Path, max_memory: u64) -> io::Result<Vec<u8>> {
    // Checked before the file is opened, since opening a pipe would block.
    let there = fs::metadata(path)?;
    if !there.is_file() {
        return Err(io::Error::other("not a regular file"));
    }
    check("reading it", there.len(), max_memory).map_err(io::Error::other)?;
    let mut bytes = Vec::new();
    // The file may grow in the meantime.
    fs::File::open(path)?.take(there.len()).read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// Bytes of a texel: decoded, as four numbers, and in all levels.
const OF_TEXEL: u64 = 48;

/// Bytes of an image's texels; the largest number on overflow.
fn of_texels(of_texel: u64, width: u64, height: u64) -> u64 {
    of_texel.saturating_mul(width).saturating_mul(height)
}

fn check(what: impl Display, takes: u64, max_memory: u64) -> Result<(), String> {
    if takes <= max_memory {
        return Ok(());
    }
    Err(format!("{what} would take {takes} bytes, more than {max_memory}; allow more (--max-memory)"))
}

impl Level {
    fn halved(&self) -> Option<Self> {
        if self.width == 1 && self.height == 1 {
            return None;
        }
        let (width, height) = ((self.width / 2).max(1), (self.height / 2).max(1));
        let texel = |x: usize, y: usize| self.texels[y.min(self.height - 1) * self.width + x.min(self.width - 1)];
        let texels = (0..width * height)
            .map(|texel| (2 * (texel % width), 2 * (texel / width)))
            .map(|(x, y)| (texel(x, y) + texel(x + 1, y) + texel(x, y + 1) + texel(x + 1, y + 1)) * 0.25)
            .collect();
        Some(Self { width, height, texels })
    }

    fn read(&self, coords: Vec2) -> Vec3 {
        let texels = coords * Vec2::new(self.width as f32, self.height as f32) - 0.5;
        let corner = texels.floor();
        let part = texels - corner;
        let texel = |x: f32, y: f32| {
            let x = x.rem_euclid(self.width as f32) as usize % self.width;
            self.texels[(y.max(0.0) as usize).min(self.height - 1) * self.width + x]
        };
        let upper = texel(corner.x, corner.y).lerp(texel(corner.x + 1.0, corner.y), part.x);
        let lower = texel(corner.x, corner.y + 1.0).lerp(texel(corner.x + 1.0, corner.y + 1.0), part.x);
        upper.lerp(lower, part.y)
    }
}

/// The inverse of the sRGB transfer function (IEC 61966-2-1).
pub(crate) fn linear_from_srgb(encoded: f32) -> f32 {
    if encoded <= 0.04045 { encoded / 12.92 } else { libm::powf((encoded + 0.055) / 1.055, 2.4) }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ENOUGH: u64 = 1 << 20;

    /// Red above, green below, and a blue texel straight ahead.
    fn texels(width: usize, height: usize) -> Vec<Vec3> {
        let mut texels: Vec<Vec3> =
            (0..width * height).map(|index| if index < width * height / 2 { Vec3::X } else { Vec3::Y }).collect();
        texels[width * (height / 2) + width / 2] = Vec3::Z * 40.0;
        texels
    }

    fn check(panorama: &Panorama) {
        assert!(panorama.radiance(Vec3::Y, 0.0).distance(Vec3::X) < 1e-2);
        assert!(panorama.radiance(Vec3::NEG_Y, 0.0).distance(Vec3::Y) < 1e-2);
        assert!(panorama.radiance(Vec3::new(0.01, -0.01, -1.0).normalize(), 0.0).z > 10.0);
        assert!(panorama.radiance(Vec3::Z, 0.0).z < 1e-2);
        let even = panorama.radiance(Vec3::X, 1.0);
        assert!(even.x > 0.4 && even.y > 0.4 && even.z > 0.05, "the smallest copy is the mean: {even}");
    }

    #[test]
    fn directions_find_their_texels() {
        check(&Panorama::new(32, 16, texels(32, 16)).unwrap());
        assert!(Panorama::new(32, 16, texels(32, 15)).is_err());
        assert!(Panorama::new(0, 0, Vec::new()).is_err());
        for broken in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            let mut texels = texels(32, 16);
            (texels[3 * 32 + 7].y, texels[500].x) = (broken, broken);
            let cause = Panorama::new(32, 16, texels).unwrap_err();
            assert_eq!(cause, "2 texels are NaN or infinite, the first in column 7 of row 3");
        }
    }

    #[test]
    fn radiance_and_open_exr_files_are_read() {
        let folder = tempfile::tempdir().unwrap();
        let (hdr, exr) = (folder.path().join("sky.hdr"), folder.path().join("sky.exr"));
        // Mantissas for powers of 2⁶: 40 is 160/256 of it, and 1 is 4/256.
        let texel = |texel: &Vec3| {
            let [red, green, blue] = texel.to_array().map(|sample| (sample * 4.0) as u8);
            [red, green, blue, 128 + 6]
        };
        let rows = texels(32, 16).iter().flat_map(texel).collect::<Vec<_>>();
        fs::write(&hdr, [b"#?RADIANCE\n\n-Y 16 +X 32\n", rows.as_slice()].concat()).unwrap();
        exr::prelude::write_rgb_file(&exr, 32, 16, |x, y| texels(32, 16)[y * 32 + x].into()).unwrap();
        check(&Panorama::open(&hdr, ENOUGH).unwrap());
        check(&Panorama::open(&exr, ENOUGH).unwrap());
        let length = fs::metadata(&hdr).unwrap().len();
        for (max_memory, what) in
            [(length - 1, "reading it would take"), (length, "an image of 32x16 texels would take")]
        {
            let cause = Panorama::open(&hdr, max_memory).unwrap_err();
            assert!(cause.starts_with(what) && cause.ends_with("(--max-memory)"), "{cause}");
        }
        let most = u32::MAX.into();
        assert_eq!((of_texels(OF_TEXEL, 3, 2), of_texels(OF_TEXEL, most, most)), (288, u64::MAX));
        assert_eq!(Panorama::open(folder.path(), ENOUGH).unwrap_err(), "not a regular file");
    }

    #[test]
    fn broken_files_say_so() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["broken.hdr", "broken.exr", "broken.png"] {
            let path = folder.path().join(name);
            fs::write(&path, b"#?RADIANCE\nnot an image").unwrap();
            assert!(Panorama::open(&path, ENOUGH).is_err(), "{name}");
        }
        assert!(Panorama::open(&folder.path().join("missing.hdr"), ENOUGH).is_err());
    }
}
