//! Filters undone after decompression: encodings of numbers that compress well.
//!
//! `EXT_meshopt_compression`, appendix B; COLOR is of `KHR_meshopt_compression`.

use serde::Deserialize;

/// A filter, by its name in the JSON.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "UPPERCASE")]
pub(super) enum Filter {
    #[default]
    None,
    Octahedral,
    Quaternion,
    Exponential,
    Color,
}

impl Filter {
    /// Whether this filter accepts elements of `stride` bytes.
    pub(super) fn takes(self, stride: usize) -> bool {
        match self {
            Self::None | Self::Exponential => true,
            Self::Octahedral | Self::Color => stride == 4 || stride == 8,
            Self::Quaternion => stride == 8,
        }
    }

    /// Decodes `elements` of `stride` bytes in place.
    pub(super) fn undo(self, elements: &mut [u8], stride: usize) {
        match self {
            Self::None => {}
            Self::Octahedral if stride == 4 => {
                for element in elements.as_chunks_mut().0 {
                    let [x, y, one, w] = element.map(|byte| byte as i8);
                    let [x, y, z] = direction([x, y, one].map(f32::from), 127.0).map(|value| value as i8);
                    *element = [x, y, z, w].map(|value| value as u8);
                }
            }
            Self::Octahedral => signed_words(elements, |[x, y, one, w]| {
                let [x, y, z] = direction([x, y, one].map(f32::from), 32_767.0).map(|value| value as i16);
                [x, y, z, w]
            }),
            Self::Quaternion => signed_words(elements, rotation),
            Self::Exponential => {
                for number in elements.as_chunks_mut::<4>().0 {
                    *number = exponential(i32::from_le_bytes(*number)).to_le_bytes();
                }
            }
            Self::Color if stride == 4 => {
                for element in elements.as_chunks_mut().0 {
                    let [y, orange, green, alpha] = *element;
                    let chroma = [orange, green].map(|byte| f32::from(byte as i8));
                    *element = color(y.into(), chroma, alpha.into(), 255.0).map(|value| value as u8);
                }
            }
            Self::Color => signed_words(elements, |[y, orange, green, alpha]| {
                let [y, alpha] = [y, alpha].map(|word| word as u16);
                let chroma = [orange, green].map(f32::from);
                color(y.into(), chroma, alpha.into(), 65_535.0).map(|value| value as u16 as i16)
            }),
        }
    }
}

/// Maps elements of four words.
fn signed_words(elements: &mut [u8], map: impl Fn([i16; 4]) -> [i16; 4]) {
    for element in elements.as_chunks_mut::<8>().0 {
        let [a, b, c, d] = [0, 2, 4, 6].map(|at| i16::from_le_bytes([element[at], element[at + 1]]));
        let words = map([a, b, c, d]).map(i16::to_le_bytes);
        element.copy_from_slice(words.as_flattened());
    }
}

/// Decodes a unit vector, times `greatest`, from octahedral coordinates x and y, where `one` stands for 1.
fn direction([x, y, one]: [f32; 3], greatest: f32) -> [f32; 3] {
    let z = one - x.abs() - y.abs();
    let beyond = (-z).max(0.0);
    let fold = |value: f32| if value >= 0.0 { value - beyond } else { value + beyond };
    let (x, y) = (fold(x), fold(y));
    let scale = greatest / (x * x + y * y + z * z).sqrt();
    [x, y, z].map(|value| (value * scale).round())
}

/// Decodes a quaternion from its three smaller components. The lowest two bits of the fourth word are the index of the
/// omitted component, the others are the scale of the three.
fn rotation([x, y, z, coded]: [i16; 4]) -> [i16; 4] {
    let scale = std::f32::consts::FRAC_1_SQRT_2 / f32::from(coded | 3);
    let [x, y, z] = [x, y, z].map(|value| f32::from(value) * scale);
    let largest = (1.0 - x * x - y * y - z * z).max(0.0).sqrt();
    let left_out = (coded & 3) as usize;
    let mut rotation = [0; 4];
    for (step, value) in [largest, x, y, z].into_iter().enumerate() {
        rotation[(left_out + step) % 4] = (value * 32_767.0).round() as i16;
    }
    rotation
}

/// Decodes a float from its exponent, in the highest byte, and its mantissa.
fn exponential(coded: i32) -> f32 {
    let mantissa = coded << 8 >> 8;
    (f64::from(mantissa) * f64::from(coded >> 24).exp2()) as f32
}

/// Decodes red, green, blue and alpha, each up to `greatest`, from lightness, two differences, and an alpha whose highest
/// bit gives the number of bits of all four.
fn color(y: f32, [orange, green]: [f32; 2], alpha: u32, greatest: f32) -> [f32; 4] {
    let all_bits = alpha.checked_ilog2().map_or(0, |highest| (2 << highest) - 1);
    let low = alpha & (all_bits >> 1);
    let alpha = (low << 1 | low & 1) as f32;
    let scale = greatest / all_bits as f32;
    [y + orange - green, y + green, y - orange - green, alpha].map(|value| (value * scale).round())
}
