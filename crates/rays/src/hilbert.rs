/// The distance of a cell, with coordinates below 1024, along Hilbert's curve: 30 bits (Skilling, *Programming the Hilbert
/// curve*, 2004).
pub(crate) fn along_hilbert_curve(mut cell: [u32; 3]) -> u32 {
    const HIGHEST: u32 = 1 << 9;
    let mut bit = HIGHEST;
    while bit > 1 {
        let below = bit - 1;
        for axis in 0..3 {
            if cell[axis] & bit != 0 {
                cell[0] ^= below;
            } else {
                let exchanged = (cell[0] ^ cell[axis]) & below;
                cell[0] ^= exchanged;
                cell[axis] ^= exchanged;
            }
        }
        bit >>= 1;
    }
    cell[1] ^= cell[0];
    cell[2] ^= cell[1];
    let mut flipped = 0;
    let mut bit = HIGHEST;
    while bit > 1 {
        if cell[2] & bit != 0 {
            flipped ^= bit - 1;
        }
        bit >>= 1;
    }
    let [x, y, z] = cell.map(|coordinate| spread_bits(coordinate ^ flipped));
    x << 2 | y << 1 | z
}

/// A number below 1024 with two zeros after each bit.
fn spread_bits(number: u32) -> u32 {
    let bits = (number | number << 16) & 0x0300_00ff;
    let bits = (bits | bits << 8) & 0x0300_f00f;
    let bits = (bits | bits << 4) & 0x030c_30c3;
    (bits | bits << 2) & 0x0924_9249
}
