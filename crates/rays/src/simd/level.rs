use std::fmt;
use std::str::FromStr;

use fearless_simd::Level;

use crate::UnknownChoice;

/// A set of SIMD instructions that this machine has and that kernels are compiled for.
///
/// Every level gives the same results bit for bit; they differ in speed only.
#[derive(Clone, Copy, Debug)]
pub struct SimdLevel(Level);

impl Default for SimdLevel {
    /// The widest one.
    fn default() -> Self {
        let machine = Level::new();
        Self(compiled(machine).into_iter().flatten().last().unwrap_or(machine))
    }
}

impl From<SimdLevel> for Level {
    /// The level as `fearless_simd` has it.
    fn from(level: SimdLevel) -> Self {
        level.0
    }
}

/// The levels of a machine that kernels are compiled for, the widest last.
#[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
fn compiled(machine: Level) -> [Option<Level>; 3] {
    let (avx2, avx512) = (machine.as_avx2(), machine.as_avx512());
    [machine.as_sse2().map(Level::Sse2), avx2.map(Level::Avx2), avx512.map(Level::Avx512)]
}

/// The levels of a machine that kernels are compiled for.
#[cfg(not(any(target_arch = "x86", target_arch = "x86_64")))]
fn compiled(machine: Level) -> [Option<Level>; 1] {
    [Some(machine)]
}

impl SimdLevel {
    /// All levels that this machine has, the widest last.
    #[must_use]
    pub fn available() -> Vec<Self> {
        compiled(Level::new()).into_iter().flatten().map(Self).collect()
    }

    /// A short name, such as `avx2`.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self.0 {
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            Level::Sse2(_) => "sse2",
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            Level::Avx2(_) => "avx2",
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            Level::Avx512(_) => "avx512",
            _ => "widest",
        }
    }
}

impl fmt::Display for SimdLevel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for SimdLevel {
    type Err = UnknownChoice;

    /// The level of a [name](Self::name), if this machine has it.
    fn from_str(name: &str) -> Result<Self, UnknownChoice> {
        let unknown = || UnknownChoice::new("SIMD level", name, Self::available().into_iter().map(Self::name));
        Self::available().into_iter().find(|level| level.name() == name).ok_or_else(unknown)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_are_found_by_their_names() {
        let levels = SimdLevel::available();
        assert_eq!(levels.last().map(|level| level.name()), Some(SimdLevel::default().name()));
        for level in levels {
            assert_eq!(level.name().parse::<SimdLevel>().unwrap().name(), level.name());
        }
        let error = "mmx".parse::<SimdLevel>().unwrap_err().to_string();
        assert!(error.contains("`mmx`") && error.contains(SimdLevel::default().name()), "{error}");
    }
}
