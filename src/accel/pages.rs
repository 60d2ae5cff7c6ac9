//! Large pages of memory.
//!
//! A tree of a million triangles is spread over 17,000 pages of 4 KiB, far more than a processor knows
//! the places of, and an incoherent ray needs another at almost every step. With pages of 2 MiB random
//! rays through such a tree take a fifth less time, others 2 to 5 % (`cargo bench --bench traversal`).
//! Linux has them where it is asked, as Embree asks too.

#[cfg(target_os = "linux")]
use rustix::mm::{Advice, madvise};
use std::mem::MaybeUninit;

/// Asks the system to hold unused memory in large pages. It may well not; nothing else changes.
#[cfg(target_os = "linux")]
pub(super) fn ask_for_large<T>(unused: &mut [MaybeUninit<T>]) {
    /// Bytes of a large page.
    const PAGE: usize = 2 << 20;

    let start = unused.as_mut_ptr().cast::<u8>();
    let skipped = start.align_offset(PAGE);
    let rest = size_of_val(unused).saturating_sub(skipped);
    let whole = rest / PAGE * PAGE;
    if whole > 0 {
        let start = start.wrapping_add(skipped).cast();
        // A system without large pages refuses; the tree is then as slow as it was.
        // SAFETY: the bytes are within the slice, which is borrowed for writing, and how large their
        // pages are changes none of them.
        #[expect(unsafe_code, reason = "measured: see above; std has no name for it")]
        let _ = unsafe { madvise(start, whole, Advice::LinuxHugepage) };
    }
}

/// Elsewhere the system decides.
#[cfg(not(target_os = "linux"))]
pub(super) fn ask_for_large<T>(_: &mut [MaybeUninit<T>]) {}
