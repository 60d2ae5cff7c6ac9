//! A finished image in memory.

use super::{ImageLayers, PixelBounds};
use crate::math::{Rgb, UVec2};

/// Linear RGB of the pixels inside `bounds`, with the variance of each if it is known.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// Width and height of the full image (EXR's display window).
    pub resolution: UVec2,
    /// The pixels stored here (EXR's data window).
    pub bounds: PixelBounds,
    /// Row by row from the top left of `bounds`.
    pub pixels: Vec<Rgb>,
    /// Variance of each value in `pixels`, in the same order: that of its scatter from render to render. Infinite if
    /// unknown.
    pub variance: Option<Vec<Rgb>>,
    /// Where neighbors share a factor in their variances ([`FilmMetadata::pool`](super::FilmMetadata::pool)): these without it, as if
    /// samples were independent. Too large, but known for each pixel by itself.
    pub independent: Option<Vec<Rgb>>,
    /// What was asked for besides. Of an image that was read, none.
    pub layers: ImageLayers,
}

impl Image {
    /// A black image without a crop window.
    pub fn black(resolution: UVec2) -> Image {
        let bounds = PixelBounds::new(UVec2::ZERO, resolution);
        Image {
            resolution,
            bounds,
            pixels: vec![Rgb::ZERO; bounds.area()],
            variance: None,
            independent: None,
            layers: ImageLayers::default(),
        }
    }

    /// The value at `pixel` (full-image coordinates); black outside `bounds`.
    pub fn pixel(&self, pixel: UVec2) -> Rgb {
        self.bounds
            .index(pixel)
            .and_then(|i| self.pixels.get(i))
            .copied()
            .unwrap_or(Rgb::ZERO)
    }

    /// The row of pixels `y` rows below the top of `bounds`.
    pub(super) fn row(&self, y: usize) -> &[Rgb] {
        let width = self.bounds.size().x as usize;
        self.pixels.get(y * width..(y + 1) * width).unwrap_or(&[])
    }
}
