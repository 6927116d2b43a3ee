use bytemuck::{Pod, Zeroable};

use crate::grid::header::{HEADER_BLOCKS, HEADER_FACES, HEADER_LARGE, HEADER_WORDS};
use crate::link::shared_constants;
use crate::{Buffer, CameraGrid, Gpu, GpuError, Groups, Kernel, LightGrid, Recorder};

/// The stage `fit`: decides on the GPU whether a frame's structures had enough room. Later stages of the same
/// submission run only then.
#[derive(Debug)]
pub struct Fit {
    kernel: Kernel,
    parameters: Buffer,
    result: Buffer,
    sizes: Buffer,
}

/// Capacities of a structure's buffers, as in `fit.wgsl`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct Room {
    pub(crate) large: u32,
    pub(crate) pairs: u32,
    pub(crate) blocks: u32,
    pub(crate) faces: u32,
    pub(crate) undecided_words: u32,
    pub(crate) words_per_undecided: u32,
    pub(crate) words_per_pixel: u32,
    pub(crate) undecided_header: u32,
}

impl Room {
    /// Whether the room is enough for `needs`, by the rule of `fit.wgsl`.
    pub(crate) fn holds(&self, needs: &Needs) -> bool {
        const MOST_UNDECIDED: u32 = 0x1000_0000;
        let Needs { large, pairs, blocks, faces, undecided, pixels, .. } = *needs;
        large <= self.large
            && pairs <= self.pairs
            && blocks <= self.blocks
            && faces <= self.faces
            && undecided.max(pixels) < MOST_UNDECIDED
            && self.undecided_header + undecided * self.words_per_undecided + pixels * self.words_per_pixel
                <= self.undecided_words
    }
}

/// Uniform of `fit.wgsl`.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
struct FitParameters {
    camera: Room,
    light: Room,
    lights: u32,
    groups: u32,
}

/// A structure's needs in a frame, word by word as in `fit.wgsl`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Needs {
    pub(crate) large: u32,
    pub(crate) pairs: u32,
    pub(crate) blocks: u32,
    pub(crate) faces: u32,
    pub(crate) undecided: u32,
    pub(crate) pixels: u32,
    /// Whether any pixel sees a triangle when it looks behind.
    pub(crate) any: u32,
}

shared_constants! { "fit":
    /// Words of a record of needs.
    NEEDS_WORDS: u64 = HEADER_WORDS + 4;
    /// Word of the number of pairs, …
    NEEDS_PAIRS: u64 = HEADER_WORDS;
    /// … of the number of undecided pairs, …
    NEEDS_UNDECIDED: u64 = NEEDS_PAIRS + 1;
    /// … and of the number of pixels with undecided pairs.
    NEEDS_PIXELS: u64 = NEEDS_PAIRS + 2;
}

impl Needs {
    /// Reads a record that was copied back.
    pub(crate) fn from_words(words: &[u32]) -> Self {
        let [large, blocks, faces] = [HEADER_LARGE, HEADER_BLOCKS, HEADER_FACES].map(|word| words[word]);
        let [pairs, undecided, pixels] = [NEEDS_PAIRS, NEEDS_UNDECIDED, NEEDS_PIXELS].map(|word| words[word as usize]);
        Self { large, pairs, blocks, faces, undecided, pixels, any: words[NEEDS_PIXELS as usize + 1] }
    }
}

impl Fit {
    /// Compiles the stage.
    #[must_use]
    pub fn new(gpu: &Gpu) -> Self {
        Self {
            kernel: Kernel::new(gpu, "fit", "fit", &[]),
            parameters: Buffer::uniform(gpu, "room"),
            result: Buffer::storage(gpu, "whether all fits"),
            sizes: Buffer::sizes(gpu, "dispatch sizes of what fits"),
        }
    }

    /// Prepares for structures that are prepared, and for a dispatch of `groups` workgroups if they fit.
    ///
    /// # Errors
    /// If the device has reported an error.
    pub fn prepare(&mut self, gpu: &Gpu, camera: &CameraGrid, lights: &LightGrid, groups: u32) -> Result<(), GpuError> {
        let lights_count = lights.light_count();
        let parameters = FitParameters { camera: camera.room(), light: lights.room(), lights: lights_count, groups };
        self.result.reserve(gpu, 16)?;
        self.sizes.reserve(gpu, 16)?;
        self.parameters.write(gpu, &[parameters])
    }

    /// Records the stage, after the structures' stages.
    pub fn record(&self, gpu: &Gpu, recorder: &mut Recorder<'_>, camera: &CameraGrid, lights: &LightGrid) {
        let buffers = [&self.parameters, camera.needs(), lights.needs(), &self.result];
        recorder.stage("fit", |pass| self.kernel.dispatch(gpu, pass, &buffers, Groups::Flat(1)));
        recorder.copy_words(&self.result, &self.sizes, 3);
    }

    /// The prepared number of workgroups if everything fits, else none.
    #[must_use]
    pub fn groups(&self) -> Groups<'_> {
        Groups::Indirect(&self.sizes, 0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layout::{Layout, differences, layout, module};
    use crate::link::link;

    #[test]
    fn rooms_are_those_of_the_shader() {
        let shader = module(&link("fit"));
        for layout in [
            Layout {
                name: "FitRoom",
                ..layout!(Room {
                    large,
                    pairs,
                    blocks,
                    faces,
                    undecided_words,
                    words_per_undecided,
                    words_per_pixel,
                    undecided_header,
                })
            },
            Layout { name: "Fit", ..layout!(FitParameters { camera, light, lights, groups }) },
        ] {
            assert_eq!(differences(&shader, &layout), [""; 0]);
        }
    }
}
