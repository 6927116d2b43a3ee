use std::path::PathBuf;

use clap::{Args, Parser, Subcommand, ValueEnum};
use clap_complete::Shell;
use umbrage::Settings;
use umbrage::output::{Format, FrameRate};
use umbrage::rays::SimdLevel;

use crate::kd_tree::KdTreeFlags;
use crate::lights::LightFlag;
use crate::values::{self, BackgroundFlag, CameraFlag, FrameRange, Size};

/// Lines of at most 80 characters, since longer ones are broken.
const EXAMPLES: &str = "\
Examples:
  umbrage render
      The built-in cloth, as umbrage.png
  umbrage render demo:glass --time 1.5 --samples 4 -o glass.png
      One moment of another built-in scene, four rays a pixel
  umbrage render demo:shatter --frames 0..24 --size 640x360 -o shatter.gif
      An animation of one second
  umbrage render 'demo:cloth?triangles=20000' --frames 0..3 -o cloth_%04d.exr
      Numbered frames with depth, normals and triangle ids
  umbrage render demo:forest --format y4m -o - | ffmpeg -i - forest.mp4
      The whole animation, through an encoder; its colours are BT.709's
  umbrage render demo:glass --bounces 4 -o mirrors.png
      With what smooth surfaces mirror
  umbrage render demo:stadium --camera 9,4,9:0,1,0:30 --light sun:-1,-2,-1
      One's own camera and light
  umbrage render demo:marbles --frames 0..24 --orbit-light -o orbit.apng
      The light goes round the scene
  umbrage render demo:cloth --frames 0..9 -o %d.png --stats json
      What each frame cost
  umbrage render demo:statue --engine auto --stats text
      On a GPU, where there is one; `umbrage info --devices` lists them
  umbrage view demo:marbles
      A window, where the command was built with it
  umbrage heatmap demo:forest --structure listed --sorting-tile 8 --max 200
      How many triangles each pixel is tested with
  umbrage heatmap demo:glass --of points --light 1
      How many points share a cell of the second light's grid
  umbrage render demo:hall --structure kdtree --kd-traversal short-stack:8
      The same picture through a kd-tree
  umbrage info demo:cloth --json
      What is in a scene
  umbrage info demo:cloth --structure --kd-builder presorted
      How deep its kd-tree is, and how good";

/// The end of `--help` and of the manual page.
const EXIT_CODES: &str = "\
Exit codes:
  0  done
  1  rendering or writing failed
  2  the flags, the scene or a file that they name is wrong

A file appears under its name only when it is whole. Until then it is a hidden file, .NAME.partial-*, beside it; \
killing the command may leave that behind.";

/// Ray traces triangle scenes that change completely every frame, with exact visibility and exact shadows.
#[derive(Debug, Parser)]
#[command(
    name = "umbrage",
    version,
    after_help = format!("{EXAMPLES}\n\n{EXIT_CODES}"),
    arg_required_else_help = true,
    args_override_self = true
)]
pub(crate) struct Flags {
    #[command(subcommand)]
    pub(crate) command: Command,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Render a picture, numbered frames, an animation or raw video
    #[command(after_help = format!("{EXAMPLES}\n\n{EXIT_CODES}"), args_override_self = true)]
    Render(Box<RenderFlags>),
    /// Open a window that plays a scene, lets its lights be dragged and shows where the time goes
    #[command(args_override_self = true)]
    View(Box<ViewFlags>),
    /// Draw how much work each pixel is: triangles tested, cells visited, tests left undecided, pairs listed in its tile,
    /// or points in its cell for a light
    #[command(args_override_self = true)]
    Heatmap(Box<HeatmapFlags>),
    /// Show what is in a scene, or without one which scenes are built in
    Info(InfoFlags),
    /// Print a completion script for a shell
    Completions {
        /// The shell
        shell: Shell,
    },
    /// Print the manual page, or write all pages into a folder
    Man {
        /// The folder, which must exist
        #[arg(long = "dir", value_name = "DIR")]
        folder: Option<PathBuf>,
    },
}

#[derive(Args, Debug)]
pub(crate) struct InfoFlags {
    /// A .gltf, .glb, .obj, .ply or .stl file, a folder or pattern of numbered ones, or demo:NAME
    pub(crate) scene: Option<PathBuf>,
    /// As JSON
    #[arg(long)]
    pub(crate) json: bool,
    /// Show which GPUs there are instead
    #[arg(long, conflicts_with = "scene")]
    pub(crate) devices: bool,
    /// Build the kd-tree as well and say what came of it: depth, leaves, references, cost by the surface area heuristic
    #[arg(long, conflicts_with = "devices", requires = "scene")]
    pub(crate) structure: bool,
    #[command(flatten)]
    pub(crate) kd_tree: KdTreeFlags,
    #[command(flatten)]
    pub(crate) opening: OpeningFlags,
}

/// How a scene is opened.
#[derive(Args, Debug)]
pub(crate) struct OpeningFlags {
    /// Which of the file's animations play: a name or a number from 0, `all` or `none`
    /// [default: all where no two move the same thing, else the first]
    #[arg(long, value_name = "NAME|NUMBER|all|none")]
    pub(crate) animation: Option<String>,
    /// How many files of a numbered sequence make a second
    #[arg(long, value_name = "FPS", default_value = "24", value_parser = values::sequence_fps)]
    pub(crate) sequence_fps: f64,
}

#[derive(Args, Debug)]
pub(crate) struct RenderFlags {
    /// A .gltf, .glb, .obj, .ply or .stl file, a folder or pattern of numbered ones, or demo:NAME
    /// [default: demo:cloth]
    pub(crate) scene: Option<PathBuf>,
    /// The file to write: .png, .exr, .gif, .apng or .y4m; with %04d, a numbered .png or .exr for each frame; `-`
    /// for standard output (y4m only) [default: umbrage.png; umbrage_%04d.png for several frames]
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,
    /// The file's format, whatever its name
    #[arg(long, value_enum)]
    pub(crate) format: Option<FormatFlag>,
    /// The moment to show; the animation starts again after its end
    #[arg(long, value_name = "SECONDS", value_parser = values::seconds, conflicts_with = "frames", allow_negative_numbers = true)]
    pub(crate) time: Option<f64>,
    /// Frames to show, without B (0..24) or with it (0..=23); frame k shows second k / FPS
    /// [default for animations: all]
    #[arg(long, value_name = "A..B")]
    pub(crate) frames: Option<FrameRange>,
    /// Frames a second, such as 24, 29.97 or 30000/1001
    #[arg(long, default_value = "24")]
    pub(crate) fps: FrameRate,
    /// Width and height in pixels
    #[arg(long, value_name = "WxH", default_value = "1280x720")]
    pub(crate) size: Size,
    /// Camera rays for each pixel
    #[arg(long, value_name = "N", default_value = "1", value_parser = values::samples())]
    pub(crate) samples: u32,
    /// A camera of the scene by name or by number from 0, or a new one at X,Y,Z that looks at another place, with
    /// its vertical field of view in degrees (40) [default: the scene's first, else one that sees everything]
    #[arg(long, value_name = "NAME|NUMBER|X,Y,Z:X,Y,Z[:FOV]", allow_hyphen_values = true)]
    pub(crate) camera: Option<CameraFlag>,
    /// A light in place of the scene's; may be given several times:
    /// point:X,Y,Z[:CANDELA[:R,G,B]], sun:DX,DY,DZ[:LUX[:R,G,B]] that travels along DX,DY,DZ, or
    /// spot:X,Y,Z:X,Y,Z:DEGREES[:CANDELA[:R,G,B]] with the cone's full angle; with :noshadow at its end nothing keeps the
    /// light away. Without a strength, it is as bright as
    /// full sunlight: at the scene's centre, or where the spot points to
    #[arg(long = "light", value_name = "LIGHT")]
    pub(crate) lights: Vec<LightFlag>,
    /// Move the first light once round the scene's vertical axis over the frames
    #[arg(long)]
    pub(crate) orbit_light: bool,
    /// What is behind and around the scene: sky, #rrggbb, linear R,G,B, or a latitude-longitude image
    #[arg(long, value_name = "sky|COLOR|FILE", default_value = "sky")]
    pub(crate) background: BackgroundFlag,
    /// Brightness: each stop doubles it
    #[arg(
        long,
        value_name = "STOPS",
        default_value = "0",
        allow_hyphen_values = true,
        value_parser = values::exposure_stops
    )]
    pub(crate) exposure: f32,
    /// What renders: triangles and shadows are the same, colours differ by rounding
    #[arg(long, value_enum, default_value = "cpu")]
    pub(crate) engine: EngineFlag,
    /// The GPU, by a part of its name; `umbrage info --devices` lists them [default: the first]
    #[arg(long, value_name = "NAME")]
    pub(crate) device: Option<String>,
    /// What finds the triangles that rays hit on the CPU; the picture is the same either way
    #[arg(long, value_enum, default_value = "perspective")]
    pub(crate) structure: StructureFlag,
    /// Cells a side of the light grids of `--structure listed`, 1 to 2048 [default: 192]
    #[arg(long, value_name = "N")]
    pub(crate) light_cells: Option<u32>,
    /// The most shadow rays in one of their blocks of work, the paper's r, 1 to 4096 [default: 256]
    #[arg(long, value_name = "R")]
    pub(crate) light_rays: Option<u32>,
    /// The most triangles in one of them, 1 to 4096 [default: 512]
    #[arg(long, value_name = "N")]
    pub(crate) light_triangles: Option<u32>,
    /// Cells of `--structure grid` for each triangle, λ of its paper, above 0 [default: 6]
    #[arg(long, value_name = "LAMBDA", allow_negative_numbers = true)]
    pub(crate) grid_density: Option<f64>,
    /// Let its cells that list more than N triangles hold grids of their own, for scenes of very uneven density [default: 64
    /// for scenes with surfaces that one sees through, else none do]
    #[arg(long, value_name = "N")]
    pub(crate) grid_nested: Option<u32>,
    /// Pixels a side of its packets: 2, 4, 8, 16 or 32 [default: 32]
    #[arg(long, value_name = "N")]
    pub(crate) packet: Option<u32>,
    #[command(flatten)]
    pub(crate) kd_tree: KdTreeFlags,
    /// See through triangles whose corners are seen clockwise; they cast shadows all the same
    #[arg(long)]
    pub(crate) cull_back_faces: bool,
    /// Mirrors that light may come by, one after the other, 0 to 1024: with 0, smooth surfaces show the background alone
    #[arg(long, value_name = "N", default_value = "0", value_parser = clap::value_parser!(u32).range(..=i64::from(Settings::MAX_BOUNCES)))]
    pub(crate) bounces: u32,
    /// From radiance to the screen
    #[arg(long, value_enum, default_value = "neutral")]
    pub(crate) tone_map: ToneMapFlag,
    /// Bits for each channel: 8 or 16 of a PNG or APNG, 16 or 32 of an EXR [default: 8; 16 for EXR]
    #[arg(long, value_name = "8|16|32")]
    pub(crate) bit_depth: Option<u8>,
    /// Colours of raw video: one for four pixels, or one for each
    #[arg(long, value_enum, default_value = "420")]
    pub(crate) chroma: ChromaFlag,
    /// Threads to work with [default: one for each core]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(crate) threads: Option<u16>,
    /// SIMD instructions for the grids: sse2, sse4.2, avx2 or avx512, as far as this machine has them; the picture is
    /// the same [default: the widest]
    #[arg(long, value_name = "LEVEL")]
    pub(crate) simd: Option<SimdLevel>,
    /// Say what each frame cost: `text` on standard error, or `json` on standard output (on standard error when the
    /// video goes to standard output)
    #[arg(long, value_enum, value_name = "FORM")]
    pub(crate) stats: Option<StatsFlag>,
    /// Say nothing but errors
    #[arg(short, long)]
    pub(crate) quiet: bool,
    #[command(flatten)]
    pub(crate) opening: OpeningFlags,
}

#[derive(Args, Debug)]
pub(crate) struct HeatmapFlags {
    /// A .gltf, .glb, .obj, .ply or .stl file, a folder or pattern of numbered ones, or demo:NAME
    /// [default: demo:cloth]
    pub(crate) scene: Option<PathBuf>,
    /// The PNG to write [default: heatmap.png]
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,
    /// What the colours show
    #[arg(long, value_enum, default_value = "tested")]
    pub(crate) of: CountedFlag,
    /// The light whose grid `--of points` shows, by number from 0; `umbrage info` lists them [default: 0]
    #[arg(long, value_name = "N")]
    pub(crate) light: Option<usize>,
    /// What finds the triangles that camera rays hit, and holds points for lights
    #[arg(long, value_enum, default_value = "listed")]
    pub(crate) structure: GridFlag,
    /// Pixels a side of the tiles that triangles are listed in: 8, 16, 32 or 64
    #[arg(long, value_name = "PIXELS")]
    pub(crate) sorting_tile: Option<u32>,
    /// Sorting tiles a side of the tiles that are searched at once: 1, 2, 4 or 8, of 64 pixels at most
    #[arg(long, value_name = "K")]
    pub(crate) tracing_tiles: Option<u32>,
    /// Depth slices, 1 to 64
    #[arg(long, value_name = "N")]
    pub(crate) slices: Option<u32>,
    /// Test all triangles of a cell on all pixels of its tile, as one GPU thread for each pixel does
    #[arg(long)]
    pub(crate) whole_tiles: bool,
    /// The count that has the last colour [default: one that few pixels exceed]
    #[arg(long, value_name = "COUNT", value_parser = clap::value_parser!(u32).range(1..=1_000_000_000))]
    pub(crate) max: Option<u32>,
    /// The moment to show; the animation starts again after its end
    #[arg(long, value_name = "SECONDS", value_parser = values::seconds, allow_negative_numbers = true)]
    pub(crate) time: Option<f64>,
    /// Width and height in pixels, without the legend
    #[arg(long, value_name = "WxH", default_value = "1024x1024")]
    pub(crate) size: Size,
    /// A camera of the scene by name or by number from 0, or a new one at X,Y,Z that looks at another place, with
    /// its vertical field of view in degrees (40) [default: the scene's first, else one that sees everything]
    #[arg(long, value_name = "NAME|NUMBER|X,Y,Z:X,Y,Z[:FOV]", allow_hyphen_values = true)]
    pub(crate) camera: Option<CameraFlag>,
    /// Threads to work with [default: one for each core]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(crate) threads: Option<u16>,
    #[command(flatten)]
    pub(crate) opening: OpeningFlags,
}

#[derive(Args, Debug)]
pub(crate) struct ViewFlags {
    /// A .gltf, .glb, .obj, .ply or .stl file, a folder or pattern of numbered ones, or demo:NAME
    /// [default: demo:cloth]
    pub(crate) scene: Option<PathBuf>,
    /// Read the file again whenever it changes
    #[arg(long)]
    pub(crate) watch: bool,
    /// What renders at first [default: as in the last window]
    #[arg(long, value_enum)]
    pub(crate) engine: Option<EngineFlag>,
    /// The GPU, by a part of its name; `umbrage info --devices` lists them [default: the first]
    #[arg(long, value_name = "NAME")]
    pub(crate) device: Option<String>,
    /// Width and height of pictures in pixels [default: as in the last window, at first the window's own]
    #[arg(long, value_name = "WxH")]
    pub(crate) size: Option<Size>,
    /// Neither recall the last window's settings nor keep this one's
    #[arg(long)]
    pub(crate) forget: bool,
    /// Threads to work with [default: one for each core]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(crate) threads: Option<u16>,
    #[command(flatten)]
    pub(crate) opening: OpeningFlags,
}

/// What a heat map shows.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum CountedFlag {
    /// Triangles tested on the pixel
    Tested,
    /// Cells with triangles that were searched for it
    Cells,
    /// Tests on it that the filter left undecided
    Undecided,
    /// Triangles listed in the cells of its tile, looked at or not
    Pairs,
    /// Points that share a cell of a light's grid with the one it shows
    Points,
}

/// Structures whose work is counted pixel by pixel.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum GridFlag {
    /// The grid that tests small triangles directly
    Perspective,
    /// The same in its paper's form, with triangles listed by cell
    Listed,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum FormatFlag {
    Png,
    Exr,
    Gif,
    Apng,
    Y4m,
}

impl From<FormatFlag> for Format {
    fn from(flag: FormatFlag) -> Self {
        match flag {
            FormatFlag::Png => Self::Png,
            FormatFlag::Exr => Self::Exr,
            FormatFlag::Gif => Self::Gif,
            FormatFlag::Apng => Self::Apng,
            FormatFlag::Y4m => Self::Y4m,
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum StructureFlag {
    /// Grids made for the camera's and the lights' rays
    Perspective,
    /// The same in their paper's form, with triangles listed by cell
    Listed,
    /// A uniform grid for all rays, traced in packets
    Grid,
    /// A kd-tree for all rays
    #[value(name = "kdtree")]
    KdTree,
    /// A bounding volume hierarchy
    Bvh,
}

/// What renders.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum EngineFlag {
    /// A GPU where there is one, else the CPU
    Auto,
    /// The CPU
    Cpu,
    /// A GPU, or a program that stands in for one
    Gpu,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum ToneMapFlag {
    /// Khronos PBR Neutral: colours stay, highlights are compressed
    Neutral,
    /// What is too bright is cut off
    Clip,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum ChromaFlag {
    /// 4:2:0
    #[value(name = "420")]
    Quarter,
    /// 4:4:4
    #[value(name = "444")]
    Full,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum StatsFlag {
    Text,
    Json,
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    #[test]
    fn the_flags_are_consistent() {
        super::Flags::command().debug_assert();
    }
}
