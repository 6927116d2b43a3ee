use glam::{DVec3, Vec2, Vec3, Vec4};
use umbrage_scene::{ColorSpace, linear_from_srgb};

use super::body::Body;
use super::header::{Element, PropertyKind};
use crate::memory::Budget;
use crate::origin::{FarBounds, local};
use crate::scalar::Scalar;
use crate::still::Vertices;

/// Roles of a vertex's properties.
#[derive(Debug)]
pub(super) struct Plan {
    /// In their order; with the index in a [`Row`] where their numbers are kept.
    properties: Vec<(PropertyKind, Option<usize>)>,
    /// The types of a row's numbers; `None` for missing ones.
    types: [Option<Scalar>; ROLES.len()],
}

/// The numbers of a vertex, in the order of [`ROLES`].
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
/// Names of red, green, blue and opacity.
const COLOR: usize = 8;

/// Which part of a colour a property of this name is, 0 to 3 for red, green, blue and opacity.
pub(super) fn color_part(name: &str) -> Option<usize> {
    ROLES[COLOR..].iter().position(|names| names.contains(&name))
}

/// Assigns a role to each property of the element `vertex`.
///
/// # Errors
/// Where a coordinate is missing or is a list.
pub(super) fn plan(element: &Element) -> Result<Plan, String> {
    let mut plan = Plan { properties: Vec::with_capacity(element.properties.len()), types: [None; ROLES.len()] };
    for property in &element.properties {
        let role = ROLES.iter().position(|names| names.contains(&property.name.as_str()));
        let role = match (property.kind, role) {
            (PropertyKind::Scalar(scalar), Some(role)) if plan.types[role].is_none() => {
                plan.types[role] = Some(scalar);
                Some(role)
            }
            _ => None,
        };
        plan.properties.push((property.kind, role));
    }
    match (POSITION..POSITION + 3).find(|&role| plan.types[role].is_none()) {
        Some(missing) => Err(format!("the element `vertex` has no number `{}`", ROLES[missing][0])),
        None => Ok(plan),
    }
}

/// Origin of the positions of the element `vertex`.
pub(super) fn origin(plan: &Plan, element: &Element, mut body: Body<'_>) -> DVec3 {
    let mut bounds = FarBounds::default();
    // Rows that can't be read are errors later.
    let all = body.each_row(element, |body| match bounds.add(world_position(&plan.row(body)?)) {
        true => Ok(()),
        false => Err("they aren't far".to_owned()),
    });
    if all.is_ok() { bounds.origin() } else { DVec3::ZERO }
}

/// Reads all rows of the element `vertex`, whose count was compared with the bytes that are there.
///
/// # Errors
/// The row's index, and the reason in words.
pub(super) fn read(
    plan: &Plan,
    element: &Element,
    body: &mut Body<'_>,
    origin: DVec3,
    budget: &Budget,
) -> Result<Vertices, (u64, String)> {
    if element.count > u64::from(u32::MAX) {
        return Err((u64::from(u32::MAX), "more vertices than a 32-bit index counts".to_owned()));
    }
    let has = |first: usize, count: usize| plan.types[first..first + count].iter().all(Option::is_some);
    let (has_normals, has_tex_coords, has_colors) = (has(NORMAL, 3), has(TEX_COORD, 2), has(COLOR, 3));
    let room = |wanted: bool| if wanted { element.count as usize } else { 0 };
    let mut vertices = Vertices::default();
    budget
        .reserve(&mut vertices.positions, room(true), "vertices")
        .and_then(|()| budget.reserve(&mut vertices.normals, room(has_normals), "normals"))
        .and_then(|()| budget.reserve(&mut vertices.tex_coords, room(has_tex_coords), "texture coordinates"))
        .and_then(|()| budget.reserve(&mut vertices.colors, room(has_colors), "vertices' colours"))
        .map_err(|cause| (0, cause))?;
    body.each_row(element, |body| {
        let row = plan.row(body)?;
        vertices.positions.push(local(world_position(&row), origin));
        if has_normals {
            vertices.normals.push(vec3(&row, NORMAL).normalize_or_zero());
        }
        if has_tex_coords {
            vertices.tex_coords.push(Vec2::new(row[TEX_COORD] as f32, 1.0 - row[TEX_COORD + 1] as f32));
        }
        if has_colors {
            let parts = [COLOR, COLOR + 1, COLOR + 2, COLOR + 3];
            vertices.colors.push(color(parts.map(|part| row[part]), parts.map(|part| plan.types[part])));
        }
        Ok(())
    })?;
    Ok(vertices)
}

impl Plan {
    fn row(&self, body: &mut Body<'_>) -> Result<Row, String> {
        let mut row = [0.0; ROLES.len()];
        for &(kind, role) in &self.properties {
            match (kind, role) {
                (PropertyKind::Scalar(scalar), Some(role)) => {
                    row[role] = body.value(scalar).map_err(|cause| format!("`{}`: {cause}", ROLES[role][0]))?;
                }
                _ => body.skip(kind)?,
            }
        }
        Ok(row)
    }
}

/// Linear colour and opacity, of red, green, blue and opacity: floating-point numbers are both already; whole numbers are parts
/// of their type's highest, and colours then sRGB.
pub(super) fn color([red, green, blue, alpha]: [f64; 4], [r, g, b, opacity]: [Option<Scalar>; 4]) -> Vec4 {
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

fn world_position(row: &Row) -> DVec3 {
    DVec3::new(row[POSITION], row[POSITION + 1], row[POSITION + 2])
}

fn vec3(row: &Row, first: usize) -> Vec3 {
    Vec3::new(row[first] as f32, row[first + 1] as f32, row[first + 2] as f32)
}
