//! Sculptures: solids modelled like clay, from lumps that melt into each other and are carved, then meshed at any fineness.

mod buddha;
mod rabbit;
mod surface;

use glam::{Mat3, Quat, Vec3};

pub(crate) use buddha::buddha;
pub(crate) use rabbit::rabbit;
pub(crate) use surface::mesh;

/// A solid: the points at which [`Sculpture::distance`] is negative.
#[derive(Clone, Debug)]
pub(crate) struct Sculpture {
    lumps: Vec<Lump>,
    relief: Relief,
    /// Half the side of a cube around the solid and its middle.
    half_size: f32,
    center: Vec3,
    /// Approximate area of the surface.
    area: f32,
}

/// Relief of a surface over a smooth solid.
#[derive(Clone, Copy, Debug)]
struct Relief {
    /// Height at a point; of the order of `greatest` at most, and cheap.
    height: fn(Vec3) -> f32,
    greatest: f32,
    /// The finest part, evaluated only very near the surface.
    tooth: fn(Vec3) -> f32,
    greatest_tooth: f32,
}

/// One lump of clay, or one cut into it.
#[derive(Clone, Copy, Debug)]
struct Lump {
    form: Form,
    /// Whether the lump is mirrored on both sides of the plane x = 0.
    mirrored: bool,
    /// Whether the form is carved out instead of added.
    carved: bool,
    /// Width of the fillet between the lump and the earlier ones.
    blend: f32,
}

#[derive(Clone, Copy, Debug)]
enum Form {
    Ellipsoid {
        center: Vec3,
        inverse_radii: Vec3,
        least_radius: f32,
        /// Maps the ellipsoid, with its middle at the origin, to the unit sphere.
        sphere_from_world: Mat3,
    },
    /// A rod from one ball to another.
    Rod { ends: [Vec3; 2], radii: [f32; 2] },
}

impl Form {
    /// About the distance to the form, negative inside; never much above it in size.
    fn distance(&self, point: Vec3) -> f32 {
        match *self {
            Self::Ellipsoid { center, inverse_radii, least_radius, sphere_from_world } => {
                let scaled = sphere_from_world * (point - center);
                let reach = scaled.length();
                if reach <= 1.0 {
                    return (reach - 1.0) * least_radius;
                }
                reach * (reach - 1.0) / (scaled * inverse_radii).length()
            }
            Self::Rod { ends: [from, to], radii } => {
                let (along, offset) = (to - from, point - from);
                let part = (offset.dot(along) / along.length_squared()).clamp(0.0, 1.0);
                (offset - along * part).length() - (radii[0] + (radii[1] - radii[0]) * part)
            }
        }
    }
}

impl Lump {
    fn ellipsoid(center: [f32; 3], radii: [f32; 3]) -> Self {
        let radii = Vec3::from(radii);
        let form = Form::Ellipsoid {
            center: center.into(),
            inverse_radii: radii.recip(),
            least_radius: radii.min_element(),
            sphere_from_world: Mat3::from_diagonal(radii.recip()),
        };
        Self { form, mirrored: false, carved: false, blend: 0.05 }
    }

    fn rod(from: [f32; 3], to: [f32; 3], radii: [f32; 2]) -> Self {
        let form = Form::Rod { ends: [from.into(), to.into()], radii };
        Self { form, mirrored: false, carved: false, blend: 0.05 }
    }

    /// The lump on both sides.
    fn both(self) -> Self {
        Self { mirrored: true, ..self }
    }

    /// The lump with a fillet of width `blend`.
    fn blend(self, blend: f32) -> Self {
        Self { blend, ..self }
    }

    /// The lump as a cut.
    fn carve(self) -> Self {
        Self { carved: true, ..self }
    }

    /// The ellipsoid turned about its middle.
    fn turn(mut self, world_from_form: Quat) -> Self {
        if let Form::Ellipsoid { sphere_from_world, .. } = &mut self.form {
            *sphere_from_world *= Mat3::from_quat(world_from_form.inverse());
        }
        self
    }

    fn distance(&self, point: Vec3) -> f32 {
        self.form.distance(if self.mirrored { point.with_x(point.x.abs()) } else { point })
    }

    /// The solid whose distance is `before` with this lump added or carved (polynomial smooth minimum).
    fn apply(&self, before: f32, point: Vec3) -> f32 {
        let own = self.distance(point);
        let melt = |a: f32, b: f32| {
            let near = (self.blend - (a - b).abs()).max(0.0);
            a.min(b) - near * near * 0.25 / self.blend
        };
        if self.carved { -melt(-before, own) } else { melt(before, own) }
    }
}

impl Sculpture {
    fn new(center: Vec3, half_size: f32, area: f32, relief: Relief) -> Self {
        Self { lumps: Vec::new(), relief, half_size, center, area }
    }

    fn add(&mut self, lumps: impl IntoIterator<Item = Lump>) {
        self.lumps.extend(lumps);
    }

    /// About the distance from the smooth solid, without relief, made of `lumps` alone.
    fn smooth_distance(&self, lumps: &[u16], point: Vec3) -> f32 {
        lumps.iter().fold(1e3, |distance, &lump| self.lumps[usize::from(lump)].apply(distance, point))
    }

    /// Approximate distance from the solid, given that only `lumps` matter near `point`. Within `exact_within` of the
    /// surface it includes all relief, elsewhere perhaps not.
    fn distance(&self, lumps: &[u16], point: Vec3, exact_within: f32) -> f32 {
        let Relief { height, greatest, tooth, greatest_tooth } = self.relief;
        let smooth = self.smooth_distance(lumps, point);
        if smooth.abs() > greatest + greatest_tooth + exact_within {
            return smooth;
        }
        let folded = smooth - height(point);
        if folded.abs() > greatest_tooth + exact_within { folded } else { folded - tooth(point) }
    }

    /// The lumps among `lumps` that can matter within `radius` of `point`: leaving out the others changes no bit there.
    fn near(&self, lumps: &[u16], point: Vec3, radius: f32) -> Vec<u16> {
        let lump = |at: usize| &self.lumps[usize::from(lumps[at])];
        let distances: Vec<f32> = (0..lumps.len()).map(|at| lump(at).distance(point)).collect();
        let solid = (0..lumps.len()).filter(|&at| !lump(at).carved);
        let nearest = solid.map(|at| distances[at]).fold(f32::INFINITY, f32::min).max(0.0);
        let mut near = Vec::new();
        // A lump's fillet reaches out by its width, and the fillet of a later lump may reach that.
        let mut widest_later = 0.0_f32;
        for at in (0..lumps.len()).rev() {
            let Lump { carved, blend, .. } = *lump(at);
            let beyond = if carved { 0.0 } else { nearest };
            if distances[at] < beyond + 2.0 * SLACK * radius + blend + widest_later {
                near.push(lumps[at]);
                widest_later = widest_later.max(blend);
            }
        }
        near.reverse();
        near
    }
}

/// Factor by which distances may be off.
const SLACK: f32 = 1.3;
