use std::ffi::c_void;

use umbrage_rays::Opacity as _;
use umbrage_scene::{Frame, FrameOpacity};

use crate::posed::Asked;

/// `RTCFilterFunctionN`.
pub(super) type Filter = unsafe extern "C" fn(*const FilterArguments);

/// `RTCFilterFunctionNArguments`.
#[repr(C)]
pub(super) struct FilterArguments {
    valid: *mut i32,
    geometry_user_data: *const c_void,
    context: *mut c_void,
    ray: *mut c_void,
    hit: *const c_void,
    width: u32,
}

/// Refuses hits at points that an alpha mask has cut away.
pub(super) unsafe extern "C" fn keep_solid(arguments: *const FilterArguments) {
    // SAFETY: Embree calls this with arguments that are valid for the call.
    unsafe { keep(arguments, Frame::camera_opacity) }
}

/// Refuses hits at points that cast no shadow.
pub(super) unsafe extern "C" fn keep_casting(arguments: *const FilterArguments) {
    // SAFETY: Embree calls this with arguments that are valid for the call.
    unsafe { keep(arguments, Frame::shadow_opacity) }
}

/// Clears the flags of hits at which, by `opacity`, the triangle lets the ray pass.
///
/// # Safety
/// `arguments` and the pointers in it must be valid, with the [`Asked`] of a posed frame as the geometry's user data.
unsafe fn keep(arguments: *const FilterArguments, opacity: impl Fn(&Frame) -> FrameOpacity<'_>) {
    // SAFETY: the caller's. A hit packet of N rays has arrays of N numbers: three of normals, u, v and ids.
    unsafe {
        let FilterArguments { valid, geometry_user_data, hit, width, .. } = *arguments;
        let Asked { frame, ids, .. } = &*geometry_user_data.cast::<Asked>();
        let (width, opacity) = (width as usize, opacity(frame));
        let (weights, primitives) = (hit.cast::<f32>(), hit.cast::<u32>());
        for lane in (0..width).filter(|&lane| *valid.add(lane) != 0) {
            let weights = [*weights.add(3 * width + lane), *weights.add(4 * width + lane)];
            let primitive = *primitives.add(5 * width + lane) as usize;
            if !opacity.stops(ids[primitive], weights) {
                *valid.add(lane) = 0;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::mem::offset_of;

    use super::*;

    /// Numbers from `rtcore_common.h`.
    #[test]
    fn arguments_are_laid_out_as_embree_reads_them() {
        assert_eq!((size_of::<FilterArguments>(), offset_of!(FilterArguments, hit)), (48, 32));
        assert_eq!(offset_of!(FilterArguments, width), 40);
    }
}
