//! `Camera "perspective"`, the pinhole camera and the thin lens, and `Camera "orthographic"`, parallel projection: the image
//! of a window of a plane, optionally with depth of field.
//!
//! Parameters (docs/scene-language.md §3.1, §A.2): `frameaspectratio`, `screenwindow` xmin xmax ymin ymax (of the orthographic
//! camera in scene units), `lensradius` 0 and `focaldistance` 1e6 (1e30 for pbrt-v2 files) in camera units, `shutteropen` 0,
//! `shutterclose` 1; `hither` and `yon` in pbrt-v2 files; `fov` 90 and `halffov` in degrees of the perspective camera.
//! Source: Pharr, Jakob and Humphreys, *Physically Based Rendering*, 3rd edition, §6.2.
//!
//! With a lens, a film point's rays of the orthographic camera start on a disk around its own point of the plane z = 0 and
//! meet again in the plane of focus (a telecentric lens). pbrt-v3 forgets the film point when it places
//! them on the lens, which makes a perspective image of what should be a parallel one.

use super::blur::{Blur, Line};
use super::camera_transform::{CameraSpaceRay, CameraTransform, Placement};
use super::connection::Hit;
use super::pinhole::Pinhole;
use super::{CameraRay, CameraSample, Clip, FilmGeometry, Screen, Shutter, ThinLens};
use crate::math::motion::Motion;
use crate::math::transform::Transform;
use crate::math::{DVec2, DVec3, Vec2};
use crate::params::ParamReader;
use std::borrow::Cow;

/// A perspective or orthographic camera as the scene file describes it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ProjectiveSpec {
    /// Of a perspective camera: full angle in degrees under which screen coordinates −1 to 1 are seen, the image's
    /// shorter side with the default screen window. Between 0 and 180. `None`: parallel projection.
    pub fov: Option<f64>,
    /// What the film shows.
    pub screen: Screen,
    /// The lens; of an orthographic camera that around every film point's ray.
    pub lens: ThinLens,
    /// When light is let in.
    pub shutter: Shutter,
    /// Clip planes.
    pub clip: Clip,
}

impl ProjectiveSpec {
    /// Reads the parameters; out-of-range values are errors and leave the default.
    pub fn from_params(params: &ParamReader) -> ProjectiveSpec {
        ProjectiveSpec {
            fov: (params.kind() == "perspective").then(|| fov(params)),
            screen: Screen::from_params(params),
            lens: ThinLens::from_params(params),
            shutter: Shutter::from_params(params),
            clip: Clip::from_params(params),
        }
    }

    /// Size of a unit of the screen: at distance 1, or of a parallel projection anywhere.
    fn screen_unit(&self) -> f64 {
        self.fov.map_or(1.0, |fov| (0.5 * fov).to_radians().tan())
    }

    /// What the film shows at distance 1: xmin, xmax, ymin, ymax.
    pub(super) fn window(&self, film: &FilmGeometry) -> [f64; 4] {
        self.screen.window(film).map(|x| x * self.screen_unit())
    }
}

fn fov(params: &ParamReader) -> f64 {
    const DEFAULT: f64 = 90.0;
    let whole = params.float("fov", DEFAULT);
    let half = params.find_float("halffov").filter(|half| *half > 0.0);
    let (name, fov) = half.map_or(("fov", whole), |half| ("halffov", 2.0 * half));
    if fov > 0.0 && fov < 180.0 {
        return fov;
    }
    params.error(
        name,
        format!("a field of view of {fov} degrees; expected between 0 and 180"),
    );
    DEFAULT
}

/// A perspective or orthographic camera ready to make rays.
#[derive(Clone, Debug)]
pub struct Projective {
    spec: ProjectiveSpec,
    transform: CameraTransform,
    /// Raster point (0, 0) at distance 1 or of a parallel projection anywhere, and its change per pixel.
    corner: DVec2,
    per_pixel: DVec2,
}

impl Projective {
    /// How it stands in the scene.
    pub(super) fn transform(&self) -> &CameraTransform {
        &self.transform
    }

    /// See [`Blur`].
    pub(super) fn blur(&self) -> Blur {
        let (radius, pixel) = (self.spec.lens.radius, self.per_pixel.x);
        Blur {
            radius: Line(radius, -radius / self.spec.lens.focal_distance),
            pixel: match self.spec.fov {
                Some(_) => Line(0.0, pixel),
                None => Line(pixel, 0.0),
            },
        }
    }

    /// When it lets light in.
    pub(super) fn shutter(&self) -> &Shutter {
        &self.spec.shutter
    }

    /// Puts `spec` behind `film`.
    pub fn new(
        spec: &ProjectiveSpec,
        film: &FilmGeometry,
        render_from_camera: &Transform,
    ) -> Projective {
        let (corner, per_pixel) = spec.screen.raster(film);
        Projective {
            transform: CameraTransform::new(render_from_camera, spec.clip),
            spec: spec.clone(),
            corner: spec.screen_unit() * corner,
            per_pixel: spec.screen_unit() * per_pixel,
        }
    }

    /// The ray for `sample`; its weight is 1.
    pub fn ray(&self, sample: &CameraSample, want_differentials: bool) -> CameraRay {
        let raster = sample.raster.as_dvec2();
        let lens = self.spec.lens.point(sample.lens);
        let through = |raster: DVec2| self.through(raster, lens);
        let neighbors = || [DVec2::X, DVec2::Y].map(|shift| through(raster + shift));
        let time = self.spec.shutter.time(sample.time);
        let neighbors = want_differentials.then(neighbors);
        self.transform.unweighted(&through(raster), neighbors, time)
    }

    /// The rays for at most [`BUNDLE`](super::BUNDLE) samples, written to the front of `rays`.
    pub(super) fn rays(
        &self,
        samples: &[CameraSample],
        want_differentials: bool,
        rays: &mut [Option<CameraRay>],
    ) {
        if let Some(pinhole) = self.pinhole() {
            pinhole.rays(samples, want_differentials, rays);
            return;
        }
        for (ray, sample) in rays.iter_mut().zip(samples) {
            *ray = Some(self.ray(sample, want_differentials));
        }
    }

    /// As a still pinhole; `None` with a lens, motion or clip planes, and for parallel projection.
    pub(super) fn pinhole(&self) -> Option<Pinhole<'_>> {
        if self.has_lens() || self.spec.fov.is_none() {
            return None;
        }
        let raster = (self.corner, self.per_pixel);
        Pinhole::new(&self.transform, raster, &self.spec.shutter)
    }

    /// The camera-space ray from point `lens` of the lens that meets the ray through its middle and
    /// `raster` in the plane of focus.
    fn through(&self, raster: DVec2, lens: DVec2) -> CameraSpaceRay {
        let shown = self.corner + self.per_pixel * raster;
        let turn = self.spec.lens.turn(lens);
        let (o, d) = match self.spec.fov {
            Some(_) => (lens, shown + turn),
            None => (shown + lens, turn),
        };
        let d = d.extend(1.0);
        CameraSpaceRay {
            o: o.extend(0.0),
            d: if d.is_finite() { d } else { DVec3::Z },
        }
    }

    /// Where the camera stands at `time`; `None` if no connection can be made.
    pub(super) fn placement(&self, time: f32) -> Option<Cow<'_, Placement>> {
        self.transform
            .is_affine()
            .then(|| self.transform.placement(time))
    }

    /// How the camera-space point `x` is seen through the point of the lens for `u`; `None` where it is not.
    #[inline]
    pub(super) fn hit(&self, x: DVec3, u: Vec2) -> Option<Hit> {
        let lens = self.spec.lens.point(u);
        let turn = self.spec.lens.turn(lens);
        // The camera's rays run forward from z = 0.
        if !(x.z > 0.0 && turn.is_finite()) {
            return None;
        }
        // The inverse of `through`, and the film's area that an area across the ray is seen on.
        let area = (self.per_pixel.x * self.per_pixel.y).abs();
        let (origin, shown, density) = match self.spec.fov {
            Some(_) => {
                let slope = (x.truncate() - lens) / x.z;
                // 1/(cos³θ |x − y|²), where z = |x − y| cosθ.
                let distance = x.distance(lens.extend(0.0));
                let density = distance / (area * x.z.powi(3));
                (lens, slope - turn, density)
            }
            None => {
                let origin = x.truncate() - turn * x.z;
                // 1/cosθ.
                let density = turn.extend(1.0).length() / area;
                (origin, origin - lens, density)
            }
        };
        Some(Hit {
            origin: origin.extend(0.0),
            raster: (shown - self.corner) / self.per_pixel,
            density,
        })
    }

    pub(super) fn set_motion(&mut self, motion: Motion) {
        self.transform.set_motion(motion);
    }

    /// Returns `true` if there is a lens, not only a pinhole.
    pub fn has_lens(&self) -> bool {
        self.spec.lens.radius > 0.0
    }

    /// See [`super::Camera::describe`].
    pub fn describe(&self, film: &FilmGeometry) -> Vec<String> {
        let lens = self.spec.lens.describe();
        let [xmin, xmax, ymin, ymax] = self.spec.window(film);
        if self.spec.fov.is_some() {
            let angle = |a: f64, b: f64| (b.atan() - a.atan()).to_degrees().abs();
            let (x, y) = (angle(xmin, xmax), angle(ymin, ymax));
            return vec![
                format!("perspective camera, {lens}"),
                format!("field of view {x:.2} x {y:.2} degrees"),
            ];
        }
        let (x, y) = ((xmax - xmin).abs(), (ymax - ymin).abs());
        let lens = Some(format!(", {lens}")).filter(|_| self.has_lens());
        vec![
            format!("orthographic camera{}", lens.unwrap_or_default()),
            format!("field of view {x} x {y} scene units"),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{UVec2, Vec3};
    use crate::params::testing::read;

    const FILM: FilmGeometry = FilmGeometry {
        resolution: UVec2::new(200, 100),
        diagonal_mm: 35.0,
    };

    fn sample(x: f32, y: f32, lens: Vec2) -> CameraSample {
        CameraSample {
            raster: Vec2::new(x, y),
            time: 0.5,
            wavelength: 0.5,
            lens,
        }
    }

    fn camera(spec: ProjectiveSpec) -> Projective {
        Projective::new(&spec, &FILM, &Transform::IDENTITY)
    }

    fn perspective() -> ProjectiveSpec {
        ProjectiveSpec {
            fov: Some(90.0),
            ..Default::default()
        }
    }

    fn orthographic(text: &str) -> Projective {
        let outcome = read("orthographic", text, ProjectiveSpec::from_params);
        assert!(outcome.messages.is_empty(), "{:?}", outcome.messages);
        camera(outcome.value)
    }

    fn assert_differentials_are_the_neighbors(c: &Projective) {
        let lens = Vec2::new(0.3, 0.8);
        let d = { c.ray(&sample(20.0, 30.0, lens), true) }.differentials;
        let d = d.unwrap();
        let x = c.ray(&sample(21.0, 30.0, lens), false).ray;
        let y = c.ray(&sample(20.0, 31.0, lens), false).ray;
        assert_eq!((d.rx_o, d.rx_d, d.ry_o, d.ry_d), (x.o, x.d, y.o, y.d));
    }

    #[test]
    fn fov_spans_the_shorter_side_and_raster_runs_down() {
        let c = camera(ProjectiveSpec {
            fov: Some(60.0),
            ..perspective()
        });
        let center = c.ray(&sample(100.0, 50.0, Vec2::ZERO), false).ray;
        assert!((center.d - Vec3::Z).length() < 1e-7);
        let top = c.ray(&sample(100.0, 0.0, Vec2::ZERO), false).ray;
        // Half of 60 degrees, upward.
        assert!((top.d - Vec3::new(0.0, 0.5, 0.75f32.sqrt())).length() < 1e-6);
        let right = c.ray(&sample(200.0, 50.0, Vec2::ZERO), false).ray;
        let t = 30f64.to_radians().tan();
        assert!((f64::from(right.d.x / right.d.z) - 2.0 * t).abs() < 1e-6);
    }

    #[test]
    fn thin_lens_rays_of_one_film_point_meet_in_the_plane_of_focus() {
        let c = camera(ProjectiveSpec {
            lens: ThinLens {
                radius: 0.3,
                focal_distance: 7.0,
            },
            ..perspective()
        });
        let at_focus = |lens| {
            let r = c.ray(&sample(31.0, 77.0, lens), false).ray;
            assert!(r.o.z == 0.0 && r.o.length() <= 0.3 + 1e-6);
            r.at(7.0 / r.d.z)
        };
        let first = at_focus(Vec2::new(0.1, 0.9));
        for lens in [
            Vec2::new(0.9, 0.2),
            Vec2::new(0.5, 0.5),
            Vec2::new(0.0, 0.0),
        ] {
            // Single-precision rays followed over 10 units.
            assert!((at_focus(lens) - first).length() < 1e-5);
        }
    }

    #[test]
    fn differentials_are_the_neighboring_pixels_rays() {
        for radius in [0.0, 0.2] {
            let c = camera(ProjectiveSpec {
                lens: ThinLens {
                    radius,
                    focal_distance: 3.0,
                },
                ..perspective()
            });
            assert_differentials_are_the_neighbors(&c);
        }
    }

    #[test]
    fn screen_window_and_aspect_move_the_image() {
        let c = camera(ProjectiveSpec {
            screen: Screen {
                window: Some([0.0, 1.0, 0.0, 1.0]),
                ..Default::default()
            },
            ..perspective()
        });
        let corner = c.ray(&sample(0.0, 100.0, Vec2::ZERO), false).ray;
        assert!((corner.d - Vec3::Z).length() < 1e-7);
        let c = camera(ProjectiveSpec {
            screen: Screen {
                frame_aspect_ratio: Some(0.5),
                ..Default::default()
            },
            ..perspective()
        });
        let top = c.ray(&sample(100.0, 0.0, Vec2::ZERO), false).ray;
        assert!((top.d.y / top.d.z - 2.0).abs() < 1e-6);
    }

    #[test]
    fn rays_are_parallel_and_start_on_the_screen() {
        for (text, top_left, right) in [
            ("", Vec2::new(-2.0, 1.0), 2.0),
            (r#""float frameaspectratio" .5"#, Vec2::new(-1.0, 2.0), 1.0),
            (
                r#""float screenwindow" [-3 5 -7 11]"#,
                Vec2::new(-3.0, 11.0),
                5.0,
            ),
        ] {
            let c = orthographic(text);
            let corner = c.ray(&sample(0.0, 0.0, Vec2::ZERO), false).ray;
            assert_eq!((corner.o, corner.d), (top_left.extend(0.0), Vec3::Z));
            let other = c.ray(&sample(200.0, 0.0, Vec2::ONE), false).ray;
            assert_eq!((other.o.x, other.d), (right, Vec3::Z));
        }
    }

    #[test]
    fn rays_of_one_film_point_meet_in_focus_and_spread_by_the_lens() {
        let c = orthographic(r#""float lensradius" .25 "float focaldistance" 6"#);
        let middle = Vec3::new(-2.0 + 31.0 * 0.02, 1.0 - 77.0 * 0.02, 0.0);
        let mut farthest: f32 = 0.0;
        for i in 0..64 {
            let u = Vec2::new((i % 8) as f32 + 0.5, (i / 8) as f32 + 0.5) / 8.0;
            let r = c.ray(&sample(31.0, 77.0, u), false).ray;
            // Single-precision rays followed over six units.
            assert!((r.at(6.0 / r.d.z) - (middle + 6.0 * Vec3::Z)).length() < 1e-5);
            assert!(r.o.distance(middle) <= 0.25 + 1e-6);
            // Twice as far the blur is as large as the lens: not so where the film point is lost.
            assert!(r.at(12.0 / r.d.z).distance(middle + 12.0 * Vec3::Z) <= 0.25 + 1e-5);
            farthest = farthest.max(r.o.distance(middle));
        }
        assert!(farthest > 0.2, "{farthest}");
    }

    #[test]
    fn differentials_of_parallel_rays_are_the_neighboring_pixels_rays() {
        for text in ["", r#""float lensradius" .25 "float focaldistance" 6"#] {
            let c = orthographic(text);
            assert_differentials_are_the_neighbors(&c);
        }
    }

    #[test]
    fn a_scaled_camera_sees_more() {
        let spec = ProjectiveSpec::default();
        let c = Projective::new(&spec, &FILM, &Transform::scale(DVec3::splat(10.0)));
        let corner = c.ray(&sample(0.0, 0.0, Vec2::ZERO), false).ray;
        assert_eq!((corner.o, corner.d), (Vec3::new(-20.0, 10.0, 0.0), Vec3::Z));
    }
}
