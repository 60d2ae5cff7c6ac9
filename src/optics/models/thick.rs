//! The lens near its axis: two principal planes, and pupils apart from them.
//!
//! A ray from the film meets the rear principal plane, continues from the front principal plane at the same
//! height, and turns by height over focal length; in a medium behind the lens its slope counts n' times. All rays through a point of the exit pupil's
//! plane then come from one point of the entrance pupil's plane, wherever that lies, so perspective and the blur
//! of near things are the real lens'. Aberrations and distortion are missing. The real
//! rims cut off what they do of the exact rays ([`super::LensModel`]).
//!
//! Source: Kolb, Mitchell and Hanrahan, "A Realistic Camera Model for Computer Graphics", SIGGRAPH 1995,
//! §3.3; Born and Wolf, *Principles of Optics*, 7th edition, §4.3.

use crate::optics::lens::Lens;
use crate::optics::real::{Number, Plain};
use crate::optics::trace::LensRay;

/// The paraxial map from film and pupil points to rays; see the module.
#[derive(Clone, Copy, Debug)]
pub struct Thick<B> {
    /// One over the distance from the plane aimed at to the film.
    per_distance: B,
    /// The same times the index behind the lens: what makes slopes there reduced angles.
    index_per_distance: B,
    /// From the rear principal plane to the film.
    film_distance: B,
    /// One over the focal length.
    power: B,
    /// z of the front principal plane.
    front: B,
}

impl<B: Plain> Thick<B> {
    /// Of `lens`, for rays aimed at the plane at `plane_z`; `None` for an afocal lens.
    pub fn new(lens: &Lens, plane_z: f64) -> Option<Thick<B>> {
        let cardinals = lens.paraxial().cardinals?;
        let per_distance = 1.0 / (lens.film_z() - plane_z);
        Some(Thick {
            per_distance: B::round_from(per_distance),
            index_per_distance: B::round_from(cardinals.index_behind * per_distance),
            film_distance: B::round_from(lens.film_z() - cardinals.rear_principal_plane),
            power: B::round_from(1.0 / cardinals.focal_length),
            front: B::round_from(cardinals.front_principal_plane),
        })
    }

    /// Where the ray crosses the principal planes, mm.
    #[inline(always)]
    pub fn height<T: Number<Base = B>>(&self, film: &[T; 2], pupil: &[T; 2]) -> [T; 2] {
        let height =
            |i: usize| film[i] - (film[i] - pupil[i]).times(self.per_distance * self.film_distance);
        [height(0), height(1)]
    }

    /// The ray in the scene; it starts at the first vertex' plane.
    #[inline(always)]
    pub fn ray<T: Number<Base = B>>(&self, film: &[T; 2], pupil: &[T; 2]) -> LensRay<T> {
        let height = self.height(film, pupil);
        // dx/dz in front of the lens: n' times that behind it, and what the lens adds.
        let slope = |i: usize| {
            (film[i] - pupil[i]).times(self.index_per_distance) + height[i].times(self.power)
        };
        let (u, v) = (slope(0), slope(1));
        let o = [
            height[0] - u.times(self.front),
            height[1] - v.times(self.front),
            T::constant(B::ZERO),
        ];
        LensRay::new(o, [-u, -v, T::constant(-B::ONE)])
    }
}
