//! What a file says about how its image came to be.

use glam::DMat4;

/// Written into the EXR header. Nothing here may differ between two runs of the same command: equal
/// renders are equal files, byte for byte, so no dates and no timings.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FilmMetadata {
    /// World space to camera space: x right, y up, z forward (left-handed, as OpenEXR's standard
    /// attribute `worldToCamera` has it). Column vectors here; the file holds the row-vector form.
    pub world_to_camera: DMat4,
    /// World space to OpenEXR's `worldToNDC`: after the division by w, (0, 0) is the upper left and
    /// (1, 1) the lower right corner of the display window. `None` where the image is no projection.
    pub world_to_ndc: Option<DMat4>,
    /// Samples per pixel; on average, and rounded, where tiles have different numbers.
    pub spp: u32,
    /// Estimated relative error of an image that was rendered until it was good enough or the time was
    /// up (`render::Progressive::error`).
    pub relative_error: Option<f64>,
    /// Seed of the sampler.
    pub seed: u64,
    /// Name of the scene file, without folders.
    pub scene: String,
    /// Name of the lens file, `None` without a traced lens.
    pub lens: Option<String>,
    /// Program and version, such as `fstop 0.1.0`.
    pub software: String,
}
