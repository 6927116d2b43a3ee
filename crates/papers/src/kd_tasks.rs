//! Simulated build times of a kd-tree on any number of threads, from counted work: a node's pass counts as its references.
//!
//! Passes are cut and wait for each other as in the tree's builders; a free thread takes the task that has
//! waited longest. The model leaves out costs of memory, caches and scheduling, and the work before and after the
//! nodes: boxes, the first sorting, the layout.

use std::cmp::Reverse;
use std::collections::{BinaryHeap, VecDeque};

use crate::{KdBuilder, KdTree};

/// A subtree of fewer references is one task, …
const SUBTREE: u64 = 1 << 12;
/// … and in the binned build so is one of less than this inverse share of all references.
const CLUSTERS: u64 = 32;
/// Nodes, and levels, of fewer references aren't shared in the builds of Choi et al. 2010.
const SHARED_FROM: u64 = 1 << 14;
/// References of a task in a shared pass.
const CHUNK: u64 = 1 << 13;
/// Levels of this many nodes aren't shared in the in-place build.
const LEVEL: usize = 16;

/// A graph of tasks with dependencies.
#[derive(Debug, Default)]
pub struct Tasks {
    work: Vec<u64>,
    /// Number of tasks before each, and the tasks after it.
    before: Vec<usize>,
    after: Vec<Vec<usize>>,
}

impl Tasks {
    /// Adds a task that waits for earlier ones; returns its index.
    pub fn add(&mut self, work: u64, before: &[usize]) -> usize {
        let index = self.work.len();
        self.work.push(work);
        self.before.push(before.len());
        self.after.push(Vec::new());
        before.iter().for_each(|&earlier| self.after[earlier].push(index));
        index
    }

    /// Adds work that threads share; returns the task that ends it.
    fn share(&mut self, work: u64, before: &[usize]) -> usize {
        let chunks = (0..work.div_ceil(CHUNK)).map(|chunk| CHUNK.min(work - chunk * CHUNK));
        let chunks: Vec<_> = chunks.map(|work| self.add(work, before)).collect();
        self.add(0, &chunks)
    }

    /// Sum of all work.
    #[must_use]
    pub fn total(&self) -> u64 {
        self.work.iter().sum()
    }

    /// Finishing time on `threads` threads, in the unit of work.
    #[must_use]
    pub fn simulated(&self, threads: usize) -> u64 {
        let mut before = self.before.clone();
        let mut ready: VecDeque<usize> = (0..before.len()).filter(|&task| before[task] == 0).collect();
        let mut running = BinaryHeap::new();
        let mut now = 0;
        loop {
            while running.len() < threads.max(1) {
                let Some(task) = ready.pop_front() else { break };
                running.push(Reverse((now + self.work[task], task)));
            }
            let Some(Reverse((end, task))) = running.pop() else { return now };
            now = end;
            for &next in &self.after[task] {
                before[next] -= 1;
                if before[next] == 0 {
                    ready.push_back(next);
                }
            }
        }
    }
}

/// The tasks of a builder for this tree.
#[must_use]
pub fn tasks(tree: &KdTree, builder: KdBuilder) -> Tasks {
    let mut passes = Passes { tree, of_node: vec![[0; 2]; tree.nodes().len()] };
    passes.count(0);
    let mut tasks = Tasks::default();
    match builder {
        KdBuilder::Binned => {
            let least = SUBTREE.max(passes.of_node[0][0] / CLUSTERS);
            passes.share_nodes(0, [least, u64::MAX], &[], &mut tasks);
        }
        KdBuilder::Nested => passes.share_nodes(0, [SHARED_FROM, SUBTREE], &[], &mut tasks),
        KdBuilder::InPlace => passes.share_levels(&mut tasks),
        _ => passes.share_nodes(0, [u64::MAX, SUBTREE], &[], &mut tasks),
    }
    tasks
}

struct Passes<'a> {
    tree: &'a KdTree,
    /// For each node: its references, and those of all nodes below it.
    of_node: Vec<[u64; 2]>,
}

impl Passes<'_> {
    fn children(&self, index: u32) -> Option<[u32; 2]> {
        let node = self.tree.nodes().get(index);
        (!node.is_leaf()).then(|| self.tree.nodes().children(index, node))
    }

    /// Counts references below a node, without clipped ones; returns the triangles there.
    fn count(&mut self, index: u32) -> Vec<u32> {
        let mut all = Vec::new();
        let mut below = 0;
        match self.children(index) {
            None => all.extend_from_slice(&self.tree.ids()[self.tree.nodes().get(index).ids()]),
            Some(children) => {
                for child in children {
                    all.append(&mut self.count(child));
                    below += self.of_node[child as usize][1];
                }
                // Two runs in order, which a stable sort merges.
                all.sort();
                all.dedup();
            }
        }
        let own = all.len() as u64;
        self.of_node[index as usize] = [own, own + below];
        all
    }

    /// Adds tasks: threads share nodes of at least `shared` references; other nodes of at least `alone` are a task
    /// each, and smaller subtrees one task.
    fn share_nodes(&self, index: u32, [shared, alone]: [u64; 2], before: &[usize], tasks: &mut Tasks) {
        let [own, all] = self.of_node[index as usize];
        match self.children(index) {
            Some(children) if own >= shared.min(alone) => {
                let end = if own >= shared { tasks.share(own, before) } else { tasks.add(own, before) };
                children.iter().for_each(|&child| self.share_nodes(child, [shared, alone], &[end], tasks));
            }
            _ => _ = tasks.add(all, before),
        }
    }

    fn share_levels(&self, tasks: &mut Tasks) {
        let mut level = vec![0];
        let mut before = Vec::new();
        let references = |level: &[u32]| level.iter().map(|&node| self.of_node[node as usize][0]).sum::<u64>();
        while !level.is_empty() && level.len() < LEVEL && references(&level) >= SHARED_FROM {
            before = vec![tasks.share(references(&level), &before)];
            level = level.iter().filter_map(|&node| self.children(node)).flatten().collect();
        }
        level.iter().for_each(|&node| self.share_nodes(node, [u64::MAX, SUBTREE], &before, tasks));
    }
}
