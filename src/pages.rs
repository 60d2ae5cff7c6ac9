//! Large (huge) pages of memory.
//!
//! A tree of a million triangles spans 17,000 pages of 4 KiB, far more than a processor's TLB holds, and an incoherent
//! ray needs another one at almost every step. With pages of 2 MiB, random rays through such a tree take a fifth less
//! time, others 2 to 5 % (`cargo bench --bench traversal`). Linux provides them on request; Embree requests them too. And one large page takes
//! the system less time to clear than five hundred small ones.

#[cfg(target_os = "linux")]
use rustix::mm::{Advice, madvise};

/// Asks the operating system to back memory that has not been touched yet with large pages. It may decline; nothing else changes.
#[cfg(target_os = "linux")]
pub fn ask_for_large<T>(untouched: &mut [T]) {
    /// Size of a large page in bytes.
    const PAGE: usize = 2 << 20;

    let start = untouched.as_mut_ptr().cast::<u8>();
    let skipped = start.align_offset(PAGE);
    let rest = size_of_val(untouched).saturating_sub(skipped);
    let whole = rest / PAGE * PAGE;
    if whole > 0 {
        let start = start.wrapping_add(skipped).cast();
        // A system without large pages refuses; all is then as slow as before.
        // SAFETY: the bytes are within the slice, which is mutably borrowed, and the size of their pages does not
        // affect their values.
        #[expect(unsafe_code, reason = "measured: see above; std has no name for it")]
        let _ = unsafe { madvise(start, whole, Advice::LinuxHugepage) };
    }
}

/// On other systems, leaves the decision to the system.
#[cfg(not(target_os = "linux"))]
pub fn ask_for_large<T>(_: &mut [T]) {}
