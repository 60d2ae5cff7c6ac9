//! Lenses that are cheaper than the traced one, and how wrong they are.
//!
//! | model | direction and start of a ray | vignetting |
//! |---|---|---|
//! | `exact` | traced through every surface | every rim |
//! | `polynomial` | a polynomial in film and pupil point ([`polynomial`]) | measured pupil shape ([`shape`]) |
//! | `table` | per film radius, a polynomial in the pupil point ([`table`]) | measured pupil shape |
//! | `thick` | principal planes ([`thick`]) | measured pupil shape |
//! | `thin` | principal planes ([`thin`]) | a disk in the principal plane |
//!
//! All map a film point and a point of one plane (the one that [`crate::optics::ExitPupil`] samples) to a ray in
//! lens coordinates, for one number or a bundle ([`Number`]), with derivatives or without. [`error`] measures a model
//! against exact rays; [`automatic`] takes the cheapest that is good enough. `docs/lens-models.md` has the figures
//! for twelve lenses. In lanes an exact ray costs about 1.05 ns a surface, `thick` 6 ns and a polynomial 11 to 46 (degrees 3 to
//! 9). So exact is the cheapest of all that are right to a tenth of a pixel, but for zoom lenses of 30 surfaces; below 17
//! surfaces only `thick` and degree 3 cost less. One ray at a time, without lanes, polynomials are three to eight times as fast
//! as exact tracing.
//!
//! ```
//! use fstop::optics::models::{ModelKind, Models};
//! use fstop::optics::{ExitPupil, Lens, Prescription};
//!
//! let prescription = Prescription::parse("50 5 1.5168 20\n-50 2 1 20\n0 0 0 10\n")?;
//! let lens = Lens::new(&prescription, Lens::focused(&prescription, 1000.0)?)?;
//! let pupil = ExitPupil::new(&lens, 10.0, 16);
//! let models = Models::new(&lens, &pupil, 10.0);
//! // Right to 2 pixels of 6 µm, as cheaply as can be.
//! let choice = models.choose(2.0, 0.006)?;
//! println!("{}", choice.reason());
//! let ray = choice.model.trace_from_film([3.0, 4.0], [0.0, 0.0, 7.0]);
//! assert!(ray.is_ok());
//! // Or one that is asked for, and its error.
//! let thick = models.model(ModelKind::Thick)?;
//! assert!(models.error(&thick, 0.006).is_some_and(|e| e.p99 > 2.0));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod automatic;
pub mod coordinates;
pub mod error;
pub mod least_squares;
pub mod polynomial;
pub mod rays;
pub mod shape;
pub mod table;
pub mod thick;
pub mod thin;

pub use automatic::Choice;
pub use error::ModelError;
pub use polynomial::Polynomial;
pub use shape::PupilShape;
pub use table::Table;
pub use thick::Thick;
pub use thin::Thin;

use super::lanes::{
    FilmTracer, Kernel, Lanes, PupilSamples, Traced, WeightedRays, projected_solid_angle,
    sample_disk, sample_pupil, vectorize,
};
use super::lens::Lens;
use super::pupil::{ExitPupil, PupilSample};
use super::real::{Dual, Index, Mask, Number, Plain};
use super::trace::{Blocked, Cause, LensRay};
use crate::math::Vec2;
use crate::math::sampling::concentric_disk;
use coordinates::Coordinates;
use rays::FitRay;
use std::fmt;

/// Which model.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ModelKind {
    /// Traced through every surface.
    Exact,
    /// A polynomial of this odd degree in film and pupil point: 3, 5, 7 or 9 are useful.
    Polynomial(usize),
    /// Polynomials of this degree in the pupil point: 1, 3 or 5 are useful.
    Table(usize),
    /// Principal planes and pupils.
    Thick,
    /// Principal planes.
    Thin,
}

/// Degrees beyond these are refused: their fit takes seconds.
const LARGEST_DEGREES: [usize; 2] = [11, 7];

impl fmt::Display for ModelKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            ModelKind::Exact => write!(f, "exact"),
            ModelKind::Polynomial(degree) => write!(f, "polynomial {degree}"),
            ModelKind::Table(degree) => write!(f, "table {degree}"),
            ModelKind::Thick => write!(f, "thick"),
            ModelKind::Thin => write!(f, "thin"),
        }
    }
}

/// Why a lens has no such model.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Unavailable {
    /// No focal length or no pupil.
    #[error("an afocal lens, or one without an f-number, has no {0} model")]
    NoFocalLength(ModelKind),
    /// No ray gets through.
    #[error("no ray passes the lens, so there is nothing to fit a {0} model to")]
    Dark(ModelKind),
    /// A degree that is even or too large.
    #[error(
        "there is no {0} model: polynomials have the degrees 1, 3, 5, 7, 9 or 11, tables 0 to 7"
    )]
    Degree(ModelKind),
}

/// One way from film and pupil point to ray, in precision `B`.
#[derive(Clone, Debug)]
enum Map<B> {
    Exact(FilmTracer<B>),
    Polynomial(Polynomial<B>, PupilShape<B>),
    Table(Table<B>, PupilShape<B>),
    Thick(Thick<B>, PupilShape<B>),
    Thin(Thin<B>),
}

impl Map<f64> {
    fn rounded<B: Plain>(&self, lens: &Lens, plane_z: f64) -> Map<B> {
        match self {
            Map::Exact(_) => Map::Exact(FilmTracer::new(lens, plane_z)),
            Map::Polynomial(p, shape) => Map::Polynomial(p.rounded(), shape.rounded()),
            Map::Table(t, shape) => Map::Table(t.rounded(), shape.rounded()),
            Map::Thick(t, shape) => Map::Thick(t.rounded(), shape.rounded()),
            Map::Thin(t) => Map::Thin(t.rounded()),
        }
    }
}

impl<B: Plain> Map<B> {
    #[inline(always)]
    fn trace<T: Index<Base = B>>(&self, film: &[T; 2], pupil: &[T; 2]) -> Traced<T> {
        let (ray, passed) = match self {
            Map::Exact(tracer) => return tracer.trace_inline(film, pupil),
            Map::Polynomial(p, shape) => (p.ray(film, pupil), shape.holds(film, pupil)),
            Map::Table(t, shape) => (t.ray(film, pupil), shape.holds(film, pupil)),
            Map::Thick(t, shape) => (t.ray(film, pupil), shape.holds(film, pupil)),
            Map::Thin(t) => (t.ray(film, pupil), t.holds(pupil)),
        };
        // Not what overflowed: the length of a direction that did is 0.
        let [l, m, n] = ray.d;
        let unit = (l * l + m * m + n * n).at_least(B::round_from(0.5));
        let o = ray.o[0]
            .finite()
            .and(ray.o[1].finite())
            .and(ray.o[2].finite());
        let d = l.finite().and(m.finite()).and(n.finite());
        Traced {
            ray,
            passed: passed.and(o).and(d).and(unit),
        }
    }
}

/// A model of one lens, its stop and film in place. Lens coordinates, mm.
#[derive(Clone, Debug)]
pub struct LensModel {
    kind: ModelKind,
    lens: Lens,
    plane_z: f64,
    double: Map<f64>,
    single: Map<f32>,
}

impl LensModel {
    /// The traced prescription, aimed at points of the plane at `plane_z`.
    pub fn exact(lens: &Lens, plane_z: f64) -> LensModel {
        LensModel {
            kind: ModelKind::Exact,
            lens: lens.clone(),
            plane_z,
            double: Map::Exact(FilmTracer::new(lens, plane_z)),
            single: Map::Exact(FilmTracer::new(lens, plane_z)),
        }
    }

    /// Which model it is.
    pub fn kind(&self) -> ModelKind {
        self.kind
    }

    /// z of the plane that bundles are aimed at: that of the exit pupil that is sampled; of the thin model
    /// the rear principal plane.
    pub fn plane_z(&self) -> f64 {
        self.plane_z
    }

    /// A point to aim at, for `u` in the unit square: of the region of `pupil` (as [`ExitPupil::sample`]),
    /// or of the thin model's own pupil, a disk in the rear principal plane. `None` where no light arrives.
    pub fn sample_pupil(&self, pupil: &ExitPupil, film: [f64; 2], u: Vec2) -> Option<PupilSample> {
        let Map::Thin(thin) = &self.double else {
            return pupil.sample(film, u);
        };
        let p = thin.radius() * concentric_disk(u).as_dvec2();
        Some(PupilSample {
            point: [p.x, p.y, self.plane_z],
            area: std::f64::consts::PI * thin.radius() * thin.radius(),
        })
    }

    /// The ray from the film point (x, y) mm along the line through `pupil`, in lens coordinates.
    /// What a model that knows no rims blocks, it blocks at the stop.
    pub fn trace_from_film(
        &self,
        film: [f64; 2],
        pupil: [f64; 3],
    ) -> Result<LensRay<f64>, Blocked> {
        if let Map::Exact(_) = self.double {
            return self.lens.trace_from_film(film, pupil);
        }
        let traced = self.double.trace(&film, &self.on_plane(film, pupil));
        self.outcome(traced)
    }

    /// The same with derivatives by the film point's x and y, `pupil` held fixed.
    pub fn trace_with_derivatives(
        &self,
        film: [f64; 2],
        pupil: [f64; 3],
    ) -> Result<LensRay<Dual>, Blocked> {
        if let Map::Exact(_) = self.double {
            let film = [film[0], film[1], self.lens.film_z()];
            return self.lens.tracer().to_scene_with_derivatives(film, pupil);
        }
        // Held fixed is `pupil`; where the line through it meets the plane may move.
        let k = (self.plane_z - self.lens.film_z()) / (pupil[2] - self.lens.film_z());
        let film = [Dual::parameter(film[0], 0), Dual::parameter(film[1], 1)];
        let on_plane = |i: usize| {
            if pupil[2] == self.plane_z {
                Dual::fixed(pupil[i])
            } else {
                film[i] + (Dual::fixed(pupil[i]) - film[i]).times(k)
            }
        };
        let traced = self.double.trace(&film, &[on_plane(0), on_plane(1)]);
        self.outcome(traced)
    }

    /// A bundle of rays from film points through points of the plane at [`LensModel::plane_z`], with
    /// the best instructions the processor has.
    #[inline]
    pub fn trace_lanes<const N: usize>(
        &self,
        film: &[Lanes<N>; 2],
        pupil: &[Lanes<N>; 2],
    ) -> Traced<Lanes<N>> {
        vectorize(
            N,
            Bundle {
                model: self,
                film,
                pupil,
            },
        )
    }

    /// The same with derivatives by the film point's x and y, the pupil point held fixed.
    #[inline]
    pub fn trace_lanes_with_derivatives<const N: usize>(
        &self,
        film: &[Lanes<N>; 2],
        pupil: &[Lanes<N>; 2],
    ) -> Traced<Dual<Lanes<N>>> {
        vectorize(
            N,
            DualBundle(Bundle {
                model: self,
                film,
                pupil,
            }),
        )
    }

    /// From film points (mm) and samples of the unit square to weighted rays: samples `pupil` (or the thin
    /// model's own, see [`LensModel::sample_pupil`]) and traces; as [`FilmTracer::rays`].
    #[inline]
    pub fn rays<const N: usize>(
        &self,
        pupil: &ExitPupil,
        film: &[Lanes<N>; 2],
        u: &[Lanes<N>; 2],
    ) -> WeightedRays<N> {
        vectorize(
            N,
            SampledBundle {
                model: self,
                pupil,
                film,
                u,
            },
        )
    }

    /// Points to aim at as [`LensModel::sample_pupil`] chooses them, for use inside a larger [`Kernel`].
    #[inline(always)]
    pub fn sample_pupil_inline<const N: usize>(
        &self,
        pupil: &ExitPupil,
        film: &[Lanes<N>; 2],
        u: &[Lanes<N>; 2],
    ) -> PupilSamples<N> {
        match &self.single {
            Map::Thin(thin) => sample_disk(thin.radius(), u),
            _ => sample_pupil(pupil, film, u),
        }
    }

    /// Projected solid angle, sr, that each of `samples` stands for, seen from `film`.
    #[inline(always)]
    pub fn projected_solid_angle_inline<const N: usize>(
        &self,
        film: &[Lanes<N>; 2],
        samples: &PupilSamples<N>,
    ) -> Lanes<N> {
        let to_plane = (self.plane_z - self.lens.film_z()) as f32;
        projected_solid_angle(to_plane, film, &samples.point, samples.area)
    }

    /// The calculation of [`LensModel::trace_lanes_with_derivatives`], for use inside a larger [`Kernel`].
    #[inline(always)]
    pub fn trace_with_derivatives_inline<const N: usize>(
        &self,
        film: &[Lanes<N>; 2],
        pupil: &[Lanes<N>; 2],
    ) -> Traced<Dual<Lanes<N>>> {
        let ([x, y], [u, v]) = (*film, *pupil);
        self.trace_inline(
            &[Dual::parameter(x, 0), Dual::parameter(y, 1)],
            &[Dual::fixed(u), Dual::fixed(v)],
        )
    }

    /// The calculation of [`LensModel::trace_lanes`], for use inside a larger [`Kernel`].
    #[inline(always)]
    pub fn trace_inline<T: Index<Base = f32>>(&self, film: &[T; 2], pupil: &[T; 2]) -> Traced<T> {
        self.single.trace(film, pupil)
    }

    fn on_plane(&self, film: [f64; 2], pupil: [f64; 3]) -> [f64; 2] {
        if pupil[2] == self.plane_z {
            return [pupil[0], pupil[1]];
        }
        let k = (self.plane_z - self.lens.film_z()) / (pupil[2] - self.lens.film_z());
        std::array::from_fn(|i| film[i] + k * (pupil[i] - film[i]))
    }

    fn outcome<T: Number<Mask = bool>>(&self, traced: Traced<T>) -> Result<LensRay<T>, Blocked> {
        if traced.passed {
            return Ok(traced.ray);
        }
        Err(Blocked {
            surface: self.lens.paraxial().stop,
            cause: Cause::Vignetted,
        })
    }
}

struct Bundle<'a, const N: usize> {
    model: &'a LensModel,
    film: &'a [Lanes<N>; 2],
    pupil: &'a [Lanes<N>; 2],
}

impl<const N: usize> Kernel for Bundle<'_, N> {
    type Output = Traced<Lanes<N>>;
    #[inline(always)]
    fn run(self) -> Traced<Lanes<N>> {
        self.model.trace_inline(self.film, self.pupil)
    }
}

struct SampledBundle<'a, const N: usize> {
    model: &'a LensModel,
    pupil: &'a ExitPupil,
    film: &'a [Lanes<N>; 2],
    u: &'a [Lanes<N>; 2],
}

impl<const N: usize> Kernel for SampledBundle<'_, N> {
    type Output = WeightedRays<N>;
    #[inline(always)]
    fn run(self) -> WeightedRays<N> {
        let samples = self
            .model
            .sample_pupil_inline(self.pupil, self.film, self.u);
        let mut traced = self.model.trace_inline(self.film, &samples.point);
        traced.passed = traced.passed.and(samples.lit);
        WeightedRays {
            traced,
            projected_solid_angle: self.model.projected_solid_angle_inline(self.film, &samples),
        }
    }
}

struct DualBundle<'a, const N: usize>(Bundle<'a, N>);

impl<const N: usize> Kernel for DualBundle<'_, N> {
    type Output = Traced<Dual<Lanes<N>>>;
    #[inline(always)]
    fn run(self) -> Traced<Dual<Lanes<N>>> {
        self.0
            .model
            .trace_with_derivatives_inline(self.0.film, self.0.pupil)
    }
}

/// What models are made from: the measured pupil and traced rays of one lens.
#[derive(Clone, Debug)]
pub struct Models<'a> {
    lens: &'a Lens,
    pupil: &'a ExitPupil,
    film_radius: f64,
    shape: PupilShape<f64>,
    rays: Vec<Vec<FitRay>>,
}

impl<'a> Models<'a> {
    /// Measures `lens` for film points up to `film_radius` mm, and rays aimed at the plane of
    /// `pupil`. Some tens of milliseconds.
    pub fn new(lens: &'a Lens, pupil: &'a ExitPupil, film_radius: f64) -> Models<'a> {
        let film_radius = film_radius.max(f64::MIN_POSITIVE);
        let plane_z = pupil.plane_z();
        let shape = PupilShape::measure(lens, film_radius, plane_z);
        let rays = rays::fit_rays(lens, film_radius, plane_z, &shape);
        Models {
            lens,
            pupil,
            film_radius,
            shape,
            rays,
        }
    }

    /// Makes a model; the slowest, a polynomial of degree 9, in a few tenths of a second.
    pub fn model(&self, kind: ModelKind) -> Result<LensModel, Unavailable> {
        let shape = || self.shape.clone();
        let no_focal_length = Unavailable::NoFocalLength(kind);
        let plane_z = match (kind, self.lens.paraxial().cardinals) {
            (ModelKind::Thin, Some(c)) => c.rear_principal_plane,
            _ => self.pupil.plane_z(),
        };
        let double = match kind {
            ModelKind::Exact => Map::Exact(FilmTracer::new(self.lens, plane_z)),
            ModelKind::Polynomial(degree) => {
                if degree % 2 == 0 || degree > LARGEST_DEGREES[0] {
                    return Err(Unavailable::Degree(kind));
                }
                let coordinates = self.coordinates().ok_or(Unavailable::Dark(kind))?;
                Map::Polynomial(
                    Polynomial::fit(coordinates, degree, &self.rays.concat()),
                    shape(),
                )
            }
            ModelKind::Table(degree) => {
                if degree > LARGEST_DEGREES[1] {
                    return Err(Unavailable::Degree(kind));
                }
                let coordinates = self.coordinates().ok_or(Unavailable::Dark(kind))?;
                Map::Table(Table::fit(coordinates, degree, &self.rays), shape())
            }
            ModelKind::Thick => Map::Thick(
                Thick::new(self.lens, plane_z).ok_or(no_focal_length)?,
                shape(),
            ),
            ModelKind::Thin => Map::Thin(Thin::new(self.lens).ok_or(no_focal_length)?),
        };
        Ok(LensModel {
            kind,
            lens: self.lens.clone(),
            plane_z,
            single: double.rounded(self.lens, plane_z),
            double,
        })
    }

    /// Scales that make inputs about 1; `None` where no ray passes.
    fn coordinates(&self) -> Option<Coordinates<f64>> {
        let lit = self.rays.iter().rposition(|node| !node.is_empty())?;
        let radius = self.film_radius * lit as f64 / shape::RADII as f64;
        let drift = if lit > 0 {
            self.shape.middle(lit) / radius
        } else {
            0.0
        };
        // Any point near where the rays cross the axis would do; a pupil at infinity is not near.
        let reach = self.lens.length() + 10.0 * self.lens.film_distance();
        let entrance = self.lens.paraxial().entrance_pupil;
        let entrance = entrance.map_or(0.0, |p| p.z).clamp(-reach, reach);
        let size = self.shape.largest_reach();
        let scales = [self.film_radius, drift, size, entrance];
        (scales.iter().all(|x| x.is_finite()) && size > 0.0)
            .then(|| Coordinates::new(self.film_radius, drift, size, entrance))
    }
}

#[cfg(test)]
mod tests;
