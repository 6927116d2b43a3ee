use fearless_simd::dispatch;

use super::cells::Covered;
use super::face::VertexErrors;
use super::pass::LightPass;
use super::settle::Settler;
use super::small::Mapped;
use super::trace::Tester;
use super::worker::Worker;
use crate::LightSource;
use crate::predicate::settle;
use crate::shot::{SeenPixels, Shot};
use crate::simd::vectors::LANES;

/// Builds the cells of each face that `light` needs for what the pixels of `shot` have `seen`, and checks them. All
/// triangles are taken to be opaque.
///
/// It asks the predicate about every triangle and point, so it takes long for large images.
///
/// # Errors
/// Names the first point, cluster or triangle that breaks a rule. Every point is mapped to a face or known as an outlier.
/// On its face it is in a cluster of its block, which knows its bounds and its farthest point and is in the cells that
/// its bounds are in. No triangle that is nearer to the light than a cluster's farthest point is dropped there. Every
/// triangle that shadows a point finds the point's block.
///
/// # Panics
/// If `survey` wasn't called for `seen`.
pub(super) fn validate(
    pass: &mut LightPass,
    shot: &Shot<'_>,
    seen: &SeenPixels,
    light: &LightSource,
) -> Result<(), String> {
    let slots = seen.triangle.len();
    let mut found = vec![0_u16; slots / LANES];
    let (mut result, mut face) = (Ok(()), 0);
    let is_light = pass.visit_faces(shot, seen, light, |pass, settler| {
        if result.is_err() {
            return;
        }
        pass.sort_clusters();
        found.iter_mut().zip(&pass.members).for_each(|(found, members)| *found |= members);
        pass.project(shot.triangles.positions);
        let checked = pass.validate_face().and_then(|()| pass.validate_reach(settler));
        result = checked.map_err(|broken| format!("face {face}: {broken}"));
        face += 1;
    });
    result?;
    for &index in pass.outliers.iter().chain(&pass.survey.unknown) {
        found[index as usize / LANES] |= 1 << (index as usize % LANES);
    }
    let is_lost =
        |&index: &usize| seen.triangle[index] != SeenPixels::NONE && found[index / LANES] >> (index % LANES) & 1 == 0;
    match (0..slots).filter(|_| is_light).find(is_lost) {
        Some(index) => Err(format!("the point of pixel {index} is on no face")),
        None => Ok(()),
    }
}

impl LightPass {
    /// Checks that triangles find the points that they shadow on the face that is built.
    fn validate_reach(&self, settler: &Settler<'_>) -> Result<(), String> {
        let Self { face, cells, blocks, errors, members, vertices, .. } = self;
        let mapped = Mapped { face, vertex_errors: VertexErrors::new(face), cells, vertices };
        let tester = Tester { mapped, blocks, errors, settler };
        let points = members.iter().enumerate().flat_map(|(block, members)| {
            (0..LANES).filter(move |lane| members >> lane & 1 == 1).map(move |lane| block * LANES + lane)
        });
        let rays: Vec<_> = points
            .filter_map(|index| Some((index, settler.image.shot.shadow_ray(settler.image.seen, index, settler.light)?)))
            .collect();
        let mut worker = Worker::default();
        for id in 0..settler.image.shot.triangles.len() as u32 {
            let mut is_found = vec![false; blocks.len()];
            let found = |block: usize| is_found[block] = true;
            dispatch!(settler.level.0, simd => tester.visit_blocks(simd, &mut worker, id, found));
            let own = |index: usize| settler.image.seen.triangle[index];
            let mut missed = rays.iter().filter(|(index, _)| !is_found[index / LANES] && own(*index) != id);
            if let Some((index, _)) = missed.find(|(_, ray)| settle::is_blocked(settler.image.shot, ray, id)) {
                return Err(format!("triangle {id} shadows the point of pixel {index}, and isn't tested against it"));
            }
        }
        Ok(())
    }

    /// Checks the cells of the face that is built.
    fn validate_face(&self) -> Result<(), String> {
        let cells = &self.cells;
        let mut clustered = vec![0_u16; self.members.len()];
        for (number, row) in cells.rows().iter().enumerate() {
            for cluster in 0..row.len() {
                let (x, y) = (row.x.each_ref().map(|x| x[cluster]), row.y.each_ref().map(|y| y[cluster]));
                let name = format!("cluster {cluster} of row {number}");
                if !(cells.down.cell(y[0])..=cells.down.cell(y[1])).contains(&number) {
                    return Err(format!("{name} is not in it"));
                }
                for column in cells.across.cell(x[0])..=cells.across.cell(x[1]) {
                    if !row.reaching(column, column).contains(&cluster) {
                        return Err(format!("{name} is not found in column {column}"));
                    }
                    let covered = Covered { columns: [column as u16; 2], rows: [number as u16; 2] };
                    if cells.farthest(covered) > row.farthest[cluster] {
                        return Err(format!("triangles that {name} may be behind are dropped in column {column}"));
                    }
                }
                let block = row.block[cluster] as usize;
                let points = self.blocks.get(block).ok_or_else(|| format!("{name} has no block"))?;
                let error = self.errors[block];
                for lane in 0..LANES {
                    let inside =
                        |at: f32, [low, high]: [f32; 2]| low <= at - error.position && at + error.position <= high;
                    let is_inside = inside(points.x[lane], x)
                        && inside(points.y[lane], y)
                        && row.farthest[cluster] <= points.nearness[lane] - error.nearness;
                    clustered[block] |= u16::from(is_inside) << lane;
                }
            }
        }
        for (block, (members, clustered)) in self.members.iter().zip(&clustered).enumerate() {
            if members & !clustered != 0 {
                return Err(format!("points {:016b} of block {block} are in no cluster", members & !clustered));
            }
        }
        Ok(())
    }
}
