//! Pseudo-random permutations that are computed, not stored.

/// A family of permutations of 0 … n−1, one for each key.
///
/// Invertible steps on the next power of two (xor, odd factor, xor with a shifted copy), repeated
/// until the value is below n: the idea of Kensler, "Correlated Multi-Jittered Sampling", 2013, §4.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Permutation {
    n: u32,
    mask: u32,
    shift: u32,
}

impl Permutation {
    /// Of `n` ≥ 1 elements.
    pub(super) fn new(n: u32) -> Permutation {
        let n = n.max(1);
        let bits = u32::BITS - (n - 1).leading_zeros();
        Permutation {
            n,
            mask: ((1u64 << bits) - 1) as u32,
            shift: bits.div_ceil(2).max(1),
        }
    }

    /// The number of elements.
    pub(super) fn len(&self) -> u32 {
        self.n
    }

    /// Where the permutation of `key` takes `i` (taken modulo the power of two above n).
    pub(super) fn apply(&self, i: u32, key: u64) -> u32 {
        let (a, b) = (key as u32, (key >> 32) as u32);
        // Six rounds: with four, some permutations of four elements are 12 % too frequent.
        let keys = [
            (a, b),
            (b >> 5, a >> 3),
            (a >> 16, b >> 11),
            (b >> 21, a >> 9),
            (a >> 24, b >> 27),
            (b >> 14, a >> 19),
        ];
        self.walk(i, |x| {
            keys.iter()
                .fold(x, |x, &(add, factor)| self.round(x, add, factor))
        })
    }

    /// The same in a third of the steps: each `i` < n is taken to all places equally often, but some pairs of places are more frequent than others.
    #[inline(always)]
    pub(super) fn apply_fast(&self, i: u32, key: u64) -> u32 {
        let [place] = self.apply_fast_to_all([i], &[key]);
        place
    }

    /// [`Permutation::apply_fast`] to many numbers, each with a key of its own: in loops that are compiled to vector instructions.
    #[inline(always)]
    pub(super) fn apply_fast_to_all<const L: usize>(
        &self,
        numbers: [u32; L],
        keys: &[u64; L],
    ) -> [u32; L] {
        let step = |x: u32, key: u64| {
            let (a, b) = (key as u32, (key >> 32) as u32);
            self.round(self.round(x, a, b), b >> 5, a >> 3)
        };
        let mut places = numbers;
        for (x, key) in places.iter_mut().zip(keys) {
            *x = step(*x & self.mask, *key);
        }
        // As in `walk`.
        while { places.iter() }.fold(false, |any, x| any | (*x >= self.n)) {
            for (x, key) in places.iter_mut().zip(keys) {
                let next = step(*x, *key);
                *x = if *x < self.n { *x } else { next };
            }
        }
        for (x, key) in places.iter_mut().zip(keys) {
            let turned = *x + ((u64::from(self.n) * (key >> 32)) >> 32) as u32;
            *x = if turned < self.n {
                turned
            } else {
                turned - self.n
            };
        }
        places
    }

    #[inline(always)]
    fn walk(&self, i: u32, step: impl Fn(u32) -> u32) -> u32 {
        let mut x = i & self.mask;
        loop {
            x = step(x);
            // The steps permute all of 0 … mask, so that repeating them from a start below n
            // returns below n at the latest at the start itself.
            if x < self.n {
                return x;
            }
        }
    }

    #[inline(always)]
    fn round(&self, x: u32, add: u32, factor: u32) -> u32 {
        let x = x.wrapping_add(add).wrapping_mul(factor | 1) & self.mask;
        x ^ (x >> self.shift)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::hash::mix;

    #[test]
    fn permutes() {
        for n in (1..70).chain([100, 1000, 1024, 1025]) {
            let p = Permutation::new(n);
            for key in 0..20 {
                let mut seen = vec![false; n as usize];
                for i in 0..n {
                    let j = p.apply(i, mix(key)) as usize;
                    assert!(!std::mem::replace(&mut seen[j], true), "n {n}, key {key}");
                }
            }
        }
    }

    #[test]
    fn every_place_and_every_pair_of_places_is_equally_likely() {
        let keys = 400_000u64;
        for n in [2u32, 3, 4, 5, 8, 9, 12, 16] {
            let p = Permutation::new(n);
            let m = n as usize;
            // Where things 0 and 1 land together: n(n−1) possible pairs.
            let mut pairs = vec![0.0f64; m * m];
            for key in 0..keys {
                let k = mix(key.wrapping_mul(0x9e37_79b9_7f4a_7c15));
                pairs[p.apply(0, k) as usize * m + p.apply(1, k) as usize] += 1.0;
            }
            let expected = keys as f64 / (m * (m - 1)) as f64;
            for i in 0..m {
                for j in 0..m {
                    let count = pairs[i * m + j];
                    if i == j {
                        assert_eq!(count, 0.0);
                    } else {
                        // At least 1666 are expected in each of 240 places, so that chance alone
                        // makes 10 % (four standard deviations); the hash may add half as much.
                        assert!(
                            (count / expected - 1.0).abs() < 0.15,
                            "n {n}: {i},{j} {count} of {expected}"
                        );
                    }
                }
            }
        }
    }
}
