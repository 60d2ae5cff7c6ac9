//! assets
mod openexr;
mod pfm;
pub mod picture;
