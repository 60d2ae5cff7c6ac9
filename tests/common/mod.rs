//! What several test programs share.

#![allow(dead_code, reason = "each test program uses a part of it")]

pub mod golden_lenses;
pub mod program;
pub mod rendering;
