use glam::{Vec2, Vec3, Vec4};

use super::body::Body;
use super::header::{Element, Kind, Scalar};
use crate::ColorSpace;
use crate::still::Vertices;
use crate::texture::linear_from_srgb;

/// What the properties of a vertex mean, in their order.
#[derive(Debug)]
pub(super) struct Plan {
    steps: Vec<Step>,
    has_normals: bool,
    has_tex_coords: bool,
    has_colors: bool,
}

#[derive(Clone, Copy, Debug)]
enum Step {
    /// A number that goes to this index of a row.
    Keep(Scalar, usize),
    Skip(Kind),
}

/// The numbers of a vertex: where each of [`ROLES`] is.
type Row = [f64; ROLES.len()];

/// The names of each number that a vertex may have.
const ROLES: [&[&str]; 12] = [
    &["x"],
    &["y"],
    &["z"],
    &["nx"],
    &["ny"],
    &["nz"],
    &["u", "s", "texture_u"],
    &["v", "t", "texture_v"],
    &["red", "r", "diffuse_red"],
    &["green", "g", "diffuse_green"],
    &["blue", "b", "diffuse_blue"],
    &["alpha", "a", "diffuse_alpha"],
];
const POSITION: usize = 0;
const NORMAL: usize = 3;
const TEX_COORD: usize = 6;
const COLOR: usize = 8;
const OPACITY: usize = 11;

/// Decides what each property of the element `vertex` is for.
///
/// # Errors
/// Where a coordinate is missing or is a list.
pub(super) fn plan(element: &Element) -> Result<Plan, String> {
    let mut found = [false; ROLES.len()];
    let mut steps = Vec::with_capacity(element.properties.len());
    for property in &element.properties {
        let role = ROLES.iter().position(|names| names.contains(&property.name.as_str()));
        steps.push(match (property.kind, role) {
            (Kind::Scalar(scalar), Some(role)) if !found[role] => {
                found[role] = true;
                Step::Keep(scalar, role)
            }
            (kind, _) => Step::Skip(kind),
        });
    }
    if let Some(missing) = (POSITION..POSITION + 3).find(|&role| !found[role]) {
        return Err(format!("the element `vertex` has no number `{}`", ROLES[missing][0]));
    }
    let has = |first: usize, count: usize| found[first..first + count].iter().all(|&found| found);
    Ok(Plan { steps, has_normals: has(NORMAL, 3), has_tex_coords: has(TEX_COORD, 2), has_colors: has(COLOR, 3) })
}

/// Reads all rows of the element `vertex`, whose count was compared with the bytes that are there.
///
/// # Errors
/// Says in which row, and what is wrong there.
pub(super) fn read(plan: &Plan, element: &Element, body: &mut Body<'_>) -> Result<Vertices, (u64, String)> {
    if element.count > u64::from(u32::MAX) {
        return Err((u64::from(u32::MAX), "more vertices than a 32-bit index counts".to_owned()));
    }
    let reserve = |wanted: bool| if wanted { element.count as usize } else { 0 };
    let mut vertices = Vertices {
        positions: Vec::with_capacity(reserve(true)),
        normals: Vec::with_capacity(reserve(plan.has_normals)),
        tex_coords: Vec::with_capacity(reserve(plan.has_tex_coords)),
        colors: Vec::with_capacity(reserve(plan.has_colors)),
    };
    let color_type = plan.color_type();
    for number in 0..element.count {
        let row = plan.row(body).map_err(|cause| (number, cause))?;
        vertices.positions.push(vec3(&row, POSITION));
        if plan.has_normals {
            vertices.normals.push(vec3(&row, NORMAL).normalize_or_zero());
        }
        if plan.has_tex_coords {
            vertices.tex_coords.push(Vec2::new(row[TEX_COORD] as f32, 1.0 - row[TEX_COORD + 1] as f32));
        }
        if plan.has_colors {
            vertices.colors.push(color(&row, color_type));
        }
    }
    Ok(vertices)
}

/// The types of a colour's parts and of its opacity.
type ColorType = [Option<Scalar>; 4];

impl Plan {
    fn row(&self, body: &mut Body<'_>) -> Result<Row, String> {
        let mut row = [0.0; ROLES.len()];
        body.begin_row()?;
        for step in &self.steps {
            match *step {
                Step::Keep(scalar, role) => {
                    row[role] = body.value(scalar).map_err(|cause| format!("`{}`: {cause}", ROLES[role][0]))?;
                }
                Step::Skip(kind) => body.skip(kind)?,
            }
        }
        Ok(row)
    }

    fn color_type(&self) -> ColorType {
        [COLOR, COLOR + 1, COLOR + 2, OPACITY].map(|wanted| {
            self.steps.iter().find_map(|step| match *step {
                Step::Keep(scalar, role) if role == wanted => Some(scalar),
                _ => None,
            })
        })
    }
}

/// Linear colour and opacity: floating-point numbers are both already; whole numbers are parts of their type's
/// highest, and colours then sRGB.
fn color(row: &Row, [r, g, b, opacity]: ColorType) -> Vec4 {
    let [red, green, blue, alpha] = [COLOR, COLOR + 1, COLOR + 2, OPACITY].map(|role| row[role]);
    let whole = [r, g, b].map(|part| part == Some(Scalar::U8)) == [true; 3];
    let highest = |scalar: Scalar| scalar.whole_range().map(|(_, highest)| highest);
    let color = if whole {
        ColorSpace::Srgb.decode([red as u8, green as u8, blue as u8, 0]).truncate()
    } else {
        let part = |value: f64, scalar: Option<Scalar>| match scalar.and_then(highest) {
            Some(highest) => linear_from_srgb((value / highest).max(0.0)) as f32,
            None => value as f32,
        };
        Vec3::new(part(red, r), part(green, g), part(blue, b))
    };
    color.extend(opacity.map_or(1.0, |scalar| highest(scalar).map_or(alpha, |highest| alpha / highest)) as f32)
}

fn vec3(row: &Row, first: usize) -> Vec3 {
    Vec3::new(row[first] as f32, row[first + 1] as f32, row[first + 2] as f32)
}
