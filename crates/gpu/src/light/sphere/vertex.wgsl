// Vertices that `project` writes for a light that sees by angles: position and α, offset from the light and β.

import package::exact::vector::{f64_vector_from_f32_bits};
import package::light::sphere::angles::{along_axes, angle_of, f32_bits_of, scaled_offset};
import package::light::sphere::largest::{largest_bits};
import package::light::sphere::turn::{ANGLE_NOWHERE, ANGLE_UNKNOWN};

struct AngledVertex {
    of_world: vec4<u32>,
    of_light: vec4<u32>,
}

// Range of offsets that have angles, 10⁻³⁰ to 10³⁰.
const SMALLEST_PART: f32 = 1e-30;
const LARGEST_OFFSET_BITS: u32 = 0x7149f2cau;
// 2⁻²⁴: an offset has no angle if it is closer than this, relative to its size, to the line around which the angle turns.
const SMALLEST_SHARE: f32 = 5.9604645e-8;

fn angled_vertex(bits: vec3<u32>) -> AngledVertex {
    if largest_bits(bits) >= 0x7f800000u {
        let nowhere = vec4<u32>(0u, 0u, 0u, u32(ANGLE_NOWHERE));
        return AngledVertex(nowhere, nowhere);
    }
    let offset = scaled_offset(f64_vector_from_f32_bits(bits));
    let of_light = f32_bits_of(offset);
    var angles = vec2<i32>(ANGLE_UNKNOWN);
    let largest = largest_bits(of_light);
    if largest < LARGEST_OFFSET_BITS {
        let parts = along_axes(offset);
        let least = max(bitcast<f32>(largest) * SMALLEST_SHARE, SMALLEST_PART);
        if abs(parts.x) + abs(parts.z) > least {
            angles.x = angle_of(parts.x, parts.z);
        }
        if abs(parts.y) + abs(parts.z) > least {
            angles.y = angle_of(parts.y, parts.z);
        }
    }
    return AngledVertex(vec4<u32>(bits, u32(angles.x)), vec4<u32>(of_light, u32(angles.y)));
}
