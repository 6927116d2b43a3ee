use std::hash::{BuildHasher as _, RandomState};
use std::sync::OnceLock;

/// A secret key for hashes of data from files: an attacker who doesn't know it can't choose numbers whose hashes
/// collide. It differs between processes, so no answer may depend on it.
#[derive(Clone, Copy, Debug)]
pub struct HashKey {
    start: u64,
    factor: u64,
}

/// The key of this process.
impl Default for HashKey {
    fn default() -> Self {
        static KEY: OnceLock<HashKey> = OnceLock::new();
        *KEY.get_or_init(|| {
            let [start, factor] = [0, 1].map(|which: u64| RandomState::new().hash_one(which));
            Self { start, factor: factor | 1 }
        })
    }
}

impl HashKey {
    /// The hash of nothing.
    #[inline(always)]
    #[must_use]
    pub fn start(self) -> u64 {
        self.start
    }

    /// Appends a number to a hash. The two halves of the product depend on different bits.
    #[inline(always)]
    #[must_use]
    pub fn mix(self, hash: u64, number: u64) -> u64 {
        let product = u128::from(hash ^ number) * u128::from(self.factor);
        product as u64 ^ (product >> 64) as u64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hashes_are_of_all_bits_and_of_their_order() {
        let key = HashKey::default();
        let hash = |numbers: &[u64]| numbers.iter().fold(key.start(), |hash, &number| key.mix(hash, number));
        let first = hash(&[5, 7]);
        assert!(first == hash(&[5, 7]) && first != hash(&[7, 5]) && first != hash(&[5, 7, 0]));
        for bit in 0..64 {
            assert!(first != hash(&[5 ^ 1 << bit, 7]) && first != hash(&[5, 7 ^ 1 << bit]), "{bit}");
            // Each bit changes the lowest bits, which hash tables use, for at least one of a few numbers.
            let low = |number: u64| hash(&[number]) & 0xff;
            assert!((0..64).any(|number| low(number) != low(number ^ 1 << bit)), "{bit}");
        }
    }

    #[test]
    fn processes_have_keys_of_their_own() {
        let [one, other] = [RandomState::new(), RandomState::new()].map(|state| state.hash_one(0_u64));
        assert_ne!(one, other);
    }
}
