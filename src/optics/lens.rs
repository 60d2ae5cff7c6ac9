//! A lens in front of a film: the prescription, prepared for everything that is asked of it.

use super::focus::{self, FocusError};
use super::paraxial::Paraxial;
use super::prescription::Prescription;
use super::real::Plain;
use super::stop_shape::StopShape;
use super::surface::Surface;
use super::trace::{Blocked, LensRay, LensTracer};

/// A lens at a fixed distance from its film. Lens coordinates: millimeters, origin at the first
/// vertex, z toward the film.
#[derive(Clone, Debug)]
pub struct Lens {
    surfaces: Vec<Surface>,
    length: f64,
    film_distance: f64,
    paraxial: Paraxial,
    tracer: LensTracer<f64>,
    stop_shape: Option<StopShape>,
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
            stop_shape: None,
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

    /// The same lens with another than a round stop. First-order properties, exit pupils and models are those of the round
    /// one, which holds it.
    pub fn with_stop_shape(mut self, shape: StopShape) -> Lens {
        self.stop_shape = Some(shape);
        self.tracer = self.tracer_in();
        self
    }

    /// A tracer in precision `B`, with the stop's blades if it has any.
    pub fn tracer_in<B: Plain>(&self) -> LensTracer<B> {
        let tracer = LensTracer::new(&self.surfaces);
        match &self.stop_shape {
            Some(StopShape::Polygon(polygon)) => tracer.with_blades(&self.surfaces, polygon),
            _ => tracer,
        }
    }

    /// What the stop is shaped like, if not round.
    pub(super) fn stop_shape(&self) -> Option<&StopShape> {
        self.stop_shape.as_ref()
    }

    /// The part of the light that the stop's shape lets through along the line from the film point (x, y) mm through `pupil`:
    /// 1 for a round stop. Exact rays take polygons into account themselves.
    pub fn stop_transmission(&self, film: [f64; 2], pupil: [f64; 3]) -> f64 {
        let Some(shape) = &self.stop_shape else {
            return 1.0;
        };
        let ray = self.film_ray(film, pupil);
        let stops = self.surfaces.iter().enumerate().filter(|(_, s)| s.is_stop);
        let through = stops.map(|(i, s)| {
            let radius = 0.5 * s.aperture;
            let point = self.tracer.point_from_film(&ray, i, true);
            match (point, shape) {
                (None, _) => 0.0,
                // The tracer has seen to it.
                (Some(_), StopShape::Polygon(_)) => 1.0,
                (Some(p), _) => shape.transmission(p.map(|x| x / radius)),
            }
        });
        through.product()
    }

    /// From the pinhole that shows what the lens does near its axis to the film, mm: film height over the tangent of the angle at the
    /// entrance pupil. The focal length at infinity; what it is at a near focus is the lens' breathing. `None` for a lens that is
    /// telecentric on a side.
    pub fn pinhole_focal_length(&self) -> Option<f64> {
        let (entrance, exit) = (self.paraxial.entrance_pupil?, self.paraxial.exit_pupil?);
        // Lagrange's invariant between the pupils: n y tan u is conserved.
        let angular = self.rear().index * exit.diameter / entrance.diameter;
        Some((self.film_z() - exit.z) / angular).filter(|f| f.is_finite())
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
