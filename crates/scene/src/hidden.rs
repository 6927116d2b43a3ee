//! Objects of a scene that aren't shown.

use std::sync::Arc;

use wildmatch::WildMatch;

use crate::Mesh;
use crate::derived::Derived;

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

#[cfg(test)]
mod tests {
    use crate::{Ground, OpenOptions, Scene};

    const ROOM: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n\
        o Floor\nf 1 2 4\nf 4 2 1\no Lamp.left\nf 1 2 3\no Lamp.right\nf 2 3 4\no Floor\nf 1 3 4\n";

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
        let room = Scene::from_bytes("room.obj", ROOM).unwrap();
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
        let room = Scene::from_bytes("room.obj", ROOM).unwrap();
        let refused = hiding(&room, &["Lamp*", "Roof"]).unwrap_err();
        assert!(refused.contains("`Roof`") && refused.contains("`Floor`, `Lamp.left`"), "{refused}");
        let options = OpenOptions { hidden: vec!["roof*".into()], ..OpenOptions::default() };
        let refused = Scene::from_files("a.obj", [("a.obj", ROOM)], &options).unwrap_err().to_string();
        assert!(refused.starts_with("a.obj: there is no object `roof*`"), "{refused}");
        let nameless = Scene::from_bytes("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
        assert!(hiding(&nameless, &["a"]).unwrap_err().contains("names none"));
    }
}
