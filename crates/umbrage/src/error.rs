use std::path::PathBuf;

use umbrage_rays::ImageTooLarge;
use umbrage_scene::BadFrame;

use crate::Settings;

/// Why a frame could not be rendered.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The scene could not be posed.
    #[error(transparent)]
    Scene(#[from] umbrage_scene::Error),
    /// A frame that was made by hand is invalid.
    #[error(transparent)]
    Frame(#[from] BadFrame),
    /// The image has more pixels on a side than the structure can sort.
    #[error(transparent)]
    ImageTooLarge(#[from] ImageTooLarge),
    /// The GPU failed, or doesn't support this.
    #[cfg(feature = "gpu")]
    #[error(transparent)]
    Gpu(#[from] umbrage_gpu::GpuError),
    /// There is no light of this index.
    #[error("there is no light {light}: the scene has {lights}, counted from 0")]
    NoSuchLight {
        /// The index asked for, from 0.
        light: usize,
        /// The number of lights.
        lights: usize,
    },
    /// There is no camera of this index.
    #[error("there is no camera {camera}: the scene has {cameras}, counted from 0")]
    NoSuchCamera {
        /// The index asked for, from 0.
        camera: usize,
        /// The number of cameras.
        cameras: usize,
    },
    /// The camera is invalid: your own in [`Settings::camera`], or one made to see all of a scene that is too large.
    #[error("the camera: {0}")]
    Camera(&'static str),
    /// A number of the settings is NaN or infinite.
    #[error("{0} is not a finite number")]
    NotFinite(&'static str),
    /// A side of the image is 0 or longer than [`Settings::MAX_SIDE`].
    #[error("an image of {width}x{height}: each side must be 1 to {limit} pixels", limit = Settings::MAX_SIDE)]
    ImageSize {
        /// Width in pixels.
        width: u32,
        /// Height in pixels.
        height: u32,
    },
    /// The system hasn't as much memory as the picture takes.
    #[error("no memory for a picture of {width}x{height}, which takes about {megabytes} MB")]
    PictureMemory {
        /// Width in pixels.
        width: u32,
        /// Height in pixels.
        height: u32,
        /// Approximate memory in megabytes.
        megabytes: u64,
    },
    /// [`Settings::samples`] is 0 or more than [`Settings::MAX_SAMPLES`].
    #[error("{0} samples a pixel: there must be 1 to {limit}", limit = Settings::MAX_SAMPLES)]
    Samples(u32),
    /// A number of the settings is negative, NaN or infinite.
    #[error("{0} is not a number from 0")]
    NotFromZero(&'static str),
    /// [`Settings::point_size`] or [`Settings::line_width`] is outside [`Settings::MARK_SIZES`].
    #[error("{0} of {1} pixels: there must be {min} to {max}", min = Settings::MARK_SIZES.start(), max = Settings::MARK_SIZES.end())]
    MarkSize(&'static str, f32),
    /// [`Settings::focus`] is not above zero.
    #[error("the focus is not a depth above 0")]
    Focus,
    /// There is nothing to focus on: the middle of the picture is empty, and the scene's middle isn't in front of the
    /// camera.
    #[error("there is nothing to focus on in the middle of the picture: give the focus as a depth")]
    NoFocus,
    /// A camera with parallel rays was given a lens.
    #[error("a parallel camera has no lens: it takes an aperture of 0")]
    ParallelLens,
    /// An open shutter was set for a frame, which is one moment.
    #[error("a frame of your own is one moment: it takes a shutter of 0 seconds")]
    ShutterOfFrame,
    /// Motion was requested for a frame, which is one moment.
    #[error("a frame of your own is one moment: it has no layer of motion")]
    MotionOfFrame,
    /// [`Settings::light_radius`] is more than
    /// [`Light::MAX_SUN_RADIUS_DEGREES`](umbrage_scene::Light::MAX_SUN_RADIUS_DEGREES), and there is a sun.
    #[error("a sun's radius is at most {limit} degrees", limit = umbrage_scene::Light::MAX_SUN_RADIUS_DEGREES)]
    SunRadius,
    /// [`Settings::bounces`] is more than [`Settings::MAX_BOUNCES`].
    #[error("{0} bounces: there must be at most {limit}", limit = Settings::MAX_BOUNCES)]
    Bounces(u32),
    /// The structure can't have these options.
    #[error("{0}")]
    StructureOptions(Box<dyn std::error::Error + Send + Sync>),
    /// The structure can't be made with any options.
    #[error("{0}")]
    Structure(Box<dyn std::error::Error + Send + Sync>),
    /// A call can't wait for a GPU in a browser: [`Renderer::render_async`](crate::Renderer::render_async) gives the
    /// page its turn.
    #[error("in a browser a GPU can't be waited for: await `render_async`")]
    WaitsInBrowser,
    /// The caller stopped the frame: [`Progress::stop`](crate::Progress::stop).
    #[error("the picture was stopped before it was done")]
    Stopped,
    /// A noise target was set, and the GPU has no room for the whole picture at once.
    #[error("this GPU renders so large a picture in parts, and can't tell how noisy it is before it is done")]
    NoiseInBands,
    /// A noise target was set for a texture.
    #[error("how noisy a picture is before it is done is known of films, not of textures")]
    NoiseOfTexture,
    /// Smooth terminators were requested on a GPU.
    #[error("smooth terminators are the CPU's alone")]
    TerminatorOnGpu,
    /// Layers were requested, and the GPU has no room for the whole picture at once.
    #[error("this GPU renders so large a picture in parts, and makes no layers of it")]
    LayersInBands,
    /// A GPU was asked for a structure that is the CPU's alone.
    #[error("a GPU has grids of its own (`listed`, or without a name) and the kd-tree, but not `{0}`")]
    StructureOnGpu(&'static str),
    /// A GPU was asked for a structure with an option that is the CPU's alone.
    #[error("`{0}` on a GPU has no option `{1}`")]
    OptionOnGpu(&'static str, &'static str),
    /// The CPU was asked for a texture.
    #[error("only a GPU renders to a texture")]
    TextureOnCpu,
    /// A GPU was asked for answers without a picture: it finds hits and light masks only while it renders.
    #[error("only the CPU sees and shadows without rendering")]
    AnswersOnGpu,
    /// A GPU was asked to count work.
    #[error("the work of pixels is counted on the CPU alone")]
    CountsOnGpu,
    /// Work was to be counted in a structure that isn't [specialised](crate::Structure::is_specialised).
    #[error("the work of pixels is counted in perspective grids alone")]
    CountsOfStructure,
    /// A background image could not be read.
    #[error("{}: {cause}", path.display())]
    Background {
        /// The file.
        path: PathBuf,
        /// The reason.
        cause: String,
    },
}

impl Error {
    /// Whether other [`Settings`] would work, for the same scene on the same engine.
    #[must_use]
    pub fn is_of_settings(&self) -> bool {
        matches!(
            self,
            Self::NoSuchCamera { .. }
                | Self::Camera(_)
                | Self::NotFinite(_)
                | Self::ImageSize { .. }
                | Self::Samples(_)
                | Self::NotFromZero(_)
                | Self::Focus
                | Self::NoFocus
                | Self::ParallelLens
                | Self::ShutterOfFrame
                | Self::MotionOfFrame
                | Self::LayersInBands
                | Self::SunRadius
                | Self::Bounces(_)
                | Self::StructureOptions(_)
                | Self::TerminatorOnGpu
                | Self::NoiseInBands
                | Self::NoiseOfTexture
                | Self::StructureOnGpu(_)
                | Self::OptionOnGpu(..)
                | Self::CountsOfStructure
        )
    }
}
