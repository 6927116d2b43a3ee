use glam::Vec4;

/// A triangle during the build: its box, scaled.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Item {
    /// The box's lowest corner, and in w the bits of the triangle's id, which no arithmetic uses.
    low: Vec4,
    /// The box's highest corner.
    high: Vec4,
}

impl Item {
    pub(super) fn new(bounds: Extent, id: u32) -> Self {
        Self { low: bounds.low.with_w(f32::from_bits(id)), high: bounds.high.with_w(0.0) }
    }

    pub(super) fn id(&self) -> u32 {
        self.low.w.to_bits()
    }

    pub(super) fn extent(&self) -> Extent {
        Extent { low: self.low, high: self.high }
    }

    /// Twice the middle of the box.
    #[inline(always)]
    pub(super) fn middle(&self) -> Vec4 {
        self.low + self.high
    }
}

/// A box; the fourth component means nothing.
#[derive(Clone, Copy, Debug)]
pub(super) struct Extent {
    pub(super) low: Vec4,
    pub(super) high: Vec4,
}

impl Extent {
    pub(super) const EMPTY: Self = Self { low: Vec4::INFINITY, high: Vec4::NEG_INFINITY };

    #[inline(always)]
    pub(super) fn union(self, other: Self) -> Self {
        Self { low: self.low.min(other.low), high: self.high.max(other.high) }
    }

    #[inline(always)]
    fn with(self, point: Vec4) -> Self {
        Self { low: self.low.min(point), high: self.high.max(point) }
    }

    /// Half of the box's surface.
    #[inline(always)]
    pub(super) fn area(&self) -> f32 {
        let size = self.high - self.low;
        size.x * (size.y + size.z) + size.y * size.z
    }
}

/// The bounds of the doubled middles of some items' boxes.
pub(super) fn middles(items: &[Item]) -> Extent {
    items.iter().fold(Extent::EMPTY, |extent, item| extent.with(item.middle()))
}

/// The mapping of middles to bins, on each axis.
#[derive(Clone, Copy, Debug, Default)]
struct Steps {
    first: Vec4,
    scale: Vec4,
    count: usize,
}

const MOST_BINS: usize = 16;

/// The lowest bits of a sum with it are the other number, rounded: faster than a conversion.
const TO_BITS: f32 = (1 << 23) as f32;
/// Subtracted first, so that numbers are rounded down.
const TO_FLOOR: f32 = 0.499;

impl Steps {
    fn new(middles: Extent, items: usize) -> Self {
        // Few items need few bins.
        let count = MOST_BINS.min(4 + items / 8);
        // Keeps rounding from leading beyond the bins.
        const SHRUNK: f32 = 0.999;
        let size = middles.high - middles.low;
        let scale = Vec4::splat(count as f32 * SHRUNK) / size;
        // An axis on which all middles are the same, or nearly so, isn't divided.
        let scale = Vec4::select(scale.is_finite_mask(), scale, Vec4::ZERO).with_w(0.0);
        Self { first: middles.low, scale, count }
    }

    /// The bin on each axis; zero where all middles are the same.
    #[inline(always)]
    fn of(&self, item: &Item) -> [usize; 3] {
        let steps = (item.middle() - self.first) * self.scale - TO_FLOOR;
        let [x, y, z, _] = (steps.max(Vec4::ZERO) + TO_BITS).to_array();
        [bin_of(x), bin_of(y), bin_of(z)]
    }

    /// The bin on one axis.
    #[inline(always)]
    fn along(&self, axis: usize, item: &Item) -> usize {
        let step = (item.low[axis] + item.high[axis] - self.first[axis]) * self.scale[axis] - TO_FLOOR;
        bin_of(step.max(0.0) + TO_BITS)
    }
}

#[inline(always)]
fn bin_of(step: f32) -> usize {
    step.to_bits() as usize % MOST_BINS
}

/// The items of a node by bins, along each axis.
#[derive(Clone, Debug)]
pub(super) struct Bins {
    steps: Steps,
    extents: [[Extent; MOST_BINS]; 3],
    counts: [[u32; MOST_BINS]; 3],
}

impl Default for Bins {
    fn default() -> Self {
        let steps = Steps::default();
        Self { steps, extents: [[Extent::EMPTY; MOST_BINS]; 3], counts: [[0; MOST_BINS]; 3] }
    }
}

/// A division of a node: items in bins below `bin` come first.
#[derive(Clone, Copy, Debug)]
pub(super) struct Split {
    steps: Steps,
    axis: usize,
    bin: usize,
    /// Number of items that come first.
    pub(super) first: usize,
    pub(super) extents: [Extent; 2],
}

impl Bins {
    /// Empties the bins, for this number of items with middles in these bounds.
    #[inline(always)]
    pub(super) fn clear(&mut self, middles: Extent, items: usize) {
        self.steps = Steps::new(middles, items);
        let count = self.steps.count;
        for axis in 0..3 {
            self.extents[axis][..count].fill(Extent::EMPTY);
            self.counts[axis][..count].fill(0);
        }
    }

    #[inline(always)]
    pub(super) fn fill(&mut self, items: &[Item]) {
        for item in items {
            for (axis, bin) in self.steps.of(item).into_iter().enumerate() {
                let extent = &mut self.extents[axis][bin];
                *extent = extent.union(item.extent());
                self.counts[axis][bin] += 1;
            }
        }
    }

    /// Adds the contents of other bins.
    pub(super) fn merge(&mut self, other: &Self) {
        for axis in 0..3 {
            for bin in 0..self.steps.count {
                self.extents[axis][bin] = self.extents[axis][bin].union(other.extents[axis][bin]);
                self.counts[axis][bin] += other.counts[axis][bin];
            }
        }
    }

    /// The best split by the surface area heuristic, for leaves of `most` items; `None` if all middles are in one bin.
    #[inline(always)]
    pub(super) fn best(&self, most: usize) -> Option<Split> {
        let count = self.steps.count;
        let cost = |extent: &Extent, items: u32| extent.area() * items.div_ceil(most as u32) as f32;
        let (mut least, mut best) = (f32::INFINITY, None);
        for axis in 0..3 {
            if self.steps.scale[axis] == 0.0 {
                continue;
            }
            let (extents, counts) = (&self.extents[axis][..count], &self.counts[axis][..count]);
            let mut above = [0.0; MOST_BINS];
            let (mut extent, mut items) = (Extent::EMPTY, 0);
            for bin in (1..count).rev() {
                extent = extent.union(extents[bin]);
                items += counts[bin];
                above[bin] = if items == 0 { f32::INFINITY } else { cost(&extent, items) };
            }
            let (mut extent, mut items) = (Extent::EMPTY, 0);
            for bin in 1..count {
                extent = extent.union(extents[bin - 1]);
                items += counts[bin - 1];
                let cost = cost(&extent, items) + above[bin];
                if items > 0 && cost < least {
                    (least, best) = (cost, Some((axis, bin)));
                }
            }
        }
        let (axis, bin) = best?;
        let sum = |extents: &[Extent]| extents.iter().copied().fold(Extent::EMPTY, Extent::union);
        let (below, above) = self.extents[axis][..count].split_at(bin);
        let first = self.counts[axis][..bin].iter().sum::<u32>() as usize;
        Some(Split { steps: self.steps, axis, bin, first, extents: [sum(below), sum(above)] })
    }
}

impl Split {
    #[inline(always)]
    fn is_first(&self, item: &Item) -> bool {
        self.steps.along(self.axis, item) < self.bin
    }

    /// Moves the items that come first to the front.
    #[inline(always)]
    pub(super) fn partition(&self, items: &mut [Item]) {
        let mut first = 0;
        for index in 0..items.len() {
            // Without a branch, which would be unpredictable.
            items.swap(index, first);
            first += usize::from(self.is_first(&items[first]));
        }
        debug_assert_eq!(first, self.first);
    }

    /// The number of items that come first.
    pub(super) fn count_first(&self, items: &[Item]) -> usize {
        items.iter().filter(|item| self.is_first(item)).count()
    }

    /// Copies the items that come first, and the others, to their destinations.
    pub(super) fn scatter(&self, items: &[Item], into: &mut [&mut [Item]; 2]) {
        let mut next = [0; 2];
        for item in items {
            let side = usize::from(!self.is_first(item));
            into[side][next[side]] = *item;
            next[side] += 1;
        }
    }
}
