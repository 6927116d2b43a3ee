/// What tracing packets through a [`UniformGrid`](super::UniformGrid) took. All zeros without the feature `statistics`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct UniformCounts {
    /// Rays that were traced.
    pub rays: u64,
    /// Groups of rays that were traced together.
    pub packets: u64,
    /// Pairs of a packet and a cell, those of grids inside of cells counted too.
    pub cells: u64,
    /// Triangles that the mailbox knew.
    pub mailbox_hits: u64,
    /// Triangles outside of the packet's frustum.
    pub frustum_culls: u64,
    /// Triangles behind what all of the packet's rays hit.
    pub depth_culls: u64,
    /// Pairs of a packet and a triangle that were tested ray by ray.
    pub triangle_tests: u64,
    /// Pairs of a ray and a triangle that the predicate was asked about.
    pub asked: u64,
}

impl UniformCounts {
    /// Each count with its name.
    #[must_use]
    pub fn named(&self) -> [(&'static str, u64); 8] {
        let Self { rays, packets, cells, mailbox_hits, frustum_culls, depth_culls, triangle_tests, asked } = *self;
        [
            ("rays", rays),
            ("packets", packets),
            ("cells", cells),
            ("mailbox_hits", mailbox_hits),
            ("frustum_culls", frustum_culls),
            ("depth_culls", depth_culls),
            ("triangle_tests", triangle_tests),
            ("asked", asked),
        ]
    }
}

/// Counts where the feature `statistics` is on; else it is empty, and its methods do nothing.
#[derive(Clone, Copy, Debug, Default)]
pub struct Statistics {
    #[cfg(feature = "statistics")]
    counts: UniformCounts,
}

impl Statistics {
    #[inline(always)]
    #[cfg_attr(not(feature = "statistics"), expect(clippy::unused_self, reason = "there is nothing to count in"))]
    fn note(&mut self, count: impl FnOnce(&mut UniformCounts)) {
        #[cfg(feature = "statistics")]
        count(&mut self.counts);
        #[cfg(not(feature = "statistics"))]
        let _ = count;
    }

    #[inline(always)]
    pub(super) fn rays(&mut self, members: u32) {
        self.note(|counts| counts.rays += u64::from(members));
    }

    #[inline(always)]
    pub(super) fn packet(&mut self) {
        self.note(|counts| counts.packets += 1);
    }

    #[inline(always)]
    pub(super) fn cells(&mut self, cells: u32) {
        self.note(|counts| counts.cells += u64::from(cells));
    }

    #[inline(always)]
    pub(super) fn mailbox_hit(&mut self) {
        self.note(|counts| counts.mailbox_hits += 1);
    }

    /// Notes triangles outside of the frustum, a bit for each.
    #[inline(always)]
    pub(super) fn frustum_culls(&mut self, outside: u64) {
        self.note(|counts| counts.frustum_culls += u64::from(outside.count_ones()));
    }

    /// Notes triangles that are inside the frustum, and those of them that aren't hidden.
    #[inline(always)]
    pub(super) fn tested(&mut self, inside: u64, tested: u64) {
        self.note(|counts| {
            counts.depth_culls += u64::from((inside & !tested).count_ones());
            counts.triangle_tests += u64::from(tested.count_ones());
        });
    }

    /// The predicate was asked.
    #[inline(always)]
    pub fn asked(&mut self) {
        self.note(|counts| counts.asked += 1);
    }

    /// What was counted since the last time, and forgets it.
    pub(super) fn take(&mut self) -> UniformCounts {
        #[cfg(feature = "statistics")]
        return std::mem::take(&mut self.counts);
        #[cfg(not(feature = "statistics"))]
        UniformCounts::default()
    }
}

impl UniformCounts {
    pub(super) fn plus(self, other: Self) -> Self {
        Self {
            rays: self.rays + other.rays,
            packets: self.packets + other.packets,
            cells: self.cells + other.cells,
            mailbox_hits: self.mailbox_hits + other.mailbox_hits,
            frustum_culls: self.frustum_culls + other.frustum_culls,
            depth_culls: self.depth_culls + other.depth_culls,
            triangle_tests: self.triangle_tests + other.triangle_tests,
            asked: self.asked + other.asked,
        }
    }
}
