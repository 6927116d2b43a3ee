use umbrage_gpu::shade::{Develop, FilmPlanes, Shown, ToneMap, Turns};
use umbrage_gpu::{Band, Buffer, Gpu, GpuError, Recorder, wgpu};

use crate::{Settings, Stats};

/// Frames as textures, developed on the GPU.
#[derive(Debug)]
pub(super) struct Picture {
    develop: Develop,
    shown: Shown,
    turns: Turns,
    /// The target of the last frame's bands.
    texture: Option<wgpu::Texture>,
}

impl Picture {
    pub(super) fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        let develop = Develop::new(gpu, super::screen_levels())?;
        Ok(Self { develop, shown: Shown::new(gpu), turns: Turns::default(), texture: None })
    }

    /// Develops a band's film into its rows of the texture; returns how many of the band's pixels show a triangle, by
    /// `seen`.
    ///
    /// # Errors
    /// Where the device has no room for the texture, or is lost.
    pub(super) async fn develop(
        &mut self,
        gpu: &Gpu,
        band: &Band,
        (planes, seen): (&FilmPlanes, &Buffer),
        settings: &Settings,
        stats: &mut Stats,
    ) -> Result<u64, GpuError> {
        let tone_map = match settings.tone_map {
            crate::ToneMap::PbrNeutral => ToneMap::PbrNeutral,
            crate::ToneMap::Clip => ToneMap::Clip,
        };
        self.texture = None;
        let texture = self.turns.next(gpu, [band.view.width, band.view.height])?;
        self.shown.prepare(gpu, band.size())?;
        self.develop.prepare(gpu, planes, settings.samples, settings.exposure_stops, tone_map)?;
        let mut recorder = Recorder::new(gpu);
        self.shown.record(gpu, &mut recorder, seen);
        recorder.stage("develop", |pass| self.develop.record(gpu, pass, planes));
        self.develop.copy(&mut recorder, &texture, band.rows.start);
        let done = recorder.submit().await?;
        done.times.iter().for_each(|stage| stats.add(stage.name, stage.milliseconds));
        if band.rows.end == band.view.height {
            self.turns.turn();
            self.texture = Some(texture);
        }
        self.shown.read(&done).map(u64::from)
    }

    /// The last frame's texture; `None` where it wasn't finished.
    pub(super) fn texture(&self) -> Option<wgpu::Texture> {
        self.texture.clone()
    }

    /// Bytes of textures, and of a band on its way to one.
    pub(super) fn bytes(&self) -> u64 {
        self.turns.bytes() + self.develop.bytes()
    }
}
