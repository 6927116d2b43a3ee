use crate::Counts;

/// Counts where the feature `statistics` is on; else it is empty, and its methods do nothing.
#[derive(Clone, Copy, Debug, Default)]
pub struct Statistics {
    #[cfg(feature = "statistics")]
    counts: Counts,
}

impl Statistics {
    #[inline(always)]
    #[cfg_attr(not(feature = "statistics"), expect(clippy::unused_self, reason = "there is nothing to count in"))]
    fn note(&mut self, count: impl FnOnce(&mut Counts)) {
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
            counts.tests += u64::from(tested.count_ones());
        });
    }

    /// The predicate was asked.
    #[inline(always)]
    pub fn settled(&mut self, pairs: u64) {
        self.note(|counts| counts.settled += pairs);
    }

    /// What was counted since the last time, and forgets it.
    pub(super) fn take(&mut self) -> Counts {
        #[cfg(feature = "statistics")]
        return std::mem::take(&mut self.counts);
        #[cfg(not(feature = "statistics"))]
        Counts::default()
    }
}
