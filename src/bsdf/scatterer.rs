//! What is kept of a BSDF where many vertices are shaded side by side.

use super::matte::ScattererSample;
use crate::math::{Rgb, Vec2, Vec3};
use crate::surface::ReceiverSide;

/// A BSDF without transmission or perfectly specular lobes, for one outgoing direction: all that light and direction sampling ask, small
/// enough to be kept by the dozen, in functions without branches.
pub(crate) trait Scatterer: Copy {
    /// Many of them.
    type Rows<const N: usize>: ScattererRows<Self>;

    /// The geometric normal.
    fn geometric_normal(&self) -> Vec3;

    /// The shading normal.
    fn shading_normal(&self) -> Vec3;

    /// [`super::Bsdf::receiver_side`].
    fn receiver_side(&self) -> ReceiverSide;

    /// [`super::Bsdf::f_and_pdf`] for light from `wi`.
    fn f_and_pdf(&self, wi: Vec3) -> (Rgb, f32);

    /// [`super::Bsdf::sample`] in the frame with these axes along the surface; and whether there is a sample.
    fn sample(&self, s: Vec3, t: Vec3, u: Vec2) -> (ScattererSample, bool);

    /// The BSDF times the cosine, and the density, for light from `wi`.
    #[inline(always)]
    fn scattered_and_pdf(&self, wi: Vec3) -> (Rgb, f32) {
        let (f, pdf) = self.f_and_pdf(wi);
        (f * wi.dot(self.shading_normal()).abs(), pdf)
    }

    /// What the throughput of a path is multiplied by that continues along a sample.
    #[inline(always)]
    fn weight(&self, sample: &ScattererSample) -> Rgb {
        sample.f * (sample.wi.dot(self.shading_normal()).abs() / sample.pdf)
    }
}

/// Many side by side: a row for each number.
pub(crate) trait ScattererRows<S>: Default {
    /// The one at `i`.
    fn get(&self, i: usize) -> S;

    /// The shading normal of the one at `i`, turned to where light leaves to; before it is finished, if that is done later.
    fn turned_normal(&self, i: usize) -> Vec3;

    /// Replaces the one at `i`.
    fn set(&mut self, i: usize, scatterer: &S);
}
