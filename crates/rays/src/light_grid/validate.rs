use fearless_simd::dispatch;

use super::cells::Covered;
use super::face::VertexErrors;
use super::settle::Judge;
use super::small::Mapped;
use super::trace::{Tester, Worker};
use super::{LightGrid, SeenImage, choose};
use crate::LightSource;
use crate::predicate::settle;
use crate::shot::{SeenPixels, Shot};
use crate::simd::vectors::LANES;

impl LightGrid {
    /// Builds the cells of each face that `light` needs for what the pixels of `shot` have `seen`, and checks them. All
    /// triangles are taken to be opaque.
    ///
    /// It asks the predicate about every triangle and point, so it takes long for large images.
    ///
    /// # Errors
    /// Names the first point, cluster or triangle that breaks a rule: every point is mapped to a face or known as an
    /// outlier; on its face it is in a cluster of its block, which knows its bounds and its farthest point, is in the
    /// cells that its bounds are in, and keeps no triangle that is nearer to the light than its farthest point from
    /// being tested; and every triangle that shadows a point finds the point's block.
    ///
    /// # Panics
    /// If `survey` wasn't called for `seen`.
    pub(crate) fn validate(&mut self, shot: &Shot<'_>, seen: &SeenPixels, light: &LightSource) -> Result<(), String> {
        let image = SeenImage { shot, seen };
        let places = image.seen.triangle.len();
        assert!(self.survey.places == places, "another image was surveyed");
        let mut faces = std::mem::take(&mut self.faces);
        let is_light = choose::choose(light, &self.survey.rays, &self.survey.tiles, &mut faces).is_some();
        let mut placed = vec![0_u16; places / LANES];
        self.outliers.clear();
        let mut result = Ok(());
        let judge = Judge { image, rays: self.survey.rays, light, level: self.level };
        for (number, face) in faces.iter().enumerate() {
            self.map_face(*face, &image);
            self.sort();
            placed.iter_mut().zip(&self.members).for_each(|(placed, members)| *placed |= members);
            self.project(shot.triangles.positions);
            let checked = self.validate_face().and_then(|()| self.validate_reach(&judge));
            result = checked.map_err(|broken| format!("face {number}: {broken}"));
            if result.is_err() {
                break;
            }
        }
        self.faces = faces;
        result?;
        for &place in self.outliers.iter().chain(&self.survey.unknown) {
            placed[place as usize / LANES] |= 1 << (place as usize % LANES);
        }
        let is_lost = |&place: &usize| {
            image.seen.triangle[place] != SeenPixels::NONE && placed[place / LANES] >> (place % LANES) & 1 == 0
        };
        match (0..places).filter(|_| is_light).find(is_lost) {
            Some(place) => Err(format!("the point at {place} is on no face")),
            None => Ok(()),
        }
    }

    /// Checks that triangles find the points that they shadow on the face that is built.
    fn validate_reach(&self, judge: &Judge<'_>) -> Result<(), String> {
        let Self { face, cells, blocks, errors, members, vertices, .. } = self;
        let mapped = Mapped { face, vertex_errors: VertexErrors::new(face), cells, vertices };
        let tester = Tester { mapped, blocks, errors, judge };
        let points = members.iter().enumerate().flat_map(|(block, members)| {
            (0..LANES).filter(move |lane| members >> lane & 1 == 1).map(move |lane| block * LANES + lane)
        });
        let rays: Vec<_> = points
            .filter_map(|place| Some((place, judge.image.shot.shadow_ray(judge.image.seen, place, judge.light)?)))
            .collect();
        let mut worker = Worker::default();
        for id in 0..judge.image.shot.triangles.len() as u32 {
            let mut is_found = vec![false; blocks.len()];
            let found = |block: usize| is_found[block] = true;
            dispatch!(judge.level.0, simd => tester.visit_blocks(simd, &mut worker, id, found));
            let own = |place: usize| judge.image.seen.triangle[place];
            let mut missed = rays.iter().filter(|(place, _)| !is_found[place / LANES] && own(*place) != id);
            if let Some((place, _)) = missed.find(|(_, ray)| settle::is_blocked(judge.image.shot, ray, id)) {
                return Err(format!("triangle {id} shadows the point at {place}, and isn't tested against it"));
            }
        }
        Ok(())
    }

    /// Checks the cells of the face that is built.
    fn validate_face(&self) -> Result<(), String> {
        let cells = &self.cells;
        let mut clustered = vec![0_u16; self.members.len()];
        for (place, row) in cells.rows().iter().enumerate() {
            for cluster in 0..row.len() {
                let (x, y) = (row.x.each_ref().map(|x| x[cluster]), row.y.each_ref().map(|y| y[cluster]));
                let name = format!("cluster {cluster} of row {place}");
                if !(cells.down.cell(y[0])..=cells.down.cell(y[1])).contains(&place) {
                    return Err(format!("{name} is not in it"));
                }
                for column in cells.across.cell(x[0])..=cells.across.cell(x[1]) {
                    if !row.reaching(column, column).contains(&cluster) {
                        return Err(format!("{name} is not found in column {column}"));
                    }
                    let covered = Covered { columns: [column as u16; 2], rows: [place as u16; 2] };
                    if cells.farthest(covered) > row.farthest[cluster] {
                        return Err(format!("triangles that {name} may be behind are dropped in column {column}"));
                    }
                }
                let block = row.block[cluster] as usize;
                let points = self.blocks.get(block).ok_or_else(|| format!("{name} has no block"))?;
                let error = self.errors[block];
                for lane in 0..LANES {
                    let inside = |at: f32, [low, high]: [f32; 2]| low <= at - error.place && at + error.place <= high;
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
