//! A reader of meshoptimizer's streams, from front to back.

/// The unread bytes.
#[derive(Debug)]
pub(super) struct Bytes<'a> {
    rest: &'a [u8],
}

impl<'a> Bytes<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Self { rest: bytes }
    }

    /// The next `count` bytes.
    ///
    /// # Errors
    /// A message, where there are fewer.
    pub(super) fn take(&mut self, count: usize) -> Result<&'a [u8], String> {
        let (taken, rest) = self.rest.split_at_checked(count).ok_or("its bytes end too early")?;
        self.rest = rest;
        Ok(taken)
    }

    /// The next byte.
    ///
    /// # Errors
    /// As [`Bytes::take`].
    pub(super) fn byte(&mut self) -> Result<u8, String> {
        Ok(self.take(1)?[0])
    }

    /// A number in groups of seven bits, the lowest first; the last group's byte is below 128.
    ///
    /// # Errors
    /// As [`Bytes::take`], and where it doesn't fit into 32 bits.
    pub(super) fn number(&mut self) -> Result<u32, String> {
        let mut number = 0;
        for shift in (0..32).step_by(7) {
            let byte = self.byte()?;
            number |= u32::from(byte & 0x7f) << shift;
            if byte < 0x80 {
                return Ok(number);
            }
        }
        Err("a number takes more than five bytes".to_owned())
    }

    /// Checks that all bytes were read.
    ///
    /// # Errors
    /// A message with the number of bytes left.
    pub(super) fn expect_end(&self) -> Result<(), String> {
        if self.rest.is_empty() {
            return Ok(());
        }
        Err(format!("{} bytes are left over behind the last element", self.rest.len()))
    }
}

/// A signed number from its zigzag code: 0, −1, 1, −2 …
pub(super) fn signed(code: u32) -> u32 {
    (code >> 1) ^ (code & 1).wrapping_neg()
}
