// Bits of the largest magnitude of three numbers; above those of all numbers if one is NaN.
fn largest_bits(bits: vec3<u32>) -> u32 {
    let magnitudes = bits & vec3<u32>(0x7fffffffu);
    return max(max(magnitudes.x, magnitudes.y), magnitudes.z);
}
