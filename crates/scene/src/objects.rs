use std::collections::HashMap;
use std::ops::Range;
use std::sync::Arc;

/// The named objects of triangles: nodes of glTF files, objects and groups of OBJ files, parts of built-in scenes.
///
/// An object is known by its name: all triangles of one name are one object. Triangles come in runs of the same object, so this is
/// small beside the mesh.
#[derive(Clone, Debug, Default)]
pub struct Objects {
    names: Vec<Arc<str>>,
    number_of_name: HashMap<Arc<str>, u32>,
    /// The first triangle of each run, in rising order, and the run's object.
    runs: Vec<(u32, u32)>,
}

impl Objects {
    /// The name of the only object of a mesh that names none.
    pub const WHOLE: &str = "scene";

    /// Assigns the triangles from `first_triangle` on to the object `name`, up to the next call's. Calls come in the
    /// order of triangles.
    pub fn begin(&mut self, first_triangle: usize, name: &str) {
        let number = self.number_of_name.get(name).copied().unwrap_or_else(|| {
            let (name, number) = (Arc::<str>::from(name), self.names.len() as u32);
            self.names.push(Arc::clone(&name));
            self.number_of_name.insert(name, number);
            number
        });
        let first = first_triangle as u32;
        // The last run had no triangles.
        if self.runs.last().is_some_and(|&(last, _)| last == first) {
            self.runs.pop();
        }
        if self.runs.last().is_none_or(|&(_, last)| last != number) {
            self.runs.push((first, number));
        }
    }

    /// Whether the mesh names no object: all of it is then one object.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.runs.is_empty()
    }

    /// The names of the objects, in the order in which they came; no two are the same. Some may have no triangles.
    #[must_use]
    pub fn names(&self) -> &[Arc<str>] {
        &self.names
    }

    /// The object of a triangle, as an index into [`names`](Self::names); `None` for triangles before the first that has a
    /// name.
    #[must_use]
    pub fn of_triangle(&self, triangle: u32) -> Option<u32> {
        let run = self.runs.partition_point(|&(first, _)| first <= triangle).checked_sub(1)?;
        Some(self.runs[run].1)
    }

    /// The object that was begun last.
    #[must_use]
    pub fn last(&self) -> Option<u32> {
        self.runs.last().map(|&(_, object)| object)
    }

    /// The runs of a mesh with this number of triangles, each with its object.
    pub(crate) fn runs(&self, triangles: usize) -> impl Iterator<Item = (Range<usize>, Option<u32>)> {
        let begun = self.runs.iter().map(|&(first, object)| (first as usize, Some(object)));
        let ends = begun.clone().map(|(first, _)| first).chain(std::iter::once(triangles));
        let runs = std::iter::once((0, None)).chain(begun).zip(ends).map(|((first, object), end)| (first..end, object));
        runs.filter(|(run, _)| !run.is_empty())
    }

    /// The same objects with the same numbers, for other triangles.
    pub(crate) fn without_triangles(&self) -> Self {
        Self { runs: Vec::new(), ..self.clone() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn triangles_are_of_the_object_that_was_named_last() {
        let mut objects = Objects::default();
        assert!(objects.is_empty() && objects.of_triangle(0).is_none());
        for (first, name) in [(2, "a"), (3, "b"), (7, "empty"), (7, "a"), (9, "a"), (10, "b")] {
            objects.begin(first, name);
        }
        let names: Vec<&str> = objects.names().iter().map(|name| &**name).collect();
        assert_eq!(names, ["a", "b", "empty"]);
        let of: Vec<Option<u32>> = (0..12).map(|triangle| objects.of_triangle(triangle)).collect();
        let [none, a, b] = [None, Some(0), Some(1)];
        assert_eq!(of, [none, none, a, b, b, b, b, a, a, a, b, b]);
        let again = objects.without_triangles();
        assert!(again.is_empty() && again.names() == objects.names());
    }
}
