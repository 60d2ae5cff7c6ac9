//! A thin lens with its stop in it: the lens of textbooks and of `Camera "perspective"`.
//!
//! The ray map is the thick lens'; what is missing is the pupil. The stop is a disk in the (rear)
//! principal plane, as wide as focal length over f-number, and no rim cuts anything off. So the
//! center of perspective is the principal plane and not the entrance pupil, which lies 98 mm from it in a
//! 250 mm telephoto lens: parallax and the blur of near things are off by that.

use super::thick::Thick;
use crate::optics::lanes::{LaneMask, Lanes};
use crate::optics::lens::Lens;
use crate::optics::pupil::Spread;
use crate::optics::real::{Index, Mask, Number, Plain};
use crate::optics::trace::LensRay;

/// The paraxial map and a disk in the rear principal plane.
#[derive(Clone, Copy, Debug)]
pub struct Thin<B> {
    thick: Thick<B>,
    /// Of the disk, mm.
    radius: B,
}

impl<B: Plain> Thin<B> {
    /// Of `lens`, for rays aimed at the rear principal plane; `None` for a lens without focal length
    /// or f-number.
    pub fn new(lens: &Lens) -> Option<Thin<B>> {
        let cardinals = lens.paraxial().cardinals?;
        let radius = 0.5 * cardinals.focal_length.abs() / lens.paraxial().f_number?;
        Some(Thin {
            thick: Thick::new(lens, cardinals.rear_principal_plane)?,
            radius: B::round_from(radius),
        })
    }

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

    /// True where the point of the principal plane is in the disk.
    #[inline(always)]
    pub fn holds<T: Number<Base = B>>(&self, pupil: &[T; 2]) -> T::Mask {
        // A sample of the disk's very edge may be rounded out of it.
        let rounded = B::round_from(1.0 + 1e-6);
        let [x, y] = *pupil;
        (x * x + y * y).at_most(self.radius * self.radius * rounded)
    }
}

impl Thin<f32> {
    /// Maps `u` to the disk, the same for every film point.
    #[inline(always)]
    pub(super) fn sample<const N: usize>(&self, u: &[Lanes<N>; 2]) -> Spread<Lanes<N>> {
        let radius = self.radius;
        let [x, y] = concentric_disk(u);
        Spread {
            point: [x.times(radius), y.times(radius)],
            area: Lanes::splat(std::f32::consts::PI * radius * radius),
            lit: LaneMask::YES,
        }
    }
}

/// The unit square to the unit disk (Shirley and Chiu 1997), as
/// [`crate::math::sampling::concentric_disk`], to 2e-7.
#[inline(always)]
fn concentric_disk<const N: usize>(u: &[Lanes<N>; 2]) -> [Lanes<N>; 2] {
    let x = u[0].times(2.0).plus(-1.0);
    let y = u[1].times(2.0).plus(-1.0);
    let flat = (x.abs() - y.abs()).greater(0.0);
    let radius = Lanes::select(flat, x, y);
    let other = Lanes::select(flat, y, x);
    // In the very middle both are 0.
    let middle = radius.abs().at_most(0.0);
    let angle = Lanes::select(middle, radius, other / radius).times(std::f32::consts::FRAC_PI_4);
    let (sin, cos) = sin_cos(angle);
    let (near, far) = (radius * cos, radius * sin);
    [
        Lanes::select(flat, near, far),
        Lanes::select(flat, far, near),
    ]
}

/// Sine and cosine of angles up to π/4: Taylor's series, whose next terms are φ¹¹/11! < 2e-9 and
/// φ¹⁰/10! < 3e-8 there.
#[inline(always)]
fn sin_cos<const N: usize>(angle: Lanes<N>) -> (Lanes<N>, Lanes<N>) {
    let a2 = angle * angle;
    let series = |terms: [f32; 4]| {
        let s = a2.times(terms[3]).plus(terms[2]);
        let s = (a2 * s).plus(terms[1]);
        (a2 * s).plus(terms[0])
    };
    let sin = series([-1.0 / 6.0, 1.0 / 120.0, -1.0 / 5040.0, 1.0 / 362_880.0]);
    let cos = series([-0.5, 1.0 / 24.0, -1.0 / 720.0, 1.0 / 40320.0]);
    (angle + angle * a2 * sin, (a2 * cos).plus(1.0))
}
