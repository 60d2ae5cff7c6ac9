//! The lecture's three ways to make a camera ray.
//!
//! | model | direction and start of a ray | vignetting |
//! |---|---|---|
//! | `exact` | traced through every surface | every rim |
//! | `thick` | principal planes ([`thick`]) | every rim, as the exact ray meets it |
//! | `thin` | principal planes ([`thin`]) | a disk in the principal plane |
//!
//! All map a film point and a point of one plane (the one that [`crate::optics::ExitPupil`] samples) to a ray in
//! lens coordinates, for one number or a bundle ([`Number`]), with derivatives or without. In lanes an exact ray costs as
//! little as an approximation of it; `docs/notes/lens-models.md` has what was measured.
//!
//! ```
//! use fstop::optics::models::{LensModel, ModelKind};
//! use fstop::optics::{ExitPupil, Lens, Prescription};
//!
//! let prescription = Prescription::parse("50 5 1.5168 20\n-50 2 1 20\n0 0 0 10\n")?;
//! let lens = Lens::new(&prescription, Lens::focused(&prescription, 1000.0)?)?;
//! let pupil = ExitPupil::new(&lens, 10.0, 16);
//! let thick = LensModel::new(ModelKind::Thick, &lens, &pupil)?;
//! let ray = thick.trace_from_film([3.0, 4.0], [0.0, 0.0, 7.0]);
//! assert!(ray.is_ok());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod thick;
pub mod thin;

pub use thick::Thick;
pub use thin::Thin;

use super::lanes::{FilmTracer, LaneMask, Lanes, Traced};
use super::lens::Lens;
use super::pupil::{ExitPupil, PupilSample, Spread};
use super::real::{Dual, Number, Plain, Real};
use super::trace::{Blocked, Cause, LensRay};
use crate::math::Vec2;
use crate::math::sampling::concentric_disk;
use std::fmt;

/// Which model (`"string model"`, `--lens-model`).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ModelKind {
    /// Traced through every surface.
    #[default]
    Exact,
    /// Principal planes and pupils.
    Thick,
    /// Principal planes.
    Thin,
}

impl fmt::Display for ModelKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            ModelKind::Exact => "exact",
            ModelKind::Thick => "thick",
            ModelKind::Thin => "thin",
        })
    }
}

/// A lens has no such model: it is afocal or has no pupil.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("an afocal lens, or one without an f-number, has no {0} model")]
pub struct NoFocalLength(pub ModelKind);

/// One way from film and pupil point to ray, in precision `B`.
#[derive(Clone, Debug)]
enum Map<B> {
    Exact(FilmTracer<B>),
    /// And the rims.
    Thick(Thick<B>, FilmTracer<B>),
    Thin(Thin<B>),
}

impl<B: Plain> Map<B> {
    /// For rays aimed at the plane at `plane_z`; `None` for a lens that has no such model.
    fn new(kind: ModelKind, lens: &Lens, plane_z: f64) -> Option<Map<B>> {
        let exact = FilmTracer::new(lens, plane_z);
        Some(match kind {
            ModelKind::Exact => Map::Exact(exact),
            ModelKind::Thick => Map::Thick(Thick::new(lens, plane_z)?, exact),
            ModelKind::Thin => Map::Thin(Thin::new(lens)?),
        })
    }

    #[inline(always)]
    fn trace<T: Number<Base = B>>(&self, film: &[T; 2], pupil: &[T; 2]) -> Traced<T> {
        let (ray, passed) = match self {
            Map::Exact(tracer) => return tracer.trace(film, pupil),
            Map::Thick(t, rims) => (t.ray(film, pupil), rims.trace(film, pupil).passed),
            Map::Thin(t) => (t.ray(film, pupil), t.holds(pupil)),
        };
        // Not what overflowed: the length of a direction that did is 0.
        let [l, m, n] = ray.d;
        let unit = (l * l + m * m + n * n).at_least(B::round_from(0.5));
        Traced {
            ray,
            passed: passed & ray.finite() & unit,
        }
    }
}

/// Rays into the scene side by side, and what they count for.
pub struct WeightedRays<T: Number, const N: usize> {
    /// The rays and which of them passed.
    pub traced: Traced<T>,
    /// Projected solid angle, sr, that each represents: the factor between radiance and irradiance.
    pub projected_solid_angle: Lanes<N>,
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
        let (double, single) = (
            FilmTracer::new(lens, plane_z),
            FilmTracer::new(lens, plane_z),
        );
        LensModel {
            kind: ModelKind::Exact,
            lens: lens.clone(),
            plane_z,
            double: Map::Exact(double),
            single: Map::Exact(single),
        }
    }

    /// The model of this kind, its rays aimed at the plane of `pupil`. Thick and thin lenses have a focal length.
    pub fn new(
        kind: ModelKind,
        lens: &Lens,
        pupil: &ExitPupil,
    ) -> Result<LensModel, NoFocalLength> {
        let plane_z = match (kind, lens.paraxial().cardinals) {
            (ModelKind::Thin, Some(cardinals)) => cardinals.rear_principal_plane,
            _ => pupil.plane_z(),
        };
        let maps = Map::new(kind, lens, plane_z).zip(Map::new(kind, lens, plane_z));
        let (double, single) = maps.ok_or(NoFocalLength(kind))?;
        Ok(LensModel {
            kind,
            lens: lens.clone(),
            plane_z,
            double,
            single,
        })
    }

    /// Which model it is.
    pub fn kind(&self) -> ModelKind {
        self.kind
    }

    /// The lens it is of; of the exact model, with the blades of its stop.
    pub fn lens(&self) -> &Lens {
        &self.lens
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
        let film = [Dual::parameter(film[0], 0), Dual::parameter(film[1], 1)];
        let traced = self.double.trace(&film, &self.on_plane(film, pupil));
        self.outcome(traced)
    }

    /// From film points (mm) and samples of the unit square to weighted rays, in single precision: what
    /// [`LensModel::sample_pupil`] and [`LensModel::trace_from_film`] do for one. For use inside a
    /// `crate::math::instruction_set::Kernel`.
    #[inline(always)]
    pub fn rays<const N: usize>(
        &self,
        pupil: &ExitPupil,
        film: &[Lanes<N>; 2],
        u: &[Lanes<N>; 2],
    ) -> WeightedRays<Lanes<N>, N> {
        self.weighted(film, &self.sample_lanes(pupil, film, u), film, |point| {
            point
        })
    }

    /// The same with derivatives by the film point's x and y, the pupil point held fixed.
    #[inline(always)]
    pub fn rays_with_derivatives<const N: usize>(
        &self,
        pupil: &ExitPupil,
        film: &[Lanes<N>; 2],
        u: &[Lanes<N>; 2],
    ) -> WeightedRays<Dual<Lanes<N>>, N> {
        let from = [Dual::parameter(film[0], 0), Dual::parameter(film[1], 1)];
        let samples = self.sample_lanes(pupil, film, u);
        self.weighted(film, &samples, &from, |point| point.map(Dual::fixed))
    }

    /// The rays from `film`, as numbers of another kind `from`, through `samples`, which `lift` makes such numbers.
    #[inline(always)]
    fn weighted<T: Number<Base = f32, Mask = LaneMask<N>>, const N: usize>(
        &self,
        film: &[Lanes<N>; 2],
        samples: &Spread<Lanes<N>>,
        from: &[T; 2],
        lift: impl Fn([Lanes<N>; 2]) -> [T; 2],
    ) -> WeightedRays<T, N> {
        let mut traced = self.single.trace(from, &lift(samples.point));
        traced.passed = traced.passed & samples.lit;
        WeightedRays {
            traced,
            projected_solid_angle: self.projected_solid_angle(film, samples),
        }
    }

    #[inline(always)]
    fn sample_lanes<const N: usize>(
        &self,
        pupil: &ExitPupil,
        film: &[Lanes<N>; 2],
        u: &[Lanes<N>; 2],
    ) -> Spread<Lanes<N>> {
        match &self.single {
            Map::Thin(thin) => thin.sample(u),
            _ => pupil.sample_lanes(film, u),
        }
    }

    /// Projected solid angle, sr, that each of `samples` represents, seen from `film`: A·cos⁴θ/Z² (see
    /// [`crate::optics::pupil::projected_solid_angle`]).
    #[inline(always)]
    fn projected_solid_angle<const N: usize>(
        &self,
        film: &[Lanes<N>; 2],
        samples: &Spread<Lanes<N>>,
    ) -> Lanes<N> {
        let to_plane = (self.plane_z - self.lens.film_z()) as f32;
        let (x, y) = (samples.point[0] - film[0], samples.point[1] - film[1]);
        let z2 = to_plane * to_plane;
        // Relative to the plane's distance: its fourth power would overflow for a distant pupil.
        let r = (x * x + y * y).times(1.0 / z2).plus(1.0);
        samples.area.times(1.0 / z2) / (r * r)
    }

    /// Where the line from a film point through `pupil` meets the plane that is aimed at.
    fn on_plane<T: Number<Base = f64>>(&self, film: [T; 2], pupil: [f64; 3]) -> [T; 2] {
        let k = (self.plane_z - self.lens.film_z()) / (pupil[2] - self.lens.film_z());
        [0, 1].map(|i| match pupil[2] == self.plane_z {
            true => T::constant(pupil[i]),
            false => film[i] + (T::constant(pupil[i]) - film[i]).times(k),
        })
    }

    fn outcome<T: Real>(&self, traced: Traced<T>) -> Result<LensRay<T>, Blocked> {
        if traced.passed {
            return Ok(traced.ray);
        }
        Err(Blocked {
            surface: self.lens.paraxial().stop,
            cause: Cause::Vignetted,
        })
    }
}

#[cfg(test)]
pub(super) mod tests;
