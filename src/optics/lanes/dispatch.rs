//! The vector instructions of the processor at hand.
//!
//! The crate is built for the least common processor, so that one binary runs everywhere; a bundle's
//! arithmetic is compiled once more for each set of vector instructions below, and the best that
//! the processor has is taken at run time. The results are the same to the bit: vector instructions
//! round as scalar ones, and neither Rust nor LLVM merges a product and a sum by itself.
//!
//! This is the one place of the optics with `unsafe`, and it is measured to be worth it: a useful ray of the double Gauss
//! (pupil sampled, traced, weighted, placed in the scene) takes 46 ns in bundles of 32 with what every x86-64 has, 28 with
//! AVX2 and 23 with AVX-512; with its derivatives traced, 106, 50 and 89
//! (`cargo bench --bench lens`, AMD EPYC with AVX-512). The `pulp` crate does the same behind a safe interface, at the same
//! speed.

#[cfg(target_arch = "x86_64")]
use crate::processor::{Avx2, Avx512};

/// A calculation to be compiled for several sets of vector instructions. `run` and all it calls
/// must be `#[inline(always)]`.
pub trait Kernel {
    /// What comes out.
    type Output;
    /// Calculates.
    fn run(self) -> Self::Output;
}

/// A set of vector instructions that this processor has.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Instructions(Set);

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Set {
    Baseline,
    #[cfg(target_arch = "x86_64")]
    Avx2(Avx2),
    #[cfg(target_arch = "x86_64")]
    Avx512(Avx512),
}

impl Instructions {
    /// All that this processor has, the best last.
    pub fn available() -> Vec<Instructions> {
        let mut sets = vec![Instructions(Set::Baseline)];
        #[cfg(target_arch = "x86_64")]
        {
            let found = [Avx2::find().map(Set::Avx2), Avx512::find().map(Set::Avx512)];
            sets.extend(found.into_iter().flatten().map(Instructions));
        }
        sets
    }

    /// The best that this processor has for bundles of `lanes`.
    ///
    /// AVX-512 pays where a bundle fills two of its registers: rays through the double Gauss take
    /// 13 ns against 17 with AVX2 for 32 lanes, but 19 against 17 for 16.
    #[inline]
    pub fn best(lanes: usize) -> Instructions {
        #[cfg(target_arch = "x86_64")]
        {
            if lanes >= 32
                && let Some(proof) = Avx512::find()
            {
                return Instructions(Set::Avx512(proof));
            }
            if let Some(proof) = Avx2::find() {
                return Instructions(Set::Avx2(proof));
            }
        }
        let _ = lanes;
        Instructions(Set::Baseline)
    }

    /// Its usual name.
    pub fn name(self) -> &'static str {
        match self.0 {
            Set::Baseline if cfg!(target_arch = "x86_64") => "SSE2",
            Set::Baseline if cfg!(target_arch = "aarch64") => "NEON",
            Set::Baseline => "baseline",
            #[cfg(target_arch = "x86_64")]
            Set::Avx2(_) => "AVX2",
            #[cfg(target_arch = "x86_64")]
            Set::Avx512(_) => "AVX-512",
        }
    }

    /// Runs `kernel` with these instructions.
    #[inline(always)]
    pub fn run<K: Kernel>(self, kernel: K) -> K::Output {
        match self.0 {
            Set::Baseline => kernel.run(),
            // SAFETY: the proof is of all that the function is compiled for.
            #[cfg(target_arch = "x86_64")]
            #[expect(unsafe_code, reason = "measured: a third less time, see above")]
            Set::Avx2(_) => unsafe { avx2(kernel) },
            // SAFETY: the proof is of all that the function is compiled for.
            #[cfg(target_arch = "x86_64")]
            #[expect(unsafe_code, reason = "measured: a third less time, see above")]
            Set::Avx512(_) => unsafe { avx512(kernel) },
        }
    }
}

/// Runs `kernel`, on bundles of `lanes`, with the best instructions of this processor.
#[inline(always)]
pub fn vectorize<K: Kernel>(lanes: usize, kernel: K) -> K::Output {
    Instructions::best(lanes).run(kernel)
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn avx2<K: Kernel>(kernel: K) -> K::Output {
    kernel.run()
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512vl,avx512dq,avx512bw")]
fn avx512<K: Kernel>(kernel: K) -> K::Output {
    kernel.run()
}
