//! Conversion of luma and chroma to red, green and blue (ITU-T H.273, section 8.3).

use re_rav1d::dav1d::Picture;
use re_rav1d::dav1d::pixel::YUVRange;

use super::planes::{Planes, SamplePlane};

/// Colour coding of planes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Coding {
    /// `MatrixCoefficients` of H.273.
    pub(super) matrix: u16,
    /// Whether values use their full range, rather than 16 to 235 or 240 (in 8 bits).
    pub(super) is_full_range: bool,
}

impl Coding {
    /// The coding stored in the frame.
    pub(super) fn of(picture: &Picture) -> Self {
        // The decoder's numbers are H.273's too.
        Self { matrix: picture.matrix_coefficients() as u16, is_full_range: picture.color_range() == YUVRange::Full }
    }

    /// Weights of red and blue in luma; `None` where the planes are green, blue and red.
    ///
    /// # Errors
    /// For unsupported matrices.
    fn parts(self) -> Result<Option<[f32; 2]>, String> {
        match self.matrix {
            0 => Ok(None),
            1 => Ok(Some([0.2126, 0.0722])),
            // Unspecified is read as BT.601, which most writers mean.
            2 | 5 | 6 => Ok(Some([0.299, 0.114])),
            4 => Ok(Some([0.30, 0.11])),
            7 => Ok(Some([0.212, 0.087])),
            9 => Ok(Some([0.2627, 0.0593])),
            other => Err(format!("its colours are coded by matrix {other} of H.273, which is not read")),
        }
    }

    /// Offset to subtract and scale that map luma to 0 … 1.
    fn luma(self, bits: u32) -> [f32; 2] {
        let unit = (1_u32 << (bits - 8)) as f32;
        if self.is_full_range { [0.0, 1.0 / greatest(bits)] } else { [16.0 * unit, 1.0 / (219.0 * unit)] }
    }

    /// Offset to subtract and scale that map chroma to −½ … ½.
    fn chroma(self, bits: u32) -> [f32; 2] {
        let unit = (1_u32 << (bits - 8)) as f32;
        [128.0 * unit, if self.is_full_range { 1.0 / greatest(bits) } else { 1.0 / (224.0 * unit) }]
    }
}

fn greatest(bits: u32) -> f32 {
    ((1_u32 << bits) - 1) as f32
}

fn scaled(value: f32, [offset, factor]: [f32; 2]) -> f32 {
    (value - offset) * factor
}

fn byte(value: f32) -> u8 {
    (value * 255.0).round() as u8
}

/// Converts planes to opaque texels.
///
/// # Errors
/// For unsupported codings.
pub(super) fn texels(planes: &Planes, coding: Coding) -> Result<Vec<[u8; 4]>, String> {
    let luma = coding.luma(planes.bits);
    let Some(chroma) = &planes.chroma else {
        let gray = |&value: &u16| [byte(scaled(f32::from(value), luma)); 3];
        return Ok(planes.luma.values.iter().map(gray).map(|[r, g, b]| [r, g, b, 255]).collect());
    };
    let parts = coding.parts()?;
    let width = planes.luma.width;
    if parts.is_none() && chroma[0].values.len() != planes.luma.values.len() {
        return Err("its planes are of red, green and blue, but not of one size".to_owned());
    }
    let differences = coding.chroma(planes.bits);
    let texel = |(at, &value): (usize, &u16)| {
        let value = f32::from(value);
        let [r, g, b] = match parts {
            None => {
                [f32::from(chroma[1].values[at]), value, f32::from(chroma[0].values[at])].map(|each| scaled(each, luma))
            }
            Some(parts) => {
                let blue_red = chroma.each_ref().map(|plane| plane.at([at % width, at / width], &planes.luma));
                rgb(scaled(value, luma), blue_red.map(|each| scaled(each, differences)), parts)
            }
        };
        [byte(r), byte(g), byte(b), 255]
    };
    Ok(planes.luma.values.iter().enumerate().map(texel).collect())
}

fn rgb(brightness: f32, [blue, red]: [f32; 2], [of_red, of_blue]: [f32; 2]) -> [f32; 3] {
    let r = brightness + 2.0 * (1.0 - of_red) * red;
    let b = brightness + 2.0 * (1.0 - of_blue) * blue;
    [r, (brightness - of_red * r - of_blue * b) / (1.0 - of_red - of_blue), b]
}

/// Copies the luma of a picture to alpha, and divides premultiplied colours by it.
pub(super) fn add_alpha(texels: &mut [[u8; 4]], planes: &Planes, coding: Coding, is_premultiplied: bool) {
    let luma = coding.luma(planes.bits);
    for ([r, g, b, a], &value) in texels.iter_mut().zip(&planes.luma.values) {
        *a = byte(scaled(f32::from(value), luma));
        if is_premultiplied && *a != 0 {
            for color in [r, g, b] {
                *color = byte(f32::from(*color) / f32::from(*a));
            }
        }
    }
}

impl SamplePlane {
    fn height(&self) -> usize {
        self.values.len() / self.width
    }

    /// Samples this plane at a texel of `full`, which is as large, or twice as wide or high: a linear mix of the nearest
    /// values, which are centred on the texels that they cover.
    fn at(&self, [x, y]: [usize; 2], full: &Self) -> f32 {
        let [(left, right), (upper, lower)] =
            [nearest(x, self.width, full.width), nearest(y, self.height(), full.height())];
        let value = |x: usize, y: usize| f32::from(self.values[y * self.width + x]);
        let row = |y: usize| 0.75 * value(left, y) + 0.25 * value(right, y);
        0.75 * row(upper) + 0.25 * row(lower)
    }
}

/// Indices of the nearest and the next nearest value along a side; equal where the plane isn't subsampled.
fn nearest(at: usize, side: usize, full: usize) -> (usize, usize) {
    if side == full {
        return (at, at);
    }
    let nearest = at / 2;
    let next = if at.is_multiple_of(2) { nearest.saturating_sub(1) } else { (nearest + 1).min(side - 1) };
    (nearest, next)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Encodes luma or chroma by H.273.
    fn coded(value: f64, is_luma: bool, bits: u32, is_full_range: bool) -> u16 {
        let unit = f64::from(1_u32 << (bits - 8));
        let [offset, scale] = match (is_luma, is_full_range) {
            (true, true) => [0.0, f64::from((1_u32 << bits) - 1)],
            (true, false) => [16.0 * unit, 219.0 * unit],
            (false, true) => [128.0 * unit, f64::from((1_u32 << bits) - 1)],
            (false, false) => [128.0 * unit, 224.0 * unit],
        };
        (offset + scale * value).round().clamp(0.0, f64::from((1_u32 << bits) - 1)) as u16
    }

    fn planes(values: [u16; 3], bits: u32, coding: Coding) -> Planes {
        let [luma, blue, red] = values.map(|value| SamplePlane { width: 1, values: vec![value] });
        Planes { size: [1, 1], bits, luma, chroma: Some([blue, red]), coding }
    }

    #[test]
    fn every_matrix_depth_and_range_comes_back() {
        for (matrix, [r, b]) in [(1, [0.2126, 0.0722]), (2, [0.299, 0.114]), (6, [0.299, 0.114]), (9, [0.2627, 0.0593])]
        {
            for (bits, is_full_range) in [8, 10, 12].into_iter().flat_map(|bits| [(bits, false), (bits, true)]) {
                let coding = Coding { matrix, is_full_range };
                for color in [[255, 0, 0], [0, 255, 0], [0, 0, 255], [255, 255, 255], [0, 0, 0], [200, 40, 90]] {
                    let [red, green, blue] = color.map(|byte: u8| f64::from(byte) / 255.0);
                    let luma = r * red + (1.0 - r - b) * green + b * blue;
                    let differences = [(blue - luma) / (2.0 * (1.0 - b)), (red - luma) / (2.0 * (1.0 - r))];
                    let [of_blue, of_red] = differences.map(|value| coded(value, false, bits, is_full_range));
                    let values = [coded(luma, true, bits, is_full_range), of_blue, of_red];
                    let [found] = texels(&planes(values, bits, coding), coding).unwrap()[..] else {
                        panic!("one texel")
                    };
                    let is_near = found.iter().zip(color).all(|(found, byte)| found.abs_diff(byte) <= 2);
                    assert!(is_near && found[3] == 255, "{coding:?}, {bits} bits: {color:?} is {found:?}");
                }
            }
        }
    }

    #[test]
    fn published_values_are_their_colors() {
        let limited = |matrix| Coding { matrix, is_full_range: false };
        // Red and blue of 100 % colour bars in BT.709, red in BT.601, and plain green, blue and red.
        for (values, coding, color) in [
            ([63, 102, 240], limited(1), [255, 0, 0]),
            ([32, 240, 118], limited(1), [0, 0, 255]),
            ([81, 90, 240], limited(6), [255, 0, 0]),
            ([20, 30, 10], Coding { matrix: 0, is_full_range: true }, [10, 20, 30]),
        ] {
            let found = texels(&planes(values, 8, coding), coding).unwrap()[0];
            let is_near = found.iter().zip(color).all(|(found, byte): (_, u8)| found.abs_diff(byte) <= 2);
            assert!(is_near, "{coding:?}: {found:?}, not {color:?}");
        }
        assert!(texels(&planes([0; 3], 8, limited(8)), limited(8)).is_err());
    }

    #[test]
    fn halved_planes_are_mixed_between_their_middles() {
        let full = SamplePlane { width: 5, values: vec![0; 15] };
        let half = SamplePlane { width: 3, values: vec![0, 40, 80, 400, 440, 480] };
        let row = |y| [0, 1, 2, 3, 4].map(|x| half.at([x, y], &full));
        assert_eq!(row(0), [0.0, 10.0, 30.0, 50.0, 70.0]);
        assert_eq!(row(1), [100.0, 110.0, 130.0, 150.0, 170.0]);
        let same = SamplePlane { width: 3, values: vec![7, 8, 9] };
        assert_eq!(same.at([1, 0], &same), 8.0);
    }
}
