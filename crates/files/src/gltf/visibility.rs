//! `KHR_node_visibility` where an animation changes it: meshes without the triangles of hidden nodes.

use std::sync::{Arc, Mutex, PoisonError};

use umbrage_scene::Mesh;

use super::curve::Curve;
use super::nodes::Nodes;

/// The visibility of one node, over time.
#[derive(Debug)]
pub(super) struct Toggle {
    pub(super) node: u32,
    /// Zero where it is hidden.
    pub(super) curve: Curve,
}

/// Visibility over time, in a scene whose nodes come and go.
#[derive(Debug)]
pub(super) struct Visibility {
    toggles: Vec<Toggle>,
    /// Each node's own visibility at rest.
    own: Vec<bool>,
    parents: Vec<Option<u32>>,
    order: Vec<u32>,
    /// Nodes with their numbers of triangles, in the order of the whole mesh.
    triangles: Vec<(u32, usize)>,
    /// The node of each run of its points and lines.
    marks: Vec<u32>,
    whole: Arc<Mesh>,
    /// The last mesh that was made, and the nodes that it shows.
    last: Mutex<Option<(Vec<bool>, Arc<Mesh>)>>,
}

impl Visibility {
    pub(super) fn new(
        nodes: &Nodes,
        toggles: Vec<Toggle>,
        (triangles, marks): (Vec<(u32, usize)>, Vec<u32>),
        whole: &Arc<Mesh>,
    ) -> Self {
        Self {
            toggles,
            own: nodes.shows_itself.clone(),
            parents: nodes.parents.clone(),
            order: nodes.order.clone(),
            triangles,
            marks,
            whole: Arc::clone(whole),
            last: Mutex::new(None),
        }
    }

    /// Whether each node is visible, together with all of its ancestors.
    pub(super) fn at(&self, seconds: f64) -> Vec<bool> {
        let mut visible = self.own.clone();
        for toggle in &self.toggles {
            let mut value = [0.0];
            toggle.curve.sample(seconds, &mut value);
            visible[toggle.node as usize] = value != [0.0];
        }
        super::nodes::hide_below(&mut visible, &self.order, &self.parents);
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
