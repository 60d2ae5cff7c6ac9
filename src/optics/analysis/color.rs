//! Color errors: where the hydrogen lines C (red) and F (blue) go instead of d (yellow).

use super::chief::ChiefFinder;
use super::fan::Fan;
use super::longitudinal::FocalShift;
use super::spot::Spot;
use crate::optics::dispersion::{AbbeModel, LINE_C, LINE_F};
use crate::optics::lens::Lens;
use crate::optics::paraxial::Paraxial;
use crate::optics::prescription::Prescription;
use serde::Serialize;

/// Lateral and longitudinal color of a lens whose file tells of dispersion.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Color {
    /// Focal point of F minus that of C, mm: positive where blue focuses farther from the lens.
    pub longitudinal: Option<f64>,
    /// Over the field.
    pub lateral: Vec<LateralColor>,
    /// Focus near the axis over the spectrum; filled in by [`super::LensAnalysis::with_color`].
    pub focal_shift: Vec<FocalShift>,
    /// Spots and fans of other colors, at the heights of those of the d line; filled in by the same.
    pub points: Vec<ColorPoint>,
}

/// What becomes of the beam of one object point in the light of the lines C and F, relative to the chief ray of the d line.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ColorPoint {
    /// C, then F.
    pub spots: [Spot; 2],
    /// C, then F.
    pub fans: [Fan; 2],
}

/// What becomes of the chief ray of one film point.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LateralColor {
    /// Film height at the d line, mm.
    pub height: f64,
    /// Film height of light of the C line from the same direction minus that of d, mm.
    pub red: f64,
    /// The same for the F line.
    pub blue: f64,
}

/// Film heights of the curve.
const HEIGHTS: u32 = 13;

impl Color {
    /// Of the lens with its film `film_distance` mm behind it, up to the film height `edge`; `None` where the file tells nothing.
    /// Directions are those of a distant object.
    pub fn new(prescription: &Prescription, film_distance: f64, edge: f64) -> Option<Color> {
        if !prescription.disperses() {
            return None;
        }
        let at = |wavelength| prescription.at_wavelength(wavelength, AbbeModel::NormalLine);
        let focus = |p: &Prescription| {
            Paraxial::new(&p.surfaces)
                .cardinals
                .map(|c| c.rear_focal_point)
        };
        let (red, blue) = (at(LINE_C), at(LINE_F));
        let lenses = [prescription, &red, &blue].map(|p| Lens::new(p, film_distance).ok());
        let [Some(yellow), Some(red_lens), Some(blue_lens)] = &lenses else {
            return None;
        };
        let [yellow, red_lens, blue_lens] = [yellow, red_lens, blue_lens].map(ChiefFinder::new);
        let lateral = (0..HEIGHTS)
            .map(|i| edge * f64::from(i) / f64::from(HEIGHTS - 1))
            .filter_map(|height| {
                let angle = yellow.find(height)?.signed_angle();
                Some(LateralColor {
                    height,
                    red: height_of(&red_lens, angle, height)? - height,
                    blue: height_of(&blue_lens, angle, height)? - height,
                })
            })
            .collect();
        Some(Color {
            longitudinal: focus(&blue).zip(focus(&red)).map(|(b, r)| b - r),
            lateral,
            focal_shift: Vec::new(),
            points: Vec::new(),
        })
    }
}

/// The film height whose chief ray comes in at this signed field angle, near `guess`: the secant method, as
/// colors land within a fraction of a millimeter of each other.
fn height_of(chief: &ChiefFinder, angle: f64, guess: f64) -> Option<f64> {
    if guess == 0.0 {
        return Some(0.0);
    }
    let error = |h: f64| Some(chief.find(h)?.signed_angle() - angle);
    let (mut a, mut b) = (guess, guess * 1.0001);
    let mut at_a = error(a)?;
    for _ in 0..8 {
        let at_b = error(b)?;
        if at_b == at_a || at_b.abs() < 1e-13 {
            break;
        }
        let next = b - at_b * (b - a) / (at_b - at_a);
        (a, at_a, b) = (b, at_b, next);
    }
    b.is_finite().then_some(b)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_singlet_focuses_blue_nearer_and_an_achromat_hardly() {
        // Change of focal length of a thin lens between F and C: f/V.
        let p =
            Prescription::parse("0 0 0 0 10\n100 1e-6 1.5168 64.17 30\n-100 0 1 0 30\n").unwrap();
        let f = 100.0 / (2.0 * 0.5168);
        let color = Color::new(&p, f, 20.0).unwrap();
        let longitudinal = color.longitudinal.unwrap();
        // To first order in 1/V.
        assert!(
            (longitudinal / (-f / 64.17) - 1.0).abs() < 0.02,
            "{longitudinal}"
        );
        // The stop at the lens: no lateral color.
        for point in &color.lateral {
            assert!(
                point.red.abs() + point.blue.abs() < 1e-6 * 20.0,
                "{point:?}"
            );
        }
        let plain = Prescription::parse("100 1 1.5168 30\n-100 0 1 30\n").unwrap();
        assert_eq!(Color::new(&plain, f, 20.0), None);
    }
}
