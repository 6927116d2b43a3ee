use std::ffi::c_void;
use std::ptr;

use libloading::Library;

use super::Handle;
use super::filter::Filter;
use crate::packet::{HALF, HalfPacket, RayHitPacket, SingleRay, Valid, ValidHalf};

/// The functions whose arguments depend on the version.
#[derive(Clone, Copy, Debug)]
pub(super) enum Trace {
    Three {
        wide: Wide<unsafe extern "C" fn(*const c_void, Handle, *mut Context3, *mut c_void)>,
        intersect_one: unsafe extern "C" fn(Handle, *mut Context3, *mut SingleRay),
    },
    Four {
        wide: Wide<unsafe extern "C" fn(*const c_void, Handle, *mut c_void, *mut Arguments4)>,
        intersect_one: unsafe extern "C" fn(Handle, *mut SingleRay, *mut Arguments4),
    },
}

/// Functions for packets of as many rays as the processor traces at a time: [`Valid`] and [`RayHitPacket`], or
/// [`ValidHalf`] and [`HalfPacket`].
#[derive(Clone, Copy, Debug)]
pub(super) struct Wide<F> {
    intersect: F,
    occluded: F,
}

impl<F: Copy> Wide<F> {
    /// # Safety
    /// `F` must be the functions' type.
    unsafe fn find(library: &Library, is_sixteen: bool) -> Result<Self, libloading::Error> {
        let (intersect, occluded) =
            if is_sixteen { (c"rtcIntersect16", c"rtcOccluded16") } else { (c"rtcIntersect8", c"rtcOccluded8") };
        // SAFETY: the caller's promise, and the library outlives the functions: both are in `Embree`.
        unsafe {
            Ok(Self {
                intersect: *library.get(intersect.to_bytes_with_nul())?,
                occluded: *library.get(occluded.to_bytes_with_nul())?,
            })
        }
    }
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
    /// The functions of version `major` for packets of sixteen rays or eight, or the reason why there are none.
    pub(super) fn find(library: &Library, major: u32, is_sixteen: bool) -> Result<Self, String> {
        // SAFETY: the types are those of the version's headers, and the library outlives the functions: both are in
        // `Embree`.
        let found = unsafe {
            let intersect_one = c"rtcIntersect1".to_bytes_with_nul();
            match major {
                3 => Wide::find(library, is_sixteen)
                    .and_then(|wide| Ok(Self::Three { wide, intersect_one: *library.get(intersect_one)? })),
                4 => Wide::find(library, is_sixteen)
                    .and_then(|wide| Ok(Self::Four { wide, intersect_one: *library.get(intersect_one)? })),
                _ => return Err(format!("Embree {major} is neither 3 nor 4")),
            }
        };
        found.map_err(|error| error.to_string())
    }

    /// Finds the nearest hits of the `valid` rays, all at a time if the functions are for sixteen.
    ///
    /// # Safety
    /// The scene must be a committed one of the same library, and `is_sixteen` as it was in [`Trace::find`].
    #[inline]
    pub(super) unsafe fn nearest(&self, scene: Handle, valid: &Valid, packet: &mut RayHitPacket, is_sixteen: bool) {
        // SAFETY: the scene is the caller's promise; packets and arguments have the header's layouts.
        let trace = |valid: *const c_void, packet: *mut c_void| unsafe {
            match *self {
                Self::Three { wide, .. } => (wide.intersect)(valid, scene, &mut { Context3::COHERENT }, packet),
                Self::Four { wide, .. } => (wide.intersect)(valid, scene, packet, &mut { Arguments4::COHERENT }),
            }
        };
        whole_or_halves(valid, packet, is_sixteen, trace);
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
    pub(super) unsafe fn occluded(&self, scene: Handle, valid: &Valid, packet: &mut RayHitPacket, is_sixteen: bool) {
        // SAFETY: as for `nearest`; the packet begins with its rays, and nothing else is read or written.
        let trace = |valid: *const c_void, packet: *mut c_void| unsafe {
            match *self {
                Self::Three { wide, .. } => (wide.occluded)(valid, scene, &mut { Context3::COHERENT }, packet),
                Self::Four { wide, .. } => (wide.occluded)(valid, scene, packet, &mut { Arguments4::COHERENT }),
            }
        };
        whole_or_halves(valid, packet, is_sixteen, trace);
    }
}

/// Calls `trace` with a packet's flags and rays, or with those of each half that has any.
#[inline(always)]
fn whole_or_halves(
    valid: &Valid,
    packet: &mut RayHitPacket,
    is_sixteen: bool,
    trace: impl Fn(*const c_void, *mut c_void),
) {
    if is_sixteen {
        return trace(ptr::from_ref(valid).cast(), ptr::from_mut(packet).cast());
    }
    for first in [0, HALF] {
        let valid = ValidHalf::of(valid, first);
        if !valid.is_empty() {
            let mut half = HalfPacket::of(packet, first);
            trace(ptr::from_ref(&valid).cast(), ptr::from_mut(&mut half).cast());
            half.store(packet, first);
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
