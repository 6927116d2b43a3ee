/// The triangles that a packet has tested, the last one of each hash (Kirk and Arvo, *Improved Ray Tagging for Voxel-Based
/// Ray Tracing*, 1991; Wald et al. 2006, §2.3). A triangle that was overwritten is tested again, which changes no answer.
pub(crate) struct Mailbox([u32; Self::SLOTS]);

impl Default for Mailbox {
    fn default() -> Self {
        Self([u32::MAX; Self::SLOTS])
    }
}

impl Mailbox {
    const SLOTS: usize = 512;

    /// Forgets everything.
    pub(crate) fn clear(&mut self) {
        self.0 = [u32::MAX; Self::SLOTS];
    }

    /// Whether a triangle isn't in the mailbox yet; adds it.
    #[inline(always)]
    pub(crate) fn is_new(&mut self, id: u32) -> bool {
        std::mem::replace(&mut self.0[id as usize % Self::SLOTS], id) != id
    }
}
