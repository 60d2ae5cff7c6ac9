//! Smooth glass and mirrors with constant parameters: a BSDF of a single perfectly specular lobe, without the memory for others.

use super::fresnel::dielectric;
use super::specular::{FresnelSpecular, SpecularReflection, reflection_probability, refract};
use super::{BsdfSample, Lobe, of_specular};
use crate::math::color::is_black;
use crate::math::frame::Frame;
use crate::math::{Rgb, Vec2, Vec3};

/// See above.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Boundary {
    Glass(FresnelSpecular),
    Mirror(SpecularReflection),
}

/// A way that light takes from a boundary.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Way {
    /// Its unit direction.
    pub wi: Vec3,
    /// The part of the flux that takes it.
    pub share: Rgb,
    /// Relative refractive index: the side of `wi` over that of `wo`; 1 for reflection.
    pub eta: f32,
}

/// Those of a boundary, where they carry light.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Ways {
    reflected: Option<Way>,
    refracted: Option<Way>,
    /// Fresnel reflectance of glass.
    fresnel: f32,
}

impl Way {
    fn if_any(self) -> Option<Way> {
        (!is_black(self.share)).then_some(self)
    }

    /// Of the channel that has the most.
    fn flux(&self) -> f32 {
        self.share.max_element()
    }
}

impl Ways {
    /// One of them and its probability, by a number in [0, 1): see [`reflection_probability`].
    pub(crate) fn choose(&self, evenness: f32, u: f32) -> Option<(Way, f32)> {
        match (self.reflected, self.refracted) {
            (Some(reflected), Some(refracted)) => {
                let p = reflection_probability(self.fresnel, evenness);
                Some(match u < p {
                    true => (reflected, p),
                    false => (refracted, 1.0 - p),
                })
            }
            (one, other) => Some((one.or(other)?, 1.0)),
        }
    }

    /// The one that a layer's sight takes, and its probability, by a number in [0, 1]: by Fresnel reflectance alone, so that it may take one that
    /// carries nothing, and end there.
    pub(crate) fn seen(&self, u: f32) -> Option<(Way, f32)> {
        match u < self.fresnel {
            true => Some((self.reflected?, self.fresnel)),
            false => Some((self.refracted?, 1.0 - self.fresnel)),
        }
    }

    /// The brighter way, which is always taken where paths go both ways, and the fainter one with the chance with which it is, if there are two: the
    /// root of the ratio of their fluxes.
    pub(crate) fn both(&self) -> Option<(Way, (Way, f32))> {
        let (reflected, refracted) = (self.reflected?, self.refracted?);
        let (brighter, fainter) = match reflected.flux() > refracted.flux() {
            true => (reflected, refracted),
            false => (refracted, reflected),
        };
        let chance = (fainter.flux() / brighter.flux()).sqrt();
        Some((brighter, (fainter, chance)))
    }
}

impl Boundary {
    /// That of a surface with this lobe alone, if it is one.
    pub(crate) fn of(lobe: &Lobe) -> Option<Boundary> {
        match lobe {
            Lobe::FresnelSpecular(glass) => Some(Boundary::Glass(*glass)),
            Lobe::SpecularReflection(mirror) => Some(Boundary::Mirror(*mirror)),
            _ => None,
        }
    }

    /// Returns `true` if there may be two ways.
    pub(crate) fn is_glass(&self) -> bool {
        matches!(self, Boundary::Glass(_))
    }

    /// The ways from a point where the unit shading normal is `n`, for what arrives along `wo`.
    #[inline(always)]
    pub(crate) fn ways(&self, n: Vec3, wo: Vec3) -> Ways {
        let cosine = n.dot(wo);
        let reflected = |share: Rgb| Way {
            wi: 2.0 * cosine * n - wo,
            share,
            eta: 1.0,
        };
        let glass = match self {
            _ if cosine == 0.0 => return Ways::default(),
            Boundary::Mirror(mirror) => {
                let share = mirror.reflectance * mirror.fresnel.evaluate(cosine);
                return Ways {
                    reflected: reflected(share).if_any(),
                    ..Ways::default()
                };
            }
            Boundary::Glass(glass) => glass,
        };
        let (near, far, n) = match cosine > 0.0 {
            true => (glass.eta_a, glass.eta_b, n),
            false => (glass.eta_b, glass.eta_a, -n),
        };
        let (eta, fresnel) = (far / near, dielectric(cosine.abs(), near, far));
        let refracted = refract(wo, n, eta).and_then(|wi| {
            let share = glass.transmittance * (1.0 - fresnel);
            Way { wi, share, eta }.if_any()
        });
        Ways {
            reflected: reflected(glass.reflectance * fresnel).if_any(),
            refracted,
            fresnel,
        }
    }

    /// [`super::Bsdf::sample`], where that chooses as evenly as in [`super::Bsdf::even_out`].
    #[inline]
    pub(crate) fn sample(
        &self,
        frame: &Frame,
        evenness: f32,
        wo: Vec3,
        u: Vec2,
    ) -> Option<BsdfSample> {
        let local_wo = frame.to_local(wo);
        if local_wo.z == 0.0 {
            return None;
        }
        let local = match self {
            Boundary::Glass(glass) => {
                let glass = FresnelSpecular { evenness, ..*glass };
                glass.sample(local_wo, u.x)?
            }
            Boundary::Mirror(mirror) => mirror.sample(local_wo),
        };
        of_specular(frame, &local, 1.0, 0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bsdf::fresnel::Fresnel;
    use crate::math::hash::{mix2, unit_float};

    fn number(i: u64, k: u64) -> f32 {
        unit_float(mix2(i, k))
    }

    fn direction(i: u64, k: u64) -> Vec3 {
        let z = 2.0 * number(i, k) - 1.0;
        let (sin, cos) = (std::f32::consts::TAU * number(i, k + 1)).sin_cos();
        Vec3::new(cos, sin, 0.0) * (1.0 - z * z).sqrt() + z * Vec3::Z
    }

    fn glass(eta: f32) -> Boundary {
        Boundary::Glass(FresnelSpecular {
            reflectance: Rgb::new(0.9, 1.0, 0.5),
            transmittance: Rgb::new(1.0, 0.7, 0.8),
            eta_a: 1.0,
            eta_b: eta,
            evenness: 0.0,
        })
    }

    #[test]
    fn ways_are_those_of_the_lobe() {
        let mirror = Boundary::Mirror(SpecularReflection {
            reflectance: Rgb::new(0.9, 0.5, 0.1),
            fresnel: Fresnel::NoOp,
        });
        for boundary in [mirror, glass(1.5), glass(0.6), glass(2.4)] {
            for i in 0..10_000 {
                let (n, wo, u) = (direction(i, 0), direction(i, 2), number(i, 4));
                let frame = Frame::from_normal(n);
                let lobe = boundary.sample(&frame, 0.5, wo, Vec2::new(u, 0.0));
                let way = boundary.ways(n, wo).choose(0.5, u);
                let (lobe, (way, chance)) = (lobe.unwrap(), way.unwrap());
                assert_eq!(way.eta, lobe.eta);
                // Where little is refracted, sideways, roundings are as large as the cosine.
                let error = 1e-5 / lobe.wi.dot(n).abs();
                assert!((way.wi - lobe.wi).length() < error, "{way:?} {lobe:?}");
                let factor = lobe.f * (lobe.wi.dot(n).abs() / lobe.pdf);
                let flux = way.share / (chance * way.eta * way.eta);
                assert!((flux - factor).abs().max_element() < error * (1.0 + flux.max_element()));
            }
        }
    }

    #[test]
    fn both_ways_have_all_of_the_flux() {
        for i in 0..10_000 {
            let (n, wo) = (direction(i, 0), direction(i, 2));
            let Boundary::Glass(mut clear) = glass(1.5) else {
                unreachable!()
            };
            (clear.reflectance, clear.transmittance) = (Rgb::ONE, Rgb::ONE);
            let ways = Boundary::Glass(clear).ways(n, wo);
            let Some((brighter, (fainter, chance))) = ways.both() else {
                // Total reflection.
                let (way, chance) = ways.choose(1.0, number(i, 4)).unwrap();
                assert_eq!((way.share, chance, way.eta), (Rgb::ONE, 1.0, 1.0));
                continue;
            };
            assert!(brighter.flux() >= fainter.flux() && chance <= 1.0);
            assert!((brighter.flux() + fainter.flux() - 1.0).abs() < 1e-6);
        }
        let mirror = SpecularReflection {
            reflectance: Rgb::ONE,
            fresnel: Fresnel::NoOp,
        };
        assert!(
            Boundary::Mirror(mirror)
                .ways(Vec3::Z, Vec3::Z)
                .both()
                .is_none()
        );
    }
}
