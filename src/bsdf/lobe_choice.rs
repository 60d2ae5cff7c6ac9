//! Sampling a lobe of a BSDF: mostly in proportion to an estimate of each lobe's albedo, and to a smaller part uniformly,
//! since the incident light is unknown. (pbrt-v3 samples all lobes with equal probability.)
//!
//! The albedo is estimated from the outgoing direction alone. The lobe is chosen by the first of the two numbers that sample the
//! direction, rescaled, as in pbrt-v3, so that lobe and direction are stratified together. What this brings, scene by scene, is in
//! docs/notes/performance.md, "Choosing a lobe".

use super::MAX_LOBES;
use super::fresnel::{Fresnel, dielectric};
use super::lobe::Lobe;
use crate::math::sampling::BELOW_ONE;
use crate::math::{Rgb, Vec2, Vec3};

/// The uniform part of the probabilities. With a tenth, eight scenes had 0.98 of the variance that they have with a quarter (4 images of
/// each); but what a weak mirror reflects may be an emitter, and is the noisier the more rarely the mirror is sampled.
const EVEN_SHARE: f32 = 0.2;

/// Albedo of the sheen, in units of its reflectance: it is bright at grazing angles only.
const SHEEN: f32 = 0.1;

/// The probability of each lobe.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct LobeChoice {
    chances: [f32; MAX_LOBES],
}

impl LobeChoice {
    /// Among these lobes, for light that leaves along `wo` (local).
    #[inline]
    pub(super) fn new(lobes: &[Lobe], wo: Vec3) -> LobeChoice {
        let mut chances = [0.0; MAX_LOBES];
        if lobes.len() == 1 {
            chances[0] = 1.0;
        } else {
            by_strength(&mut chances, lobes, wo);
        }
        LobeChoice { chances }
    }

    /// That of the lobe at this index.
    #[inline]
    pub(super) fn of(&self, lobe: usize) -> f32 {
        self.chances.get(lobe).copied().unwrap_or(0.0)
    }

    /// Chooses one of `count` lobes by the first of two numbers in [0, 1), which is rescaled for reuse.
    #[inline]
    pub(super) fn choose(&self, count: usize, mut u: Vec2) -> Option<(usize, Vec2)> {
        let last = count.checked_sub(1)?;
        for lobe in 0..last {
            let chance = self.of(lobe);
            if u.x < chance {
                return Some((lobe, rescaled(u, chance)));
            }
            u.x -= chance;
        }
        // Rounding may leave a little more than the last one's chance.
        match last {
            0 => Some((0, u)),
            _ => Some((last, rescaled(u, self.of(last)))),
        }
    }
}

/// Two numbers of which the first is in [0, `end`), or beyond by rounding, as numbers in [0, 1).
#[inline(always)]
pub(super) fn rescaled(u: Vec2, end: f32) -> Vec2 {
    Vec2::new((u.x / end).clamp(0.0, BELOW_ONE), u.y)
}

/// [`LobeChoice::choose`] between two lobes, without a branch: whether the first is chosen.
#[inline(always)]
pub(super) fn choose_of_two(chances: [f32; 2], u: Vec2) -> (bool, Vec2) {
    let is_first = u.x < chances[0];
    let rest = Vec2::new(u.x - chances[0], u.y);
    let (u, chance) = if is_first {
        (u, chances[0])
    } else {
        (rest, chances[1])
    };
    (is_first, rescaled(u, chance))
}

/// The probabilities of two lobes that scatter this much of the light, of each color.
#[inline(always)]
pub(super) fn chances_of_two(first: Rgb, second: Rgb) -> [f32; 2] {
    let (first, second) = (brightness(first), brightness(second));
    let total = first + second;
    [chance(first, total, 2), chance(second, total, 2)]
}

#[inline(never)]
fn by_strength(chances: &mut [f32; MAX_LOBES], lobes: &[Lobe], wo: Vec3) {
    let mut total = 0.0;
    let mut boundary = Reflectance::toward(wo);
    for (chance, lobe) in chances.iter_mut().zip(lobes) {
        *chance = brightness(lobe.strength(wo, &mut boundary));
        total += *chance;
    }
    for strength in chances.iter_mut().take(lobes.len()) {
        *strength = chance(*strength, total, lobes.len());
    }
}

/// The probability of one of `count` lobes, whose strengths sum up to `total`.
#[inline(always)]
fn chance(strength: f32, total: f32, count: usize) -> f32 {
    let known = (total > 0.0) & total.is_finite();
    let by_strength = (1.0 - EVEN_SHARE) / total * strength;
    let even = if known { EVEN_SHARE } else { 1.0 } / count as f32;
    even + if known { by_strength } else { 0.0 }
}

/// The sum over colors, at least 0.
#[inline(always)]
fn brightness(color: Rgb) -> f32 {
    let sum = color.x + color.y + color.z;
    // Not where it is not a number.
    if sum > 0.0 { sum } else { 0.0 }
}

/// Fresnel reflectance of dielectrics toward one direction: the two lobes of a boundary share it.
struct Reflectance {
    /// Signed cosine to the normal.
    cosine: f32,
    /// The indices of the last evaluation, and the reflectance.
    known: Option<([f32; 2], f32)>,
}

impl Reflectance {
    fn toward(wo: Vec3) -> Reflectance {
        Reflectance {
            cosine: wo.z,
            known: None,
        }
    }

    /// With these indices on the normal's side and on the other.
    fn of(&mut self, eta_i: f32, eta_t: f32) -> f32 {
        let indices = [eta_i, eta_t];
        match self.known {
            Some((known, reflectance)) if known == indices => reflectance,
            _ => {
                let reflectance = dielectric(self.cosine, eta_i, eta_t);
                self.known = Some((indices, reflectance));
                reflectance
            }
        }
    }

    fn of_facets(&mut self, fresnel: &Fresnel) -> Rgb {
        match *fresnel {
            Fresnel::Dielectric { eta_i, eta_t } => Rgb::splat(self.of(eta_i, eta_t)),
            _ => fresnel.evaluate(self.cosine),
        }
    }
}

impl Lobe<'_> {
    /// About how much of the light from all directions the lobe scatters toward `wo`, of each color.
    fn strength(&self, wo: Vec3, boundary: &mut Reflectance) -> Rgb {
        match self {
            Lobe::LambertianReflection(l) => l.reflectance,
            Lobe::LambertianTransmission(l) => l.transmittance,
            Lobe::OrenNayar(l) => l.reflectance,
            Lobe::SpecularReflection(l) => l.reflectance * boundary.of_facets(&l.fresnel),
            Lobe::SpecularTransmission(l) => {
                l.transmittance * (1.0 - boundary.of(l.eta_a, l.eta_b))
            }
            Lobe::FresnelSpecular(l) => {
                let reflected = boundary.of(l.eta_a, l.eta_b);
                l.reflectance * reflected + l.transmittance * (1.0 - reflected)
            }
            Lobe::MicrofacetReflection(l) => l.reflectance * boundary.of_facets(&l.fresnel),
            Lobe::MicrofacetTransmission(l) => {
                l.transmittance * (1.0 - boundary.of(l.eta_a, l.eta_b))
            }
            Lobe::MirroredReflection(l) => l.0.reflectance * l.0.fresnel.evaluate(wo.z.abs()),
            Lobe::FresnelBlend(l) => l.scale * (l.diffuse + l.specular),
            Lobe::DisneyDiffuse(l) => l.reflectance * (l.base + l.flat) + SHEEN * l.sheen,
            Lobe::Clearcoat(l) => l.weight * l.reflectance_at(wo.z.abs()),
            Lobe::Hair(l) => l.scale,
            Lobe::SubsurfaceExit(l) => l.factor,
            Lobe::Fourier(l) => l.share,
            Lobe::Measured(l) => l.share,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bsdf::lambertian::{LambertianReflection, LambertianTransmission};
    use crate::bsdf::specular::SpecularReflection;

    fn reflecting(share: f32) -> Lobe<'static> {
        Lobe::LambertianReflection(LambertianReflection {
            reflectance: Rgb::splat(share),
        })
    }

    fn transmitting(share: f32) -> Lobe<'static> {
        Lobe::LambertianTransmission(LambertianTransmission {
            transmittance: Rgb::splat(share),
        })
    }

    #[test]
    fn every_lobe_has_a_chance_and_all_have_one_together() {
        let coat = Lobe::SpecularReflection(SpecularReflection {
            reflectance: Rgb::ONE,
            fresnel: Fresnel::Dielectric {
                eta_i: 1.0,
                eta_t: 1.5,
            },
        });
        let wo = Vec3::Z;
        for lobes in [
            &[reflecting(0.3)][..],
            &[reflecting(0.9), transmitting(0.1)],
            &[reflecting(0.5), coat, transmitting(0.0)],
            &[reflecting(0.0), transmitting(0.0)],
            &[reflecting(f32::NAN), transmitting(0.5)],
            &[reflecting(f32::INFINITY), transmitting(0.5)],
            &[reflecting(1e30), transmitting(1e-30), coat, coat],
        ] {
            let choice = LobeChoice::new(lobes, wo);
            let n = lobes.len();
            let chances: Vec<f32> = (0..n).map(|i| choice.of(i)).collect();
            // A few roundings of numbers up to 1.
            let sum: f32 = chances.iter().sum();
            assert!((sum - 1.0).abs() < 1e-6, "{chances:?}");
            let least = 0.99 * EVEN_SHARE / n as f32;
            assert!(chances.iter().all(|&c| c >= least), "{chances:?}");
        }
        // A coat that reflects 4 % on a base that reflects 36 %.
        let choice = LobeChoice::new(&[reflecting(0.36), coat], wo);
        let expected = 0.5 * EVEN_SHARE + 0.9 * (1.0 - EVEN_SHARE);
        assert!((choice.of(0) - expected).abs() < 1e-6, "{choice:?}");
    }

    #[test]
    fn numbers_are_even_whatever_lobe_they_choose() {
        let lobes = [reflecting(0.6), transmitting(0.1), reflecting(0.3)];
        let choice = LobeChoice::new(&lobes, Vec3::Z);
        let n = 100_000;
        let mut sums = [(0.0, 0.0); 3];
        for i in 0..n {
            let x = (i as f32 + 0.5) / n as f32;
            let (lobe, u) = choice.choose(3, Vec2::new(x, 0.7)).expect("a lobe");
            assert!(u.y == 0.7 && (0.0..1.0).contains(&u.x));
            sums[lobe].0 += 1.0 / n as f32;
            sums[lobe].1 += u.x / n as f32;
        }
        for (lobe, (chance, sum)) in sums.into_iter().enumerate() {
            // Sums of a hundred thousand numbers in single precision.
            assert!((chance - choice.of(lobe)).abs() < 1e-3, "{lobe}: {chance}");
            assert!(
                (sum / chance - 0.5).abs() < 1e-3,
                "{lobe}: {}",
                sum / chance
            );
        }
    }
}
