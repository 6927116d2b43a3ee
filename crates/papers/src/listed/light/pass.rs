use umbrage_rays::LightSource;
use umbrage_rays::light_grid::settle::Settler;
use umbrage_rays::light_grid::survey::Survey;
use umbrage_rays::shot::{Counts, LightMask, Seconds, SeenImage, SeenPixels, Shot, TileOrder, Work};
use umbrage_rays::simd::SimdLevel;

/// The state of one light's way from a camera's points to a mask, independent of the map.
#[derive(Default)]
pub(super) struct LightPass {
    pub(super) level: SimdLevel,
    pub(super) survey: Survey,
    /// The lanes of each block with a point of the current face.
    pub(super) members: Vec<u16>,
    pub(super) undecided: Vec<[u32; 2]>,
    /// For each block, the points known to be in shadow.
    pub(super) shadowed: Vec<u16>,
    pub(super) outliers: Vec<u32>,
    pub(super) counts: Counts,
    pub(super) seconds: Seconds,
}

impl LightPass {
    pub(super) fn new(level: SimdLevel) -> Self {
        Self { level, ..Self::default() }
    }

    /// The settler of undecided pairs of a light.
    pub(super) fn settler<'a>(&self, image: &SeenImage<'a>, light: &'a LightSource) -> Settler<'a> {
        Settler::of_image(*image, self.survey.rays, light, self.level)
    }

    /// Starts with a light.
    ///
    /// # Panics
    /// If `survey` wasn't called for `seen`.
    pub(super) fn start(&mut self, seen: &SeenPixels) {
        assert!(self.survey.slots == seen.triangle.len(), "another image was surveyed");
        self.counts = Counts::default();
        self.seconds = Seconds { survey: self.survey.seconds, ..Seconds::default() };
        self.outliers.clear();
        let blocks = self.survey.slots / TileOrder::BLOCK_PIXELS;
        self.shadowed.clear();
        self.shadowed.resize(blocks, 0);
        self.members.resize(blocks, 0);
    }

    /// Settles the points that no face holds.
    pub(super) fn settle_outliers(&mut self, settler: &Settler<'_>) {
        self.outliers.extend_from_slice(&self.survey.unknown);
        self.counts.outliers = settler.settle_outliers(&mut self.outliers, &mut self.shadowed);
    }

    /// Writes the lit points to `mask`.
    pub(super) fn finish(&self, shot: &Shot<'_>, seen: &SeenPixels, light: &LightSource, mask: &mut LightMask) -> Work {
        mask.resize(seen.order());
        let lit = mask.blocks_mut();
        lit.copy_from_slice(&self.shadowed);
        seen.light_the_rest(lit, self.level);
        mask.keep_in_cone(light, shot, seen, self.level);
        Work { counts: self.counts, seconds: self.seconds }
    }

    /// Bytes held.
    pub(super) fn bytes(&self) -> usize {
        self.survey.bytes()
            + (self.members.capacity() + self.shadowed.capacity()) * size_of::<u16>()
            + self.undecided.capacity() * size_of::<[u32; 2]>()
            + self.outliers.capacity() * size_of::<u32>()
    }
}
