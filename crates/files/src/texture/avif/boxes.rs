//! A reader of boxes (ISO/IEC 14496-12): length, name of four letters, content.

/// The unread bytes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bytes<'a>(pub(super) &'a [u8]);

impl<'a> Bytes<'a> {
    /// The next `count` bytes.
    ///
    /// # Errors
    /// Where there are fewer.
    pub(super) fn take(&mut self, count: usize) -> Result<&'a [u8], String> {
        let (taken, rest) = self.0.split_at_checked(count).ok_or("it is cut off")?;
        self.0 = rest;
        Ok(taken)
    }

    /// Reads a big-endian number of at most eight bytes; 0 for none.
    pub(super) fn number(&mut self, bytes: usize) -> Result<u64, String> {
        Ok(self.take(bytes)?.iter().fold(0, |number, &byte| number << 8 | u64::from(byte)))
    }

    pub(super) fn u8(&mut self) -> Result<u8, String> {
        Ok(self.number(1)? as u8)
    }

    pub(super) fn u16(&mut self) -> Result<u16, String> {
        Ok(self.number(2)? as u16)
    }

    pub(super) fn u32(&mut self) -> Result<u32, String> {
        Ok(self.number(4)? as u32)
    }

    pub(super) fn name(&mut self) -> Result<[u8; 4], String> {
        Ok(self.u32()?.to_be_bytes())
    }

    /// Reads a full box's version and flags.
    pub(super) fn version(&mut self) -> Result<(u8, u32), String> {
        let word = self.u32()?;
        Ok(((word >> 24) as u8, word & 0x00FF_FFFF))
    }

    /// Reads the next box's name and content; `None` at the end.
    pub(super) fn next_box(&mut self) -> Result<Option<([u8; 4], Bytes<'a>)>, String> {
        if self.0.is_empty() {
            return Ok(None);
        }
        let (length, name) = (self.u32()?, self.name()?);
        let content = match length {
            0 => self.0.len() as u64,
            1 => self.number(8)?.checked_sub(16).ok_or("a box is shorter than its head")?,
            _ => u64::from(length).checked_sub(8).ok_or("a box is shorter than its head")?,
        };
        let content = usize::try_from(content).ok().and_then(|content| self.take(content).ok());
        let content = content.ok_or_else(|| format!("the box `{}` is cut off", name.escape_ascii()))?;
        Ok(Some((name, Bytes(content))))
    }

    /// Finds the first box called `wanted`.
    ///
    /// # Errors
    /// Where there is none.
    pub(super) fn find(mut self, wanted: &[u8; 4]) -> Result<Bytes<'a>, String> {
        while let Some((name, content)) = self.next_box()? {
            if name == *wanted {
                return Ok(content);
            }
        }
        Err(format!("it has no box `{}`", wanted.escape_ascii()))
    }
}
