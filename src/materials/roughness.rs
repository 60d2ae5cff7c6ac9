//! Conversion of roughness parameters to the widths of microfacet distributions.

use super::Place;
use crate::bsdf::trowbridge_reitz::TrowbridgeReitz;
use crate::inputs::FloatInput;
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

/// The roughness of a surface along u and v.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Roughness {
    /// As given.
    pub(super) along: [FloatInput; 2],
    /// How it is interpreted.
    pub(super) meaning: RoughnessMeaning,
}

impl Roughness {
    /// These, with the meaning that the scene gives them.
    pub(super) fn new(reader: &ParamReader, along: [FloatInput; 2]) -> Roughness {
        let meaning = RoughnessMeaning::from_params(reader);
        Roughness { along, meaning }
    }

    /// Float `roughness` (0.1), the same along u and v.
    pub(super) fn isotropic(reader: &ParamReader) -> Roughness {
        let both = find_roughness(reader, "roughness").unwrap_or(FloatInput::Constant(0.1));
        Roughness::new(reader, [both; 2])
    }

    /// Floats `uroughness` and `vroughness`.
    pub(super) fn anisotropic(reader: &ParamReader, default: FloatInput) -> Roughness {
        let along = ["uroughness", "vroughness"]
            .map(|name| find_roughness(reader, name).unwrap_or(default));
        Roughness::new(reader, along)
    }

    /// Returns `true` if it is the same along u and v.
    pub(super) fn is_isotropic(&self) -> bool {
        self.along[0] == self.along[1]
    }

    /// Returns `true` if the surface is smooth everywhere.
    pub(super) fn is_smooth(&self) -> bool {
        self.along == [FloatInput::Constant(0.0); 2]
    }

    /// The roughnesses at a point, as given.
    fn at(&self, place: &Place) -> [f32; 2] {
        let [u, v] = &self.along;
        let along_u = place.float(u);
        [along_u, if u == v { along_u } else { place.float(v) }]
    }

    /// The facet distribution, if it is the same everywhere.
    pub(super) fn even_distribution(&self) -> Option<TrowbridgeReitz> {
        let [FloatInput::Constant(u), FloatInput::Constant(v)] = self.along else {
            return None;
        };
        Some(self.meaning.distribution(u, v))
    }

    /// The facet distribution at a point.
    pub(super) fn distribution(&self, place: &Place) -> TrowbridgeReitz {
        let [u, v] = self.at(place);
        self.meaning.distribution(u, v)
    }

    /// The facet distribution at a point; `None` where the surface is smooth.
    pub(super) fn facets(&self, place: &Place) -> Option<TrowbridgeReitz> {
        let [u, v] = self.at(place);
        (u != 0.0 || v != 0.0).then(|| self.meaning.distribution(u, v))
    }
}

/// How a roughness parameter is interpreted. Parameter: constant bool `remaproughness` (true); in pbrt-v2's language
/// always [`RoughnessMeaning::BlinnExponent`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum RoughnessMeaning {
    /// pbrt-v3's perceptual scale (Pharr, Jakob and Humphreys 2016, §8.4.2).
    Remapped,
    /// The width α of the Trowbridge–Reitz distribution itself.
    Alpha,
    /// pbrt-v2's: one over the exponent of Blinn's distribution.
    BlinnExponent,
}

impl RoughnessMeaning {
    /// Reads the parameter.
    pub(super) fn from_params(reader: &ParamReader) -> RoughnessMeaning {
        if !reader.offers("remaproughness") {
            RoughnessMeaning::BlinnExponent
        } else if reader.boolean("remaproughness", true) {
            RoughnessMeaning::Remapped
        } else {
            RoughnessMeaning::Alpha
        }
    }

    /// The width α for a roughness.
    pub(super) fn alpha(self, roughness: f32) -> f32 {
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
    pub(super) fn distribution(self, u_roughness: f32, v_roughness: f32) -> TrowbridgeReitz {
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
