//! Sixteen rays side by side, and single ones, laid out as Embree reads them.

use crate::posed::Posed;

/// Rays of a packet.
pub const WIDTH: usize = 16;

/// Rays of half a packet.
pub(crate) const HALF: usize = WIDTH / 2;

/// Embree's id for no triangle and no geometry.
const NONE: u32 = u32::MAX;

/// −1 for each ray that is traced, 0 for the others.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C, align(64))]
pub struct Valid(pub [i32; WIDTH]);

/// Rays as Embree reads them: `RTCRay` of numbers, or `RTCRay16`, 768 bytes, of sixteen of each.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct Rays<F, U> {
    /// Origins in world space.
    pub origin: [F; 3],
    /// Start of the rays, in lengths of their directions.
    pub t_near: F,
    /// Directions of any length.
    pub direction: [F; 3],
    /// For motion blur; zero.
    pub time: F,
    /// End of the rays, then their hits; −∞ for a blocked shadow ray.
    pub t_far: F,
    /// Mask of the geometries that rays can hit: all.
    pub mask: U,
    /// Not used.
    pub id: U,
    /// Not used.
    pub flags: U,
}

/// Hits of rays, as Embree writes them: `RTCHit16` has 512 bytes for Embree 3, and 64 more for the last field, which
/// Embree 4 may have and Embree 3 ignores.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct Hits<F, U> {
    /// Unnormalised normals.
    pub normal: [F; 3],
    /// Weights of the second corners.
    pub u: F,
    /// Weights of the third corners.
    pub v: F,
    /// Ids of triangles.
    pub primitive: U,
    /// Zero for a hit, all ones for none.
    pub geometry: U,
    /// Not used: nothing is instanced.
    pub instance: U,
    /// Not used: nothing is instanced.
    pub instance_primitive: U,
}

impl<F: Copy, U: Copy> Rays<F, U> {
    /// Endless rays; the arguments are zero and infinity as `F`, then zero and all ones as `U`.
    fn endless(zero: F, infinity: F, none: U, all: U) -> Self {
        let (origin, direction) = ([zero; 3], [zero; 3]);
        Self { origin, t_near: zero, direction, time: zero, t_far: infinity, mask: all, id: none, flags: none }
    }
}

impl<F: Copy, U: Copy> Hits<F, U> {
    /// Misses; the arguments are zero, and Embree's id for none.
    fn none(zero: F, none: U) -> Self {
        let normal = [zero; 3];
        Self { normal, u: zero, v: zero, primitive: none, geometry: none, instance: none, instance_primitive: none }
    }
}

/// `RTCRayHit16`.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub struct RayHitPacket {
    /// The rays.
    pub ray: Rays<[f32; WIDTH], [u32; WIDTH]>,
    /// Their hits.
    pub hit: Hits<[f32; WIDTH], [u32; WIDTH]>,
}

/// Half of a packet, for processors that trace eight rays at a time: `RTCRayHit8`.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub(crate) struct HalfPacket {
    ray: Rays<[f32; HALF], [u32; HALF]>,
    hit: Hits<[f32; HALF], [u32; HALF]>,
}

/// −1 for each ray of a half that is traced, 0 for the others.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C, align(32))]
pub(crate) struct ValidHalf([i32; HALF]);

/// `RTCRayHit`: 80 bytes for Embree 3, and 16 more for the last fields, which Embree 4 may have and Embree 3 ignores.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(16))]
pub struct SingleRay {
    ray: Rays<f32, u32>,
    hit: Hits<f32, u32>,
}

impl SingleRay {
    /// An endless ray without a hit.
    #[must_use]
    pub fn new(origin: [f32; 3], direction: [f32; 3]) -> Self {
        let ray = Rays { origin, direction, ..Rays::endless(0.0, f32::INFINITY, 0, u32::MAX) };
        Self { ray, hit: Hits::none(0.0, NONE) }
    }

    /// Name of the hit triangle, for [`Posed::triangle`](crate::Posed::triangle); `None` for a miss.
    #[must_use]
    pub fn name(&self) -> Option<u32> {
        (self.hit.geometry != NONE).then(|| Posed::name(self.hit.primitive, self.hit.geometry))
    }
}

impl Valid {
    /// All lanes are traced.
    pub const ALL: Self = Self([-1; WIDTH]);
    /// No lane is traced.
    pub const NONE: Self = Self([0; WIDTH]);
}

impl Default for RayHitPacket {
    fn default() -> Self {
        let zero = [0.0; WIDTH];
        let ray = Rays::endless(zero, [f32::INFINITY; WIDTH], [0; WIDTH], [u32::MAX; WIDTH]);
        Self { ray, hit: Hits::none(zero, [NONE; WIDTH]) }
    }
}

impl RayHitPacket {
    /// Makes the rays endless and removes their hits.
    #[inline(always)]
    pub fn forget_hits(&mut self) {
        self.ray.t_far = [f32::INFINITY; WIDTH];
        self.hit.geometry = [NONE; WIDTH];
        self.hit.primitive = [NONE; WIDTH];
    }
}

impl HalfPacket {
    /// The rays `first` and following of a packet, without their hits.
    #[inline(always)]
    pub(crate) fn of(packet: &RayHitPacket, first: usize) -> Self {
        let Rays { origin, t_near, direction, time, t_far, mask, id, flags } = &packet.ray;
        let ray = Rays {
            origin: [half(&origin[0], first), half(&origin[1], first), half(&origin[2], first)],
            t_near: half(t_near, first),
            direction: [half(&direction[0], first), half(&direction[1], first), half(&direction[2], first)],
            time: half(time, first),
            t_far: half(t_far, first),
            mask: half(mask, first),
            id: half(id, first),
            flags: half(flags, first),
        };
        Self { ray, hit: Hits::none([0.0; HALF], [NONE; HALF]) }
    }

    /// Stores the distances and triangles of its hits in the packet.
    #[inline(always)]
    pub(crate) fn store(&self, packet: &mut RayHitPacket, first: usize) {
        packet.ray.t_far[first..first + HALF].copy_from_slice(&self.ray.t_far);
        packet.hit.primitive[first..first + HALF].copy_from_slice(&self.hit.primitive);
        packet.hit.geometry[first..first + HALF].copy_from_slice(&self.hit.geometry);
    }
}

impl ValidHalf {
    /// The flags of the rays `first` and following.
    #[inline(always)]
    pub(crate) fn of(valid: &Valid, first: usize) -> Self {
        Self(half(&valid.0, first))
    }

    /// Whether no ray is traced.
    #[inline(always)]
    pub(crate) fn is_empty(&self) -> bool {
        self.0 == [0; HALF]
    }
}

#[inline(always)]
fn half<T: Copy>(values: &[T; WIDTH], first: usize) -> [T; HALF] {
    std::array::from_fn(|lane| values[first + lane])
}

#[cfg(test)]
mod tests {
    use std::mem::{align_of, offset_of};

    use super::*;

    /// Numbers from `rtcore_ray.h`.
    #[test]
    fn packets_are_laid_out_as_embree_reads_them() {
        const ARRAY: usize = 64;
        assert_eq!((size_of::<Valid>(), align_of::<Valid>()), (ARRAY, 64));
        type Rays = super::Rays<[f32; WIDTH], [u32; WIDTH]>;
        type Hits = super::Hits<[f32; WIDTH], [u32; WIDTH]>;
        assert_eq!((size_of::<Rays>(), size_of::<Hits>()), (12 * ARRAY, 9 * ARRAY));
        assert_eq!((size_of::<RayHitPacket>(), align_of::<RayHitPacket>()), (21 * ARRAY, 64));
        assert_eq!((size_of::<HalfPacket>(), align_of::<HalfPacket>()), (21 * ARRAY / 2, 32));
        assert_eq!((size_of::<ValidHalf>(), align_of::<ValidHalf>()), (ARRAY / 2, 32));
        assert_eq!((size_of::<SingleRay>(), align_of::<SingleRay>()), (96, 16));
        assert_eq!((offset_of!(SingleRay, ray), offset_of!(SingleRay, hit)), (0, 48));
        assert_eq!((offset_of!(RayHitPacket, ray), offset_of!(RayHitPacket, hit)), (0, 12 * ARRAY));
        assert_eq!(offset_of!(Rays, t_near), 3 * ARRAY);
        assert_eq!(offset_of!(Rays, direction), 4 * ARRAY);
        assert_eq!(offset_of!(Rays, time), 7 * ARRAY);
        assert_eq!(offset_of!(Rays, t_far), 8 * ARRAY);
        assert_eq!(offset_of!(Rays, mask), 9 * ARRAY);
        assert_eq!(offset_of!(Rays, flags), 11 * ARRAY);
        assert_eq!(offset_of!(Hits, u), 3 * ARRAY);
        assert_eq!(offset_of!(Hits, primitive), 5 * ARRAY);
        assert_eq!(offset_of!(Hits, geometry), 6 * ARRAY);
        assert_eq!(offset_of!(Hits, instance), 7 * ARRAY);
        assert_eq!(offset_of!(Hits, instance_primitive), 8 * ARRAY);
    }
}
