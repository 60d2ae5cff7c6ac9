//! How much a texture uses others.

/// How much a texture uses others, those that they use in turn included.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Nesting {
    /// How many textures stand one inside the other at most, 1 for a texture that uses none.
    pub depth: usize,
    /// How many textures are evaluated for one value at most. A texture named twice counts twice, so
    /// that thirty textures of two operands each can come to a thousand million.
    pub lookups: u64,
}

impl Nesting {
    /// That of a texture which uses no other.
    pub const NONE: Nesting = Nesting {
        depth: 1,
        lookups: 1,
    };
}

/// The most textures that may be evaluated for one value: about a millisecond of work. No image
/// would ever be finished with many more, in pbrt-v3 neither.
pub const MAX_LOOKUPS: u64 = 1 << 16;
