use super::{MOST_TRIANGLES, MOST_VERTICES, Patches};
use crate::Triangles;
use crate::simd::lanes::LANES;

impl Patches {
    /// Checks that each triangle whose corners exist is in one patch, with its own corners, that patches are within their
    /// limits, and that their boxes hold their vertices.
    ///
    /// # Errors
    /// Describes the first fault.
    pub(crate) fn validate(&self, triangles: Triangles<'_>) -> Result<(), String> {
        let mut seen = vec![0; triangles.len()];
        for &id in &self.in_none {
            if triangles.has_all_corners(id) {
                return Err(format!("triangle {id} is in no patch"));
            }
            seen[id as usize] += 1;
        }
        for number in 0..self.len() {
            self.check_patch(number, triangles, &mut seen).map_err(|what| format!("patch {number}: {what}"))?;
        }
        match seen.iter().position(|&count| count != 1) {
            Some(id) => Err(format!("triangle {id} is in {} patches", seen[id])),
            None if self.triangles != triangles.len() => Err(format!("{} triangles", self.triangles)),
            None => Ok(()),
        }
    }

    fn check_patch(&self, number: usize, triangles: Triangles<'_>, seen: &mut [u32]) -> Result<(), String> {
        let patch = self.get(number);
        let lengths = [patch.vertices.len(), patch.ids.len()];
        if lengths.iter().any(|length| length % LANES != 0) || patch.ids.len() != patch.count.next_multiple_of(LANES) {
            return Err(format!("lengths {lengths:?} of {} triangles", patch.count));
        }
        if patch.count == 0 || patch.count > MOST_TRIANGLES || patch.vertices.len() > MOST_VERTICES {
            return Err(format!("{} triangles, {} vertices", patch.count, patch.vertices.len()));
        }
        if patch.ids[patch.count..].iter().any(|&id| id != Self::NONE) {
            return Err("padded with triangles".to_owned());
        }
        for (&id, &[a, b, c, _]) in patch.ids[..patch.count].iter().zip(patch.corners) {
            let corners = [a, b, c].map(|corner| patch.vertices.get(usize::from(corner)).copied());
            if triangles.indices.get(id as usize).map(|&corners| corners.map(Some)) != Some(corners) {
                return Err(format!("triangle {id} has corners {corners:?}"));
            }
            seen[id as usize] += 1;
        }
        let Some(boxes) = self.bounds.sixteens.get(number / LANES) else { return Err("no box".to_owned()) };
        let positions = || patch.vertices.iter().map(|&vertex| triangles.positions[vertex as usize]);
        let is_finite = positions().all(glam::Vec3::is_finite);
        for axis in 0..3 {
            let (low, high) = (boxes.low[axis][number % LANES], boxes.high[axis][number % LANES]);
            let (least, most) = positions()
                .map(|position| position[axis])
                .fold((f32::INFINITY, f32::NEG_INFINITY), |(least, most), coordinate| {
                    (least.min(coordinate), most.max(coordinate))
                });
            let is_right = if is_finite { (low, high) == (least, most) } else { low.is_nan() && high.is_nan() };
            if !is_right {
                return Err(format!("from {low} to {high} on axis {axis}"));
            }
        }
        Ok(())
    }
}
