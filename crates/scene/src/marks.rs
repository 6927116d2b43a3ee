//! Points and lines beside the triangles of a mesh.

use std::collections::TryReserveError;
use std::ops::Range;

/// Points and lines between vertices of a [`Mesh`](crate::Mesh), which pictures show as disks and ribbons with a size in
/// pixels.
///
/// They have the base colour of their material times their vertices' own, without any light. Rays don't meet them: they cast no
/// shadow and are in no mirror. 4 bytes a point, 8 a line.
#[derive(Clone, Debug, Default)]
pub struct Marks {
    points: Vec<u32>,
    lines: Vec<[u32; 2]>,
    runs: Vec<Run>,
}

/// Consecutive points and lines of one material and one object.
#[derive(Clone, Debug)]
struct Run {
    points: Range<usize>,
    lines: Range<usize>,
    material: u32,
    /// Index into the names of the mesh's objects.
    object: Option<u32>,
}

/// Points and lines of one material.
#[derive(Clone, Copy, Debug)]
pub struct MarkRun<'a> {
    /// The vertex of each point.
    pub points: &'a [u32],
    /// The two vertices of each line.
    pub lines: &'a [[u32; 2]],
    /// Index of the material.
    pub material: u32,
}

impl Marks {
    /// Adds points, by their vertices, and lines, by theirs, of one material.
    pub fn add(
        &mut self,
        points: impl IntoIterator<Item = u32>,
        lines: impl IntoIterator<Item = [u32; 2]>,
        material: u32,
    ) {
        self.begin(material, None);
        points.into_iter().for_each(|vertex| self.push_point(vertex));
        lines.into_iter().for_each(|line| self.push_line(line));
    }

    /// The vertex of each point.
    #[must_use]
    pub fn points(&self) -> &[u32] {
        &self.points
    }

    /// The two vertices of each line.
    #[must_use]
    pub fn lines(&self) -> &[[u32; 2]] {
        &self.lines
    }

    /// All points and lines, in runs of one material.
    pub fn runs(&self) -> impl Iterator<Item = MarkRun<'_>> {
        self.runs.iter().map(|Run { points, lines, material, .. }| MarkRun {
            points: &self.points[points.clone()],
            lines: &self.lines[lines.clone()],
            material: *material,
        })
    }

    /// The vertices of all points and lines; several of them may be the same.
    pub fn vertices(&self) -> impl Iterator<Item = u32> + Clone + '_ {
        self.points.iter().chain(self.lines.as_flattened()).copied()
    }

    /// Number of points and lines.
    #[must_use]
    pub fn len(&self) -> usize {
        self.points.len() + self.lines.len()
    }

    /// Whether there are neither points nor lines.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Bytes held.
    #[must_use]
    pub fn bytes(&self) -> usize {
        size_of_val(self.points.as_slice()) + size_of_val(self.lines.as_slice()) + size_of_val(self.runs.as_slice())
    }

    /// Begins a run: the following points and lines have this material and, as an index into the mesh's
    /// [names](crate::Objects::names), this object.
    pub fn begin(&mut self, material: u32, object: Option<u32>) {
        let (points, lines) = (self.points.len(), self.lines.len());
        self.runs.push(Run { points: points..points, lines: lines..lines, material, object });
    }

    /// The material and the object of the last run.
    #[must_use]
    pub fn last_run(&self) -> Option<(u32, Option<u32>)> {
        self.runs.last().map(|run| (run.material, run.object))
    }

    /// Adds a point to the last run.
    pub fn push_point(&mut self, vertex: u32) {
        self.points.push(vertex);
        self.runs.last_mut().into_iter().for_each(|run| run.points.end += 1);
    }

    /// Adds a line to the last run.
    pub fn push_line(&mut self, vertices: [u32; 2]) {
        self.lines.push(vertices);
        self.runs.last_mut().into_iter().for_each(|run| run.lines.end += 1);
    }

    /// Reserves memory for more points and lines.
    ///
    /// # Errors
    /// Where the system has too little.
    pub fn reserve(&mut self, points: usize, lines: usize) -> Result<(), TryReserveError> {
        self.points.try_reserve(points)?;
        self.lines.try_reserve(lines)
    }

    /// The runs that `is_shown` accepts, given the index of each and its object.
    pub(crate) fn only(&self, is_shown: impl Fn(usize, Option<u32>) -> bool) -> Self {
        let mut shown = Self::default();
        for (_, run) in self.runs.iter().enumerate().filter(|&(number, run)| is_shown(number, run.object)) {
            shown.begin(run.material, run.object);
            self.points[run.points.clone()].iter().for_each(|&vertex| shown.push_point(vertex));
            self.lines[run.lines.clone()].iter().for_each(|&line| shown.push_line(line));
        }
        shown
    }

    /// The material of each run, for checks.
    pub(crate) fn materials(&self) -> Vec<u32> {
        self.runs.iter().map(|run| run.material).collect()
    }
}
