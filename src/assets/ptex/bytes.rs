//! Reads numbers and compressed blocks from a file in memory, with bounds checks.

use flate2::{Decompress, FlushDecompress};

/// Maximum expansion of a byte by deflate (zlib's own figure), …
const MAX_GROWTH: usize = 1032;

/// … and what its first bytes may add to that: a match of 258 bytes.
const GROWTH_SLACK: usize = 258;

/// The unread rest of some bytes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bytes<'a> {
    rest: &'a [u8],
    /// What the bytes contain, for messages.
    what: &'static str,
}

impl<'a> Bytes<'a> {
    pub(super) fn new(bytes: &'a [u8], what: &'static str) -> Bytes<'a> {
        Bytes { rest: bytes, what }
    }

    /// The bytes of `file` from `start`.
    pub(super) fn from(
        file: &'a [u8],
        start: u64,
        what: &'static str,
    ) -> Result<Bytes<'a>, String> {
        let rest = usize::try_from(start).ok().and_then(|s| file.get(s..));
        rest.map(|rest| Bytes { rest, what })
            .ok_or_else(|| format!("the file ends before its {what}"))
    }

    pub(super) fn take(&mut self, count: u64) -> Result<&'a [u8], String> {
        let split = usize::try_from(count)
            .ok()
            .and_then(|n| self.rest.split_at_checked(n));
        let (taken, rest) =
            split.ok_or_else(|| format!("the file ends within its {}", self.what))?;
        self.rest = rest;
        Ok(taken)
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N], String> {
        let mut array = [0; N];
        array.copy_from_slice(self.take(N as u64)?);
        Ok(array)
    }

    pub(super) fn u8(&mut self) -> Result<u8, String> {
        self.array().map(u8::from_le_bytes)
    }

    pub(super) fn u16(&mut self) -> Result<u16, String> {
        self.array().map(u16::from_le_bytes)
    }

    pub(super) fn u32(&mut self) -> Result<u32, String> {
        self.array().map(u32::from_le_bytes)
    }

    pub(super) fn i32(&mut self) -> Result<i32, String> {
        self.array().map(i32::from_le_bytes)
    }

    pub(super) fn u64(&mut self) -> Result<u64, String> {
        self.array().map(u64::from_le_bytes)
    }

    /// Decompresses the next `zipped` bytes to exactly `size` bytes.
    pub(super) fn inflate(&mut self, zipped: u64, size: u64) -> Result<Vec<u8>, String> {
        let what = self.what;
        inflate(self.take(zipped)?, size, what)
    }
}

/// Decompresses `zipped` to `size` bytes. Never allocates more than it can expand to.
pub(super) fn inflate(zipped: &[u8], size: u64, what: &str) -> Result<Vec<u8>, String> {
    let most = zipped.len().saturating_mul(MAX_GROWTH) + GROWTH_SLACK;
    let size = usize::try_from(size)
        .ok()
        .filter(|&size| size <= most)
        .ok_or_else(|| {
            format!(
                "{} compressed bytes cannot hold the {size} bytes of its {what}",
                zipped.len()
            )
        })?;
    let mut plain = vec![0; size];
    if size == 0 {
        return Ok(plain);
    }
    let mut stream = Decompress::new(true);
    stream
        .decompress(zipped, &mut plain, FlushDecompress::Finish)
        .map_err(|_| format!("the compressed data of its {what} are damaged"))?;
    if stream.total_out() != size as u64 {
        return Err(format!(
            "the compressed data of its {what} end after {} of {size} bytes",
            stream.total_out()
        ));
    }
    Ok(plain)
}
