//! Pupil points for bundles of film points, and the whole way from film sample to weighted ray.

use super::dispatch::Kernel;
use super::lane::{LaneMask, Lanes};
use super::tracer::{FilmTracer, Traced};
use crate::optics::pupil::ExitPupil;
use crate::optics::real::{Index, Mask, Number};

/// Points of the exit pupil's plane to aim at.
#[derive(Clone, Copy, Debug)]
pub struct PupilSamples<const N: usize> {
    /// (x, y) on the pupil's plane, mm.
    pub point: [Lanes<N>; 2],
    /// The area each was drawn from uniformly, mm².
    pub area: Lanes<N>,
    /// Which film points any light reaches.
    pub lit: LaneMask<N>,
}

/// Rays into the scene and what they count for.
#[derive(Clone, Copy, Debug)]
pub struct WeightedRays<const N: usize> {
    /// The rays and which of them passed.
    pub traced: Traced<Lanes<N>>,
    /// Projected solid angle, sr, that each stands for: the factor between radiance and irradiance.
    pub projected_solid_angle: Lanes<N>,
}

impl FilmTracer {
    /// From film points (mm) and samples of the unit square to weighted rays: samples `pupil`, on whose
    /// plane this tracer aims, and traces. The same as [`ExitPupil::sample`] and [`crate::optics::Lens::trace_from_film`],
    /// in single precision.
    #[inline]
    pub fn rays<const N: usize>(
        &self,
        pupil: &ExitPupil,
        film: &[Lanes<N>; 2],
        u: &[Lanes<N>; 2],
    ) -> WeightedRays<N> {
        self.instructions(N).run(SampleAndTrace {
            tracer: self,
            pupil,
            film,
            u,
        })
    }

    /// The calculation of [`FilmTracer::rays`], for use inside a larger [`Kernel`].
    #[inline(always)]
    pub fn rays_inline<const N: usize>(
        &self,
        pupil: &ExitPupil,
        film: &[Lanes<N>; 2],
        u: &[Lanes<N>; 2],
    ) -> WeightedRays<N> {
        let samples = sample_pupil(pupil, film, u);
        let mut traced = self.trace_inline(film, &samples.point);
        traced.passed = traced.passed.and(samples.lit);
        WeightedRays {
            traced,
            projected_solid_angle: projected_solid_angle(
                self.to_plane(),
                film,
                &samples.point,
                samples.area,
            ),
        }
    }
}

struct SampleAndTrace<'a, const N: usize> {
    tracer: &'a FilmTracer,
    pupil: &'a ExitPupil,
    film: &'a [Lanes<N>; 2],
    u: &'a [Lanes<N>; 2],
}

impl<const N: usize> Kernel for SampleAndTrace<'_, N> {
    type Output = WeightedRays<N>;
    #[inline(always)]
    fn run(self) -> WeightedRays<N> {
        self.tracer.rays_inline(self.pupil, self.film, self.u)
    }
}

/// Projected solid angle, sr, that an area (mm²) at `pupil`, on the plane `to_plane` mm from the film, stands for,
/// seen from `film`: A·cos⁴θ/Z² (see [`crate::optics::pupil::projected_solid_angle`]).
#[inline(always)]
pub fn projected_solid_angle<const N: usize>(
    to_plane: f32,
    film: &[Lanes<N>; 2],
    pupil: &[Lanes<N>; 2],
    area: Lanes<N>,
) -> Lanes<N> {
    let (x, y) = (pupil[0] - film[0], pupil[1] - film[1]);
    let z2 = to_plane * to_plane;
    // Relative to the plane's distance: its fourth power would overflow for a distant pupil.
    let r = (x * x + y * y).times(1.0 / z2).plus(1.0);
    area.times(1.0 / z2) / (r * r)
}

/// Maps `u` to the regions of `pupil`, as [`ExitPupil::sample`] but for rounding.
#[inline(always)]
pub fn sample_pupil<const N: usize>(
    pupil: &ExitPupil,
    film: &[Lanes<N>; 2],
    u: &[Lanes<N>; 2],
) -> PupilSamples<N> {
    let found = pupil.sample_lanes(film, u);
    PupilSamples {
        point: found.point,
        area: found.area,
        lit: found.lit,
    }
}

/// Maps `u` to a disk of `radius` mm about the axis, the same for every film point.
#[inline(always)]
pub fn sample_disk<const N: usize>(radius: f32, u: &[Lanes<N>; 2]) -> PupilSamples<N> {
    let [x, y] = concentric_disk(u);
    PupilSamples {
        point: [x.times(radius), y.times(radius)],
        area: Lanes::splat(std::f32::consts::PI * radius * radius),
        lit: LaneMask::YES,
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
