use std::env;
use std::ffi::{CStr, CString, c_char, c_void};
use std::fs;
use std::mem::ManuallyDrop;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use libloading::Library;

use super::filter::Filter;
use super::point_query::{PointQuery, QueryContext, QueryFunction};
use super::trace::Trace;
use super::{Error, Handle};
use crate::packet::{HALF, WIDTH};

/// Embree with a device of its own.
#[derive(Debug)]
pub struct Embree {
    pub(super) functions: Functions,
    pub(super) trace: Trace,
    pub(super) device: Handle,
    version: [u32; 3],
    /// Whether the processor traces packets of sixteen rays as such.
    pub(super) is_sixteen: bool,
    /// Never unloaded: its build threads may still be ending after the device is released.
    _library: ManuallyDrop<Library>,
}

/// Functions that are the same in both versions.
#[derive(Clone, Copy, Debug)]
pub(super) struct Functions {
    pub(super) new_device: unsafe extern "C" fn(*const c_char) -> Option<Handle>,
    pub(super) release_device: unsafe extern "C" fn(Handle),
    pub(super) device_property: unsafe extern "C" fn(Handle, i32) -> isize,
    pub(super) device_error: unsafe extern "C" fn(Option<Handle>) -> i32,
    pub(super) new_scene: unsafe extern "C" fn(Handle) -> Option<Handle>,
    pub(super) release_scene: unsafe extern "C" fn(Handle),
    pub(super) set_scene_quality: unsafe extern "C" fn(Handle, i32),
    pub(super) set_scene_flags: unsafe extern "C" fn(Handle, i32),
    pub(super) commit_scene: unsafe extern "C" fn(Handle),
    pub(super) attach_geometry: unsafe extern "C" fn(Handle, Handle) -> u32,
    pub(super) new_geometry: unsafe extern "C" fn(Handle, i32) -> Option<Handle>,
    pub(super) release_geometry: unsafe extern "C" fn(Handle),
    pub(super) set_geometry_quality: unsafe extern "C" fn(Handle, i32),
    pub(super) set_shared_buffer: unsafe extern "C" fn(Handle, i32, u32, i32, *const c_void, usize, usize, usize),
    pub(super) set_intersect_filter: unsafe extern "C" fn(Handle, Option<Filter>),
    pub(super) set_occluded_filter: unsafe extern "C" fn(Handle, Option<Filter>),
    pub(super) set_user_data: unsafe extern "C" fn(Handle, *const c_void),
    pub(super) commit_geometry: unsafe extern "C" fn(Handle),
    pub(super) point_query:
        unsafe extern "C" fn(Handle, *mut PointQuery, *mut QueryContext, Option<QueryFunction>, *mut c_void) -> bool,
}

/// `RTC_DEVICE_PROPERTY_VERSION`.
const VERSION: i32 = 0;

/// `RTC_DEVICE_PROPERTY_NATIVE_RAY16_SUPPORTED`.
const NATIVE_RAY16_SUPPORTED: i32 = 34;

/// File names of the supported versions, the newest first.
const FILE_NAMES: [&str; 2] = ["libembree4.so.4", "libembree3.so.3"];

impl Embree {
    /// Loads the library at `path`, or else the newest that is found, with `threads` threads to build with. Those of the
    /// system's search path are found, and those of the Python package `embreex`.
    ///
    /// # Errors
    /// If there is none, or if its version is neither 3 nor 4.
    pub fn load(path: Option<&Path>, threads: usize) -> Result<Arc<Self>, Error> {
        let paths = path.map_or_else(installed, |path| vec![path.to_owned()]);
        let mut newest: Option<Self> = None;
        let mut failure = None;
        for path in &paths {
            // SAFETY: loading runs the library's initialisers, which for Embree touch nothing of ours.
            let Ok(library) = (unsafe { Library::new(path) }) else { continue };
            match Self::new(library, threads) {
                Ok(found) if newest.as_ref().is_none_or(|newest| newest.version < found.version) => {
                    newest = Some(found);
                }
                Ok(_) => {}
                Err(Error::Unusable { cause, .. }) => failure = Some(Error::Unusable { path: path.clone(), cause }),
                Err(error) => failure = Some(error),
            }
        }
        newest.map(Arc::new).ok_or_else(|| {
            let tried: Vec<String> = paths.iter().map(|path| path.display().to_string()).collect();
            failure.unwrap_or(Error::NotFound { tried: tried.join(", ") })
        })
    }

    fn new(library: Library, threads: usize) -> Result<Self, Error> {
        let unusable = |cause| Error::Unusable { path: PathBuf::new(), cause };
        let functions = Functions::find(&library).map_err(|error| unusable(error.to_string()))?;
        let settings = CString::new(format!("threads={threads}")).map_err(|error| unusable(error.to_string()))?;
        // SAFETY: the text ends with a zero. The device is released once, in `drop`.
        let (device, version, is_sixteen) = unsafe {
            let Some(device) = (functions.new_device)(settings.as_ptr()) else {
                return Err(Error::Failed { what: "make a device", code: (functions.device_error)(None) });
            };
            let property = |number| (functions.device_property)(device, number);
            (device, property(VERSION) as u32, property(NATIVE_RAY16_SUPPORTED) != 0)
        };
        let version = [version / 10_000, version / 100 % 100, version % 100];
        let trace = Trace::find(&library, version[0], is_sixteen);
        match trace {
            Ok(trace) => {
                Ok(Self { functions, trace, device, version, is_sixteen, _library: ManuallyDrop::new(library) })
            }
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

    /// The number of rays that the processor traces at a time: 16 with AVX-512, else 8.
    #[must_use]
    pub fn packet_width(&self) -> usize {
        if self.is_sixteen { WIDTH } else { HALF }
    }

    /// Returns the device's last error, if there was one since the last call.
    pub(super) fn check(&self, what: &'static str) -> Result<(), Error> {
        // SAFETY: the device lives as long as `self`.
        match unsafe { (self.functions.device_error)(Some(self.device)) } {
            0 => Ok(()),
            code => Err(Error::Failed { what, code }),
        }
    }
}

/// Names for the system's search path, and the libraries in Python's package `embreex`, which may not exist.
fn installed() -> Vec<PathBuf> {
    let environments = [("VIRTUAL_ENV", "lib"), ("HOME", ".local/lib")];
    let of_user = environments.into_iter().filter_map(|(name, lib)| Some(Path::new(&env::var_os(name)?).join(lib)));
    let pythons =
        of_user.chain(["/usr/local/lib", "/usr/lib"].map(PathBuf::from)).flat_map(|lib| beginning(&lib, "python3"));
    let packages = pythons.flat_map(|python| ["site-packages", "dist-packages"].map(|name| python.join(name)));
    let libraries = packages.flat_map(|package| beginning(&package.join("embreex.libs"), "libembree"));
    FILE_NAMES.map(PathBuf::from).into_iter().chain(libraries).collect()
}

/// Paths in a folder whose names begin with a text; none if it can't be read.
fn beginning(folder: &Path, text: &str) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let named = entries.filter(|entry| entry.file_name().to_string_lossy().starts_with(text));
    named.map(|entry| entry.path()).collect()
}

impl Functions {
    fn find(library: &Library) -> Result<Self, libloading::Error> {
        /// Looks up a function by name, as type `F`.
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
            point_query: named(library, c"rtcPointQuery")?,
        })
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
