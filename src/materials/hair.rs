//! The `hair` material.

use super::inputs::{float_within, given_refractive_index, unit_input};
use super::{Place, Scattering};
use crate::bsdf::{self, Bsdf, Lobe};
use crate::inputs::{FloatInput, SpectrumInput};
use crate::math::Rgb;
use crate::math::float::clamp_nan_low;
use crate::params::ParamReader;

/// Absorption per unit of eumelanin, the brown and black pigment (d'Eon et al. 2011).
const EUMELANIN: Rgb = Rgb::new(0.419, 0.697, 1.37);

/// Absorption per unit of pheomelanin, the yellow and red pigment.
const PHEOMELANIN: Rgb = Rgb::new(0.187, 0.4, 1.05);

/// How a fiber's absorption is specified.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Pigment {
    /// `sigma_a`: absorption per fiber radius.
    Absorption(SpectrumInput),
    /// `color`: reflectance of a mass of such hair under uniform light, at most 1.
    Color(SpectrumInput),
    /// `eumelanin`, brown and black, and `pheomelanin`, yellow and red: concentrations.
    Melanin([FloatInput; 2]),
}

/// Hair and fur (Chiang et al. 2016). Parameters: spectrum `sigma_a`, else spectrum `color`, else float `eumelanin` and
/// `pheomelanin` (1.3 and 0 if none of the four is given); float `eta` (1.55), at least 1; float `beta_m` (0.3),
/// `beta_n` (0.3): longitudinal and azimuthal roughness, 0 to 1; float `alpha` (2): tilt of the scales in degrees.
///
/// Designed for curves: v runs across the fiber, so that the offset from its axis is 2v − 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hair {
    /// Specification of the absorption.
    pub pigment: Pigment,
    /// Refractive index.
    pub eta: FloatInput,
    /// Roughness along and around the fiber.
    pub beta: [FloatInput; 2],
    /// Tilt of the scales, degrees.
    pub alpha: FloatInput,
}

impl Hair {
    /// Reads the parameters.
    pub fn from_params(reader: &ParamReader) -> Hair {
        let eta = given_refractive_index(reader, "eta").unwrap_or(FloatInput::Constant(1.55));
        if let FloatInput::Constant(x) = eta
            && x < 1.0
        {
            reader.warn("eta", format!("`eta` is {x}, below that of air: 1 is used"));
        }
        Hair {
            pigment: Pigment::from_params(reader),
            eta,
            beta: ["beta_m", "beta_n"].map(|name| unit_input(reader, name, 0.3)),
            alpha: float_within(reader, "alpha", 2.0, -90.0..=90.0),
        }
    }
}

impl Scattering for Hair {
    /// v says where across the fiber a ray meets it, ∂p/∂u where that points.
    fn is_isotropic(&self) -> bool {
        false
    }

    fn bumps(&self) -> bool {
        false
    }

    fn add_lobes(&self, at: &Place, bsdf: &mut Bsdf) {
        let beta = self.beta.map(|beta| at.float(&beta));
        let alpha = at.float(&self.alpha);
        bsdf.add(Lobe::Hair(bsdf::hair::Hair::new(
            2.0 * at.point.uv.y - 1.0,
            at.refractive_index(&self.eta),
            self.pigment.sigma_a(at, beta[1]),
            beta,
            if alpha.is_finite() { alpha } else { 0.0 },
        )));
    }
}

impl Pigment {
    /// Reads the parameters; those after the first one given are ignored with a warning.
    fn from_params(reader: &ParamReader) -> Pigment {
        let sigma_a = reader.find_spectrum_input("sigma_a");
        let color = reader.find_spectrum_input("color");
        let melanin = ["eumelanin", "pheomelanin"].map(|name| {
            reader
                .find_float_input(name)
                .map(|_| float_within(reader, name, 0.0, 0.0..=f32::MAX))
        });
        let ignored = |used, names: &[&str]| {
            for &name in names.iter().filter(|&&name| reader.has(name)) {
                reader.warn(name, format!("`{name}` is ignored: `{used}` is given"));
            }
        };
        match (sigma_a, color, melanin) {
            (Some(sigma_a), _, _) => {
                ignored("sigma_a", &["color", "eumelanin", "pheomelanin"]);
                Pigment::Absorption(sigma_a)
            }
            (None, Some(color), _) => {
                ignored("color", &["eumelanin", "pheomelanin"]);
                Pigment::Color(color)
            }
            (None, None, [None, None]) => Pigment::Melanin([1.3, 0.0].map(FloatInput::Constant)),
            (None, None, given) => {
                Pigment::Melanin(given.map(|input| input.unwrap_or(FloatInput::Constant(0.0))))
            }
        }
    }

    /// Absorption per fiber radius, for the azimuthal roughness.
    fn sigma_a(&self, at: &Place, beta_n: f32) -> Rgb {
        match self {
            Pigment::Absorption(sigma_a) => at.reflectance(sigma_a),
            Pigment::Color(color) => {
                let color = at.reflectance(color);
                absorption_of_color(color, clamp_nan_low(beta_n, 0.0, 1.0))
            }
            Pigment::Melanin(amounts) => {
                let [brown, red] = amounts.map(|input| at.within(&input, 0.0, f32::MAX));
                (brown * EUMELANIN + red * PHEOMELANIN).min(Rgb::MAX)
            }
        }
    }
}

/// The absorption that gives a mass of hair its color: the fit of Chiang et al. 2016, equation 9.
fn absorption_of_color(color: Rgb, beta_n: f32) -> Rgb {
    const FIT: [f32; 6] = [5.969, -0.215, 2.532, -10.73, 5.574, 0.245];
    let scale = FIT.iter().rev().fold(0.0, |sum, c| sum * beta_n + c);
    // Black would need unbounded absorption.
    let log = color.max(Rgb::splat(1e-20)).min(Rgb::ONE).map(f32::ln);
    (log / scale) * (log / scale)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bsdf::testing::{flat_hit, sky_by_sampling};
    use crate::materials::MaterialKind;
    use crate::math::{Vec2, Vec3};
    use crate::params::testing::read;
    use crate::surface::Footprint;
    use crate::textures::Textures;

    #[test]
    fn one_pigment_counts() {
        for (params, warnings) in [
            ("\"rgb sigma_a\" [1 2 3]", 0),
            ("\"rgb color\" [.5 .4 .3] \"float eumelanin\" 2", 1),
            (
                "\"rgb sigma_a\" [1 2 3] \"rgb color\" [1 1 1] \"float pheomelanin\" 2",
                2,
            ),
            ("\"float eumelanin\" 2 \"float pheomelanin\" 1", 0),
            ("\"float eumelanin\" -2", 1),
            (
                "\"float beta_m\" 1.5 \"float beta_n\" -1 \"float eta\" .9",
                3,
            ),
        ] {
            let outcome = read("hair", params, Hair::from_params);
            assert_eq!(
                (outcome.errors, outcome.warnings),
                (0, warnings),
                "{}",
                outcome.text
            );
        }
        let default = read("hair", "", Hair::from_params).value.pigment;
        let given = read("hair", "\"float eumelanin\" 1.3", Hair::from_params)
            .value
            .pigment;
        assert_eq!(default, given);
    }

    /// Chiang et al. 2016, §4.2: the fit inverts multiple scattering, so absorption decreases with the color.
    #[test]
    fn brighter_hair_absorbs_less() {
        let of = |c| absorption_of_color(Rgb::splat(c), 0.3).x;
        assert!(of(0.0).is_finite() && of(0.0) > of(0.1) && of(0.1) > of(0.9));
        assert_eq!((of(1.0), of(7.0)), (0.0, 0.0));
    }

    /// v across the fiber gives the offset: a ray at v = ½ goes through the middle, the longest way.
    #[test]
    fn the_offset_is_that_of_v() {
        let hair = read("hair", "\"rgb sigma_a\" [1 1 1]", Hair::from_params).value;
        let shown = |v: f32| {
            let mut hit = flat_hit(Vec3::Z);
            hit.uv = Vec2::new(0.3, v);
            let kind = MaterialKind::Hair(hair);
            let material = crate::materials::Material::without_textures(kind);
            let bsdf = material.bsdf(&hit, &Footprint::default(), &Textures::default(), &[]);
            sky_by_sampling(&bsdf, Vec3::Z, 16).x
        };
        assert!(shown(0.5) < shown(0.9) && shown(0.9) < shown(0.999));
        // By symmetry; the error of 16³ samples.
        assert!((shown(0.2) - shown(0.8)).abs() < 0.02);
    }
}
