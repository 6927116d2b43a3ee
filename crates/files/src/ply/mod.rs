//! The Stanford polygon format, in text and in binary of either byte order.

mod body;
mod faces;
mod header;
mod vertices;

use std::path::Path;
use std::sync::Arc;

use glam::DVec3;
use umbrage_scene::{Error, Marks};

use crate::memory::Budget;
use crate::still::{Still, Vertices};
use body::Body;
use faces::{Faces, ListForm, index};
use header::{Element, Header, PropertyKind};

/// Reads a PLY file.
///
/// From `vertex`: `x y z`, `nx ny nz`, `s t` or `u v` or `texture_u texture_v` (turned upside down, as in OBJ), and `red
/// green blue alpha`, taken as sRGB where they are whole numbers and as linear where they are not. From `face`:
/// `vertex_indices` or `vertex_index`, polygons being cut as [`polygon`](crate::polygon) says, and colours, unless
/// vertices have some; from `tristrips`: `vertex_indices`, -1 ending a strip; from `edge`: `vertex1 vertex2`, as lines.
/// Without any of these, all vertices are points. Everything else is skipped. Positions count from `origin`, or else from
/// that of their [`FarBounds`](crate::origin::FarBounds).
///
/// # Errors
/// Where the file can't be read or breaks its format.
pub(crate) fn read(path: &Path, mut origin: Option<DVec3>, budget: &Budget) -> Result<Still, Error> {
    let bytes = crate::folder::read(path, budget).map_err(|source| Error::read(path, source))?;
    let header = Header::parse(path, &bytes)?;
    let mut body = Body::new(header.encoding, &bytes[header.bytes..]);
    // Known before any vertex is read, because faces may come first; it is checked when they are read.
    let vertex_count = header.elements.iter().find(|element| element.name == "vertex").map(|element| element.count);
    let vertex_count = vertex_count.ok_or_else(|| Error::malformed(path, "header", "no element `vertex`"))?;
    let mut vertices = None;
    let mut faces = Faces::new(vertex_count, budget);
    let mut marks = Marks::default();
    marks.begin(0, None);
    for element in &header.elements {
        check_count(path, element, &header, &body)?;
        let positions = vertices.as_ref().map_or(&[][..], |vertices: &Vertices| &vertices.positions);
        let at_row = |(row, cause): (u64, String)| Error::malformed(path, format!("{} {row}", element.name), cause);
        match element.name.as_str() {
            "vertex" if vertices.is_none() => {
                let plan = vertices::plan(element).map_err(|cause| Error::malformed(path, "header", cause))?;
                let origin = *origin.get_or_insert_with(|| vertices::origin(&plan, element, body.clone()));
                vertices = Some(vertices::read(&plan, element, &mut body, origin, budget).map_err(at_row)?);
            }
            "face" => faces.read(ListForm::Polygon, element, &mut body, positions).map_err(at_row)?,
            "tristrips" => faces.read(ListForm::Strips, element, &mut body, positions).map_err(at_row)?,
            "edge" if has_ends(element) => {
                read_edges(element, &mut body, vertex_count, &mut marks, budget).map_err(at_row)?;
            }
            _ => skip(element, &mut body).map_err(at_row)?,
        }
    }
    let mut vertices = vertices.unwrap_or_default();
    faces.finish(&vertices.positions).map_err(|cause| Error::malformed(path, "face", cause))?;
    let mut warnings = faces.warnings();
    if !body.is_blank() {
        warnings.push(format!("left out {} bytes after the last element", body.bytes_left()));
    }
    if faces.triangles.is_empty() && marks.is_empty() {
        let Vertices { positions, normals, .. } = &mut vertices;
        // Points have no use for normals.
        *normals = Vec::new();
        let room = budget.reserve_marks(&mut marks, positions.len(), 0);
        room.map_err(|cause| Error::malformed(path, "vertex", cause))?;
        let somewhere = positions.iter().zip(0..).filter(|(position, _)| position.is_finite());
        somewhere.for_each(|(_, vertex)| marks.push_point(vertex));
        let nowhere = positions.len() - marks.len();
        if nowhere > 0 {
            warnings.push(format!("left out {nowhere} points with a coordinate that is not finite"));
        } else if positions.is_empty() {
            warnings.push("the file has neither faces nor points".to_owned());
        }
    }
    let Faces { triangles, colors, .. } = faces;
    let frame = vertices.into_plain_frame(triangles, &colors, budget);
    let mut frame = frame.map_err(|cause| Error::malformed(path, "face", cause))?;
    Arc::make_mut(&mut frame.mesh).marks = marks;
    Ok(Still { frame, warnings, origin: origin.unwrap_or_default(), ..Still::default() })
}

/// Compares an element's count with the rest of the file.
fn check_count(path: &Path, element: &Element, header: &Header, body: &Body<'_>) -> Result<(), Error> {
    let claimed = u128::from(element.count) * element.least_bytes(header.encoding) as u128;
    // The last line of a text may lack its newline.
    let left = body.bytes_left() as u128 + 1;
    if claimed > left {
        let (name, count) = (&element.name, element.count);
        let location = format!("byte {}", header.bytes);
        let cause = format!("the header claims {count} of `{name}`, too many for the {} bytes left", body.bytes_left());
        return Err(Error::malformed(path, location, cause));
    }
    Ok(())
}

/// Skips all rows of an element; an error names the row.
fn skip(element: &Element, body: &mut Body<'_>) -> Result<(), (u64, String)> {
    if element.properties.is_empty() {
        return Ok(());
    }
    body.each_row(element, |body| {
        element
            .properties
            .iter()
            .try_for_each(|property| body.skip(property.kind).map_err(|cause| format!("`{}`: {cause}", property.name)))
    })
}

/// Names of the vertices at the ends of an edge.
const ENDS: [&str; 2] = ["vertex1", "vertex2"];

fn has_ends(element: &Element) -> bool {
    ENDS.iter().all(|end| element.properties.iter().any(|property| property.name == *end))
}

/// Reads all rows of an element whose [`ENDS`] are the ends of lines.
///
/// # Errors
/// The row's index, and the reason in words.
fn read_edges(
    element: &Element,
    body: &mut Body<'_>,
    vertex_count: u64,
    marks: &mut Marks,
    budget: &Budget,
) -> Result<(), (u64, String)> {
    // The count was compared with the bytes that are there.
    budget.reserve_marks(marks, 0, element.count as usize).map_err(|cause| (0, cause))?;
    body.each_row(element, |body| {
        let mut line = [0; 2];
        for property in &element.properties {
            let named = |cause| format!("`{}`: {cause}", property.name);
            match (ENDS.iter().position(|&end| end == property.name), property.kind) {
                (Some(end), PropertyKind::Scalar(scalar)) => {
                    line[end] = index(body.value(scalar).map_err(named)?, vertex_count).map_err(named)?;
                }
                _ => body.skip(property.kind).map_err(named)?,
            }
        }
        marks.push_line(line);
        Ok(())
    })
}
