//! A lens in front of a film: the prescription, prepared for everything that is asked of it.

use super::focus::{self, FocusError};
use super::paraxial::Paraxial;
use super::prescription::Prescription;
use super::surface::Surface;
use super::trace::{Blocked, LensRay, LensTracer};

/// A lens at a fixed distance from its film. Lens coordinates: millimetres, origin at the first
/// vertex, z toward the film.
#[derive(Clone, Debug)]
pub struct Lens {
    surfaces: Vec<Surface>,
    length: f64,
    film_distance: f64,
    paraxial: Paraxial,
    tracer: LensTracer<f64>,
}

/// Why a prescription makes no lens.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum LensError {
    /// It has no surfaces.
    #[error("the lens has no surfaces")]
    Empty,
    /// The film is not behind the lens.
    #[error("the film lies {0} mm behind the last lens surface; expected a positive distance")]
    FilmDistance(f64),
}

impl Lens {
    /// The lens of `prescription` with its film `film_distance` mm behind the last vertex.
    pub fn new(prescription: &Prescription, film_distance: f64) -> Result<Lens, LensError> {
        if prescription.surfaces.is_empty() {
            return Err(LensError::Empty);
        }
        if !(film_distance > 0.0 && film_distance.is_finite()) {
            return Err(LensError::FilmDistance(film_distance));
        }
        Ok(Lens {
            surfaces: prescription.surfaces.clone(),
            length: prescription.length(),
            film_distance,
            paraxial: Paraxial::new(&prescription.surfaces),
            tracer: LensTracer::new(&prescription.surfaces),
        })
    }

    /// The film distance, mm, that focuses `prescription` on the plane `distance` mm from the film.
    pub fn focused(prescription: &Prescription, distance: f64) -> Result<f64, FocusError> {
        if prescription.surfaces.is_empty() {
            return Err(FocusError::NoImage { focal_length: None });
        }
        let cardinals = Paraxial::new(&prescription.surfaces).cardinals;
        focus::film_distance_for_focus(cardinals, distance)
    }

    /// Its surfaces, from the scene to the film.
    pub fn surfaces(&self) -> &[Surface] {
        &self.surfaces
    }

    /// The surface next to the film.
    pub fn rear(&self) -> &Surface {
        // A lens has at least one surface.
        &self.surfaces[self.surfaces.len() - 1]
    }

    /// From the first vertex to the last, mm: also the last one's z.
    pub fn length(&self) -> f64 {
        self.length
    }

    /// From the last vertex to the film, mm.
    pub fn film_distance(&self) -> f64 {
        self.film_distance
    }

    /// z of the film.
    pub fn film_z(&self) -> f64 {
        self.length + self.film_distance
    }

    /// First-order properties.
    pub fn paraxial(&self) -> &Paraxial {
        &self.paraxial
    }

    /// The exact tracer.
    pub fn tracer(&self) -> &LensTracer<f64> {
        &self.tracer
    }

    /// z of the plane of focus; see [`focus::plane_of_focus`].
    pub fn plane_of_focus(&self) -> Option<f64> {
        let cardinals = self.paraxial.cardinals?;
        focus::plane_of_focus(&cardinals, self.film_distance)
    }

    /// Traces the ray from the film point (x, y) mm along the line through `pupil`, which may lie on
    /// either side of the film.
    pub fn trace_from_film(
        &self,
        film: [f64; 2],
        pupil: [f64; 3],
    ) -> Result<LensRay<f64>, Blocked> {
        self.tracer.to_scene(&self.film_ray(film, pupil))
    }

    /// The ray from the film point (x, y) mm toward the lens, along the line through `pupil`.
    pub fn film_ray(&self, film: [f64; 2], pupil: [f64; 3]) -> LensRay<f64> {
        let from = [film[0], film[1], self.film_z()];
        let mut ray = LensRay::through(from, pupil);
        if ray.d[2] > 0.0 {
            ray.d = ray.d.map(|x| -x);
        }
        ray
    }
}
