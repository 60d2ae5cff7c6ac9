//! BSDFs, which describe how surfaces scatter light: lobes, and the [`Bsdf`] that sums them at a point (Pharr, Jakob
//! and Humphreys 2016, chapters 8 and 14; docs/scene-language.md §3.8).

mod boundary;
pub mod clearcoat;
mod coated;
pub mod disney_diffuse;
pub mod fourier;
pub mod fresnel;
pub mod fresnel_blend;
pub mod fresnel_moments;
pub mod hair;
pub mod lambertian;
#[cfg(test)]
mod laws;
pub mod lobe;
mod lobe_choice;
mod lobe_sample;
mod matte;
pub mod measured;
pub mod microfacet;
pub mod oren_nayar;
mod scatterer;
pub mod specular;
pub mod subsurface_exit;
#[cfg(test)]
pub(crate) mod testing;
pub mod trowbridge_reitz;

pub(crate) use boundary::{Boundary, Way};
pub(crate) use coated::{Coated, CoatedLobes};
pub use lobe::Lobe;
pub(crate) use matte::Matte;
use matte::ScattererSample;
pub(crate) use scatterer::{Scatterer, ScattererRows};

use crate::math::color::is_black;
use crate::math::frame::Frame;
use crate::math::{Rgb, Vec2, Vec3};
use crate::surface::{ReceiverSide, ShadingGeometry};
use arrayvec::ArrayVec;
use lobe_choice::LobeChoice;
use lobe_sample::LobeSample;
use std::ops::Range;

/// Maximum number of lobes at a point, as in pbrt-v3.
pub const MAX_LOBES: usize = 8;

/// The bidirectional scattering distribution function at a point: a sum of lobes around the shading normal. All
/// directions are unit vectors in render space that point away from the surface.
#[derive(Clone, Debug)]
pub struct Bsdf<'a> {
    /// Geometric normal: distinguishes reflection from transmission.
    ng: Vec3,
    frame: Frame,
    lobes: ArrayVec<Lobe<'a>, MAX_LOBES>,
    /// An outgoing direction, or NaN, and the probabilities of the lobes for it.
    known: (Vec3, LobeChoice),
}

/// A direction sampled from a BSDF.
#[derive(Clone, Copy, Debug)]
pub struct BsdfSample {
    /// Value, in 1/sr; for a specular sample, the factor of the delta distribution over the cosine: either way the
    /// estimate is f |cos| / pdf, with the cosine to the shading normal.
    pub f: Rgb,
    /// Sampled direction.
    pub wi: Vec3,
    /// Density per solid angle; for a specular sample, its probability.
    pub pdf: f32,
    /// `true` if the lobe is a delta distribution, which light sampling cannot match.
    pub specular: bool,
    /// `true` if the direction is transmitted through the surface.
    pub transmission: bool,
    /// Relative refractive index: `wi`'s side over `wo`'s; 1 for reflection. `f` of a transmission includes a factor
    /// 1/eta² for the scaling of radiance between media.
    pub eta: f32,
    /// Index of the sampled lobe.
    pub lobe: u8,
}

impl<'a> Bsdf<'a> {
    /// A BSDF without lobes, which is black. `ng` is the unit geometric normal.
    pub fn new(ng: Vec3, shading: &ShadingGeometry) -> Bsdf<'a> {
        let mut bsdf = Bsdf::empty();
        bsdf.set_frame(ng, shading);
        bsdf
    }

    /// An empty BSDF, to be filled in place, as it is large ([`crate::world::World::fill_bsdf`]).
    #[inline]
    pub fn empty() -> Bsdf<'a> {
        Bsdf {
            ng: Vec3::ZERO,
            frame: Frame {
                s: Vec3::ZERO,
                t: Vec3::ZERO,
                n: Vec3::ZERO,
            },
            lobes: ArrayVec::new(),
            known: (Vec3::NAN, LobeChoice::default()),
        }
    }

    /// Computes the probabilities of the lobes for light that leaves along `wo` once, for all densities and the sample that follow.
    #[inline]
    pub fn prepare(&mut self, wo: Vec3) {
        if self.lobes.len() > 1 {
            let choice = LobeChoice::new(&self.lobes, self.frame.to_local(wo));
            self.known = (wo, choice);
        }
    }

    /// Invalidates what [`Bsdf::prepare`] computed.
    #[inline]
    fn forget(&mut self) {
        self.known.0 = Vec3::NAN;
    }

    /// The probabilities of the lobes for light that leaves along `wo`.
    #[inline]
    fn choice(&self, wo: Vec3, local_wo: Vec3) -> LobeChoice {
        match self.known.0 == wo {
            true => self.known.1,
            false => LobeChoice::new(&self.lobes, local_wo),
        }
    }

    /// Sets the frame to that of a surface with the unit geometric normal `ng`.
    #[inline]
    pub fn set_frame(&mut self, ng: Vec3, shading: &ShadingGeometry) {
        self.forget();
        self.ng = ng;
        self.frame = Frame::from_normal_and_tangent(shading.n, shading.dpdu);
    }

    /// Adds a lobe; those beyond [`MAX_LOBES`] are dropped. Only mixes may have more, and they are warned about when
    /// the scene is read.
    pub fn add(&mut self, lobe: Lobe<'a>) {
        self.forget();
        let _ = self.lobes.try_push(lobe);
    }

    /// Adds some lobes.
    pub fn extend(&mut self, lobes: impl IntoIterator<Item = Lobe<'a>>) {
        lobes.into_iter().for_each(|lobe| self.add(lobe));
    }

    /// The number of lobes.
    pub fn lobe_count(&self) -> usize {
        self.lobes.len()
    }

    /// Scales what the lobes from index `first` on scatter by `share`.
    pub fn scale_from(&mut self, first: usize, share: Rgb) {
        self.forget();
        for lobe in self.lobes.iter_mut().skip(first) {
            *lobe = lobe.scaled(share);
        }
    }

    /// The shading frame.
    pub fn frame(&self) -> &Frame {
        &self.frame
    }

    /// The shading normal.
    pub fn shading_normal(&self) -> Vec3 {
        self.frame.n
    }

    /// Returns `true` if the BSDF has no lobes.
    #[cfg(any(test, feature = "internals"))]
    pub fn is_black(&self) -> bool {
        self.lobes.is_empty()
    }

    /// The share of light from everywhere that is scattered to any direction, where that is the same for all: of a sum of
    /// ideally diffuse lobes.
    pub fn diffuse_reflectance(&self) -> Option<Rgb> {
        self.lobes.iter().map(Lobe::diffuse_reflectance).sum()
    }

    /// Returns `true` if there is a lobe that light sampling can evaluate.
    pub fn has_non_specular(&self) -> bool {
        self.lobes.iter().any(|l| !l.is_specular())
    }

    /// Returns `true` if there is a perfectly specular lobe.
    pub fn has_specular(&self) -> bool {
        self.lobes.iter().any(Lobe::is_specular)
    }

    /// Returns `true` if there is a lobe that scatters into all directions.
    pub fn has_diffuse(&self) -> bool {
        self.lobes.iter().any(Lobe::is_diffuse)
    }

    /// The hemisphere whose light the non-specular lobes scatter to `wo`; BSDF sampling competes (MIS).
    pub fn receiver_side(&self, wo: Vec3) -> ReceiverSide {
        let through = |l: &Lobe| !l.is_specular() && l.scatters(true);
        if self.lobes.iter().any(through) {
            ReceiverSide::BothSides
        } else if wo.dot(self.ng) < 0.0 {
            ReceiverSide::Back
        } else {
            ReceiverSide::Front
        }
    }

    /// Value in 1/sr of all but the specular lobes. The geometric normal decides whether the pair of directions is
    /// reflection or transmission, the shading normal gives the cosines; black if `wo` is in the shading plane.
    pub fn f(&self, wo: Vec3, wi: Vec3) -> Rgb {
        self.f_of(0..self.lobes.len(), wo, wi)
    }

    /// The contribution to [`Bsdf::f`] of the lobes with these indices.
    pub fn f_of(&self, lobes: Range<usize>, wo: Vec3, wi: Vec3) -> Rgb {
        let (local_wo, local_wi) = (self.frame.to_local(wo), self.frame.to_local(wi));
        if local_wo.z == 0.0 {
            return Rgb::ZERO;
        }
        let transmit = self.transmits(wo, wi);
        let lobes = self.lobes.get(lobes).unwrap_or_default();
        let matching = lobes.iter().filter(|l| l.scatters(transmit));
        matching.map(|l| l.f(local_wo, local_wi)).sum()
    }

    /// Density with which [`Bsdf::sample`] samples `wi` from non-specular lobes.
    pub fn pdf(&self, wo: Vec3, wi: Vec3) -> f32 {
        let (local_wo, local_wi) = (self.frame.to_local(wo), self.frame.to_local(wi));
        if local_wo.z == 0.0 {
            return 0.0;
        }
        match &self.lobes[..] {
            [lobe] => lobe.pdf(local_wo, local_wi),
            lobes => {
                let choice = self.choice(wo, local_wo);
                let pdfs = lobes.iter().enumerate();
                pdfs.map(|(i, lobe)| choice.of(i) * lobe.pdf(local_wo, local_wi))
                    .sum()
            }
        }
    }

    /// [`Bsdf::f`] and [`Bsdf::pdf`] for one pair of directions, at less than the cost of both.
    pub fn f_and_pdf(&self, wo: Vec3, wi: Vec3) -> (Rgb, f32) {
        if let Some(matte) = self.matte(wo) {
            return matte.f_and_pdf(wi);
        }
        let (local_wo, local_wi) = (self.frame.to_local(wo), self.frame.to_local(wi));
        if local_wo.z == 0.0 {
            return (Rgb::ZERO, 0.0);
        }
        let transmit = self.transmits(wo, wi);
        match &self.lobes[..] {
            [lobe] => {
                let (f, pdf) = lobe.f_and_pdf(local_wo, local_wi);
                let f = if lobe.scatters(transmit) {
                    f
                } else {
                    Rgb::ZERO
                };
                (f, pdf)
            }
            _ => {
                let choice = self.choice(wo, local_wo);
                self.sums((usize::MAX, &choice), transmit, local_wo, local_wi)
            }
        }
    }

    /// What scatters toward `wo`, if that is diffuse reflection alone.
    #[inline(always)]
    pub(crate) fn matte(&self, wo: Vec3) -> Option<Matte> {
        match &self.lobes[..] {
            [Lobe::LambertianReflection(lobe)] => {
                Some(Matte::new(lobe.reflectance, self.ng, self.frame.n, wo))
            }
            _ => None,
        }
    }

    /// What scatters light, if that is a diffuse and a glossy reflection by a dielectric.
    #[inline(always)]
    pub(crate) fn coated(&self) -> Option<CoatedLobes> {
        CoatedLobes::of(&self.lobes)
    }

    /// Sums over all lobes except the one at index `but`: of values, and of densities by the lobes' chances; directions are local.
    #[inline(never)]
    fn sums(
        &self,
        (but, choice): (usize, &LobeChoice),
        transmit: bool,
        wo: Vec3,
        wi: Vec3,
    ) -> (Rgb, f32) {
        let (mut f, mut pdf) = (Rgb::ZERO, 0.0);
        for (i, lobe) in self.lobes.iter().enumerate().filter(|(i, _)| *i != but) {
            let counts = lobe.scatters(transmit);
            if !counts && !lobe.may_sample(wo, wi) {
                continue;
            }
            let of_lobe = lobe.f_and_pdf(wo, wi);
            if counts {
                f += of_lobe.0;
            }
            pdf += choice.of(i) * of_lobe.1;
        }
        (f, pdf)
    }

    /// Returns `true` if the directions are on opposite sides of the surface.
    #[inline]
    fn transmits(&self, wo: Vec3, wi: Vec3) -> bool {
        wi.dot(self.ng) * wo.dot(self.ng) <= 0.0
    }

    /// Returns `true` if [`Bsdf::sample`] uses its third number.
    pub fn needs_third(&self) -> bool {
        self.lobes.iter().any(Lobe::needs_third)
    }

    /// Samples a direction from one of the lobes, chosen by about how much each scatters; `third` and `u` in [0, 1). `None` if the
    /// sample contributes nothing.
    #[inline]
    pub fn sample(&self, wo: Vec3, third: f32, u: Vec2) -> Option<BsdfSample> {
        if let Some(matte) = self.matte(wo) {
            let (sample, is_lit) = matte.sample(self.frame.s, self.frame.t, u);
            return is_lit.then(|| BsdfSample::of_matte(&sample));
        }
        let local_wo = self.frame.to_local(wo);
        if local_wo.z == 0.0 {
            return None;
        }
        if let [Lobe::FresnelSpecular(boundary)] = &self.lobes[..] {
            // As below: there is nothing to choose from.
            return self.specular_sample(&boundary.sample(local_wo, u.x)?, 1.0, 0);
        }
        let choice = self.choice(wo, local_wo);
        let (chosen, u) = choice.choose(self.lobes.len(), u)?;
        let lobe = self.lobes.get(chosen)?;
        let local = lobe.sample(local_wo, third, u)?;
        if lobe.is_specular() {
            return self.specular_sample(&local, choice.of(chosen), chosen);
        }
        let wi = self.frame.to_world(local.wi);
        let transmit = self.transmits(wo, wi);
        let (mut f, mut pdf) = (Rgb::ZERO, choice.of(chosen) * local.pdf);
        if lobe.scatters(transmit) {
            f = local.f;
        }
        if self.lobes.len() > 1 {
            let others = self.sums((chosen, &choice), transmit, local_wo, local.wi);
            f += others.0;
            pdf += others.1;
        }
        (pdf > 0.0 && !is_black(f)).then_some(BsdfSample {
            f,
            pdf,
            ..BsdfSample::of_lobe(chosen, &local, wi)
        })
    }

    /// Chooses between reflection and refraction of smooth boundaries more evenly than by flux from now on: see
    /// [`FresnelSpecular`](specular::FresnelSpecular).
    pub fn even_out(&mut self, evenness: f32) {
        self.forget();
        for lobe in &mut self.lobes {
            if let Lobe::FresnelSpecular(boundary) = lobe {
                boundary.evenness = evenness;
            }
        }
    }

    /// Samples one of the specular lobes that reflect (`transmit` false) or transmit (true), all equally likely: `pdf`
    /// is one over their number.
    pub fn sample_specular(&self, wo: Vec3, transmit: bool, uc: f32) -> Option<BsdfSample> {
        let local_wo = self.frame.to_local(wo);
        if local_wo.z == 0.0 {
            return None;
        }
        let matching: ArrayVec<(usize, &Lobe<'_>), MAX_LOBES> = self
            .lobes
            .iter()
            .enumerate()
            .filter(|(_, l)| l.is_specular() && l.scatters(transmit))
            .collect();
        let last = matching.len().checked_sub(1)?;
        let chosen = ((uc * matching.len() as f32) as usize).min(last);
        let &(position, lobe) = matching.get(chosen)?;
        let local = lobe.specular_direction(local_wo, transmit)?;
        self.specular_sample(&local, 1.0 / matching.len() as f32, position)
    }

    fn specular_sample(&self, local: &LobeSample, chance: f32, lobe: usize) -> Option<BsdfSample> {
        of_specular(&self.frame, local, chance, lobe)
    }
}

/// As the perfectly specular lobe with this index has sampled it, which was chosen with this chance.
fn of_specular(frame: &Frame, local: &LobeSample, chance: f32, lobe: usize) -> Option<BsdfSample> {
    let wi = frame.to_world(local.wi);
    let sample = BsdfSample {
        pdf: local.pdf * chance,
        specular: true,
        ..BsdfSample::of_lobe(lobe, local, wi)
    };
    (sample.pdf > 0.0 && !is_black(sample.f)).then_some(sample)
}

impl BsdfSample {
    fn of_matte(sample: &ScattererSample) -> BsdfSample {
        BsdfSample {
            f: sample.f,
            wi: sample.wi,
            pdf: sample.pdf,
            specular: false,
            transmission: false,
            eta: 1.0,
            lobe: 0,
        }
    }

    /// As a lobe that is not specular has sampled it, toward `wi`.
    #[inline]
    fn of_lobe(lobe: usize, local: &LobeSample, wi: Vec3) -> BsdfSample {
        BsdfSample {
            f: local.f,
            wi,
            pdf: local.pdf,
            specular: false,
            transmission: local.transmission,
            eta: local.eta,
            lobe: lobe as u8,
        }
    }
}

#[cfg(test)]
mod tests;
