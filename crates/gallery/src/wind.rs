use std::f32::consts::TAU;

use glam::Vec3;
use rayon::prelude::*;
use umbrage_rays::parallel::Parallel;

use super::build::math::{cos, wave};

/// Amplitude and phase of each plant vertex in the wind.
///
/// Eight bytes a vertex.
#[derive(Clone, Debug, Default)]
pub(super) struct Wind {
    /// Amplitude in metres, and phase in turns, 0 … 1.
    bends: Vec<[f32; 2]>,
}

impl Wind {
    /// Sets the motion of the next vertex.
    pub(super) fn bends(&mut self, amplitude: f32, phase: f32) {
        self.bends.push([amplitude, phase]);
    }

    /// Number of moving vertices.
    pub(super) fn len(&self) -> usize {
        self.bends.len()
    }

    /// Moves `positions`, one for each call of [`Wind::bends`], from rest to `part`, 0 … 1, of a cycle; the cycle ends
    /// where it starts.
    pub(super) fn blow(&self, part: f32, positions: &mut [Vec3]) {
        /// Gusts for each cycle, slow and quick, whole numbers.
        const GUSTS: [f32; 2] = [5.0, 13.0];
        const STEPS: usize = 512;
        /// Vertices for each task.
        const CHUNK: usize = 4096;
        // One sine for each phase rather than for each vertex.
        let gust: [Vec3; STEPS] = std::array::from_fn(|step| {
            let phase = step as f32 / STEPS as f32;
            let slow = 0.4 + wave(GUSTS[0] * part + phase);
            let quick = cos(TAU * (GUSTS[1] * part + 2.0 * phase));
            Vec3::new(-slow - 0.25 * quick, 0.3 * quick, -0.35 * slow + 0.4 * quick)
        });
        positions.par_chunks_mut(CHUNK).zip(self.bends.par_chunks(CHUNK)).each(|(positions, bends)| {
            for (position, &[amplitude, phase]) in positions.iter_mut().zip(bends) {
                let step = (phase * STEPS as f32) as usize;
                *position += gust[step.min(STEPS - 1)] * amplitude;
            }
        });
    }
}
