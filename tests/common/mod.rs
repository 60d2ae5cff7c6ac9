//! What several test programs share.

#![allow(dead_code, reason = "each test program uses a part of it")]

pub(crate) mod golden_lenses;
pub(crate) mod program;
pub(crate) mod rendering;
