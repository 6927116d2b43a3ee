// The tiles of a light's face: columns and rows of bins. Each has a cell for each of its depth slices.

// Bins of an axis of a face.
const BINS: u32 = 2048u;
// Fraction bits of fixed-point coordinates on faces.
const BIN_FRACTION_BITS: u32 = 18u;
const BIN_UNIT: f32 = 3.8146973e-6;
// For each axis of a face: the points of each bin, then its column; then the first bin of each column, and the end.
const SPREAD_STARTS: u32 = BINS;
const SPREAD_WORDS: u32 = 4096u;

fn spread_base(face: u32, axis: u32) -> u32 {
    return (2u * face + axis) * SPREAD_WORDS;
}
