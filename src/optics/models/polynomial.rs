//! The lens as a polynomial.
//!
//! Film point h and pupil point q (both pairs, about 1) go to the ray's `turn` and `offset`
//! ([`Coordinates`]). A lens is symmetric about its axis, so each output is h·A + q·B, where A and B are
//! polynomials of the three invariants h·h, h·q and q·q alone: 16, 40, 80, 140 coefficients for the degrees 3, 5, 7, 9
//! in place of the 140 to 2860 of a polynomial of four variables. Fitted by least squares to traced rays.
//!
//! Sources: Hullin, Hanika and Heidrich, "Polynomial Optics", EGSR 2012 (the idea, by Taylor expansion);
//! Hanika and Dachsbacher, "Efficient Monte Carlo Rendering with Realistic Lenses", Eurographics 2014 (fitting in
//! place of expanding); Schrade, Hanika and Dachsbacher, "Sparse high-degree polynomials for wide-angle lenses",
//! EGSR 2016. That an equivariant map needs the invariants only: Welford, *Aberrations of Optical Systems*, §7.1.

use super::coordinates::Coordinates;
use super::least_squares::LeastSquares;
use super::rays::FitRay;
use crate::optics::real::{Number, Plain};
use crate::optics::trace::LensRay;

/// Coefficients of one monomial of the invariants: of h and of q in `turn`, of h and of q in `offset`.
type Term<B> = [B; 4];

/// An equivariant polynomial; see the module.
#[derive(Clone, Debug)]
pub struct Polynomial<B> {
    coordinates: Coordinates<B>,
    degree: usize,
    /// In the order that evaluation meets them: powers of u, v, w from the highest down to 0.
    terms: Vec<Term<B>>,
}

/// Powers of (h·h, h·q, q·q) up to degree `order` together, each from the highest down.
fn powers(order: usize) -> impl Iterator<Item = [usize; 3]> {
    (0..=order).rev().flat_map(move |i| {
        (0..=order - i)
            .rev()
            .flat_map(move |j| (0..=order - i - j).rev().map(move |k| [i, j, k]))
    })
}

impl Polynomial<f64> {
    /// Fits a polynomial of the odd `degree` 1, 3, 5, … to `rays`.
    pub fn fit(coordinates: Coordinates<f64>, degree: usize, rays: &[FitRay]) -> Polynomial<f64> {
        let order = degree.saturating_sub(1) / 2;
        let powers: Vec<[usize; 3]> = powers(order).collect();
        let rows = rays.iter().flat_map(|ray| {
            let [h, q] = coordinates.inputs(&ray.film, &ray.pupil);
            let [turn, offset] = coordinates.outputs(&ray.scene);
            let dot = |a: [f64; 2], b: [f64; 2]| a[0] * b[0] + a[1] * b[1];
            let (u, v, w) = (dot(h, h), dot(h, q), dot(q, q));
            let values: Vec<f64> = powers
                .iter()
                .map(|p| u.powi(p[0] as i32) * v.powi(p[1] as i32) * w.powi(p[2] as i32))
                .collect();
            // Film radii are evenly spread, so that each stands for an area that grows with it; the middle
            // still counts for something.
            let weight = (u.sqrt() + 0.02).sqrt();
            [0, 1].map(|axis| {
                let row = values
                    .iter()
                    .flat_map(|x| [weight * x * h[axis], weight * x * q[axis]]);
                (row.collect(), [weight * turn[axis], weight * offset[axis]])
            })
        });
        let [turn, offset] = LeastSquares::new(2 * powers.len(), rows).solve();
        let terms = turn
            .chunks_exact(2)
            .zip(offset.chunks_exact(2))
            .map(|(t, o)| [t[0], t[1], o[0], o[1]])
            .collect();
        Polynomial {
            coordinates,
            degree: 2 * order + 1,
            terms,
        }
    }

    /// In another precision.
    pub fn rounded<B: Plain>(&self) -> Polynomial<B> {
        Polynomial {
            coordinates: self.coordinates.rounded(),
            degree: self.degree,
            terms: self.terms.iter().map(|t| t.map(B::round_from)).collect(),
        }
    }
}

impl<B: Plain> Polynomial<B> {
    /// The degree in h and q together.
    pub fn degree(&self) -> usize {
        self.degree
    }

    /// How many coefficients it has.
    pub fn coefficients(&self) -> usize {
        4 * self.terms.len()
    }

    /// The ray in the scene.
    #[inline(always)]
    pub fn ray<T: Number<Base = B>>(&self, film: &[T; 2], pupil: &[T; 2]) -> LensRay<T> {
        let [h, q] = self.coordinates.inputs(film, pupil);
        let u = h[0] * h[0] + h[1] * h[1];
        let v = h[0] * q[0] + h[1] * q[1];
        let w = q[0] * q[0] + q[1] * q[1];
        // Horner's scheme in u, of schemes in v, of schemes in w, for the four factors side by side.
        let order = (self.degree - 1) / 2;
        let mut terms = self.terms.iter();
        let mut next = || {
            terms
                .next()
                .copied()
                .unwrap_or([B::ZERO; 4])
                .map(T::constant)
        };
        let mut in_u = [T::constant(B::ZERO); 4];
        for i in (0..=order).rev() {
            let mut in_v = [T::constant(B::ZERO); 4];
            for j in (0..=order - i).rev() {
                let mut in_w = next();
                for _ in 0..order - i - j {
                    in_w = step(in_w, w, next());
                }
                in_v = step(in_v, v, in_w);
            }
            in_u = step(in_u, u, in_v);
        }
        let [a, b, c, d] = in_u;
        self.coordinates.ray(
            [h[0] * a + q[0] * b, h[1] * a + q[1] * b],
            [h[0] * c + q[0] * d, h[1] * c + q[1] * d],
        )
    }
}

/// `sum`·x + `term`, each by itself.
#[inline(always)]
fn step<T: Number>(sum: [T; 4], x: T, term: [T; 4]) -> [T; 4] {
    [
        sum[0] * x + term[0],
        sum[1] * x + term[1],
        sum[2] * x + term[2],
        sum[3] * x + term[3],
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn as_many_coefficients_as_the_symmetry_leaves() {
        for (degree, count) in [(1, 4), (3, 16), (5, 40), (7, 80), (9, 140)] {
            let c = Coordinates::new(1.0, 0.0, 1.0, 0.0);
            assert_eq!(Polynomial::fit(c, degree, &[]).coefficients(), count);
        }
    }

    /// A ray that is a known polynomial of its inputs is found again, and turns with them.
    #[test]
    fn a_polynomial_lens_is_found_again() {
        let c = Coordinates::new(2.0, 0.3, 1.5, 7.0);
        let mut truth = Polynomial::fit(c, 5, &[]);
        for (i, term) in truth.terms.iter_mut().enumerate() {
            *term = std::array::from_fn(|k| 0.1 * ((4 * i + k) as f64).cos());
        }
        let ray = |i: usize, turn: f64| {
            let r = |k: i32| 2.0 * (0.5 + i as f64 / 1.167_303_978f64.powi(k)).fract() - 1.0;
            let rotate = |[x, y]: [f64; 2]| {
                let (sin, cos) = turn.sin_cos();
                [cos * x - sin * y, sin * x + cos * y]
            };
            let (film, pupil) = (rotate([r(1), r(2)]), rotate([r(3), r(4)]));
            FitRay {
                film,
                pupil,
                scene: truth.ray(&film, &pupil),
            }
        };
        let rays: Vec<FitRay> = (0..400).map(|i| ray(i, 0.0)).collect();
        let found = Polynomial::fit(c, 5, &rays);
        for i in 400..500 {
            let (ray, turned) = (ray(i, 0.0), ray(i, 1.0));
            let again = found.ray(&ray.film, &ray.pupil);
            let single = found
                .rounded::<f32>()
                .ray(&ray.film.map(|x| x as f32), &ray.pupil.map(|x| x as f32));
            for k in 0..3 {
                assert!((again.d[k] - ray.scene.d[k]).abs() < 1e-11);
                assert!((again.o[k] - ray.scene.o[k]).abs() < 1e-10);
                // Some forty roundings of numbers below 1.
                assert!((f64::from(single.d[k]) - ray.scene.d[k]).abs() < 2e-6);
            }
            // Turning film and pupil turns the ray.
            let (sin, cos) = 1f64.sin_cos();
            let [l, m, n] = ray.scene.d;
            let expected = [cos * l - sin * m, sin * l + cos * m, n];
            for (found, expected) in turned.scene.d.iter().zip(expected) {
                assert!((found - expected).abs() < 1e-13);
            }
        }
    }
}
