//! Rotationally symmetric aspheric surfaces: a conic and even powers of the distance from the axis.
//!
//! z(r) = c r² / (1 + √(1 − (1+k) c² r²)) + A₂ r² + A₄ r⁴ + … + A₁₆ r¹⁶, with c the curvature of the base sphere and
//! k the conic constant (0 sphere, −1 paraboloid, below it a hyperboloid, above an ellipsoid): the form of ISO
//! 10110-12 and of Zemax' "even asphere" (Smith, *Modern Optical Engineering*, 4th edition, §17.2).

use super::real::{Number, Plain};

/// How many even powers there are: r² to r¹⁶.
pub const TERMS: usize = 8;

/// What makes a surface of a prescription aspheric.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Asphere {
    /// Conic constant k.
    pub conic: f64,
    /// Coefficients of r², r⁴, … r¹⁶, in mm⁻¹, mm⁻³, … mm⁻¹⁵.
    pub terms: [f64; TERMS],
}

impl Asphere {
    /// All lengths times `factor`.
    pub fn scaled(mut self, factor: f64) -> Asphere {
        let mut power = factor;
        for a in &mut self.terms {
            // A mm^(1−2m): the sag grows by the factor where r does.
            power /= factor * factor;
            *a *= power;
        }
        self
    }
}

/// An aspheric surface ready for tracing in precision `B`. z is relative to its vertex.
#[derive(Clone, Copy, Debug)]
pub struct AsphericSurface<B> {
    curvature: B,
    /// 1 + k.
    one_plus_conic: B,
    terms: [B; TERMS],
    /// Longest step of the search and unit of its tolerance, mm.
    reach: B,
    /// A residual this small means that the point lies on the surface.
    tolerance: B,
}

/// Where a ray meets an aspheric surface, whether it does or not: see `residual`.
#[derive(Clone, Copy, Debug)]
pub struct Meeting<T> {
    /// The point.
    pub point: [T; 3],
    /// Unit normal, leaning toward the film.
    pub normal: [T; 3],
    /// How far the point lies off the surface, along the axis.
    pub residual: T,
    /// 1 − (1+k) c² r² there: the surface goes no farther out than where this is 0.
    pub inside: T,
}

/// Steps of Newton's method. It doubles the correct digits each time: from the conic, which real aspheres leave by less
/// than a tenth of their diameter, six reach rounding, one more makes derivatives (dual numbers) exact, one is spare.
const STEPS: usize = 8;

impl<B: Plain> AsphericSurface<B> {
    /// Of base radius `radius` (infinite for a plane) and clear radius `clear_radius`, mm.
    pub fn new(radius: f64, asphere: &Asphere, clear_radius: f64) -> AsphericSurface<B> {
        let reach = [clear_radius, radius.abs()]
            .into_iter()
            .find(|r| r.is_finite())
            // No bound at all: that of a telescope.
            .unwrap_or(1e4);
        AsphericSurface {
            curvature: B::round_from(1.0 / radius),
            one_plus_conic: B::round_from(1.0 + asphere.conic),
            terms: asphere.terms.map(B::round_from),
            reach: B::round_from(reach),
            // Some hundred roundings of numbers of the size of the reach.
            tolerance: B::round_from(reach) * B::EPSILON * B::round_from(256.0),
        }
    }

    /// See [`Meeting::residual`].
    pub fn tolerance(&self) -> B {
        self.tolerance
    }

    /// z at squared distance `r2` from the axis, its derivative by `r2`, and [`Meeting::inside`]. Beyond the surface's
    /// edge something finite, so that the search can come back from there.
    #[inline(always)]
    fn profile<T: Number<Base = B>>(&self, r2: T) -> (T, T, T) {
        let c = self.curvature;
        let inside = r2.times(-(self.one_plus_conic * c * c)).plus(B::ONE);
        // √|inside| without a comparison.
        let root = (inside * inside).sqrt().sqrt();
        let conic = r2.times(c) / root.plus(B::ONE);
        // Horner's rule for Σ A r^2m and its derivative Σ m A r^(2m−2).
        let (mut sum, mut slope) = (T::constant(B::ZERO), T::constant(B::ZERO));
        for a in self.terms.iter().rev() {
            slope = slope * r2 + sum;
            sum = (sum * r2).plus(*a);
        }
        let polynomial = sum * r2;
        let polynomial_slope = slope * r2 + sum;
        let conic_slope = T::constant(c * B::round_from(0.5)) / root;
        (conic + polynomial, conic_slope + polynomial_slope, inside)
    }

    /// z at distance `r` from the axis.
    pub fn sag(&self, r: B) -> B {
        self.profile(r * r).0
    }

    /// Where the line through `o`, z relative to the vertex, along the unit direction `d` meets the surface, near the
    /// vertex plane; `sign` is that of the direction's z. Newton's method in a fixed number of steps, each at most as
    /// long as the clear radius, from the meeting with the conic: it cannot run on for ever, and what it ends at is on the
    /// surface where the residual is at most [`AsphericSurface::tolerance`] and `inside` is positive. No step depends on a comparison, so
    /// rays can go side by side.
    #[inline(always)]
    pub fn meet<T: Number<Base = B>>(&self, o: [T; 3], d: [T; 3], sign: B) -> Meeting<T> {
        let [l, m, n] = d;
        let t = -o[2] / n;
        let (x0, y0) = (o[0] + t * l, o[1] + t * m);
        let c = self.curvature;
        // The conic c (r² + (1+k) z²) = 2 z, from the vertex plane (Welford, *Aberrations of Optical Systems*, §4.5).
        let f = (x0 * x0 + y0 * y0).times(c);
        let g = n - (x0 * l + y0 * m).times(c);
        let bend = (n * n).times(self.one_plus_conic - B::ONE).plus(B::ONE);
        let discriminant = g * g - f.times(c) * bend;
        // Where the line misses the conic, somewhere near.
        let root = (discriminant * discriminant).sqrt().sqrt().times(sign);
        let mut t = self.bounded(f / (g + root));
        for _ in 0..STEPS {
            let (x, y) = (x0 + t * l, y0 + t * m);
            let (sag, slope, _) = self.profile(x * x + y * y);
            let residual = t * n - sag;
            let descent = n - (slope * (x * l + y * m)).times(B::ONE + B::ONE);
            t = t - self.bounded(residual / descent);
        }
        let point = [x0 + t * l, y0 + t * m, t * n];
        let (sag, slope, inside) = self.profile(point[0] * point[0] + point[1] * point[1]);
        Meeting {
            point,
            normal: normal(point[0], point[1], slope),
            residual: point[2] - sag,
            inside,
        }
    }

    /// Unit normal above (x, y), leaning toward the film.
    pub fn normal<T: Number<Base = B>>(&self, x: T, y: T) -> [T; 3] {
        let (_, slope, _) = self.profile(x * x + y * y);
        normal(x, y, slope)
    }

    /// The step, shortened smoothly to less than the reach.
    #[inline(always)]
    fn bounded<T: Number<Base = B>>(&self, step: T) -> T {
        let relative = step.times(B::ONE / self.reach);
        step / (relative * relative).plus(B::ONE).sqrt()
    }
}

/// Unit normal above (x, y) of a surface whose z has this derivative by x² + y².
#[inline(always)]
fn normal<T: Number>(x: T, y: T, slope: T) -> [T; 3] {
    let one = T::Base::ONE;
    let lean = -slope.times(one + one);
    let (a, b) = (x * lean, y * lean);
    let length = (a * a + b * b).plus(one).sqrt();
    [a / length, b / length, T::constant(one) / length]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::real::{Dual, Number};
    use crate::optics::{LensRay, LensTracer, Surface};
    use proptest::prelude::*;

    /// The rear surface of the Noct 58 mm f/0.95 (WO 2019/229849, example 1).
    const NOCT: (f64, [f64; TERMS]) = (
        52.858,
        [
            0.0,
            3.18645e-6,
            -1.14718e-8,
            7.74567e-11,
            -2.24225e-13,
            3.3479e-16,
            -1.7047e-19,
            0.0,
        ],
    );

    fn noct<B: Plain>() -> AsphericSurface<B> {
        AsphericSurface::new(
            NOCT.0,
            &Asphere {
                conic: 0.0,
                terms: NOCT.1,
            },
            15.6,
        )
    }

    #[test]
    fn a_paraboloid_and_a_sphere_have_their_known_sags() {
        let conic = |k| {
            AsphericSurface::<f64>::new(
                50.0,
                &Asphere {
                    conic: k,
                    ..Asphere::default()
                },
                20.0,
            )
        };
        // r²/2R, and R − √(R² − r²) of the 3-4-5 triangle.
        assert!((conic(-1.0).sag(10.0) - 1.0).abs() < 1e-15);
        assert!((conic(0.0).sag(30.0) - 10.0).abs() < 1e-14);
        let a4 = AsphericSurface::<f64>::new(
            f64::INFINITY,
            &Asphere {
                conic: 0.0,
                terms: [1e-3, 2e-6, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
            },
            20.0,
        );
        assert!((a4.sag(10.0) - (0.1 + 0.02)).abs() < 1e-15);
    }

    #[test]
    fn parallel_rays_on_a_paraboloid_meet_it_where_it_is() {
        let s = AsphericSurface::<f64>::new(
            -50.0,
            &Asphere {
                conic: -1.0,
                ..Asphere::default()
            },
            200.0,
        );
        for x in [0.0f64, 1.0, 30.0, 150.0] {
            let m = s.meet([x, 0.0, 7.0], [0.0, 0.0, -1.0], -1.0);
            assert!((m.point[2] + x * x / 100.0).abs() < 1e-12, "{x}");
            // Slope x/R of the profile.
            assert!((m.normal[0] / m.normal[2] - x / 50.0).abs() < 1e-13);
            assert!(m.residual.abs() <= s.tolerance() && m.inside > 0.0);
        }
    }

    #[test]
    fn single_precision_finds_the_same_point() {
        let (wide, narrow) = (noct::<f64>(), noct::<f32>());
        for (x, l) in [(0.0, 0.3), (8.0, -0.4), (-14.0, 0.2), (15.0, 0.0)] {
            let d = [l, 0.1, -(1.0f64 - l * l - 0.01).sqrt()];
            let a = wide.meet([x, 2.0, 3.0], d, -1.0);
            let b = narrow.meet([x as f32, 2.0, 3.0], d.map(|v| v as f32), -1.0);
            assert!(a.residual.abs() <= wide.tolerance());
            assert!(b.residual.abs() <= narrow.tolerance());
            for i in 0..3 {
                // Some roundings of 15 mm in 24 bits.
                assert!((a.point[i] - f64::from(b.point[i])).abs() < 5e-6);
                assert!((a.normal[i] - f64::from(b.normal[i])).abs() < 1e-6);
            }
        }
    }

    #[test]
    fn derivatives_are_those_of_the_meeting_point() {
        let s = noct::<f64>();
        let d = [0.2, -0.1, -(1.0f64 - 0.05).sqrt()];
        let at = |x: f64| s.meet([x, 3.0, 5.0], d, -1.0).point[2];
        let m = s.meet(
            [
                Dual::parameter(9.0, 0),
                Number::constant(3.0),
                Number::constant(5.0),
            ],
            d.map(Number::constant),
            -1.0,
        );
        // Central difference: 1e-5² of truncation.
        let difference = (at(9.0 + 1e-5) - at(9.0 - 1e-5)) / 2e-5;
        assert!((m.point[2].by[0] - difference).abs() < 1e-8);
    }

    #[test]
    fn scaling_scales_the_sag() {
        let a = Asphere {
            conic: -0.7,
            terms: NOCT.1,
        };
        let s = AsphericSurface::<f64>::new(52.858, &a, 15.6);
        let t = AsphericSurface::<f64>::new(2.0 * 52.858, &a.scaled(2.0), 31.2);
        assert!((t.sag(20.0) / (2.0 * s.sag(10.0)) - 1.0).abs() < 1e-14);
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2000))]

        /// Whatever the surface and the line: where the search says it has met the surface, it has.
        #[test]
        fn a_meeting_is_on_the_line_and_on_the_surface(
            radius in prop_oneof![-100.0..-5.0f64, 5.0..100.0f64],
            conic in -5.0..5.0f64,
            a4 in -1e-3..1e-3f64,
            a6 in -1e-6..1e-6f64,
            x in -20.0..20.0f64,
            l in -0.9..0.9f64,
        ) {
            let mut terms = [0.0; TERMS];
            (terms[1], terms[2]) = (a4, a6);
            let s = AsphericSurface::<f64>::new(radius, &Asphere { conic, terms }, 20.0);
            let d = [l, 0.0, (1.0 - l * l).sqrt()];
            let m = s.meet([x, 1.0, -10.0], d, 1.0);
            let on = m.residual.abs() <= s.tolerance() && m.inside > 0.0;
            if on {
                let t = (m.point[2] + 10.0) / d[2];
                prop_assert!((x + t * l - m.point[0]).abs() < 1e-9 * (1.0 + t.abs()));
                let r2 = m.point[0].powi(2) + m.point[1].powi(2);
                let c = 1.0 / radius;
                let sag = c * r2 / (1.0 + (1.0 - (1.0 + conic) * c * c * r2).sqrt()) + a4 * r2 * r2 + a6 * r2.powi(3);
                prop_assert!((sag - m.point[2]).abs() < 1e-9 * (1.0 + sag.abs()));
                let length: f64 = m.normal.iter().map(|v| v * v).sum();
                prop_assert!((length - 1.0).abs() < 1e-12);
            }
        }

        /// Whatever the surface and the ray: tracing ends, and what passes is finite and inside the aperture.
        #[test]
        fn tracing_wild_aspheres_never_returns_nonsense(
            radius in prop_oneof![Just(f64::INFINITY), -50.0..50.0f64, Just(1e-3), Just(-1e9)],
            conic in prop_oneof![-10.0..10.0f64, Just(1e12), Just(-1e12)],
            terms in prop::array::uniform8(prop_oneof![Just(0.0), -1.0..1.0f64, -1e-6..1e-6f64, Just(1e300)]),
            o in prop::array::uniform3(prop_oneof![-30.0..30.0f64, Just(f64::NAN), Just(1e300)]),
            d in prop::array::uniform3(prop_oneof![-1.0..1.0f64, Just(0.0), Just(f64::INFINITY)]),
        ) {
            let surface = Surface {
                radius,
                index: 1.7,
                aperture: 20.0,
                asphere: Some(Asphere { conic, terms }),
                ..Surface::default()
            };
            let tracer = LensTracer::<f64>::new(&[surface]);
            for ray in [LensRay::new(o, d), LensRay { o, d }] {
                for out in [tracer.to_scene(&ray), tracer.to_film(&ray)].into_iter().flatten() {
                    prop_assert!(out.o.iter().chain(&out.d).all(|x| x.is_finite()));
                    prop_assert!(out.o[0].hypot(out.o[1]) <= 10.0 * (1.0 + 1e-12));
                }
            }
        }

        /// A ray that passes comes back the way it came.
        #[test]
        fn paths_through_aspheres_are_reversible(
            conic in -2.0..2.0f64,
            a4 in -1e-5..1e-5f64,
            x in -8.0..8.0f64,
            l in -0.2..0.2f64,
        ) {
            let mut terms = [0.0; TERMS];
            terms[1] = a4;
            let front = Surface {
                radius: 30.0,
                thickness: 5.0,
                index: 1.6,
                aperture: 20.0,
                asphere: Some(Asphere { conic, terms }),
                ..Surface::default()
            };
            let back = Surface { radius: -40.0, aperture: 20.0, ..Surface::default() };
            let tracer = LensTracer::<f64>::new(&[front, back]);
            let start = LensRay::new([x, 0.5, 20.0], [l, 0.05, -1.0]);
            let Ok(out) = tracer.to_scene(&start) else { return Ok(()) };
            let Ok(back) = tracer.to_film(&LensRay { o: out.o, d: out.d.map(|v| -v) }) else {
                return Ok(());
            };
            for i in 0..3 {
                // No ray here grazes.
                prop_assert!((back.d[i] + start.d[i]).abs() < 1e-11);
            }
        }
    }
}
