use glam::{Vec3, Vec4};

use super::body::Body;
use super::header::{Element, Property, PropertyKind};
use super::vertices;
use crate::memory::Budget;
use crate::polygon::Cutter;
use crate::scalar::Scalar;

/// The triangles of a file.
#[derive(Debug, Default)]
pub(super) struct Faces {
    pub(super) triangles: Vec<[u32; 3]>,
    /// Linear colours of the triangles, where faces have some; else empty.
    pub(super) colors: Vec<Vec4>,
    /// Exclusive upper bound of indices.
    vertex_count: u64,
    small_faces: u64,
    corner_tex_coords: bool,
    /// Indices of the face that is read.
    face: Vec<u32>,
    cutter: Cutter,
    budget: Budget,
}

/// Meaning of a list of vertices.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ListForm {
    /// The corners of one polygon.
    Polygon,
    /// Triangle strips, each ended by -1.
    Strips,
}

impl Faces {
    pub(super) fn new(vertex_count: u64, budget: &Budget) -> Self {
        Self { vertex_count, cutter: Cutter::new(budget), budget: budget.clone(), ..Self::default() }
    }

    /// Reads all rows of an element whose list of vertices has this form. `positions` are those of the vertices, none where they
    /// come later in the file.
    ///
    /// # Errors
    /// The row's index, and the reason in words.
    pub(super) fn read(
        &mut self,
        form: ListForm,
        element: &Element,
        body: &mut Body<'_>,
        positions: &[Vec3],
    ) -> Result<(), (u64, String)> {
        let Some((list, count_type, index_type)) = index_list(&element.properties) else {
            return Err((0, "no list `vertex_indices` or `vertex_index`".to_owned()));
        };
        self.corner_tex_coords |= element.properties.iter().any(|property| property.name == "texcoord");
        if form == ListForm::Polygon {
            self.reserve(element, body, index_type).map_err(|cause| (0, cause))?;
        }
        let parts: Vec<_> = element.properties.iter().map(color_part_of).collect();
        let mut types = [None; 4];
        for (part, scalar) in parts.iter().flatten() {
            types[*part] = Some(*scalar);
        }
        let has_colors = form == ListForm::Polygon && types[..3].iter().all(Option::is_some);
        if has_colors {
            self.color(Vec4::ONE).map_err(|cause| (0, cause))?;
        }
        body.each_row(element, |body| {
            let mut parts_of_row = [0.0; 4];
            for (index, property) in element.properties.iter().enumerate() {
                let named = |cause| format!("`{}`: {cause}", property.name);
                match (form, parts[index]) {
                    (_, Some((part, scalar))) => parts_of_row[part] = body.value(scalar).map_err(named)?,
                    _ if index != list => body.skip(property.kind).map_err(named)?,
                    (ListForm::Polygon, _) => self.face(body, count_type, index_type, positions)?,
                    (ListForm::Strips, _) => self.strips(body, count_type, index_type)?,
                }
            }
            if has_colors {
                self.color(vertices::color(parts_of_row, types))?;
            }
            Ok(())
        })
    }

    /// Gives a colour to all triangles that have none yet.
    fn color(&mut self, color: Vec4) -> Result<(), String> {
        let count = self.triangles.len() - self.colors.len();
        self.budget.reserve(&mut self.colors, count, "faces' colours")?;
        self.colors.resize(self.triangles.len(), color);
        Ok(())
    }

    fn face(
        &mut self,
        body: &mut Body<'_>,
        count_type: Scalar,
        index_type: Scalar,
        positions: &[Vec3],
    ) -> Result<(), String> {
        let count = body.list_length(count_type, index_type)?;
        self.face.clear();
        self.budget.reserve(&mut self.face, count, "a face's corners")?;
        for _ in 0..count {
            self.face.push(index(body.value(index_type)?, self.vertex_count)?);
        }
        self.small_faces += u64::from(count < 3);
        self.cutter.cut(&self.face, |vertex| positions.get(vertex as usize).copied(), &mut self.triangles)
    }

    /// Cuts polygons that came before the vertices' `positions`.
    ///
    /// # Errors
    /// Where there is no memory for it.
    pub(super) fn finish(&mut self, positions: &[Vec3]) -> Result<(), String> {
        self.cutter.finish(|vertex| positions.get(vertex as usize).copied(), &mut self.triangles)
    }

    /// Reads strips. Every second triangle of a strip runs the other way round; those that join the
    /// parts of a strip by repeating a vertex are left out.
    fn strips(&mut self, body: &mut Body<'_>, count_type: Scalar, index_type: Scalar) -> Result<(), String> {
        let mut last: [Option<u32>; 2] = [None; 2];
        let mut flipped = false;
        let count = body.list_length(count_type, index_type)?;
        self.budget.reserve(&mut self.triangles, count.saturating_sub(2), "triangles")?;
        for _ in 0..count {
            let value = body.value(index_type)?;
            if value == -1.0 {
                (last, flipped) = ([None; 2], false);
                continue;
            }
            let vertex = index(value, self.vertex_count)?;
            if let [Some(a), Some(b)] = last {
                if a != b && b != vertex && vertex != a {
                    self.triangles.push(if flipped { [b, a, vertex] } else { [a, b, vertex] });
                }
                flipped = !flipped;
            }
            last = [last[1], Some(vertex)];
        }
        Ok(())
    }

    /// Reserves one triangle a face, if the rest of the file can hold that many.
    fn reserve(&mut self, element: &Element, body: &Body<'_>, index_type: Scalar) -> Result<(), String> {
        let least_bytes = match body {
            Body::Ascii { .. } => "3 0 1 2\n".len(),
            Body::Binary { .. } => 1 + 3 * index_type.bytes(),
        };
        let most = body.bytes_left() / least_bytes;
        let count = usize::try_from(element.count).map_or(most, |count| count.min(most));
        self.budget.reserve(&mut self.triangles, count, "triangles")
    }

    /// Messages for users about content that was left out.
    pub(super) fn warnings(&self) -> Vec<String> {
        let mut warnings = Vec::new();
        if self.small_faces > 0 {
            warnings.push(format!("left out {} faces with fewer than three corners", self.small_faces));
        }
        if self.corner_tex_coords {
            warnings.push("left out texture coordinates that belong to corners of faces (`texcoord`)".to_owned());
        }
        warnings.extend(self.cutter.warning());
        warnings
    }
}

/// Which part of a colour a property is, 0 to 3, and its type.
fn color_part_of(property: &Property) -> Option<(usize, Scalar)> {
    match property.kind {
        PropertyKind::Scalar(scalar) => Some((vertices::color_part(&property.name)?, scalar)),
        PropertyKind::List { .. } => None,
    }
}

/// The index of the list of vertices among the properties, and the types of its length and items.
fn index_list(properties: &[Property]) -> Option<(usize, Scalar, Scalar)> {
    properties.iter().enumerate().find_map(|(index, property)| match property.kind {
        PropertyKind::List { count, item } if matches!(property.name.as_str(), "vertex_indices" | "vertex_index") => {
            Some((index, count, item))
        }
        _ => None,
    })
}

/// The vertex index of a value, below the number of vertices.
pub(super) fn index(value: f64, vertex_count: u64) -> Result<u32, String> {
    let vertex = value as u32;
    if f64::from(vertex) == value && u64::from(vertex) < vertex_count {
        Ok(vertex)
    } else {
        Err(format!("vertex {value} is not there: the file has {vertex_count}"))
    }
}
