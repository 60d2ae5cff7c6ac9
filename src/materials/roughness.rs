//! Conversion of roughness parameters to the widths of microfacet distributions.

use crate::bsdf::microfacet::MicrofacetTransmission;
use crate::bsdf::specular::SpecularTransmission;
use crate::bsdf::trowbridge_reitz::TrowbridgeReitz;
use crate::bsdf::{Bsdf, Lobe};
use crate::inputs::FloatInput;
use crate::math::Rgb;
use crate::params::ParamReader;

/// Minimum roughness that is not smooth: pbrt-v3 raises smaller values to this.
const MIN: f32 = 1e-3;

/// A roughness parameter, if it is given. Negative constants give a warning and count as the minimum roughness, as in
/// pbrt-v3.
pub(super) fn find_roughness(reader: &ParamReader, name: &str) -> Option<FloatInput> {
    let given = reader.find_float_input(name)?;
    Some(match given {
        FloatInput::Constant(r) if r < 0.0 => {
            reader.warn(name, format!("`{name}` is {r}, below 0: {MIN} is used"));
            FloatInput::Constant(MIN)
        }
        _ => given,
    })
}

/// Refractive indices this close to 1 deflect light by less than the half vector can resolve: it is transmitted
/// straight.
pub(super) const UNBENT: f32 = 1e-4;

/// Adds refraction through a rough boundary into the refractive index `eta`.
pub(super) fn add_rough_refraction(
    bsdf: &mut Bsdf,
    transmittance: Rgb,
    distribution: TrowbridgeReitz,
    eta: f32,
) {
    bsdf.add(if (eta - 1.0).abs() < UNBENT {
        Lobe::SpecularTransmission(SpecularTransmission {
            transmittance,
            eta_a: 1.0,
            eta_b: 1.0,
        })
    } else {
        Lobe::MicrofacetTransmission(MicrofacetTransmission {
            transmittance,
            distribution,
            eta_a: 1.0,
            eta_b: eta,
        })
    });
}

/// How a roughness parameter is interpreted. Parameter: constant bool `remaproughness` (true); in pbrt-v2's language
/// always [`RoughnessMeaning::BlinnExponent`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RoughnessMeaning {
    /// pbrt-v3's perceptual scale (Pharr, Jakob and Humphreys 2016, §8.4.2).
    Remapped,
    /// The width α of the Trowbridge–Reitz distribution itself.
    Alpha,
    /// pbrt-v2's: one over the exponent of Blinn's distribution.
    BlinnExponent,
}

impl RoughnessMeaning {
    /// Reads the parameter.
    pub fn from_params(reader: &ParamReader) -> RoughnessMeaning {
        if !reader.offers("remaproughness") {
            RoughnessMeaning::BlinnExponent
        } else if reader.boolean("remaproughness", true) {
            RoughnessMeaning::Remapped
        } else {
            RoughnessMeaning::Alpha
        }
    }

    /// The width α for a roughness.
    pub fn alpha(self, roughness: f32) -> f32 {
        match self {
            RoughnessMeaning::Remapped => {
                let x = roughness.max(MIN).ln();
                1.62142 + x * (0.819955 + x * (0.1734 + x * (0.0171201 + x * 0.000640711)))
            }
            RoughnessMeaning::Alpha => roughness,
            RoughnessMeaning::BlinnExponent => {
                // cosᵉ falls off like GGX with α² = 2/(e + 2) (Walter et al. 2007), e = 1/r; pbrt-v2
                // caps the exponent at 10000.
                let r = roughness.max(1e-4);
                (2.0 * r / (1.0 + 2.0 * r)).sqrt()
            }
        }
    }

    /// The facet distribution of a surface with these roughnesses along u and v.
    pub fn distribution(self, u_roughness: f32, v_roughness: f32) -> TrowbridgeReitz {
        TrowbridgeReitz::new(self.alpha(u_roughness), self.alpha(v_roughness))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn remapping_is_pbrts_table() {
        // docs/scene-language.md §6.1, printed to five digits.
        let table = [
            (0.0, 0.04727),
            (0.001, 0.04727),
            (0.005, 0.1033),
            (0.01, 0.13892),
            (0.025, 0.21556),
            (0.05, 0.31255),
            (0.1, 0.46176),
            (0.15, 0.58135),
            (0.2, 0.68384),
            (0.3, 0.85704),
            (0.5, 1.13083),
            (0.7, 1.35026),
            (1.0, 1.62142),
        ];
        for (roughness, alpha) in table {
            assert!(
                (RoughnessMeaning::Remapped.alpha(roughness) - alpha).abs() < 1e-5,
                "{roughness}"
            );
        }
    }

    #[test]
    fn blinn_exponents_and_ggx_widths_match() {
        // e = 10: α = √(2/12).
        assert!((RoughnessMeaning::BlinnExponent.alpha(0.1) - (2.0f32 / 12.0).sqrt()).abs() < 1e-6);
    }
}
