use glam::{DVec3, Vec3};

use super::extent::{Extent, Plane};
use super::node::Nodes;
use super::{KdTree, KdTreeCounts};
use umbrage_rays::Triangles;

impl KdTree {
    /// Checks the tree against the triangles that it was built over.
    ///
    /// # Errors
    /// Names the first node or triangle that breaks a rule: planes go through their node's cell; every node but the root has
    /// one parent, and leaves share no ids; ids ascend in each leaf, and belong to triangles whose box touches the leaf's
    /// cell; leaves that list a triangle cover it; and there are no more references, and no more leaves, than the limit.
    pub fn check(&self, triangles: Triangles<'_>) -> Result<(), String> {
        if self.nodes.len() == 0 {
            return Err("the tree wasn't built".to_owned());
        }
        if triangles.len() != self.triangle_count {
            return Err(format!("built over {} triangles, not {}", self.triangle_count, triangles.len()));
        }
        self.validate_nodes(triangles, 0)?;
        let limit = Self::MOST_REFERENCES * triangles.len() as u64 + Self::LEAST_LIMIT;
        let KdTreeCounts { references, leaves, .. } = self.counts();
        if references > limit || leaves > limit {
            return Err(format!("{references} references in {leaves} leaves are more than {limit}"));
        }
        for id in 0..triangles.len() as u32 {
            if let Ok(corners) = triangles.usable_corners(id) {
                let polygon = corners.map(Vec3::as_dvec3).to_vec();
                if !self.covers(0, id, &polygon) {
                    return Err(format!("triangle {id} is missing in a leaf that it overlaps"));
                }
            }
        }
        Ok(())
    }

    /// Checks the nodes of a tree, or of a subtree with `depth` nodes above its root.
    fn validate_nodes(&self, triangles: Triangles<'_>, depth: usize) -> Result<(), String> {
        let mut visited = Visited { nodes: vec![false; self.nodes.len()], ids: 0 };
        self.validate_below(triangles, 0, self.extent, depth, &mut visited)?;
        let (held, all) = (visited.ids, self.ids.len());
        if held == all { Ok(()) } else { Err(format!("leaves hold {held} ids of {all}")) }
    }

    fn validate_below(
        &self,
        triangles: Triangles<'_>,
        index: u32,
        cell: Extent,
        depth: usize,
        visited: &mut Visited,
    ) -> Result<(), String> {
        if depth > Nodes::MAX_DEPTH {
            return Err(format!("node {index} is too deep"));
        }
        match visited.nodes.get_mut(index as usize) {
            Some(visited) if !*visited => *visited = true,
            Some(_) => return Err(format!("node {index} has two parents")),
            None => return Err(format!("node {index} is out of range")),
        }
        let node = self.nodes.get(index);
        if !node.is_leaf() {
            let plane = node.plane();
            if !(cell.min[plane.axis] <= plane.at && plane.at <= cell.max[plane.axis]) {
                return Err(format!("the plane of node {index} is outside of its cell"));
            }
            for (child, cell) in self.nodes.children(index, node).into_iter().zip(cell.cut(plane)) {
                self.validate_below(triangles, child, cell, depth + 1, visited)?;
            }
            return Ok(());
        }
        let ids = self.ids.get(node.ids()).ok_or_else(|| format!("ids of leaf {index} are out of range"))?;
        visited.ids += ids.len();
        if node.is_deferred() {
            let start = node.ids().start;
            if !self.deferred.references(start).iter().map(|reference| reference.id).eq(ids.iter().copied()) {
                return Err(format!("what is deferred in leaf {index} isn't what it lists"));
            }
            if let Some(subtree) = self.deferred.get(start) {
                if subtree.extent != cell {
                    return Err(format!("the subtree of leaf {index} is another cell's"));
                }
                subtree.validate_nodes(triangles, depth).map_err(|broken| format!("below leaf {index}: {broken}"))?;
            }
        }
        if !ids.is_sorted_by(|a, b| a < b) {
            return Err(format!("ids of leaf {index} don't ascend"));
        }
        for &id in ids {
            let usable = triangles.indices.get(id as usize).and_then(|_| triangles.usable_corners(id).ok());
            let corners = usable.ok_or_else(|| format!("leaf {index} lists {id}, which can't be hit"))?;
            let extent = Extent::around(corners);
            if !(0..3).all(|axis| extent.min[axis] <= cell.max[axis] && cell.min[axis] <= extent.max[axis]) {
                return Err(format!("triangle {id} is in leaf {index}, away from its box"));
            }
        }
        Ok(())
    }

    /// Whether the leaves below a node that list a triangle cover this part of it, except for slivers from rounding.
    fn covers(&self, index: u32, id: u32, polygon: &[DVec3]) -> bool {
        let node = self.nodes.get(index);
        if node.is_leaf() {
            if node.is_deferred()
                && let Some(subtree) = self.deferred.get(node.ids().start)
            {
                return subtree.covers(0, id, polygon);
            }
            return self.ids[node.ids()].binary_search(&id).is_ok();
        }
        let plane = node.plane();
        let [left, right] = self.nodes.children(index, node);
        let at = f64::from(plane.at);
        let along = |point: &DVec3| point[plane.axis];
        let (low, high) = polygon.iter().map(along).fold((f64::MAX, f64::MIN), |(a, b), c| (a.min(c), b.max(c)));
        // Crossings of edges have errors of a few roundings of the coordinates.
        let slack = (low.abs().max(high.abs())) * SLACK;
        if (low - at).abs() <= slack && (high - at).abs() <= slack {
            return self.covers(left, id, polygon) || self.covers(right, id, polygon);
        }
        (low >= at - slack || self.covers(left, id, &part(polygon, plane, 1.0)))
            && (high <= at + slack || self.covers(right, id, &part(polygon, plane, -1.0)))
    }
}

const SLACK: f64 = 1.0 / (1_u64 << 44) as f64;

struct Visited {
    nodes: Vec<bool>,
    ids: usize,
}

/// The part of a polygon below a plane, or with a `side` of −1 above it (Sutherland and Hodgman 1974).
pub(super) fn part(polygon: &[DVec3], plane: Plane, side: f64) -> Vec<DVec3> {
    let at = f64::from(plane.at);
    let above = |point: DVec3| (point[plane.axis] - at) * side;
    let mut part = Vec::with_capacity(polygon.len() + 1);
    for (index, &from) in polygon.iter().enumerate() {
        let to = polygon[(index + 1) % polygon.len()];
        let (start, end) = (above(from), above(to));
        if start <= 0.0 {
            part.push(from);
        }
        if (start < 0.0 && end > 0.0) || (start > 0.0 && end < 0.0) {
            let mut crossing = from + (to - from) * (start / (start - end));
            crossing[plane.axis] = at;
            part.push(crossing);
        }
    }
    part
}
