//! `Camera "perspective"`: the pinhole camera and the thin lens.
//!
//! Parameters (scene-language 3.1, A.2): `fov` 90 and `halffov` in degrees, `frameaspectratio`,
//! `screenwindow` xmin xmax ymin ymax, `lensradius` 0 and `focaldistance` 1e6 (1e30 for pbrt-v2
//! files) in camera units, `shutteropen` 0, `shutterclose` 1; `hither` and `yon` in pbrt-v2 files.
//! Source: Pharr, Jakob and Humphreys, *Physically Based Rendering*, 3rd edition, §6.2.2-6.2.3.

use super::mount::{CameraSpaceRay, Mount};
use super::{CameraRay, CameraSample, Clip, FilmGeometry, Shutter};
use crate::math::sampling::concentric_disk;
use crate::math::transform::Transform;
use crate::math::{DVec2, DVec3, Rgb};
use crate::params::{Dialect, ParamReader};

/// A perspective camera as the scene file describes it.
#[derive(Clone, Debug, PartialEq)]
pub struct PerspectiveSpec {
    /// Full angle in degrees under which screen coordinates −1 to 1 are seen: the picture's
    /// shorter side, with the default screen window. Between 0 and 180.
    pub fov: f64,
    /// Width over height of the default screen window; the film's where absent.
    pub frame_aspect_ratio: Option<f64>,
    /// xmin, xmax, ymin, ymax of what the film shows.
    pub screen_window: Option<[f64; 4]>,
    /// Radius of the thin lens; 0 is a pinhole.
    pub lens_radius: f64,
    /// Distance of the plane in focus.
    pub focal_distance: f64,
    /// When light is let in.
    pub shutter: Shutter,
    /// Clip planes.
    pub clip: Clip,
}

impl Default for PerspectiveSpec {
    fn default() -> PerspectiveSpec {
        PerspectiveSpec {
            fov: 90.0,
            frame_aspect_ratio: None,
            screen_window: None,
            lens_radius: 0.0,
            focal_distance: 1e6,
            shutter: Shutter::default(),
            clip: Clip::NONE,
        }
    }
}

impl PerspectiveSpec {
    /// Reads the parameters; out-of-range values are errors and leave the default.
    pub fn from_params(params: &ParamReader) -> Option<PerspectiveSpec> {
        let v2 = params.dialect() == Dialect::V2;
        let default = PerspectiveSpec::default();
        let mut fov = params.float("fov", default.fov);
        let mut fov_name = "fov";
        if let Some(half) = params.find_float("halffov").filter(|h| *h > 0.0) {
            fov = 2.0 * half;
            fov_name = "halffov";
        }
        if !(fov > 0.0 && fov < 180.0) {
            params.error(
                fov_name,
                format!("a field of view of {fov} degrees; expected between 0 and 180"),
            );
            fov = default.fov;
        }
        let frame_aspect_ratio = params
            .find_float("frameaspectratio")
            .filter(|a| positive(params, "frameaspectratio", *a));
        let focal_distance = params.float(
            "focaldistance",
            if v2 { 1e30 } else { default.focal_distance },
        );
        let mut lens_radius = params.float("lensradius", default.lens_radius);
        if lens_radius != 0.0
            && !(positive(params, "lensradius", lens_radius)
                && positive(params, "focaldistance", focal_distance))
        {
            lens_radius = 0.0;
        }
        Some(PerspectiveSpec {
            fov,
            frame_aspect_ratio,
            screen_window: screen_window(params),
            lens_radius,
            focal_distance,
            shutter: Shutter::from_params(params),
            // pbrt-v3 knows no clip planes: there the names stay unread and are reported unused.
            clip: if v2 {
                Clip::from_params(params)
            } else {
                Clip::NONE
            },
        })
    }

    /// The screen window: as given, or the shorter side from −1 to 1.
    pub(super) fn window(&self, film: &FilmGeometry) -> [f64; 4] {
        let aspect = self
            .frame_aspect_ratio
            .unwrap_or(f64::from(film.resolution.x) / f64::from(film.resolution.y));
        self.screen_window.unwrap_or(if aspect > 1.0 {
            [-aspect, aspect, -1.0, 1.0]
        } else {
            [-1.0, 1.0, -1.0 / aspect, 1.0 / aspect]
        })
    }

    /// See [`super::Camera::describe`].
    pub fn describe(&self, film: &FilmGeometry) -> Vec<String> {
        let t = (0.5 * self.fov).to_radians().tan();
        let angle = |a: f64, b: f64| ((b * t).atan() - (a * t).atan()).to_degrees().abs();
        let w = self.window(film);
        let lens = if self.lens_radius > 0.0 {
            format!(
                "thin lens of radius {}, focused at {}",
                self.lens_radius, self.focal_distance
            )
        } else {
            "pinhole".to_string()
        };
        vec![
            format!("perspective camera, {lens}"),
            format!(
                "field of view {:.2} x {:.2} degrees",
                angle(w[0], w[1]),
                angle(w[2], w[3])
            ),
        ]
    }
}

/// Reports an error under `name` unless `value` is positive and finite.
fn positive(params: &ParamReader, name: &str, value: f64) -> bool {
    let good = value > 0.0 && value.is_finite();
    if !good {
        params.error(
            name,
            format!("{name} is {value}; expected a positive number"),
        );
    }
    good
}

/// Reads `screenwindow`: four numbers that span an area.
fn screen_window(params: &ParamReader) -> Option<[f64; 4]> {
    let given = params.floats("screenwindow")?;
    let window = <[f64; 4]>::try_from(given).ok();
    match window {
        Some(w) if w[0] != w[1] && w[2] != w[3] && w.iter().all(|x| x.is_finite()) => Some(w),
        _ => {
            params.error(
                "screenwindow",
                "expected four numbers xmin xmax ymin ymax that span an area",
            );
            None
        }
    }
}

/// A perspective camera ready to make rays.
#[derive(Clone, Debug)]
pub struct Perspective {
    pub(super) spec: PerspectiveSpec,
    mount: Mount,
    /// Direction (z = 1) through raster point (0, 0), and its change per pixel.
    corner: DVec2,
    per_pixel: DVec2,
}

impl Perspective {
    /// Puts `spec` behind `film`. Both resolutions are positive.
    pub fn new(
        spec: &PerspectiveSpec,
        film: &FilmGeometry,
        render_from_camera: &Transform,
    ) -> Perspective {
        let t = (0.5 * spec.fov).to_radians().tan();
        let [xmin, xmax, ymin, ymax] = spec.window(film);
        let resolution = film.resolution.as_dvec2();
        Perspective {
            mount: Mount::new(render_from_camera, spec.clip),
            spec: spec.clone(),
            corner: t * DVec2::new(xmin, ymax),
            per_pixel: t * DVec2::new(xmax - xmin, ymin - ymax) / resolution,
        }
    }

    /// The ray for `sample`; its weight is 1.
    pub fn ray(&self, sample: &CameraSample, want_differentials: bool) -> CameraRay {
        let raster = sample.raster.as_dvec2();
        let lens = if self.spec.lens_radius > 0.0 {
            self.spec.lens_radius * concentric_disk(sample.lens).as_dvec2()
        } else {
            DVec2::ZERO
        };
        let through = |raster: DVec2| self.through(raster, lens);
        CameraRay {
            ray: self
                .mount
                .ray(&through(raster), self.spec.shutter.time(sample.time)),
            tint: Rgb::ONE,
            weight: 1.0,
            differentials: want_differentials.then(|| {
                self.mount
                    .differentials(&through(raster + DVec2::X), &through(raster + DVec2::Y))
            }),
        }
    }

    /// The camera-space ray from point `lens` of the lens that meets the pinhole's ray through
    /// `raster` in the plane of focus.
    fn through(&self, raster: DVec2, lens: DVec2) -> CameraSpaceRay {
        let pinhole = self.corner + self.per_pixel * raster;
        // From the lens to the focus (pinhole, 1)·f, divided by f so that f = 1e30 is no trouble.
        let d = (pinhole - lens / self.spec.focal_distance).extend(1.0);
        CameraSpaceRay {
            o: lens.extend(0.0),
            d: if d.is_finite() { d } else { DVec3::Z },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{UVec2, Vec2, Vec3};

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

    fn camera(spec: PerspectiveSpec) -> Perspective {
        Perspective::new(&spec, &FILM, &Transform::IDENTITY)
    }

    #[test]
    fn fov_spans_the_shorter_side_and_raster_runs_down() {
        let c = camera(PerspectiveSpec {
            fov: 60.0,
            ..Default::default()
        });
        let centre = c.ray(&sample(100.0, 50.0, Vec2::ZERO), false).ray;
        assert!((centre.d - Vec3::Z).length() < 1e-7);
        let top = c.ray(&sample(100.0, 0.0, Vec2::ZERO), false).ray;
        // Half of 60 degrees, upward.
        assert!((top.d - Vec3::new(0.0, 0.5, 0.75f32.sqrt())).length() < 1e-6);
        let right = c.ray(&sample(200.0, 50.0, Vec2::ZERO), false).ray;
        let t = 30f64.to_radians().tan();
        assert!((f64::from(right.d.x / right.d.z) - 2.0 * t).abs() < 1e-6);
    }

    #[test]
    fn thin_lens_rays_of_one_film_point_meet_in_the_plane_of_focus() {
        let c = camera(PerspectiveSpec {
            lens_radius: 0.3,
            focal_distance: 7.0,
            ..Default::default()
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
    fn differentials_are_the_neighbouring_pixels_rays() {
        for radius in [0.0, 0.2] {
            let c = camera(PerspectiveSpec {
                lens_radius: radius,
                focal_distance: 3.0,
                ..Default::default()
            });
            let lens = Vec2::new(0.3, 0.8);
            let d = c
                .ray(&sample(20.0, 30.0, lens), true)
                .differentials
                .unwrap();
            let x = c.ray(&sample(21.0, 30.0, lens), false).ray;
            let y = c.ray(&sample(20.0, 31.0, lens), false).ray;
            assert_eq!((d.rx_o, d.rx_d, d.ry_o, d.ry_d), (x.o, x.d, y.o, y.d));
        }
    }

    #[test]
    fn screen_window_and_aspect_move_the_picture() {
        let c = camera(PerspectiveSpec {
            screen_window: Some([0.0, 1.0, 0.0, 1.0]),
            ..Default::default()
        });
        let corner = c.ray(&sample(0.0, 100.0, Vec2::ZERO), false).ray;
        assert!((corner.d - Vec3::Z).length() < 1e-7);
        let c = camera(PerspectiveSpec {
            frame_aspect_ratio: Some(0.5),
            ..Default::default()
        });
        let top = c.ray(&sample(100.0, 0.0, Vec2::ZERO), false).ray;
        assert!((top.d.y / top.d.z - 2.0).abs() < 1e-6);
    }
}
