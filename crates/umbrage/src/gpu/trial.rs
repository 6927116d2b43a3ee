//! One frame shaded by both engines, for the tests that compare them.

use umbrage_gpu::shade::{Develop, FilmPlanes, Layer, Shade, ShadeInputs, ToneMap};
use umbrage_gpu::{Buffer, Gpu, Groups, Recorder};
use umbrage_rays::{SeenPixels, View};
use umbrage_scene::Frame;

pub use super::tables::Uploaded;
use super::tables::{Tables, sample_rays};
use crate::background::Surroundings;
use crate::cpu::{Cpu, PeeledLayer};
use crate::{Film, Sample, Settings};

type Error = Box<dyn std::error::Error + Send + Sync>;

/// Shades what the CPU engine sees, on the CPU and on a GPU.
#[derive(Debug)]
pub struct Trial {
    gpu: Gpu,
    cpu: Cpu,
    frame: Frame,
    tables: Tables,
    shade: Shade,
    develop: Develop,
    planes: FilmPlanes,
    seen: Buffer,
    lit: Buffer,
    positions: Buffer,
    indices: Buffer,
}

/// The same frame twice.
#[derive(Clone, Debug)]
pub struct Films {
    /// As the CPU engine has it.
    pub cpu: Film,
    /// With the GPU's shading.
    pub gpu: Film,
    /// The GPU's film as the GPU develops it: sRGB-encoded RGBA.
    pub developed: Vec<[u8; 4]>,
    /// What of the frame the GPU didn't have yet.
    pub uploaded: Uploaded,
}

impl Trial {
    /// How many layers the CPU engine looks through.
    const MOST_LAYERS: usize = 32;

    /// Ready to render.
    ///
    /// # Errors
    /// Where the GPU has no memory.
    pub fn new(gpu: Gpu) -> Result<Self, Error> {
        Ok(Self {
            cpu: Cpu::default(),
            frame: Frame::default(),
            tables: Tables::default(),
            shade: Shade::new(&gpu)?,
            develop: Develop::new(&gpu),
            planes: FilmPlanes::new(&gpu),
            seen: Buffer::storage(&gpu, "seen"),
            lit: Buffer::storage(&gpu, "light masks"),
            positions: Buffer::storage(&gpu, "positions"),
            indices: Buffer::storage(&gpu, "indices"),
            gpu,
        })
    }

    /// Renders a frame.
    ///
    /// # Errors
    /// Where the CPU engine has one, and where the GPU has no room for the frame.
    pub fn render_made(&mut self, frame: Frame, settings: &Settings) -> Result<Films, Error> {
        settings.check()?;
        self.frame = frame;
        self.render_frame(settings)
    }

    fn render_frame(&mut self, settings: &Settings) -> Result<Films, Error> {
        let view = settings.view(&self.frame);
        let surroundings = Surroundings::new(&settings.background);
        let mut film = Film::default();
        film.clear(&view);
        self.cpu.build(&self.frame, settings);
        let Self { gpu, frame, tables, shade, .. } = self;
        let uploaded = tables.upload(gpu, frame, None, &surroundings, shade)?;
        self.positions.write(gpu, &frame.positions)?;
        let records: Vec<_> = frame.mesh.triangles.iter().map(|&[a, b, c]| [a, b, c, 0]).collect();
        self.indices.write(gpu, &records)?;
        let is_see_through = frame.is_see_through();
        self.planes.prepare(gpu, [view.width, view.height], true, is_see_through)?;
        for sample in Sample::all(settings.samples) {
            self.cpu.see(&self.frame, &view, &sample)?;
            self.cpu.shadow(&self.frame, &view, &sample);
            self.cpu.shade(&self.frame, &view, &sample, &surroundings, &mut film);
            self.shade_layers(&view, &sample, is_see_through)?;
        }
        film.average(settings.samples);
        Ok(Films { gpu: self.film(settings)?, developed: self.developed(settings)?, cpu: film, uploaded })
    }

    fn shade_layers(&mut self, view: &View, sample: &Sample, is_see_through: bool) -> Result<(), Error> {
        let mut layer = self.cpu.first_layer(&self.frame, view, sample);
        for depth in 0..Self::MOST_LAYERS {
            let behind = if is_see_through && depth + 1 < Self::MOST_LAYERS {
                self.cpu.layer_behind(&self.frame, view, sample, &layer)
            } else {
                PeeledLayer::default()
            };
            let which =
                Layer { is_of_first_sample: sample.index == 0, is_first: depth == 0, is_last: behind.is_empty() };
            self.shade_layer(view, sample, &layer, which)?;
            if which.is_last {
                break;
            }
            layer = behind;
        }
        Ok(())
    }

    fn shade_layer(&mut self, view: &View, sample: &Sample, layer: &PeeledLayer, which: Layer) -> Result<(), Error> {
        let Self { gpu, shade, planes, seen, lit, positions, indices, .. } = self;
        let triangles = layer.hits.iter().map(|hit| hit.map_or(SeenPixels::NONE, |hit| hit.triangle));
        seen.write(gpu, &triangles.collect::<Vec<u32>>())?;
        lit.write(gpu, &layer.lit)?;
        shade.prepare(gpu, &sample_rays(&view.into(), sample), which, planes)?;
        let inputs = ShadeInputs { seen, lit, positions, triangles: indices };
        let mut recorder = Recorder::new(gpu);
        recorder.stage("shade", |pass| shade.record(gpu, pass, &inputs, planes, Groups::Flat(shade.groups())));
        recorder.submit()()?;
        Ok(())
    }

    fn film(&self, settings: &Settings) -> Result<Film, Error> {
        let Self { gpu, planes, .. } = self;
        let first = planes.read_first(gpu)?;
        let mut film = Film {
            width: settings.width,
            height: settings.height,
            color: planes.read_color(gpu)?.into_iter().map(Into::into).collect(),
            depth: first.iter().map(|&[.., depth]| depth).collect(),
            normal: first.iter().map(|&[x, y, z, _]| [x, y, z].into()).collect(),
            triangle: planes.read_triangle(gpu)?,
        };
        film.average(settings.samples);
        Ok(film)
    }

    fn developed(&mut self, settings: &Settings) -> Result<Vec<[u8; 4]>, Error> {
        let Self { gpu, develop, planes, .. } = self;
        let tone_map = match settings.tone_map {
            crate::ToneMap::PbrNeutral => ToneMap::PbrNeutral,
            crate::ToneMap::Clip => ToneMap::Clip,
        };
        develop.prepare(gpu, planes, settings.samples, settings.exposure_stops, tone_map)?;
        let mut recorder = Recorder::new(gpu);
        recorder.stage("develop", |pass| develop.record(gpu, pass, planes));
        recorder.submit()()?;
        let words: Vec<u32> = develop.image().read(gpu, planes.pixels() as usize)?;
        Ok(words.into_iter().map(u32::to_le_bytes).collect())
    }
}
