//! A thin lens with its stop in it: the lens of textbooks and of `Camera "perspective"`.
//!
//! The ray map is the thick lens'; what is missing is the pupil. The stop is a disk in the (rear)
//! principal plane, as wide as focal length over f-number, and no rim cuts anything off. So the
//! centre of perspective is the principal plane and not the entrance pupil, which lies 98 mm from it in a
//! 250 mm telephoto lens: parallax and the blur of near things are off by that.

use super::thick::Thick;
use crate::optics::lens::Lens;
use crate::optics::real::{Number, Plain};
use crate::optics::trace::LensRay;

/// The paraxial map and a disk in the rear principal plane.
#[derive(Clone, Copy, Debug)]
pub struct Thin<B> {
    thick: Thick<B>,
    /// Square of the disk's radius, mm².
    radius2: B,
}

impl Thin<f64> {
    /// Of `lens`, for rays aimed at the plane at `plane_z`; `None` for a lens without focal length
    /// or f-number.
    pub fn new(lens: &Lens, plane_z: f64) -> Option<Thin<f64>> {
        let cardinals = lens.paraxial().cardinals?;
        let radius = 0.5 * cardinals.focal_length / lens.paraxial().f_number?;
        Some(Thin {
            thick: Thick::new(lens, plane_z)?,
            radius2: radius * radius,
        })
    }

    /// In another precision.
    pub fn rounded<B: Plain>(&self) -> Thin<B> {
        Thin {
            thick: self.thick.rounded(),
            radius2: B::round_from(self.radius2),
        }
    }

    /// Radius of the disk, mm.
    pub fn radius(&self) -> f64 {
        self.radius2.sqrt()
    }
}

impl<B: Plain> Thin<B> {
    /// The ray in the scene.
    #[inline(always)]
    pub fn ray<T: Number<Base = B>>(&self, film: &[T; 2], pupil: &[T; 2]) -> LensRay<T> {
        self.thick.ray(film, pupil)
    }

    /// Does the ray pass the disk?
    #[inline(always)]
    pub fn holds<T: Number<Base = B>>(&self, film: &[T; 2], pupil: &[T; 2]) -> T::Mask {
        let [x, y] = self.thick.height(film, pupil);
        (x * x + y * y).at_most(self.radius2)
    }
}
