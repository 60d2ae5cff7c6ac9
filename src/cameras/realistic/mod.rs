//! `Camera "realistic"`: a camera whose every ray is traced through a lens prescription.
//!
//! Two spellings, one camera:
//!
//! | | course kits on pbrt-v1 and v2 | pbrt-v3 |
//! |---|---|---|
//! | lens file | `specfile` | `lensfile` |
//! | focus | `filmdistance` mm, rear vertex to film (70) | `focusdistance` m, film to plane of focus (10); `filmdistance` wins |
//! | stop, mm | `aperture_diameter` (1) | `aperturediameter` (1) |
//! | film diagonal, mm | `filmdiag` (the film's) | the film's `diagonal` |
//! | camera space | mm, origin at the front vertex | m, origin at the film's center |
//! | weight | irradiance | `simpleweighting` true: relative; false: irradiance times the time the shutter is open |
//! | clip planes | `hither`, `yon` | none |
//!
//! Both know `"string pupilsampling"`, how lens samples are spread over the exit pupil: `concentric`
//! (default), `polar` or `rejection`; see [`crate::optics::pupil::PupilSampling`]. It changes noise only.
//!
//! `"string focus"`: `paraxial` (default) or `best`, the film where the axial spot of real rays is smallest
//! ([`crate::optics::best_focus`]); `"float scale"`, by which all lengths of the lens file are multiplied; and
//! `"string model"`: what rays are made with, `exact` (default), or `thick` and `thin` as in textbooks; see
//! [`crate::optics::models`]. Rays of an image are made side by side in single precision
//! ([`Realistic::rays`]), which is below 0.02 pixels of a 6000 × 4000 full-frame sensor for every lens in `tests/golden`;
//! `"string precision" "double"` makes them one at a time, and so does a stop of less than some 0.0002 mm.
//!
//! `"string aperture"`, what the stop is shaped like: `circular` (default), pbrt-v4's `gaussian`, `square`, `pentagon` and
//! `star`, or the name of an image; `"integer blades"`: that many straight blades, corners on the circle of the stop's diameter,
//! one of them up; `"float bladerotation"` turns all but images, degrees counterclockwise as seen from behind the camera
//! ([`crate::optics::stop_shape`]). The image darkens by the area that is covered; pbrt-v4 makes up for it.
//!
//! What a photographer sets (docs/camera.md): `"float fnumber"` or `"float tnumber"` instead of the stop's diameter
//! ([`crate::optics::f_number`]); `"float exposuretime"` in seconds and `"float iso"`, apart from the time of the animation
//! ([`Exposure`]); `"float shift"` [x y], the lens moved across the film, mm; `"float zoom"` of a lens whose file says how its groups
//! move, which they do with `focusdistance`, too ([`crate::optics::prescription::positions`]).
//!
//! `"bool dispersion"` (false): each ray is traced at one of twelve wavelengths, for lens files that tell Abbe numbers or
//! dispersion formulas; see [`Band`]. The pupil, the model and the weight are those of the wavelength, the film
//! stays where the d line has it.
//!
//! In both the scene lies on +z and the image is upright. The course form is recognized by any of its
//! own names. Sources: Kolb, Mitchell and Hanrahan, "A Realistic Camera Model for Computer Graphics",
//! SIGGRAPH 1995; Pharr, Jakob and Humphreys, 3rd edition, §6.4.

mod bands;
mod connection;
mod exposure;
mod lanes;
mod optics;
mod params;
pub mod pbrt_pupil_box;
mod photograph;
mod report;
mod spec;
mod stop_shape;
#[cfg(test)]
mod tests;

pub use bands::Band;
pub(super) use connection::Traced;
pub use exposure::Exposure;
pub use spec::{Compat, Form, Precision, RealisticSpec, Weighting};

use super::blur::{Blur, Line};
use super::camera_transform::{BatchTransform, CameraSpaceRay, CameraTransform};
use super::{BUNDLE, CameraError, CameraRay, CameraSample, FilmGeometry, Shutter};
use crate::math::motion::Motion;
use crate::math::transform::Transform;
use crate::math::{DMat4, DVec3, Rgb, Vec2};
use crate::optics::pupil::projected_solid_angle;
use crate::optics::real::Dual;
use crate::optics::{Lens, LensRay};
use arrayvec::ArrayVec;
use connection::Connections;
use optics::{Optics, PupilTarget, is_too_fine};
use pbrt_pupil_box::innermost_box_area;

/// A realistic camera ready to make rays.
#[derive(Clone, Debug)]
pub struct Realistic {
    spec: RealisticSpec,
    transform: CameraTransform,
    /// For bundles; `None` where rays are made one at a time.
    placing: Option<BatchTransform>,
    /// At the d line.
    main: Optics,
    /// Of the bands of the spectrum; none without dispersion.
    bands: Vec<Optics>,
    /// Film point (mm) of raster (0, 0), and its change per pixel in x and y.
    corner: [f64; 2],
    per_pixel: [f64; 2],
    blur: Blur,
    /// Once they are asked for.
    connections: Option<Box<Connections>>,
}

impl Realistic {
    /// How it stands in the scene.
    pub(super) fn transform(&self) -> &CameraTransform {
        &self.transform
    }

    /// See [`Blur`].
    pub(super) fn blur(&self) -> &Blur {
        &self.blur
    }

    /// Traces a ray near the lens' axis and, to first order, that of the next pixel; `None` where light along the axis is
    /// blocked, or the pupil is not known (`--compat pbrt-v2`).
    fn first_order_blur(&self) -> Option<Blur> {
        /// Part of the pupil's radius: near the axis, where a lens has no aberrations to speak of.
        const NEAR: f64 = 0.05;
        let PupilTarget::Pupil(pupil) = &self.main.aim else {
            return None;
        };
        let (film, z) = ([0.0, 0.0], pupil.plane_z());
        let edge = NEAR * pupil.region(0.0)?.along;
        let near = self.main.model.trace_from_film(film, [edge, 0.0, z]).ok()?;
        let axis = { &self.main.model }.trace_with_derivatives(film, [0.0, 0.0, z]);
        let next = { axis.ok()? }.map(|x| x.value + self.per_pixel[0] * x.by[0]);
        Some(Blur {
            radius: Line::of_ray(&self.camera_ray(&near), 1.0 / NEAR),
            pixel: Line::of_ray(&self.camera_ray(&next), 1.0),
        })
    }

    /// When it lets light in.
    pub(super) fn shutter(&self) -> &Shutter {
        &self.spec.shutter
    }

    /// Puts `spec` in front of `film`, whose resolution is positive.
    pub fn new(
        spec: &RealisticSpec,
        film: &FilmGeometry,
        render_from_camera: &Transform,
    ) -> Result<Realistic, CameraError> {
        let diagonal = spec.diagonal(film);
        if !(diagonal > 0.0 && diagonal.is_finite()) {
            return Err(CameraError::FilmDiagonal(diagonal));
        }
        let [width, height] = film.size_mm(diagonal);
        let pitch = width / f64::from(film.resolution.x);
        let lens = &spec.lens;
        let exposure = spec.exposure.factor(&spec.shutter, spec.weighting);
        let in_air = match spec.weighting {
            Weighting::Physical => exposure,
            // Relative to the middle of the image at the d line, whatever the medium.
            Weighting::Simple => {
                let relative = lens.film_distance() / lens.rear().index;
                exposure * relative.powi(2) / innermost_box_area(lens, diagonal)
            }
        };
        let optics = |lens: &Lens, tint: Rgb| {
            let mut optics = Optics::new(spec, lens, tint, spec.film_reach(film), pitch)?;
            // Radiance over the squared index is what stays the same along a ray.
            optics.weight_scale = in_air * lens.rear().index.powi(2);
            Ok(optics)
        };
        let bands = spec.bands.iter().map(|band| optics(&band.lens, band.tint));
        let transform = CameraTransform::new(render_from_camera, spec.clip);
        let main = optics(lens, Rgb::ONE)?;
        let one_by_one = spec.compat != Compat::None
            || spec.precision == Precision::Double
            || is_too_fine(lens)
            || main.stop_mask.is_some();
        let mut camera = Realistic {
            blur: Blur::default(),
            placing: if one_by_one {
                None
            } else {
                transform.placing(&camera_from_lens(spec))
            },
            transform,
            main,
            bands: bands.collect::<Result<_, _>>()?,
            // The lens turns the image over: the image's top left is the film's bottom right,
            // seen from behind. A lens moved up and to the right sees the film move the other way.
            corner: [0.5 * width - spec.shift[0], -0.5 * height - spec.shift[1]],
            per_pixel: [-pitch, height / f64::from(film.resolution.y)],
            connections: None,
            spec: spec.clone(),
        };
        camera.blur = camera.first_order_blur().unwrap_or_default();
        Ok(camera)
    }

    /// Lets the camera move while its shutter is open. Rays are then placed one at a time, each at its own time.
    pub(super) fn set_motion(&mut self, motion: Motion) {
        self.transform.set_motion(motion);
        self.placing = None;
    }

    /// The rays for `samples`, side by side.
    pub fn rays(
        &self,
        samples: &[CameraSample],
        want_differentials: bool,
        rays: &mut ArrayVec<Option<CameraRay>, BUNDLE>,
    ) {
        if let Some(made) = self.rays_in_lanes(samples, want_differentials) {
            *rays = made;
            return;
        }
        rays.clear();
        let one = |sample| self.ray(sample, want_differentials);
        rays.extend(samples.iter().take(BUNDLE).map(one));
    }

    /// Returns `true` if rays are traced in several bands of the spectrum.
    pub fn disperses(&self) -> bool {
        !self.bands.is_empty()
    }

    /// What makes the ray of `sample`.
    fn optics(&self, sample: &CameraSample) -> &Optics {
        self.of_band(self.band(sample.wavelength))
    }

    /// The number of the band that a part of the spectrum from 0 to 1 falls into.
    fn band(&self, wavelength: f32) -> usize {
        let count = self.bands.len();
        let band = (f64::from(wavelength) * count as f64) as usize;
        band.min(count.saturating_sub(1))
    }

    /// What makes the rays of a band; without any, all.
    fn of_band(&self, band: usize) -> &Optics {
        self.bands.get(band).unwrap_or(&self.main)
    }

    /// The ray for `sample` in double precision; `None` where it is vignetted.
    pub fn ray(&self, sample: &CameraSample, want_differentials: bool) -> Option<CameraRay> {
        let film = self.film_point(sample.raster);
        let optics = self.optics(sample);
        let pupil = optics.aim(film, sample.lens)?;
        let time = self.spec.shutter.time(sample.time);
        let (ray, differentials) = if want_differentials {
            let ray = optics.model.trace_with_derivatives(film, pupil.point);
            let ray = ray.ok()?;
            (ray.map(|x| x.value), self.differentials(&ray, time))
        } else {
            (optics.model.trace_from_film(film, pupil.point).ok()?, None)
        };
        let copies = matches!(optics.aim, PupilTarget::RearDisk(_));
        if copies && !self.neighbors_pass(optics, film, pupil.point) {
            return None;
        }
        let transmission = optics.transmission(film, pupil.point);
        if transmission <= 0.0 {
            return None;
        }
        let film = [film[0], film[1], self.spec.lens.film_z()];
        Some(CameraRay {
            ray: self.transform.ray(&self.camera_ray(&ray), time),
            weight: (optics.weight_scale * transmission * projected_solid_angle(film, &pupil))
                as f32,
            tint: optics.tint,
            differentials,
        })
    }

    /// The point of the film, mm, where the lens throws what belongs at `raster`.
    fn film_point(&self, raster: Vec2) -> [f64; 2] {
        let raster = raster.as_dvec2().to_array();
        std::array::from_fn(|i| self.corner[i] + self.per_pixel[i] * raster[i])
    }

    /// Do the rays of the next pixel in x and of the next in y pass, through the same pupil point?
    fn neighbors_pass(&self, optics: &Optics, film: [f64; 2], pupil: [f64; 3]) -> bool {
        let passes = |film| optics.lens.trace_from_film(film, pupil).is_ok();
        passes([film[0] + self.per_pixel[0], film[1]])
            && passes([film[0], film[1] + self.per_pixel[1]])
    }

    /// From lens coordinates to camera space.
    fn camera_ray(&self, ray: &LensRay<f64>) -> CameraSpaceRay {
        CameraSpaceRay {
            o: camera_from_lens(&self.spec).transform_point3(DVec3::from(ray.o)),
            d: DVec3::new(ray.d[0], ray.d[1], -ray.d[2]),
        }
    }

    /// The rays one pixel on, to first order: this ray and its derivatives by the film point.
    /// `None` on the very edge of total reflection, where a derivative is infinite.
    fn differentials(
        &self,
        ray: &LensRay<Dual>,
        time: f32,
    ) -> Option<crate::math::ray::RayDifferentials> {
        let shifted = |axis: usize| {
            self.camera_ray(&ray.map(|x| x.value + self.per_pixel[axis] * x.by[axis]))
        };
        let (x, y) = (shifted(0), shifted(1));
        let finite = [x.o, x.d, y.o, y.d].iter().all(|v| v.is_finite());
        finite.then(|| self.transform.differentials(&x, &y, time))
    }

    /// Fraction of the image's rays that end in the lens, estimated from a few thousand.
    pub fn vignetted_fraction(&self, film: &FilmGeometry) -> f64 {
        // 4096 well-spread samples: to about a percent.
        let count = 4096;
        let size = film.resolution.as_vec2();
        let passed = (0..count).filter(|i| {
            // Four coordinates of the R sequence (Roberts 2018).
            let r =
                |k: i32| (0.5 + f64::from(*i) / 1.167_303_978_261_418_7f64.powi(k)).fract() as f32;
            let raster = Vec2::new(r(1), r(2)) * size;
            let sample = CameraSample {
                raster,
                time: 0.0,
                lens: Vec2::new(r(3), r(4)),
                wavelength: 0.5,
            };
            self.ray(&sample, false).is_some()
        });
        1.0 - passed.count() as f64 / f64::from(count)
    }

    /// Angle in radians between the axis and the middle of the light that reaches the film point
    /// `radius` mm from the axis; `None` where none does.
    pub fn field_angle(&self, radius: f64) -> Option<f64> {
        let center = match &self.main.aim {
            PupilTarget::Pupil(pupil) => [pupil.region(radius)?.center, 0.0, pupil.plane_z()],
            PupilTarget::RearDisk(_) => [0.0, 0.0, self.spec.lens.length()],
        };
        let ray = self.spec.lens.film_ray([radius, 0.0], center);
        let out = self.spec.lens.tracer().to_scene_unclipped(&ray).ok()?;
        Some(out.d[0].hypot(out.d[1]).atan2(-out.d[2]))
    }
}

/// From lens coordinates, mm, to camera space.
fn camera_from_lens(spec: &RealisticSpec) -> DMat4 {
    let turned = DMat4::from_scale(DVec3::new(1.0, 1.0, -1.0));
    match spec.form {
        Form::Course => turned,
        Form::Pbrt3 => {
            let film = DVec3::new(0.0, 0.0, spec.lens.film_z());
            DMat4::from_scale(DVec3::splat(1e-3)) * DMat4::from_translation(film) * turned
        }
    }
}
