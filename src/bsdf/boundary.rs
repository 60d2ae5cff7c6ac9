//! Smooth glass and mirrors with constant parameters: a BSDF of a single perfectly specular lobe, without the memory for others.

use super::specular::{FresnelSpecular, SpecularReflection};
use super::{BsdfSample, Lobe, of_specular};
use crate::math::frame::Frame;
use crate::math::{Vec2, Vec3};

/// See above.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Boundary {
    Glass(FresnelSpecular),
    Mirror(SpecularReflection),
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
