use std::fmt::Write as _;
use std::io::{self, Write as _};
use std::path::Path;
use std::time::Instant;

use serde::Serialize;
use umbrage::gallery::{DEMOS, DemoScene};
use umbrage::gpu::Adapter;
use umbrage::rays::{KdTree, KdTreeCounts, KdTreeOptions, LightSource, Structure as _};
use umbrage::scene::Frame;
use umbrage::{OmittedTriangles, Scene, Structure};

use crate::failure::Failure;
use crate::flags::InfoFlags;
use crate::report::{count, thousands};

/// What is in a scene at its first moment.
#[derive(Debug, Serialize)]
struct Contents {
    scene: String,
    kind: String,
    triangles: usize,
    vertices: usize,
    /// World units; `None` where nothing can be hit.
    bounds: Option<[[f32; 3]; 2]>,
    duration_seconds: f64,
    materials: Vec<String>,
    textures: Vec<TextureContents>,
    lights: Vec<LightContents>,
    cameras: Vec<CameraContents>,
    animations: Vec<AnimationContents>,
    omitted: Vec<OmittedTriangles>,
    warnings: Vec<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    structure: Option<KdTreeContents>,
}

#[derive(Debug, Serialize)]
struct KdTreeContents {
    builder: String,
    layout: String,
    build_milliseconds: f64,
    /// Inner nodes above the deepest leaf.
    depth: u32,
    nodes: u64,
    leaves: u64,
    empty_leaves: u64,
    references: u64,
    /// Subtrees that wait for a ray.
    deferred: u64,
    sah_cost: f64,
    bytes: usize,
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
    position: [f32; 3],
    forward: [f32; 3],
}

#[derive(Debug, Serialize)]
struct AnimationContents {
    name: String,
    seconds: f64,
    plays: bool,
}

pub(crate) fn run(flags: InfoFlags) -> Result<(), Failure> {
    if flags.devices {
        return devices(flags.json);
    }
    let Some(address) = flags.scene else { return gallery(flags.json) };
    let scene = umbrage::open_with(&address, &flags.opening.into())?;
    if flags.kd_tree.has_options() && !flags.structure {
        return Err(Failure::input("no kd-tree is built", "add `--structure`"));
    }
    let frame = scene.at(0.0)?;
    let structure = match flags.kd_tree.structure()? {
        Structure::KdTree(options) if flags.structure => Some(KdTreeContents::of(&frame, options)?),
        _ => None,
    };
    let contents = Contents { structure, ..Contents::of(&address, &scene, &frame) };
    let text = if flags.json { json(&contents)? } else { contents.text() };
    Ok(io::stdout().write_all(text.as_bytes())?)
}

fn json(value: &impl Serialize) -> Result<String, Failure> {
    let mut json = serde_json::to_string_pretty(value).map_err(|error| Failure::Work(error.to_string()))?;
    json.push('\n');
    Ok(json)
}

/// Lists what can stand as a GPU.
fn devices(as_json: bool) -> Result<(), Failure> {
    #[derive(Serialize)]
    struct Listed {
        name: String,
        driver: String,
        backend: String,
        is_software: bool,
    }
    let all = Adapter::all().into_iter().map(|Adapter { name, driver, backend, is_software }| Listed {
        name,
        driver,
        backend,
        is_software,
    });
    let listed: Vec<Listed> = all.collect();
    let text = if as_json {
        json(&listed)?
    } else if listed.is_empty() {
        "No GPU, and no program that stands in for one. A Vulkan driver may be missing; on Debian, the package\n\
         mesa-vulkan-drivers has one in software.\n"
            .to_owned()
    } else {
        let lines = listed.iter().map(|Listed { name, driver, backend, is_software }| {
            let kind = if *is_software { "a program on the CPU" } else { "a GPU" };
            format!("{name}\n    {kind}, {backend}, {driver}\n")
        });
        lines.collect()
    };
    Ok(io::stdout().write_all(text.as_bytes())?)
}

/// Lists the built-in scenes.
fn gallery(as_json: bool) -> Result<(), Failure> {
    #[derive(Serialize)]
    struct Listed {
        scene: String,
        about: &'static str,
        triangles: usize,
    }
    let listed = DEMOS.iter().map(|&DemoScene { name, about, triangles, .. }| Listed {
        scene: format!("demo:{name}"),
        about,
        triangles,
    });
    let listed: Vec<Listed> = listed.collect();
    let text = if as_json {
        json(&listed)?
    } else {
        let lines = listed.iter().map(|Listed { scene, about, triangles }| {
            format!("{scene:<16} {:>12}  {about}\n", count(*triangles as u64, "triangle"))
        });
        let note = "Each takes another number of triangles: 'demo:NAME?triangles=N'\n";
        lines.chain([note.to_owned()]).collect()
    };
    Ok(io::stdout().write_all(text.as_bytes())?)
}

impl Contents {
    fn of(address: &Path, scene: &Scene, frame: &Frame) -> Self {
        let triangles = frame.triangles();
        let bounds = triangles.bounds();
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
            position: named.camera.position.to_array(),
            forward: named.camera.forward.to_array(),
        });
        Self {
            scene: address.display().to_string(),
            kind: kind(address),
            triangles: triangles.len(),
            vertices: frame.positions.len(),
            bounds: (!bounds.is_empty()).then(|| [bounds.min.to_array(), bounds.max.to_array()]),
            duration_seconds: scene.duration_seconds(),
            materials: frame.materials.materials.iter().map(|material| material.name.clone()).collect(),
            textures: textures.collect(),
            lights: lights.collect(),
            cameras: cameras.collect(),
            animations: animations.collect(),
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
        match self.bounds {
            Some([min, max]) => line("bounds", &format!("{} to {}", point(min), point(max))),
            None => line("bounds", "none: no triangle can be hit"),
        }
        line("duration", &format!("{} s", self.duration_seconds));
        line("materials", &listed(self.materials.iter().map(|name| quoted(name))));
        let textures = self.textures.iter();
        line(
            "textures",
            &listed(textures.map(|image| format!("{} {}x{}", quoted(&image.name), image.width, image.height))),
        );
        let lights = self.lights.iter();
        line(
            "lights",
            &listed(lights.map(|light| {
                let unit = if light.kind == "directional" { "lux" } else { "candela" };
                format!("{} {} {} {unit}", quoted(&light.name), light.kind, light.intensity)
            })),
        );
        let cameras = self.cameras.iter();
        line(
            "cameras",
            &listed(cameras.map(|camera| format!("{} at {}", quoted(&camera.name), point(camera.position)))),
        );
        let animations = self.animations.iter();
        line(
            "animations",
            &listed(animations.map(|animation| {
                let plays = if animation.plays { ", plays" } else { "" };
                format!("{} {:.3} s{plays}", quoted(&animation.name), animation.seconds)
            })),
        );
        for omitted in &self.omitted {
            let triangles = count(u64::from(omitted.count), "triangle");
            line("left out", &format!("{triangles} ({}; first ids {:?})", omitted.reason, omitted.first_ids));
        }
        for warning in &self.warnings {
            line("warning", warning);
        }
        if let Some(structure) = &self.structure {
            text.push_str(&structure.text(self.triangles));
        }
        text
    }
}

impl KdTreeContents {
    fn of(frame: &Frame, options: KdTreeOptions) -> Result<Self, Failure> {
        let mut tree = KdTree::default();
        tree.set_options(options)
            .map_err(|impossible| Failure::Input { message: impossible.to_string(), hint: None })?;
        let start = Instant::now();
        tree.build(frame.triangles());
        let build_milliseconds = 1e3 * start.elapsed().as_secs_f64();
        let KdTreeCounts { depth, nodes, leaves, empty_leaves, references, sah_cost, deferred, .. } = tree.counts();
        Ok(Self {
            builder: options.builder.to_string(),
            layout: options.layout.to_string(),
            build_milliseconds,
            depth,
            nodes,
            leaves,
            empty_leaves,
            references,
            deferred,
            sah_cost,
            bytes: tree.bytes().triangles,
        })
    }

    fn text(&self, triangles: usize) -> String {
        let mut text = format!("  kd-tree      {} builder, {} layout\n", self.builder, self.layout);
        let mut line = |name: &str, value: String| {
            // Writing to a string can't fail.
            let _ = writeln!(text, "    {name:<10} {value}");
        };
        let each = |number: f64| number / (triangles as f64).max(1.0);
        line("build", format!("{:.1} ms", self.build_milliseconds));
        line("depth", self.depth.to_string());
        line("nodes", thousands(self.nodes));
        line("leaves", format!("{}, {} of them empty", thousands(self.leaves), thousands(self.empty_leaves)));
        if self.deferred > 0 {
            line("waiting", format!("{} to be built when a ray reaches them", thousands(self.deferred)));
        }
        let of_each = each(self.references as f64);
        line("references", format!("{}, {of_each:.2} per triangle", thousands(self.references)));
        line("SAH cost", format!("{:.1}", self.sah_cost));
        let of_each = each(self.bytes as f64);
        line(
            "memory",
            format!("{} bytes, {of_each:.0} per triangle, with what building took", thousands(self.bytes as u64)),
        );
        text
    }
}

/// What kind of scene an address means.
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
        other => format!("{} model", other.to_uppercase()),
    }
}

/// How many there are, and the first of them.
fn listed(items: impl ExactSizeIterator<Item = String>) -> String {
    const SHOWN: usize = 12;
    let number = items.len();
    let mut text = thousands(number as u64);
    for (index, item) in items.take(SHOWN).enumerate() {
        text.push_str(if index == 0 { ": " } else { ", " });
        text.push_str(&item);
    }
    if number > SHOWN {
        text.push_str(", …");
    }
    text
}

fn quoted(name: &str) -> String {
    if name.is_empty() { "(unnamed)".to_owned() } else { format!("`{name}`") }
}

fn point([x, y, z]: [f32; 3]) -> String {
    format!("({x}, {y}, {z})")
}
