//! Objects of a scene that aren't shown.

use std::sync::{Arc, Mutex, PoisonError};

use wildmatch::WildMatch;

use crate::Mesh;

/// The hidden objects of a scene, which are invisible and cast no shadows.
#[derive(Debug)]
pub(crate) struct Hidden {
    names: Vec<String>,
    mesh: Derived<Mesh>,
}

impl Hidden {
    /// The objects with some names, in which `*` stands for any characters and `?` for any one.
    ///
    /// # Errors
    /// The first name that none of these objects has.
    pub(crate) fn new<'n>(names: &'n [String], objects: &[Arc<str>]) -> Result<Self, &'n str> {
        match names.iter().find(|name| !objects.iter().any(|object| is_meant(name, object))) {
            Some(unknown) => Err(unknown),
            None => Ok(Self { names: names.to_vec(), mesh: Derived::default() }),
        }
    }

    /// Whether an object is hidden.
    pub(crate) fn has(&self, object: &str) -> bool {
        self.names.iter().any(|name| is_meant(name, object))
    }

    /// Removes their triangles from a mesh.
    pub(crate) fn take_out(&self, mesh: &mut Arc<Mesh>) {
        if mesh.objects.names().iter().any(|name| self.has(name)) {
            *mesh = self.mesh.of(mesh, |mesh| {
                let are_hidden: Vec<bool> = mesh.objects.names().iter().map(|name| self.has(name)).collect();
                let runs = mesh.objects.runs(mesh.triangles.len());
                let shown = runs.filter(|(_, object)| object.is_none_or(|object| !are_hidden[object as usize]));
                mesh.with_only(shown.map(|(run, _)| run), |_, object| {
                    object.is_none_or(|object| !are_hidden[object as usize])
                })
            });
        }
    }
}

/// Whether a name or a pattern matches an object.
fn is_meant(name: &str, object: &str) -> bool {
    name == object || name.contains(['*', '?']) && WildMatch::new(name).matches(object)
}

/// The last value derived from an input that usually stays the same.
#[derive(Debug)]
pub(crate) struct Derived<T>(Mutex<Option<Made<T>>>);

#[derive(Debug)]
struct Made<T> {
    /// Kept alive, so that no other input gets its address.
    from: Arc<T>,
    to: Arc<T>,
}

impl<T> Derived<T> {
    /// Returns `make(from)`, which is computed again only when `from` is another allocation than last time.
    pub(crate) fn of(&self, from: &Arc<T>, make: impl FnOnce(&T) -> T) -> Arc<T> {
        let mut last = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        match &*last {
            Some(last) if Arc::ptr_eq(&last.from, from) => Arc::clone(&last.to),
            _ => {
                let to = Arc::new(make(from));
                *last = Some(Made { from: Arc::clone(from), to: Arc::clone(&to) });
                to
            }
        }
    }
}

impl<T> Default for Derived<T> {
    fn default() -> Self {
        Self(Mutex::new(None))
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::Vec3;

    use crate::{Frame, Ground, Scene};

    /// Triangles whose objects have these names.
    fn scene(names: &[&str]) -> Scene {
        let corners = vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z];
        let triangles = [[0, 1, 3], [3, 1, 0], [0, 1, 2], [1, 2, 3], [0, 2, 3]];
        let mut frame = Frame::from_triangles(corners, triangles.to_vec());
        let objects = &mut Arc::make_mut(&mut frame.mesh).objects;
        names.iter().enumerate().for_each(|(triangle, name)| objects.begin(triangle, name));
        Scene::new(Box::new(frame)).unwrap()
    }

    const ROOM: [&str; 5] = ["Floor", "Floor", "Lamp.left", "Lamp.right", "Floor"];

    fn triangles(scene: &Scene) -> Vec<[u32; 3]> {
        let frame = scene.at(0.0).unwrap();
        assert_eq!(frame.mesh.triangles.len(), frame.mesh.material_of_triangle.len());
        frame.mesh.triangles.clone()
    }

    fn hiding(scene: &Scene, names: &[&str]) -> Result<Scene, String> {
        scene.hiding(&names.iter().map(ToString::to_string).collect::<Vec<_>>())
    }

    #[test]
    fn objects_are_hidden_by_name() {
        let room = scene(&ROOM);
        assert_eq!(room.objects().iter().map(|name| &**name).collect::<Vec<_>>(), ["Floor", "Lamp.left", "Lamp.right"]);
        let all = triangles(&room);
        assert_eq!(all.len(), 5);
        for (names, shown) in [
            (&["Floor"][..], &[2, 3][..]),
            (&["Lamp*"], &[0, 1, 4]),
            (&["Lamp.left", "*r"], &[3]),
            (&["Lamp.?ight"], &[0, 1, 2, 4]),
            (&["*"], &[]),
            (&[], &[0, 1, 2, 3, 4]),
        ] {
            let scene = hiding(&room, names).unwrap();
            assert_eq!(scene.objects(), room.objects());
            assert_eq!(scene.is_hidden("Floor"), !shown.contains(&0));
            assert_eq!(triangles(&scene), shown.iter().map(|&triangle: &usize| all[triangle]).collect::<Vec<_>>());
            // Also from a scene with hidden objects.
            assert_eq!(triangles(&hiding(&scene, &[]).unwrap()), all);
        }
        let mut without_floor = hiding(&room, &["Floor"]).unwrap();
        let objects = &without_floor.at(0.0).unwrap().mesh.objects;
        assert_eq!([0, 1].map(|triangle| objects.of_triangle(triangle)), [Some(1), Some(2)], "they keep their numbers");
        without_floor.set_ground(Some(Ground::default()));
        assert_eq!(triangles(&without_floor).len(), 4, "a ground is there whatever is hidden");
        assert_eq!(triangles(&hiding(&without_floor, &["Lamp*"]).unwrap()).len(), 5, "and stays");
    }

    #[test]
    fn names_that_nothing_has_are_refused() {
        let room = scene(&ROOM);
        let refused = hiding(&room, &["Lamp*", "Roof"]).unwrap_err();
        assert!(refused.contains("`Roof`") && refused.contains("`Floor`, `Lamp.left`"), "{refused}");
        let nameless = scene(&[]);
        assert!(hiding(&nameless, &["a"]).unwrap_err().contains("names none"));
    }
}
