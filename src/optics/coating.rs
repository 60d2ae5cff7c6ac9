//! How much light a surface reflects: Fresnel's equations, and those of one thin layer.

use std::f64::consts::TAU;

/// One layer that absorbs nothing, a quarter of a wavelength thick: the classic coating of lenses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coating {
    /// Its index of refraction; 1.38 for magnesium fluoride.
    pub index: f64,
    /// The wavelength in vacuum that it is a quarter of for perpendicular light, nm.
    pub wavelength: f64,
}

impl Coating {
    /// Of magnesium fluoride, the commonest, a quarter of this wavelength (nm) thick.
    #[must_use]
    pub fn magnesium_fluoride(wavelength: f64) -> Coating {
        let index = 1.38;
        Coating { index, wavelength }
    }
}

impl std::fmt::Display for Coating {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}@{}", self.index, self.wavelength)
    }
}

impl std::str::FromStr for Coating {
    type Err = String;

    /// `INDEX@NM`.
    fn from_str(text: &str) -> Result<Coating, String> {
        let parts = text.split_once('@');
        let parsed = parts.and_then(|(index, nm)| Some((index.parse().ok()?, nm.parse().ok()?)));
        match parsed {
            Some((index, wavelength))
                if (1.0..=4.0).contains(&index) && (1.0..=1e6).contains(&wavelength) =>
            {
                Ok(Coating { index, wavelength })
            }
            _ => Err(
                "expected INDEX@NM, index and wavelength of a quarter-wave layer, such as 1.38@550"
                    .to_string(),
            ),
        }
    }
}

/// The boundary of two media, with or without a layer between them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Boundary {
    /// Index of the medium that light comes from.
    pub from: f64,
    /// Index of the other.
    pub into: f64,
    /// Between them.
    pub coating: Option<Coating>,
}

impl Boundary {
    /// The same for light from the other side.
    #[must_use]
    pub fn reversed(self) -> Boundary {
        Boundary {
            from: self.into,
            into: self.from,
            ..self
        }
    }

    /// The share of unpolarized light of this wavelength (nm, in vacuum) that is reflected; the rest is transmitted. `cosine` is that of
    /// incidence, 0 to 1. Everything is reflected where the layer or the medium behind it does so totally: light that would
    /// cross a layer of lower index than both media as an evanescent wave is counted with that.
    ///
    /// M. Born and E. Wolf, *Principles of Optics* (7th edition), §1.5.2 (eq. 20, 21) and §1.6.4 (eq. 57, 60), of real indices.
    #[must_use]
    pub fn reflectance(self, cosine: f64, wavelength: f64) -> f64 {
        let sine2 = (1.0 - cosine * cosine).clamp(0.0, 1.0) * self.from * self.from;
        let inside = |index: f64| (1.0 - sine2 / (index * index)).max(0.0).sqrt();
        let (here, behind) = (cosine.clamp(0.0, 1.0), inside(self.into));
        if behind == 0.0 {
            return 1.0;
        }
        let Some(Coating {
            index,
            wavelength: quarter,
        }) = self.coating
        else {
            return mean(amplitudes(self.from, here, self.into, behind).map(|r| r * r));
        };
        let within = inside(index);
        if within == 0.0 {
            return 1.0;
        }
        // 2β, where β is the phase that the layer adds; perpendicular light of the wavelength it is made for gets π.
        let phase = 0.5 * TAU * quarter / wavelength * within;
        let first = amplitudes(self.from, here, index, within);
        let second = amplitudes(index, within, self.into, behind);
        let of_polarization = |k: usize| {
            let (a, b) = (first[k], second[k]);
            let both = 2.0 * a * b * phase.cos();
            (a * a + b * b + both) / (1.0 + a * a * b * b + both)
        };
        mean([of_polarization(0), of_polarization(1)])
    }
}

/// Amplitudes of reflection, of light polarized across the plane of incidence and in it.
fn amplitudes(from: f64, cos_from: f64, into: f64, cos_into: f64) -> [f64; 2] {
    let (across, along) = (from * cos_from, into * cos_into);
    let (tilted, other) = (into * cos_from, from * cos_into);
    [
        (across - along) / (across + along),
        (tilted - other) / (tilted + other),
    ]
}

fn mean([a, b]: [f64; 2]) -> f64 {
    0.5 * (a + b)
}

#[cfg(test)]
mod tests {
    use super::*;

    const MAGNESIUM_FLUORIDE: Coating = Coating {
        index: 1.38,
        wavelength: 550.0,
    };

    fn boundary(from: f64, into: f64, coating: Option<Coating>) -> Boundary {
        Boundary {
            from,
            into,
            coating,
        }
    }

    #[test]
    fn perpendicular_light_is_reflected_as_the_textbook_says() {
        let glass = boundary(1.0, 1.52, None);
        let expected = (0.52f64 / 2.52).powi(2);
        assert!((glass.reflectance(1.0, 550.0) - expected).abs() < 1e-15);
        // ((n₁ n₃ − n₂²) / (n₁ n₃ + n₂²))² at a quarter wave, and as if there were no layer at a half.
        let coated = boundary(1.0, 1.52, Some(MAGNESIUM_FLUORIDE));
        let n2 = 1.38f64 * 1.38;
        let least = ((1.52 - n2) / (1.52 + n2)).powi(2);
        assert!((coated.reflectance(1.0, 550.0) - least).abs() < 1e-15);
        assert!((coated.reflectance(1.0, 275.0) - expected).abs() < 1e-14);
        assert!(least < 0.013 && expected > 0.042);
    }

    #[test]
    fn brewsters_angle_reflects_one_polarization() {
        // tan θ = n: half of what the other polarization has, ((n² − 1) / (n² + 1))².
        let n = 1.5f64;
        let cosine = 1.0 / (1.0 + n * n).sqrt();
        let expected = 0.5 * ((n * n - 1.0) / (n * n + 1.0)).powi(2);
        let found = boundary(1.0, n, None).reflectance(cosine, 550.0);
        assert!((found - expected).abs() < 1e-15);
    }

    /// Stokes: from both sides, along one path, the same share is reflected.
    #[test]
    fn both_sides_reflect_the_same() {
        for coating in [None, Some(MAGNESIUM_FLUORIDE)] {
            for degrees in [0.0f64, 10.0, 40.0, 70.0, 89.0] {
                let there = boundary(1.0, 1.7, coating);
                let sine = degrees.to_radians().sin() / 1.7;
                let back = there
                    .reversed()
                    .reflectance((1.0 - sine * sine).sqrt(), 480.0);
                let forth = there.reflectance(degrees.to_radians().cos(), 480.0);
                assert!((back - forth).abs() < 1e-12, "{degrees}: {forth} {back}");
                assert!((0.0..=1.0).contains(&forth));
            }
        }
    }

    #[test]
    fn beyond_the_critical_angle_and_along_the_surface_everything_is_reflected() {
        for coating in [None, Some(MAGNESIUM_FLUORIDE)] {
            assert_eq!(boundary(1.5, 1.0, coating).reflectance(0.6, 550.0), 1.0);
            let grazing = boundary(1.0, 1.5, coating).reflectance(0.0, 550.0);
            assert!((grazing - 1.0).abs() < 1e-15);
        }
    }

    #[test]
    fn a_layer_that_is_no_other_medium_is_none() {
        let layer = Coating {
            index: 1.5,
            wavelength: 550.0,
        };
        for cosine in [1.0, 0.7, 0.2] {
            let with = boundary(1.0, 1.5, Some(layer)).reflectance(cosine, 550.0);
            let without = boundary(1.0, 1.5, None).reflectance(cosine, 550.0);
            assert!((with - without).abs() < 1e-15);
        }
    }

    #[test]
    fn layers_are_read() {
        assert_eq!("1.38@550".parse(), Ok(MAGNESIUM_FLUORIDE));
        for wrong in ["1.38", "0.5@550", "1.38@0", "x@550", "1.38@nan", ""] {
            assert!(wrong.parse::<Coating>().is_err(), "{wrong}");
        }
    }
}
