use std::collections::HashMap;
use std::num::NonZeroU32;
use std::path::Path;
use std::str::FromStr;

use glam::{DVec3, Vec2, Vec3, Vec4};
use umbrage_scene::{Error, MarkRun, Marks, Objects, linear_from_srgb};

use super::Positions;
use crate::memory::Budget;
use crate::origin::{FarBounds, local};
use crate::polygon::Cutter;
use crate::still::Vertices;
use crate::text;
use crate::text::{Lines, number, quoted, words};

/// Shapes of an OBJ file, in the file's own indices.
#[derive(Debug, Default)]
pub(super) struct Geometry {
    /// Origin of `positions` in the world.
    pub(super) origin: DVec3,
    positions: Vec<Vec3>,
    /// sRGB; as long as `positions` once any position has a colour, else empty.
    colors: Vec<Vec3>,
    tex_coords: Vec<Vec2>,
    normals: Vec<Vec3>,
    /// The different corners of the faces, in order of first use.
    corners: Vec<Corner>,
    /// The line on which each of `corners` was first used.
    line_of_corner: Vec<usize>,
    /// The first of `corners` at each position: nearly always the only one, so that most look-ups need no hash.
    corner_at_position: Vec<Option<NonZeroU32>>,
    /// All other corners.
    further_corners: HashMap<Corner, u32>,
    pub(super) triangles: Vec<[u32; 3]>,
    pub(super) material_of_triangle: Vec<u32>,
    /// The text after each `mtllib`.
    pub(super) libraries: Vec<String>,
    /// Names of the materials that triangles use, in order of first use; `None` before any `usemtl`.
    pub(super) material_names: Vec<Option<String>>,
    index_of_material: HashMap<Option<String>, u32>,
    material: Option<String>,
    /// The index of `material` in `material_names` once a triangle used it.
    material_index: Option<u32>,
    pub(super) objects: Objects,
    pub(super) marks: Marks,
    left_out: LeftOut,
    /// Corners of the face that is read.
    face: Vec<u32>,
    cutter: Cutter,
    budget: Budget,
}

/// One corner of a face: indices into the file's lists, counted from 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct Corner {
    position: NonZeroU32,
    tex_coord: Option<NonZeroU32>,
    normal: Option<NonZeroU32>,
}

/// Counts of content that no frame can hold, and of unknown statements.
#[derive(Debug, Default)]
struct LeftOut {
    small_faces: usize,
    /// Texture coordinates and normals that corners name but that aren't there.
    absent: usize,
    statements: usize,
    first_statement: Option<(usize, String)>,
}

impl Geometry {
    /// Reads the text of an OBJ file.
    ///
    /// # Errors
    /// Names the line that breaks the format.
    pub(super) fn parse(path: &Path, bytes: &[u8], origin: DVec3, budget: &Budget) -> Result<Self, Error> {
        let mut geometry = Self { origin, cutter: Cutter::new(budget), budget: budget.clone(), ..Self::default() };
        let mut lines = Lines::new(bytes);
        let mut joined = Vec::new();
        while let Some((line_number, line)) = lines.next() {
            let line = match line.strip_suffix(b"\\") {
                // Names may end in a backslash, above all paths of Windows.
                Some(_) if is_named(line) => line,
                None => line,
                Some(start) => {
                    join_continued(start, &mut lines, &mut joined);
                    &joined
                }
            };
            geometry
                .statement(line, line_number)
                .map_err(|cause| Error::malformed(path, format!("line {line_number}"), cause))?;
        }
        if geometry.triangles.is_empty() && geometry.marks.is_empty() {
            geometry.show_all_positions().map_err(|cause| Error::malformed(path, "the vertices", cause))?;
        }
        geometry.forget_absent();
        let Self { corners, positions, triangles, cutter, .. } = &mut geometry;
        let cut = cutter.finish(|vertex| position_of(corners, positions, vertex), triangles);
        cut.map_err(|cause| Error::malformed(path, "the faces", cause))?;
        Ok(geometry)
    }

    fn statement(&mut self, line: &[u8], line_number: usize) -> Result<(), String> {
        let (keyword, rest) = text::keyword(line);
        match keyword {
            b"v" => self.position(rest),
            b"vt" => {
                let ([u, v, _], _) = floats::<f32, 3>(rest, 1)?;
                self.budget.reserve(&mut self.tex_coords, 1, "texture coordinates")?;
                self.tex_coords.push(Vec2::new(u, 1.0 - v));
                Ok(())
            }
            b"vn" => {
                let (normal, _) = floats::<f32, 3>(rest, 3)?;
                self.budget.reserve(&mut self.normals, 1, "normals")?;
                self.normals.push(Vec3::from_array(normal).normalize_or_zero());
                Ok(())
            }
            b"f" | b"fo" => self.face(rest, line_number),
            b"usemtl" => {
                self.material = Some(String::from_utf8_lossy(rest).into_owned());
                self.material_index = None;
                Ok(())
            }
            b"mtllib" => {
                self.libraries.push(String::from_utf8_lossy(rest).into_owned());
                Ok(())
            }
            b"p" | b"l" => self.points_or_lines(rest, keyword == b"l", line_number),
            b"o" | b"g" => self.object(rest),
            // Hints that don't change pictures.
            b"" | b"s" | b"mg" | b"lod" | b"bevel" | b"c_interp" | b"d_interp" => Ok(()),
            comment if comment.starts_with(b"#") => Ok(()),
            other => {
                self.left_out.statements += 1;
                self.left_out.first_statement.get_or_insert_with(|| (line_number, quoted(other)));
                Ok(())
            }
        }
    }

    /// The last name counts, an object's or a group's: exporters write either, or groups as parts of objects.
    fn object(&mut self, name: &[u8]) -> Result<(), String> {
        let name = String::from_utf8_lossy(name);
        // Held twice, with an entry to look it up.
        self.budget.take(2 * name.len() as u64 + 128, "names of objects")?;
        // The format's name for groups without a name.
        let name = if name.is_empty() { "default" } else { &name };
        if self.objects.is_empty() && !self.triangles.is_empty() {
            self.objects.begin(0, "default");
        }
        self.objects.begin(self.triangles.len(), name);
        Ok(())
    }

    /// `x y z`, `x y z w` (a weight that polygons don't have) or `x y z r g b`.
    fn position(&mut self, rest: &[u8]) -> Result<(), String> {
        let ([x, y, z, r, g, b], count) = floats::<f32, 6>(rest, 3)?;
        self.budget.reserve(&mut self.positions, 1, "vertices")?;
        self.positions.push(if self.origin == DVec3::ZERO {
            Vec3::new(x, y, z)
        } else {
            local(world_position(rest)?, self.origin)
        });
        if count == 6 || !self.colors.is_empty() {
            let missing = self.positions.len() - self.colors.len();
            self.budget.reserve(&mut self.colors, missing, "vertices' colours")?;
        }
        if count == 6 {
            self.colors.resize(self.positions.len() - 1, Vec3::ONE);
            self.colors.push(Vec3::new(r, g, b));
        } else if !self.colors.is_empty() {
            self.colors.push(Vec3::ONE);
        }
        Ok(())
    }

    fn face(&mut self, rest: &[u8], line_number: usize) -> Result<(), String> {
        self.face.clear();
        for word in before_comment(rest) {
            let corner = self.corner(word)?;
            let vertex = self.vertex(corner, line_number)?;
            self.budget.reserve(&mut self.face, 1, "a face's corners")?;
            self.face.push(vertex);
        }
        let Some(count @ 1..) = self.face.len().checked_sub(2) else {
            self.left_out.small_faces += 1;
            return Ok(());
        };
        let material = self.used_material()?;
        self.budget.reserve(&mut self.material_of_triangle, count, "triangles' materials")?;
        let Self { corners, positions, triangles, cutter, .. } = self;
        cutter.cut(&self.face, |vertex| position_of(corners, positions, vertex), triangles)?;
        self.material_of_triangle.resize(self.triangles.len(), material);
        Ok(())
    }

    /// Points, or the vertices of lines one after the other.
    fn points_or_lines(&mut self, rest: &[u8], are_lines: bool, line_number: usize) -> Result<(), String> {
        let material = self.used_material()?;
        self.begin_marks(material, self.objects.last())?;
        let mut last = None;
        for word in before_comment(rest) {
            let corner = Corner { tex_coord: None, normal: None, ..self.corner(word)? };
            let vertex = self.vertex(corner, line_number)?;
            self.budget.reserve_marks(&mut self.marks, usize::from(!are_lines), usize::from(are_lines))?;
            match last.replace(vertex) {
                _ if !are_lines => self.marks.push_point(vertex),
                Some(last) => self.marks.push_line([last, vertex]),
                None => {}
            }
        }
        Ok(())
    }

    /// Begins a run of points and lines, unless the last one has the same material and object.
    fn begin_marks(&mut self, material: u32, object: Option<u32>) -> Result<(), String> {
        if self.marks.last_run() != Some((material, object)) {
            self.budget.take_for::<MarkRun<'_>>(1, "points and lines")?;
            self.marks.begin(material, object);
        }
        Ok(())
    }

    /// Makes all positions points, in a file with nothing else.
    fn show_all_positions(&mut self) -> Result<(), String> {
        let positions = self.positions.len() as u32;
        if positions == 0 {
            return Ok(());
        }
        let material = self.used_material()?;
        self.begin_marks(material, None)?;
        self.budget.reserve_marks(&mut self.marks, positions as usize, 0)?;
        for position in (1..=positions).filter_map(NonZeroU32::new) {
            let vertex = self.vertex(Corner { position, tex_coord: None, normal: None }, 0)?;
            self.marks.push_point(vertex);
        }
        Ok(())
    }

    /// Reads `v`, `v/t`, `v//n` or `v/t/n`.
    fn corner(&mut self, word: &[u8]) -> Result<Corner, String> {
        let mut parts = word.split(|&byte| byte == b'/');
        let position = parts.next().unwrap_or_default();
        let signed = number(position)?;
        let count = self.positions.len();
        let position = index(signed, count).ok_or_else(|| match signed {
            0 => "vertex 0: indices count from 1".to_owned(),
            _ => format!("vertex {signed} is not there: the file has {count} so far"),
        })?;
        let mut optional = |count| match parts.next() {
            None | Some(b"") => Ok(None),
            Some(part) => {
                let there = index(number(part)?, count);
                self.left_out.absent += usize::from(there.is_none());
                Ok::<_, String>(there)
            }
        };
        let tex_coord = optional(self.tex_coords.len())?;
        let normal = optional(self.normals.len())?;
        if parts.next().is_some() {
            return Err(format!("{} has more than three indices", quoted(word)));
        }
        Ok(Corner { position, tex_coord, normal })
    }

    /// The index of `corner` in `corners`, to which it is added if it isn't there yet.
    fn vertex(&mut self, corner: Corner, line_number: usize) -> Result<u32, String> {
        let next = u32::try_from(self.corners.len()).ok().filter(|&next| next < u32::MAX);
        let next = next.ok_or("more different corners than a 32-bit index counts")?;
        // Indices may point ahead in the file: only positions that are there already have an entry.
        if self.corner_at_position.len() < self.positions.len() {
            let more = self.positions.len() - self.corner_at_position.len();
            self.budget.reserve(&mut self.corner_at_position, more, "vertices")?;
            self.corner_at_position.resize(self.positions.len(), None);
        }
        match self.corner_at_position.get_mut(corner.position.get() as usize - 1) {
            Some(Some(index)) if self.corners[index.get() as usize - 1] == corner => return Ok(index.get() - 1),
            Some(none @ None) if !self.further_corners.contains_key(&corner) => *none = NonZeroU32::new(next + 1),
            _ => {
                self.budget.reserve_map(&mut self.further_corners, 1, "corners")?;
                let index = *self.further_corners.entry(corner).or_insert(next);
                if index < next {
                    return Ok(index);
                }
            }
        }
        self.budget.reserve(&mut self.corners, 1, "corners")?;
        self.budget.reserve(&mut self.line_of_corner, 1, "corners")?;
        self.corners.push(corner);
        self.line_of_corner.push(line_number);
        Ok(next)
    }

    fn used_material(&mut self) -> Result<u32, String> {
        if let Some(index) = self.material_index {
            return Ok(index);
        }
        let next = u32::try_from(self.material_names.len()).map_err(|_| "more materials than a 32-bit index counts")?;
        let index = *self.index_of_material.entry(self.material.clone()).or_insert(next);
        if index == next {
            self.material_names.push(self.material.clone());
        }
        self.material_index = Some(index);
        Ok(index)
    }

    /// Corners lose the texture coordinates and normals that the file never says.
    fn forget_absent(&mut self) {
        let [tex_coords, normals] = [self.tex_coords.len(), self.normals.len()];
        for corner in &mut self.corners {
            for (index, count) in [(&mut corner.tex_coord, tex_coords), (&mut corner.normal, normals)] {
                if index.is_some_and(|index| index.get() as usize > count) {
                    *index = None;
                    self.left_out.absent += 1;
                }
            }
        }
    }

    /// The vertices that the triangles point to.
    ///
    /// # Errors
    /// Names the first face with an index that is out of range.
    pub(super) fn vertices(&self, path: &Path) -> Result<Vertices, Error> {
        let positions = self.gather(path, "vertex", &self.positions, |corner| Some(corner.position), Vec3::ZERO)?;
        let normals = self.gather(path, "normal", &self.normals, |corner| corner.normal, Vec3::ZERO)?;
        let tex_coords =
            self.gather(path, "texture coordinate", &self.tex_coords, |corner| corner.tex_coord, Vec2::ZERO)?;
        let colors = match self.colors.len() {
            0 => Vec::new(),
            _ => self.gather(path, "vertex", &self.colors, |corner| Some(corner.position), Vec3::ONE)?,
        };
        let linear = |encoded: f32| linear_from_srgb(f64::from(encoded)) as f32;
        let colors: Vec<Vec4> = colors.into_iter().map(|color| color.map(linear).extend(1.0)).collect();
        Ok(Vertices { positions, normals, tex_coords, colors })
    }

    /// Which positions the vertices have.
    ///
    /// # Errors
    /// Where there is no memory for it.
    pub(super) fn positions(&self, path: &Path) -> Result<Positions, Error> {
        let taken = self.budget.take_for::<u32>(self.corners.len(), "positions of vertices");
        taken.map_err(|cause| Error::malformed(path, "the faces", cause))?;
        let of_vertex = self.corners.iter().map(|corner| corner.position.get() - 1).collect();
        Ok(Positions { count: self.positions.len(), of_vertex })
    }

    /// The value of each corner, `missing` where it has none; empty when none has one.
    fn gather<T: Copy>(
        &self,
        path: &Path,
        kind: &str,
        values: &[T],
        index: impl Fn(&Corner) -> Option<NonZeroU32>,
        missing: T,
    ) -> Result<Vec<T>, Error> {
        if self.corners.iter().all(|corner| index(corner).is_none()) {
            return Ok(Vec::new());
        }
        let taken = self.budget.take_for::<T>(self.corners.len(), kind);
        taken.map_err(|cause| Error::malformed(path, "the faces", cause))?;
        let value = |(corner, line): (&Corner, &usize)| match index(corner) {
            None => Ok(missing),
            Some(index) => values.get(index.get() as usize - 1).copied().ok_or_else(|| {
                let cause = format!("{kind} {index} is not there: the file has {}", values.len());
                Error::malformed(path, format!("line {line}"), cause)
            }),
        };
        self.corners.iter().zip(&self.line_of_corner).map(value).collect()
    }

    /// Messages for users about content that was left out.
    pub(super) fn warnings(&self) -> Vec<String> {
        let LeftOut { small_faces, absent, statements, first_statement } = &self.left_out;
        let mut warnings = Vec::new();
        if *small_faces > 0 {
            warnings.push(format!("left out {small_faces} faces with fewer than three corners"));
        }
        if *absent > 0 {
            warnings.push(format!(
                "left out {absent} texture coordinates and normals that faces name but that are not there"
            ));
        }
        if let Some((line, name)) = first_statement {
            warnings.push(format!("left out {statements} unknown statements, the first being {name} on line {line}"));
        }
        warnings.extend(self.cutter.warning());
        warnings
    }
}

/// Origin of a file's positions.
pub(super) fn origin(bytes: &[u8]) -> DVec3 {
    let vertices = Lines::new(bytes).map(|(_, line)| text::keyword(line)).filter(|(keyword, _)| *keyword == b"v");
    // Those that can't be read are errors later.
    FarBounds::origin_of(vertices.filter_map(|(_, rest)| world_position(rest).ok()))
}

fn world_position(rest: &[u8]) -> Result<DVec3, String> {
    floats::<f64, 3>(rest, 3).map(|(position, _)| position.into())
}

/// The position of vertex `vertex`, one of `corners`; `None` where the file says it later, or never.
fn position_of(corners: &[Corner], positions: &[Vec3], vertex: u32) -> Option<Vec3> {
    positions.get(corners[vertex as usize].position.get() as usize - 1).copied()
}

/// Whether the rest of the line is a name or a comment.
fn is_named(line: &[u8]) -> bool {
    let (keyword, _) = text::keyword(line);
    keyword.starts_with(b"#") || [&b"usemtl"[..], b"mtllib", b"o", b"g"].contains(&keyword)
}

/// Puts a line that ends in a backslash, `start` without it, and those that continue it into `joined`.
fn join_continued(start: &[u8], lines: &mut Lines<'_>, joined: &mut Vec<u8>) {
    joined.clear();
    joined.extend_from_slice(start);
    for (_, line) in lines {
        joined.push(b' ');
        match line.strip_suffix(b"\\") {
            Some(part) => joined.extend_from_slice(part),
            None => {
                joined.extend_from_slice(line);
                return;
            }
        }
    }
}

fn before_comment(rest: &[u8]) -> impl Iterator<Item = &[u8]> {
    words(rest).take_while(|word| !word.starts_with(b"#"))
}

/// Up to `N` numbers, and how many there are; at least `required`, the rest being zero.
fn floats<T: Copy + Default + FromStr, const N: usize>(
    rest: &[u8],
    required: usize,
) -> Result<([T; N], usize), String> {
    let mut values = [T::default(); N];
    let mut count = 0;
    for (value, word) in values.iter_mut().zip(before_comment(rest)) {
        *value = number(word)?;
        count += 1;
    }
    if count < required { Err(format!("{count} numbers where {required} are needed")) } else { Ok((values, count)) }
}

/// The index from 1 that a number means when the file's list has `count` items so far; `None` where there can't be one.
fn index(signed: i64, count: usize) -> Option<NonZeroU32> {
    // Negative indices count back from the last item so far.
    let index = if signed < 0 { signed.saturating_add_unsigned(count as u64 + 1) } else { signed };
    u32::try_from(index).ok().and_then(NonZeroU32::new)
}
