//! Files that scenes refer to: meshes, pictures, spectra and BSDFs.

pub mod bsdf_file;
pub mod mesh;
pub mod obj;
pub(crate) mod openexr;
mod pfm;
pub mod picture;
pub mod ply;
pub mod ptex;
pub mod spd;
