//! Engines, which find and shade a frame: the CPU or a GPU. Both give the same triangles and shadows; their shading
//! differs by rounding.

use std::fmt::Debug;
use std::mem;
use std::pin::Pin;
use std::task::{Context, Poll};

use umbrage_rays::{LightMask, SeenPixels, View, Work};
use umbrage_scene::{Frame, Light, Scene};

use crate::background::Surroundings;
use crate::cpu::Cpu;
use crate::motion::Next;
use crate::sampling::Samples;
use crate::{Error, Film, Settings, Stats};

/// A frame with its lights, view and surroundings, as the settings choose them.
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
    /// A texture of a GPU's with the developed film. Nothing is fetched.
    #[cfg(feature = "gpu")]
    Texture,
}

impl Output {
    /// Width and height of the fetched image, in pixels; 0 if nothing is fetched.
    pub(crate) fn fetched(self, view: &View) -> [u32; 2] {
        match self {
            Self::Film => [view.width, view.height],
            #[cfg(feature = "gpu")]
            Self::Texture => [0, 0],
        }
    }
}

/// A stage's result: known at once on the CPU, and perhaps awaited on a GPU.
pub(crate) enum Outcome<'a> {
    Known(Result<(), Error>),
    #[cfg_attr(not(feature = "gpu"), allow(dead_code, reason = "the CPU's are known"))]
    Awaited(Pin<Box<dyn Future<Output = Result<(), Error>> + 'a>>),
}

#[cfg(feature = "gpu")]
impl<'a> Outcome<'a> {
    pub(crate) fn of(stage: impl Future<Output = Result<(), Error>> + 'a) -> Self {
        Self::Awaited(Box::pin(stage))
    }
}

impl Future for Outcome<'_> {
    type Output = Result<(), Error>;

    fn poll(self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<Self::Output> {
        match self.get_mut() {
            // Futures aren't polled again once they are ready.
            Self::Known(known) => Poll::Ready(mem::replace(known, Ok(()))),
            Self::Awaited(stage) => stage.as_mut().poll(context),
        }
    }
}

/// The stages of a frame, in the order in which they are called, and queries about the last frame.
///
/// Each stage counts its time in the [`Stats`]. Between stages of a sample a GPU has nothing to say to the CPU: it does
/// [seeing](Self::see) and [shadowing](Self::shadow) as part of [shading](Self::shade), all of it recorded and submitted at
/// once, under the finer names of its kernels.
pub(crate) trait Engine: Debug + Send + Sync {
    /// Rejects settings and outputs that this engine doesn't support, before the last frame is touched.
    fn check(&self, settings: &Settings, output: Output) -> Result<(), Error>;

    /// Begins a frame: resets the counts of the last one.
    fn begin(&mut self, settings: &Settings);

    /// Poses a frame at `seconds`: its moment, or another one that its picture is made of. A GPU may keep its vertices
    /// to itself, see [`Engine::whole_frame`].
    fn animate(&mut self, scene: &Scene, seconds: f64, settings: &Settings, frame: &mut Frame) -> Result<(), Error>;

    /// Prepares for a frame that comes with its vertices, in place of [animating](Self::animate) one.
    fn adopt(&mut self) {}

    /// Rebuilds the structures and tables that serve all samples of a moment.
    fn build(&mut self, staged: &Staged<'_>, output: Output) -> Result<(), Error>;

    /// Number of bands of rows in which the frame is rendered, one after the other: the CPU has room for all of it.
    fn bands(&self) -> usize {
        1
    }

    /// Whether four samples of a pixel are traced together, rather than one after the other.
    fn traces_four(&self, _view: &View) -> bool {
        false
    }

    /// Finds the triangle that each pixel shows at these samples.
    fn see(&mut self, _staged: &Staged<'_>, _samples: &Samples, _stats: &mut Stats) -> Result<(), Error> {
        Ok(())
    }

    /// Finds the visible points that each light reaches.
    fn shadow(&mut self, _staged: &Staged<'_>, _samples: &Samples, _stats: &mut Stats) -> Result<(), Error> {
        Ok(())
    }

    /// Adds each pixel's radiance at these samples to the film, or to planes that [develop](Self::develop) brings
    /// there.
    fn shade<'a>(
        &'a mut self,
        staged: &'a Staged<'a>,
        band: usize,
        samples: &'a Samples,
        film: &'a mut Film,
        stats: &'a mut Stats,
    ) -> Outcome<'a>;

    /// Adds these samples to the chosen layers. `next` is the scene's next pose, for samples that have motion.
    fn layers(
        &mut self,
        _staged: &Staged<'_>,
        _samples: &Samples,
        _next: Option<&Next<'_>>,
        _film: &mut Film,
        _stats: &mut Stats,
    ) {
    }

    /// Brings a band, summed over all samples, to the output, if it isn't there: the CPU shades into the film itself.
    fn develop<'a>(
        &'a mut self,
        _staged: &'a Staged<'a>,
        _band: usize,
        _output: Output,
        _film: &'a mut Film,
        _stats: &'a mut Stats,
    ) -> Outcome<'a> {
        Outcome::Known(Ok(()))
    }

    /// The texture that the last frame was rendered to.
    #[cfg(feature = "gpu")]
    fn texture(&self) -> Option<umbrage_gpu::wgpu::Texture> {
        None
    }

    /// The CPU, whose stages can be asked for without rendering.
    fn cpu(&mut self) -> Option<&mut Cpu> {
        None
    }

    /// Whether pictures have the frame's points and lines.
    fn draws_marks(&self) -> bool {
        false
    }

    /// The triangle that each pixel showed at the last sample.
    fn seen(&self) -> &SeenPixels;

    /// For each light, the pixels that it lit at the last sample.
    fn light_masks(&self) -> &[LightMask];

    /// The camera's work for the CPU's grid, at the samples that were traced last; zero where there is none.
    fn camera_work(&self) -> Work {
        Work::default()
    }

    /// The work of each light that casts shadows for the CPU's grid, at the samples that were traced last; empty where
    /// there is none.
    fn light_work(&self) -> &[Work] {
        &[]
    }

    /// The frame with its vertices, posed on the CPU if it comes without.
    fn whole_frame<'a>(&'a self, frame: &'a Frame) -> &'a Frame {
        frame
    }

    /// Adds the engine's own counts to the stats, which have those of the triangles, the film and the camera rays.
    fn count(&self, frame: &Frame, stats: &mut Stats);
}
