//! What files a frame's image goes to.

use super::check_place;
use crate::film;
use crate::output::{OutputError, check_apart, check_room, numbered, same_file};
use crate::scene::Frame;
use crate::syntax::{Diagnostic, Diagnostics, SourceMap};
use std::path::{Path, PathBuf};

/// Names of files that the caller chooses.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct OutputNames {
    /// The image, `.exr`, `.png`, `.pfm` or `.tga`; `None` for what the scene's `Film` names. Later frames of a scene get
    /// their number added.
    pub image: Option<PathBuf>,
    /// A PNG beside it.
    pub png: Option<PathBuf>,
    /// Of each also one without noise, as `image.denoised.exr`.
    pub denoised: bool,
}

/// The files of one frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Outputs {
    image: PathBuf,
    png: Option<PathBuf>,
    has_denoised: bool,
}

impl Outputs {
    fn new(names: &OutputNames, frame: &Frame, number: usize) -> Outputs {
        let of_frame = |path: &PathBuf| numbered(path, number);
        let image = names.image.as_ref().map(of_frame);
        Outputs {
            image: image.unwrap_or_else(|| frame.options.film.output()),
            png: names.png.as_ref().map(of_frame),
            has_denoised: names.denoised,
        }
    }

    /// The image's file.
    pub fn image(&self) -> &Path {
        &self.image
    }

    fn same_image(&self, other: &Outputs) -> bool {
        same_file(&self.image, &other.image)
    }

    /// Checks, as far as that is known before rendering, that all of them, of `pixels` pixels, can be written.
    fn check(&self, pixels: usize) -> Result<(), Box<Diagnostic>> {
        let denoised: Vec<_> = self.denoised().collect();
        for path in self.paths().chain(denoised.iter().map(PathBuf::as_path)) {
            film::check_output(path).map_err(|e| Box::new(cannot_write(&e)))?;
            // Three channels of four bytes; files are packed, to half of that at best.
            let needed = pixels as u64 * 12 / 2;
            check_room(path, needed).map_err(|e| Box::new(cannot_write(&e.into())))?;
        }
        let Some(png) = &self.png else { return Ok(()) };
        check_png(png).map_err(|message| Box::new(Diagnostic::error(message)))?;
        if same_file(png, &self.image) {
            let png = png.display();
            let message = format!("--png {png}: the image itself is written there already");
            return Err(Diagnostic::error(message).into());
        }
        Ok(())
    }

    /// Returns `true` if one of the files can hold the variances of pixels.
    pub fn keep_variances(&self) -> bool {
        self.paths().any(film::keeps_variances)
    }

    /// Those of the images without noise, if there are to be any.
    pub fn denoised(&self) -> impl Iterator<Item = PathBuf> {
        let wanted = self.paths().filter(|_| self.has_denoised);
        wanted.map(|path| {
            let ending = path.extension().unwrap_or_default().to_string_lossy();
            path.with_extension(format!("denoised.{ending}"))
        })
    }

    /// The image, then the PNG beside it.
    pub fn paths(&self) -> impl Iterator<Item = &Path> {
        [Some(self.image.as_path()), self.png.as_deref()]
            .into_iter()
            .flatten()
    }
}

/// Refuses a name that is none of a PNG.
pub(crate) fn check_png(png: &Path) -> Result<(), String> {
    let is_png = { png.extension() }.is_some_and(|e| e.eq_ignore_ascii_case("png"));
    let message = || format!("--png {}: expected a name ending in .png", png.display());
    is_png.then_some(()).ok_or_else(message)
}

/// The files of all frames. Two frames that name the same image get one each, which pbrt-v3 does not do: there the last
/// one is all that is left.
pub(super) fn of_frames(
    names: &OutputNames,
    frames: &[Frame],
    diagnostics: &Diagnostics,
) -> Vec<Outputs> {
    let mut all: Vec<Outputs> = Vec::with_capacity(frames.len());
    for (number, frame) in (1..).zip(frames) {
        let mut outputs = Outputs::new(names, frame, number);
        if all.iter().any(|earlier| earlier.same_image(&outputs)) {
            outputs.image = free(&outputs.image, number, &all);
            let message = format!(
                "an earlier frame is written to this file: `{}` is used for frame {number}",
                outputs.image.display()
            );
            let diagnostic = Diagnostic::warning(message);
            diagnostics.push(match &frame.options.film.filename {
                Some(file) => diagnostic.at(file.span),
                None => diagnostic,
            });
        }
        all.push(outputs);
    }
    all
}

/// A name of an image with a number, `number` or the next that no earlier frame has.
fn free(image: &Path, number: usize, earlier: &[Outputs]) -> PathBuf {
    let is_taken = |path: &Path| earlier.iter().any(|one| same_file(&one.image, path));
    let mut number = number;
    while is_taken(&numbered(image, number)) {
        number += 1;
    }
    numbered(image, number)
}

/// Reports outputs that cannot be written; where the scene names them, at that place.
pub(super) fn check(
    names: &OutputNames,
    frames: &[Frame],
    outputs: &[Outputs],
    sources: &SourceMap,
    diagnostics: &Diagnostics,
) {
    for (frame, outputs) in frames.iter().zip(outputs) {
        let pixels = frame.options.film.pixel_bounds().area();
        let integrator = &frame.options.integrator;
        if !integrator.spec.strategies().is_empty() && !outputs.keep_variances() {
            let message = "only .exr files keep the images of strategies";
            let warning = Diagnostic::warning(message);
            diagnostics.push(match integrator.place {
                Some(place) => warning.at(place),
                None => warning,
            });
        }
        let named = frame.options.film.filename.as_ref();
        let named = named.filter(|_| names.image.is_none());
        if let Some(file) = named {
            check_place(file, sources, diagnostics);
        }
        if let Some(file) = named
            && let Err(error) = film::check_output(&file.path)
        {
            diagnostics.push(cannot_write(&error).at(file.span));
        } else if let Err(error) = outputs.check(pixels) {
            diagnostics.push(*error);
        }
    }
    if diagnostics.errors() == 0
        && let Err(error) = apart(outputs, &sources.files_read())
    {
        diagnostics.push(cannot_write(&error.into()));
    }
}

/// Checks that all files of all frames are different, and none of those that are read.
fn apart(outputs: &[Outputs], read: &[PathBuf]) -> Result<(), OutputError> {
    let images = outputs.iter().flat_map(Outputs::paths).map(Path::to_owned);
    let denoised = outputs.iter().flat_map(Outputs::denoised);
    let written: Vec<PathBuf> = images.chain(denoised).collect();
    check_apart(&written, read)
}

fn cannot_write(error: &film::WriteError) -> Diagnostic {
    Diagnostic::error(error.to_string()).failed_if(error.is_failure())
}
