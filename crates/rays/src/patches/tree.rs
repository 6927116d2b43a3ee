use super::{Patches, SixteenBoxes};
use crate::simd::lanes::LANES;

/// A tree of boxes over the patches' boxes, sixteen to a node. Scans and nearest points walk it.
///
/// Level 0 are the boxes of the patches themselves. A box of level n is around the sixteen boxes of a node of level n − 1.
#[derive(Debug, Default)]
pub(crate) struct BoxTree {
    /// The boxes of each level above the patches.
    levels: Vec<Vec<SixteenBoxes>>,
    /// The largest magnitude of a finite coordinate.
    pub(crate) reach: f32,
}

/// The box of patches with NaN coordinates: all of space.
const EVERYWHERE: [[f32; 3]; 2] = [[f32::NEG_INFINITY; 3], [f32::INFINITY; 3]];

impl BoxTree {
    /// Makes the tree anew for the patches' present bounds.
    pub(crate) fn find(&mut self, patches: &Patches) {
        let Self { levels, reach } = self;
        let mut level = 0;
        let mut boxes = patches.bounds.sixteens.len();
        while boxes > 1 {
            if levels.len() == level {
                levels.push(Vec::new());
            }
            let (below, above) = levels.split_at_mut(level);
            let below = below.last().unwrap_or(&patches.bounds.sixteens);
            above[0].clear();
            above[0].extend(below.chunks(LANES).map(|sixteens| {
                let mut sixteen = SixteenBoxes::EMPTY;
                for (lane, boxes) in sixteens.iter().enumerate() {
                    sixteen.set(lane, all_of(boxes));
                }
                sixteen
            }));
            boxes = above[0].len();
            level += 1;
        }
        levels.truncate(level);
        *reach = 0.0;
        for boxes in &patches.bounds.sixteens {
            for lane in 0..LANES {
                let [low, high] = boxes.get(lane);
                for axis in [0, 1, 2] {
                    if low[axis].is_finite() && high[axis].is_finite() {
                        *reach = reach.max(low[axis].abs()).max(high[axis].abs());
                    }
                }
            }
        }
    }

    /// The level of the root, a single node.
    pub(crate) fn top(&self) -> usize {
        self.levels.len()
    }

    /// A node by its level and number: sixteen boxes, and how many of them exist.
    #[inline(always)]
    pub(crate) fn node<'a>(&'a self, patches: &'a Patches, level: usize, number: usize) -> (&'a SixteenBoxes, usize) {
        let nodes = if level == 0 { &patches.bounds.sixteens } else { &self.levels[level - 1] };
        let boxes = match level {
            0 => patches.len(),
            1 => patches.bounds.sixteens.len(),
            _ => self.levels[level - 2].len(),
        };
        (&nodes[number], (boxes - number * LANES).min(LANES))
    }

    pub(crate) fn bytes(&self) -> usize {
        self.levels.iter().map(|level| level.capacity() * size_of::<SixteenBoxes>()).sum()
    }
}

/// The box around sixteen boxes.
fn all_of(boxes: &SixteenBoxes) -> [[f32; 3]; 2] {
    let mut all = [[f32::INFINITY; 3], [f32::NEG_INFINITY; 3]];
    for lane in 0..LANES {
        let [low, high] = boxes.get(lane);
        for axis in [0, 1, 2] {
            if low[axis].is_nan() || high[axis].is_nan() {
                return EVERYWHERE;
            }
            all[0][axis] = all[0][axis].min(low[axis]);
            all[1][axis] = all[1][axis].max(high[axis]);
        }
    }
    all
}
