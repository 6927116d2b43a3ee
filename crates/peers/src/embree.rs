//! Embree, through the functions of its shared library: versions 3 and 4.
//!
//! # Safety
//! Everything unsafe of this crate is here, for three reasons. Functions are looked up by name and given the types of
//! the headers `rtcore_*.h`; the two versions differ in the two functions that trace, and which one it is the library
//! itself says. Buffers are shared, not copied: a [`Scene`] keeps the [`Posed`] that owns them, unchanged behind an
//! [`Arc`], until its geometry is given other ones or released; indices were checked, and positions have the padding
//! that 16-byte reads need. Packets have the layouts of the headers, which tests compare with the headers' numbers.
//!
//! Embree's manual recommends to trace with denormal numbers taken for zero. Calls that switched to that mode and back
//! took as long as others (within 1 % on the gallery's cloth and shatter), so the mode is left as Rust needs it.
#![allow(unsafe_code, reason = "calls a C library")]

use std::ffi::{CStr, CString, c_char, c_void};
use std::mem::ManuallyDrop;
use std::path::{Path, PathBuf};
use std::ptr::{self, NonNull};
use std::sync::Arc;

use libloading::Library;
use umbrage_scene::Frame;

use crate::packet::{RayHitPacket, RayPacket, Valid};
use crate::posed::{Asked, Posed};

type Handle = NonNull<c_void>;
type Filter = unsafe extern "C" fn(*const FilterArguments);

/// Why Embree can't be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// No library was found.
    #[error(
        "Embree is not installed (tried {tried}): install Debian's package libembree-dev, or name a library with \
         --embree PATH or the environment variable UMBRAGE_EMBREE"
    )]
    NotFound {
        /// File names and paths.
        tried: String,
    },
    /// The library is not one that is known.
    #[error("{}: {cause}", path.display())]
    Unusable {
        /// The library.
        path: PathBuf,
        /// What it lacks.
        cause: String,
    },
    /// Embree reports an error.
    #[error("Embree could not {what}: error {code}")]
    Failed {
        /// What was tried.
        what: &'static str,
        /// `RTCError`.
        code: i32,
    },
    /// A triangle that Embree must not be given.
    #[error("triangle {triangle} has a vertex that is out of range")]
    IndexOutOfRange {
        /// Its id.
        triangle: usize,
    },
}

/// Embree with a device of its own.
#[derive(Debug)]
pub struct Embree {
    functions: Functions,
    trace: Trace,
    device: Handle,
    version: [u32; 3],
    /// Never unloaded: its build threads may still be on their way out when the device is gone.
    _library: ManuallyDrop<Library>,
}

/// How a scene is built anew for each frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BuildMethod {
    /// What the hierarchy is built with.
    pub quality: Quality,
    /// Whether the scene is a dynamic one that is kept, so that its memory is used again; else it is a new one.
    pub kept: bool,
}

/// What a hierarchy is built with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quality {
    /// By Morton codes.
    Low,
    /// By the binned surface area heuristic.
    Medium,
}

/// Embree's hierarchy over a frame's triangles.
#[derive(Debug)]
pub struct Scene {
    embree: Arc<Embree>,
    method: BuildMethod,
    built: Option<Built>,
}

#[derive(Debug)]
struct Built {
    scene: Handle,
    opaque: Handle,
    /// The triangles that are asked about, where there are any.
    asked: Option<Handle>,
    posed: Arc<Posed>,
}

#[derive(Clone, Copy, Debug)]
struct Functions {
    new_device: unsafe extern "C" fn(*const c_char) -> Option<Handle>,
    release_device: unsafe extern "C" fn(Handle),
    device_property: unsafe extern "C" fn(Handle, i32) -> isize,
    device_error: unsafe extern "C" fn(Option<Handle>) -> i32,
    new_scene: unsafe extern "C" fn(Handle) -> Option<Handle>,
    release_scene: unsafe extern "C" fn(Handle),
    set_scene_quality: unsafe extern "C" fn(Handle, i32),
    set_scene_flags: unsafe extern "C" fn(Handle, i32),
    commit_scene: unsafe extern "C" fn(Handle),
    attach_geometry: unsafe extern "C" fn(Handle, Handle) -> u32,
    new_geometry: unsafe extern "C" fn(Handle, i32) -> Option<Handle>,
    release_geometry: unsafe extern "C" fn(Handle),
    set_geometry_quality: unsafe extern "C" fn(Handle, i32),
    set_shared_buffer: unsafe extern "C" fn(Handle, i32, u32, i32, *const c_void, usize, usize, usize),
    set_intersect_filter: unsafe extern "C" fn(Handle, Option<Filter>),
    set_occluded_filter: unsafe extern "C" fn(Handle, Option<Filter>),
    set_user_data: unsafe extern "C" fn(Handle, *const c_void),
    commit_geometry: unsafe extern "C" fn(Handle),
}

/// The two functions whose arguments depend on the version.
#[derive(Clone, Copy, Debug)]
enum Trace {
    Three {
        intersect: unsafe extern "C" fn(*const Valid, Handle, *mut Context3, *mut RayHitPacket),
        occluded: unsafe extern "C" fn(*const Valid, Handle, *mut Context3, *mut RayPacket),
    },
    Four {
        intersect: unsafe extern "C" fn(*const Valid, Handle, *mut RayHitPacket, *mut Arguments4),
        occluded: unsafe extern "C" fn(*const Valid, Handle, *mut RayPacket, *mut Arguments4),
    },
}

/// `RTCIntersectContext` of Embree 3.
#[repr(C)]
struct Context3 {
    flags: i32,
    filter: Option<Filter>,
    instance: u32,
}

/// `RTCIntersectArguments` and `RTCOccludedArguments` of Embree 4.
#[repr(C)]
struct Arguments4 {
    flags: i32,
    features: u32,
    context: *mut c_void,
    filter: Option<Filter>,
    callback: *const c_void,
}

/// `RTCFilterFunctionNArguments`.
#[repr(C)]
struct FilterArguments {
    valid: *mut i32,
    geometry_user_data: *const c_void,
    context: *mut c_void,
    ray: *mut c_void,
    hit: *const c_void,
    width: u32,
}

const VERSION: i32 = 0;
const TRIANGLE: i32 = 0;
const INDEX_BUFFER: i32 = 0;
const VERTEX_BUFFER: i32 = 1;
const FORMAT_UINT3: i32 = 0x5003;
const FORMAT_FLOAT3: i32 = 0x9003;
const DYNAMIC: i32 = 1;
const COHERENT_3: i32 = 1;
const COHERENT_4: i32 = 1 << 16;

/// File names of the versions that are known, the newest first.
const FILE_NAMES: [&str; 2] = ["libembree4.so.4", "libembree3.so.3"];

impl Embree {
    /// Loads the library at `path`, or else one that the system knows, with `threads` threads to build with.
    ///
    /// # Errors
    /// If there is none, or it isn't version 3 or 4.
    pub fn load(path: Option<&Path>, threads: usize) -> Result<Arc<Self>, Error> {
        let paths = path.map_or_else(|| FILE_NAMES.map(PathBuf::from).to_vec(), |path| vec![path.to_owned()]);
        for path in &paths {
            // SAFETY: loading runs the library's initialisers, which for Embree touch nothing of ours.
            if let Ok(library) = unsafe { Library::new(path) } {
                return Self::new(library, threads).map(Arc::new).map_err(|error| match error {
                    Error::Unusable { cause, .. } => Error::Unusable { path: path.clone(), cause },
                    error => error,
                });
            }
        }
        let tried: Vec<String> = paths.iter().map(|path| path.display().to_string()).collect();
        Err(Error::NotFound { tried: tried.join(", ") })
    }

    fn new(library: Library, threads: usize) -> Result<Self, Error> {
        let unusable = |cause| Error::Unusable { path: PathBuf::new(), cause };
        let functions = Functions::find(&library).map_err(|error| unusable(error.to_string()))?;
        let settings = CString::new(format!("threads={threads}")).map_err(|error| unusable(error.to_string()))?;
        // SAFETY: the text ends with a zero. The device is released once, in `drop`.
        let (device, version) = unsafe {
            let Some(device) = (functions.new_device)(settings.as_ptr()) else {
                return Err(Error::Failed { what: "make a device", code: (functions.device_error)(None) });
            };
            (device, (functions.device_property)(device, VERSION) as u32)
        };
        let version = [version / 10_000, version / 100 % 100, version % 100];
        let trace = Trace::find(&library, version[0]);
        match trace {
            Ok(trace) => Ok(Self { functions, trace, device, version, _library: ManuallyDrop::new(library) }),
            Err(cause) => {
                // SAFETY: nothing else knows the device.
                unsafe { (functions.release_device)(device) };
                Err(unusable(cause))
            }
        }
    }

    /// Major, minor and patch number.
    #[must_use]
    pub fn version(&self) -> [u32; 3] {
        self.version
    }

    fn check(&self, what: &'static str) -> Result<(), Error> {
        // SAFETY: the device lives as long as `self`.
        match unsafe { (self.functions.device_error)(Some(self.device)) } {
            0 => Ok(()),
            code => Err(Error::Failed { what, code }),
        }
    }
}

impl Functions {
    fn find(library: &Library) -> Result<Self, libloading::Error> {
        /// The function of a name, as the type that is asked for.
        fn named<F: Copy>(library: &Library, name: &CStr) -> Result<F, libloading::Error> {
            // SAFETY: the caller's type is the header's, and the library outlives the function: both are in `Embree`.
            unsafe { library.get::<F>(name.to_bytes_with_nul()).map(|symbol| *symbol) }
        }
        Ok(Self {
            new_device: named(library, c"rtcNewDevice")?,
            release_device: named(library, c"rtcReleaseDevice")?,
            device_property: named(library, c"rtcGetDeviceProperty")?,
            device_error: named(library, c"rtcGetDeviceError")?,
            new_scene: named(library, c"rtcNewScene")?,
            release_scene: named(library, c"rtcReleaseScene")?,
            set_scene_quality: named(library, c"rtcSetSceneBuildQuality")?,
            set_scene_flags: named(library, c"rtcSetSceneFlags")?,
            commit_scene: named(library, c"rtcCommitScene")?,
            attach_geometry: named(library, c"rtcAttachGeometry")?,
            new_geometry: named(library, c"rtcNewGeometry")?,
            release_geometry: named(library, c"rtcReleaseGeometry")?,
            set_geometry_quality: named(library, c"rtcSetGeometryBuildQuality")?,
            set_shared_buffer: named(library, c"rtcSetSharedGeometryBuffer")?,
            set_intersect_filter: named(library, c"rtcSetGeometryIntersectFilterFunction")?,
            set_occluded_filter: named(library, c"rtcSetGeometryOccludedFilterFunction")?,
            set_user_data: named(library, c"rtcSetGeometryUserData")?,
            commit_geometry: named(library, c"rtcCommitGeometry")?,
        })
    }
}

impl Trace {
    /// The functions as version `major` has them, or why there are none.
    fn find(library: &Library, major: u32) -> Result<Self, String> {
        // SAFETY: the types are those of the version's headers, and the library outlives the functions: both are in
        // `Embree`.
        let found = unsafe {
            let (intersect, occluded) = (c"rtcIntersect16".to_bytes_with_nul(), c"rtcOccluded16".to_bytes_with_nul());
            match major {
                3 => library
                    .get(intersect)
                    .and_then(|intersect| Ok(Self::Three { intersect: *intersect, occluded: *library.get(occluded)? })),
                4 => library
                    .get(intersect)
                    .and_then(|intersect| Ok(Self::Four { intersect: *intersect, occluded: *library.get(occluded)? })),
                _ => return Err(format!("Embree {major} is neither 3 nor 4")),
            }
        };
        found.map_err(|error| error.to_string())
    }
}

// SAFETY: Embree's devices may be used by many threads at once.
unsafe impl Send for Embree {}
// SAFETY: as above.
unsafe impl Sync for Embree {}

impl Drop for Embree {
    fn drop(&mut self) {
        // SAFETY: scenes hold an `Arc` of this, so none is left.
        unsafe { (self.functions.release_device)(self.device) }
    }
}

// SAFETY: many threads may trace through a scene at once; what changes it takes `&mut self`.
unsafe impl Send for Scene {}
// SAFETY: as above.
unsafe impl Sync for Scene {}

impl Scene {
    /// A scene without triangles.
    #[must_use]
    pub fn new(embree: &Arc<Embree>, method: BuildMethod) -> Self {
        Self { embree: Arc::clone(embree), method, built: None }
    }

    /// Releases what the next build makes anew, so that it needn't be timed there; nothing for a scene that is kept.
    pub fn clear(&mut self) {
        if !self.method.kept {
            self.release();
        }
    }

    /// Builds the hierarchy over a frame's triangles, on Embree's own threads.
    ///
    /// # Errors
    /// Where Embree reports one; the scene is then empty.
    pub fn build(&mut self, posed: &Arc<Posed>) -> Result<(), Error> {
        self.clear();
        if self.built.as_ref().is_some_and(|built| built.asked.is_some() != posed.asked().is_some()) {
            self.release();
        }
        if self.built.is_none() {
            self.built = Some(self.make(posed)?);
        }
        let functions = &self.embree.functions;
        if let Some(built) = &mut self.built {
            let positions = posed.positions();
            // SAFETY: the handles are alive. The buffers have as many items as is said and are kept by `built.posed`, as
            // is what the filters are given; old ones are released only after Embree was given these.
            unsafe {
                let share = |geometry, indices: &[[u32; 3]]| {
                    let share = functions.set_shared_buffer;
                    let (vertices, corners) = (positions.as_ptr().cast(), indices.as_ptr().cast());
                    share(geometry, VERTEX_BUFFER, 0, FORMAT_FLOAT3, vertices, 0, 12, positions.len());
                    share(geometry, INDEX_BUFFER, 0, FORMAT_UINT3, corners, 0, 12, indices.len());
                };
                share(built.opaque, posed.opaque());
                (functions.commit_geometry)(built.opaque);
                if let Some((geometry, asked)) = built.asked.zip(posed.asked()) {
                    share(geometry, &asked.indices);
                    (functions.set_user_data)(geometry, ptr::from_ref(asked).cast());
                    (functions.commit_geometry)(geometry);
                }
                (functions.commit_scene)(built.scene);
            }
            built.posed = Arc::clone(posed);
        }
        self.embree.check("build a scene").inspect_err(|_| self.release())
    }

    /// An empty scene with one empty geometry or two.
    fn make(&self, posed: &Arc<Posed>) -> Result<Built, Error> {
        let Embree { functions, device, .. } = &*self.embree;
        let quality = match self.method.quality {
            Quality::Low => 0,
            Quality::Medium => 1,
        };
        let failed =
            || self.embree.check("make a scene").err().unwrap_or(Error::Failed { what: "make a scene", code: 0 });
        // SAFETY: the device is alive. The handles are released once: those of `Built` in `release`, and others here.
        unsafe {
            let scene = (functions.new_scene)(*device).ok_or_else(failed)?;
            let geometry = || {
                let geometry = (functions.new_geometry)(*device, TRIANGLE)?;
                (functions.set_geometry_quality)(geometry, quality);
                (functions.attach_geometry)(scene, geometry);
                Some(geometry)
            };
            let opaque = geometry();
            let asked = if posed.asked().is_some() { geometry().map(Some) } else { Some(None) };
            let Some((opaque, asked)) = opaque.zip(asked) else {
                // The scene holds what is attached to it.
                opaque.into_iter().chain(asked.flatten()).for_each(|geometry| (functions.release_geometry)(geometry));
                (functions.release_scene)(scene);
                return Err(failed());
            };
            if let Some(asked) = asked {
                (functions.set_intersect_filter)(asked, Some(keep_solid));
                (functions.set_occluded_filter)(asked, Some(keep_casting));
            }
            (functions.set_scene_quality)(scene, quality);
            (functions.set_scene_flags)(scene, if self.method.kept { DYNAMIC } else { 0 });
            Ok(Built { scene, opaque, asked, posed: Arc::clone(posed) })
        }
    }

    fn release(&mut self) {
        if let Some(Built { scene, opaque, asked, .. }) = self.built.take() {
            let functions = &self.embree.functions;
            // SAFETY: each handle is released once; nobody traces through them, since this has `&mut self`.
            unsafe {
                [opaque].into_iter().chain(asked).for_each(|geometry| (functions.release_geometry)(geometry));
                (functions.release_scene)(scene);
            }
        }
    }

    /// Finds the nearest hits of the rays that are `valid`; rays that hit nothing keep what they had.
    #[inline]
    pub fn nearest(&self, valid: &Valid, packet: &mut RayHitPacket) {
        let Some(Built { scene, .. }) = self.built else { return };
        // SAFETY: the scene was committed, and the packet has the header's layout.
        unsafe {
            match self.embree.trace {
                Trace::Three { intersect, .. } => intersect(valid, scene, &mut { Context3::COHERENT }, packet),
                Trace::Four { intersect, .. } => intersect(valid, scene, packet, &mut { Arguments4::COHERENT }),
            }
        }
    }

    /// Sets `t_far` of the `valid` rays that hit anything to −∞.
    #[inline]
    pub fn occluded(&self, valid: &Valid, packet: &mut RayPacket) {
        let Some(Built { scene, .. }) = self.built else { return };
        // SAFETY: as for `nearest`.
        unsafe {
            match self.embree.trace {
                Trace::Three { occluded, .. } => occluded(valid, scene, &mut { Context3::COHERENT }, packet),
                Trace::Four { occluded, .. } => occluded(valid, scene, packet, &mut { Arguments4::COHERENT }),
            }
        }
    }
}

impl Drop for Scene {
    fn drop(&mut self) {
        self.release();
    }
}

impl Context3 {
    const COHERENT: Self = Self { flags: COHERENT_3, filter: None, instance: u32::MAX };
}

impl Arguments4 {
    const COHERENT: Self =
        Self { flags: COHERENT_4, features: u32::MAX, context: ptr::null_mut(), filter: None, callback: ptr::null() };
}

/// Refuses hits where an alpha mask has cut the triangle away.
unsafe extern "C" fn keep_solid(arguments: *const FilterArguments) {
    // SAFETY: Embree calls this with arguments that are valid for the call.
    unsafe { keep(arguments, Frame::is_solid) }
}

/// Refuses hits on what casts no shadow there.
unsafe extern "C" fn keep_casting(arguments: *const FilterArguments) {
    // SAFETY: Embree calls this with arguments that are valid for the call.
    unsafe { keep(arguments, Frame::casts_shadow) }
}

/// Clears the flags of hits that `counts` refuses, given a triangle and the weights of its second and third corner.
///
/// # Safety
/// `arguments` and what they point to must be valid, with the [`Asked`] of a [`Posed`] as the geometry's user data.
unsafe fn keep(arguments: *const FilterArguments, counts: impl Fn(&Frame, u32, [f32; 2]) -> bool) {
    // SAFETY: the caller's. A hit packet of N rays has arrays of N numbers: three of normals, u, v and ids.
    unsafe {
        let FilterArguments { valid, geometry_user_data, hit, width, .. } = *arguments;
        let Asked { frame, ids, .. } = &*geometry_user_data.cast::<Asked>();
        let width = width as usize;
        let (weights, primitives) = (hit.cast::<f32>(), hit.cast::<u32>());
        for lane in (0..width).filter(|&lane| *valid.add(lane) != 0) {
            let weights = [*weights.add(3 * width + lane), *weights.add(4 * width + lane)];
            let primitive = *primitives.add(5 * width + lane) as usize;
            if !counts(frame, ids[primitive], weights) {
                *valid.add(lane) = 0;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::mem::offset_of;

    use super::*;
    use crate::packet::WIDTH;

    /// Numbers from `rtcore_common.h`.
    #[test]
    fn arguments_are_laid_out_as_embree_reads_them() {
        assert_eq!((size_of::<Context3>(), offset_of!(Context3, filter), offset_of!(Context3, instance)), (24, 8, 16));
        assert_eq!((size_of::<Arguments4>(), offset_of!(Arguments4, context)), (32, 8));
        assert_eq!((offset_of!(Arguments4, filter), offset_of!(Arguments4, callback)), (16, 24));
        assert_eq!((size_of::<FilterArguments>(), offset_of!(FilterArguments, hit)), (48, 32));
        assert_eq!(offset_of!(FilterArguments, width), 40);
        assert_eq!(size_of::<Valid>(), 4 * WIDTH);
    }
}
