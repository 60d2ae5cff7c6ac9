//! The stop by its number, as photographers set it.
//!
//! The f-number is the focal length over the diameter of the entrance pupil: Gaussian optics of the stop alone. The T-number is that of
//! a lens that loses nothing and is as bright in the middle of the film, focused at infinity: 1/(2 n' sin u') of the widest real ray
//! there, over the root of what a shaped stop lets through (Ray, *Applied Photographic Optics*, 3rd edition, chapter 20). Where a rim in
//! front of the stop is the narrower, or the lens has spherical aberration of its pupils, they differ. Glass absorbs nothing
//! here, and what it reflects is the caller's to count.

use super::analysis::illumination::effective_f_number;
use super::bisection::bisect;
use super::lens::Lens;
use super::paraxial::Paraxial;
use super::prescription::Prescription;
use super::trace::LensRay;

/// A number to set the stop by.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ApertureNumber {
    /// Focal length over the diameter of the entrance pupil.
    F(f64),
    /// By the light in the middle of the film.
    T {
        /// The T-number.
        number: f64,
        /// What the stop's shape lets through of a round one's light: above 0, at most 1.
        transmission: f64,
    },
}

/// Why a stop cannot be set by a number.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum ApertureError {
    /// Not a positive number.
    #[error("{0} is no f-number or T-number; expected a positive number")]
    NoNumber(f64),
    /// Nothing to set.
    #[error("the lens has no stop row that could be set")]
    NoStop,
    /// It has no focal length, no entrance pupil or no film to be bright.
    #[error("the lens has no f-number: it makes no image of what is far")]
    NoImage,
    /// The stop of the file is too narrow.
    #[error("{asked} is faster than the lens, which reaches {fastest:.3} with its stop open")]
    TooFast {
        /// The number that was asked for.
        asked: f64,
        /// The smallest that there is.
        fastest: f64,
    },
}

/// A stop opened to within this part of what was asked for is open: marked numbers are rounded, and so are computed ones.
const ROUNDING: f64 = 1e-6;

impl ApertureNumber {
    fn asked(self) -> f64 {
        let (ApertureNumber::F(number) | ApertureNumber::T { number, .. }) = self;
        number
    }

    /// The number of this kind that the lens has with its stops as they are.
    pub fn of(self, prescription: &Prescription) -> Option<f64> {
        match self {
            ApertureNumber::F(_) => Paraxial::new(&prescription.surfaces).f_number,
            ApertureNumber::T { transmission, .. } => t_number(prescription, transmission),
        }
    }

    /// The diameter of the stops, mm, that gives `prescription` this number.
    ///
    /// # Errors
    /// See [`ApertureError`].
    pub fn diameter(self, prescription: &Prescription) -> Result<f64, ApertureError> {
        let asked = self.asked();
        if !(asked > 0.0 && asked.is_finite()) {
            return Err(ApertureError::NoNumber(asked));
        }
        let stops = prescription.surfaces.iter().filter(|s| s.is_stop);
        let widest = stops.map(|s| s.aperture).fold(0.0, f64::max);
        if widest <= 0.0 {
            return Err(ApertureError::NoStop);
        }
        let fastest = self.of(prescription).ok_or(ApertureError::NoImage)?;
        if asked < fastest * (1.0 - ROUNDING) {
            return Err(ApertureError::TooFast { asked, fastest });
        }
        let mut stopped = prescription.clone();
        let mut number = |diameter: f64| {
            for (s, file) in stopped.surfaces.iter_mut().zip(&prescription.surfaces) {
                if s.is_stop {
                    s.aperture = file.aperture.min(diameter);
                }
            }
            self.of(&stopped)
        };
        // Each step gains a bit of the diameter over the widest: f/1e6 still has ten digits.
        let slower = |d: f64| number(d).is_none_or(|n| n > asked);
        let [_, high] = bisect([0.0, widest], 80, slower);
        Ok(high)
    }
}

/// The T-number of a lens whose stop's shape lets `transmission` of a round one's light through; `None` where it makes no image of what is
/// far, or no light arrives.
pub fn t_number(prescription: &Prescription, transmission: f64) -> Option<f64> {
    let film_distance = Lens::focused(prescription, f64::INFINITY).ok()?;
    let lens = Lens::new(prescription, film_distance).ok()?;
    working_number(&lens, transmission)
}

/// The same at the film distance that `lens` has: what the light in the middle of the film goes by, at any focus.
pub fn working_number(lens: &Lens, transmission: f64) -> Option<f64> {
    let sine = axial_sine(lens)?;
    effective_f_number(
        std::f64::consts::PI * sine * sine * transmission,
        lens.rear().index,
    )
}

/// The sine of the widest angle at which light comes to the middle of the film; `None` for no light.
fn axial_sine(lens: &Lens) -> Option<f64> {
    /// Steps of the sine within which light is taken not to break off and continue.
    const STEPS: u32 = 256;
    let passes = |sine: f64| {
        let d = [sine, 0.0, -(1.0 - sine * sine).max(0.0).sqrt()];
        let ray = LensRay::new([0.0, 0.0, lens.film_z()], d);
        lens.tracer().to_scene(&ray).is_ok()
    };
    let at = |step: u32| f64::from(step) / f64::from(STEPS);
    let blocked = (0..=STEPS).find(|step| !passes(at(*step)))?;
    let last = blocked.checked_sub(1)?;
    let [low, _] = bisect([at(last), at(blocked)], 60, passes);
    (low > 0.0).then_some(low)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn golden(name: &str) -> Prescription {
        let root = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/golden/");
        Prescription::read(format!("{root}{name}.dat").as_ref()).unwrap()
    }

    /// f/N of every golden lens with a stop, to f/1000.
    #[test]
    fn the_stop_of_an_f_number_gives_it() {
        for name in [
            "dgauss_50",
            "wide_22",
            "fisheye_10",
            "tessar_100",
            "zoom_80_200_wide",
        ] {
            let prescription = golden(name);
            let open = Paraxial::new(&prescription.surfaces).f_number.unwrap();
            for n in [open, open * 1.001, 5.6, 8.0, 22.0, 1000.0] {
                let d = ApertureNumber::F(n).diameter(&prescription).unwrap();
                let mut set = prescription.clone();
                assert!(set.set_stops(d).is_empty(), "{name} f/{n}");
                let found = Paraxial::new(&set.surfaces).f_number.unwrap();
                // 80 halvings: what is left is rounding of f and of the pupil's diameter.
                assert!((found / n - 1.0).abs() < 1e-12, "{name}: {found} for {n}");
                // Stop and pupil are proportional.
                let widest = prescription.surfaces.iter().find(|s| s.is_stop).unwrap();
                assert!((d * n / (widest.aperture * open) - 1.0).abs() < 1e-12);
            }
        }
    }

    /// Against the projected solid angle of `tests/golden`, whose quadrature is good to 3e-4: `f/EPD` and `N from real area` of the study
    /// differ by up to a third where a rim is narrower than the stop.
    #[test]
    fn the_t_number_is_that_of_real_light() {
        for (name, f, t) in [
            ("dgauss_50", 2.03, 2.02),
            ("wide_22", 2.68, 2.79),
            ("zoom_80_200_wide", 2.88, 3.81),
            ("nikon_50_f1.2", 1.16, 1.25),
        ] {
            let prescription = golden(name);
            let found = [
                Paraxial::new(&prescription.surfaces).f_number.unwrap(),
                t_number(&prescription, 1.0).unwrap(),
            ];
            // The study gives three digits.
            assert!((found[0] - f).abs() < 0.0051, "{name} f/{}", found[0]);
            assert!((found[1] - t).abs() < 0.0051, "{name} T{}", found[1]);
        }
    }

    #[test]
    fn the_stop_of_a_t_number_gives_it_whatever_its_shape() {
        let prescription = golden("dgauss_50");
        for transmission in [1.0, 0.64, 0.1] {
            let wanted = ApertureNumber::T {
                number: 8.0,
                transmission,
            };
            let mut set = prescription.clone();
            set.set_stops(wanted.diameter(&prescription).unwrap());
            let found = t_number(&set, transmission).unwrap();
            // 60 halvings of a sine of 1/256.
            assert!((found / 8.0 - 1.0).abs() < 1e-10, "{found}");
        }
    }

    #[test]
    fn what_cannot_be_set_is_said() {
        let prescription = golden("dgauss_50");
        let set = |n| ApertureNumber::F(n).diameter(&prescription);
        assert!(matches!(set(1.0), Err(ApertureError::TooFast { .. })));
        for n in [0.0, -2.0, f64::NAN, f64::INFINITY] {
            assert!(matches!(set(n), Err(ApertureError::NoNumber(_))));
        }
        let without = Prescription::parse("50 5 1.5 20\n-50 0 1 20\n").unwrap();
        let f8 = ApertureNumber::F(8.0);
        assert_eq!(f8.diameter(&without), Err(ApertureError::NoStop));
        let window = Prescription::parse("inf 5 1.5 20\ninf 1 1 20\n0 0 0 10\n").unwrap();
        assert_eq!(f8.diameter(&window), Err(ApertureError::NoImage));
    }
}
