//! How surfaces scatter light: lobes, and the [`Bsdf`] that adds them up at one point
//! (Pharr, Jakob and Humphreys 2016, chapters 8 and 14; scene-language 3.8).

pub mod fresnel;
pub mod lambertian;
pub mod lobe;
pub mod microfacet;
pub mod oren_nayar;
pub mod specular;
#[cfg(test)]
pub(crate) mod testing;
pub mod trowbridge_reitz;

pub use lobe::Lobe;

use crate::math::color::is_black;
use crate::math::frame::Frame;
use crate::math::{Rgb, Vec2, Vec3};
use crate::surface::ShadingGeometry;
use arrayvec::ArrayVec;
use lobe::LobeSample;

/// Most lobes a material has.
pub const MAX_LOBES: usize = 8;

/// The scattering of light at one point: a sum of lobes around the shading normal.
/// All directions are unit vectors in render space that point away from the surface.
#[derive(Clone, Debug)]
pub struct Bsdf {
    /// Geometric normal: tells reflection from transmission.
    ng: Vec3,
    frame: Frame,
    lobes: ArrayVec<Lobe, MAX_LOBES>,
}

/// A direction drawn from a BSDF.
#[derive(Clone, Copy, Debug)]
pub struct BsdfSample {
    /// Value, in 1/sr; for a specular sample the delta's factor over the cosine: either way the
    /// estimate is f |cos| / pdf, the cosine to the shading normal.
    pub f: Rgb,
    /// Sampled direction.
    pub wi: Vec3,
    /// Density per solid angle; of a specular sample its probability.
    pub pdf: f32,
    /// Does it come from a lobe of single directions? Then light sampling cannot make it.
    pub specular: bool,
    /// Has it passed through the surface?
    pub transmission: bool,
    /// Refractive index on `wi`'s side over that on `wo`'s; 1 for reflection. `f` of a
    /// transmission holds a factor 1/eta² for the radiance's change with the medium.
    pub eta: f32,
}

impl Bsdf {
    /// Without lobes: black. `ng` is the unit geometric normal.
    pub fn new(ng: Vec3, shading: &ShadingGeometry) -> Bsdf {
        let frame = Frame::from_normal_and_tangent(shading.n, shading.dpdu);
        Bsdf {
            ng,
            frame,
            lobes: ArrayVec::new(),
        }
    }

    /// Adds a lobe; more than [`MAX_LOBES`] are left out.
    pub fn add(&mut self, lobe: Lobe) {
        // No material has that many: the mix of two halves is made by choosing, not by adding.
        let _ = self.lobes.try_push(lobe);
    }

    /// The shading normal.
    pub fn shading_normal(&self) -> Vec3 {
        self.frame.n
    }

    /// Is there any lobe?
    pub fn is_black(&self) -> bool {
        self.lobes.is_empty()
    }

    /// Is there a lobe that light sampling can find?
    pub fn has_non_specular(&self) -> bool {
        self.lobes.iter().any(|l| !l.is_specular())
    }

    /// Value in 1/sr of all but the specular lobes. The geometric normal decides whether the pair
    /// of directions reflects or transmits, the shading normal gives the cosines; black for `wo`
    /// in the shading plane.
    pub fn f(&self, wo: Vec3, wi: Vec3) -> Rgb {
        let (local_wo, local_wi) = (self.frame.to_local(wo), self.frame.to_local(wi));
        if local_wo.z == 0.0 {
            return Rgb::ZERO;
        }
        let transmit = wi.dot(self.ng) * wo.dot(self.ng) <= 0.0;
        let matching = self.lobes.iter().filter(|l| l.scatters(transmit));
        matching.map(|l| l.f(local_wo, local_wi)).sum()
    }

    /// Density with which [`Bsdf::sample`] draws `wi` other than from a specular lobe.
    pub fn pdf(&self, wo: Vec3, wi: Vec3) -> f32 {
        let (wo, wi) = (self.frame.to_local(wo), self.frame.to_local(wi));
        if wo.z == 0.0 || self.lobes.is_empty() {
            return 0.0;
        }
        self.lobes.iter().map(|l| l.pdf(wo, wi)).sum::<f32>() / self.lobes.len() as f32
    }

    /// Draws a direction from one of the lobes, all equally likely; `uc` and `u` in [0, 1).
    /// `None` where no light would come from the direction.
    pub fn sample(&self, wo: Vec3, uc: f32, u: Vec2) -> Option<BsdfSample> {
        let local_wo = self.frame.to_local(wo);
        if local_wo.z == 0.0 {
            return None;
        }
        let (lobe, uc) = choose(&self.lobes, uc)?;
        let local = lobe.sample(local_wo, uc, u)?;
        if lobe.is_specular() {
            return self.specular_sample(&local, 1.0 / self.lobes.len() as f32);
        }
        let wi = self.frame.to_world(local.wi);
        let f = self.f(wo, wi);
        let others = self.lobes.iter().filter(|l| !std::ptr::eq(*l, lobe));
        let pdf = (local.pdf + others.map(|l| l.pdf(local_wo, local.wi)).sum::<f32>())
            / self.lobes.len() as f32;
        let LobeSample {
            transmission, eta, ..
        } = local;
        (pdf > 0.0 && !is_black(f)).then_some(BsdfSample {
            f,
            wi,
            pdf,
            specular: false,
            transmission,
            eta,
        })
    }

    /// The direction of one of the specular lobes that reflect (`transmit` false) or transmit
    /// (true), all equally likely: `pdf` is one over their number.
    pub fn sample_specular(&self, wo: Vec3, transmit: bool, uc: f32) -> Option<BsdfSample> {
        let local_wo = self.frame.to_local(wo);
        if local_wo.z == 0.0 {
            return None;
        }
        let matching = self
            .lobes
            .iter()
            .filter(|l| l.is_specular() && l.scatters(transmit));
        let matching: ArrayVec<&Lobe, MAX_LOBES> = matching.collect();
        let (lobe, _) = choose(&matching, uc)?;
        let local = lobe.specular_direction(local_wo, transmit)?;
        self.specular_sample(&local, 1.0 / matching.len() as f32)
    }

    fn specular_sample(&self, local: &LobeSample, chance: f32) -> Option<BsdfSample> {
        let LobeSample {
            f,
            wi,
            pdf,
            transmission,
            eta,
        } = *local;
        let sample = BsdfSample {
            f,
            wi: self.frame.to_world(wi),
            pdf: pdf * chance,
            specular: true,
            transmission,
            eta,
        };
        (sample.pdf > 0.0 && !is_black(f)).then_some(sample)
    }
}

/// One of `items`, all equally likely, and `u` stretched for reuse.
fn choose<T>(items: &[T], u: f32) -> Option<(&T, f32)> {
    let scaled = u * items.len() as f32;
    let i = (scaled as usize).min(items.len().checked_sub(1)?);
    Some((
        &items[i],
        (scaled - i as f32).clamp(0.0, 1.0 - f32::EPSILON / 2.0),
    ))
}
