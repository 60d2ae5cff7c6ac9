//! Spectrum-valued parameters: `rgb`, `xyz`, `blackbody` and `spectrum` to linear RGB.

use super::{Dialect, ParamReader};
use crate::assets::spd;
use crate::math::spectrum::{rgb_from_blackbody, rgb_from_samples};
use crate::math::{Rgb, color};
use crate::syntax::files;
use crate::syntax::{Diagnostic, Name, Param, ParamType, ParamValue};
use std::cell::RefCell;
use std::collections::HashMap;
use std::path::PathBuf;

/// The `.spd` files read so far, so that a metal used a thousand times is read once. Those that
/// could not be read are remembered too.
#[derive(Debug, Default)]
pub struct SpectrumFiles {
    read: RefCell<HashMap<PathBuf, Result<Rgb, String>>>,
}

impl SpectrumFiles {
    /// None read so far.
    pub fn new() -> Self {
        Self::default()
    }

    fn rgb(&self, path: PathBuf) -> Result<Rgb, String> {
        let mut read = self.read.borrow_mut();
        let entry = read.entry(path).or_insert_with_key(|path| {
            spd::read(path)
                .map(|s| rgb_from_samples(&s))
                .map_err(|error| error.to_string())
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
        (ParamType::Blackbody, &[kelvin, scale]) => {
            let normalisation = match dialect {
                Dialect::V2 => peak_over_555_nm(kelvin),
                Dialect::V3 => 1.0,
            };
            rgb_from_blackbody(kelvin) * (scale * normalisation) as f32
        }
        (_, &[r, g, b]) => Rgb::new(r as f32, g as f32, b as f32),
        _ => Rgb::ZERO,
    }
}

/// Planck's curve at its peak over its value at 555 nm: pbrt-v2 normalises to the latter
/// (scene-language A.3), pbrt-v3 and our conversion to the former. 1 where there is no curve.
///
/// B(λ) ∝ λ⁻⁵ / (exp(c₂/(λT)) − 1), and the peak is at λT = b (Wien). Constants: CODATA 2018.
fn peak_over_555_nm(kelvin: f64) -> f64 {
    // Second radiation constant and Wien's displacement constant, m·K.
    const C2: f64 = 1.438_776_877e-2;
    const WIEN: f64 = 2.897_771_955e-3;
    if !(kelvin > 0.0 && kelvin.is_finite()) {
        return 1.0;
    }
    // λT is what both exponents depend on; their ratio to the fifth power is what λ⁻⁵ leaves.
    let at_555 = 555e-9 * kelvin;
    let ratio = at_555 / WIEN;
    let ratio =
        ratio * ratio * ratio * ratio * ratio * libm::expm1(C2 / at_555) / libm::expm1(C2 / WIEN);
    // Below some 40 K the curve is nothing at 555 nm.
    if ratio.is_finite() { ratio } else { 1.0 }
}

fn inline(reader: &ParamReader<'_>, param: &Param, numbers: &[f64]) -> Rgb {
    match spd::samples(numbers) {
        Ok(samples) => rgb_from_samples(&samples),
        Err(error) => {
            reader.context.diagnostics.push(
                Diagnostic::error(format!("`{}` is no spectrum: {error}", param.name))
                    .at(param.value_span)
                    .label("black is used to read on"),
            );
            Rgb::ZERO
        }
    }
}

fn from_file(reader: &ParamReader<'_>, name: &Name) -> Rgb {
    let read = match files::resolve(reader.context.directory, &name.text) {
        Some(path) => reader.context.spectra.rgb(path),
        None => Err("there is no such file".to_owned()),
    };
    read.unwrap_or_else(|error| {
        reader.context.diagnostics.push(
            Diagnostic::error(format!(
                "cannot use the spectrum file `{}`: {error}",
                name.text
            ))
            .at(name.span)
            .label("black is used to read on"),
        );
        Rgb::ZERO
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// At T = b/555 nm (5221 K) the peak is at 555 nm and the two normalisations agree.
    #[test]
    fn the_normalisations_agree_where_the_peak_is_at_555_nm() {
        // Rounding of two exponentials.
        assert!((peak_over_555_nm(2.897_771_955e-3 / 555e-9) - 1.0).abs() < 1e-12);
        // Elsewhere the peak is higher than any other place of the curve, by definition.
        for kelvin in [500.0, 2000.0, 2856.0, 6500.0, 20_000.0] {
            assert!(peak_over_555_nm(kelvin) > 1.0, "{kelvin}");
        }
        assert_eq!(peak_over_555_nm(0.0), 1.0);
        assert_eq!(peak_over_555_nm(1e-300), 1.0);
    }
}
