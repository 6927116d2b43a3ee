//! Triangles that move nearly together over an animation: the motion decomposition of fuzzy kd-trees (Günther et al.,
//! *Ray Tracing Animated Scenes using Motion Decomposition*, 2006; thesis §4.2).
//!
//! It is generalised Lloyd relaxation: each cluster has for each pose the affine map that best takes it back to the
//! first pose. Each triangle goes to the cluster whose maps leave it the smallest distance from its first position, its
//! *residual motion*; this repeats until no triangle changes its cluster. Then the triangle with the largest residual
//! motion becomes a new cluster, with its neighbours.
//!
//! In the paper a cluster's map is that of its triangle of least residual motion, and the rest pose the best of all; here
//! maps are least squares over the cluster's vertices, and the rest pose is the first.

use crate::kdtree::fit;
use glam::{DAffine3, DVec3, Vec3};
use rayon::prelude::*;

/// Limits of the search.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClusterOptions {
    /// Maximum number of clusters.
    pub most: u32,
    /// Maximum number of relaxation rounds for each number of clusters.
    pub rounds: u32,
    /// Relative residual motion, in units of the first pose's size: below it no cluster is added.
    pub residual: f64,
}

impl Default for ClusterOptions {
    fn default() -> Self {
        Self { most: 32, rounds: 6, residual: 1.0 / 256.0 }
    }
}

/// The cluster of each triangle, given its vertices in at least one pose; numbers of clusters have no gaps. Ignores
/// vertices that aren't finite in all poses.
///
/// # Panics
/// If a triangle has a vertex that a pose lacks.
#[must_use]
pub fn clusters(indices: &[[u32; 3]], poses: &[Vec<Vec3>], options: ClusterOptions) -> Vec<u32> {
    let mut all = Clusters::new(indices, poses);
    let enough = all.size * options.residual;
    loop {
        for _ in 0..options.rounds {
            if !all.relax() {
                break;
            }
        }
        let (worst, residual) = all.worst();
        if residual.sqrt() <= enough || all.maps.len() >= options.most as usize || !all.add(worst) {
            return all.numbered();
        }
    }
}

/// Maps back to the first pose, one for each other pose.
type Maps = Vec<DAffine3>;

struct Clusters<'a> {
    indices: &'a [[u32; 3]],
    poses: &'a [Vec<Vec3>],
    /// For each vertex, the triangles around it: the start of each vertex's list, and all lists.
    around: (Vec<u32>, Vec<u32>),
    /// Maps of each cluster; empty if its triangles have no fit.
    maps: Vec<Maps>,
    of_triangle: Vec<u32>,
    /// Squared residual motion of each triangle.
    residual_of_triangle: Vec<f64>,
    /// Size of the first pose.
    size: f64,
}

impl<'a> Clusters<'a> {
    fn new(indices: &'a [[u32; 3]], poses: &'a [Vec<Vec3>]) -> Self {
        let rest = &poses[0];
        let finite = indices.as_flattened().iter().map(|&vertex| rest[vertex as usize]).filter(|at| at.is_finite());
        let (low, high) =
            finite.fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), at| (low.min(at), high.max(at)));
        let mut firsts = vec![0; rest.len() + 1];
        indices.as_flattened().iter().for_each(|&vertex| firsts[vertex as usize + 1] += 1);
        for vertex in 0..rest.len() {
            firsts[vertex + 1] += firsts[vertex];
        }
        let mut next = firsts.clone();
        let mut around = vec![0; 3 * indices.len()];
        for (id, corners) in (0..).zip(indices) {
            for &vertex in corners {
                around[next[vertex as usize] as usize] = id;
                next[vertex as usize] += 1;
            }
        }
        let of_triangle = vec![0; indices.len()];
        let residual_of_triangle = vec![0.0; indices.len()];
        let (size, around) = (f64::from((high - low).max_element()).max(0.0), (firsts, around));
        let mut all = Self { indices, poses, around, maps: Vec::new(), of_triangle, residual_of_triangle, size };
        all.maps.push(all.fitted(0..indices.len() as u32).unwrap_or_default());
        all
    }

    fn around(&self, vertex: u32) -> &[u32] {
        let (firsts, around) = &self.around;
        &around[firsts[vertex as usize] as usize..firsts[vertex as usize + 1] as usize]
    }

    /// The best maps of some triangles; a vertex counts once for each of its triangles.
    fn fitted(&self, triangles: impl Iterator<Item = u32>) -> Option<Maps> {
        let is_finite = |vertex: u32| self.poses.iter().all(|pose| pose[vertex as usize].is_finite());
        let vertices = triangles.flat_map(|id| self.indices[id as usize]).filter(|&vertex| is_finite(vertex));
        let vertices: Vec<u32> = vertices.collect();
        let map = |pose: &Vec<Vec3>| {
            let pair = |&vertex: &u32| [pose, &self.poses[0]].map(|pose| pose[vertex as usize].as_dvec3());
            fit(&vertices.iter().map(pair).collect::<Vec<[DVec3; 2]>>())
        };
        self.poses[1..].par_iter().map(map).collect()
    }

    /// Squared residual motion of a triangle by the maps of a cluster: the largest of its corners'.
    fn residual(&self, id: u32, maps: &Maps) -> f64 {
        let mut most: f64 = 0.0;
        for vertex in self.indices[id as usize] {
            let rest = self.poses[0][vertex as usize].as_dvec3();
            for (map, pose) in maps.iter().zip(&self.poses[1..]) {
                let residual = map.transform_point3(pose[vertex as usize].as_dvec3()).distance_squared(rest);
                most = if residual.is_finite() { most.max(residual) } else { most };
            }
        }
        most
    }

    /// Moves each triangle to its best cluster, and fits each cluster to its triangles; returns whether any triangle moved.
    fn relax(&mut self) -> bool {
        let best = |id: u32| {
            let of_clusters = (0..).zip(&self.maps).map(|(cluster, maps)| (self.residual(id, maps), cluster));
            of_clusters.min_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or((0.0, 0))
        };
        let found: Vec<(f64, u32)> = (0..self.indices.len() as u32).into_par_iter().map(best).collect();
        let has_changed = found.iter().zip(&self.of_triangle).any(|((_, new), old)| new != old);
        for (id, (residual, cluster)) in found.into_iter().enumerate() {
            (self.residual_of_triangle[id], self.of_triangle[id]) = (residual, cluster);
        }
        for cluster in 0..self.maps.len() as u32 {
            let own = (0..self.indices.len() as u32).filter(|&id| self.of_triangle[id as usize] == cluster);
            if let Some(maps) = self.fitted(own) {
                self.maps[cluster as usize] = maps;
            }
        }
        has_changed
    }

    /// The triangle with the largest residual motion, and that motion squared.
    fn worst(&self) -> (u32, f64) {
        let all = (0..).zip(self.residual_of_triangle.iter().copied());
        all.max_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((0, 0.0))
    }

    /// Adds a cluster of a triangle and its neighbours; returns `false` if these have no fit.
    fn add(&mut self, seed: u32) -> bool {
        let near = self.indices[seed as usize].into_iter().flat_map(|vertex| self.around(vertex).iter().copied());
        let Some(maps) = self.fitted(near) else { return false };
        self.maps.push(maps);
        true
    }

    /// The clusters of triangles, renumbered without empty ones.
    fn numbered(self) -> Vec<u32> {
        let mut numbers = vec![u32::MAX; self.maps.len()];
        let mut next = 0;
        let number = |cluster: u32| {
            let number = &mut numbers[cluster as usize];
            if *number == u32::MAX {
                *number = next;
                next += 1;
            }
            *number
        };
        self.of_triangle.into_iter().map(number).collect()
    }
}
