//! Longitudinal aberrations: where rays of a point on the axis cross it, by their height in the pupil and by color.
//!
//! Smith, *Modern Optical Engineering*, 4th edition, §5.2 and 5.3. Lengths are millimeters behind the film.

use super::beam::Beam;
use super::object::ObjectPlane;
use crate::optics::dispersion::{AbbeModel, LINE_C, LINE_D, LINE_F};
use crate::optics::lens::Lens;
use crate::optics::paraxial::Paraxial;
use crate::optics::prescription::Prescription;
use crate::optics::surface::Surface;
use serde::Serialize;

/// Where rays of one color cross the axis.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Longitudinal {
    /// µm.
    pub wavelength: f64,
    /// \[height in the beam as a part of its rim, crossing behind the film in mm\].
    pub crossings: Vec<[f64; 2]>,
}

/// Rays from the axis to the rim.
const RAYS: u32 = 32;

impl Longitudinal {
    /// Of `lens`, which is one for `wavelength`; `beam` is that of the axis.
    pub fn new(lens: &Lens, wavelength: f64, beam: &Beam) -> Longitudinal {
        let [_, rim] = beam.rim(lens, 1);
        let crossing = |i: u32| {
            // The first ray is so near to the axis that third order is 1e-6 of the rim's.
            let part = f64::from(i).max(0.03) / f64::from(RAYS);
            // Rounding must not push it beyond the rim.
            let ray = beam.at_film(lens, [0.0, part * rim * (1.0 - 1e-9)])?;
            let crossing = -ray.o[1] * ray.d[2] / ray.d[1];
            crossing.is_finite().then_some([part, crossing])
        };
        Longitudinal {
            wavelength,
            crossings: (0..=RAYS).filter_map(crossing).collect(),
        }
    }
}

/// Where light near the axis comes to a focus.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct FocalShift {
    /// µm.
    pub wavelength: f64,
    /// From the focus of the d line, away from the lens, mm.
    pub shift: f64,
}

impl FocalShift {
    /// Over visible light; empty where the lens has no focus, or the file knows no dispersion.
    pub fn over_the_spectrum(prescription: &Prescription, object: ObjectPlane) -> Vec<FocalShift> {
        if !prescription.disperses() {
            return Vec::new();
        }
        let yellow = image(&prescription.surfaces, object);
        // 0.40 to 0.70 µm, and the three lines themselves.
        let steps = (0..=30).map(|i| 0.40 + 0.01 * f64::from(i));
        let mut wavelengths: Vec<f64> = steps.chain([LINE_C, LINE_D, LINE_F]).collect();
        wavelengths.sort_by(f64::total_cmp);
        let shift = |wavelength: f64| {
            let there = prescription.at_wavelength(wavelength, AbbeModel::NormalLine);
            let shift = image(&there.surfaces, object)? - yellow?;
            shift
                .is_finite()
                .then_some(FocalShift { wavelength, shift })
        };
        wavelengths.into_iter().filter_map(shift).collect()
    }
}

/// z of the Gaussian image of the object's axial point: Newton's equation.
fn image(surfaces: &[Surface], object: ObjectPlane) -> Option<f64> {
    let c = Paraxial::new(surfaces).cardinals?;
    let beyond = object.z.map_or(0.0, |z| {
        c.index_behind * c.focal_length * c.focal_length / (c.front_focal_point - z)
    });
    Some(c.rear_focal_point + beyond).filter(|z| z.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::ExitPupil;
    use crate::optics::analysis::ChiefFinder;

    #[test]
    fn a_plano_convex_lens_has_the_aberration_of_the_closed_form() {
        // Plane side to the light, which the sphere R = −50 of n = 1.5 refracts alone: sin I = y/50 in glass, sin I' = 1.5 y/50, and the
        // ray crosses the axis R (sin I'/sin(I' − I) − 1) behind the vertex: 2R at the axis.
        let p = Prescription::parse("0 0 0 20\ninf 5 1.5 30\n-50 0 1 30\n").unwrap();
        let lens = Lens::new(&p, 100.0).unwrap();
        let pupil = ExitPupil::new(&lens, 1.0, 8);
        let chief = ChiefFinder::new(&lens).find(0.0).unwrap();
        let beam = Beam::new(&lens, &pupil, &chief, ObjectPlane::INFINITY).unwrap();
        let found = Longitudinal::new(&lens, LINE_D, &beam);
        assert_eq!(found.crossings.len(), 33);
        for [part, crossing] in &found.crossings {
            let (i, out) = (
                (part * 10.0 / 50.0f64).asin(),
                (1.5 * part * 10.0 / 50.0f64).asin(),
            );
            // From the center of curvature, 50 mm in front of the vertex.
            let expected = 50.0 * out.sin() / (out - i).sin() - 50.0 - 100.0;
            // The rim is found to 1e-9 of itself.
            assert!(
                (crossing - expected).abs() < 1e-6,
                "{part}: {crossing} {expected}"
            );
        }
    }

    #[test]
    fn focus_shifts_with_color_by_the_abbe_number() {
        // A thin lens: f/V between F and C, and for an object at a distance the image's change is that times (s'/f)².
        let p =
            Prescription::parse("0 0 0 0 10\n100 1e-6 1.5168 64.17 30\n-100 0 1 0 30\n").unwrap();
        let f = 100.0 / (2.0 * 0.5168);
        for (object, image) in [
            (ObjectPlane::INFINITY, f),
            (ObjectPlane { z: Some(-3.0 * f) }, 1.5 * f),
        ] {
            let shifts = FocalShift::over_the_spectrum(&p, object);
            let at = |line: f64| shifts.iter().find(|s| s.wavelength == line).unwrap().shift;
            let expected = -(image / f).powi(2) * f / 64.17;
            // To first order in 1/V.
            assert!(((at(LINE_F) - at(LINE_C)) / expected - 1.0).abs() < 0.02);
            // The two numbers of the glass give its index to 1e-8.
            assert!(at(LINE_D).abs() < 1e-5, "{}", at(LINE_D));
        }
    }
}
