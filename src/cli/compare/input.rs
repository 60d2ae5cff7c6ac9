//! Images to compare, from files of any supported format.

use crate::assets::image_data::{Encoding, ImageData};
use crate::budget::Budget;
use crate::cli::messages::{self, Failure};
use crate::compare::Estimate;
use crate::film::{self, Image, LoadedImage, PixelBounds, ReadError};
use crate::math::color::linear_from_srgb;
use crate::math::{Rgb, UVec2};
use std::path::{Path, PathBuf};

/// An image with its file's properties.
pub(in crate::cli) struct Input {
    pub(in crate::cli) path: PathBuf,
    pub(in crate::cli) loaded: LoadedImage,
    /// Values were decoded from sRGB: 8 or 16 bits, nothing brighter than white.
    pub(in crate::cli) srgb: bool,
    /// Colors share an exponent and have eight bits each (Radiance).
    is_coarse: bool,
    /// The file records which part of the full image it holds.
    windowed: bool,
}

impl Input {
    /// An image that has been written to an EXR file.
    pub(in crate::cli) fn of(path: &Path, loaded: LoadedImage) -> Input {
        Input {
            path: path.to_owned(),
            loaded,
            srgb: false,
            is_coarse: false,
            windowed: true,
        }
    }

    /// With its file moved.
    pub(in crate::cli) fn renamed(self, path: &Path) -> Result<Input, Failure> {
        let moved = std::fs::rename(&self.path, path);
        let failed = |e| Failure::new(format!("{}: cannot write: {e}", path.display()), true);
        moved.map_err(failed)?;
        Ok(Input {
            path: path.to_owned(),
            ..self
        })
    }

    /// Its data window, where that is not the display window.
    fn window(&self) -> String {
        let (bounds, display) = (self.loaded.image.bounds, self.loaded.display);
        let resolution = self.loaded.image.resolution;
        let whole = PixelBounds::new(display, display + resolution);
        if bounds == whole {
            return String::new();
        }
        if bounds.intersection(whole) == bounds {
            return format!(" of a crop window ({})", crate::compare::extent(bounds));
        }
        let from = |at: u32, origin: u32| i64::from(at) - i64::from(origin);
        let side = |min: UVec2, max: UVec2, of: fn(UVec2) -> u32| {
            let origin = of(display);
            format!("{}..{}", from(of(min), origin), from(of(max), origin))
        };
        let [x, y] =
            [|at: UVec2| at.x, |at: UVec2| at.y].map(|of| side(bounds.min, bounds.max, of));
        let counted = match display {
            UVec2::ZERO => "",
            _ => "; pixels are counted from the data window's edge",
        };
        format!(
            " of a data window (x {x} y {y}) beyond the display window of {} × {} (overscan{counted})",
            resolution.x, resolution.y
        )
    }

    /// Without what the file of a mean does not keep: images of a suite and references, which may be means or not, are not told apart
    /// by it.
    pub(in crate::cli) fn plain(mut self) -> Input {
        (self.loaded.display, self.loaded.primaries) = (UVec2::ZERO, None);
        self
    }

    /// A short description of the file.
    pub(in crate::cli) fn describe(&self) -> String {
        let size = self.loaded.image.bounds.size();
        let mut words = format!("{} × {} pixels", size.x, size.y);
        words += &self.window();
        if let Some(spp) = self.loaded.spp {
            words += &format!(", {spp} samples a pixel");
        }
        if let Some(runs) = self.loaded.runs.filter(|&runs| runs > 1) {
            words += &format!(" in each of {runs} runs");
        }
        let is_known = Estimate::of(&self.loaded).has_variance();
        words += match (&self.loaded.image.variance, self.loaded.spp) {
            (Some(_), _) if is_known => ", with variances",
            (Some(_), Some(1)) => ", which tells no variances: that takes two",
            (Some(_), _) => ", with variances that are not known",
            (None, _) => ", without variances",
        };
        if let Some(by) = &self.loaded.denoised {
            words += &format!(", denoised by {by}");
        }
        if self.loaded.from_xyz {
            words += ", converted from X, Y and Z";
        }
        if self.srgb {
            words += ", decoded from sRGB";
        }
        if self.is_coarse {
            words +=
                ", of 8 bits a color with one exponent: by rounding alone up to 0.8 % too dark";
        }
        words
    }
}

/// Reads both images. Formats that do not record a crop window take the other's if they have as many pixels.
pub(in crate::cli) fn read_pair(a: &Path, b: &Path) -> Result<[Input; 2], Failure> {
    Ok(pair(read(a)?, read(b)?))
}

/// Both images; one that does not know its crop window takes the other's if it has as many pixels.
pub(in crate::cli) fn pair(mut a: Input, mut b: Input) -> [Input; 2] {
    take_window(&mut a, &b);
    take_window(&mut b, &a);
    [a, b]
}

fn take_window(input: &mut Input, other: &Input) {
    let (image, from) = (&mut input.loaded.image, &other.loaded.image);
    if !input.windowed && other.windowed && image.bounds.size() == from.bounds.size() {
        (image.bounds, image.resolution) = (from.bounds, from.resolution);
    }
}

/// Reads an image of any format.
pub(in crate::cli) fn read(path: &Path) -> Result<Input, Failure> {
    let budget = Budget::new(None);
    match film::read_within(path, &budget) {
        Ok(loaded) => {
            if loaded.denoised.is_some() {
                let path = path.display();
                messages::warning(format!(
                    "{path} was denoised: it is a guess and no estimate, so whether it agrees says nothing of the renderer"
                ));
            }
            return Ok(Input {
                path: path.to_owned(),
                loaded,
                srgb: false,
                is_coarse: false,
                windowed: true,
            });
        }
        Err(error @ (ReadError::Window(_) | ReadError::Partial { .. })) => {
            return Err(error.to_string().into());
        }
        // Another format, or no image: that says why.
        Err(_) => {}
    }
    let image = ImageData::load(path, &budget)?;
    let size = [image.width, image.height].map(|n| u32::try_from(n).unwrap_or(u32::MAX));
    let resolution = UVec2::from(size);
    let srgb = image.encoding == Encoding::Srgb;
    let decode = |p: &Rgb| if srgb { p.map(linear_from_srgb) } else { *p };
    Ok(Input {
        path: path.to_owned(),
        loaded: LoadedImage::of(Image {
            resolution,
            bounds: PixelBounds::new(UVec2::ZERO, resolution),
            pixels: image.texels().iter().map(decode).collect(),
            variance: None,
            independent: None,
            layers: Default::default(),
        }),
        srgb,
        is_coarse: path
            .extension()
            .is_some_and(|e| e.eq_ignore_ascii_case("hdr")),
        windowed: false,
    })
}

/// What is to be said of both files, whatever their pixels are.
pub(in crate::cli) fn notes(inputs: &[Input; 2]) -> Vec<String> {
    let notes = [clipping(inputs), display_windows(inputs), primaries(inputs)];
    notes.into_iter().flatten().collect()
}

/// Of the same pixels of images that are not the same.
fn display_windows(inputs: &[Input; 2]) -> Option<String> {
    let [a, b] = inputs.each_ref().map(|input| {
        let (image, display) = (&input.loaded.image, input.loaded.display);
        let end = display + image.resolution;
        (image.bounds, PixelBounds::new(display, end))
    });
    (a.0 == b.0 && a.1 != b.1).then(|| {
        let [a, b] = [a.1, b.1].map(crate::compare::extent);
        format!("The display windows differ (A {a}, B {b}): what is compared are the pixels of the data windows, which agree.")
    })
}

/// Of colors that are not those of Rec. 709.
fn primaries(inputs: &[Input; 2]) -> Option<String> {
    let [a, b] = inputs.each_ref().map(|input| input.loaded.primaries);
    let who = match (a, b) {
        (None, None) => return None,
        (Some(_), None) => "A has",
        (None, Some(_)) => "B has",
        (Some(a), Some(b)) if a == b => "Both images have",
        (Some(_), Some(_)) => "Each image has its own",
    };
    let end = match a == b {
        true => "and FLIP and pages take them for Rec. 709's",
        false => {
            "and one color may differ in them: convert one image to the primaries of the other first"
        }
    };
    Some(format!(
        "{who} primaries other than Rec. 709's (attribute chromaticities): the numbers are compared as they are, {end}."
    ))
}

/// What is to be said where an image of a screen's range meets one that is brighter than that somewhere.
fn clipping(inputs: &[Input; 2]) -> Option<String> {
    let [a, b] = inputs;
    let (short, narrow, whole, wide) = match (a.srgb, b.srgb) {
        (true, false) => ("A", a, "B", b),
        (false, true) => ("B", b, "A", a),
        _ => return None,
    };
    let is_white = |p: &&Rgb| p.max_element() > 1.0;
    let pixels = &wide.loaded.image.pixels;
    let count = pixels.iter().filter(is_white).count();
    if count == 0 {
        return None;
    }
    let most = { pixels.iter() }
        .map(|p| p.max_element())
        .fold(0.0, f32::max);
    let share = crate::compare::relative(count as f64 / pixels.len().max(1) as f64);
    Some(format!(
        "{short} ({}) holds nothing brighter than white, which is 1. {whole} is brighter in {share} of its pixels, up to {most:.3}: what \
         differs there is clipping.",
        narrow.path.display()
    ))
}
