//! A BSDF of one diffuse and one glossy reflection by a dielectric, as of plastic, for one outgoing direction: see
//! [`Scatterer`].

use super::fresnel::{Fresnel, dielectric};
use super::lambertian::LambertianReflection;
use super::lobe::Lobe;
use super::lobe_choice::{chances_of_two, choose_of_two};
use super::matte::ScattererSample;
use super::microfacet::MicrofacetReflection;
use super::scatterer::{Scatterer, ScattererRows};
use super::trowbridge_reitz::TrowbridgeReitz;
use crate::math::color::is_black;
use crate::math::frame::Frame;
use crate::math::rows::Rows3;
use crate::math::sampling::cosine_hemisphere;
use crate::math::{Rgb, Vec2, Vec3};
use crate::surface::ReceiverSide;

/// The two lobes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CoatedLobes {
    base: LambertianReflection,
    /// Scale of the glossy reflection.
    reflectance: Rgb,
    facets: TrowbridgeReitz,
    /// Refractive indices on the normal's side and on the other.
    eta: [f32; 2],
}

impl CoatedLobes {
    /// Those of a BSDF, if they are of these kinds and in this order.
    #[inline]
    pub(crate) fn of(lobes: &[Lobe]) -> Option<CoatedLobes> {
        let [
            Lobe::LambertianReflection(base),
            Lobe::MicrofacetReflection(coat),
        ] = lobes
        else {
            return None;
        };
        let &MicrofacetReflection {
            reflectance,
            distribution,
            fresnel: Fresnel::Dielectric { eta_i, eta_t },
        } = coat
        else {
            return None;
        };
        (!distribution.is_separable()).then_some(CoatedLobes {
            base: *base,
            reflectance,
            facets: distribution,
            eta: [eta_i, eta_t],
        })
    }
}

/// See above.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Coated {
    lobes: CoatedLobes,
    /// Geometric normal.
    ng: Vec3,
    frame: Frame,
    /// The outgoing direction, in the frame, and its cosine to the geometric normal.
    wo: Vec3,
    cos_ng: f32,
    /// Probabilities of the lobes.
    chances: [f32; 2],
}

impl Coated {
    /// On a surface with this geometric normal and shading frame, for light that leaves along `wo`.
    #[inline(always)]
    pub(crate) fn new(lobes: &CoatedLobes, ng: Vec3, frame: Frame, wo: Vec3) -> Coated {
        let local = frame.to_local(wo);
        let [eta_i, eta_t] = lobes.eta;
        let coat = lobes.reflectance * Rgb::splat(dielectric(local.z, eta_i, eta_t));
        Coated {
            lobes: *lobes,
            ng,
            frame,
            wo: local,
            cos_ng: wo.dot(ng),
            chances: chances_of_two(lobes.base.reflectance, coat),
        }
    }

    /// Sums over both lobes: of values, and of densities by their chances; `wi` is local.
    #[inline(always)]
    fn sums(&self, wi: Vec3) -> (Rgb, f32) {
        let CoatedLobes {
            base,
            reflectance,
            facets,
            eta: [eta_i, eta_t],
        } = self.lobes;
        let base = base.f_and_pdf(self.wo.z, wi.z);
        let facets = facets.reflection(self.wo, wi);
        let fresnel = Rgb::splat(dielectric(facets.cosine, eta_i, eta_t));
        let coat = reflectance * fresnel * facets.f;
        let pdf = self.chances[0] * base.1 + self.chances[1] * facets.pdf;
        (base.0 + coat, pdf)
    }

    #[inline(always)]
    fn transmits(&self, wi: Vec3) -> bool {
        wi.dot(self.ng) * self.cos_ng <= 0.0
    }
}

impl Scatterer for Coated {
    type Rows<const N: usize> = CoatedRows<N>;

    #[inline(always)]
    fn geometric_normal(&self) -> Vec3 {
        self.ng
    }

    #[inline(always)]
    fn shading_normal(&self) -> Vec3 {
        self.frame.n
    }

    #[inline(always)]
    fn receiver_side(&self) -> ReceiverSide {
        if self.cos_ng < 0.0 {
            ReceiverSide::Back
        } else {
            ReceiverSide::Front
        }
    }

    #[inline(always)]
    fn f_and_pdf(&self, wi: Vec3) -> (Rgb, f32) {
        let (f, pdf) = self.sums(self.frame.to_local(wi));
        let edge_on = self.wo.z == 0.0;
        let is_dark = self.transmits(wi) | edge_on;
        (
            if is_dark { Rgb::ZERO } else { f },
            if edge_on { 0.0 } else { pdf },
        )
    }

    /// The axes are those of its own frame.
    #[inline(always)]
    fn sample(&self, _: Vec3, _: Vec3, u: Vec2) -> (ScattererSample, bool) {
        let (is_base, u) = choose_of_two(self.chances, u);
        let base = cosine_hemisphere(u);
        let base = base.with_z(base.z.copysign(self.wo.z));
        let (coat, is_above) = self.lobes.facets.sample_reflection(self.wo, u);
        let local = if is_base { base } else { coat };
        let (f, pdf) = self.sums(local);
        let wi = self.frame.to_world(local);
        let may = !self.transmits(wi) & (self.wo.z != 0.0) & (is_base | is_above);
        let is_lit = may & (pdf > 0.0) & !is_black(f);
        (ScattererSample { f, wi, pdf }, is_lit)
    }
}

/// `N` of them side by side.
pub(crate) struct CoatedRows<const N: usize> {
    base: Rows3<N>,
    reflectance: Rows3<N>,
    /// Widths of the facets' distribution, and refractive indices.
    alpha: [[f32; N]; 2],
    eta: [[f32; N]; 2],
    ng: Rows3<N>,
    s: Rows3<N>,
    t: Rows3<N>,
    n: Rows3<N>,
    wo: Rows3<N>,
    cos_ng: [f32; N],
    chances: [[f32; N]; 2],
}

impl<const N: usize> Default for CoatedRows<N> {
    fn default() -> Self {
        CoatedRows {
            base: Rows3::default(),
            reflectance: Rows3::default(),
            alpha: [[1.0; N]; 2],
            eta: [[1.0; N]; 2],
            ng: Rows3::default(),
            s: Rows3::default(),
            t: Rows3::default(),
            n: Rows3::default(),
            wo: Rows3::default(),
            cos_ng: [0.0; N],
            chances: [[0.5; N]; 2],
        }
    }
}

impl<const N: usize> CoatedRows<N> {
    /// Sets lobes, for now alone.
    #[inline(always)]
    pub(crate) fn set_lobes(&mut self, i: usize, lobes: &CoatedLobes) {
        self.base.set(i, lobes.base.reflectance);
        self.reflectance.set(i, lobes.reflectance);
        (self.alpha[0][i], self.alpha[1][i]) = lobes.facets.widths();
        (self.eta[0][i], self.eta[1][i]) = (lobes.eta[0], lobes.eta[1]);
    }

    /// Sets all else of one that is [finished](CoatedRows::finish) later; `wo` is in render space.
    #[inline(always)]
    pub(crate) fn place(&mut self, i: usize, ng: Vec3, frame: &Frame, wo: Vec3) {
        self.ng.set(i, ng);
        self.s.set(i, frame.s);
        self.t.set(i, frame.t);
        self.n.set(i, frame.n);
        self.wo.set(i, wo);
    }

    /// Computes what depends on the outgoing direction.
    #[inline(always)]
    pub(crate) fn finish(&mut self, i: usize) {
        let Coated {
            lobes,
            ng,
            frame,
            wo,
            ..
        } = self.get(i);
        let coated = Coated::new(&lobes, ng, frame, wo);
        self.wo.set(i, coated.wo);
        self.cos_ng[i] = coated.cos_ng;
        (self.chances[0][i], self.chances[1][i]) = (coated.chances[0], coated.chances[1]);
    }
}

impl<const N: usize> ScattererRows<Coated> for CoatedRows<N> {
    #[inline(always)]
    fn get(&self, i: usize) -> Coated {
        Coated {
            lobes: CoatedLobes {
                base: LambertianReflection {
                    reflectance: self.base.get(i),
                },
                reflectance: self.reflectance.get(i),
                facets: TrowbridgeReitz::of_widths(self.alpha[0][i], self.alpha[1][i]),
                eta: [self.eta[0][i], self.eta[1][i]],
            },
            ng: self.ng.get(i),
            frame: Frame {
                s: self.s.get(i),
                t: self.t.get(i),
                n: self.n.get(i),
            },
            wo: self.wo.get(i),
            cos_ng: self.cos_ng[i],
            chances: [self.chances[0][i], self.chances[1][i]],
        }
    }

    #[inline(always)]
    fn turned_normal(&self, i: usize) -> Vec3 {
        // Not in the frame yet.
        let (n, wo) = (self.n.get(i), self.wo.get(i));
        n * 1_f32.copysign(n.dot(wo))
    }

    #[inline(always)]
    fn set(&mut self, i: usize, coated: &Coated) {
        self.set_lobes(i, &coated.lobes);
        self.place(i, coated.ng, &coated.frame, coated.wo);
        self.cos_ng[i] = coated.cos_ng;
        (self.chances[0][i], self.chances[1][i]) = (coated.chances[0], coated.chances[1]);
    }
}
