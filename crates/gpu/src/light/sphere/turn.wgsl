// Angles around a light as integers.
//
// The angle of (across, along) from `along` is counted in units of 2⁻³⁰ of a turn, but not evenly: across / (|across| +
// |along|) on the side where `along` is positive, the rest of a half turn on the other. It is in the same order as
// true angles, and opposite directions are half a turn apart.

const TURN: i32 = 0x40000000;
const HALF_TURN: i32 = 0x20000000;
// Of vertices: an unknown angle, and the angle of a vertex that isn't finite.
const ANGLE_UNKNOWN: i32 = 0x7fffffff;
const ANGLE_NOWHERE: i32 = 0x7ffffffe;
