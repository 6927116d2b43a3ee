//! tinybvh, through a few C functions that `glue.cpp` beside this file makes of its header; that file says how to
//! compile it.
//!
//! Like Embree, it is loaded when the program runs, so that nothing is built with C++. The crate `tinybvh-rs` isn't
//! used: it has neither tinybvh's fast builder nor its occlusion queries.
//!
//! # Safety
//! As for Embree: functions are looked up by name and have the types of `glue.cpp`, which checks the offsets of a
//! packet's fields. A [`TinyScene`] keeps the positions and the [`Posed`] whose indices its hierarchy reads; indices
//! were checked.
#![allow(unsafe_code, reason = "calls a C++ library")]

use std::ffi::c_void;
use std::mem::ManuallyDrop;
use std::path::Path;
use std::ptr::NonNull;
use std::sync::Arc;

use glam::Vec4;
use libloading::Library;

use crate::Error;
use crate::packet::{RayHitPacket, Valid};
use crate::posed::Posed;

type Handle = NonNull<c_void>;
type Trace = unsafe extern "C" fn(Handle, *const Valid, *mut RayHitPacket);

/// The library.
#[derive(Debug)]
pub struct TinyBvh {
    new: unsafe extern "C" fn(i32) -> Option<Handle>,
    release: unsafe extern "C" fn(Handle),
    build: unsafe extern "C" fn(Handle, *const Vec4, u32, *const [u32; 3], u32),
    nearest: Trace,
    occluded: Trace,
    /// Never unloaded: its build threads live on.
    _library: ManuallyDrop<Library>,
}

/// Layout of its hierarchy.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Layout {
    /// Two children a node: `BVH`, as the fastest builder, `BuildAVX`, makes it.
    Binary,
    /// Eight children a node and leaves of four triangles, tested at once: `BVH8_CPU`, converted from `BVH`.
    Wide,
}

/// tinybvh's hierarchy over a frame's triangles, all of them opaque.
#[derive(Debug)]
pub struct TinyScene {
    library: Arc<TinyBvh>,
    hierarchy: Handle,
    /// Vertices in its form, of 16 bytes.
    positions: Vec<Vec4>,
    posed: Option<Arc<Posed>>,
    /// Whether the hierarchy is that of `posed`.
    is_built: bool,
}

impl TinyBvh {
    /// Loads the library that was compiled from `glue.cpp`.
    ///
    /// # Errors
    /// If it isn't there or lacks a function.
    pub fn load(path: &Path) -> Result<Arc<Self>, Error> {
        let unusable = |error: libloading::Error| Error::Unusable { path: path.to_owned(), cause: error.to_string() };
        // SAFETY: its initialisers touch nothing of ours; the types are those of `glue.cpp`, and the library isn't unloaded.
        unsafe {
            let library = Library::new(path).map_err(unusable)?;
            Ok(Arc::new(Self {
                new: *library.get(b"umbrage_tinybvh_new\0").map_err(unusable)?,
                release: *library.get(b"umbrage_tinybvh_release\0").map_err(unusable)?,
                build: *library.get(b"umbrage_tinybvh_build\0").map_err(unusable)?,
                nearest: *library.get(b"umbrage_tinybvh_nearest\0").map_err(unusable)?,
                occluded: *library.get(b"umbrage_tinybvh_occluded\0").map_err(unusable)?,
                _library: ManuallyDrop::new(library),
            }))
        }
    }
}

// SAFETY: many threads may trace through a hierarchy at once; methods that change it take `&mut self`.
unsafe impl Send for TinyScene {}
// SAFETY: as above.
unsafe impl Sync for TinyScene {}

impl TinyScene {
    /// A scene without triangles.
    ///
    /// # Panics
    /// If there is no memory.
    #[must_use]
    pub fn new(library: &Arc<TinyBvh>, layout: Layout) -> Self {
        // SAFETY: the hierarchy is released once, in `drop`.
        let hierarchy = unsafe { (library.new)(i32::from(layout == Layout::Wide)) };
        let hierarchy = hierarchy.expect("memory for a hierarchy without triangles");
        Self { library: Arc::clone(library), hierarchy, positions: Vec::new(), posed: None, is_built: false }
    }

    /// Copies a frame's triangles: tinybvh reads vertices of 16 bytes.
    ///
    /// # Errors
    /// If there are none, or if some aren't opaque.
    pub fn pose(&mut self, posed: &Arc<Posed>) -> Result<(), Error> {
        (self.posed, self.is_built) = (None, false);
        if posed.opaque().is_empty() || posed.asked().is_some() {
            return Err(Error::NotOpaque);
        }
        self.positions.clear();
        self.positions.extend(posed.positions().iter().map(|position| position.extend(0.0)));
        self.posed = Some(Arc::clone(posed));
        Ok(())
    }

    /// Rebuilds the hierarchy in the memory of the last one; from 50,000 triangles on, with as many threads as there
    /// are cores.
    ///
    /// # Panics
    /// Without triangles.
    pub fn build(&mut self) {
        let triangles = self.posed.as_ref().expect("a frame's triangles").opaque();
        let [vertices, count] = [self.positions.len(), triangles.len()].map(|count| count as u32);
        // SAFETY: positions and triangles are kept as long as the hierarchy reads them; indices are in range.
        unsafe {
            (self.library.build)(self.hierarchy, self.positions.as_ptr(), vertices, triangles.as_ptr(), count);
        }
        self.is_built = true;
    }

    /// Finds the nearest hits of rays, one after the other.
    ///
    /// # Panics
    /// If the hierarchy wasn't built since the last [`Self::pose`].
    #[inline(always)]
    pub fn nearest(&self, valid: &Valid, packet: &mut RayHitPacket) {
        assert!(self.is_built, "build comes first");
        // SAFETY: both are laid out as `glue.cpp` reads them.
        unsafe { (self.library.nearest)(self.hierarchy, valid, packet) }
    }

    /// Sets `t_far` of blocked rays below zero, one after the other.
    ///
    /// # Panics
    /// As above.
    #[inline(always)]
    pub fn occluded(&self, valid: &Valid, packet: &mut RayHitPacket) {
        assert!(self.is_built, "build comes first");
        // SAFETY: as above.
        unsafe { (self.library.occluded)(self.hierarchy, valid, packet) }
    }
}

impl Drop for TinyScene {
    fn drop(&mut self) {
        // SAFETY: it is released only here.
        unsafe { (self.library.release)(self.hierarchy) }
    }
}
