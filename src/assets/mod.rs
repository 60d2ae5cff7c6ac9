//! Files that scenes refer to: meshes, pictures and spectra.

pub mod mesh;
pub mod obj;
mod openexr;
mod pfm;
pub mod picture;
pub mod ply;
pub mod spd;
