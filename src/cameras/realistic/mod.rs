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
//! ([`Exposure`]); `"float shift"` [x y], the lens moved across the film, mm; `"float tilt"` [x y], the film turned about its
//! middle, degrees (`tilted`); `"float zoom"` of a lens whose file says how its groups
//! move, which they do with `focusdistance`, too ([`crate::optics::prescription::positions`]); `"float focuspoint"` [x y],
//! `"float autofocuszones"` and `"string af_zones"`, parts of the image to focus on, and `"string focusobject"`, a thing in it (`autofocus`).
//!
//! `"bool dispersion"` (false): each ray is traced at one of twelve wavelengths, for lens files that tell Abbe numbers or
//! dispersion formulas; see [`Band`]. The pupil, the model and the weight are those of the wavelength, the film
//! stays where the d line has it.
//!
//! `"bool ghosts"` (false): surfaces reflect. The image lacks what they do, and has the ghosts of lamps and sky; `"string coating"`, such as
//! `1.38@550`, is on those of which the lens file says none (`ghosts`).
//!
//! In both the scene lies on +z and the image is upright. The course form is recognized by any of its
//! own names. Sources: Kolb, Mitchell and Hanrahan, "A Realistic Camera Model for Computer Graphics",
//! SIGGRAPH 1995; Pharr, Jakob and Humphreys, 3rd edition, §6.4.

mod autofocus;
mod bands;
mod connection;
mod exposure;
mod ghosts;
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
mod tilted;

pub(super) use autofocus::Autofocus;
pub use bands::Band;
pub(super) use connection::Traced;
pub use exposure::Exposure;
pub use ghosts::GhostEntry;
pub(crate) use params::is_course_form;
pub use spec::{Compat, Form, Precision, RealisticSpec, Weighting};

use super::blur::{Blur, Line};
use super::camera_transform::{BatchTransform, CameraSpaceRay, CameraTransform};
use super::{BUNDLE, CameraError, CameraRay, CameraSample, FilmGeometry, Shutter};
use crate::math::motion::Motion;
use crate::math::transform::Transform;
use crate::math::{DMat4, DVec3, Rgb, Vec2, Vec3};
use crate::optics::pupil::{ExitPupil, PupilSample, projected_solid_angle};
use crate::optics::real::Dual;
use crate::optics::{Lens, LensRay};
use crate::syntax::Span;
use connection::Connections;
use ghosts::GhostSampling;
use optics::{FILTER_REACH, FilmReach, Optics, PupilTarget};
use pbrt_pupil_box::innermost_box_area;
use tilted::TiltedFilm;

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
    /// Where the film lies, if it is tilted.
    tilted: Option<TiltedFilm>,
    blur: Blur,
    /// Once they are asked for.
    connections: Option<Box<Connections>>,
    /// For where points are seen, also beyond what is rendered.
    motion: Option<Box<Connections>>,
    ghost_sampling: Option<Box<GhostSampling>>,
}

impl Realistic {
    /// How it stands in the scene.
    pub(super) fn transform(&self) -> &CameraTransform {
        &self.transform
    }

    /// See [`Blur`]; `None` where it depends on the point.
    pub(super) fn even_blur(&self) -> Option<Blur> {
        self.tilted.is_none().then_some(self.blur)
    }

    /// See [`Blur`]; of the point `p` in render space.
    pub(super) fn blur(&self, p: Vec3, time: f32) -> Blur {
        self.tilted_blur(p, time).unwrap_or(self.blur)
    }

    /// The same of a tilted film, to first order about where it shows `p`; `None` if it is not tilted, or the lens has no pupils.
    fn tilted_blur(&self, p: Vec3, time: f32) -> Option<Blur> {
        let tilted = self.tilted.as_ref()?;
        let PupilTarget::Pupil(pupil) = &self.main.aim else {
            return None;
        };
        let lens = &self.spec.lens;
        let (entrance, exit) = (lens.paraxial().entrance_pupil?, lens.paraxial().exit_pupil?);
        let lens_from_camera = camera_from_lens(&self.spec).inverse();
        let p = lens_from_camera.transform_point3(self.transform.placement(time).point(p));
        let scale = lens.pinhole_focal_length()? / (p.z - entrance.z);
        let film = tilted.from_flat([scale * p.x, scale * p.y], [0.0, 0.0, exit.z]);
        let z = tilted.point(film).z;
        let k = (lens.film_z() - z) / (pupil.plane_z() - z);
        let center = [0.0, 0.0, pupil.plane_z()];
        let from = tilted.on_flat(film, center);
        let step = self.steps(film, from, center)?[0][0] / self.per_pixel[0];
        let along = self.edge_of_pupil(pupil)?;
        Some(self.blur.tilted(k * along / self.per_pixel[0], step))
    }

    /// How far from the axis rays of the middle of the film to the edge of the Gaussian exit pupil meet the plane of the sampled one, mm. (What is
    /// sampled is larger: it has a margin, and the real pupil's aberrations.)
    fn edge_of_pupil(&self, pupil: &ExitPupil) -> Option<f64> {
        let lens = &self.spec.lens;
        let Some(exit) = lens.paraxial().exit_pupil else {
            return Some(pupil.region(0.0)?.along);
        };
        let slope = 0.5 * exit.diameter / (lens.film_z() - exit.z);
        Some((slope * (lens.film_z() - pupil.plane_z())).abs())
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
        let edge = NEAR * self.edge_of_pupil(pupil)?;
        let near = self.main.model.trace_from_film(film, [edge, 0.0, z]).ok()?;
        let axis = { &self.main.model }.trace_with_derivatives(film, [0.0, 0.0, z]);
        let next = { axis.ok()? }.map(|x| x.value + self.per_pixel[0] * x.by[0]);
        Some(Blur {
            radius: Line::of_ray(&self.camera_ray(&near), 1.0 / NEAR),
            pixel: Line::of_ray(&self.camera_ray(&next), 1.0),
        })
    }

    /// From the last vertex of its lens to the film, mm.
    pub fn film_distance(&self) -> f64 {
        self.spec.lens.film_distance()
    }

    /// Where the scene asks for autofocus.
    pub fn autofocus_place(&self) -> Option<Span> {
        self.spec.autofocus.as_ref()?.place
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
        let in_air = weight_in_air(spec, diagonal);
        let tilted = spec.tilted_film();
        let reach = match &tilted {
            None => FilmReach {
                flat: spec.film_reach(film) + FILTER_REACH * pitch * std::f64::consts::SQRT_2,
                tilted: None,
            },
            Some(tilted) => tilted_reach(spec, tilted, [width, height], FILTER_REACH * pitch)?,
        };
        let optics = |lens: &Lens, tint: Rgb, nanometers: Option<f64>| {
            let mut optics = Optics::new(spec, lens, tint, &reach)?;
            if spec.reflects() {
                let of_all = nanometers.map_or_else(bands::of_channels, |nm| [nm; 3]);
                optics.reflect(spec.coating, of_all);
            }
            // Radiance over the squared index is what stays the same along a ray.
            optics.weight_scale = in_air * lens.rear().index.powi(2);
            Ok(optics)
        };
        let of_band = |band: &Band| optics(&band.lens, band.tint, Some(1e3 * band.wavelength));
        let bands = spec.bands.iter().map(of_band);
        let transform = CameraTransform::new(render_from_camera, spec.clip);
        let main = optics(lens, Rgb::ONE, None)?;
        let one_by_one = main.goes_one_by_one(spec) || tilted.is_some();
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
            tilted,
            connections: None,
            motion: None,
            ghost_sampling: None,
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

    /// The rays for at most [`BUNDLE`] samples, side by side, written to the front of `rays`.
    pub fn rays(
        &self,
        samples: &[CameraSample],
        want_differentials: bool,
        rays: &mut [Option<CameraRay>],
    ) {
        let samples = &samples[..samples.len().min(BUNDLE)];
        let side_by_side = self.rays_in_lanes(samples, want_differentials, rays);
        if side_by_side.is_none() {
            for (ray, sample) in rays.iter_mut().zip(samples) {
                *ray = self.ray(sample, want_differentials);
            }
        }
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
        let (from, pupil) = self.aimed(optics, film, sample.lens)?;
        let time = self.spec.shutter.time(sample.time);
        let (ray, differentials) = if want_differentials {
            let ray = optics.model.trace_with_derivatives(from, pupil.point);
            let ray = ray.ok()?;
            let steps = self.steps(film, from, pupil.point);
            (ray.map(|x| x.value), self.differentials(&ray, steps, time))
        } else {
            (optics.model.trace_from_film(from, pupil.point).ok()?, None)
        };
        let copies = matches!(optics.aim, PupilTarget::RearDisk(_));
        if copies && !self.neighbors_pass(optics, film, pupil.point)
            || self.is_behind(film, pupil.point)
        {
            return None;
        }
        let transmission = optics.transmission(from, pupil.point);
        if transmission <= 0.0 {
            return None;
        }
        let solid_angle = self.projected_solid_angle(film, &pupil);
        Some(CameraRay {
            ray: self.transform.ray(&self.camera_ray(&ray), time),
            weight: (optics.weight_scale * transmission * solid_angle) as f32,
            tint: optics.tint(from, pupil.point)?,
            differentials,
        })
    }

    /// The point of the film, mm, where the lens throws what belongs at `raster`.
    fn film_point(&self, raster: Vec2) -> [f64; 2] {
        let raster = raster.as_dvec2().to_array();
        std::array::from_fn(|i| self.corner[i] + self.per_pixel[i] * raster[i])
    }

    /// The point of the exit pupil that the ray of the film point is aimed at, and the point that the ray comes from of a film that is not
    /// tilted.
    fn aimed(&self, optics: &Optics, film: [f64; 2], u: Vec2) -> Option<([f64; 2], PupilSample)> {
        let Some(tilted) = &self.tilted else {
            return Some((film, optics.aim(film, u)?));
        };
        let sample = optics.aim_from(tilted.point(film).to_array(), u)?;
        Some((tilted.on_flat(film, sample.point), sample))
    }

    /// Where the line from the film point through `pupil` meets a film that is not tilted.
    fn on_flat(&self, film: [f64; 2], pupil: [f64; 3]) -> [f64; 2] {
        let tilted = self.tilted.as_ref();
        tilted.map_or(film, |tilted| tilted.on_flat(film, pupil))
    }

    /// How far that point moves per pixel in x and in y, from `from`.
    fn steps(&self, film: [f64; 2], from: [f64; 2], pupil: [f64; 3]) -> Option<[[f64; 2]; 2]> {
        let tilted = self.tilted.as_ref()?;
        Some([0, 1].map(|axis| {
            let mut next = film;
            next[axis] += self.per_pixel[axis];
            let to = tilted.on_flat(next, pupil);
            [to[0] - from[0], to[1] - from[1]]
        }))
    }

    /// Returns `true` if the film faces away from `point`, as only a tilted one can.
    fn is_behind(&self, film: [f64; 2], point: [f64; 3]) -> bool {
        let unit = PupilSample { point, area: 1.0 };
        let tilted = self.tilted.as_ref();
        tilted.is_some_and(|tilted| tilted.projected_solid_angle(film, &unit) <= 0.0)
    }

    /// Seen from the film point across its film.
    fn projected_solid_angle(&self, film: [f64; 2], sample: &PupilSample) -> f64 {
        match &self.tilted {
            None => projected_solid_angle([film[0], film[1], self.spec.lens.film_z()], sample),
            Some(tilted) => tilted.projected_solid_angle(film, sample),
        }
    }

    /// Returns `true` if the rays of the next pixel in x and of the next in y pass through the same pupil point.
    fn neighbors_pass(&self, optics: &Optics, film: [f64; 2], pupil: [f64; 3]) -> bool {
        let passes = |film| {
            let from = self.on_flat(film, pupil);
            optics.lens.trace_from_film(from, pupil).is_ok()
        };
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

    /// The rays one pixel on, to first order: this ray and its derivatives by the film point, which makes these `steps` if the film is
    /// tilted.
    /// `None` on the very edge of total reflection, where a derivative is infinite.
    fn differentials(
        &self,
        ray: &LensRay<Dual>,
        steps: Option<[[f64; 2]; 2]>,
        time: f32,
    ) -> Option<crate::math::ray::RayDifferentials> {
        let shifted = |axis: usize| {
            self.camera_ray(&ray.map(|x| match steps {
                None => x.value + self.per_pixel[axis] * x.by[axis],
                Some(steps) => x.value + steps[axis][0] * x.by[0] + steps[axis][1] * x.by[1],
            }))
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

/// How far a tilted film of this size, mm, reaches with a `margin` around it, and what of the flat film its rays go through.
fn tilted_reach(
    spec: &RealisticSpec,
    tilted: &TiltedFilm,
    size: [f64; 2],
    margin: f64,
) -> Result<FilmReach, CameraError> {
    let lens = &spec.lens;
    let ends =
        [-1.0, 1.0].map(|side| [0, 1].map(|i| side * (0.5 * size[i] + margin) - spec.shift[i]));
    let (depth, reach) = tilted.extent(ends);
    let rear = lens.rear();
    let behind = lens.length() + rear.sag(rear.clear_radius()).max(0.0);
    if depth[0] <= behind || depth[0].is_nan() {
        return Err(CameraError::FilmInLens(behind - depth[0]));
    }
    Ok(FilmReach {
        flat: tilted.window_on_flat(ends, lens).radius(),
        tilted: Some((depth, reach)),
    })
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

/// Of light in air, before a lens' own: see [`Weighting`]; for a film of this diagonal, mm.
fn weight_in_air(spec: &RealisticSpec, diagonal: f64) -> f64 {
    let (lens, exposure) = (
        &spec.lens,
        spec.exposure.factor(&spec.shutter, spec.weighting),
    );
    match spec.weighting {
        Weighting::Physical => exposure,
        // Relative to the middle of the image at the d line, whatever the medium.
        Weighting::Simple => {
            let relative = lens.film_distance() / lens.rear().index;
            exposure * relative.powi(2) / innermost_box_area(lens, diagonal)
        }
    }
}
