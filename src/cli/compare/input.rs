//! Images to compare, from files of any supported format.

use crate::assets::image_data::{Encoding, ImageData};
use crate::budget::Budget;
use crate::cli::messages::Failure;
use crate::film::{self, Image, LoadedImage, PixelBounds, ReadError};
use crate::math::color::linear_from_srgb;
use crate::math::{Rgb, UVec2};
use std::path::{Path, PathBuf};

/// An image with its file's properties.
pub(super) struct Input {
    pub path: PathBuf,
    pub loaded: LoadedImage,
    /// Values were decoded from sRGB: 8 or 16 bits, nothing brighter than white.
    pub srgb: bool,
    /// The file records which part of the full image it holds.
    windowed: bool,
}

impl Input {
    /// A short description of the file.
    pub(super) fn describe(&self) -> String {
        let size = self.loaded.image.bounds.size();
        let mut words = format!("{} × {} pixels", size.x, size.y);
        if size != self.loaded.image.resolution {
            let bounds = self.loaded.image.bounds;
            words += &format!(" of a crop window ({})", crate::compare::extent(bounds));
        }
        if let Some(spp) = self.loaded.spp {
            words += &format!(", {spp} samples a pixel");
        }
        if let Some(runs) = self.loaded.runs.filter(|&runs| runs > 1) {
            words += &format!(" in each of {runs} runs");
        }
        words += match self.loaded.image.variance {
            Some(_) => ", with variances",
            None => ", without variances",
        };
        if self.srgb {
            words += ", decoded from sRGB";
        }
        words
    }
}

/// Reads both images. Formats that do not record a crop window take the other's if they have as many pixels.
pub(super) fn read_pair(a: &Path, b: &Path) -> Result<[Input; 2], Failure> {
    let (mut a, mut b) = (read(a)?, read(b)?);
    take_window(&mut a, &b);
    take_window(&mut b, &a);
    Ok([a, b])
}

fn take_window(input: &mut Input, other: &Input) {
    let (image, from) = (&mut input.loaded.image, &other.loaded.image);
    if !input.windowed && other.windowed && image.bounds.size() == from.bounds.size() {
        (image.bounds, image.resolution) = (from.bounds, from.resolution);
    }
}

fn read(path: &Path) -> Result<Input, Failure> {
    let budget = Budget::new(None);
    match film::read_within(path, &budget) {
        Ok(loaded) => {
            return Ok(Input {
                path: path.to_owned(),
                loaded,
                srgb: false,
                windowed: true,
            });
        }
        Err(error @ ReadError::Window(_)) => return Err(error.to_string().into()),
        // Grayscale, with other channel names, or another format.
        Err(_) => {}
    }
    let image = ImageData::load(path, &budget)?;
    let size = [image.width, image.height].map(|n| u32::try_from(n).unwrap_or(u32::MAX));
    let resolution = UVec2::from(size);
    let srgb = image.encoding == Encoding::Srgb;
    let decode = |p: &Rgb| if srgb { p.map(linear_from_srgb) } else { *p };
    Ok(Input {
        path: path.to_owned(),
        loaded: LoadedImage {
            image: Image {
                resolution,
                bounds: PixelBounds::new(UVec2::ZERO, resolution),
                pixels: image.texels().iter().map(decode).collect(),
                variance: None,
            },
            spp: None,
            runs: None,
        },
        srgb,
        windowed: false,
    })
}
