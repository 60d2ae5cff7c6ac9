//! Files a scene refers to, decoded: here pictures.

mod openexr;
mod pfm;
pub mod picture;
