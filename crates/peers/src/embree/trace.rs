use std::ffi::c_void;
use std::ptr;

use libloading::Library;

use super::Handle;
use super::filter::Filter;
use crate::packet::{RayHitPacket, SingleRay, Valid};

/// The functions whose arguments depend on the version.
#[derive(Clone, Copy, Debug)]
pub(super) enum Trace {
    Three {
        intersect: unsafe extern "C" fn(*const Valid, Handle, *mut Context3, *mut RayHitPacket),
        occluded: unsafe extern "C" fn(*const Valid, Handle, *mut Context3, *mut RayHitPacket),
        intersect_one: unsafe extern "C" fn(Handle, *mut Context3, *mut SingleRay),
    },
    Four {
        intersect: unsafe extern "C" fn(*const Valid, Handle, *mut RayHitPacket, *mut Arguments4),
        occluded: unsafe extern "C" fn(*const Valid, Handle, *mut RayHitPacket, *mut Arguments4),
        intersect_one: unsafe extern "C" fn(Handle, *mut SingleRay, *mut Arguments4),
    },
}

/// `RTCIntersectContext` of Embree 3.
#[repr(C)]
pub(super) struct Context3 {
    flags: i32,
    filter: Option<Filter>,
    instance: u32,
}

/// `RTCIntersectArguments` and `RTCOccludedArguments` of Embree 4.
#[repr(C)]
pub(super) struct Arguments4 {
    flags: i32,
    features: u32,
    context: *mut c_void,
    filter: Option<Filter>,
    callback: *const c_void,
}

const COHERENT_3: i32 = 1;
const COHERENT_4: i32 = 1 << 16;

impl Trace {
    /// The functions of version `major`, or the reason why there are none.
    pub(super) fn find(library: &Library, major: u32) -> Result<Self, String> {
        // SAFETY: the types are those of the version's headers, and the library outlives the functions: both are in
        // `Embree`.
        let found = unsafe {
            let (intersect, occluded) = (c"rtcIntersect16".to_bytes_with_nul(), c"rtcOccluded16".to_bytes_with_nul());
            let intersect_one = c"rtcIntersect1".to_bytes_with_nul();
            match major {
                3 => library.get(intersect).and_then(|intersect| {
                    let (occluded, intersect_one) = (*library.get(occluded)?, *library.get(intersect_one)?);
                    Ok(Self::Three { intersect: *intersect, occluded, intersect_one })
                }),
                4 => library.get(intersect).and_then(|intersect| {
                    let (occluded, intersect_one) = (*library.get(occluded)?, *library.get(intersect_one)?);
                    Ok(Self::Four { intersect: *intersect, occluded, intersect_one })
                }),
                _ => return Err(format!("Embree {major} is neither 3 nor 4")),
            }
        };
        found.map_err(|error| error.to_string())
    }

    /// Finds the nearest hits of the `valid` rays.
    ///
    /// # Safety
    /// The scene must be a committed one of the same library.
    #[inline]
    pub(super) unsafe fn nearest(&self, scene: Handle, valid: &Valid, packet: &mut RayHitPacket) {
        // SAFETY: the scene is the caller's promise; packet and arguments have the header's layouts.
        unsafe {
            match *self {
                Self::Three { intersect, .. } => intersect(valid, scene, &mut { Context3::COHERENT }, packet),
                Self::Four { intersect, .. } => intersect(valid, scene, packet, &mut { Arguments4::COHERENT }),
            }
        }
    }

    /// Finds the nearest hit of a ray.
    ///
    /// # Safety
    /// As for `nearest`.
    #[inline]
    pub(super) unsafe fn nearest_of_one(&self, scene: Handle, ray: &mut SingleRay) {
        // SAFETY: as for `nearest`.
        unsafe {
            match *self {
                Self::Three { intersect_one, .. } => intersect_one(scene, &mut { Context3::INCOHERENT }, ray),
                Self::Four { intersect_one, .. } => intersect_one(scene, ray, &mut { Arguments4::INCOHERENT }),
            }
        }
    }

    /// Sets `t_far` of the `valid` rays that hit anything to −∞.
    ///
    /// # Safety
    /// As for `nearest`.
    #[inline]
    pub(super) unsafe fn occluded(&self, scene: Handle, valid: &Valid, packet: &mut RayHitPacket) {
        // SAFETY: as for `nearest`; the packet begins with its rays, and nothing else is read or written.
        unsafe {
            match *self {
                Self::Three { occluded, .. } => occluded(valid, scene, &mut { Context3::COHERENT }, packet),
                Self::Four { occluded, .. } => occluded(valid, scene, packet, &mut { Arguments4::COHERENT }),
            }
        }
    }
}

impl Context3 {
    const INCOHERENT: Self = Self { flags: 0, filter: None, instance: u32::MAX };
    const COHERENT: Self = Self { flags: COHERENT_3, ..Self::INCOHERENT };
}

impl Arguments4 {
    const INCOHERENT: Self =
        Self { flags: 0, features: u32::MAX, context: ptr::null_mut(), filter: None, callback: ptr::null() };
    const COHERENT: Self = Self { flags: COHERENT_4, ..Self::INCOHERENT };
}

#[cfg(test)]
mod tests {
    use std::mem::offset_of;

    use super::*;

    /// Numbers from `rtcore_common.h`.
    #[test]
    fn arguments_are_laid_out_as_embree_reads_them() {
        assert_eq!((size_of::<Context3>(), offset_of!(Context3, filter), offset_of!(Context3, instance)), (24, 8, 16));
        assert_eq!((size_of::<Arguments4>(), offset_of!(Arguments4, context)), (32, 8));
        assert_eq!((offset_of!(Arguments4, filter), offset_of!(Arguments4, callback)), (16, 24));
    }
}
