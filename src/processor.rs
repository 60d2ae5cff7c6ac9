//! Proof of what the processor at hand can do.
//!
//! The crate is built for the least common processor, and its innermost loops are compiled once more for others. Running
//! those where the processor lacks the instructions is undefined behavior, so whoever calls them shows a value of these types.
//! Its field is private to this file: one is made only by `find`, which asks the processor.

/// Proof that the processor has AVX2, and BMI1, BMI2, LZCNT and POPCNT, which came with it everywhere.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Avx2(());

impl Avx2 {
    /// Asks the processor; the answer is kept by the standard library.
    #[inline]
    pub fn find() -> Option<Avx2> {
        let found = is_x86_feature_detected!("avx2")
            && is_x86_feature_detected!("bmi1")
            && is_x86_feature_detected!("bmi2")
            && is_x86_feature_detected!("lzcnt")
            && is_x86_feature_detected!("popcnt");
        found.then_some(Avx2(()))
    }
}

/// Proof that the processor has AVX-512 with the extensions VL, DQ and BW, and all that [`Avx2`] proves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Avx512(());

impl Avx512 {
    /// Asks the processor; the answer is kept by the standard library.
    #[inline]
    pub fn find() -> Option<Avx512> {
        let found = Avx2::find().is_some()
            && is_x86_feature_detected!("avx512f")
            && is_x86_feature_detected!("avx512vl")
            && is_x86_feature_detected!("avx512dq")
            && is_x86_feature_detected!("avx512bw");
        found.then_some(Avx512(()))
    }
}
