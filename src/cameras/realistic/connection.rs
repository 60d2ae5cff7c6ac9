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
//! Source: for the measure, Welford and Winston, *High Collection Nonimaging Optics*, 1989, chapter 2.

use super::lanes::FEW;
use super::optics::{Optics, PupilTarget, is_too_fine};
use super::tilted::area_at;
use super::{Compat, Form, Precision, Realistic, camera_from_lens};
use crate::cameras::camera_transform::Placement;
use crate::cameras::connection::{Landing, LensSample, toward};
use crate::cameras::{BUNDLE, CameraRay, CameraSample};
use crate::math::instruction_set::{Instructions, Kernel, vectorize};
use crate::math::ray::Ray;
use crate::math::{DMat4, DVec2, DVec3, Vec2, Vec3};
use crate::optics::LensRay;
use crate::optics::entrance::{Drawn, EntrancePupil, FilmWindow, Seen};
use crate::optics::lanes::{Landed, Lanes, SceneTracer};
use crate::optics::models::ModelKind;
use crate::optics::pupil::{ExitPupil, PupilSample};
use crate::surface::ReferencePoint;
use arrayvec::ArrayVec;

/// What connections need beside the camera.
#[derive(Clone, Debug)]
pub(super) struct Connections {
    entrance: EntrancePupil,
    /// Of the film's own points.
    window: FilmWindow,
    /// Of the bands, or at the d line where there are none.
    tracers: Vec<Tracers>,
    /// Only those in double precision are to be used.
    one_by_one: bool,
    lens_from_camera: DMat4,
}

/// From the scene to the film.
#[derive(Clone, Debug)]
struct Tracers {
    double: SceneTracer<f64>,
    single: SceneTracer<f32>,
}

impl Tracers {
    fn new(optics: &Optics) -> Tracers {
        let (lens, plane_z) = (optics.model.lens(), optics.model.plane_z());
        Tracers {
            double: SceneTracer::new(lens, plane_z),
            single: SceneTracer::new(lens, plane_z),
        }
    }
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
    /// `true` if rays are those of the lens.
    pub(in super::super) fn connects(&self) -> bool {
        let exact = self.main.model.kind() == ModelKind::Exact;
        exact && self.spec.compat == Compat::None && self.transform.is_affine()
    }

    /// Finds out where to aim from the scene for light to land between these corners, in raster coordinates.
    pub(in super::super) fn prepare_connections(&mut self, window: [Vec2; 2]) {
        self.connections = self.connections_to(window);
    }

    /// See [`crate::cameras::Camera::prepare_motion`].
    pub(in super::super) fn prepare_motion(&mut self, window: [Vec2; 2]) {
        self.motion = self.connections_to(window);
    }

    fn connections_to(&self, window: [Vec2; 2]) -> Option<Box<Connections>> {
        let window = self.window(window);
        let lens = &self.spec.lens;
        let on_flat = self.tilted.as_ref().map_or(window, |tilted| {
            tilted.window_on_flat([window.low, window.high], lens)
        });
        // The d line first, though no ray is traced at it where there are bands.
        let seen = [&self.main].into_iter().chain(&self.bands);
        let seen: Vec<Seen<'_>> = seen
            .filter_map(|optics| Some((&optics.lens, pupil(optics)?)))
            .collect();
        let mut tracers: Vec<Tracers> = self.bands.iter().map(Tracers::new).collect();
        if tracers.is_empty() {
            tracers.push(Tracers::new(&self.main));
        }
        let fine = is_too_fine(&self.spec.lens);
        let made = EntrancePupil::new(&seen, on_flat).filter(|_| self.connects());
        made.map(|entrance| {
            Box::new(Connections {
                entrance,
                window,
                tracers,
                one_by_one: fine
                    || self.spec.precision == Precision::Double
                    || self.main.ghosts.is_some(),
                lens_from_camera: camera_from_lens(&self.spec).inverse(),
            })
        })
    }

    /// The film between two corners in raster coordinates.
    pub(super) fn window(&self, corners: [Vec2; 2]) -> FilmWindow {
        let corners = corners.map(|corner| self.film_point(corner));
        let ends = |pick: fn(f64, f64) -> f64| [0, 1].map(|i| pick(corners[0][i], corners[1][i]));
        FilmWindow {
            low: ends(f64::min),
            high: ends(f64::max),
        }
    }

    /// The raster coordinates of a film point.
    pub(super) fn raster(&self, film: [f64; 2]) -> Vec2 {
        let raster = (DVec2::from(film) - DVec2::from(self.corner)) / DVec2::from(self.per_pixel);
        raster.as_vec2()
    }

    /// See [`crate::cameras::Camera::aim`].
    pub(in super::super) fn aim(
        &self,
        from: &ReferencePoint,
        sample: &LensSample,
    ) -> Option<(Vec3, Ray, Traced)> {
        self.aim_by(self.connections.as_deref()?, from, sample)
    }

    /// Where on the film, in raster coordinates, a point is seen; `None` where it is not, or [`Realistic::prepare_motion`] was not called.
    pub(in super::super) fn seen_at(
        &self,
        from: &ReferencePoint,
        sample: &LensSample,
    ) -> Option<Vec2> {
        let connections = self.motion.as_deref()?;
        let (_, _, traced) = self.aim_by(connections, from, sample)?;
        Some(self.land_by(connections, &traced)?.raster)
    }

    fn aim_by(
        &self,
        connections: &Connections,
        from: &ReferencePoint,
        sample: &LensSample,
    ) -> Option<(Vec3, Ray, Traced)> {
        let placement = self.transform.placement(from.time);
        let x = placement.point(from.p);
        let in_lens = connections.lens_from_camera.transform_point3(x);
        let drawn = connections.entrance.draw(in_lens, sample.lens)?;
        let band = self.band(sample.wavelength);
        let traced = self.along(&placement, in_lens, &drawn, band)?;
        let start = camera_from_lens(&self.spec).transform_point3(DVec3::from(traced.ray.o));
        let (wi, shadow) = toward(from, &placement, x, start)?;
        Some((wi, shadow, traced))
    }

    /// The ray from the point `x` of lens coordinates in the direction drawn, where it meets the first surface; `None` where it does not.
    fn along(&self, placement: &Placement, x: DVec3, drawn: &Drawn, band: usize) -> Option<Traced> {
        let ray = LensRay {
            o: x.to_array(),
            d: drawn.d.to_array(),
        };
        let [front, _] = self.of_band(band).lens.tracer().front(&ray)?;
        let ahead = (DVec3::from(front) - x).dot(drawn.d) > 0.0;
        ahead.then(|| Traced {
            ray: LensRay { o: front, ..ray },
            band,
            scale: self.area_across(placement, drawn.d) / drawn.density,
        })
    }

    /// See [`crate::cameras::Camera::land`].
    pub(in super::super) fn land(&self, traced: &Traced) -> Option<Landing> {
        self.land_by(self.connections.as_deref()?, traced)
    }

    fn land_by(&self, connections: &Connections, traced: &Traced) -> Option<Landing> {
        let tracers = connections.tracers.get(traced.band)?;
        let landed = tracers.double.trace_alone(&traced.ray)?;
        self.landing(connections, traced, &landed)
    }

    /// The same for as many as fit into `out`, side by side in single precision, where one at a time is not asked for.
    pub(in super::super) fn land_all(
        &self,
        traced: &[Traced],
        out: &mut ArrayVec<Option<Landing>, BUNDLE>,
    ) {
        out.clear();
        let traced = &traced[..traced.len().min(BUNDLE)];
        let Some(connections) = self.connections.as_deref() else {
            out.extend(traced.iter().map(|_| None));
            return;
        };
        // What comes from behind the front vertex goes its own way.
        let alone = |t: &Traced| connections.one_by_one || t.ray.d[2] <= 0.0;
        out.extend(traced.iter().map(|t| match alone(t) {
            true => self.land(t),
            false => None,
        }));
        for band in 0..connections.tracers.len() {
            let of_this = |i: &usize| traced[*i].band == band && !alone(&traced[*i]);
            let chosen: ArrayVec<usize, BUNDLE> = (0..traced.len()).filter(of_this).collect();
            if self.disperses() {
                for few in chosen.chunks(FEW) {
                    self.land_lanes::<FEW>(connections, traced, few, out);
                }
            } else if !chosen.is_empty() {
                self.land_lanes::<BUNDLE>(connections, traced, &chosen, out);
            }
        }
    }

    /// Those of the rays that are number `chosen`, at least one, at most N and of one band.
    fn land_lanes<const N: usize>(
        &self,
        connections: &Connections,
        traced: &[Traced],
        chosen: &[usize],
        out: &mut [Option<Landing>],
    ) {
        // Lanes without a ray repeat the first.
        let one = |lane: usize| &traced[*chosen.get(lane).unwrap_or(&chosen[0])];
        let mut ray = LensRay {
            o: [Lanes::splat(0.0); 3],
            d: [Lanes::splat(0.0); 3],
        };
        for lane in 0..N {
            let from = &one(lane).ray;
            for k in 0..3 {
                ray.o[k].0[lane] = from.o[k] as f32;
                ray.d[k].0[lane] = from.d[k] as f32;
            }
        }
        let tracer = &connections.tracers[one(0).band].single;
        let landed = vectorize::<N, _>(ToFilm { tracer, ray: &ray });
        for (lane, i) in chosen.iter().take(N).enumerate() {
            let at = |x: &[Lanes<N>; 2]| [0, 1].map(|k| f64::from(x[k].0[lane]));
            let here = Landed {
                film: at(&landed.film),
                pupil: at(&landed.pupil),
                passed: landed.passed.at(lane),
            };
            out[*i] = match here.passed {
                true => self.landing(connections, &traced[*i], &here),
                false => None,
            };
        }
    }

    /// What light counts for that has landed.
    fn landing(
        &self,
        connections: &Connections,
        traced: &Traced,
        landed: &Landed<f64>,
    ) -> Option<Landing> {
        let optics = self.of_band(traced.band);
        let [x, y] = landed.pupil;
        let point = [x, y, optics.model.plane_z()];
        let film = match &self.tilted {
            None => landed.film,
            Some(tilted) => tilted.from_flat(landed.film, point),
        };
        if !connections.window.holds(film) {
            return None;
        }
        let importance =
            self.importance(optics) * optics.transmission(landed.film, point) * traced.scale;
        if self.is_behind(film, point) {
            return None;
        }
        let area = match (&self.tilted, &optics.tilted) {
            (Some(tilted), Some(pupil)) => area_at(tilted, pupil, film, landed.pupil),
            _ => pupil(optics)?.area_at(film, landed.pupil),
        };
        let density = area.map_or(0.0, |area| {
            let solid_angle = self.projected_solid_angle(film, &PupilSample { point, area });
            traced.scale / (solid_angle * self.pixel_area() * optics.lens.rear().index.powi(2))
        });
        let landing = Landing {
            raster: self.raster(film),
            importance: importance as f32 * optics.tint(landed.film, point)?,
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
                let (film, aim) = self.aimed(optics, film, sample.lens)?;
                optics.transmission(film, aim.point)
            }
        };
        let density = self.importance(optics) * transmission / f64::from(ray.weight);
        let drawn = connections.entrance.density(x, d);
        Some(drawn / (density * self.area_across(&placement, d)))
    }

    /// Per étendue in the scene, mm², of a pixel.
    pub(super) fn importance(&self, optics: &Optics) -> f64 {
        optics.weight_scale / (optics.lens.rear().index.powi(2) * self.pixel_area())
    }

    /// mm².
    pub(super) fn pixel_area(&self) -> f64 {
        (self.per_pixel[0] * self.per_pixel[1]).abs()
    }

    /// Area in mm² across the direction `d` of lens coordinates, per area in render space.
    pub(super) fn area_across(&self, placement: &Placement, d: DVec3) -> f64 {
        placement.area_across(DVec3::new(d.x, d.y, -d.z)) * self.camera_unit().powi(2)
    }

    /// Of camera space, mm.
    pub(super) fn camera_unit(&self) -> f64 {
        match self.spec.form {
            Form::Course => 1.0,
            Form::Pbrt3 => 1e3,
        }
    }
}

/// A bundle of rays to the film.
struct ToFilm<'a, const N: usize> {
    tracer: &'a SceneTracer<f32>,
    ray: &'a LensRay<Lanes<N>>,
}

impl<const N: usize> Kernel for ToFilm<'_, N> {
    type Output = Landed<Lanes<N>>;
    #[inline(always)]
    fn run(self, _: impl Instructions) -> Self::Output {
        self.tracer.trace(self.ray)
    }
}

/// Where the camera aims; one that connects aims at an exit pupil.
fn pupil(optics: &Optics) -> Option<&ExitPupil> {
    match &optics.aim {
        PupilTarget::Pupil(pupil) => Some(pupil),
        PupilTarget::RearDisk(_) => None,
    }
}

#[cfg(test)]
mod tests;
