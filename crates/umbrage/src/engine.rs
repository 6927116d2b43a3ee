//! What finds and shades a frame: the CPU or a GPU.

use umbrage_rays::{LightCells, LightMask, LightSource, Omitted, PixelWork, SeenPixels, View, Work};
use umbrage_scene::{Frame, Scene};

use crate::background::Surroundings;
use crate::cpu::Cpu;
#[cfg(feature = "gpu")]
use crate::gpu::{Band, GpuEngine};
use crate::sampling::Sample;
use crate::{Error, Film, Settings, Settled, Stats};

/// All rows of an image.
#[cfg(not(feature = "gpu"))]
#[derive(Debug)]
pub(crate) struct Band {
    pub(crate) view: View,
}

#[cfg(not(feature = "gpu"))]
impl From<&View> for Band {
    fn from(view: &View) -> Self {
        Self { view: *view }
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

/// Both give the same triangles and shadows; their shading differs by rounding.
#[derive(Debug)]
pub(crate) enum Engine {
    Cpu(Box<Cpu>),
    #[cfg(feature = "gpu")]
    Gpu(Box<GpuEngine>),
}

impl Default for Engine {
    fn default() -> Self {
        Self::Cpu(Box::default())
    }
}

impl Engine {
    /// Brings a frame to a moment. A GPU may keep its vertices to itself, see [`Engine::whole_frame`].
    pub(crate) fn animate(
        &mut self,
        scene: &Scene,
        seconds: f64,
        settings: &Settings,
        frame: &mut Frame,
    ) -> Result<(), Error> {
        // What only a GPU needs.
        let _ = settings;
        match self {
            Self::Cpu(_) => scene.pose(seconds, frame)?,
            #[cfg(feature = "gpu")]
            Self::Gpu(gpu) => gpu.animate(scene, seconds, settings, frame)?,
        }
        Ok(())
    }

    /// Makes ready for a frame that comes with its vertices, in place of [animating](Self::animate) one.
    pub(crate) fn adopt(&mut self) {
        match self {
            Self::Cpu(_) => {}
            #[cfg(feature = "gpu")]
            Self::Gpu(gpu) => gpu.adopt(),
        }
    }

    /// Rebuilds what serves all samples of a frame.
    pub(crate) fn build(
        &mut self,
        frame: &Frame,
        view: &View,
        settings: &Settings,
        surroundings: &Surroundings<'_>,
        output: Output,
    ) -> Result<(), Error> {
        // What only a GPU needs.
        let _ = (view, surroundings, output);
        match self {
            Self::Cpu(cpu) => cpu.build(frame, settings)?,
            #[cfg(feature = "gpu")]
            Self::Gpu(_) if settings.bounces > 0 => {
                return Err(Error::Settings("mirrors are followed on the CPU alone: a GPU takes 0 bounces".to_owned()));
            }
            #[cfg(feature = "gpu")]
            Self::Gpu(gpu) => gpu.build(frame, view, settings, surroundings, output)?,
        }
        Ok(())
    }

    /// The bands of rows in which an image is rendered: the CPU has room for all of it.
    pub(crate) fn bands(&self, view: &View) -> Vec<Band> {
        match self {
            Self::Cpu(_) => vec![Band::from(view)],
            #[cfg(feature = "gpu")]
            Self::Gpu(gpu) => gpu.bands(view),
        }
    }

    /// Sees, shadows and shades one sample of each pixel of a band. The film has it afterwards, or once the band is
    /// [finished](Self::finish).
    pub(crate) fn sample(
        &mut self,
        frame: &Frame,
        band: &Band,
        sample: &Sample,
        surroundings: &Surroundings<'_>,
        film: &mut Film,
        stats: &mut Stats,
    ) -> Result<(), Error> {
        match self {
            Self::Cpu(cpu) => {
                let view = &band.view;
                stats.time("see", || cpu.see(frame, view, sample))?;
                stats.time("shadow", || cpu.shadow(frame, view, sample));
                stats.time("shade", || cpu.shade(frame, view, sample, surroundings, film));
            }
            #[cfg(feature = "gpu")]
            Self::Gpu(gpu) => gpu.sample(frame, band, sample, stats)?,
        }
        Ok(())
    }

    /// Brings a band's sums over all samples to the output, if they aren't there.
    pub(crate) fn finish(
        &mut self,
        band: &Band,
        settings: &Settings,
        output: Output,
        film: &mut Film,
        stats: &mut Stats,
    ) -> Result<(), Error> {
        // What only a GPU needs.
        let _ = (&band, settings, &film, &stats);
        match (self, output) {
            (Self::Cpu(_), Output::Film) => {}
            #[cfg(feature = "gpu")]
            (Self::Cpu(_), Output::Texture) => return Err(Self::no_texture()),
            #[cfg(feature = "gpu")]
            (Self::Gpu(gpu), Output::Film) => stats.time("fetch", || gpu.fetch(band, film, settings.samples))?,
            #[cfg(feature = "gpu")]
            (Self::Gpu(gpu), Output::Texture) => gpu.develop(band, settings, stats)?,
        }
        Ok(())
    }

    /// The texture that the last frame was rendered to.
    #[cfg(feature = "gpu")]
    pub(crate) fn texture(&self) -> Result<umbrage_gpu::wgpu::Texture, Error> {
        let texture = match self {
            Self::Cpu(_) => None,
            Self::Gpu(gpu) => gpu.texture(),
        };
        texture.ok_or_else(Self::no_texture)
    }

    #[cfg(feature = "gpu")]
    fn no_texture() -> Error {
        Error::Settings("only a GPU renders to a texture".to_owned())
    }

    /// Counts what it takes to find the triangle that each pixel shows; a GPU counts nothing.
    pub(crate) fn see_counting(
        &mut self,
        frame: &Frame,
        view: &View,
        sample: &Sample,
        work: &mut PixelWork,
    ) -> Result<(), Error> {
        match self {
            Self::Cpu(cpu) => Ok(cpu.see_counting(frame, view, sample, work)?),
            #[cfg(feature = "gpu")]
            Self::Gpu(_) => Err(Error::Settings("the work of pixels is counted on the CPU alone".to_owned())),
        }
    }

    /// Finds in which cell of a light's grid the point is that each pixel shows; a GPU says nothing of that.
    pub(crate) fn locate(
        &mut self,
        frame: &Frame,
        view: &View,
        sample: &Sample,
        light: &LightSource,
        cells: &mut LightCells,
    ) -> Result<(), Error> {
        match self {
            Self::Cpu(cpu) => {
                cpu.see(frame, view, sample)?;
                cpu.locate(frame, view, sample, light, cells);
                Ok(())
            }
            #[cfg(feature = "gpu")]
            Self::Gpu(_) => Err(Error::Settings("the cells of lights are shown by the CPU alone".to_owned())),
        }
    }

    /// What each pixel showed at the last sample.
    pub(crate) fn seen(&self) -> &SeenPixels {
        match self {
            Self::Cpu(cpu) => cpu.seen(),
            #[cfg(feature = "gpu")]
            Self::Gpu(gpu) => gpu.seen(),
        }
    }

    /// For each light, which pixels it lit at the last sample.
    pub(crate) fn light_masks(&self) -> &[LightMask] {
        match self {
            Self::Cpu(cpu) => cpu.light_masks(),
            #[cfg(feature = "gpu")]
            Self::Gpu(gpu) => gpu.light_masks(),
        }
    }

    /// What the camera was as work for the CPU's grid, at the last sample; zero where there is none.
    pub(crate) fn camera_work(&self) -> Work {
        match self {
            Self::Cpu(cpu) => cpu.camera_work(),
            #[cfg(feature = "gpu")]
            Self::Gpu(_) => Work::default(),
        }
    }

    /// What each light was as work for the CPU's grid, at the last sample; empty where there is none.
    pub(crate) fn light_work(&self) -> &[Work] {
        match self {
            Self::Cpu(cpu) => cpu.light_work(),
            #[cfg(feature = "gpu")]
            Self::Gpu(_) => &[],
        }
    }

    /// The frame with its vertices, wherever they were posed.
    pub(crate) fn whole_frame<'a>(&'a self, frame: &'a Frame) -> &'a Frame {
        match self {
            Self::Cpu(_) => frame,
            #[cfg(feature = "gpu")]
            Self::Gpu(gpu) => gpu.whole_frame(frame),
        }
    }

    pub(crate) fn omitted(&self, frame: &Frame) -> Result<Omitted, Error> {
        // What only a GPU needs.
        let _ = frame;
        match self {
            Self::Cpu(cpu) => Ok(cpu.omitted().clone()),
            #[cfg(feature = "gpu")]
            Self::Gpu(gpu) => Ok(gpu.omitted(frame)?),
        }
    }

    pub(crate) fn vertices(&self, frame: &Frame) -> usize {
        match self {
            Self::Cpu(_) => frame.positions.len(),
            #[cfg(feature = "gpu")]
            Self::Gpu(gpu) => gpu.vertices(),
        }
    }

    /// Bytes of what vertices are made from that are posed elsewhere than in the frame.
    pub(crate) fn rig_bytes(&self) -> usize {
        match self {
            Self::Cpu(_) => 0,
            #[cfg(feature = "gpu")]
            Self::Gpu(gpu) => gpu.rig_bytes(),
        }
    }

    /// Bytes that went to a GPU for the last frame.
    pub(crate) fn uploaded_bytes(&self) -> u64 {
        match self {
            Self::Cpu(_) => 0,
            #[cfg(feature = "gpu")]
            Self::Gpu(gpu) => gpu.uploaded_bytes(),
        }
    }

    /// Shadow rays of the last frame, all samples together.
    pub(crate) fn shadow_rays(&self) -> u64 {
        match self {
            Self::Cpu(cpu) => cpu.shadow_rays(),
            #[cfg(feature = "gpu")]
            Self::Gpu(gpu) => gpu.shadow_rays(),
        }
    }

    /// What of the last frame's camera rays and shadow rays was left to the predicate, all samples together; how many rays
    /// there were isn't filled in.
    pub(crate) fn settled(&self) -> [Option<Settled>; 2] {
        match self {
            Self::Cpu(cpu) => cpu.settled(),
            #[cfg(feature = "gpu")]
            Self::Gpu(gpu) => gpu.settled().map(Some),
        }
    }

    pub(crate) fn structure_bytes(&self) -> usize {
        match self {
            Self::Cpu(cpu) => cpu.structure_bytes(),
            #[cfg(feature = "gpu")]
            Self::Gpu(gpu) => gpu.structure_bytes(),
        }
    }

    pub(crate) fn point_bytes(&self) -> usize {
        match self {
            Self::Cpu(cpu) => cpu.point_bytes(),
            #[cfg(feature = "gpu")]
            Self::Gpu(gpu) => gpu.point_bytes(),
        }
    }

    pub(crate) fn pixel_bytes(&self) -> usize {
        match self {
            Self::Cpu(cpu) => cpu.pixel_bytes(),
            #[cfg(feature = "gpu")]
            Self::Gpu(gpu) => gpu.pixel_bytes(),
        }
    }
}
