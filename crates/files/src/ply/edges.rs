use umbrage_scene::Marks;

use super::body::Body;
use super::faces::index;
use super::header::{Element, Kind};
use crate::memory::Budget;

/// Reads all rows of an element whose `vertex1` and `vertex2` are the ends of lines. Without these, it is skipped.
///
/// # Errors
/// The row's index, and the reason in words.
pub(super) fn read(
    element: &Element,
    body: &mut Body<'_>,
    vertex_count: u64,
    marks: &mut Marks,
    budget: &Budget,
) -> Result<(), (u64, String)> {
    let ends = ["vertex1", "vertex2"];
    let is_end = |name: &str| element.properties.iter().any(|property| property.name == name);
    let are_there = ends.into_iter().all(is_end);
    if element.properties.is_empty() {
        return Ok(());
    }
    // The count was compared with the bytes that are there.
    let lines = if are_there { element.count as usize } else { 0 };
    budget.reserve_marks(marks, 0, lines).map_err(|cause| (0, cause))?;
    body.each_row(element, |body| {
        let mut line = [0; 2];
        for property in &element.properties {
            let named = |cause| format!("`{}`: {cause}", property.name);
            match (ends.iter().position(|&end| end == property.name), property.kind) {
                (Some(end), Kind::Scalar(scalar)) if are_there => {
                    line[end] = index(body.value(scalar).map_err(named)?, vertex_count).map_err(named)?;
                }
                _ => body.skip(property.kind).map_err(named)?,
            }
        }
        if are_there {
            marks.push_line(line);
        }
        Ok(())
    })
}
