//! Sixteen rays side by side, and single ones, laid out as Embree reads them.

use crate::posed::Posed;

/// Rays of a packet.
pub const WIDTH: usize = 16;

/// Embree's number for no triangle and no geometry.
const NONE: u32 = u32::MAX;

/// −1 for each ray that is traced, 0 for the others.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C, align(64))]
pub struct Valid(pub [i32; WIDTH]);

/// `RTCRay16`: 768 bytes.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub struct RayPacket {
    /// Origins in world space.
    pub origin: [[f32; WIDTH]; 3],
    /// Where the rays start, in lengths of their directions.
    pub t_near: [f32; WIDTH],
    /// Directions of any length.
    pub direction: [[f32; WIDTH]; 3],
    /// For motion blur; zero.
    pub time: [f32; WIDTH],
    /// Where the rays end, and where they hit; −∞ for a shadow ray that is blocked.
    pub t_far: [f32; WIDTH],
    /// Which geometry they see; all.
    pub mask: [u32; WIDTH],
    /// Not used.
    pub id: [u32; WIDTH],
    /// Not used.
    pub flags: [u32; WIDTH],
}

/// `RTCHit16`: 512 bytes for Embree 3, and 64 more for the last field, which Embree 4 may have and Embree 3 ignores.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub struct HitPacket {
    /// Unnormalised normals.
    pub normal: [[f32; WIDTH]; 3],
    /// Weights of the second corners.
    pub u: [f32; WIDTH],
    /// Weights of the third corners.
    pub v: [f32; WIDTH],
    /// Ids of triangles.
    pub primitive: [u32; WIDTH],
    /// Zero for a hit, all ones for none.
    pub geometry: [u32; WIDTH],
    /// Not used: nothing is instanced.
    pub instance: [u32; WIDTH],
    /// Not used: nothing is instanced.
    pub instance_primitive: [u32; WIDTH],
}

/// `RTCRayHit16`.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(64))]
pub struct RayHitPacket {
    /// The rays.
    pub ray: RayPacket,
    /// What they hit.
    pub hit: HitPacket,
}

/// `RTCRayHit`: 80 bytes for Embree 3, and 16 more for the last fields, which Embree 4 may have and Embree 3 ignores.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(16))]
pub struct SingleRay {
    /// Origin in world space.
    pub origin: [f32; 3],
    /// Where the ray starts, in lengths of its direction.
    pub t_near: f32,
    /// A direction of any length.
    pub direction: [f32; 3],
    time: f32,
    /// Where the ray ends, and where it hits.
    pub t_far: f32,
    mask: u32,
    id: u32,
    flags: u32,
    normal: [f32; 3],
    u: f32,
    v: f32,
    primitive: u32,
    geometry: u32,
    instance: u32,
    instance_primitive: u32,
}

impl SingleRay {
    /// An endless ray that hasn't hit anything.
    #[must_use]
    pub fn new(origin: [f32; 3], direction: [f32; 3]) -> Self {
        Self {
            origin,
            t_near: 0.0,
            direction,
            time: 0.0,
            t_far: f32::INFINITY,
            mask: u32::MAX,
            id: 0,
            flags: 0,
            normal: [0.0; 3],
            u: 0.0,
            v: 0.0,
            primitive: NONE,
            geometry: NONE,
            instance: NONE,
            instance_primitive: NONE,
        }
    }

    /// The name of the triangle that was hit, which [`Posed::triangle`](crate::Posed::triangle) knows; `None` for none.
    #[must_use]
    pub fn name(&self) -> Option<u32> {
        (self.geometry != NONE).then(|| Posed::name(self.primitive, self.geometry))
    }
}

impl Valid {
    /// All rays are traced.
    pub const ALL: Self = Self([-1; WIDTH]);
    /// No ray is traced.
    pub const NONE: Self = Self([0; WIDTH]);
}

impl Default for RayPacket {
    fn default() -> Self {
        let zero = [0.0; WIDTH];
        Self {
            origin: [zero; 3],
            t_near: zero,
            direction: [zero; 3],
            time: zero,
            t_far: [f32::INFINITY; WIDTH],
            mask: [u32::MAX; WIDTH],
            id: [0; WIDTH],
            flags: [0; WIDTH],
        }
    }
}

impl Default for HitPacket {
    fn default() -> Self {
        let zero = [0.0; WIDTH];
        Self {
            normal: [zero; 3],
            u: zero,
            v: zero,
            primitive: [NONE; WIDTH],
            geometry: [NONE; WIDTH],
            instance: [NONE; WIDTH],
            instance_primitive: [NONE; WIDTH],
        }
    }
}

impl RayHitPacket {
    /// Makes the rays endless and forgets what they have hit.
    #[inline(always)]
    pub fn forget_hits(&mut self) {
        self.ray.t_far = [f32::INFINITY; WIDTH];
        self.hit.geometry = [NONE; WIDTH];
        self.hit.primitive = [NONE; WIDTH];
    }
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
        assert_eq!((size_of::<RayPacket>(), align_of::<RayPacket>()), (12 * ARRAY, 64));
        assert_eq!((size_of::<HitPacket>(), align_of::<HitPacket>()), (9 * ARRAY, 64));
        assert_eq!((size_of::<RayHitPacket>(), align_of::<RayHitPacket>()), (21 * ARRAY, 64));
        assert_eq!((size_of::<SingleRay>(), align_of::<SingleRay>()), (96, 16));
        assert_eq!((offset_of!(SingleRay, t_far), offset_of!(SingleRay, normal)), (32, 48));
        assert_eq!((offset_of!(SingleRay, primitive), offset_of!(SingleRay, instance)), (68, 76));
        assert_eq!(offset_of!(RayPacket, t_near), 3 * ARRAY);
        assert_eq!(offset_of!(RayPacket, direction), 4 * ARRAY);
        assert_eq!(offset_of!(RayPacket, time), 7 * ARRAY);
        assert_eq!(offset_of!(RayPacket, t_far), 8 * ARRAY);
        assert_eq!(offset_of!(RayPacket, mask), 9 * ARRAY);
        assert_eq!(offset_of!(RayPacket, flags), 11 * ARRAY);
        assert_eq!(offset_of!(RayHitPacket, hit), 12 * ARRAY);
        assert_eq!(offset_of!(HitPacket, u), 3 * ARRAY);
        assert_eq!(offset_of!(HitPacket, primitive), 5 * ARRAY);
        assert_eq!(offset_of!(HitPacket, geometry), 6 * ARRAY);
        assert_eq!(offset_of!(HitPacket, instance), 7 * ARRAY);
        assert_eq!(offset_of!(HitPacket, instance_primitive), 8 * ARRAY);
    }
}
