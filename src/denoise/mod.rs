//! Images without their noise, by Intel's Open Image Denoise, if that library is on the machine (`render --denoise`). It is
//! looked for when it is asked for: fstop does not contain it.

mod library;

use crate::film::{Image, Layer};
use crate::math::Rgb;
use library::{Filter, Library};

/// Why there is no denoised image.
#[derive(Debug, thiserror::Error)]
pub enum DenoiseError {
    /// No library of the names that it may have.
    #[error(
        "--denoise: Open Image Denoise is not on this machine (looked for {looked_for}: {reason}); install it \
         (https://www.openimagedenoise.org, or `pip install pyoidn`), and if it is elsewhere set FSTOP_OIDN_LIBRARY to its file, \
         such as …/lib/libOpenImageDenoise.so.2"
    )]
    Missing {
        /// Names, between commas.
        looked_for: String,
        /// What the system said of the last.
        reason: String,
    },
    /// What the library said.
    #[error("--denoise: Open Image Denoise: {0}")]
    Failed(String),
}

/// The library, ready to work.
#[derive(Debug)]
pub struct Denoiser {
    library: Library,
}

impl Denoiser {
    /// Finds it: the file that `FSTOP_OIDN_LIBRARY` names, or where the system has libraries.
    ///
    /// # Errors
    /// No such library, or none that works here.
    pub fn find() -> Result<Denoiser, DenoiseError> {
        let library = Library::find()?;
        Ok(Denoiser { library })
    }

    /// What it is, with its version.
    #[must_use]
    pub fn name(&self) -> String {
        self.library.name()
    }

    /// The image without its noise, by itself: of variances and layers it has none. Where it has the layers `albedo` and
    /// `normal`, edges are found by these, from which noise is taken first
    /// (the library's documentation, "Prefiltering").
    ///
    /// # Errors
    /// What the library says, such as that there is not enough memory.
    pub fn denoised(&self, image: &Image, threads: usize) -> Result<Image, DenoiseError> {
        let size = image.bounds.size();
        let device = self.library.device(threads)?;
        let layer = |layer| image.layers.mean(layer);
        let clean = |name: &str, values: &[Rgb]| {
            let filter = Filter {
                inputs: &[(name, values)],
                is_hdr: false,
                has_clean_features: false,
            };
            device.run(&filter, name, size)
        };
        let albedo = { layer(Layer::Albedo) }.map(|own| clean("albedo", &own.triples()));
        let normal = { layer(Layer::Normal) }.map(|own| clean("normal", &own.triples()));
        let (albedo, normal) = (albedo.transpose()?, normal.transpose()?);
        let mut inputs = vec![("color", image.pixels.as_slice())];
        inputs.extend({ albedo.as_deref() }.map(|albedo| ("albedo", albedo)));
        // Normals are used beside albedo only.
        inputs.extend({ normal.as_deref().filter(|_| albedo.is_some()) }.map(|n| ("normal", n)));
        let filter = Filter {
            inputs: &inputs,
            is_hdr: true,
            has_clean_features: inputs.len() > 1,
        };
        Ok(Image {
            resolution: image.resolution,
            bounds: image.bounds,
            pixels: device.run(&filter, "output", size)?,
            variance: None,
            independent: None,
            layers: Default::default(),
        })
    }
}
