//! `KHR_node_visibility` where an animation changes it: meshes without the triangles of hidden nodes.

use std::sync::{Arc, Mutex, PoisonError};

use umbrage_scene::Mesh;

use super::moved::{Moved, Target};
use super::nodes::{Nodes, hide_below};

/// Visibility over time, in a scene whose nodes come and go.
#[derive(Debug)]
pub(super) struct Visibility {
    nodes: Nodes,
    /// Nodes with their numbers of triangles, in the order of the whole mesh.
    triangles: Vec<(u32, usize)>,
    /// The node of each run of its points and lines.
    marks: Vec<u32>,
    whole: Arc<Mesh>,
    /// The last mesh that was made, and the nodes that it shows.
    last: Mutex<Option<(Vec<bool>, Arc<Mesh>)>>,
}

impl Visibility {
    pub(super) fn new(nodes: Nodes, (triangles, marks): (Vec<(u32, usize)>, Vec<u32>), whole: &Arc<Mesh>) -> Self {
        Self { nodes, triangles, marks, whole: Arc::clone(whole), last: Mutex::new(None) }
    }

    /// Whether each node is visible, together with all of its ancestors.
    pub(super) fn at(&self, seconds: f64, moved: &[Moved]) -> Vec<bool> {
        let mut visible = self.nodes.shows_itself.clone();
        for moved in moved {
            if let Target::Visibility(node) = moved.target {
                let mut value = [0.0];
                moved.curve.sample(seconds, &mut value);
                visible[node] = value != [0.0];
            }
        }
        hide_below(&mut visible, &self.nodes.order, &self.nodes.parents);
        visible
    }

    /// The mesh of the visible nodes; the same one as long as these stay the same.
    pub(super) fn mesh(&self, visible: &[bool]) -> Arc<Mesh> {
        if self.triangles.iter().all(|&(node, _)| visible[node as usize]) {
            return Arc::clone(&self.whole);
        }
        let mut last = self.last.lock().unwrap_or_else(PoisonError::into_inner);
        match &*last {
            Some((shown, mesh)) if shown == visible => Arc::clone(mesh),
            _ => {
                let mesh = Arc::new(self.without_hidden(visible));
                *last = Some((visible.to_vec(), Arc::clone(&mesh)));
                mesh
            }
        }
    }

    fn without_hidden(&self, visible: &[bool]) -> Mesh {
        let mut first = 0;
        let runs = self.triangles.iter().map(|&(node, count)| {
            let run = first..first + count;
            first = run.end;
            (node, run)
        });
        let shown = runs.filter(|&(node, _)| visible[node as usize]).map(|(_, run)| run);
        self.whole.with_only(shown, |number, _| visible[self.marks[number] as usize])
    }
}
