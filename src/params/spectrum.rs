//! Spectrum-valued parameters: `rgb`, `xyz`, `blackbody` and `spectrum` to linear RGB.

use super::{Dialect, ParamReader};
use crate::assets::spd;
use crate::files::{FileError, FileProblem};
use crate::math::spectrum::rgb_from_samples;
use crate::math::{Rgb, color};
use crate::syntax::{Diagnostic, Name, Param, ParamType, ParamValue};
use std::cell::RefCell;
use std::collections::HashMap;
use std::path::PathBuf;

/// The `.spd` files read so far, so that a metal used a thousand times is read once. Those that
/// could not be read are remembered too.
#[derive(Debug, Default)]
pub struct SpectrumFiles {
    read: RefCell<HashMap<PathBuf, Result<ReadFile, FileError>>>,
}

/// A file that could be read.
#[derive(Clone, Debug)]
struct ReadFile {
    /// In pbrt-v3's normalization.
    color: Rgb,
    /// See [`spd::SpectrumFile::passed_over`].
    passed_over: Option<String>,
}

impl SpectrumFiles {
    /// None read so far.
    pub fn new() -> Self {
        Self::default()
    }

    fn color(&self, path: PathBuf) -> Result<ReadFile, FileError> {
        let mut read = self.read.borrow_mut();
        let entry = read.entry(path).or_insert_with_key(|path| {
            let file = spd::read(path)?;
            Ok(ReadFile {
                color: rgb_from_samples(&file.samples),
                passed_over: file.passed_over,
            })
        });
        entry.clone()
    }
}

/// The first value of a spectrum parameter, and how many it has: all (wavelength, value) pairs
/// together are one, each file is one.
pub(super) fn first_value(reader: &ParamReader<'_>, param: &Param) -> Option<(Rgb, usize)> {
    match &param.value {
        ParamValue::Numbers(numbers) if param.ty == ParamType::Spectrum => {
            (!numbers.is_empty()).then(|| (inline(reader, param, numbers), 1))
        }
        ParamValue::Numbers(numbers) => {
            reader.check_finite(param, numbers);
            let items = param.ty.items();
            Some((
                converted(reader.dialect(), param.ty, numbers.get(..items)?),
                numbers.len() / items,
            ))
        }
        ParamValue::Strings(names) => Some((from_file(reader, names.first()?), names.len())),
        ParamValue::Bools(_) => None,
    }
}

fn converted(dialect: Dialect, ty: ParamType, numbers: &[f64]) -> Rgb {
    match (ty, numbers) {
        (ParamType::Xyz, &[x, y, z]) => color::rgb_from_xyz(Rgb::new(x as f32, y as f32, z as f32)),
        (ParamType::Blackbody, &[kelvin, scale]) => dialect.of_blackbody(kelvin) * scale as f32,
        (_, &[r, g, b]) => Rgb::new(r as f32, g as f32, b as f32),
        _ => Rgb::ZERO,
    }
}

fn inline(reader: &ParamReader<'_>, param: &Param, numbers: &[f64]) -> Rgb {
    match spd::samples(numbers) {
        Ok(samples) => reader.dialect().of_samples(rgb_from_samples(&samples)),
        Err(error) => {
            reader.context.diagnostics.push(
                reader
                    .new_error(format!("`{}` is no spectrum: {error}", param.name))
                    .at(param.value_span)
                    .label("black is used to read on"),
            );
            Rgb::ZERO
        }
    }
}

fn from_file(reader: &ParamReader<'_>, name: &Name) -> Rgb {
    let path = reader.context.search.regular(&name.text);
    let is_missing = path == Err(FileProblem::Missing);
    let read = path
        .map_err(FileError::from)
        .and_then(|path| reader.context.spectra.color(path));
    let read = read.map(|file| {
        if let Some(what) = file.passed_over {
            let message = format!("the spectrum file `{}`: {what}", name.text);
            let warning = Diagnostic::warning(message).at(name.span);
            reader.context.diagnostics.push(warning);
        }
        reader.dialect().of_samples(file.color)
    });
    read.unwrap_or_else(|error| {
        let diagnostic = Diagnostic::error(format!(
            "cannot use the spectrum file `{}`: {error}",
            name.text
        ))
        .at(name.span)
        .recoverable()
        .failed_if(error.is_failure)
        .label("black is used to read on");
        reader.context.diagnostics.push(if is_missing {
            diagnostic.missing(&name.text)
        } else {
            diagnostic
        });
        Rgb::ZERO
    })
}

#[cfg(test)]
mod tests {
    use crate::math::Rgb;
    use crate::params::testing::{Outcome, Surroundings, read_in};
    use crate::params::{Dialect, ParamReader};

    fn spectrum(dialect: Dialect, params: &str) -> Rgb {
        let surroundings = Surroundings {
            dialect,
            ..Surroundings::default()
        };
        let look_up = |reader: &ParamReader<'_>| reader.find_spectrum("L");
        let Outcome { value, .. } = read_in(&surroundings, "point", params, look_up);
        value.expect("a spectrum")
    }

    /// Scene-language A.3: the flat spectrum 1 has luminance 1 in pbrt-v2 and 470/471 in v3.
    #[test]
    fn sampled_spectra_are_a_471st_brighter_in_v2() {
        let flat = "\"spectrum L\" [400 1 700 1]";
        let ratio = spectrum(Dialect::V2, flat) / spectrum(Dialect::V3, flat);
        // Single-precision rounding of a product.
        assert!(
            (ratio - 471.0 / 470.0).abs().max_element() < 1e-6,
            "{ratio}"
        );
        let rgb = "\"rgb L\" [.1 .2 .3]";
        assert_eq!(spectrum(Dialect::V2, rgb), spectrum(Dialect::V3, rgb));
    }

    /// Scene-language A.3: v3 divides Planck's curve by its peak, v2 by its value at 555 nm, which
    /// is lower wherever the peak lies elsewhere.
    #[test]
    fn blackbodies_are_normalized_at_555_nm_in_v2() {
        let warm = "\"blackbody L\" [2700 3]";
        let (v2, v3) = (spectrum(Dialect::V2, warm), spectrum(Dialect::V3, warm));
        assert_eq!(
            v2,
            3.0 * crate::math::spectrum::rgb_from_blackbody_v2(2700.0)
        );
        assert_eq!(v3, 3.0 * crate::math::spectrum::rgb_from_blackbody(2700.0));
        assert!(v2.cmpgt(v3).all());
    }
}
