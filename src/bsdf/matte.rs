//! A BSDF of one diffuse reflection, for one outgoing direction: all that light sampling asks of most surfaces, and small enough to be
//! kept by the dozen and evaluated side by side.

use super::lambertian::LambertianReflection;
use super::scatterer::{Scatterer, ScattererRows};
use crate::math::color::is_black;
use crate::math::frame::Frame;
use crate::math::rows::Rows3;
use crate::math::sampling::cosine_hemisphere;
use crate::math::{Rgb, Vec2, Vec3};
use crate::surface::ReceiverSide;

/// See above.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Matte {
    pub(super) lobe: LambertianReflection,
    /// Geometric normal.
    pub(super) ng: Vec3,
    /// Shading normal.
    pub(super) n: Vec3,
    /// Of the outgoing direction, to either.
    pub(super) cos_ng: f32,
    pub(super) cos_n: f32,
}

/// A direction sampled from one, as in [`super::BsdfSample`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct ScattererSample {
    pub f: Rgb,
    pub wi: Vec3,
    pub pdf: f32,
}

impl Matte {
    /// On a surface with these normals, for light that leaves along `wo`.
    #[inline(always)]
    pub(crate) fn new(reflectance: Rgb, ng: Vec3, n: Vec3, wo: Vec3) -> Matte {
        Matte {
            lobe: LambertianReflection { reflectance },
            ng,
            n,
            cos_ng: wo.dot(ng),
            cos_n: wo.dot(n),
        }
    }

    /// The share of light that is scattered.
    #[inline(always)]
    pub(crate) fn reflectance(&self) -> Rgb {
        self.lobe.reflectance
    }
}

impl Scatterer for Matte {
    type Rows<const N: usize> = MatteRows<N>;

    #[inline(always)]
    fn geometric_normal(&self) -> Vec3 {
        self.ng
    }

    #[inline(always)]
    fn shading_normal(&self) -> Vec3 {
        self.n
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
        let (f, pdf) = self.lobe.f_and_pdf(self.cos_n, wi.dot(self.n));
        let transmits = wi.dot(self.ng) * self.cos_ng <= 0.0;
        let edge_on = self.cos_n == 0.0;
        (
            if transmits | edge_on { Rgb::ZERO } else { f },
            if edge_on { 0.0 } else { pdf },
        )
    }

    #[inline(always)]
    fn sample(&self, s: Vec3, t: Vec3, u: Vec2) -> (ScattererSample, bool) {
        let local = cosine_hemisphere(u);
        let local = local.with_z(local.z.copysign(self.cos_n));
        let (f, pdf) = self.lobe.f_and_pdf(self.cos_n, local.z);
        let wi = Frame { s, t, n: self.n }.to_world(local);
        let transmits = wi.dot(self.ng) * self.cos_ng <= 0.0;
        let is_lit = !transmits & (self.cos_n != 0.0) & (pdf > 0.0) & !is_black(f);
        (ScattererSample { f, wi, pdf }, is_lit)
    }
}

/// `N` of them side by side.
pub(crate) struct MatteRows<const N: usize> {
    reflectance: Rows3<N>,
    ng: Rows3<N>,
    n: Rows3<N>,
    cos_ng: [f32; N],
    cos_n: [f32; N],
}

impl<const N: usize> Default for MatteRows<N> {
    fn default() -> Self {
        MatteRows {
            reflectance: Rows3::default(),
            ng: Rows3::default(),
            n: Rows3::default(),
            cos_ng: [0.0; N],
            cos_n: [0.0; N],
        }
    }
}

impl<const N: usize> MatteRows<N> {
    /// Sets a reflectance, for now alone.
    #[inline(always)]
    pub(crate) fn set_reflectance(&mut self, i: usize, reflectance: Rgb) {
        self.reflectance.set(i, reflectance);
    }

    /// That of the one at `i`.
    #[inline(always)]
    pub(crate) fn reflectance(&self, i: usize) -> Rgb {
        self.reflectance.get(i)
    }
}

impl<const N: usize> ScattererRows<Matte> for MatteRows<N> {
    #[inline(always)]
    fn get(&self, i: usize) -> Matte {
        Matte {
            lobe: LambertianReflection {
                reflectance: self.reflectance.get(i),
            },
            ng: self.ng.get(i),
            n: self.n.get(i),
            cos_ng: self.cos_ng[i],
            cos_n: self.cos_n[i],
        }
    }

    #[inline(always)]
    fn turned_normal(&self, i: usize) -> Vec3 {
        self.n.get(i) * 1_f32.copysign(self.cos_n[i])
    }

    #[inline(always)]
    fn set(&mut self, i: usize, matte: &Matte) {
        self.reflectance.set(i, matte.lobe.reflectance);
        self.ng.set(i, matte.ng);
        self.n.set(i, matte.n);
        self.cos_ng[i] = matte.cos_ng;
        self.cos_n[i] = matte.cos_n;
    }
}
