use std::path::{Path, PathBuf};

use super::Error;

/// A path whose file name holds a frame's number: `out_%04d.png`, `%d.exr`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NumberedPath {
    folder: PathBuf,
    before: String,
    digits: usize,
    after: String,
}

impl NumberedPath {
    /// The pattern in `path`'s file name; `None` where it has no `%d` or `%0Nd`.
    ///
    /// # Errors
    /// Where it holds several numbers, or one is wider than nine digits.
    pub fn parse(path: &Path) -> Result<Option<Self>, Error> {
        let Some(name) = path.file_name().and_then(|name| name.to_str()) else { return Ok(None) };
        let mut numbers = name.match_indices('%').filter_map(|(percent, _)| {
            let behind = &name[percent + 1..];
            let width = behind.bytes().take_while(u8::is_ascii_digit).count();
            Some((&name[..percent], &behind[..width], behind[width..].strip_prefix('d')?))
        });
        let Some((before, digits, after)) = numbers.next() else { return Ok(None) };
        // `%4d` would pad with blanks, a bad choice in a file's name.
        if !(digits.is_empty() || digits.len() == 2 && digits.starts_with('0') && digits != "00") {
            return Err(Error::unsuitable(path, "a frame's number is written %d or %01d to %09d"));
        }
        if numbers.next().is_some() {
            return Err(Error::unsuitable(path, "a file name has a place for only one number"));
        }
        let folder = path.parent().unwrap_or(Path::new("")).to_owned();
        let digits = digits.parse().unwrap_or(1);
        Ok(Some(Self { folder, before: before.to_owned(), digits, after: after.to_owned() }))
    }

    /// The path of frame `number`.
    #[must_use]
    pub fn path(&self, number: u32) -> PathBuf {
        self.folder.join(self.name(number))
    }

    fn name(&self, number: u32) -> String {
        format!("{}{number:0digits$}{}", self.before, self.after, digits = self.digits)
    }

    /// The file name of the frame whose number is in `name`, after the same prefix; of frame 0 where there is none.
    pub(super) fn alike(&self, name: &str) -> String {
        let behind = name.strip_prefix(&self.before).unwrap_or_default();
        let digits = behind.bytes().take_while(u8::is_ascii_digit).count();
        self.name(behind[..digits].parse().unwrap_or(0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn patterns_number_files() {
        let path = |pattern: &str, number| NumberedPath::parse(Path::new(pattern)).unwrap().unwrap().path(number);
        assert_eq!(path("a/out_%04d.png", 7), Path::new("a/out_0007.png"));
        assert_eq!(path("out_%04d.png", 123_456), Path::new("out_123456.png"));
        assert_eq!(path("%d.exr", 12), Path::new("12.exr"));
        assert_eq!(path("100%_%02d.png", 3), Path::new("100%_03.png"));
        assert_eq!(path("a%04d/b%02d.png", 3), Path::new("a%04d/b03.png"));
    }

    #[test]
    fn other_names_are_plain_or_wrong() {
        for plain in ["out.png", "50%.png", "%x.png", "%04d/out.png", "", ".."] {
            assert_eq!(NumberedPath::parse(Path::new(plain)).unwrap(), None, "{plain}");
        }
        for wrong in ["%d_%d.png", "%099d.png", "%4d.png", "%00d.png"] {
            assert!(NumberedPath::parse(Path::new(wrong)).is_err(), "{wrong}");
        }
    }
}
