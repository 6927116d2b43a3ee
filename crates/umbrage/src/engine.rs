//! Engines, which find and shade a frame: the CPU or a GPU. Both give the same triangles and shadows; their shading
//! differs by rounding.

use std::fmt::Debug;
use std::future::poll_fn;
use std::pin::Pin;
use std::task::Poll;

use umbrage_rays::{LightMask, SeenPixels, View, Work};
use umbrage_scene::{Frame, Light};

use crate::background::Surroundings;
use crate::frame::Subject;
use crate::motion::Next;
use crate::sampling::Samples;
use crate::{Error, Film, Settings, Stats};

/// A frame with its lights, view, surroundings and samples, as the settings and an exposure choose them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Staged<'a> {
    pub(crate) frame: &'a Frame,
    /// The lights, in place of the frame's own.
    pub(crate) lights: &'a [Light],
    /// Number of sky lights, the last of `lights`: each is light from the surroundings in one direction, which surfaces
    /// scatter but don't mirror.
    pub(crate) sky_lights: usize,
    pub(crate) view: View,
    pub(crate) settings: &'a Settings,
    pub(crate) surroundings: &'a Surroundings<'a>,
    /// The samples to take of each pixel.
    pub(crate) samples: Samples,
    /// Number of the band of rows that takes them.
    #[cfg_attr(not(feature = "gpu"), allow(dead_code, reason = "only GPUs render in bands"))]
    pub(crate) band: usize,
}

impl Staged<'_> {
    /// Whether any part of the picture may be shown without exposure and tone map.
    pub(crate) fn has_flat(&self) -> bool {
        self.surroundings.are_flat()
            || !self.frame.mesh.marks.is_empty()
            || self.frame.materials.materials.iter().any(|material| material.unlit)
    }
}

/// The target that a frame is rendered to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Output {
    /// The film, with all its planes.
    Film,
    /// Opaque rows of RGB with eight bits a channel, developed strip by strip as they are shaded. There is no film, so
    /// this is for one sample of a pixel.
    Rows,
    /// A texture of a GPU's with the developed film. Nothing is fetched.
    #[cfg(feature = "gpu")]
    Texture,
}

impl Output {
    /// Width and height of the fetched image, in pixels; 0 if nothing is fetched.
    pub(crate) fn fetched(self, view: &View) -> [u32; 2] {
        match self {
            Self::Film => [view.width, view.height],
            Self::Rows => [0, 0],
            #[cfg(feature = "gpu")]
            Self::Texture => [0, 0],
        }
    }
}

/// A stage that is done at once on the CPU, and perhaps awaited on a GPU.
pub(crate) type Outcome<'a> = Pin<Box<dyn Future<Output = Result<(), Error>> + 'a>>;

/// The outcome of a stage that is done. It has no state, and so takes nothing from the heap.
pub(crate) fn done<'a>() -> Outcome<'a> {
    Box::pin(poll_fn(|_| Poll::Ready(Ok(()))))
}

/// The groups of samples and rows in which an engine renders a frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Passes {
    /// Number of bands of rows that are rendered one after the other.
    pub(crate) bands: usize,
    /// Whether four samples of a pixel are traced together, rather than one after the other.
    pub(crate) by_four: bool,
}

/// Answers of the last samples of the last frame.
pub(crate) struct Last<'a> {
    pub(crate) samples: Samples,
    /// The triangles that pixels showed: each of four samples is a pixel here.
    pub(crate) seen: &'a SeenPixels,
    /// For each light, the pixels that it lit.
    pub(crate) light_masks: &'a [LightMask],
    /// The camera's work for the CPU's grid; zero where there is none.
    pub(crate) camera_work: Work,
    /// The work of each light that casts shadows for the CPU's grid; empty where there is none.
    pub(crate) light_work: &'a [Work],
    /// The texture that the frame was rendered to.
    #[cfg(feature = "gpu")]
    pub(crate) texture: Option<umbrage_gpu::wgpu::Texture>,
}

/// The stages of a frame, in the order in which they are called, and queries about the last frame.
///
/// Each stage counts its time in the [`Stats`]. A GPU notes the sample that it is to [see](Self::see) and
/// [shadow](Self::shadow), and records these stages under the finer names of its kernels, before those that
/// [shade](Self::shade): all are submitted at once, and recorded again with more room where a list was too small.
pub(crate) trait Engine: Debug + Send + Sync {
    /// Begins a frame: resets the counts of the last one.
    ///
    /// # Errors
    /// Where this engine doesn't support the settings or the output; the last frame then stays.
    fn begin(&mut self, settings: &Settings, output: Output) -> Result<(), Error>;

    /// Poses a scene at its moment, or prepares for a frame that comes with its vertices. A GPU may keep the vertices of a
    /// scene to itself, see [`Engine::whole_frame`].
    fn animate(&mut self, subject: Subject<'_>, settings: &Settings, frame: &mut Frame) -> Result<(), Error>;

    /// Rebuilds the structures and tables that serve all samples of a moment.
    fn build(&mut self, staged: &Staged<'_>, output: Output) -> Result<Passes, Error>;

    /// Finds the triangle that each pixel shows at the samples.
    fn see(&mut self, staged: &Staged<'_>, stats: &mut Stats) -> Result<(), Error>;

    /// Finds the visible points that each light reaches.
    fn shadow(&mut self, staged: &Staged<'_>, stats: &mut Stats) -> Result<(), Error>;

    /// Adds each pixel's radiance at the samples to the film, or to planes that [develop](Self::develop) brings there; then
    /// the chosen layers to the film. `next` is the scene's next pose, for samples that have motion.
    fn shade<'a>(
        &'a mut self,
        staged: &'a Staged<'a>,
        next: Option<&'a Next<'a>>,
        film: &'a mut Film,
        stats: &'a mut Stats,
    ) -> Outcome<'a>;

    /// Brings a band, summed over its samples so far, to the output, if it isn't there.
    fn develop<'a>(&'a mut self, staged: &'a Staged<'a>, film: &'a mut Film, stats: &'a mut Stats) -> Outcome<'a>;

    /// The rows of the last frame that was rendered to [rows](Output::Rows), and the memory of the next one's; `None` if
    /// this engine has only films.
    fn rows(&mut self) -> Option<&mut Vec<u8>> {
        None
    }

    /// The last samples' answers.
    fn last(&self) -> Last<'_>;

    /// The frame with its vertices, posed on the CPU if it comes without.
    fn whole_frame<'a>(&'a self, frame: &'a Frame) -> &'a Frame;

    /// Adds the engine's own counts to the stats, which have those of the triangles, the film and the camera rays.
    fn count(&self, frame: &Frame, stats: &mut Stats);
}
