use std::path::PathBuf;

use bytesize::ByteSize;
use clap::{Args, Parser, Subcommand, ValueEnum};
use clap_complete::Shell;
use umbrage::output::{Chroma, Compression, Format, FrameRate};
use umbrage::rays::SimdLevel;
use umbrage::scene::{Clip, GroundChoice, OpenOptions};
use umbrage::spec::{BackgroundSpec, CameraSpec, Length, LightSpec};
use umbrage::{EngineKind, HeatKind, Layers, PixelView, Settings, Sides, Structure, ToneMap};

use crate::choices::{choice, engine, layers, structure};
use crate::pages::{COMPLETIONS_EXAMPLES, MAN_EXAMPLES};
use crate::staging::OrbitingLights;
use crate::values::{self, ExposureFlag, FrameRange, Shard, Size};

// Lines of examples have at most 80 characters, since longer ones are broken.

const OPEN_EXAMPLES: &str = "
  umbrage model.glb
      A model in a window, or where there is none a picture beside it";

const RENDER_EXAMPLES: &str = "
  umbrage render
      The built-in cloth, as umbrage.png
  umbrage render demo:glass --time 1.5 --samples 16 --bounces 8 -o glass.png
      One moment of another built-in scene, with mirrors and glass
  umbrage render demo:shatter --frames 0..24 --size 640x360 -o shatter.gif
      An animation of one second
  umbrage render demo:forest --format y4m -o - | ffmpeg -i - forest.mp4
      The whole animation, through an encoder; its colours are BT.709's
  umbrage render demo:gears --frames 0..48 -o g_%04d.png --shard 2/3 --resume
      The second third of the frames, without those that are there already
  umbrage render demo:marbles --layers shadow,motion,cryptomatte -o marbles.exr
      Layers for compositing; docs/files.md has their channels
  umbrage render demo:marbles --aperture 2% --light rect:3,3,2:0,0.5,0:2.5x0.6
      A lens and a panel of light; docs/effects.md has more of these
  umbrage render demo:stadium --camera 9,4,9:0,1,0:30 --light sun:-1,-2,-1
      One's own camera and light
  umbrage render demo:statue --engine auto --stats text
      On a GPU, where there is one, and the cost of each frame";

const VIEW_EXAMPLES: &str = "
  umbrage view demo:marbles
      A window, where the command was built with it";

const HEATMAP_EXAMPLES: &str = "
  umbrage heatmap demo:forest --max 200
      How many triangles each pixel is tested with
  umbrage heatmap demo:glass --of points --light 1
      How many points share a cell of the second light's grid";

const INFO_EXAMPLES: &str = "
  umbrage info
      Which scenes are built in
  umbrage info demo:cloth --json
      The content of a scene";

const STRUCTURES_EXAMPLES: &str = "
  umbrage structures
      Which structures there are
  umbrage structures perspective
      The options of one";

/// The end of `--help` and of the manual page.
const EXIT_CODES: &str = "\
Exit codes:
  0  done
  1  rendering or writing failed
  2  the flags, the scene or a file that they name is wrong

A file appears under its name only when it is whole. Until then it is a hidden file, .NAME.partial-*, beside it. \
Interrupting the command (Ctrl-C, SIGTERM: 130 and 143 in a shell) removes that; what killing it leaves behind, the next \
render to the same name removes.";

/// The text below the flags in `--help`.
fn below(examples: &[&str]) -> String {
    format!("Examples:{}\n\n{EXIT_CODES}", examples.concat())
}

/// Ray traces triangle scenes that change completely every frame, with exact visibility and exact shadows.
#[derive(Debug, Parser)]
#[command(
    name = "umbrage",
    version,
    after_help = below(&[OPEN_EXAMPLES, RENDER_EXAMPLES, VIEW_EXAMPLES, HEATMAP_EXAMPLES, INFO_EXAMPLES]),
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
    #[command(
        after_help = "`umbrage render --help` has the other options, and examples",
        after_long_help = below(&[RENDER_EXAMPLES]),
        args_override_self = true
    )]
    Render(Box<RenderFlags>),
    /// Open a window that plays a scene, lets its lights be dragged and shows where the time goes
    #[command(after_help = below(&[VIEW_EXAMPLES]), args_override_self = true)]
    View(Box<ViewFlags>),
    /// Draw how much work each pixel is: triangles tested, cells visited, tests left undecided, pairs listed in its tile,
    /// or points in its cell for a light
    #[command(after_help = below(&[HEATMAP_EXAMPLES]), args_override_self = true)]
    Heatmap(Box<HeatmapFlags>),
    /// Show the content of a scene, or without one the built-in scenes
    #[command(after_help = below(&[INFO_EXAMPLES]))]
    Info(Box<InfoFlags>),
    /// List the structures that find the triangles that rays hit, or one with its paper and its options
    #[command(after_help = below(&[STRUCTURES_EXAMPLES]))]
    Structures {
        /// The structure
        #[arg(value_parser = structure(|_| true))]
        name: Option<Structure>,
    },
    /// Print a completion script for a shell
    #[command(after_help = below(&[COMPLETIONS_EXAMPLES]))]
    Completions {
        /// The shell
        shell: Shell,
    },
    /// Print the manual page, or write all pages into a folder
    #[command(after_help = below(&[MAN_EXAMPLES]))]
    Man {
        /// The folder, which must exist
        #[arg(long = "dir", value_name = "DIR")]
        folder: Option<PathBuf>,
    },
}

#[derive(Args, Debug)]
pub(crate) struct InfoFlags {
    /// A .gltf, .glb, .obj, .ply, .stl, .pc2 or .mdd file, a folder or pattern of numbered ones, or demo:NAME
    pub(crate) scene: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
    /// Show which GPUs there are, rather than a scene
    #[arg(long, conflicts_with = "scene")]
    pub(crate) devices: bool,
    /// Build this kd-tree as well, and say its depth, leaves, references and cost by the surface area heuristic: kdtree, or
    /// kdtree:OPTION=VALUE,OPTION=VALUE
    #[cfg(feature = "papers")]
    #[arg(
        long,
        value_name = "STRUCTURE",
        conflicts_with = "devices",
        requires = "scene",
        value_parser = structure(|structure| structure.name() == "kdtree")
    )]
    pub(crate) structure: Option<Structure>,
    #[command(flatten)]
    pub(crate) opening: OpeningFlags,
}

/// How a scene is opened.
#[derive(Args, Debug)]
pub(crate) struct OpeningFlags {
    /// Animations that play: a name or a number from 0, `all` or `none` [default: all where no two move the same thing,
    /// else the first]
    #[arg(long, value_name = "NAME|NUMBER|all|none", hide_short_help = true)]
    pub(crate) animation: Option<String>,
    /// Variant whose materials are shown, as `umbrage info` lists them [default: the file's own]
    #[arg(long, value_name = "NAME", hide_short_help = true)]
    pub(crate) variant: Option<String>,
    /// Hide an object that `umbrage info` lists; may be given several times, * is any characters
    #[arg(long, value_name = "NAME", hide_short_help = true)]
    pub(crate) hide: Vec<String>,
    /// Files of a numbered sequence, or frames of a .pc2 file, that make a second
    #[arg(long, value_name = "FPS", default_value = "24", value_parser = values::sequence_fps, hide_short_help = true)]
    pub(crate) sequence_fps: f64,
    /// Let the file name others outside of its own folder; for files that you trust
    #[arg(long, hide_short_help = true)]
    pub(crate) allow_outside: bool,
    /// Maximum memory of scene, background and picture, each, such as 4GiB [default: half of all]
    #[arg(long, value_name = "SIZE", value_parser = memory, hide_short_help = true)]
    pub(crate) max_memory: Option<ByteSize>,
    /// Floor at the scene's lowest point or at a height: `shadow` shows only shadows, `matte` is light grey [default in
    /// pictures: `shadow` under files that have neither lights nor a floor, else `none`]
    #[arg(long, value_name = "none|auto|shadow|matte[:HEIGHT]")]
    pub(crate) ground: Option<GroundChoice>,
    /// Degrees up to which triangles without normals are smooth together; 0: flat
    #[arg(long, value_name = "DEGREES", default_value_t = OpenOptions::default().crease_degrees, value_parser = values::crease, hide_short_help = true)]
    pub(crate) crease: f32,
}

fn memory(text: &str) -> Result<ByteSize, &'static str> {
    text.parse().map_err(|_| "a size is needed, such as 500MB, 4GiB or a number of bytes")
}

impl OpeningFlags {
    pub(crate) fn options(&self) -> OpenOptions {
        let clip = match self.animation.as_deref() {
            None => Clip::Auto,
            Some("all") => Clip::All,
            Some("none") => Clip::Rest,
            Some(name) => Clip::Named(name.to_owned()),
        };
        let max_memory = self.max_memory.map_or(OpenOptions::default().max_memory, |most| most.as_u64());
        let Self { sequence_fps, allow_outside, crease: crease_degrees, .. } = *self;
        let ground = self.ground.unwrap_or_default();
        let (variant, hidden) = (self.variant.clone(), self.hide.clone());
        let texture_memory = None;
        OpenOptions {
            clip,
            variant,
            sequence_fps,
            allow_outside,
            max_memory,
            hidden,
            crease_degrees,
            ground,
            texture_memory,
        }
    }

    /// As [`options`](Self::options), where nobody says otherwise with a ground for files that need one.
    pub(crate) fn options_for_pictures(&self) -> OpenOptions {
        let ground = self.ground.unwrap_or(OpenOptions::for_pictures().ground);
        OpenOptions { ground, ..self.options() }
    }
}

impl RenderFlags {
    /// How the scene is opened.
    pub(crate) fn open_options(&self) -> OpenOptions {
        let texture_memory = self.texture_memory.map(|most| most.as_u64());
        OpenOptions { texture_memory, ..self.scene.opening.options_for_pictures() }
    }

    /// A text of all that pictures depend on beside the job's settings and the scene's files.
    pub(crate) fn beside_settings(&self) -> String {
        // Nothing is left out by `..`, so that every new flag is thought of.
        let Self {
            camera,
            lights,
            orbit_light,
            background,
            show,
            exposure,
            engine,
            device,
            scene,
            output: _,
            format: _,
            time: _,
            frames: _,
            shard: _,
            resume: _,
            fps: _,
            size: _,
            samples: _,
            noise: _,
            aperture,
            focus,
            shutter: _,
            light_radius,
            sky_shadows: _,
            structure: _,
            sides: _,
            smooth_terminator: _,
            point_size: _,
            line_width: _,
            bounces: _,
            least_contribution: _,
            gloss: _,
            ambient_occlusion,
            tone_map: _,
            layers: _,
            bit_depth: _,
            quality: _,
            png_compression: _,
            chroma: _,
            texture_memory: _,
            simd: _,
            stats: _,
            quiet: _,
        } = self;
        let SceneFlags { opening, address: _, threads: _ } = scene;
        let OpeningFlags { animation, variant, hide, sequence_fps, allow_outside, ground, crease, max_memory: _ } =
            opening;
        format!(
            "{camera:?} {lights:?} {orbit_light:?} {background:?} {show:?} {engine:?} {device:?} {animation:?} {variant:?} \
             {hide:?} {sequence_fps:?} {allow_outside:?} {ground:?} {crease:?} {exposure:?} {aperture} {focus:?} {light_radius} \
             {ambient_occlusion}"
        )
    }
}

/// The scene that a command is about, and who works on it.
#[derive(Args, Debug)]
pub(crate) struct SceneFlags {
    /// A .gltf, .glb, .obj, .ply, .stl, .pc2 or .mdd file, numbered ones, or demo:NAME [default: demo:cloth]
    #[arg(value_name = "SCENE")]
    address: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) opening: OpeningFlags,
    /// Threads to work with [default: one for each core]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024), hide_short_help = true)]
    pub(crate) threads: Option<u16>,
}

impl SceneFlags {
    pub(crate) fn address(&self) -> PathBuf {
        self.address.clone().unwrap_or_else(|| "demo:cloth".into())
    }
}

#[derive(Args, Debug)]
pub(crate) struct RenderFlags {
    /// File to write: .png, .jpg, .webp, .exr, .gif, .apng, .mp4 (by ffmpeg) or .y4m (also `-`, standard output); %04d
    /// numbers pictures [default: umbrage.png; umbrage_%04d.png for several frames]
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,
    /// Format of the file
    #[arg(long, value_parser = choice::<Format>(), hide_short_help = true)]
    pub(crate) format: Option<Format>,
    /// Moment to show [default: the best one of a demo, else the middle of the animation]
    #[arg(long, value_name = "SECONDS", value_parser = values::seconds, conflicts_with = "frames")]
    pub(crate) time: Option<f64>,
    /// Frames to show, without B (0..24) or with it (0..=23); frame k is second k / FPS [default for animations: all]
    #[arg(long, value_name = "A..B", allow_hyphen_values = true)]
    pub(crate) frames: Option<FrameRange>,
    /// Show one of N even shares of numbered frames, counted from 1, as on machine I of N
    #[arg(long, value_name = "I/N", hide_short_help = true)]
    pub(crate) shard: Option<Shard>,
    /// Leave out numbered frames that were made in the same way before, by records in .umbrage
    #[arg(long, hide_short_help = true)]
    pub(crate) resume: bool,
    /// Frames a second, such as 24, 29.97 or 30000/1001
    #[arg(long, default_value = "24", hide_short_help = true)]
    pub(crate) fps: FrameRate,
    /// Width and height in pixels
    #[arg(long, value_name = "WxH", default_value = "1280x720")]
    pub(crate) size: Size,
    /// Camera rays for each pixel, spread over lens, open shutter and lights [default: 4 for a still, 1 for frames, 64
    /// with any of these]
    #[arg(long, value_name = "N", value_parser = values::samples)]
    pub(crate) samples: Option<u32>,
    /// Sample until noise is below so many levels of 255, at most --samples or 1024
    #[arg(long, value_name = "LEVELS", default_value = "0", value_parser = values::from_zero, hide_short_help = true)]
    pub(crate) noise: f32,
    /// Diameter of the lens, in world units (0.1) or parts of the scene's size (2%)
    #[arg(long, value_name = "LENGTH", default_value = "0", value_parser = values::length, hide_short_help = true)]
    pub(crate) aperture: Length,
    /// Distance of sharp objects from the lens, as --aperture [default: the picture's middle]
    #[arg(long, value_name = "LENGTH", value_parser = values::distance, requires = "aperture", hide_short_help = true)]
    pub(crate) focus: Option<Length>,
    /// Time for which the shutter is open: moving objects leave streaks
    #[arg(long, value_name = "SECONDS", default_value = "0", value_parser = values::seconds, hide_short_help = true)]
    pub(crate) shutter: f64,
    /// Radius of lights without :radius=R, as --aperture, of suns in degrees (0.27)
    #[arg(long, value_name = "LENGTH", default_value = "0", value_parser = values::length, hide_short_help = true)]
    pub(crate) light_radius: Length,
    /// Light from all around (--background) casts shadows: one direction for each sample
    #[arg(long, hide_short_help = true)]
    pub(crate) sky_shadows: bool,
    /// Camera of the scene, by name or number from 0, or at X,Y,Z towards another point with a vertical field of view
    /// in degrees (40) [default: the first, else one that sees everything]
    #[arg(long, value_name = "NAME|NUMBER|X,Y,Z:X,Y,Z[:FOV]", allow_hyphen_values = true)]
    pub(crate) camera: Option<CameraSpec>,
    /// A light in place of the scene's; may be given several times: point:X,Y,Z[:CANDELA[:R,G,B]],
    /// sun:DX,DY,DZ[:LUX[:R,G,B]] along DX,DY,DZ, spot:X,Y,Z:X,Y,Z:DEGREES[:CANDELA[:R,G,B]] with the cone's full
    /// angle, or a panel towards a point, rect:X,Y,Z:X,Y,Z:WIDTHxHEIGHT[:CANDELA[:R,G,B]] or
    /// disk:X,Y,Z:X,Y,Z:RADIUS[:CANDELA[:R,G,B]]; then :radius=R (of suns in degrees) and :noshadow. Colours may be
    /// #rrggbb or names in CSS, sizes as --aperture. Without a strength, it is as bright as full sunlight
    #[arg(long = "light", value_name = "LIGHT")]
    pub(crate) lights: Vec<LightSpec>,
    /// Move lights once round the scene's vertical axis: the first, all, or by numbers (0,2)
    #[arg(
        long,
        value_name = "first|all|N,N",
        num_args = 0..=1,
        require_equals = true,
        default_missing_value = "first",
        hide_short_help = true
    )]
    pub(crate) orbit_light: Option<OrbitingLights>,
    /// Background and its light: sky, a colour (its name in CSS, #rrggbb or linear R,G,B) or a latitude-longitude
    /// image; `none` is transparent, with the light of the sky
    #[arg(long, value_name = "sky|none|COLOR|FILE", default_value = "sky")]
    pub(crate) background: BackgroundSpec,
    /// Brightness in stops, or `auto` by the picture [default: auto for files, 0 for demos]
    #[arg(long, value_name = "auto|STOPS", allow_hyphen_values = true, hide_short_help = true)]
    pub(crate) exposure: Option<ExposureFlag>,
    /// Engine that renders: triangles and shadows are the same, colours differ by rounding
    #[arg(long, default_value = "cpu", value_parser = engine())]
    pub(crate) engine: EngineKind,
    /// The GPU, by a part of its name; `umbrage info --devices` lists them [default: the first]
    #[arg(long, value_name = "NAME", hide_short_help = true)]
    pub(crate) device: Option<String>,
    /// Acceleration structure, with options as NAME:OPTION=VALUE,OPTION=VALUE; `umbrage structures` describes them.
    /// GPUs have perspective, listed and kdtree
    #[arg(long, value_name = "STRUCTURE", default_value = "perspective", value_parser = structure(|_| true))]
    pub(crate) structure: Structure,
    /// Sides of triangles that rays meet
    #[arg(long, value_name = "SIDES", default_value = "file", value_parser = choice::<Sides>(), hide_short_help = true)]
    pub(crate) sides: Sides,
    /// Light ends on round surfaces by vertices' normals, not at whole triangles; on the CPU
    #[arg(long, hide_short_help = true)]
    pub(crate) smooth_terminator: bool,
    /// Diameter of the scene's points, in pixels; on the CPU
    #[arg(long, value_name = "PIXELS", default_value = "2", value_parser = values::mark_size, hide_short_help = true)]
    pub(crate) point_size: f32,
    /// Width of the scene's lines, in pixels; on the CPU
    #[arg(long, value_name = "PIXELS", default_value = "2", value_parser = values::mark_size, hide_short_help = true)]
    pub(crate) line_width: f32,
    /// Mirrors and glass along a path, 0 to 1024 [default: 2 for a still or with --gloss, else 0]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(..=i64::from(Settings::MAX_BOUNCES)))]
    pub(crate) bounces: Option<u32>,
    /// Minimum contribution of paths through mirrors and glass; others are cut
    #[arg(long, value_name = "PART", default_value = "0.002", value_parser = values::from_zero, hide_short_help = true)]
    pub(crate) least_contribution: f32,
    /// Rough surfaces mirror as well, blurred: one direction for each sample
    #[arg(long, hide_short_help = true)]
    pub(crate) gloss: bool,
    /// Objects within this distance, as --aperture, keep light from all around away
    #[arg(
        long,
        value_name = "LENGTH",
        default_value = "0",
        value_parser = values::length,
        conflicts_with = "sky_shadows",
        hide_short_help = true
    )]
    pub(crate) ambient_occlusion: Length,
    /// Tone map of lit surfaces
    #[arg(long, value_name = "NAME", default_value = "neutral", value_parser = choice::<ToneMap>(), hide_short_help = true)]
    pub(crate) tone_map: ToneMap,
    /// Property to show in place of light
    #[arg(long, value_name = "VIEW", value_parser = choice::<PixelView>(), hide_short_help = true)]
    pub(crate) show: Option<PixelView>,
    /// Further layers of an EXR file, with commas between them (docs/files.md); on the CPU
    #[arg(long, value_name = "NAMES", value_parser = layers(), hide_short_help = true)]
    pub(crate) layers: Option<Layers>,
    /// Bits for each channel: 8 or 16 of PNG and APNG, 16 or 32 of EXR [default: 8; 16 for EXR]
    #[arg(long, value_name = "8|16|32", hide_short_help = true)]
    pub(crate) bit_depth: Option<u8>,
    /// Quality of a JPEG, 1 to 100 [default: 92]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(1..=100), hide_short_help = true)]
    pub(crate) quality: Option<u8>,
    /// Compression of PNG and APNG
    #[arg(long, default_value = "fast", value_parser = choice::<Compression>(), hide_short_help = true)]
    pub(crate) png_compression: Compression,
    /// Chroma of raw video, for four pixels or for each
    #[arg(long, default_value = "420", value_parser = choice::<Chroma>(), hide_short_help = true)]
    pub(crate) chroma: Chroma,
    /// Maximum memory for a file's texels, 64KiB or more; others are in a temporary file (in TMPDIR). On the CPU
    /// [default: all]
    #[arg(long, value_name = "SIZE", value_parser = memory, hide_short_help = true)]
    pub(crate) texture_memory: Option<ByteSize>,
    /// SIMD instructions for the grids: sse2, avx2 or avx512 [default: the widest there are]
    #[arg(long, value_name = "LEVEL", hide_short_help = true)]
    pub(crate) simd: Option<SimdLevel>,
    /// Cost of each frame, on standard error as text, or on standard output as JSON (on standard error beside video)
    #[arg(long, value_enum, value_name = "FORM")]
    pub(crate) stats: Option<StatsFlag>,
    /// Say nothing but errors
    #[arg(short, long)]
    pub(crate) quiet: bool,
    #[command(flatten)]
    pub(crate) scene: SceneFlags,
}

#[derive(Args, Debug)]
pub(crate) struct HeatmapFlags {
    /// The PNG to write [default: heatmap.png]
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,
    /// Count that the colours show
    #[arg(long, value_name = "KIND", default_value = "tested", value_parser = choice::<HeatKind>())]
    pub(crate) of: HeatKind,
    /// The light whose grid `--of points` shows, by number from 0; `umbrage info` lists them [default: 0]
    #[arg(long, value_name = "N")]
    pub(crate) light: Option<usize>,
    /// Acceleration structure whose work is counted, with options as NAME:OPTION=VALUE,OPTION=VALUE; `umbrage
    /// structures` describes them
    #[arg(
        long,
        value_name = "STRUCTURE",
        default_value = "perspective",
        value_parser = structure(Structure::is_specialised)
    )]
    pub(crate) structure: Structure,
    /// The count that has the last colour [default: one that few pixels exceed]
    #[arg(long, value_name = "COUNT", value_parser = clap::value_parser!(u32).range(1..=1_000_000_000))]
    pub(crate) max: Option<u32>,
    /// Moment to show [default: the best one of a demo, else the middle of the animation]
    #[arg(long, value_name = "SECONDS", value_parser = values::seconds)]
    pub(crate) time: Option<f64>,
    /// Width and height in pixels, without the legend
    #[arg(long, value_name = "WxH", default_value = "1024x1024")]
    pub(crate) size: Size,
    /// Camera of the scene, by name or number from 0, or at X,Y,Z towards another point with a vertical field of view
    /// in degrees (40) [default: the first, else one that sees everything]
    #[arg(long, value_name = "NAME|NUMBER|X,Y,Z:X,Y,Z[:FOV]", allow_hyphen_values = true)]
    pub(crate) camera: Option<CameraSpec>,
    #[command(flatten)]
    pub(crate) scene: SceneFlags,
}

#[derive(Args, Debug)]
pub(crate) struct ViewFlags {
    /// Read the file again whenever it changes
    #[arg(long)]
    pub(crate) watch: bool,
    /// Engine that renders at first [default: as in the last window]
    #[arg(long, value_parser = engine())]
    pub(crate) engine: Option<EngineKind>,
    /// The GPU, by a part of its name; `umbrage info --devices` lists them [default: the first]
    #[arg(long, value_name = "NAME")]
    pub(crate) device: Option<String>,
    /// Width and height of pictures in pixels [default: as in the last window, at first the window's own]
    #[arg(long, value_name = "WxH")]
    pub(crate) size: Option<Size>,
    /// Camera rays for each pixel of a picture that stays: it becomes sharper until it has them [default: as in the last
    /// window, at first 64]
    #[arg(long, value_name = "N", value_parser = values::samples)]
    pub(crate) samples: Option<u32>,
    /// Neither recall the last window's settings nor keep this one's
    #[arg(long)]
    pub(crate) forget: bool,
    #[command(flatten)]
    pub(crate) scene: SceneFlags,
}

/// How costs are said.
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
