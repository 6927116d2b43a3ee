use fearless_simd::Level;

/// A set of SIMD instructions of this machine.
///
/// Every level gives the same results bit for bit; they differ in speed only.
#[derive(Clone, Copy, Debug)]
pub struct SimdLevel(pub(super) Level);

impl Default for SimdLevel {
    /// The widest one.
    fn default() -> Self {
        Self(Level::new())
    }
}

impl SimdLevel {
    /// All levels that this machine has, the widest last.
    #[must_use]
    pub fn available() -> Vec<Self> {
        let widest = Level::new();
        #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
        let levels = [
            widest.as_sse2().map(Level::Sse2),
            widest.as_sse4_2().map(Level::Sse4_2),
            widest.as_avx2().map(Level::Avx2),
            widest.as_avx512().map(Level::Avx512),
        ];
        #[cfg(not(any(target_arch = "x86", target_arch = "x86_64")))]
        let levels = [Some(widest)];
        levels.into_iter().flatten().map(Self).collect()
    }
}
