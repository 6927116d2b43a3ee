use glam::Vec3;
use umbrage_rays::Triangles;

/// Tells whether triangles are the same as in the last call, so that nothing is rebuilt for them.
///
/// Of moving triangles only a sample is stored; all of them are, once the sample has stayed. So two builds are made for
/// triangles that don't move.
#[derive(Debug, Default)]
pub(crate) struct Kept {
    sample: Vec<Vec3>,
    count: [usize; 2],
    /// Empty where the sample has changed since the frame before.
    positions: Vec<Vec3>,
    indices: Vec<[u32; 3]>,
}

impl Kept {
    /// Number of sampled vertices, enough to notice most movements.
    const SAMPLE: usize = 1024;

    /// Whether they are the triangles of the last call. Otherwise the caller rebuilds for them.
    pub(crate) fn are_still(&mut self, triangles: Triangles<'_>) -> bool {
        let Triangles { positions, indices } = triangles;
        let count = [positions.len(), indices.len()];
        let step = positions.len().div_ceil(Self::SAMPLE).max(1);
        let sample = || positions.iter().step_by(step).copied();
        // NaN is never the same.
        if self.count != count || !sample().eq(self.sample.iter().copied()) {
            self.count = count;
            self.sample.clear();
            self.sample.extend(sample());
            self.positions.clear();
            self.indices.clear();
            return false;
        }
        if self.positions == positions && self.indices == indices {
            return true;
        }
        self.positions.clear();
        self.positions.extend_from_slice(positions);
        self.indices.clear();
        self.indices.extend_from_slice(indices);
        false
    }

    pub(crate) fn bytes(&self) -> usize {
        size_of_val(&self.positions[..]) + size_of_val(&self.indices[..])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whatever_moves_is_noticed() {
        let still: Vec<Vec3> = (0..5000).map(|number| Vec3::splat(number as f32)).collect();
        let indices: Vec<[u32; 3]> = (0..4998).map(|first| [first, first + 1, first + 2]).collect();
        let mut kept = Kept::default();
        let mut ask = |positions: &[Vec3], indices: &[[u32; 3]]| kept.are_still(Triangles { positions, indices });
        assert_eq!([0; 4].map(|_| ask(&still, &indices)), [false, false, true, true]);
        // In the sample, and beside it.
        for number in [0, 3] {
            let mut moved = still.clone();
            moved[number].x += 1e-3;
            assert!(!ask(&moved, &indices), "vertex {number}");
            assert!(!ask(&still, &indices));
            let _ = ask(&still, &indices);
            assert!(ask(&still, &indices));
        }
        let mut others = indices.clone();
        others[17].swap(0, 1);
        assert!(!ask(&still, &others) && !ask(&still, &others[1..]) && !ask(&still[1..], &others));
        let nowhere = [Vec3::NAN; 3];
        assert_eq!([0; 4].map(|_| ask(&nowhere, &[[0, 1, 2]])), [false; 4]);
        assert!(!ask(&[], &[]), "others than before");
    }
}
