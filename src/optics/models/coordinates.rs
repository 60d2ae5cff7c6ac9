//! The numbers in which a lens is a smooth function: film point and pupil point on the one side, two
//! pairs for the ray in the scene on the other.

use crate::optics::real::{Number, Plain};
use crate::optics::trace::LensRay;

/// How film and pupil points become inputs of about 1, and outputs become a ray.
///
/// The ray is the pair `turn`, its direction (dx, dy)/(1 − dz) (the stereographic projection: smooth
/// for all directions but straight at the film, so that a fisheye may look backward), and the pair
/// `offset`, mm: where it passes the middle of the entrance pupil, in the plane perpendicular to it,
/// turned back to the lens' axes. Both are smooth for any lens, and turn with the film point.
#[derive(Clone, Copy, Debug)]
pub struct Coordinates<B> {
    /// One over the largest film radius.
    film_scale: B,
    /// Movement of the pupil's middle with the film point.
    drift: B,
    /// One over the pupil's size.
    pupil_scale: B,
    /// z of the entrance pupil.
    entrance: B,
}

impl Coordinates<f64> {
    /// For film points up to `film_radius` and pupil points up to `pupil_size` from a middle that
    /// moves by `drift` of the film point; rays pass near the axis at z = `entrance`. All in mm.
    pub fn new(film_radius: f64, drift: f64, pupil_size: f64, entrance: f64) -> Self {
        Coordinates {
            film_scale: 1.0 / film_radius,
            drift,
            pupil_scale: 1.0 / pupil_size,
            entrance,
        }
    }

    /// In another precision.
    pub fn rounded<B: Plain>(&self) -> Coordinates<B> {
        Coordinates {
            film_scale: B::round_from(self.film_scale),
            drift: B::round_from(self.drift),
            pupil_scale: B::round_from(self.pupil_scale),
            entrance: B::round_from(self.entrance),
        }
    }

    /// `turn` and `offset` of a ray: the inverse of [`Coordinates::ray`].
    pub fn outputs(&self, ray: &LensRay<f64>) -> [[f64; 2]; 2] {
        let [l, m, n] = ray.d;
        let turn = [l / (1.0 - n), m / (1.0 - n)];
        let v = [ray.o[0], ray.o[1], ray.o[2] - self.entrance];
        let along = v[0] * l + v[1] * m + v[2] * n;
        let w = v[2] - along * n;
        let offset = [
            v[0] - along * l + turn[0] * w,
            v[1] - along * m + turn[1] * w,
        ];
        [turn, offset]
    }
}

impl<B: Plain> Coordinates<B> {
    /// The film point and the pupil point, in units of their sizes.
    #[inline(always)]
    pub fn inputs<T: Number<Base = B>>(&self, film: &[T; 2], pupil: &[T; 2]) -> [[T; 2]; 2] {
        let q = |i: usize| (pupil[i] - film[i].times(self.drift)).times(self.pupil_scale);
        [
            [
                film[0].times(self.film_scale),
                film[1].times(self.film_scale),
            ],
            [q(0), q(1)],
        ]
    }

    /// The ray with this `turn` and `offset`; it starts where it is nearest to the first vertex.
    #[inline(always)]
    pub fn ray<T: Number<Base = B>>(&self, turn: [T; 2], offset: [T; 2]) -> LensRay<T> {
        let one = T::constant(B::ONE);
        let (two, [a, b], [x, y]) = (B::ONE + B::ONE, turn, offset);
        let k = T::constant(two) / (a * a + b * b + one);
        let d = [a * k, b * k, one - k];
        // The rotation that takes −z to d by the shortest way, on (x, y, 0).
        let w = d[0] * x + d[1] * y;
        let o = [x - a * w, y - b * w, w.plus(self.entrance)];
        let back = o[0] * d[0] + o[1] * d[1] + o[2] * d[2];
        LensRay {
            o: [o[0] - back * d[0], o[1] - back * d[1], o[2] - back * d[2]],
            d,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// To the pair of pairs and back: the same line.
        #[test]
        fn rays_come_back(
            o in prop::array::uniform3(-50.0..50.0f64),
            d in prop::array::uniform3(-1.0..1.0f64),
            entrance in -300.0..300.0f64,
        ) {
            let ray = LensRay::new(o, d);
            // Not straight at the film, where the projection ends.
            prop_assume!(ray.d.iter().all(|x| x.is_finite()) && ray.d[2] < 0.9);
            let c = Coordinates::new(20.0, 0.1, 5.0, entrance);
            let [turn, offset] = c.outputs(&ray);
            let back = c.ray(turn, offset);
            for i in 0..3 {
                // Rounding, over the 1 − dz > 0.1 that is divided by.
                prop_assert!((back.d[i] - ray.d[i]).abs() < 1e-14);
            }
            // The start lies on the line: the difference is along it.
            let v: [f64; 3] = std::array::from_fn(|i| back.o[i] - ray.o[i]);
            let along: f64 = (0..3).map(|i| v[i] * ray.d[i]).sum();
            let off = |(v, d): (&f64, f64)| (v - along * d).abs();
            prop_assert!(v.iter().zip(ray.d).map(off).all(|x| x < 1e-11), "{back:?} {ray:?}");
            // And nowhere on it is nearer to the vertex.
            let nearest: f64 = (0..3).map(|i| back.o[i] * back.d[i]).sum();
            prop_assert!(nearest.abs() < 1e-11);
        }
    }
}
