//! Stereolithography files, in text and in binary.

use std::collections::HashMap;
use std::path::Path;

use glam::Vec3;

use crate::memory::Budget;
use crate::text::{Lines, keyword, number, quoted, words};
use crate::{Error, Frame, still::Still};

/// Bytes before the triangles of a binary file: 80 of anything, then the count.
const HEADER_BYTES: usize = 84;
/// Bytes of a triangle in a binary file: a normal, three corners and two bytes of anything.
const TRIANGLE_BYTES: usize = 50;

/// Reads an STL file.
///
/// Corners at exactly the same position become one vertex. The file's normals say nothing that the corners don't and
/// are left out: the surface is flat. A binary file may have bytes after its last triangle, and a text may end without
/// `endsolid`; both are warnings.
///
/// # Errors
/// Where the file can't be read or breaks its format.
pub(crate) fn read(path: &Path, budget: &Budget) -> Result<Still, Error> {
    let bytes = crate::folder::read(path, budget).map_err(|source| Error::read(path, source))?;
    let mut warnings = Vec::new();
    let soup = if is_text(&bytes) {
        read_text(path, &bytes, budget, &mut warnings)?
    } else {
        read_binary(path, &bytes, budget, &mut warnings)?
    };
    drop(bytes);
    if soup.triangles.is_empty() {
        warnings.push("the file has no triangles".to_owned());
    }
    Ok(Still { frame: Frame::from_triangles(soup.positions, soup.triangles), warnings, ..Still::default() })
}

/// Whether the file is a text: it begins with `solid`, as some binary files do too, but its size isn't just what a
/// binary file's count asks for, and it has a facet, or an end, near its start.
fn is_text(bytes: &[u8]) -> bool {
    const NEAR: usize = 1024;
    let start = &bytes[..bytes.len().min(NEAR)];
    let has = |word: &[u8]| start.windows(word.len()).any(|window| window.eq_ignore_ascii_case(word));
    let exact = binary_count(bytes).is_some_and(|count| binary_bytes(count) == bytes.len() as u64);
    let is_solid = start.trim_ascii_start().get(..5).is_some_and(|word| word.eq_ignore_ascii_case(b"solid"));
    is_solid && !exact && (bytes.len() < HEADER_BYTES || has(b"facet") || has(b"endsolid"))
}

/// The count that a binary file claims; `None` if it is too short to claim one.
fn binary_count(bytes: &[u8]) -> Option<u32> {
    bytes.get(80..HEADER_BYTES).and_then(|count| count.try_into().ok()).map(u32::from_le_bytes)
}

fn binary_bytes(count: u32) -> u64 {
    HEADER_BYTES as u64 + u64::from(count) * TRIANGLE_BYTES as u64
}

fn read_binary(path: &Path, bytes: &[u8], budget: &Budget, warnings: &mut Vec<String>) -> Result<Welded, Error> {
    let location = || format!("byte {}", bytes.len());
    let count = binary_count(bytes).ok_or_else(|| {
        Error::malformed(path, location(), "the file ends here, before the count of triangles of a binary STL file")
    })?;
    let wanted = binary_bytes(count);
    if wanted > bytes.len() as u64 {
        let there = (bytes.len() - HEADER_BYTES) / TRIANGLE_BYTES;
        let cause = format!("the file ends here, after {there} of the {count} triangles that it claims");
        return Err(Error::malformed(path, location(), cause));
    }
    let end = wanted as usize;
    if end < bytes.len() {
        warnings.push(format!("left out {} bytes after the last triangle", bytes.len() - end));
    }
    let malformed = |cause| Error::malformed(path, "the triangles", cause);
    let mut soup = Welded::with_room_for(count as usize, budget).map_err(malformed)?;
    for triangle in bytes[HEADER_BYTES..end].chunks_exact(TRIANGLE_BYTES) {
        // The 12 bytes of the normal come first.
        let float = |index: usize| {
            let start = 12 + 4 * index;
            f32::from_le_bytes([triangle[start], triangle[start + 1], triangle[start + 2], triangle[start + 3]])
        };
        soup.add([0, 3, 6].map(|first| Vec3::new(float(first), float(first + 1), float(first + 2))))
            .map_err(malformed)?;
    }
    Ok(soup)
}

fn read_text(path: &Path, bytes: &[u8], budget: &Budget, warnings: &mut Vec<String>) -> Result<Welded, Error> {
    let mut soup = Welded { budget: budget.clone(), ..Welded::default() };
    let mut text = Text::default();
    let mut last = 1;
    for (line_number, line) in Lines::new(bytes) {
        last = line_number;
        text.line(line, &mut soup).map_err(|cause| Error::malformed(path, format!("line {line_number}"), cause))?;
    }
    if text.in_facet {
        return Err(Error::malformed(path, format!("line {last}"), "the file ends inside a facet"));
    }
    if text.in_solid {
        warnings.push("the file ends without `endsolid`: it may have been cut off".to_owned());
    }
    Ok(soup)
}

/// How far the reading of a text has come.
#[derive(Debug, Default)]
struct Text {
    in_solid: bool,
    in_facet: bool,
    corners: Vec<Vec3>,
}

impl Text {
    fn line(&mut self, line: &[u8], soup: &mut Welded) -> Result<(), String> {
        let (keyword, rest) = keyword(line);
        match keyword.to_ascii_lowercase().as_slice() {
            b"" => {}
            b"solid" => self.in_solid = true,
            b"endsolid" if !self.in_facet => self.in_solid = false,
            b"facet" if !self.in_facet => {
                self.in_facet = true;
                self.corners.clear();
            }
            b"outer" | b"endloop" if self.in_facet => {}
            b"vertex" if self.in_facet => self.corners.push(position(rest)?),
            b"endfacet" if self.in_facet => {
                let corners = <[Vec3; 3]>::try_from(self.corners.as_slice())
                    .map_err(|_| format!("a facet of {} vertices instead of 3", self.corners.len()))?;
                soup.add(corners)?;
                self.in_facet = false;
            }
            _ => return Err(format!("{} is out of place here", quoted(keyword))),
        }
        Ok(())
    }
}

fn position(rest: &[u8]) -> Result<Vec3, String> {
    let mut words = words(rest);
    let mut coordinate = || number(words.next().ok_or("a vertex has 3 coordinates")?);
    Ok(Vec3::new(coordinate()?, coordinate()?, coordinate()?))
}

/// Triangles whose corners share a vertex where their positions are exactly the same.
#[derive(Debug, Default)]
struct Welded {
    positions: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
    vertex_at: HashMap<[u32; 3], u32>,
    budget: Budget,
}

impl Welded {
    /// `count` is a number of triangles that are really there.
    fn with_room_for(count: usize, budget: &Budget) -> Result<Self, String> {
        let mut soup = Self { budget: budget.clone(), ..Self::default() };
        // A closed surface has about half as many vertices as triangles.
        budget.reserve(&mut soup.positions, count / 2 + 2, "vertices")?;
        budget.reserve(&mut soup.triangles, count, "triangles")?;
        budget.reserve_map(&mut soup.vertex_at, count / 2 + 2, "vertices")?;
        Ok(soup)
    }

    fn add(&mut self, corners: [Vec3; 3]) -> Result<(), String> {
        let mut triangle = [0; 3];
        self.budget.reserve(&mut self.positions, 3, "vertices")?;
        self.budget.reserve(&mut self.triangles, 1, "triangles")?;
        self.budget.reserve_map(&mut self.vertex_at, 3, "vertices")?;
        for (vertex, position) in triangle.iter_mut().zip(corners) {
            let next = u32::try_from(self.positions.len()).map_err(|_| "more vertices than a 32-bit index counts")?;
            // Adding zero makes -0 the same as 0. Bits, unlike floats, find NaNs again.
            let key = (position + Vec3::ZERO).to_array().map(f32::to_bits);
            *vertex = *self.vertex_at.entry(key).or_insert(next);
            if *vertex == next {
                self.positions.push(position);
            }
        }
        self.triangles.push(triangle);
        Ok(())
    }
}
