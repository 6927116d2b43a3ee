use std::ffi::c_void;
use std::ptr;

use glam::Vec3;

use crate::posed::Posed;

/// `RTCPointQuery`.
#[repr(C, align(16))]
pub(super) struct PointQuery {
    position: [f32; 3],
    time: f32,
    radius: f32,
}

/// `RTCPointQueryContext` without instances. Libraries with arrays of instances have one more number before the stack's
/// size, so all that follows is zero.
#[repr(C, align(16))]
pub(super) struct QueryContext {
    matrices: [[f32; 16]; 2],
    instance: u32,
    stack_size: [u32; 2],
}

/// `RTCPointQueryFunctionArguments`.
#[repr(C, align(16))]
pub(super) struct QueryArguments {
    query: *mut PointQuery,
    user: *mut c_void,
    primitive: u32,
    geometry: u32,
    context: *mut QueryContext,
    similarity_scale: f32,
}

/// `RTCPointQueryFunction`.
pub(super) type QueryFunction = unsafe extern "C" fn(*mut QueryArguments) -> bool;

/// `rtcPointQuery`, with the scene's handle bound.
type Ask<'a> = &'a dyn Fn(*mut PointQuery, *mut QueryContext, QueryFunction, *mut c_void);

/// The nearest triangle so far.
struct Nearest<'a> {
    posed: &'a Posed,
    name: u32,
}

/// Finds the name of the triangle that is nearest to a point, and its distance; `None` without triangles.
pub(super) fn closest(posed: &Posed, point: Vec3, ask: Ask<'_>) -> Option<(u32, f32)> {
    let mut nearest = Nearest { posed, name: u32::MAX };
    let mut query = PointQuery { position: point.to_array(), time: 0.0, radius: f32::INFINITY };
    let mut context = QueryContext { matrices: [[0.0; 16]; 2], instance: u32::MAX, stack_size: [0; 2] };
    ask(&mut query, &mut context, visit, ptr::from_mut(&mut nearest).cast());
    (nearest.name != u32::MAX).then_some((nearest.name, query.radius))
}

/// Makes the query's radius smaller if a triangle is nearer than that.
unsafe extern "C" fn visit(arguments: *mut QueryArguments) -> bool {
    // SAFETY: Embree passes the query and the pointer of `closest`, and nobody else has them meanwhile.
    let (primitive, geometry, query, nearest) = unsafe {
        let arguments = &*arguments;
        let nearest = &mut *arguments.user.cast::<Nearest<'_>>();
        (arguments.primitive, arguments.geometry, &mut *arguments.query, nearest)
    };
    let Nearest { posed, name } = nearest;
    let indices = posed.asked().filter(|_| geometry == 1).map_or(posed.opaque(), |asked| &asked.indices);
    let corners = indices[primitive as usize].map(|vertex| posed.positions()[vertex as usize]);
    let point = Vec3::from_array(query.position);
    let distance = closest_on_triangle(point, corners).distance(point);
    if distance >= query.radius {
        return false;
    }
    query.radius = distance;
    *name = Posed::name(primitive, geometry);
    true
}

/// The nearest point of a triangle, as in Embree's tutorial `closest_point` (Ericson, *Real-Time Collision Detection*, 2005,
/// section 5.1.5).
#[inline(always)]
fn closest_on_triangle(p: Vec3, [a, b, c]: [Vec3; 3]) -> Vec3 {
    let (ab, ac, ap) = (b - a, c - a, p - a);
    let (d1, d2) = (ab.dot(ap), ac.dot(ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return a;
    }
    let bp = p - b;
    let (d3, d4) = (ab.dot(bp), ac.dot(bp));
    if d3 >= 0.0 && d4 <= d3 {
        return b;
    }
    let cp = p - c;
    let (d5, d6) = (ab.dot(cp), ac.dot(cp));
    if d6 >= 0.0 && d5 <= d6 {
        return c;
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return a + ab * (d1 / (d1 - d3));
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return a + ac * (d2 / (d2 - d6));
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0 {
        return b + (c - b) * ((d4 - d3) / ((d4 - d3) + (d5 - d6)));
    }
    let scale = 1.0 / (va + vb + vc);
    a + ab * (vb * scale) + ac * (vc * scale)
}

#[cfg(test)]
mod tests {
    use std::mem::offset_of;

    use super::*;

    /// Numbers from `rtcore_common.h`.
    #[test]
    fn queries_are_laid_out_as_embree_reads_them() {
        assert_eq!((size_of::<PointQuery>(), offset_of!(PointQuery, radius)), (32, 16));
        assert_eq!((size_of::<QueryContext>(), offset_of!(QueryContext, instance)), (144, 128));
        assert_eq!((offset_of!(QueryArguments, user), offset_of!(QueryArguments, primitive)), (8, 16));
        assert_eq!((offset_of!(QueryArguments, context), offset_of!(QueryArguments, similarity_scale)), (24, 32));
    }
}
