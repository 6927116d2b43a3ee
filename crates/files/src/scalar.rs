//! Types of the numbers in binary files.

/// A type of number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Scalar {
    /// Range of an integer type; `None` for floating-point types.
    pub(crate) fn whole_range(self) -> Option<(f64, f64)> {
        Some(match self {
            Self::I8 => (f64::from(i8::MIN), f64::from(i8::MAX)),
            Self::U8 => (0.0, f64::from(u8::MAX)),
            Self::I16 => (f64::from(i16::MIN), f64::from(i16::MAX)),
            Self::U16 => (0.0, f64::from(u16::MAX)),
            Self::I32 => (f64::from(i32::MIN), f64::from(i32::MAX)),
            Self::U32 => (0.0, f64::from(u32::MAX)),
            Self::F32 | Self::F64 => return None,
        })
    }

    /// Bytes of a value.
    pub(crate) fn bytes(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    /// The number in `bytes`, as many as the type has.
    pub(crate) fn decode(self, bytes: &[u8], big_endian: bool) -> f64 {
        /// The bytes in little-endian order; zeros if there aren't as many.
        fn ordered<const N: usize>(bytes: &[u8], big_endian: bool) -> [u8; N] {
            let mut ordered: [u8; N] = bytes.try_into().unwrap_or([0; N]);
            if big_endian {
                ordered.reverse();
            }
            ordered
        }
        match self {
            Self::I8 => f64::from(i8::from_le_bytes(ordered(bytes, big_endian))),
            Self::U8 => f64::from(u8::from_le_bytes(ordered(bytes, big_endian))),
            Self::I16 => f64::from(i16::from_le_bytes(ordered(bytes, big_endian))),
            Self::U16 => f64::from(u16::from_le_bytes(ordered(bytes, big_endian))),
            Self::I32 => f64::from(i32::from_le_bytes(ordered(bytes, big_endian))),
            Self::U32 => f64::from(u32::from_le_bytes(ordered(bytes, big_endian))),
            Self::F32 => f64::from(f32::from_le_bytes(ordered(bytes, big_endian))),
            Self::F64 => f64::from_le_bytes(ordered(bytes, big_endian)),
        }
    }
}
