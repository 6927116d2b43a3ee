//! What the user can choose about pictures, whatever the scene.

use serde::{Deserialize, Serialize};
use umbrage::rays::{
    Cells, KdBuilder, KdTraversal, KdTreeOptions, ListedLightOptions, ListedOptions, PacketSide, UniformOptions,
};
use umbrage::{Background, CameraChoice, Settings, Sides, Structure, ToneMap};

/// Outlives the window.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub(crate) struct Choices {
    pub(crate) engine: EngineChoice,
    pub(crate) structure: StructureChoice,
    pub(crate) listed: ListedChoices,
    pub(crate) uniform: UniformChoices,
    pub(crate) kd_tree: KdTreeChoices,
    pub(crate) culls_back_faces: bool,
    pub(crate) bounces: u32,
    pub(crate) samples: u32,
    pub(crate) resolution: Resolution,
    pub(crate) exposure_stops: f32,
    pub(crate) clips: bool,
    pub(crate) surroundings: SurroundingsChoice,
}

/// What renders.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum EngineChoice {
    /// The processor.
    #[default]
    Cpu,
    /// The first adapter with this in its name.
    Gpu(String),
}

/// What finds triangles on the CPU.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) enum StructureChoice {
    #[default]
    Perspective,
    Listed,
    Grid,
    KdTree,
    Bvh,
}

/// The parameters of [`StructureChoice::Listed`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub(crate) struct ListedChoices {
    pub(crate) sorting_tile: u32,
    pub(crate) tracing_tiles: u32,
    pub(crate) slices: u32,
    pub(crate) light_cells: u32,
    pub(crate) light_rays: u32,
    pub(crate) light_triangles: u32,
}

/// The parameters of [`StructureChoice::Grid`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub(crate) struct UniformChoices {
    pub(crate) cells_per_triangle: f64,
    /// Pixels along an edge.
    pub(crate) packet: u32,
}

/// The parameters of [`StructureChoice::KdTree`], by their names.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub(crate) struct KdTreeChoices {
    pub(crate) builder: String,
    pub(crate) traversal: String,
}

/// How large pictures are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) enum Resolution {
    /// As many pixels as the screen shows.
    #[default]
    Window,
    /// A pixel for each block of so many by so many.
    Fraction(u32),
    /// Always the same.
    Fixed([u32; 2]),
}

/// What is around the scene.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) enum SurroundingsChoice {
    #[default]
    Sky,
    /// A linear colour.
    Color([f32; 3]),
}

impl Default for Choices {
    fn default() -> Self {
        Self {
            engine: EngineChoice::default(),
            structure: StructureChoice::default(),
            listed: ListedChoices::default(),
            uniform: UniformChoices::default(),
            kd_tree: KdTreeChoices::default(),
            culls_back_faces: false,
            bounces: 0,
            samples: 1,
            resolution: Resolution::default(),
            exposure_stops: 0.0,
            clips: false,
            surroundings: SurroundingsChoice::default(),
        }
    }
}

impl Default for UniformChoices {
    fn default() -> Self {
        let UniformOptions { cells_per_triangle, packet, .. } = UniformOptions::DEFAULT;
        Self { cells_per_triangle, packet: packet.pixels() }
    }
}

impl Default for KdTreeChoices {
    fn default() -> Self {
        let KdTreeOptions { builder, traversal, .. } = KdTreeOptions::FAST;
        Self { builder: builder.to_string(), traversal: traversal.to_string() }
    }
}

impl KdTreeChoices {
    /// Names that no version knows stand for the defaults.
    fn options(&self) -> KdTreeOptions {
        let default = KdTreeOptions::FAST;
        KdTreeOptions {
            builder: self.builder.parse::<KdBuilder>().unwrap_or(default.builder),
            traversal: self.traversal.parse::<KdTraversal>().unwrap_or(default.traversal),
            ..default
        }
    }
}

impl Default for ListedChoices {
    fn default() -> Self {
        let (cells, light) = (Cells::DEFAULT, ListedLightOptions::DEFAULT);
        Self {
            sorting_tile: cells.sorting_tile(),
            tracing_tiles: cells.tracing_tiles(),
            slices: cells.slices(),
            light_cells: light.cells(),
            light_rays: light.points(),
            light_triangles: light.triangles(),
        }
    }
}

impl Choices {
    /// The settings of a picture for a screen of so many pixels, but for its camera and lights.
    ///
    /// # Errors
    /// Where a structure's parameters don't go together.
    pub(crate) fn settings(&self, screen: [u32; 2]) -> Result<Settings, String> {
        let [width, height] = self.resolution.size(screen);
        Ok(Settings {
            width,
            height,
            samples: self.samples.clamp(1, Settings::MAX_SAMPLES),
            camera: CameraChoice::Default,
            lights: None,
            structure: self.structure()?,
            sides: if self.culls_back_faces { Sides::Front } else { Sides::Both },
            // A GPU follows none.
            bounces: if self.engine == EngineChoice::Cpu { self.bounces.min(Settings::MAX_BOUNCES) } else { 0 },
            background: match self.surroundings {
                SurroundingsChoice::Sky => Background::Sky,
                SurroundingsChoice::Color(color) => Background::Color(color.into()),
            },
            exposure_stops: self.exposure_stops,
            tone_map: if self.clips { ToneMap::Clip } else { ToneMap::PbrNeutral },
        })
    }

    fn structure(&self) -> Result<Structure, String> {
        let chosen = &self.listed;
        match (&self.engine, self.structure) {
            (EngineChoice::Gpu(_), _) | (_, StructureChoice::Perspective) => Ok(Structure::Perspective),
            (_, StructureChoice::KdTree) => Ok(Structure::KdTree(self.kd_tree.options())),
            (_, StructureChoice::Bvh) => Ok(Structure::Bvh),
            (_, StructureChoice::Grid) => {
                let UniformChoices { cells_per_triangle, packet } = self.uniform;
                let default = UniformOptions::DEFAULT;
                let packet = PacketSide::ALL.into_iter().find(|side| side.pixels() == packet).unwrap_or(default.packet);
                let options = UniformOptions { cells_per_triangle, packet, ..default };
                options.check().map_err(|impossible| impossible.to_string())?;
                Ok(Structure::Grid(options))
            }
            (_, StructureChoice::Listed) => {
                let cells = Cells::new(chosen.sorting_tile, chosen.tracing_tiles, chosen.slices);
                let light = ListedLightOptions::new(chosen.light_cells, chosen.light_rays, chosen.light_triangles);
                Ok(Structure::Listed {
                    camera: ListedOptions {
                        cells: cells.map_err(|impossible| impossible.to_string())?,
                        ..ListedOptions::DEFAULT
                    },
                    light: light.map_err(|impossible| impossible.to_string())?,
                })
            }
        }
    }
}

impl Resolution {
    /// The size of a picture on a screen of so many pixels; at least one pixel.
    pub(crate) fn size(self, screen: [u32; 2]) -> [u32; 2] {
        let size = match self {
            Self::Window => screen,
            Self::Fraction(side) => screen.map(|pixels| pixels.div_ceil(side.max(1))),
            Self::Fixed(size) => size,
        };
        size.map(|side| side.clamp(1, Settings::MAX_SIDE))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_are_as_large_as_chosen() {
        assert_eq!(Resolution::Window.size([800, 600]), [800, 600]);
        assert_eq!(Resolution::Fraction(2).size([801, 600]), [401, 300]);
        assert_eq!(Resolution::Fixed([64, 32]).size([801, 600]), [64, 32]);
        // A window without height has no picture of no pixels.
        assert_eq!(Resolution::Window.size([800, 0]), [800, 1]);
    }

    #[test]
    fn impossible_parameters_are_refused_in_words() {
        let listed = ListedChoices { sorting_tile: 7, ..ListedChoices::default() };
        let choices = Choices { structure: StructureChoice::Listed, listed, ..Choices::default() };
        assert!(choices.settings([8, 8]).expect_err("no such tile").contains('7'));
        // They don't matter to a GPU.
        let on_gpu = Choices { engine: EngineChoice::Gpu(String::new()), ..choices };
        assert_eq!(on_gpu.settings([8, 8]).expect("settings").structure, Structure::Perspective);
    }

    #[test]
    fn the_defaults_are_the_librarys() {
        let settings = Choices::default().settings([1280, 720]).expect("settings");
        let expected = Settings::default();
        assert_eq!((settings.width, settings.height), (expected.width, expected.height));
        assert_eq!((settings.samples, settings.structure), (expected.samples, expected.structure));
        assert_eq!((settings.exposure_stops, settings.tone_map), (expected.exposure_stops, expected.tone_map));
        let listed = Choices { structure: StructureChoice::Listed, ..Choices::default() };
        assert_eq!(listed.settings([8, 8]).expect("settings").structure, Structure::LISTED);
        let kd_tree = Choices { structure: StructureChoice::KdTree, ..Choices::default() };
        assert_eq!(kd_tree.settings([8, 8]).expect("settings").structure, Structure::KD_TREE);
    }
}
