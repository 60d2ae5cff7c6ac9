//! Readers of the files that scenes refer to: meshes, images, spectra and BSDFs.

pub mod brdf_file;
pub mod bsdf_file;
pub mod image_data;
pub mod merl_file;
pub mod mesh;
pub mod obj;
pub(crate) mod openexr;
mod pfm;
pub mod ply;
pub mod ptex;
pub mod spd;

/// Largest accepted measured reflectance, in 1/sr: the peak of a mirror as sharp as the finest angle of a MERL table is
/// a hundredth of it.
const MAX_MEASURED: f64 = 1e9;
