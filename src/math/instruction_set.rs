//! The vector instructions of the processor at hand, chosen once at run time for the lens and the traversal alike.
//!
//! The crate is built for the least common processor, so that one binary runs everywhere. A [`Kernel`] is compiled once more
//! for AVX2 and for AVX-512, and the best set that the processor has is taken when it runs. The results are the same to the
//! bit: vector instructions round as scalar ones do, and neither Rust nor LLVM merges a product and a sum by itself.
//!
//! The crate `pulp` tests the processor and holds the proof; there is no `unsafe` here.

#[cfg(target_arch = "x86_64")]
use pulp::x86::{V3, V4};

/// A calculation to be compiled for several sets of vector instructions. `run` and all it calls must be
/// `#[inline(always)]`: what is not inlined keeps the instructions of the least common processor.
pub trait Kernel {
    /// What comes out.
    type Output;
    /// Calculates with the instructions that `with` proves to be there.
    fn run(self, with: impl Instructions) -> Self::Output;
}

/// Proof that the processor has a set of vector instructions; a type for each, so that the set is known where code is
/// compiled for it.
pub trait Instructions: Copy {
    /// The same as a value; a match on it costs nothing.
    fn proof(self) -> Proof;
}

/// The proofs of all sets.
#[derive(Clone, Copy, Debug)]
pub enum Proof {
    /// What every processor of this architecture has: SSE2 on x86-64.
    Baseline,
    /// AVX2 with FMA, BMI and LZCNT (x86-64-v3).
    #[cfg(target_arch = "x86_64")]
    Avx2(V3),
    /// AVX-512 F, BW, CD, DQ and VL (x86-64-v4).
    #[cfg(target_arch = "x86_64")]
    Avx512(V4),
}

/// No more than every processor of this architecture has.
#[derive(Clone, Copy)]
struct Baseline;

impl Instructions for Baseline {
    #[inline(always)]
    fn proof(self) -> Proof {
        Proof::Baseline
    }
}

#[cfg(target_arch = "x86_64")]
impl Instructions for V3 {
    #[inline(always)]
    fn proof(self) -> Proof {
        Proof::Avx2(self)
    }
}

#[cfg(target_arch = "x86_64")]
impl Instructions for V4 {
    #[inline(always)]
    fn proof(self) -> Proof {
        Proof::Avx512(self)
    }
}

/// A set of vector instructions that this processor has.
#[derive(Clone, Copy, Debug)]
pub struct InstructionSet(Proof);

impl Default for InstructionSet {
    /// What every processor has.
    fn default() -> InstructionSet {
        InstructionSet(Proof::Baseline)
    }
}

impl InstructionSet {
    /// All that this processor has, the best last.
    #[cfg(any(test, feature = "internals"))]
    pub fn available() -> Vec<InstructionSet> {
        let mut sets = vec![InstructionSet::default()];
        #[cfg(target_arch = "x86_64")]
        {
            sets.extend(V3::try_new().map(|v3| InstructionSet(Proof::Avx2(v3))));
            sets.extend(V4::try_new().map(|v4| InstructionSet(Proof::Avx512(v4))));
        }
        sets
    }

    /// The best that this processor has.
    #[inline]
    pub fn best() -> InstructionSet {
        #[cfg(target_arch = "x86_64")]
        if let Some(v4) = V4::try_new() {
            return InstructionSet(Proof::Avx512(v4));
        }
        InstructionSet::best_of_256_bits()
    }

    /// The best that this processor has for bundles of `lanes` single-precision numbers.
    ///
    /// AVX-512 pays where a bundle fills two of its registers: rays through the double Gauss take 13 ns against 17 with AVX2
    /// for 32 lanes, but 19 against 17 for 16 (`cargo bench --bench lens`).
    #[inline]
    pub fn best_for(lanes: usize) -> InstructionSet {
        if lanes >= 32 {
            InstructionSet::best()
        } else {
            InstructionSet::best_of_256_bits()
        }
    }

    #[inline]
    fn best_of_256_bits() -> InstructionSet {
        #[cfg(target_arch = "x86_64")]
        if let Some(v3) = V3::try_new() {
            return InstructionSet(Proof::Avx2(v3));
        }
        InstructionSet::default()
    }

    /// Its usual name.
    #[cfg(any(test, feature = "internals"))]
    pub fn name(self) -> &'static str {
        match self.0 {
            Proof::Baseline if cfg!(target_arch = "x86_64") => "SSE2",
            Proof::Baseline if cfg!(target_arch = "aarch64") => "NEON",
            Proof::Baseline => "baseline",
            #[cfg(target_arch = "x86_64")]
            Proof::Avx2(_) => "AVX2",
            #[cfg(target_arch = "x86_64")]
            Proof::Avx512(_) => "AVX-512",
        }
    }

    /// Runs `kernel` with these instructions.
    #[inline(always)]
    pub fn run<K: Kernel>(self, kernel: K) -> K::Output {
        match self.0 {
            Proof::Baseline => kernel.run(Baseline),
            #[cfg(target_arch = "x86_64")]
            Proof::Avx2(with) => with.vectorize(Call { kernel, with }),
            #[cfg(target_arch = "x86_64")]
            Proof::Avx512(with) => with.vectorize(Call { kernel, with }),
        }
    }
}

/// Runs `kernel`, on bundles of `lanes`, with the best instructions of this processor.
#[inline(always)]
pub fn vectorize<K: Kernel>(lanes: usize, kernel: K) -> K::Output {
    InstructionSet::best_for(lanes).run(kernel)
}

/// A kernel with its instructions, as `pulp` calls it.
#[cfg(target_arch = "x86_64")]
struct Call<K, I> {
    kernel: K,
    with: I,
}

#[cfg(target_arch = "x86_64")]
impl<K: Kernel, I: Instructions> pulp::NullaryFnOnce for Call<K, I> {
    type Output = K::Output;
    #[inline(always)]
    fn call(self) -> K::Output {
        self.kernel.run(self.with)
    }
}
