//! Names of the choices that have no options of their own.

use umbrage_rays::{PixelCounts, choices};

use crate::output::{Chroma, Compression, Format};
use crate::{PixelView, ToneMap};

/// The engine that renders.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum EngineKind {
    /// A GPU where there is one, else the CPU.
    Auto,
    /// The CPU.
    #[default]
    Cpu,
    /// A GPU, or a program that stands in for one.
    Gpu,
}

/// The count that a heat map shows for each pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum HeatKind {
    /// Triangles tested on its sample.
    #[default]
    Tested,
    /// Cells of the camera's grid that were searched for it.
    Cells,
    /// Tests that the filter left undecided.
    Undecided,
    /// Triangles listed in the cells of its tile.
    Pairs,
    /// Points in its point's cell of a light's grid.
    Points,
}

impl HeatKind {
    /// The title beside its colours.
    #[must_use]
    pub fn title(self) -> &'static str {
        match self {
            Self::Tested => "triangles tested",
            Self::Cells => "cells visited",
            Self::Undecided => "undecided tests",
            Self::Pairs => "pairs per tile",
            Self::Points => "points per light cell",
        }
    }

    /// Its count in the work of a pixel's camera ray; `None` for points, which aren't work of camera rays.
    #[must_use]
    pub fn of(self, work: PixelCounts) -> Option<u32> {
        match self {
            Self::Tested => Some(work.tested),
            Self::Cells => Some(work.cells),
            Self::Undecided => Some(work.undecided),
            Self::Pairs => Some(work.pairs),
            Self::Points => None,
        }
    }
}

choices! { EngineKind, "engine":
    "auto" => Auto, "a GPU where there is one, else the CPU";
    "cpu" => Cpu, "the CPU";
    "gpu" => Gpu, "a GPU, or a program that stands in for one";
}

choices! { HeatKind, "heat map":
    "tested" => Tested, "triangles tested on the pixel";
    "cells" => Cells, "cells with triangles that were searched for it";
    "undecided" => Undecided, "tests on it that the filter left undecided";
    "pairs" => Pairs, "triangles listed in the cells of its tile, looked at or not";
    "points" => Points, "points in the same cell of a light's grid as the one that it shows";
}

choices! { PixelView, "view of pixels":
    "normals" => Normals, "shading normals: red is x, green is y, blue is z";
    "uv" => Uv, "texture coordinates: red is u, green is v; black without any";
    "depth" => Depth, "depth: white at the nearest, darker farther away";
    "wireframe" => Wireframe, "the edges of triangles, over grey";
}

choices! { ToneMap, "tone map":
    "neutral" => PbrNeutral, "Khronos PBR Neutral: colours stay, highlights are compressed";
    "clip" => Clip, "what is too bright is cut off";
}

choices! { Format, "format":
    "png" => Png, "8 or 16 bits a channel; one file for each frame";
    "jpg" => Jpeg, "small, with a loss that --quality sets; one file for each frame";
    "webp" => WebP, "8 bits a channel without loss; one file for each frame";
    "exr" => Exr, "linear radiance, depth, normals, triangle ids and layers; one file for each frame";
    "gif" => Gif, "an animation of at most 256 colours a frame";
    "apng" => Apng, "an animated PNG";
    "mp4" => Mp4, "H.264 video, by the program ffmpeg";
    "y4m" => Y4m, "uncompressed video that encoders read";
}

choices! { Chroma, "chroma":
    "420" => Quarter, "one colour for four pixels";
    "444" => Full, "one colour for each pixel";
}

choices! { Compression, "compression":
    "fast" => Fast, "quickly";
    "small" => Small, "files about a fifth smaller, in ten times the time";
}

#[cfg(test)]
mod tests {
    use umbrage_rays::Choice;

    use super::*;
    use crate::Sides;

    fn names<T: Choice + ToString + std::str::FromStr>() -> Vec<String> {
        assert!(T::all().all(|value| value.to_string().parse::<T>().is_ok_and(|parsed| parsed == value)));
        T::all().map(|value| value.to_string()).collect()
    }

    #[test]
    fn names_stay() {
        assert_eq!(names::<EngineKind>(), ["auto", "cpu", "gpu"]);
        assert_eq!(names::<HeatKind>(), ["tested", "cells", "undecided", "pairs", "points"]);
        assert_eq!(names::<PixelView>(), ["normals", "uv", "depth", "wireframe"]);
        assert_eq!(names::<ToneMap>(), ["neutral", "clip"]);
        assert_eq!(names::<Sides>(), ["file", "both", "front"]);
        assert_eq!(names::<Format>(), ["png", "jpg", "webp", "exr", "gif", "apng", "mp4", "y4m"]);
        assert_eq!(names::<Chroma>(), ["420", "444"]);
        assert_eq!(names::<Compression>(), ["fast", "small"]);
    }
}
