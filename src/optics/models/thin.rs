//! A thin lens with its stop in it: the lens of textbooks and of `Camera "perspective"`.
//!
//! The ray map is the thick lens'; what is missing is the pupil. The stop is a disk in the (rear)
//! principal plane, as wide as focal length over f-number, and no rim cuts anything off. So the
//! center of perspective is the principal plane and not the entrance pupil, which lies 98 mm from it in a
//! 250 mm telephoto lens: parallax and the blur of near things are off by that.

use super::thick::Thick;
use crate::optics::lens::Lens;
use crate::optics::real::{Number, Plain};
use crate::optics::trace::LensRay;

/// The paraxial map and a disk in the rear principal plane.
#[derive(Clone, Copy, Debug)]
pub struct Thin<B> {
    thick: Thick<B>,
    /// Of the disk, mm.
    radius: B,
}

impl Thin<f64> {
    /// Of `lens`, for rays aimed at the rear principal plane; `None` for a lens without focal length
    /// or f-number.
    pub fn new(lens: &Lens) -> Option<Thin<f64>> {
        let cardinals = lens.paraxial().cardinals?;
        Some(Thin {
            thick: Thick::new(lens, cardinals.rear_principal_plane)?,
            radius: 0.5 * cardinals.focal_length.abs() / lens.paraxial().f_number?,
        })
    }

    /// In another precision.
    pub fn rounded<B: Plain>(&self) -> Thin<B> {
        Thin {
            thick: self.thick.rounded(),
            radius: B::round_from(self.radius),
        }
    }
}

impl<B: Plain> Thin<B> {
    /// Radius of the disk, mm.
    #[inline(always)]
    pub fn radius(&self) -> B {
        self.radius
    }

    /// The ray in the scene.
    #[inline(always)]
    pub fn ray<T: Number<Base = B>>(&self, film: &[T; 2], pupil: &[T; 2]) -> LensRay<T> {
        self.thick.ray(film, pupil)
    }

    /// Is the point of the principal plane in the disk?
    #[inline(always)]
    pub fn holds<T: Number<Base = B>>(&self, pupil: &[T; 2]) -> T::Mask {
        // A sample of the disk's very edge may be rounded out of it.
        let rounded = B::round_from(1.0 + 1e-6);
        let [x, y] = *pupil;
        (x * x + y * y).at_most(self.radius * self.radius * rounded)
    }
}
