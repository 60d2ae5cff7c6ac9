//! Vector instruction sets of the processor, selected once at run time for both the lens and the traversal.
//!
//! The crate is built for the oldest processor of its architecture, so that one binary runs everywhere. A [`Kernel`] is
//! also compiled for AVX2 and for AVX-512, and the best set that the processor supports is used at run time. Results
//! are bitwise identical: vector instructions round as scalar ones do, and neither Rust nor LLVM fuses a product and a
//! sum on its own.
//!
//! The crate `pulp` detects the processor's features and holds the proof; there is no `unsafe` here. The environment
//! variable `FSTOP_INSTRUCTIONS` lowers the set, to show on one machine that results do not depend on it.

#[cfg(target_arch = "x86_64")]
use pulp::x86::{V3, V4};

/// Numbers of single precision in a vector of the widest set. Loops run over whole ones, whatever is in the places that are too many.
pub const WIDEST: usize = 16;

/// A computation to be compiled for several instruction sets. `run` and everything it calls must be
/// `#[inline(always)]`: functions that are not inlined use only the baseline instructions.
pub trait Kernel {
    /// The result.
    type Output;
    /// Runs the computation with the instructions that `with` proves to be available.
    fn run(self, with: impl Instructions) -> Self::Output;
}

/// Proof that the processor supports an instruction set; one type for each, so that the set is known wherever code is
/// compiled for it.
pub trait Instructions: Copy {
    /// The proof as a value; a match on it costs nothing.
    fn proof(self) -> Proof;
}

/// The proofs of all instruction sets.
#[derive(Clone, Copy, Debug)]
pub enum Proof {
    /// Supported by every processor of this architecture: SSE2 on x86-64.
    Baseline,
    /// AVX2 with FMA, BMI and LZCNT (x86-64-v3).
    #[cfg(target_arch = "x86_64")]
    Avx2(V3),
    /// AVX-512 F, BW, CD, DQ and VL (x86-64-v4).
    #[cfg(target_arch = "x86_64")]
    Avx512(V4),
}

/// Proof of the baseline, which every processor of this architecture supports.
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

/// An instruction set that this processor supports.
#[derive(Clone, Copy, Debug)]
pub struct InstructionSet(Proof);

impl Default for InstructionSet {
    /// The baseline.
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

    /// The best set that this processor supports.
    #[inline]
    pub fn best() -> InstructionSet {
        #[cfg(target_arch = "x86_64")]
        if let Some(v4) = avx512() {
            return InstructionSet(Proof::Avx512(v4));
        }
        #[cfg(target_arch = "x86_64")]
        if let Some(v3) = avx2() {
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

/// The best set to be used even if the processor has better.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Limit {
    Baseline,
    Avx2,
    Avx512,
}

/// Read once: results do not depend on it.
#[cfg(target_arch = "x86_64")]
static LIMIT: std::sync::LazyLock<Limit> =
    std::sync::LazyLock::new(|| limit().unwrap_or(Limit::Avx512));

/// # Errors
/// Fails, in words for the user, if `FSTOP_INSTRUCTIONS` is set to something else.
pub fn check_variable() -> Result<(), String> {
    limit().map(drop)
}

fn limit() -> Result<Limit, String> {
    let Some(value) = std::env::var_os("FSTOP_INSTRUCTIONS") else {
        return Ok(Limit::Avx512);
    };
    match value.to_string_lossy().as_ref() {
        "sse2" | "neon" | "baseline" => Ok(Limit::Baseline),
        "avx2" => Ok(Limit::Avx2),
        "avx512" => Ok(Limit::Avx512),
        other => Err(format!(
            "FSTOP_INSTRUCTIONS is `{other}`: expected sse2 (or baseline), avx2 or avx512"
        )),
    }
}

/// AVX-512, if the processor has it and the user has not said otherwise.
#[cfg(target_arch = "x86_64")]
#[inline]
fn avx512() -> Option<V4> {
    V4::try_new().filter(|_| *LIMIT >= Limit::Avx512)
}

/// AVX2, likewise.
#[cfg(target_arch = "x86_64")]
#[inline]
fn avx2() -> Option<V3> {
    V3::try_new().filter(|_| *LIMIT >= Limit::Avx2)
}

/// Runs `kernel`, on bundles of `LANES` numbers, with the best instructions of this processor.
///
/// AVX-512 is worth it if a bundle fills two of its registers: rays through the double Gauss take 13 ns instead of
/// 17 with AVX2 for 32 lanes, but 19 instead of 17 for 16 (`cargo bench --bench lens`). For fewer it is not even compiled,
/// which takes long.
#[inline(always)]
pub fn vectorize<const LANES: usize, K: Kernel>(kernel: K) -> K::Output {
    #[cfg(target_arch = "x86_64")]
    if const { LANES >= 32 }
        && let Some(with) = avx512()
    {
        return with.vectorize(Call { kernel, with });
    }
    #[cfg(target_arch = "x86_64")]
    if let Some(with) = avx2() {
        return with.vectorize(Call { kernel, with });
    }
    kernel.run(Baseline)
}

/// A kernel with its instruction set, as `pulp` calls it.
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
