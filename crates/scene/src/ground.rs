//! A floor under scenes without one.

use std::fmt;
use std::str::FromStr;
use std::sync::Arc;

use glam::{Affine3A, Vec2, Vec3, Vec4};
use umbrage_rays::{Bounds, choices};

use crate::hidden::Derived;
use crate::rig::{Placement, Pose, Rig, RigPart, Shape};
use crate::{Frame, Material, Materials, Mesh, Objects};

/// A level floor under a scene, which receives its shadows: `shadow` or `matte`, optionally followed by `:HEIGHT`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Ground {
    /// Its appearance.
    pub surface: GroundSurface,
    /// Its world height along +Y, in world units; `None` for just below the lowest point of the scene over its animation, as
    /// far as that is known without posing every moment.
    pub height: Option<f32>,
}

/// Which ground a scene gets when it is opened: `auto`, `none` or a [`Ground`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum GroundChoice {
    /// None.
    #[default]
    None,
    /// Shadows alone under a file that has neither lights nor a floor of its own, none under other scenes.
    Auto,
    /// This one.
    Own(Ground),
}

impl fmt::Display for GroundChoice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::None => f.write_str("none"),
            Self::Auto => f.write_str("auto"),
            Self::Own(ground) => ground.fmt(f),
        }
    }
}

impl FromStr for GroundChoice {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "none" => Ok(Self::None),
            "auto" => Ok(Self::Auto),
            ground => ground.parse().map(Self::Own),
        }
    }
}

/// Appearance of a ground.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum GroundSurface {
    /// A shadow catcher: shows the background, darkened by the shadows on it.
    #[default]
    Shadow,
    /// Rough and light grey.
    Matte,
}

choices! { GroundSurface, "ground":
    "shadow" => Shadow, "only the shadows on it are seen";
    "matte" => Matte, "rough and light grey";
}

impl fmt::Display for Ground {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.height {
            None => write!(f, "{}", self.surface),
            Some(height) => write!(f, "{}:{height}", self.surface),
        }
    }
}

impl FromStr for Ground {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (surface, height) = text.split_once(':').map_or((text, None), |(surface, height)| (surface, Some(height)));
        let surface = surface.parse().map_err(|error: umbrage_rays::UnknownChoice| error.to_string())?;
        let height = height.map(|height| match height.parse::<f32>() {
            Ok(height) if height.is_finite() => Ok(height),
            _ => Err(format!("`{height}` is no height: give a number, as in {surface}:0.5")),
        });
        Ok(Self { surface, height: height.transpose()? })
    }
}

impl Ground {
    /// Distance from the middle of the scene to its sides, in halves of the scene's diagonal. In views of the whole scene
    /// it ends close to the horizon, and shadows are whole until a light is 2° above it.
    const REACH: f32 = 30.0;
    /// Distance below the scene, in diagonals. Without it, rays would hit the ground and a floor at the scene's lowest
    /// point at equal depths, which only exact arithmetic finds: in `demo:cloth` at 1024², *see* took 131 ms instead of
    /// 16.
    const GAP: f32 = 1e-5;

    fn material(self) -> Material {
        let grey = Material { name: "ground".into(), base_color: Vec4::new(0.5, 0.5, 0.5, 1.0), ..Material::default() };
        Material { catches_shadows: self.surface == GroundSurface::Shadow, ..grey }
    }

    /// Its corners, counterclockwise from above; `None` if the scene has no extent or a corner isn't finite.
    fn corners(self, scene: Bounds) -> Option<[Vec3; 4]> {
        let (center, diagonal) = (scene.center(), scene.size().length());
        let reach = 0.5 * Self::REACH * diagonal;
        let height = self.height.unwrap_or(scene.min.y - Self::GAP * diagonal);
        let corner = |x: f32, z: f32| Vec3::new(center.x + x * reach, height, center.z + z * reach);
        let corners = [corner(-1.0, -1.0), corner(-1.0, 1.0), corner(1.0, 1.0), corner(1.0, -1.0)];
        (reach > 0.0 && corners.iter().all(|corner| corner.is_finite())).then_some(corners)
    }
}

/// Whether a frame needs a ground: it has neither lights nor a floor. A floor is level triangles that face up near the
/// frame's lowest point and cover over half of its bounds from above, with something that stands on them.
pub(crate) fn lacks_floor(frame: &Frame) -> bool {
    /// Parts of the diagonal, and of the area.
    const NEAR: f32 = 0.02;
    const LEVEL: f64 = 0.99;
    const SHARE: f64 = 0.5;
    const LEAST_HEIGHT: f32 = 0.03;
    let triangles = frame.triangles();
    let bounds = triangles.bounds();
    if !frame.lights.is_empty() || bounds.is_empty() {
        return false;
    }
    let size = bounds.size();
    let diagonal = size.length();
    if size.y < LEAST_HEIGHT * diagonal {
        return true;
    }
    let highest = bounds.min.y + NEAR * diagonal;
    let floor_of = |id: u32| {
        let [a, b, c] = triangles.corners(id);
        if a.y.max(b.y).max(c.y) > highest {
            return 0.0;
        }
        let [a, b, c] = [a, b, c].map(Vec3::as_dvec3);
        let doubled = (b - a).cross(c - a);
        if doubled.y > LEVEL * doubled.length() { 0.5 * doubled.y } else { 0.0 }
    };
    let floor: f64 = (0..triangles.len() as u32).map(floor_of).sum();
    floor <= SHARE * f64::from(size.x) * f64::from(size.z)
}

/// Adds a ground to a scene's frames: two triangles, which come last.
#[derive(Debug)]
pub(crate) struct Grounded {
    pub(crate) ground: Ground,
    corners: Option<[Vec3; 4]>,
    /// The last mesh and materials with a ground: they usually stay the same.
    mesh: Derived<Mesh>,
    materials: Derived<Materials>,
    rig: Derived<Rig>,
}

impl Grounded {
    /// `level` is the world's height of the scene's origin.
    pub(crate) fn new(ground: Ground, scene: Bounds, level: f64) -> Self {
        let height = ground.height.map(|height| (f64::from(height) - level) as f32);
        let corners = if scene.is_empty() { None } else { Ground { height, ..ground }.corners(scene) };
        Self { ground, corners, mesh: Derived::default(), materials: Derived::default(), rig: Derived::default() }
    }

    /// Puts the ground under a frame with vertices.
    pub(crate) fn put_under(&self, frame: &mut Frame) {
        let Some(corners) = self.corners else { return };
        let vertices = frame.positions.len();
        frame.positions.extend(corners);
        if !frame.normals.is_empty() {
            frame.normals.extend([Vec3::ZERO; 4]);
        }
        if !frame.tangents.is_empty() {
            frame.tangents.extend([Vec4::ZERO; 4]);
        }
        self.extend_surfaces(frame, vertices);
    }

    /// Puts the ground under a frame whose vertices a rig moves; returns the rig with the ground's vertices added.
    pub(crate) fn put_under_rig(&self, rig: &Arc<Rig>, frame: &mut Frame, pose: &mut Pose) -> Arc<Rig> {
        let Some(corners) = self.corners else { return Arc::clone(rig) };
        self.extend_surfaces(frame, rig.vertices);
        let matrix = pose.matrices.len() as u32;
        pose.matrices.push(Affine3A::IDENTITY);
        self.rig.of(rig, |rig| {
            let mut rig = rig.clone();
            let placement = Placement::Rigid { matrix };
            let (shape, first_vertex) = (rig.shapes.len() as u32, rig.vertices as u32);
            rig.shapes.push(Arc::new(Shape { positions: corners.into(), ..Shape::default() }));
            rig.parts.push(RigPart { shape, first_vertex, first_weight: 0, placement, moves: false });
            rig.vertices += corners.len();
            rig
        })
    }

    fn extend_surfaces(&self, frame: &mut Frame, first_vertex: usize) {
        let material = frame.materials.materials.len() as u32;
        frame.materials = self.materials.of(&frame.materials, |materials| {
            let mut materials = materials.clone();
            materials.materials.push(self.ground.material());
            materials
        });
        frame.mesh = self.mesh.of(&frame.mesh, |mesh| with_two_triangles(mesh, first_vertex as u32, material));
    }
}

fn with_two_triangles(mesh: &Mesh, first_vertex: u32, material: u32) -> Mesh {
    let mut mesh = mesh.clone();
    let [a, b, c, d] = [0, 1, 2, 3].map(|corner| first_vertex + corner);
    mesh.triangles.extend([[a, b, c], [a, c, d]]);
    mesh.material_of_triangle.extend([material; 2]);
    if let Some(last) = mesh.part_of_triangle.iter().max().copied() {
        mesh.part_of_triangle.extend([last + 1; 2]);
        if let Some(object) = mesh.object_of_part.iter().max().copied() {
            mesh.object_of_part.push(object + 1);
        }
    }
    for coords in &mut mesh.tex_coords {
        if !coords.is_empty() {
            coords.extend([Vec2::ZERO; 4]);
        }
    }
    if !mesh.colors.is_empty() {
        mesh.colors.extend([Vec4::ONE; 4]);
    }
    if mesh.objects.is_empty() {
        mesh.objects.begin(0, Objects::WHOLE);
    }
    mesh.objects.begin(mesh.triangles.len() - 2, "ground");
    mesh.ground_triangles = 2;
    mesh
}
