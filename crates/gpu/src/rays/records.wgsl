// Layout of rays and shadow questions in a buffer: a header, then records.


// Number of records, …
const RECORDS_COUNT: u32 = 0u;
// … then the workgroups for them, with a record for each invocation: three words for groups of 64, three for packets.
const RECORDS_GROUPS: u32 = 1u;
const RECORDS_PACKETS: u32 = 4u;
const RECORDS_FIRST: u32 = 8u;
const RECORD_WORDS: u32 = 20u;

// Of a ray: origin, direction, and the ends of its interval, all F64.
const RAY_DIRECTION: u32 = 6u;
const RAY_T_MIN: u32 = 12u;
const RAY_T_MAX: u32 = 14u;
// Of a ray that starts at a point of a triangle: the point's error on any axis, in F64; zero for other rays.
const RAY_ERROR: u32 = 18u;

// Of a shadow question: the point with its error, in F64; the light, in bits of f32; the light's contribution, in f32.
const SHADOW_ERROR: u32 = 6u;
const SHADOW_LIGHT: u32 = 8u;
const SHADOW_IS_DIRECTIONAL: u32 = 11u;
const SHADOW_COLOR: u32 = 12u;

// Of both: the triangle to ignore, and a tag for the stage that asks; `NO_TRIANGLE` marks an empty shadow question.
const RECORD_OWN: u32 = 16u;
const RECORD_TAG: u32 = 17u;

// Invocations of a workgroup, except for packets.
const RECORD_LANES: u32 = 64u;

// Of a hit: its triangle, an unused word, t in F64, and the weights of its second and third corner.
const HIT_WORDS: u32 = 8u;

const NO_TRIANGLE: u32 = 0xffffffffu;

fn record_start(number: u32) -> u32 {
    return RECORDS_FIRST + number * RECORD_WORDS;
}
