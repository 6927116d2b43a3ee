//! What finds and shades a frame: the CPU or a GPU. Both give the same triangles and shadows; their shading differs by
//! rounding.

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

/// A frame, and what the settings say is around it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Staged<'a> {
    pub(crate) frame: &'a Frame,
    /// In place of the frame's own.
    pub(crate) lights: &'a [Light],
    /// How many of these, which are the last ones, are light from all around in a single direction: surfaces scatter it, but
    /// don't mirror it.
    pub(crate) sky_lights: usize,
    pub(crate) view: View,
    pub(crate) settings: &'a Settings,
    pub(crate) surroundings: &'a Surroundings<'a>,
}

impl Staged<'_> {
    /// Whether pictures may show something of the frame as it is, whatever exposure and tone map do to the rest.
    pub(crate) fn has_flat(&self) -> bool {
        self.surroundings.are_flat()
            || !self.frame.mesh.marks.is_empty()
            || self.frame.materials.materials.iter().any(|material| material.unlit)
    }
}

/// What a frame is rendered to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Output {
    /// The film, with all that is known of its pixels.
    Film,
    /// A texture of a GPU's, which shows the film developed. Nothing is fetched.
    #[cfg(feature = "gpu")]
    Texture,
}

impl Output {
    /// The size of what is fetched of an image.
    pub(crate) fn fetched(self, view: &View) -> [u32; 2] {
        match self {
            Self::Film => [view.width, view.height],
            #[cfg(feature = "gpu")]
            Self::Texture => [0, 0],
        }
    }
}

/// How a stage went: known at once on the CPU; of a GPU's there may be something to wait for.
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

/// The stages of a frame, in the order in which they are called, and what is known after them.
///
/// Each stage counts its time in the [`Stats`]. Between stages of a sample a GPU has nothing to say to the CPU: it does
/// [seeing](Self::see) and [shadowing](Self::shadow) as part of [shading](Self::shade), all of it recorded and submitted at
/// once, under the finer names of its kernels.
pub(crate) trait Engine: Debug + Send + Sync {
    /// Refuses what this engine can't do, before anything of the last frame is touched.
    fn check(&self, settings: &Settings, output: Output) -> Result<(), Error>;

    /// Begins a frame: forgets what was counted of the last one.
    fn begin(&mut self, settings: &Settings);

    /// Brings a frame to a moment, or to another one that its picture is made of. A GPU may keep its vertices to itself, see [`Engine::whole_frame`].
    fn animate(&mut self, scene: &Scene, seconds: f64, settings: &Settings, frame: &mut Frame) -> Result<(), Error>;

    /// Makes ready for a frame that comes with its vertices, in place of [animating](Self::animate) one.
    fn adopt(&mut self) {}

    /// Rebuilds what serves all samples of a moment.
    fn build(&mut self, staged: &Staged<'_>, output: Output) -> Result<(), Error>;

    /// In how many bands of rows the frame is rendered, one after the other: the CPU has room for all of it.
    fn bands(&self) -> usize {
        1
    }

    /// Whether four samples of a pixel are traced together, rather than one after the other.
    fn traces_four(&self, _view: &View) -> bool {
        false
    }

    /// Finds the triangle that each pixel shows at some samples.
    fn see(&mut self, _staged: &Staged<'_>, _samples: &Samples, _stats: &mut Stats) -> Result<(), Error> {
        Ok(())
    }

    /// Finds which of the points that pixels show each light reaches.
    fn shadow(&mut self, _staged: &Staged<'_>, _samples: &Samples, _stats: &mut Stats) -> Result<(), Error> {
        Ok(())
    }

    /// Adds each pixel's radiance at these samples to the film, or to what [develop](Self::develop) brings there.
    fn shade<'a>(
        &'a mut self,
        staged: &'a Staged<'a>,
        band: usize,
        samples: &'a Samples,
        film: &'a mut Film,
        stats: &'a mut Stats,
    ) -> Outcome<'a>;

    /// Adds to the layers that are asked for. `next` is where the scene will be, for those samples that motion is taken of.
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

    /// What each pixel showed at the last sample.
    fn seen(&self) -> &SeenPixels;

    /// For each light, which pixels it lit at the last sample.
    fn light_masks(&self) -> &[LightMask];

    /// What the camera was as work for the CPU's grid, at the samples that were traced last; zero where there is none.
    fn camera_work(&self) -> Work {
        Work::default()
    }

    /// What each light that casts shadows was as work for the CPU's grid, at the samples that were traced last; empty where there is none.
    fn light_work(&self) -> &[Work] {
        &[]
    }

    /// The frame with its vertices, wherever they were posed.
    fn whole_frame<'a>(&'a self, frame: &'a Frame) -> &'a Frame {
        frame
    }

    /// Adds what the engine alone knows of a frame's cost to what is known of its triangles, film and camera rays.
    fn count(&self, frame: &Frame, stats: &mut Stats);
}
