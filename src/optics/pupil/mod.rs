//! Where to aim: the part of the exit pupil that a film point sees light through.
//!
//! Most rays toward the rear element end at some rim. For each of a number of rings of film
//! radius the outline of the rays that pass is found by tracing (`outline`), and a polygon around it is
//! kept that moves with the film radius (`ring`); samples are drawn uniformly from the polygon, and
//! their weight carries its area. The polygon holds every ray that passes, so the expectation is that of
//! sampling everything: what bends outward between the film radii and directions that were traced is
//! measured half-way and made room for (`draft`), rings are split where the pupil changes fast, and rays
//! just outside and all over the rear element look for light that was overlooked (`survey`).
//!
//! The plane is that of the paraxial exit pupil, where the region hardly moves within a ring. The
//! paraxial pupil disk itself would not do (pupil aberration moves the true one off it by up to half
//! its light), nor the rear element's disk at its vertex (the rim of a curved surface lies elsewhere;
//! a wide-angle lens loses its corners). pbrt's boxes (3rd edition §6.4.5) waste a quarter of the
//! rays or more, and miss a stop of a hundredth of a millimeter altogether, because they look for it with
//! random rays. Here the search starts from a ray that passes and walks outward. `docs/pupil.md` has
//! the figures.
//!
//! How the unit square is spread over the polygon is a [`PupilSampling`]; [`super::stops`] finds the pupil as
//! lens designers do, by imaging every aperture.

mod draft;
mod mapping;
pub(super) mod outline;
mod rear;
mod region;
mod ring;
mod search;
mod survey;
mod table;
mod tilted;

pub use mapping::PupilSampling;
pub use region::Region;
pub use tilted::TiltedPupil;

use self::mapping::Spot;
use self::ring::Ring;
use self::survey::Survey;
use self::table::PupilTable;
pub(super) use self::table::Spread;
use super::lanes::Lanes;
use super::lens::Lens;
use super::real::{Index, Number};
use crate::math::Vec2;

/// A point of the exit pupil to aim at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PupilSample {
    /// Where, in lens coordinates.
    pub point: [f64; 3],
    /// Area it was drawn from uniformly, mm², on a plane perpendicular to the axis.
    pub area: f64,
}

/// For every film radius, the region of the exit pupil to sample.
#[derive(Clone, Debug)]
pub struct ExitPupil {
    /// What it was found with.
    survey: Survey,
    /// By film radius; between them it is dark.
    rings: Vec<Ring>,
    /// What samples are made with: `rings` once more, for f64 and for f32 and bundles of them.
    double: PupilTable<f64>,
    single: PupilTable<f32>,
    sampling: PupilSampling,
}

/// Rings to begin with; they are split where the pupil changes fast. Between 16 of them and their
/// middles no change of the pupil is overlooked in the lenses of `tests/golden`.
pub const RINGS: usize = 16;

impl ExitPupil {
    /// Finds the regions for film points up to `max_radius` mm from the axis, beginning with `rings`
    /// rings.
    pub fn new(lens: &Lens, max_radius: f64, rings: usize) -> ExitPupil {
        ExitPupil::on_plane(lens, sampling_plane(lens), max_radius, rings)
    }

    /// The same, seen on the plane at `plane_z`, which is not the film's.
    pub fn on_plane(lens: &Lens, plane_z: f64, max_radius: f64, rings: usize) -> ExitPupil {
        ExitPupil::surveyed(Survey::new(lens, plane_z, max_radius), rings)
    }

    fn surveyed(survey: Survey, rings: usize) -> ExitPupil {
        let rings = survey.rings(rings.max(1));
        ExitPupil {
            double: PupilTable::new(&rings, survey.reach),
            single: PupilTable::new(&rings, survey.reach),
            rings,
            survey,
            sampling: PupilSampling::default(),
        }
    }

    /// The same regions, sampled in another way.
    pub fn with_sampling(self, sampling: PupilSampling) -> ExitPupil {
        ExitPupil { sampling, ..self }
    }

    /// z of the plane that is sampled.
    pub fn plane_z(&self) -> f64 {
        self.survey.plane_z
    }

    /// Number of rings.
    pub fn rings(&self) -> usize {
        self.rings.len()
    }

    /// The region for film points `radius` mm from the axis; `None` where no light arrives.
    /// Beyond the largest radius: everything the rear element lets through.
    pub fn region(&self, radius: f64) -> Option<Region> {
        if radius <= self.survey.reach {
            return self.ring(radius).map(|ring| ring.region(ring.t(radius)));
        }
        self.survey.rear_region(radius)
    }

    /// The ring of a film radius within reach.
    fn ring(&self, radius: f64) -> Option<&Ring> {
        let at = self.rings.partition_point(|r| r.radii[1] < radius);
        self.rings.get(at).filter(|r| r.radii[0] <= radius)
    }

    /// Maps `u` in the unit square to the region of the film point (x, y) mm, evenly over its area.
    /// `None` where no light arrives.
    #[inline]
    pub fn sample(&self, film: [f64; 2], u: Vec2) -> Option<PupilSample> {
        // Not `hypot`, which takes as long as all the rest: film points are neither tiny nor huge,
        // and one nearer than 1e-154 mm to the axis is on it.
        let radius = (film[0] * film[0] + film[1] * film[1]).sqrt();
        if !self.is_tabulated(radius, self.survey.reach) {
            return self.one_by_one(film, radius, u);
        }
        let spot = self.spot(u.as_dvec2().to_array());
        let found = self.double.point(&film, radius, &spot);
        found.lit.then_some(PupilSample {
            point: [found.point[0], found.point[1], self.survey.plane_z],
            area: found.area,
        })
    }

    /// [`ExitPupil::sample`] for a bundle, in single precision.
    #[inline(always)]
    pub(super) fn sample_lanes<const N: usize>(
        &self,
        film: &[Lanes<N>; 2],
        u: &[Lanes<N>; 2],
    ) -> Spread<Lanes<N>> {
        let radius = (film[0] * film[0] + film[1] * film[1]).sqrt();
        let mut found = self.single.point(film, radius, &self.spot(*u));
        let reach = self.survey.reach as f32;
        if (0..N).any(|i| !self.is_tabulated(radius.0[i], reach)) {
            for i in (0..N).filter(|i| !self.is_tabulated(radius.0[*i], reach)) {
                let film = film.map(|x| f64::from(x.0[i]));
                let u = Vec2::new(u[0].0[i], u[1].0[i]);
                let one = self.one_by_one(film, film[0].hypot(film[1]), u);
                found.lit.0[i] = if one.is_some() { u32::MAX } else { 0 };
                let Some(one) = one else { continue };
                found.point[0].0[i] = one.point[0] as f32;
                found.point[1].0[i] = one.point[1] as f32;
                found.area.0[i] = one.area as f32;
            }
        }
        found
    }

    /// Returns `true` if this film radius is sampled from the tables.
    #[inline(always)]
    fn is_tabulated<T: PartialOrd>(&self, radius: T, reach: T) -> bool {
        radius <= reach && self.sampling != PupilSampling::Rejection
    }

    #[inline(always)]
    fn spot<T: Index>(&self, u: [T; 2]) -> Spot<T> {
        match self.sampling {
            PupilSampling::Polar => Spot::square_root(u),
            PupilSampling::Concentric | PupilSampling::Rejection => Spot::concentric(u),
        }
    }

    /// A sample of what is in no table: by rejection, and beyond the reach.
    #[cold]
    fn one_by_one(&self, film: [f64; 2], radius: f64, u: Vec2) -> Option<PupilSample> {
        let ([x, y], area) = if radius <= self.survey.reach {
            let ring = self.ring(radius)?;
            let t = ring.t(radius);
            match ring.by_rejection(t, u) {
                Ok(p) => (p, ring.area(t)),
                Err(u) => {
                    let spot = Spot::concentric(u.as_dvec2().to_array());
                    // On the positive x axis.
                    let found = self.double.point(&[radius, 0.0], radius, &spot);
                    (found.point, found.area)
                }
            }
        } else {
            // A point of what the rear element lets through.
            let e = self.survey.rear_region(radius)?;
            let spot = Spot::concentric(u.as_dvec2().to_array());
            (e.point(spot), e.area)
        };
        let (cos, sin) = if radius > 0.0 {
            (film[0] / radius, film[1] / radius)
        } else {
            (1.0, 0.0)
        };
        Some(PupilSample {
            point: [cos * x - sin * y, sin * x + cos * y, self.survey.plane_z],
            area,
        })
    }

    /// The area, as in [`PupilSample::area`], that samples around `point` of the plane represent, seen from the film point (x, y)
    /// mm; `None` where none falls.
    pub fn area_at(&self, film: [f64; 2], point: [f64; 2]) -> Option<f64> {
        let radius = (film[0] * film[0] + film[1] * film[1]).sqrt();
        // Along and across the film point's azimuth.
        let p = match radius > 0.0 {
            true => [
                (point[0] * film[0] + point[1] * film[1]) / radius,
                (point[1] * film[0] - point[0] * film[1]) / radius,
            ],
            false => point,
        };
        if radius > self.survey.reach {
            let e = self.survey.rear_region(radius)?;
            let (x, y) = ((p[0] - e.center) / e.along, p[1] / e.across);
            return (x * x + y * y <= 1.0).then_some(e.area);
        }
        let ring = self.ring(radius)?;
        let t = ring.t(radius);
        let triangle = ring.triangle_at(t, p)?;
        // By rejection every part of the region is met alike.
        Some(match self.sampling {
            PupilSampling::Rejection => ring.area(t),
            PupilSampling::Concentric | PupilSampling::Polar => triangle,
        })
    }

    /// Projected solid angle ∫cosθ dω, in steradians, that a sample of area `area` represents, seen
    /// from the film point: area·cos⁴θ/Z², the factor between radiance and irradiance.
    pub fn projected_solid_angle(&self, film: [f64; 2], sample: &PupilSample) -> f64 {
        projected_solid_angle([film[0], film[1], self.survey.film_z], sample)
    }
}

/// Projected solid angle of `sample`'s area seen from `film` across a film perpendicular to the axis.
pub fn projected_solid_angle(film: [f64; 3], sample: &PupilSample) -> f64 {
    let d: [f64; 3] = std::array::from_fn(|i| sample.point[i] - film[i]);
    let z2 = d[2] * d[2];
    let distance2 = d[0] * d[0] + d[1] * d[1] + z2;
    // cos²θ = Z²/d², so A cos⁴θ/Z² = A Z²/d⁴.
    sample.area * z2 / (distance2 * distance2)
}

/// The plane to sample on: the paraxial exit pupil's, a very distant one for a telecentric lens,
/// and the rear vertex' where the pupil lies too near the film.
pub fn sampling_plane(lens: &Lens) -> f64 {
    // A plane a million film distances away sees all film points alike, and its points still have
    // ten digits.
    let far = 1e6 * lens.film_distance();
    let Some(pupil) = lens.paraxial().exit_pupil else {
        return lens.film_z() - far;
    };
    let distance = lens.film_z() - pupil.z;
    // Nearer than a quarter of the film distance the region would spread with the film radius.
    if distance.abs() < 0.25 * lens.film_distance() {
        lens.length()
    } else {
        lens.film_z() - distance.clamp(-far, far)
    }
}

/// Points on the outline of the rays that pass, for the film point (radius, 0), on the plane
/// `plane_z`: the half with y ≥ 0, each just outside. Empty where no ray passes.
pub fn boundary(lens: &Lens, radius: f64, plane_z: f64) -> Vec<[f64; 2]> {
    let survey = Survey::new(lens, plane_z, radius);
    let outline = survey.view(radius).outline(None);
    outline.map_or(Vec::new(), |o| o.absolute().collect())
}

#[cfg(test)]
mod tests;
