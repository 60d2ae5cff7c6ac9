//! assets
pub mod openexr;
pub mod pfm;
pub mod picture;
