//! The stage `develop` alone.

use glam::Vec4;
use umbrage::{Film, Settings};
use umbrage_gpu::shade::{Develop, FilmKeeps, FilmPlanes, ToneMap};
use umbrage_gpu::{Gpu, Recorder};

use crate::common::gpu;

/// Develops films on a GPU.
pub(crate) struct Developer {
    gpu: Gpu,
    stage: Develop,
    planes: FilmPlanes,
}

impl Developer {
    pub(crate) fn open() -> Option<Self> {
        let gpu = gpu()?;
        let stage = Develop::new(&gpu, umbrage::gpu::screen_levels()).expect("room");
        Some(Self { stage, planes: FilmPlanes::new(&gpu), gpu })
    }

    /// Develops a film to sRGB-encoded RGBA, pixel by pixel.
    fn develop(&mut self, film: &Film, settings: &Settings) -> Vec<[u8; 4]> {
        let Self { gpu, stage, planes } = self;
        let tone_map = match settings.tone_map {
            umbrage::ToneMap::PbrNeutral => ToneMap::PbrNeutral,
            umbrage::ToneMap::Clip => ToneMap::Clip,
        };
        // On a GPU the film has all planes, and sums over the samples.
        let keeps = FilmKeeps { first: true, through: true, flat: !film.flat.is_empty(), ways: 0 };
        planes.prepare(gpu, [film.width, film.height], keeps).expect("room");
        let sums = |means: &[Vec4]| -> Vec<[f32; 4]> {
            means.iter().map(|mean| (*mean * settings.samples as f32).to_array()).collect()
        };
        planes.planes().write_at(gpu, 0, &sums(&film.color)).expect("room");
        if let Some(flat) = planes.flat_plane() {
            planes.planes().write_at(gpu, 16 * u64::from(flat), &sums(&film.flat)).expect("room");
        }
        stage.prepare(gpu, planes, settings.samples, settings.exposure_stops, tone_map).expect("room");
        let mut recorder = Recorder::new(gpu);
        recorder.stage("develop", |pass| stage.record(gpu, pass, planes));
        recorder.submit_and_wait().expect("done");
        let words = stage.read_image(gpu).expect("read");
        words.into_iter().map(u32::to_le_bytes).collect()
    }

    /// Number of pixels that the GPU develops more than one level off from the CPU, with the same film and `settings`.
    pub(crate) fn developed_otherwise(&mut self, film: &Film, settings: &Settings) -> usize {
        let developed = self.develop(film, settings);
        otherwise(&film.develop(settings).pixels, &developed)
    }

    /// The same, with other settings on the CPU.
    pub(crate) fn developed_otherwise_than(&mut self, film: &Film, settings: &Settings, of_cpu: &Settings) -> usize {
        let developed = self.develop(film, settings);
        otherwise(&film.develop(of_cpu).pixels, &developed)
    }
}

fn otherwise(of_cpu: &[[u16; 3]], of_gpu: &[[u8; 4]]) -> usize {
    assert_eq!(of_cpu.len(), of_gpu.len());
    let is_off = |(cpu, gpu): &(&[u16; 3], &[u8; 4])| {
        gpu[3] != u8::MAX
            || (0..3).any(|channel| (f32::from(cpu[channel]) / 257.0 - f32::from(gpu[channel])).abs() > 1.0)
    };
    of_cpu.iter().zip(of_gpu).filter(is_off).count()
}
