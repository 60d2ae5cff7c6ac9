//! Metadata of an image file: how the image was rendered.

use glam::DMat4;
use serde::{Deserialize, Serialize};

/// Metadata written to the EXR header. Nothing here may differ between two runs of the same command, as equal renders
/// are equal files, byte for byte: so no dates and no timings.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FilmMetadata {
    /// World space to camera space: x right, y up, z forward (left-handed, as in OpenEXR's standard attribute
    /// `worldToCamera`). Column vectors here; the file stores the row-vector form.
    pub world_to_camera: DMat4,
    /// World space to OpenEXR's `worldToNDC`: after the division by w, (0, 0) is the upper left and (1, 1) the lower
    /// right corner of the display window. `None` if the camera is not a projection.
    pub world_to_ndc: Option<DMat4>,
    /// Samples per pixel; the rounded average if tiles have different numbers.
    pub spp: u32,
    /// Estimated relative error of an image that was rendered until it was good enough or the time was
    /// up (`render::Progressive::error`).
    pub relative_error: Option<f64>,
    /// Seed of the sampler.
    pub seed: u64,
    /// Name of the scene file, without folders.
    pub scene: String,
    /// Name of the lens file; `None` without a traced lens.
    pub lens: Option<String>,
    /// Program and version, such as `fstop 0.1.0`.
    pub software: String,
}
