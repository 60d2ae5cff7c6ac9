//! The lens as a table over the film radius, of polynomials in the pupil point.
//!
//! A lens is symmetric about its axis: film points at the same radius see the same, turned. So at each of 65 film
//! radii, `turn` and `offset` ([`Coordinates`]) are polynomials of the pupil point, fitted by least squares to rays
//! traced from there; between two radii the coefficients are interpolated linearly. Components
//! along the film point's azimuth are even in the pupil point's component across it, those across are odd.
//!
//! Degree 1 is a perfect lens at every film radius, with distortion, field curvature and astigmatism: what
//! remains of a stopped-down lens. Unlike the polynomial in film and pupil it suits steep distortion
//! (fisheyes); but every lane looks up other entries, so in lanes it costs more than its arithmetic.

use super::coordinates::Coordinates;
use super::least_squares::LeastSquares;
use super::rays::FitRay;
use super::shape::RADII;
use crate::optics::real::{Index, Plain};
use crate::optics::trace::LensRay;

/// A table of polynomials; see the module.
#[derive(Clone, Debug)]
pub struct Table<B> {
    coordinates: Coordinates<B>,
    degree: usize,
    /// Film radii per unit of the film input.
    nodes: B,
    /// At each film radius: pairs (turn, offset) for [`even`] monomials, then for odd ones.
    coefficients: Vec<B>,
}

/// Powers (a, b) of x^a·(y²)^b with a + 2b ≤ degree; `y` times those of one degree less are the odd ones.
fn even(degree: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..=degree / 2).flat_map(move |b| (0..=degree - 2 * b).map(move |a| (a, b)))
}

fn odd(degree: usize) -> impl Iterator<Item = (usize, usize)> {
    // Degree 0 has none.
    (degree > 0).then(|| even(degree - 1)).into_iter().flatten()
}

impl Table<f64> {
    /// Fits polynomials of `degree` to the rays of every film radius, film points on +x.
    pub fn fit(coordinates: Coordinates<f64>, degree: usize, rays: &[Vec<FitRay>]) -> Table<f64> {
        let mut coefficients = Vec::new();
        let mut last = vec![0.0; 2 * (even(degree).count() + odd(degree).count())];
        for node in rays {
            if !node.is_empty() {
                last = fit_node(&coordinates, degree, node);
            }
            // No ray gets through: what the last ones did.
            coefficients.extend(&last);
        }
        Table {
            coordinates,
            degree,
            nodes: RADII as f64,
            coefficients,
        }
    }

    /// In another precision.
    pub fn rounded<B: Plain>(&self) -> Table<B> {
        Table {
            coordinates: self.coordinates.rounded(),
            degree: self.degree,
            nodes: B::round_from(self.nodes),
            coefficients: self
                .coefficients
                .iter()
                .map(|x| B::round_from(*x))
                .collect(),
        }
    }
}

fn fit_node(coordinates: &Coordinates<f64>, degree: usize, rays: &[FitRay]) -> Vec<f64> {
    let solve = |axis: usize, powers: &[(usize, usize)]| {
        let rows = rays.iter().map(|ray| {
            let [_, [x, y]] = coordinates.inputs(&ray.film, &ray.pupil);
            let [turn, offset] = coordinates.outputs(&ray.scene);
            let front = if axis == 0 { 1.0 } else { y };
            let row = powers
                .iter()
                .map(|(a, b)| front * x.powi(*a as i32) * (y * y).powi(*b as i32));
            (row.collect(), [turn[axis], offset[axis]])
        });
        let [turn, offset] = LeastSquares::new(powers.len(), rows).solve();
        turn.into_iter().zip(offset).flat_map(|(t, o)| [t, o])
    };
    let even: Vec<_> = even(degree).collect();
    let odd: Vec<_> = odd(degree).collect();
    solve(0, &even).chain(solve(1, &odd)).collect()
}

impl<B: Plain> Table<B> {
    /// The degree in the pupil point.
    pub fn degree(&self) -> usize {
        self.degree
    }

    /// The ray in the scene.
    #[inline(always)]
    pub fn ray<T: Index<Base = B>>(&self, film: &[T; 2], pupil: &[T; 2]) -> LensRay<T> {
        let [h, q] = self.coordinates.inputs(film, pupil);
        // Off the exact middle, where any azimuth will do; one part in 1e12 of the film.
        let hx = h[0].plus(B::round_from(1e-12));
        let radius = (hx * hx + h[1] * h[1]).sqrt();
        let (cos, sin) = (hx / radius, h[1] / radius);
        let x = q[0] * cos + q[1] * sin;
        let y = q[1] * cos - q[0] * sin;
        let y2 = y * y;
        let (ring, t) = radius.times(self.nodes).place(RADII - 1);
        let stride = 2 * (even(self.degree).count() + odd(self.degree).count());
        let mut entry = 0;
        let mut polynomial = |degree: usize| {
            let mut sum = [T::constant(B::ZERO); 2];
            let mut in_y = T::constant(B::ONE);
            for b in 0..=degree / 2 {
                let mut power = in_y;
                for _ in 0..=degree - 2 * b {
                    for s in &mut sum {
                        let at = T::look_up(&self.coefficients, [(ring, stride)], entry);
                        let next = T::look_up(&self.coefficients, [(ring, stride)], entry + stride);
                        *s = *s + power * (at + t * (next - at));
                        entry += 1;
                    }
                    power = power * x;
                }
                in_y = in_y * y2;
            }
            sum
        };
        let [turn_x, offset_x] = polynomial(self.degree);
        let [turn_y, offset_y] = if self.degree > 0 {
            polynomial(self.degree - 1)
        } else {
            [T::constant(B::ZERO); 2]
        };
        let back = |along: T, across: T| {
            let across = across * y;
            [along * cos - across * sin, along * sin + across * cos]
        };
        self.coordinates
            .ray(back(turn_x, turn_y), back(offset_x, offset_y))
    }
}
