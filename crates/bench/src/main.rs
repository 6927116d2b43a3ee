//! `umbrage-bench`: how fast is it?
#![forbid(unsafe_code)]

mod beside;
mod bounce;
mod copies;
mod effects;
mod experiments;
mod far;
mod flags;
mod frame;
mod gpu;
mod grids;
mod lit;
mod measure;
mod nearest;
mod papers;
mod peers;
mod picture;
mod plot;
mod rays;
mod scan;
mod shot;
mod table;
mod tone_map;
mod trace;
mod trust;
#[cfg(feature = "view")]
mod window;

use std::io;
use std::process::ExitCode;

use clap::{Parser, Subcommand};

/// Measures frames side by side, in alternation, and prints medians.
#[derive(Debug, Parser)]
#[command(name = "umbrage-bench", version, after_help = EXAMPLES)]
struct Flags {
    #[command(subcommand)]
    command: Command,
}

const EXAMPLES: &str = "Examples:
  umbrage-bench frame
      Every stage of a frame, for the whole gallery, through the grids and through the hierarchy
  umbrage-bench frame demo:cloth model.glb --size 2048x2048 --form csv
      Some scenes only, larger, for a spreadsheet
  umbrage-bench gpu --json gpu.json
      All about this machine's GPU, within nine minutes
  umbrage-bench peers --files scenes
      The gallery and the real scenes of a folder, side by side with Embree
  umbrage-bench peers demo:cloth --lights 1,2,4,8 --tinybvh libumbrage_tinybvh.so
      What further lights cost; and tinybvh beside, compiled as crates/peers/src/tinybvh/glue.cpp says
  umbrage-bench growth --plot growth.svg --plot-bytes memory.svg
      10 K to 10 M triangles, images of up to 4096x4096 pixels, 1 to 64 lights
  umbrage-bench breakdown --plot breakdown.svg
      One of the paper's experiments, as a table and a chart
  umbrage-bench papers --files scenes
      All of them, into crates/papers/docs/tables, beside what was measured the last time";

#[derive(Debug, Subcommand)]
enum Command {
    /// Time every stage of a frame, for each scene and structure
    Frame(frame::FrameFlags),
    /// Describe a GPU: its limits, the cost of a launch, answers beside the CPU's, and every stage of frames
    Gpu(gpu::GpuFlags),
    /// Count the work of each kernel of a frame while it runs on any device, and the least time of GPUs for it
    Roofline(gpu::RooflineFlags),
    /// Time whole pictures, from the scene to the file, by the command; of two builds of it in turn
    Picture(picture::PictureFlags),
    /// Compare frames with those of Embree, which must be installed (the Python package embreex, or Debian's
    /// libembree-dev), and of tinybvh
    Peers(peers::PeersFlags),
    /// Incoherent rays: one diffuse bounce through every structure for all rays, and through Embree
    Bounce(bounce::BounceFlags),
    /// Lenses and large lights: exact frames beside rays of which each pixel's have points of their own
    Effects(effects::EffectsFlags),
    /// A spinning lidar: directions all around from one origin, through scans and through Embree
    Scan(scan::ScanFlags),
    /// Which faces each of many suns reaches, through scans and through Embree
    Lit(lit::LitFlags),
    /// Closest points of meshes that move, by our boxes and by Embree's point queries
    Nearest(nearest::NearestFlags),
    /// Copies of a mesh that stay copies beside all of their triangles, and rays with a moment each
    Copies(copies::CopiesFlags),
    /// Any rays, in runs from the same origin: times of a scan, the hierarchy and Embree, and the choice between them
    Trace(trace::TraceFlags),
    /// Levels that the tone maps give greys
    ToneMap(tone_map::ToneMapFlags),
    /// Measure some of the papers' experiments and write their tables to crates/papers/docs/tables
    Paper(papers::PaperFlags),
    /// Measure all of them, and say what differs from the tables that are there
    Papers(papers::PapersFlags),
    /// Table 1 of the paper: what building and tracing take, beside the paper's own numbers
    Table1(experiments::Table1Flags),
    /// Figure 10 of the paper: which stages a frame's time goes to
    Breakdown(experiments::BreakdownFlags),
    /// Figure 11 of the paper: shadows of a light that moves away
    Distance(experiments::DistanceFlags),
    /// The light grid's cells of the paper: one spherical map for each light, beside faces and the direct form
    LightMaps(experiments::LightMapsFlags),
    /// How time and memory grow with triangles, pixels and lights
    Growth(experiments::GrowthFlags),
    /// Indirect mapping: sorting to small tiles, tracing by larger ones
    Mapping(experiments::MappingFlags),
    /// Sizes of the camera grid's cells
    Cells(experiments::CellsFlags),
    /// Tiles of many triangles that are divided among threads, for the camera's grid
    CameraTriangles(experiments::CameraTrianglesFlags),
    /// Ray-triangle tests of the literature: how many a second, beside the ratios that their papers report
    Triangles(experiments::TrianglesFlags),
    /// The uniform grid of Wald et al. 2006, Table 3 and Figure 7: packets of several sizes, and single rays
    Packets(experiments::PacketsFlags),
    /// Its Figure 6: how many cells for each triangle
    Density(experiments::DensityFlags),
    /// Grids inside of its cells, for scenes of uneven density
    Nested(experiments::NestedFlags),
    /// Its sections 2.4, 3 and 4.6: macrocells, exact insertion, and packets of shadow rays that are split
    GridOptions(experiments::GridOptionsFlags),
    /// Its Figures 8 and 9: moving models, without and with shading and shadows
    Models(experiments::ModelsFlags),
    /// Its section 4.2: how the time grows with the image
    Resolution(experiments::ResolutionFlags),
    /// Its Tables 1 and 4: what the mailbox and frustum culling spare (needs the feature `statistics`)
    Culling(experiments::CullingFlags),
    /// The kd-tree's builders: how long they take, how good the tree is, and how fast rays go through it
    KdBuilders(experiments::KdBuildersFlags),
    /// How its parallel builds would scale to 16 threads, by counted work
    KdScaling(experiments::KdScalingFlags),
    /// The surface area heuristic without its parts: clipping, the bonus for empty space, mailboxes, when to stop
    KdAblations(experiments::KdAblationsFlags),
    /// Horn et al. 2007, Tables 1 and 2: traversals of the kd-tree, one ray at a time and in packets
    KdTraversals(experiments::KdTraversalsFlags),
    /// Its Figure 2: how mirror bounces slow rays down
    KdBounces(experiments::KdBouncesFlags),
    /// Where large packets begin and what they leave out: entry-point search and culling
    KdEntries(experiments::KdEntriesFlags),
    /// Moving scenes through kd-trees that are built anew, as rays need them, from a hierarchy, or beside tracing
    KdFrames(experiments::KdFramesFlags),
    /// Moving scenes through kd-trees that outlive a frame: two levels, groups, boxes over poses; and Embree's refit
    KdMoving(experiments::KdMovingFlags),
    /// Horn et al. 2007 on a GPU: frames that are traced throughout, and those with rasterised primary hits
    KdGpu(experiments::KdGpuFlags),
    /// Haines and Greenberg's light buffer: shadow rays from what a diffuse bounce hits
    LightBuffer(experiments::LightBufferFlags),
    /// A scene larger than the memory: parts of it on disk, rays one by one, in queues and in generations
    OnDemand(experiments::OnDemandFlags),
    /// How threads come by their work: locks, counters, in turn, fewer at a time, and stealing
    Queues(experiments::QueuesFlags),
    /// Re-ordering of secondary rays: packets, runs, types, adaptive packets, streams and frusta beside single rays
    Reorder(experiments::ReorderFlags),
    /// Figures of trust, each beside published results of others; writes docs/trust.md
    Trust(trust::TrustFlags),
    /// How many pictures a second the window plays, and what the interface adds to each
    #[cfg(feature = "view")]
    Window(window::WindowFlags),
}

fn main() -> ExitCode {
    match run(Flags::parse().command) {
        Ok(code) => code,
        // The reader of standard output has closed it, which is no error.
        Err(error) if is_unread(&error) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:?}");
            ExitCode::FAILURE
        }
    }
}

fn run(command: Command) -> anyhow::Result<ExitCode> {
    match command {
        Command::Trust(flags) => return trust::run(&flags),
        Command::Frame(flags) => frame::run(&flags),
        Command::Gpu(flags) => gpu::run(&flags),
        Command::Roofline(flags) => gpu::run_roofline(&flags),
        #[cfg(feature = "view")]
        Command::Window(flags) => window::run(&flags),
        Command::Picture(flags) => flags.run(),
        Command::Peers(flags) => peers::run(&flags),
        Command::Bounce(flags) => bounce::run(&flags),
        Command::Effects(flags) => effects::run(&flags),
        Command::Scan(flags) => scan::run(&flags),
        Command::Lit(flags) => lit::run(&flags),
        Command::Nearest(flags) => nearest::run(&flags),
        Command::Copies(flags) => copies::run(&flags),
        Command::Trace(flags) => trace::run(&flags),
        Command::ToneMap(flags) => flags.run(),
        Command::Paper(flags) => flags.run(),
        Command::Papers(flags) => flags.run(),
        Command::Table1(flags) => flags.run(),
        Command::Breakdown(flags) => flags.run(),
        Command::Distance(flags) => flags.run(),
        Command::LightMaps(flags) => flags.run(),
        Command::Growth(flags) => flags.run(),
        Command::Mapping(flags) => flags.run(),
        Command::Cells(flags) => flags.run(),
        Command::CameraTriangles(flags) => flags.run(),
        Command::Triangles(flags) => flags.run(),
        Command::Packets(flags) => flags.run(),
        Command::Density(flags) => flags.run(),
        Command::Nested(flags) => flags.run(),
        Command::GridOptions(flags) => flags.run(),
        Command::Models(flags) => flags.run(),
        Command::Resolution(flags) => flags.run(),
        Command::Culling(flags) => flags.run(),
        Command::KdBuilders(flags) => flags.run(),
        Command::KdScaling(flags) => flags.run(),
        Command::KdAblations(flags) => flags.run(),
        Command::KdTraversals(flags) => flags.run(),
        Command::KdBounces(flags) => flags.run(),
        Command::KdEntries(flags) => flags.run(),
        Command::KdFrames(flags) => flags.run(),
        Command::KdMoving(flags) => flags.run(),
        Command::KdGpu(flags) => flags.run(),
        Command::LightBuffer(flags) => flags.run(),
        Command::OnDemand(flags) => flags.run(),
        Command::Queues(flags) => flags.run(),
        Command::Reorder(flags) => flags.run(),
    }
    .map(|()| ExitCode::SUCCESS)
}

fn is_unread(error: &anyhow::Error) -> bool {
    let cause = error.root_cause().downcast_ref::<io::Error>();
    cause.is_some_and(|cause| cause.kind() == io::ErrorKind::BrokenPipe)
}
