//! Metadata of an image file: how the image was rendered.

use super::{LightPathUse, Manifest};
use glam::DMat4;
use serde::{Deserialize, Serialize};

/// Metadata written to the EXR header. Nothing here may differ between two runs of the same command, as equal renders
/// are equal files, byte for byte: so no dates and no timings.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FilmMetadata {
    /// World space to camera space: x right, y up, z forward (left-handed, as in OpenEXR's standard attribute
    /// `worldToCamera`). Column vectors here; the file stores the row-vector form. `None` where it is not known.
    pub world_to_camera: Option<DMat4>,
    /// World space to OpenEXR's `worldToNDC`: after the division by w, (0, 0) is the upper left and (1, 1) the lower
    /// right corner of the display window. `None` if the camera is not a projection.
    pub world_to_ndc: Option<DMat4>,
    /// Width of a pixel over its height as the camera sees them; `None` where they are square, or that is not known.
    #[serde(default)]
    pub pixel_aspect: Option<f32>,
    /// Samples per pixel; the rounded average if tiles have different numbers.
    pub spp: u32,
    /// Estimated relative error of an image that was rendered until it was good enough or the time was
    /// up (`render::Progressive::error`).
    pub relative_error: Option<f64>,
    /// The confidence that was asked for, a probability.
    #[serde(default)]
    pub confidence: Option<f64>,
    /// What the true relative error is below with it.
    #[serde(default)]
    pub error_bound: Option<f64>,
    /// Where the image has variances: degrees of freedom of each, as far as the samples of one pixel tell it.
    #[serde(default)]
    pub freedom: Option<f64>,
    /// Side of the squares of pixels whose variances share a factor, of one degree of freedom for each pixel; counted
    /// from the corner of the whole image. `None` if they share none.
    #[serde(default)]
    pub pool: Option<u32>,
    /// How light paths are used; `None` if that is unknown, or the integrator has no light pass (photon mapping, ambient occlusion).
    #[serde(default)]
    pub light_paths: Option<LightPathUse>,
    /// Number of independent renders that the image is the mean of, where there are several; `spp` and `seed` are of the
    /// first. Without `freedom` its variances are those of their scatter.
    #[serde(default)]
    pub runs: Option<u32>,
    /// What has taken the noise out, with its version: such an image is no estimate that has a variance.
    #[serde(default)]
    pub denoised: Option<String>,
    /// The names of what Cryptomattes show.
    #[serde(default)]
    pub manifests: Vec<Manifest>,
    /// What its layers of light are called, of which the image has one for each group of its lights, or for each strategy.
    #[serde(default)]
    pub light_layers: Vec<String>,
    /// Luminance that the pixel value (1, 1, 1) represents, cd/m²; `None` where the scene does not say.
    #[serde(default)]
    pub white_luminance: Option<f32>,
    /// Seed of the sampler.
    pub seed: u64,
    /// Name of the scene file, without folders.
    pub scene: String,
    /// Name of the lens file; `None` without a traced lens.
    pub lens: Option<String>,
    /// How the camera was set; `None` without a traced lens.
    #[serde(default)]
    pub photograph: Option<Photograph>,
    /// Program and version, such as `fstop 0.1.0`.
    pub software: String,
}

/// What a photographer notes of an image. Lengths in mm unless said otherwise; `None` for what there is none of, or is infinite.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Photograph {
    /// Name of the lens' file.
    pub lens: String,
    /// Focal length over the diameter of the entrance pupil.
    pub f_number: Option<f64>,
    /// The f-number of a lens without losses that is as bright in the middle of the film, both focused at infinity.
    pub t_number: Option<f64>,
    /// The same at this focus: the effective f-number.
    pub working_number: Option<f64>,
    /// Focal length at this focus.
    pub focal_length: Option<f64>,
    /// Focal length at this zoom, focused at infinity: what is engraved on a lens.
    #[serde(default)]
    pub nominal_focal_length: Option<f64>,
    /// Angles that the middle row and column of the film see, degrees; `None` where an end of one is dark.
    #[serde(default)]
    pub field_of_view: Option<[f64; 2]>,
    /// From the film to the pinhole with the same view near the axis, at this focus.
    pub pinhole_focal_length: Option<f64>,
    /// From the film to the entrance pupil.
    pub entrance_pupil: Option<f64>,
    /// From the film to the plane of focus, meters.
    pub focus: Option<f64>,
    /// `true` if that plane is infinitely far.
    pub focused_at_infinity: bool,
    /// From the film to the nearest plane that is sharp, meters.
    pub near: Option<f64>,
    /// To the farthest, meters.
    pub far: Option<f64>,
    /// The nearest focus that leaves infinity sharp, from the film, meters.
    pub hyperfocal: Option<f64>,
    /// Seconds.
    pub exposure_time: Option<f64>,
    /// Sensitivity, if one was set.
    pub iso: Option<f64>,
    /// Width and height of the film.
    pub sensor: [f64; 2],
    /// Between the middles of pixels, micrometers.
    pub pixel_pitch: f64,
    /// Of the film's middle from the axis, to the right and up as the image shows it, micrometers.
    pub sensor_offset: [f64; 2],
}
