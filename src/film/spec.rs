//! The `Film "image"` directive.

use super::sensor::SensorPreset;
use super::{LayerSet, PixelBounds, Tile};
use crate::math::UVec2;
use crate::params::{NamedFile, ParamReader};
use std::path::PathBuf;

/// Maximum width or height in pixels: four times an 8K panorama's.
const MAX_SIDE: i64 = 1 << 16;

/// Maximum number of pixels rendered at once; their statistics then take 15 GB.
const MAX_PIXELS: usize = 1 << 28;

/// The film as specified in the scene file (docs/scene-language.md §3.2).
///
/// | parameter | type | default | meaning |
/// |---|---|---|---|
/// | `filename` | string | `pbrt.exr` | relative to the working directory |
/// | `xresolution`, `yresolution` | integer | 1280 × 720 (pbrt-v2: 640 × 480) | pixels |
/// | `cropwindow` | float×4 | 0 1 0 1 | x0 x1 y0 y1 as fractions of the image |
/// | `diagonal` | float | 35 | mm, for the realistic camera |
/// | `sensor` | string | the camera's | name of a [`SensorPreset`], whose pixels and size are the defaults; not in pbrt-v3 |
/// | `whiteluminance` | float | none | cd/m² that the pixel value (1, 1, 1) represents; written to the file; not in pbrt-v3 |
/// | `scale` | float | 1 | multiplies the finished pixel |
/// | `maxsampleluminance` | float | infinite | brighter samples are scaled down to it |
/// | `aov` | string list | none | [layers](super::Layer) of the image, each by itself or between commas; not in pbrt-v3 |
#[derive(Clone, Debug, PartialEq)]
pub struct FilmSpec {
    /// Output file as named by the scene; see [`output`](Self::output).
    pub filename: Option<NamedFile>,
    /// Width and height of the full image in pixels.
    pub resolution: UVec2,
    /// x0, x1, y0, y1 as fractions of the image, each in 0…1 and in order.
    pub crop_window: [f64; 4],
    /// Diagonal of the full image on the film in mm.
    pub diagonal_mm: f64,
    /// Factor applied to the finished pixel.
    pub scale: f32,
    /// Luminance that the pixel value (1, 1, 1) represents, cd/m², where the scene says so.
    pub white_luminance: Option<f32>,
    /// Limit on a sample's luminance, before the camera's weight.
    pub max_sample_luminance: f32,
    /// What the image keeps besides colors.
    pub layers: LayerSet,
}

/// Why a film's dimensions are invalid.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FilmError {
    /// Not four finite numbers.
    #[error("a crop window is four numbers x0 x1 y0 y1 between 0 and 1")]
    CropWindow,
    /// No pixel lies inside the crop window.
    #[error("the crop window {0:?} holds no pixel of a {1}×{2} image")]
    EmptyCrop([f64; 4], u32, u32),
    /// Too many pixels for memory.
    #[error("an image of {0} pixels is more than this program takes (at most {MAX_PIXELS})")]
    TooManyPixels(usize),
}

impl Default for FilmSpec {
    fn default() -> FilmSpec {
        FilmSpec {
            filename: None,
            resolution: UVec2::new(1280, 720),
            crop_window: [0.0, 1.0, 0.0, 1.0],
            diagonal_mm: 35.0,
            scale: 1.0,
            white_luminance: None,
            max_sample_luminance: f32::INFINITY,
            layers: LayerSet::NONE,
        }
    }
}

impl FilmSpec {
    /// Reads a `Film` directive. Invalid values are reported as errors and replaced by defaults, so that the rest of
    /// the file is still checked. The `camera` may name the sensor as well.
    pub fn from_params(reader: &ParamReader, camera: Option<&'static SensorPreset>) -> FilmSpec {
        let defaults = FilmSpec::default();
        reader.accept("display");
        let own = SensorPreset::from_params(reader);
        if let (Some(own), Some(camera)) = (own, camera)
            && own != camera
        {
            let message = format!(
                "the film has the sensor \"{}\" and the camera \"{}\": leave one out",
                own.name, camera.name
            );
            reader.error("sensor", message);
        }
        let sensor = own.or(camera);
        let pixels = sensor.map_or(defaults.resolution, |sensor| sensor.resolution);
        let resolution = UVec2::new(
            side(reader, "xresolution", pixels.x),
            side(reader, "yresolution", pixels.y),
        );
        let diagonal = sensor.map(|sensor| sensor.diagonal_mm(resolution));
        let mut film = FilmSpec {
            filename: filename(reader),
            resolution,
            diagonal_mm: positive(reader, "diagonal", diagonal.unwrap_or(defaults.diagonal_mm)),
            scale: positive(reader, "scale", 1.0) as f32,
            white_luminance: { reader.find_float("whiteluminance") }
                .map(|_| positive(reader, "whiteluminance", 1.0) as f32),
            max_sample_luminance: positive(reader, "maxsampleluminance", f64::INFINITY) as f32,
            layers: layers(reader),
            ..defaults
        };
        if let Some(window) = reader.floats("cropwindow")
            && let Err(error) = film.set_crop(window)
        {
            reader.error("cropwindow", error.to_string());
        }
        if let Err(error) = film.check() {
            reader.error("xresolution", error.to_string());
            film.resolution = defaults.resolution;
        }
        film
    }

    /// The file to write: the one named, or pbrt's default `pbrt.exr`.
    pub fn output(&self) -> PathBuf {
        let named = self.filename.as_ref().map(|file| file.path.clone());
        named.unwrap_or_else(|| PathBuf::from("pbrt.exr"))
    }

    /// Replaces the crop window (`--crop`, `cropwindow`): x0, x1, y0, y1, each clamped to 0…1 and sorted.
    ///
    /// # Errors
    /// Fails, leaving the film unchanged, if there are not four numbers, one is not finite, or no pixel is left.
    pub fn set_crop(&mut self, window: &[f64]) -> Result<(), FilmError> {
        let &[a, b, c, d] = window else {
            return Err(FilmError::CropWindow);
        };
        if window.iter().any(|v| !v.is_finite()) {
            return Err(FilmError::CropWindow);
        }
        let [a, b, c, d] = [a, b, c, d].map(|v| v.clamp(0.0, 1.0));
        let cropped = FilmSpec {
            crop_window: [a.min(b), a.max(b), c.min(d), c.max(d)],
            ..self.clone()
        };
        cropped.check()?;
        *self = cropped;
        Ok(())
    }

    /// Reduces width and height to a quarter, for a quick look (`--quick`); at least one pixel. A crop window that then
    /// contains no pixel is removed.
    pub fn make_quick(&mut self) {
        self.resolution = (self.resolution / 4).max(UVec2::ONE);
        if self.check().is_err() {
            self.crop_window = [0.0, 1.0, 0.0, 1.0];
        }
    }

    /// Reduces the image, keeping its proportions, if it has more than `pixels` pixels.
    pub fn shrink(&mut self, pixels: u32) {
        let size = self.resolution.as_dvec2();
        let factor = (f64::from(pixels) / (size.x * size.y)).sqrt();
        if factor < 1.0 {
            self.resolution = (size * factor).round().as_uvec2().max(UVec2::ONE);
            if self.check().is_err() {
                self.crop_window = [0.0, 1.0, 0.0, 1.0];
            }
        }
    }

    /// The pixels to render: pbrt's rule, ceil(resolution × fraction) at both ends, in single precision as in pbrt
    /// (0.07 of 100 pixels is 7 there, but 7.000000000000001 in double).
    pub fn pixel_bounds(&self) -> PixelBounds {
        let edge =
            |resolution: u32, fraction: f64| (resolution as f32 * fraction as f32).ceil() as u32;
        let [x0, x1, y0, y1] = self.crop_window;
        let UVec2 { x, y } = self.resolution;
        PixelBounds::new(
            UVec2::new(edge(x, x0), edge(y, y0)),
            UVec2::new(edge(x, x1), edge(y, y1)),
        )
    }

    /// An empty tile for the part of `bounds` inside the crop window.
    pub fn tile(&self, bounds: PixelBounds) -> Tile {
        let inside = bounds.intersection(self.pixel_bounds());
        Tile::new(inside, self.max_sample_luminance).with_layers(self.layers)
    }

    /// # Errors
    /// Fails if there are no pixels, or too many.
    pub fn check(&self) -> Result<(), FilmError> {
        let bounds = self.pixel_bounds();
        if bounds.is_empty() {
            return Err(FilmError::EmptyCrop(
                self.crop_window,
                self.resolution.x,
                self.resolution.y,
            ));
        }
        let longest = i64::from(self.resolution.max_element());
        if longest > MAX_SIDE || bounds.area() > MAX_PIXELS {
            return Err(FilmError::TooManyPixels(bounds.area()));
        }
        Ok(())
    }
}

/// The file to write, which need not exist; relative to the working directory as in pbrt.
fn filename(reader: &ParamReader) -> Option<NamedFile> {
    let path = PathBuf::from(reader.find_string("filename").filter(|n| !n.is_empty())?);
    let span = reader.strings("filename")?.first()?.span;
    Some(NamedFile { path, span })
}

/// `aov`: the names of layers, in one string or several.
fn layers(reader: &ParamReader) -> LayerSet {
    let lists = reader.strings("aov").unwrap_or_default();
    let lists: Vec<&str> = lists.iter().map(|list| list.text.as_str()).collect();
    if lists.is_empty() {
        return LayerSet::NONE;
    }
    LayerSet::parse(&lists.join(",")).unwrap_or_else(|error| {
        reader.error("aov", error);
        LayerSet::NONE
    })
}

/// A width or height in pixels.
fn side(reader: &ParamReader, name: &str, default: u32) -> u32 {
    let pixels = reader.integer(name, i64::from(default));
    match u32::try_from(pixels) {
        Ok(n) if (1..=MAX_SIDE).contains(&pixels) => n,
        _ => {
            reader.error(
                name,
                format!("an image is 1 to {MAX_SIDE} pixels wide and high, not {pixels}"),
            );
            default
        }
    }
}

/// A positive number; infinity only if it is the default.
fn positive(reader: &ParamReader, name: &str, default: f64) -> f64 {
    let value = reader.float(name, default);
    // Rounded to 0 or infinity in single precision, it would not be the number requested.
    if value as f32 > 0.0 && ((value as f32).is_finite() || default.is_infinite()) {
        return value;
    }
    reader.error(name, format!("`{name}` must be above 0, not {value}"));
    default
}

#[cfg(test)]
mod tests {
    use super::*;

    fn film(x: u32, y: u32) -> FilmSpec {
        FilmSpec {
            resolution: UVec2::new(x, y),
            ..FilmSpec::default()
        }
    }

    fn corners(film: &FilmSpec) -> [u32; 4] {
        let b = film.pixel_bounds();
        [b.min.x, b.max.x, b.min.y, b.max.y]
    }

    #[test]
    fn crop_edges_round_up() {
        let mut f = film(100, 50);
        assert_eq!(corners(&f), [0, 100, 0, 50]);
        f.set_crop(&[0.07, 0.501, 0.1, 0.1201]).unwrap();
        assert_eq!(corners(&f), [7, 51, 5, 7]);
    }

    #[test]
    fn neighboring_crops_tile_the_image() {
        let cuts = [0.0, 0.07, 0.1, 1.0 / 3.0, 0.5, 0.77, 1.0];
        let mut next = 0;
        for pair in cuts.windows(2) {
            let mut f = film(97, 1);
            f.set_crop(&[pair[0], pair[1], 0.0, 1.0]).unwrap();
            let [x0, x1, ..] = corners(&f);
            assert_eq!(x0, next);
            next = x1;
        }
        assert_eq!(next, 97);
    }

    #[test]
    fn crop_is_clamped_and_sorted() {
        let mut f = film(10, 10);
        f.set_crop(&[7.0, 0.5, -3.0, 0.2]).unwrap();
        assert_eq!(f.crop_window, [0.5, 1.0, 0.0, 0.2]);
    }

    #[test]
    fn useless_crops_are_errors_and_change_nothing() {
        let mut f = film(10, 10);
        for bad in [
            &[0.5, 0.5, 0.0, 1.0][..],
            &[0.0, 1.0, f64::NAN, 1.0],
            &[0.0, 1.0],
            &[2.0, 3.0, 0.0, 1.0],
        ] {
            assert!(f.set_crop(bad).is_err(), "{bad:?}");
        }
        assert_eq!(f, film(10, 10));
    }

    #[test]
    fn quick_is_a_quarter_but_never_nothing() {
        let mut f = film(103, 3);
        f.make_quick();
        assert_eq!(f.resolution, UVec2::new(25, 1));
        f.set_crop(&[0.0, 1.0, 0.0, 1.0]).unwrap();
    }

    #[test]
    fn absurd_images_are_refused() {
        assert!(film(65536, 65536).check().is_err());
        assert!(film(16384, 16384).check().is_ok());
    }
}
