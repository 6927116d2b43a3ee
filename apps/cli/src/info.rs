use std::fmt::{self, Write as _};
use std::io::{self, Write as _};
use std::path::Path;
#[cfg(feature = "papers")]
use std::time::Instant;

use glam::Vec3;
use serde::Serialize;
use serde_json::{Value, json};
#[cfg(feature = "papers")]
use umbrage::Structure;
use umbrage::gallery::{DEMOS, DemoScene};
use umbrage::rays::LightSource;
#[cfg(feature = "papers")]
use umbrage::rays::Structure as _;
use umbrage::scene::Frame;
use umbrage::{OmittedTriangles, Scene};
#[cfg(feature = "papers")]
use umbrage_papers::{KdRebuild, KdTree, KdTreeCounts, KdTrees};

use crate::engine;
use crate::failure::Failure;
use crate::feature::Feature;
use crate::flags::InfoFlags;
use crate::progress::Progress;
use crate::report::{count, thousands};

/// A scene's contents at its first moment.
#[derive(Debug, Serialize)]
struct Contents {
    scene: String,
    kind: String,
    triangles: usize,
    vertices: usize,
    points: usize,
    lines: usize,
    /// Bounds in the world's coordinates; `None` for a scene without visible content.
    bounds: Option<[WorldPoint; 2]>,
    /// Origin of the scene's coordinates in the world, where it isn't zero.
    #[serde(skip_serializing_if = "Option::is_none")]
    origin: Option<[f64; 3]>,
    /// Size in world units, of which lengths may be shares.
    size: f32,
    duration_seconds: f64,
    objects: Vec<String>,
    materials: Vec<String>,
    textures: Vec<TextureContents>,
    lights: Vec<LightContents>,
    cameras: Vec<CameraContents>,
    animations: Vec<AnimationContents>,
    variants: Vec<String>,
    omitted: Vec<OmittedTriangles>,
    warnings: Vec<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    structure: Option<Value>,
}

#[derive(Debug, Serialize)]
struct TextureContents {
    name: String,
    width: u32,
    height: u32,
}

#[derive(Debug, Serialize)]
struct LightContents {
    name: String,
    kind: &'static str,
    intensity: f32,
    color: [f32; 3],
}

#[derive(Debug, Serialize)]
struct CameraContents {
    name: String,
    position: WorldPoint,
    forward: [f32; 3],
}

#[derive(Debug, Serialize)]
struct AnimationContents {
    name: String,
    seconds: f64,
    plays: bool,
}

pub(crate) fn run(flags: &InfoFlags) -> Result<(), Failure> {
    if flags.devices {
        return Ok(io::stdout().write_all(engine::devices(flags.json)?.as_bytes())?);
    }
    let Some(address) = &flags.scene else { return gallery(flags.json) };
    let opening = Progress::task("opening", address, false);
    let scene = umbrage::open_with(address, &flags.opening.options())?;
    drop(opening);
    let frame = scene.at(0.0)?;
    #[cfg(feature = "papers")]
    let structure = flags.structure.as_ref().and_then(Structure::kind).map(|kind| kd_tree(&frame, kind)).transpose()?;
    #[cfg(not(feature = "papers"))]
    let structure: Option<(Value, String)> = None;
    let (structure, lines) = structure.unzip();
    let contents = Contents { structure, ..Contents::of(address, &scene, &frame) };
    let text = contents.text() + &lines.unwrap_or_default();
    let text = if flags.json { json_text(&contents)? } else { text };
    Feature::hint_at_missing(scene.warnings());
    Ok(io::stdout().write_all(text.as_bytes())?)
}

/// A value as the command prints it.
pub(crate) fn json_text(value: &impl Serialize) -> Result<String, Failure> {
    let mut json = serde_json::to_string_pretty(value).map_err(|error| Failure::Work(error.to_string()))?;
    json.push('\n');
    Ok(json)
}

/// Lists the built-in scenes.
fn gallery(as_json: bool) -> Result<(), Failure> {
    let text = if as_json {
        let listed = DEMOS.iter().map(|DemoScene { name, about, triangles, .. }| {
            json!({ "scene": format!("demo:{name}"), "about": about, "triangles": triangles })
        });
        json_text(&listed.collect::<Value>())?
    } else {
        let lines = DEMOS.iter().map(|DemoScene { name, about, triangles, .. }| {
            format!("{:<16} {:>12}  {about}\n", format!("demo:{name}"), count(*triangles as u64, "triangle"))
        });
        let note = "Each takes another number of triangles: 'demo:NAME?triangles=N'\n";
        lines.chain([note.to_owned()]).collect()
    };
    Ok(io::stdout().write_all(text.as_bytes())?)
}

impl Contents {
    fn of(address: &Path, scene: &Scene, frame: &Frame) -> Self {
        let triangles = frame.triangles();
        let (bounds, marks) = (frame.bounds(), &frame.mesh.marks);
        let animations = scene.animations().iter().map(|animation| AnimationContents {
            name: animation.name.clone(),
            seconds: animation.seconds,
            plays: animation.plays,
        });
        let textures = frame.materials.textures.iter().map(|texture| {
            let [width, height] = texture.size();
            TextureContents { name: texture.name.clone(), width, height }
        });
        let lights = frame.lights.iter().map(|light| LightContents {
            name: light.name.to_string(),
            kind: match light.source {
                LightSource::Point { .. } => "point",
                LightSource::Spot { .. } => "spot",
                LightSource::Directional { .. } => "directional",
            },
            intensity: light.intensity,
            color: light.color.to_array(),
        });
        let cameras = frame.cameras.iter().map(|named| CameraContents {
            name: named.name.to_string(),
            position: WorldPoint::new(scene, named.camera.position),
            forward: named.camera.forward.to_array(),
        });
        Self {
            scene: address.display().to_string(),
            kind: kind(address),
            triangles: triangles.len(),
            vertices: frame.positions.len(),
            points: marks.points().len(),
            lines: marks.lines().len(),
            bounds: (!bounds.is_empty()).then(|| [bounds.min, bounds.max].map(|corner| WorldPoint::new(scene, corner))),
            origin: Some(scene.origin()).filter(|origin| *origin != [0.0; 3]),
            size: scene.size(),
            duration_seconds: scene.duration_seconds(),
            objects: scene.objects().iter().map(ToString::to_string).collect(),
            materials: frame.materials.materials.iter().map(|material| material.name.clone()).collect(),
            textures: textures.collect(),
            lights: lights.collect(),
            cameras: cameras.collect(),
            animations: animations.collect(),
            variants: scene.variants().to_vec(),
            omitted: OmittedTriangles::of(&triangles.omitted()).collect(),
            warnings: scene.warnings().to_vec(),
            structure: None,
        }
    }

    fn text(&self) -> String {
        let mut text = format!("{}: {}\n", self.scene, self.kind);
        let mut line = |name: &str, value: &str| {
            // Writing to a string can't fail.
            let _ = writeln!(text, "  {name:<12} {value}");
        };
        line("triangles", &thousands(self.triangles as u64));
        line("vertices", &thousands(self.vertices as u64));
        for (name, count) in [("points", self.points), ("lines", self.lines)] {
            if count > 0 {
                line(name, &thousands(count as u64));
            }
        }
        match &self.bounds {
            Some([min, max]) => line("bounds", &format!("{min} to {max}")),
            None => line("bounds", "none: no triangle can be hit"),
        }
        if let Some([x, y, z]) = self.origin {
            line("origin", &format!("({x}, {y}, {z}), from which the scene's coordinates count"));
        }
        if self.size > 0.0 {
            line("size", &format!("{}, the diagonal of the bounds; a length of 2% is {}", self.size, 0.02 * self.size));
        }
        line("duration", &format!("{} s", self.duration_seconds));
        // All of them, since one is hidden by its name.
        line("objects", &all(&self.objects, |name| quoted(name)));
        line("materials", &listed(&self.materials, |name| quoted(name)));
        let texture = |image: &TextureContents| format!("{} {}x{}", quoted(&image.name), image.width, image.height);
        line("textures", &listed(&self.textures, texture));
        let light = |light: &LightContents| {
            let unit = if light.kind == "directional" { "lux" } else { "candela" };
            format!("{} {} {} {unit}", quoted(&light.name), light.kind, light.intensity)
        };
        line("lights", &listed(&self.lights, light));
        let camera = |camera: &CameraContents| format!("{} at {}", quoted(&camera.name), camera.position);
        line("cameras", &listed(&self.cameras, camera));
        let animation = |animation: &AnimationContents| {
            let plays = if animation.plays { ", plays" } else { "" };
            format!("{} {:.3} s{plays}", quoted(&animation.name), animation.seconds)
        };
        // All of them, since one is chosen by its name.
        line("animations", &all(&self.animations, animation));
        line("variants", &all(&self.variants, |name| quoted(name)));
        for omitted in &self.omitted {
            let triangles = count(u64::from(omitted.count), "triangle");
            line("left out", &format!("{triangles} ({}; first ids {:?})", omitted.reason, omitted.first_ids));
        }
        for warning in &self.warnings {
            line("warning", warning);
        }
        text
    }
}

/// Statistics of a kd-tree over the frame, as JSON and in lines.
#[cfg(feature = "papers")]
fn kd_tree(frame: &Frame, &KdTrees { options, rebuild }: &KdTrees) -> Result<(Value, String), Failure> {
    if rebuild != KdRebuild::Whole {
        return Err(Failure::input("the kd-tree of one frame isn't rebuilt", "leave out `rebuild`"));
    }
    let mut tree = KdTree::default();
    tree.set_options(options).map_err(|impossible| Failure::Input { message: impossible.to_string(), hint: None })?;
    let start = Instant::now();
    tree.build(frame.triangles());
    let milliseconds = 1e3 * start.elapsed().as_secs_f64();
    let KdTreeCounts { depth, nodes, leaves, empty_leaves, references, sah_cost, deferred, .. } = tree.counts();
    let (builder, layout, bytes) = (options.builder.to_string(), options.layout.to_string(), tree.bytes().triangles);
    let mut text = format!("  kd-tree      {builder} builder, {layout} layout\n");
    let mut line = |name: &str, value: String| {
        // Writing to a string can't fail.
        let _ = writeln!(text, "    {name:<10} {value}");
    };
    let each = |number: f64| number / (frame.triangles().len() as f64).max(1.0);
    line("build", format!("{milliseconds:.1} ms"));
    line("depth", depth.to_string());
    line("nodes", thousands(nodes));
    line("leaves", format!("{}, {} of them empty", thousands(leaves), thousands(empty_leaves)));
    if deferred > 0 {
        line("waiting", format!("{} to be built when a ray reaches them", thousands(deferred)));
    }
    line("references", format!("{}, {:.2} per triangle", thousands(references), each(references as f64)));
    line("SAH cost", format!("{sah_cost:.1}"));
    let of_each = each(bytes as f64);
    line("memory", format!("{} bytes, {of_each:.0} per triangle, with what building took", thousands(bytes as u64)));
    let json = json!({
        "builder": builder,
        "layout": layout,
        "build_milliseconds": milliseconds,
        "depth": depth,
        "nodes": nodes,
        "leaves": leaves,
        "empty_leaves": empty_leaves,
        "references": references,
        "deferred": deferred,
        "sah_cost": sah_cost,
        "bytes": bytes,
    });
    Ok((json, text))
}

/// The kind of scene at an address.
fn kind(address: &Path) -> String {
    let text = address.to_string_lossy();
    if text.starts_with("demo:") {
        return "built-in scene".to_owned();
    }
    if address.is_dir() || (!address.exists() && text.contains(['%', '*'])) {
        return "sequence of numbered files".to_owned();
    }
    let extension = address.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
    match extension.as_str() {
        "gltf" | "glb" => "glTF scene".to_owned(),
        "pc2" | "mdd" => format!("{} point cache over an OBJ file", extension.to_uppercase()),
        other => format!("{} model", other.to_uppercase()),
    }
}

/// Number of items, and the first of them.
fn listed<T>(items: &[T], in_words: impl Fn(&T) -> String) -> String {
    few(items, 12, in_words)
}

/// Number of items, and all of them.
fn all<T>(items: &[T], in_words: impl Fn(&T) -> String) -> String {
    few(items, items.len(), in_words)
}

fn few<T>(items: &[T], shown: usize, in_words: impl Fn(&T) -> String) -> String {
    let first: Vec<String> = items.iter().take(shown).map(in_words).collect();
    let more = if items.len() > shown { ", …" } else { "" };
    let colon = if items.is_empty() { "" } else { ": " };
    format!("{}{colon}{}{more}", thousands(items.len() as u64), first.join(", "))
}

fn quoted(name: &str) -> String {
    if name.is_empty() { "(unnamed)".to_owned() } else { format!("`{name}`") }
}

/// A point of the world: with the digits of f32 if the scene's origin is the world's.
#[derive(Debug, Serialize)]
#[serde(untagged)]
enum WorldPoint {
    Near([f32; 3]),
    Far([f64; 3]),
}

impl WorldPoint {
    fn new(scene: &Scene, local: Vec3) -> Self {
        if scene.origin() == [0.0; 3] {
            Self::Near(local.to_array())
        } else {
            Self::Far(scene.world_from_local(local).to_array())
        }
    }
}

impl fmt::Display for WorldPoint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Near([x, y, z]) => write!(f, "({x}, {y}, {z})"),
            // Rounded to the digits that f32 has near the origin.
            Self::Far(point) => {
                let [x, y, z] = point.map(|axis| (axis * 1e6).round() / 1e6 + 0.0);
                write!(f, "({x}, {y}, {z})")
            }
        }
    }
}
