//! Stereolithography files, in text and in binary.

use std::collections::HashMap;
use std::path::Path;
use std::str::FromStr;

use glam::{DVec3, Vec3, Vec4};
use umbrage_scene::{ColorSpace, Error, Material};

use crate::memory::Budget;
use crate::origin::{FarBounds, local};
use crate::still::{Still, Vertices};
use crate::text::{Lines, keyword, number, quoted};

/// Bytes before the triangles of a binary file: 80 of anything, then the count.
const HEADER_BYTES: usize = 84;
/// Bytes of a triangle in a binary file: a normal, three corners and two bytes of anything.
const TRIANGLE_BYTES: usize = 50;

/// Reads an STL file.
///
/// Corners at exactly the same position become one vertex. The file's normals follow from the corners and are left out:
/// the surface is flat. A binary file may have bytes after its last triangle, and a text may end without `endsolid`; both
/// are warnings. The last two bytes of a triangle are its colour where the file says so as Viscam or as Magics writes it.
/// Positions count from `origin`, or else from that of their [`FarBounds`].
///
/// # Errors
/// Where the file can't be read or breaks its format.
pub(crate) fn read(path: &Path, origin: Option<DVec3>, budget: &Budget) -> Result<Still, Error> {
    let bytes = crate::folder::read(path, budget).map_err(|source| Error::read(path, source))?;
    let mut warnings = Vec::new();
    let (soup, origin) = if is_text(&bytes) {
        let origin = origin.unwrap_or_else(|| FarBounds::origin_of(text_positions(&bytes)));
        (read_text(path, &bytes, origin, budget, &mut warnings)?, origin)
    } else {
        let mut soup = read_binary(path, &bytes, budget, &mut warnings)?;
        let world = || soup.positions.iter().map(|position| position.as_dvec3());
        let origin = origin.unwrap_or_else(|| FarBounds::origin_of(world()));
        if origin != DVec3::ZERO {
            soup.positions.iter_mut().for_each(|position| *position = local(position.as_dvec3(), origin));
        }
        (soup, origin)
    };
    drop(bytes);
    let Welded { positions, triangles, colors, .. } = soup;
    if triangles.is_empty() {
        warnings.push("the file has no triangles".to_owned());
    }
    let vertices = Vertices { positions, ..Vertices::default() };
    let frame = vertices.into_plain_frame(triangles, &colors, budget);
    let frame = frame.map_err(|cause| Error::malformed(path, "the triangles", cause))?;
    Ok(Still { frame, warnings, origin, ..Still::default() })
}

/// Whether the file is a text: it begins with `solid`, as some binary files do too, but its size isn't exactly that of a
/// binary file with its count, and it has a facet, or an end, near its start. Comments may come before.
fn is_text(bytes: &[u8]) -> bool {
    const NEAR: usize = 1024;
    let exact = binary_count(bytes).is_some_and(|count| binary_bytes(count) == bytes.len() as u64);
    let mut tokens = Tokens::new(bytes);
    let is_solid = tokens.next().is_some_and(|word| word.eq_ignore_ascii_case(b"solid"));
    // With the end of the word's line, one byte or two.
    let start = &bytes[bytes.len().saturating_sub(tokens.line.len() + 2 + tokens.lines.rest().len())..];
    let start = &start[..start.len().min(NEAR)];
    let has = |word: &[u8]| start.windows(word.len()).any(|window| window.eq_ignore_ascii_case(word));
    is_solid && !exact && (bytes.len() < HEADER_BYTES || has(b"facet") || has(b"endsolid") || has(b"end solid"))
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
    let colors = Colors::of(bytes, end);
    if colors.is_some() {
        budget.reserve(&mut soup.colors, count as usize, "triangles' colours").map_err(malformed)?;
    }
    for triangle in bytes[HEADER_BYTES..end].chunks_exact(TRIANGLE_BYTES) {
        // The 12 bytes of the normal come first.
        let float = |index: usize| {
            let start = 12 + 4 * index;
            f32::from_le_bytes([triangle[start], triangle[start + 1], triangle[start + 2], triangle[start + 3]])
        };
        soup.add([0, 3, 6].map(|first| Vec3::new(float(first), float(first + 1), float(first + 2))))
            .map_err(malformed)?;
        if let Some(colors) = colors {
            soup.colors.push(colors.color(attribute(triangle)));
        }
    }
    Ok(soup)
}

/// Encodings of triangles' colours in a binary file, with five bits each of red, green and blue.
#[derive(Clone, Copy, Debug)]
enum Colors {
    /// Viscam: blue is in the lowest bits, and the highest bit is set where there is a colour.
    Viscam,
    /// Magics: red is in the lowest bits, and the highest bit is set where the triangle has the file's own colour.
    Magics([u8; 3]),
}

impl Colors {
    /// The encoding of a file whose triangles end at byte `end`; `None` for a file without colours.
    fn of(bytes: &[u8], end: usize) -> Option<Self> {
        const MAGICS: &[u8] = b"COLOR=";
        let header = &bytes[..80];
        let magics = header.windows(MAGICS.len()).position(|window| window == MAGICS);
        if let Some(&[r, g, b, _, ..]) = magics.map(|at| &header[at + MAGICS.len()..]) {
            return Some(Self::Magics([r, g, b]));
        }
        let mut triangles = bytes[HEADER_BYTES..end].chunks_exact(TRIANGLE_BYTES);
        // Writers that fill the bytes with ones mean no colour.
        let is_colored = |bits: u16| bits & 0x8000 != 0 && bits != u16::MAX;
        triangles.any(|triangle| is_colored(attribute(triangle))).then_some(Self::Viscam)
    }

    /// The linear colour of a triangle with these bits.
    fn color(self, bits: u16) -> Vec4 {
        let eight_bits = |first: u16| ((u32::from(bits >> first & 31) * 255 + 15) / 31) as u8;
        let (low, middle, high) = (eight_bits(0), eight_bits(5), eight_bits(10));
        let [r, g, b] = match (self, bits & 0x8000 != 0) {
            (Self::Viscam, true) => [high, middle, low],
            (Self::Viscam, false) => return Material::clay().base_color,
            (Self::Magics(of_file), true) => of_file,
            (Self::Magics(_), false) => [low, middle, high],
        };
        ColorSpace::Srgb.decode([r, g, b, u8::MAX])
    }
}

/// The last two bytes of a triangle.
fn attribute(triangle: &[u8]) -> u16 {
    u16::from_le_bytes([triangle[48], triangle[49]])
}

/// The positions after each word `vertex`.
fn text_positions(bytes: &[u8]) -> impl Iterator<Item = DVec3> {
    let mut tokens = Tokens::new(bytes);
    std::iter::from_fn(move || {
        loop {
            let is_vertex = tokens.next()?.eq_ignore_ascii_case(b"vertex");
            // Words that aren't numbers are errors later, or names.
            if is_vertex && let Ok(position) = tokens.position::<f64>() {
                return Some(position.into());
            }
        }
    })
}

fn read_text(
    path: &Path,
    bytes: &[u8],
    origin: DVec3,
    budget: &Budget,
    warnings: &mut Vec<String>,
) -> Result<Welded, Error> {
    let mut soup = Welded { budget: budget.clone(), ..Welded::default() };
    let mut text = Text { tokens: Tokens::new(bytes), origin, in_solid: false, in_facet: false, corners: Vec::new() };
    while let Some(word) = text.tokens.next() {
        let read = text.statement(word, &mut soup);
        read.map_err(|cause| Error::malformed(path, format!("line {}", text.tokens.line_number), cause))?;
    }
    if text.in_facet {
        let location = format!("line {}", text.tokens.line_number);
        return Err(Error::malformed(path, location, "the file ends inside a facet"));
    }
    if text.in_solid {
        warnings.push("the file ends without `endsolid`: it may have been cut off".to_owned());
    }
    Ok(soup)
}

/// The words of a text, in one line or in many, without comments.
#[derive(Clone, Debug)]
struct Tokens<'a> {
    lines: Lines<'a>,
    /// The rest of the last word's line.
    line: &'a [u8],
    line_number: usize,
}

impl<'a> Tokens<'a> {
    fn new(text: &'a [u8]) -> Self {
        Self { lines: Lines::new(text), line: &[], line_number: 1 }
    }

    /// The next three words as numbers.
    fn position<T: FromStr>(&mut self) -> Result<[T; 3], String> {
        let mut coordinate = || number(self.next().ok_or("a vertex has 3 coordinates")?);
        Ok([coordinate()?, coordinate()?, coordinate()?])
    }

    /// Skips the name after `solid`: up to the first facet or the end, if its line has one, else the whole line.
    fn skip_name(&mut self) {
        self.line = from_word(self.line, begins_content);
    }

    /// Skips the name after `endsolid`: up to the next solid, if its line has one with a facet or an end, else the whole
    /// line.
    fn skip_last_name(&mut self) {
        let solid = from_word(self.line, |word, _| word.eq_ignore_ascii_case(b"solid"));
        let has_content = !from_word(keyword(solid).1, begins_content).is_empty();
        self.line = if has_content { solid } else { &[] };
    }
}

/// The part of a line from the first word that `is_it`, given that and the rest; empty if there is none.
fn from_word(mut line: &[u8], is_it: impl Fn(&[u8], &[u8]) -> bool) -> &[u8] {
    loop {
        let (word, after) = keyword(line);
        if word.is_empty() || is_it(word, after) {
            return line;
        }
        line = after;
    }
}

/// Whether a word, with `after` behind it, is a facet's first or a solid's last.
fn begins_content(word: &[u8], after: &[u8]) -> bool {
    let is = |word: &[u8], known: &[u8]| word.eq_ignore_ascii_case(known);
    is(word, b"facet") && is(keyword(after).0, b"normal") || is(word, b"endsolid")
}

impl<'a> Iterator for Tokens<'a> {
    type Item = &'a [u8];

    fn next(&mut self) -> Option<&'a [u8]> {
        loop {
            let (word, rest) = keyword(self.line);
            let is_comment = word.starts_with(b"//") || matches!(word, [b'#' | b';' | b'!', ..]);
            if !word.is_empty() && !is_comment {
                self.line = rest;
                return Some(word);
            }
            (self.line_number, self.line) = self.lines.next()?;
        }
    }
}

/// The state of reading a text.
#[derive(Debug)]
struct Text<'a> {
    tokens: Tokens<'a>,
    /// Origin of positions in the world.
    origin: DVec3,
    in_solid: bool,
    in_facet: bool,
    corners: Vec<Vec3>,
}

impl Text<'_> {
    fn statement(&mut self, word: &[u8], soup: &mut Welded) -> Result<(), String> {
        let mut joined = word.to_ascii_lowercase();
        if joined == b"end" {
            joined.extend(self.tokens.next().unwrap_or_default().to_ascii_lowercase());
        }
        match joined.as_slice() {
            b"solid" if !self.in_facet => {
                self.in_solid = true;
                self.tokens.skip_name();
            }
            b"endsolid" if !self.in_facet => {
                self.in_solid = false;
                self.tokens.skip_last_name();
            }
            b"facet" if !self.in_facet => {
                self.in_facet = true;
                self.corners.clear();
                self.skip_normal();
            }
            b"outer" | b"loop" | b"endloop" if self.in_facet => {}
            b"vertex" if self.in_facet => {
                let position = self.position()?;
                self.corners.push(position);
            }
            b"endfacet" if self.in_facet => {
                let corners = <[Vec3; 3]>::try_from(self.corners.as_slice())
                    .map_err(|_| format!("a facet of {} vertices instead of 3", self.corners.len()))?;
                soup.add(corners)?;
                self.in_facet = false;
            }
            other => return Err(format!("{} is out of place here", quoted(other))),
        }
        Ok(())
    }

    /// Skips `normal` and its numbers, if any.
    fn skip_normal(&mut self) {
        const KNOWN: [&[u8]; 5] = [b"outer", b"loop", b"vertex", b"facet", b"end"];
        let is_known = |word: &[u8]| {
            KNOWN.iter().any(|known| word.len() >= known.len() && word[..known.len()].eq_ignore_ascii_case(known))
        };
        let mut ahead = self.tokens.clone();
        if !ahead.next().is_some_and(|word| word.eq_ignore_ascii_case(b"normal")) {
            return;
        }
        for _ in 0..4 {
            self.tokens = ahead.clone();
            if ahead.next().is_none_or(is_known) {
                return;
            }
        }
    }

    fn position(&mut self) -> Result<Vec3, String> {
        if self.origin == DVec3::ZERO {
            self.tokens.position().map(Vec3::from_array)
        } else {
            self.tokens.position().map(|world| local(world.into(), self.origin))
        }
    }
}

/// Triangles whose corners share a vertex where their positions are exactly the same.
#[derive(Debug, Default)]
struct Welded {
    positions: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
    /// As long as `triangles`, or empty.
    colors: Vec<Vec4>,
    vertex_at: HashMap<[u32; 3], u32>,
    budget: Budget,
}

impl Welded {
    /// `count` is the actual number of triangles.
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
