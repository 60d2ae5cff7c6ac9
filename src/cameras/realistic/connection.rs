//! Connections through a traced lens: light runs from the scene to the film, and no derivative of the lens is needed.
//!
//! Refraction conserves étendue over the squared index, n² dA⊥ dω, and the lens takes the rays that pass one to one to the film. So the
//! importance per étendue in the scene is one number: with the weight k·n'²·T·A cos⁴θ'/Z² that a ray of the camera has
//! ([`super::Weighting`]; k the exposure, or what makes it relative; T the stop's transmission), and its density Z²/(A cos⁴θ' P n'²) for a
//! pixel of area P and a pupil region of area A, it is k T/P, wherever and however sharply the ray lands. A direction is drawn by
//! [`EntrancePupil`] and traced to the film; what does not arrive counts for nothing. κ is the density over that of the direction, 0 where
//! the camera samples no such point of its exit pupil.
//!
//! Bands of the spectrum are as likely here as there, and each ray is traced in its band's lens. Lengths are millimeters of lens coordinates;
//! areas across a ray become those of render space as in [`crate::cameras::Aim`].
//!
//! Source: for the measure, Welford and Winston, *High Collection Nonimaging Optics*, 1989, §2.7 and appendix A.

use super::optics::{Optics, PupilTarget};
use super::{Compat, Form, Realistic, camera_from_lens};
use crate::cameras::camera_transform::Placement;
use crate::cameras::connection::{Landing, LensSample, toward};
use crate::cameras::{CameraRay, CameraSample};
use crate::math::ray::Ray;
use crate::math::{DMat4, DVec2, DVec3, Vec2, Vec3};
use crate::optics::LensRay;
use crate::optics::entrance::{EntrancePupil, FilmWindow, Seen};
use crate::optics::lanes::{Landed, SceneTracer};
use crate::optics::models::ModelKind;
use crate::optics::pupil::{ExitPupil, PupilSample, projected_solid_angle};
use crate::surface::ReferencePoint;

/// What connections need beside the camera.
#[derive(Clone, Debug)]
pub(super) struct Connections {
    entrance: EntrancePupil,
    window: FilmWindow,
    /// Of the bands, and last at the d line.
    tracers: Vec<SceneTracer<f64>>,
    lens_from_camera: DMat4,
}

/// A ray toward the film, up to the first surface.
#[derive(Clone, Copy, Debug)]
pub(in super::super) struct Traced {
    /// It starts on the first surface; lens coordinates.
    ray: LensRay<f64>,
    /// Which of the tracers it is for.
    band: usize,
    /// Area across it at its origin, mm², over solid angle drawn and area in render space: takes densities per étendue to κ.
    scale: f64,
}

impl Realistic {
    /// Are rays those of the lens?
    pub(in super::super) fn connects(&self) -> bool {
        let exact = self.main.model.kind() == ModelKind::Exact;
        exact && self.spec.compat == Compat::None && self.transform.is_affine()
    }

    /// Finds out where to aim from the scene for light to land between these corners, in raster coordinates.
    pub(in super::super) fn prepare_connections(&mut self, window: [Vec2; 2]) {
        let corners = window.map(|corner| self.film_point(corner));
        let ends = |pick: fn(f64, f64) -> f64| [0, 1].map(|i| pick(corners[0][i], corners[1][i]));
        let window = FilmWindow {
            low: ends(f64::min),
            high: ends(f64::max),
        };
        let all = || self.bands.iter().chain([&self.main]);
        // The d line first, though no ray is traced at it where there are bands.
        let seen = [&self.main].into_iter().chain(&self.bands);
        let seen: Vec<Seen<'_>> = seen
            .filter_map(|optics| Some((&optics.lens, pupil(optics)?)))
            .collect();
        let tracers = all().map(|o| SceneTracer::new(o.model.lens(), o.model.plane_z()));
        let tracers = tracers.collect();
        let made = EntrancePupil::new(&seen, window).filter(|_| self.connects());
        self.connections = made.map(|entrance| {
            Box::new(Connections {
                entrance,
                window,
                tracers,
                lens_from_camera: camera_from_lens(&self.spec).inverse(),
            })
        });
    }

    /// See [`crate::cameras::Camera::aim`].
    pub(in super::super) fn aim(
        &self,
        from: &ReferencePoint,
        sample: &LensSample,
    ) -> Option<(Vec3, Ray, Traced)> {
        let connections = self.connections.as_deref()?;
        let placement = self.transform.placement(from.time);
        let x = placement.point(from.p);
        let in_lens = connections.lens_from_camera.transform_point3(x);
        let drawn = connections.entrance.draw(in_lens, sample.lens)?;
        let band = self.band(sample.wavelength);
        let ray = LensRay {
            o: in_lens.to_array(),
            d: drawn.d.to_array(),
        };
        let [front, _] = self.of_band(band).lens.tracer().front(&ray)?;
        let y = DVec3::from(front);
        if (y - in_lens).dot(drawn.d) <= 0.0 {
            return None;
        }
        let start = camera_from_lens(&self.spec).transform_point3(y);
        let (wi, shadow) = toward(from, &placement, x, start)?;
        let traced = Traced {
            ray: LensRay { o: front, ..ray },
            band,
            scale: self.area_across(&placement, drawn.d) / drawn.density,
        };
        Some((wi, shadow, traced))
    }

    /// See [`crate::cameras::Camera::land`].
    pub(in super::super) fn land(&self, traced: &Traced) -> Option<Landing> {
        let connections = self.connections.as_deref()?;
        let landed = connections
            .tracers
            .get(traced.band)?
            .trace_alone(&traced.ray)?;
        self.landing(connections, traced, &landed)
    }

    /// What light counts for that has landed.
    fn landing(
        &self,
        connections: &Connections,
        traced: &Traced,
        landed: &Landed<f64>,
    ) -> Option<Landing> {
        let (film, optics) = (landed.film, self.of_band(traced.band));
        if !connections.window.holds(film) {
            return None;
        }
        let [x, y] = landed.pupil;
        let point = [x, y, optics.model.plane_z()];
        let importance = self.importance(optics) * optics.transmission(film, point) * traced.scale;
        let area = pupil(optics)?.area_at(film, landed.pupil);
        let density = area.map_or(0.0, |area| {
            let film = [film[0], film[1], self.spec.lens.film_z()];
            let solid_angle = projected_solid_angle(film, &PupilSample { point, area });
            traced.scale / (solid_angle * self.pixel_area() * optics.lens.rear().index.powi(2))
        });
        let raster = (DVec2::from(film) - DVec2::from(self.corner)) / DVec2::from(self.per_pixel);
        let landing = Landing {
            raster: raster.as_vec2(),
            importance: importance as f32 * optics.tint,
            density: density as f32,
        };
        let finite = landing.importance.is_finite() && landing.density.is_finite();
        (finite && importance > 0.0).then_some(landing)
    }

    /// See [`crate::cameras::Camera::connection_density`].
    pub(in super::super) fn connection_density(
        &self,
        sample: &CameraSample,
        ray: &CameraRay,
        p: Vec3,
    ) -> Option<f64> {
        let connections = self.connections.as_deref()?;
        let placement = self.transform.placement(ray.ray.time);
        let x = connections
            .lens_from_camera
            .transform_point3(placement.point(p));
        let d = placement.direction(-ray.ray.d);
        let d = DVec3::new(d.x, d.y, -d.z).normalize();
        let optics = self.of_band(self.band(sample.wavelength));
        // The weight knows the solid angle.
        let transmission = match optics.stop_mask {
            None => 1.0,
            Some(_) => {
                let film = self.film_point(sample.raster);
                optics.transmission(film, optics.aim(film, sample.lens)?.point)
            }
        };
        let density = self.importance(optics) * transmission / f64::from(ray.weight);
        let drawn = connections.entrance.density(x, d);
        Some(drawn / (density * self.area_across(&placement, d)))
    }

    /// Per étendue in the scene, mm², of a pixel.
    fn importance(&self, optics: &Optics) -> f64 {
        optics.weight_scale / (optics.lens.rear().index.powi(2) * self.pixel_area())
    }

    /// mm².
    fn pixel_area(&self) -> f64 {
        (self.per_pixel[0] * self.per_pixel[1]).abs()
    }

    /// Area in mm² across the direction `d` of lens coordinates, per area in render space.
    fn area_across(&self, placement: &Placement, d: DVec3) -> f64 {
        let camera_unit: f64 = match self.spec.form {
            Form::Course => 1.0,
            Form::Pbrt3 => 1e3,
        };
        placement.area_across(DVec3::new(d.x, d.y, -d.z)) * camera_unit.powi(2)
    }
}

/// Where the camera aims; one that connects aims at an exit pupil.
fn pupil(optics: &Optics) -> Option<&ExitPupil> {
    match &optics.aim {
        PupilTarget::Pupil(pupil) => Some(pupil),
        PupilTarget::RearDisk(_) => None,
    }
}
