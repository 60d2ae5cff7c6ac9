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
//! (default), `polar` or `rejection`; see [`PupilSampling`]. It changes noise only.
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
//! `"bool dispersion"` (false): each ray is traced at one of twelve wavelengths, for lens files that tell Abbe numbers or
//! dispersion formulas; see [`super::Band`]. The pupil, the model and the weight are those of the wavelength, the film
//! stays where the d line has it.
//!
//! In both the scene lies on +z and the image is upright. The course form is recognized by any of its
//! own names. Sources: Kolb, Mitchell and Hanrahan, "A Realistic Camera Model for Computer Graphics",
//! SIGGRAPH 1995; Pharr, Jakob and Humphreys, 3rd edition, §6.4.

use super::camera_transform::{BatchTransform, CameraSpaceRay, CameraTransform};
use super::pbrt_pupil_box::innermost_box_area;
use super::realistic_bands::Band;
use super::{BUNDLE, CameraError, CameraRay, CameraSample, Clip, FilmGeometry, Shutter};
use crate::math::motion::Motion;
use crate::math::sampling::concentric_disk;
use crate::math::transform::Transform;
use crate::math::{DMat4, DVec3, Rgb, Vec2};
use crate::optics::models::{LensModel, ModelKind};
use crate::optics::pupil::{ExitPupil, PupilSample, PupilSampling, RINGS, projected_solid_angle};
use crate::optics::real::Dual;
use crate::optics::{Lens, LensRay, StopShape};
use arrayvec::ArrayVec;

/// Which spelling a camera was written in: decides units and origin of camera space.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// Camera space in millimeters, origin at the front vertex.
    Course,
    /// Camera space in meters, origin at the film's center.
    Pbrt3,
}

/// Whose habits to copy (`"string compat"`, `--compat`).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Compat {
    /// Nobody's: every film point sees its true exit pupil.
    #[default]
    None,
    /// The course kit's on pbrt-v2: samples the rear element's disk, flat at its vertex (and so
    /// misses what enters a curved element outside it), and drops a sample when the ray of the
    /// next pixel in x or in y through the same point of the disk is vignetted.
    PbrtV2,
}

/// What the radiance along a ray counts for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Weighting {
    /// The pixel is the irradiance on the film (times the shutter's opening time, where that is
    /// not 0): n'²·A·cos⁴θ/Z², as radiance in a medium of index n' is n'² times that in air.
    Physical,
    /// pbrt-v3's `simpleweighting`: cos⁴θ times the pupil's area relative to pbrt's box around
    /// the pupil of the film's middle, so that a white scene gives at most 1. A relative weight, that knows no n'².
    Simple,
}

/// The number type that an image's rays are traced in (`"string precision"`).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Precision {
    /// f32, side by side.
    #[default]
    Single,
    /// f64, one ray at a time.
    Double,
}

/// A realistic camera as the scene file describes it: lens file read, stop set, focused.
#[derive(Clone, Debug)]
pub struct RealisticSpec {
    /// Name of the lens file, without folders.
    pub lens_name: String,
    /// The lens, its stop set and its film in place.
    pub lens: Lens,
    /// Units and origin of camera space.
    pub form: Form,
    /// What rays count for.
    pub weighting: Weighting,
    /// Whose habits to copy.
    pub compat: Compat,
    /// How lens samples are spread over the exit pupil.
    pub pupil_sampling: PupilSampling,
    /// What rays are made with.
    pub model: ModelKind,
    /// In which precision.
    pub precision: Precision,
    /// What the stop is shaped like, if not round.
    pub stop_shape: Option<StopShape>,
    /// The bands of the spectrum that rays are traced in; none: all at the d line.
    pub bands: Vec<Band>,
    /// Film diagonal in mm that overrides the film's own (`filmdiag`).
    pub film_diagonal: Option<f64>,
    /// When light is let in.
    pub shutter: Shutter,
    /// Clip planes, in camera units.
    pub clip: Clip,
}

impl RealisticSpec {
    /// The diagonal that counts, mm.
    pub fn diagonal(&self, film: &FilmGeometry) -> f64 {
        self.film_diagonal.unwrap_or(film.diagonal_mm)
    }
}

/// Where rays are aimed.
#[derive(Clone, Debug)]
pub(super) enum PupilTarget {
    /// At the true exit pupil.
    Pupil(Box<ExitPupil>),
    /// At the rear element's disk, flat at its vertex: radius in mm.
    RearDisk(f64),
}

/// The lens at one wavelength, and what makes its rays.
#[derive(Clone, Debug)]
pub(super) struct Optics {
    lens: Lens,
    pub(super) aim: PupilTarget,
    pub(super) model: LensModel,
    /// The lens with its shaped stop, where rays need to be weighed by it: by an image, or because the model traces none.
    stop_mask: Option<Box<Lens>>,
    /// See [`CameraRay::tint`].
    pub(super) tint: Rgb,
    /// Weight over projected solid angle at the film.
    pub(super) weight_scale: f64,
}

/// A realistic camera ready to make rays.
#[derive(Clone, Debug)]
pub struct Realistic {
    pub(super) spec: RealisticSpec,
    transform: CameraTransform,
    /// For bundles; `None` where rays are made one at a time.
    pub(super) placing: Option<BatchTransform>,
    /// At the d line.
    pub(super) main: Optics,
    /// Of the bands of the spectrum; none without dispersion.
    pub(super) bands: Vec<Optics>,
    /// Film point (mm) of raster (0, 0), and its change per pixel in x and y.
    corner: [f64; 2],
    pub(super) per_pixel: [f64; 2],
}

/// The exit pupil is known for film points this many pixels outside the image: the widest reconstruction
/// filter in use, a windowed sinc, reaches four. Farther out everything still works, with more rays lost.
const FILTER_REACH: f64 = 4.0;

impl Realistic {
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
        let in_air = match spec.weighting {
            Weighting::Physical => spec.shutter.exposure(),
            // Relative to the middle of the image at the d line, whatever the medium.
            Weighting::Simple => {
                let relative = lens.film_distance() / lens.rear().index;
                relative.powi(2) / innermost_box_area(lens, diagonal)
            }
        };
        let optics = |lens: &Lens, tint: Rgb| {
            let mut optics = Optics::new(spec, lens, tint, 0.5 * diagonal, pitch)?;
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
        Ok(Realistic {
            placing: if one_by_one {
                None
            } else {
                transform.placing(&camera_from_lens(spec))
            },
            transform,
            main,
            bands: bands.collect::<Result<_, _>>()?,
            // The lens turns the image over: the image's top left is the film's bottom right,
            // seen from behind.
            corner: [0.5 * width, -0.5 * height],
            per_pixel: [-pitch, height / f64::from(film.resolution.y)],
            spec: spec.clone(),
        })
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

    /// Are rays traced in several bands of the spectrum?
    pub fn disperses(&self) -> bool {
        !self.bands.is_empty()
    }

    /// What makes the ray of `sample`.
    pub(super) fn optics(&self, sample: &CameraSample) -> &Optics {
        let count = self.bands.len();
        let band = (f64::from(sample.wavelength) * count as f64) as usize;
        let band = self.bands.get(band.min(count.saturating_sub(1)));
        band.unwrap_or(&self.main)
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
            (value(&ray), self.differentials(&ray, time))
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
    pub(super) fn film_point(&self, raster: Vec2) -> [f64; 2] {
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
    pub(super) fn camera_ray(&self, ray: &LensRay<f64>) -> CameraSpaceRay {
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
            let shift = |x: Dual| x.value + self.per_pixel[axis] * x.by[axis];
            self.camera_ray(&LensRay {
                o: ray.o.map(shift),
                d: ray.d.map(shift),
            })
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

impl Optics {
    fn new(
        spec: &RealisticSpec,
        lens: &Lens,
        tint: Rgb,
        film_radius: f64,
        pitch: f64,
    ) -> Result<Optics, CameraError> {
        let reach = film_radius + FILTER_REACH * pitch * std::f64::consts::SQRT_2;
        let aim = match spec.compat {
            Compat::None => {
                let pupil = ExitPupil::new(lens, reach, RINGS);
                PupilTarget::Pupil(Box::new(pupil.with_sampling(spec.pupil_sampling)))
            }
            Compat::PbrtV2 => PupilTarget::RearDisk(0.5 * lens.rear().aperture),
        };
        let model = match &aim {
            PupilTarget::Pupil(pupil) => LensModel::new(spec.model, lens, pupil, film_radius)
                .map_err(CameraError::LensModel)?,
            PupilTarget::RearDisk(_) => LensModel::exact(lens, lens.length()),
        };
        let (model, stop_mask) = shaped(model, lens, spec.stop_shape.as_ref());
        Ok(Optics {
            lens: lens.clone(),
            aim,
            model,
            stop_mask,
            tint,
            weight_scale: 1.0,
        })
    }

    /// Part of the light of a ray that a shaped stop lets pass, where the model does not see to that.
    fn transmission(&self, film: [f64; 2], pupil: [f64; 3]) -> f64 {
        let stop_mask = self.stop_mask.as_ref();
        stop_mask.map_or(1.0, |lens| lens.stop_transmission(film, pupil))
    }

    /// Where to send the ray from `film`; `None` where no light comes from.
    pub(super) fn aim(&self, film: [f64; 2], u: Vec2) -> Option<PupilSample> {
        match &self.aim {
            PupilTarget::Pupil(pupil) => self.model.sample_pupil(pupil, film, u),
            PupilTarget::RearDisk(radius) => {
                let p = radius * concentric_disk(u).as_dvec2();
                Some(PupilSample {
                    point: [p.x, p.y, self.lens.length()],
                    area: std::f64::consts::PI * radius * radius,
                })
            }
        }
    }
}

/// An aperture narrower than this part of the way to the film is met in double precision: in single precision a ray is
/// off by some millionths of its coordinates there, and light would be lost.
const FINEST_APERTURE: f64 = 1.0 / 262_144.0;

/// Has the lens an aperture too small for rays in single precision?
fn is_too_fine(lens: &Lens) -> bool {
    let narrowest = lens.surfaces().iter().map(|s| s.aperture);
    narrowest.fold(f64::INFINITY, f64::min) < FINEST_APERTURE * lens.film_z()
}

/// `model` with a stop of this shape, and the lens that weighs its rays where the model cannot.
fn shaped(
    model: LensModel,
    lens: &Lens,
    shape: Option<&StopShape>,
) -> (LensModel, Option<Box<Lens>>) {
    let Some(shape) = shape else {
        return (model, None);
    };
    let lens = lens.clone().with_stop_shape(shape.clone());
    match (model.kind(), shape) {
        // Exact rays end at blades by themselves.
        (ModelKind::Exact, StopShape::Polygon(_)) => {
            (LensModel::exact(&lens, model.plane_z()), None)
        }
        _ => (model, Some(Box::new(lens))),
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

fn value(ray: &LensRay<Dual>) -> LensRay<f64> {
    LensRay {
        o: ray.o.map(|x| x.value),
        d: ray.d.map(|x| x.value),
    }
}
