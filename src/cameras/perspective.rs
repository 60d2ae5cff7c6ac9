//! `Camera "perspective"`: the pinhole camera and the thin lens.
//!
//! Parameters (docs/scene-language.md §3.1, §A.2): `fov` 90 and `halffov` in degrees, `frameaspectratio`,
//! `screenwindow` xmin xmax ymin ymax, `lensradius` 0 and `focaldistance` 1e6 (1e30 for pbrt-v2
//! files) in camera units, `shutteropen` 0, `shutterclose` 1; `hither` and `yon` in pbrt-v2 files.
//! Source: Pharr, Jakob and Humphreys, *Physically Based Rendering*, 3rd edition, §6.2.2-6.2.3.

use super::camera_transform::{CameraSpaceRay, CameraTransform};
use super::kinds::OrdinaryCamera;
use super::{CameraError, CameraRay, CameraSample, Clip, FilmGeometry, Screen, Shutter, ThinLens};
use crate::math::transform::Transform;
use crate::math::{DVec2, DVec3, Rgb};
use crate::params::ParamReader;

/// A perspective camera as the scene file describes it.
#[derive(Clone, Debug, PartialEq)]
pub struct PerspectiveSpec {
    /// Full angle in degrees under which screen coordinates −1 to 1 are seen: the image's
    /// shorter side, with the default screen window. Between 0 and 180.
    pub fov: f64,
    /// What the film shows.
    pub screen: Screen,
    /// The lens.
    pub lens: ThinLens,
    /// When light is let in.
    pub shutter: Shutter,
    /// Clip planes.
    pub clip: Clip,
}

impl Default for PerspectiveSpec {
    fn default() -> PerspectiveSpec {
        PerspectiveSpec {
            fov: 90.0,
            screen: Screen::default(),
            lens: ThinLens::default(),
            shutter: Shutter::default(),
            clip: Clip::NONE,
        }
    }
}

impl PerspectiveSpec {
    /// Reads the parameters; out-of-range values are errors and leave the default.
    pub fn from_params(params: &ParamReader) -> PerspectiveSpec {
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
        PerspectiveSpec {
            fov,
            screen: Screen::from_params(params),
            lens: ThinLens::from_params(params),
            shutter: Shutter::from_params(params),
            clip: Clip::from_params(params),
        }
    }
}

/// A perspective camera ready to make rays.
#[derive(Clone, Debug)]
pub struct Perspective {
    spec: PerspectiveSpec,
    transform: CameraTransform,
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
    ) -> Result<Perspective, CameraError> {
        let t = (0.5 * spec.fov).to_radians().tan();
        let (corner, per_pixel) = spec.screen.raster(film);
        Ok(Perspective {
            transform: CameraTransform::new(render_from_camera, spec.clip),
            spec: spec.clone(),
            corner: t * corner,
            per_pixel: t * per_pixel,
        })
    }

    /// The ray for `sample`; its weight is 1.
    pub fn ray(&self, sample: &CameraSample, want_differentials: bool) -> CameraRay {
        let raster = sample.raster.as_dvec2();
        let lens = self.spec.lens.point(sample.lens);
        let through = |raster: DVec2| self.through(raster, lens);
        let time = self.spec.shutter.time(sample.time);
        CameraRay {
            ray: self.transform.ray(&through(raster), time),
            tint: Rgb::ONE,
            weight: 1.0,
            differentials: want_differentials.then(|| {
                let (x, y) = (raster + DVec2::X, raster + DVec2::Y);
                self.transform.differentials(&through(x), &through(y), time)
            }),
        }
    }

    /// The camera-space ray from point `lens` of the lens that meets the pinhole's ray through
    /// `raster` in the plane of focus.
    fn through(&self, raster: DVec2, lens: DVec2) -> CameraSpaceRay {
        let pinhole = self.corner + self.per_pixel * raster;
        let d = (pinhole + self.spec.lens.turn(lens)).extend(1.0);
        CameraSpaceRay {
            o: lens.extend(0.0),
            d: if d.is_finite() { d } else { DVec3::Z },
        }
    }
}

impl OrdinaryCamera for Perspective {
    fn transform(&mut self) -> &mut CameraTransform {
        &mut self.transform
    }

    fn has_lens(&self) -> bool {
        self.spec.lens.radius > 0.0
    }

    fn describe(&self, film: &FilmGeometry) -> Vec<String> {
        let spec = &self.spec;
        let t = (0.5 * spec.fov).to_radians().tan();
        let angle = |a: f64, b: f64| ((b * t).atan() - (a * t).atan()).to_degrees().abs();
        let w = spec.screen.window(film);
        vec![
            format!("perspective camera, {}", spec.lens.describe()),
            format!(
                "field of view {:.2} x {:.2} degrees",
                angle(w[0], w[1]),
                angle(w[2], w[3])
            ),
        ]
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
        Perspective::new(&spec, &FILM, &Transform::IDENTITY).unwrap()
    }

    #[test]
    fn fov_spans_the_shorter_side_and_raster_runs_down() {
        let c = camera(PerspectiveSpec {
            fov: 60.0,
            ..Default::default()
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
        let c = camera(PerspectiveSpec {
            lens: ThinLens {
                radius: 0.3,
                focal_distance: 7.0,
            },
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
    fn differentials_are_the_neighboring_pixels_rays() {
        for radius in [0.0, 0.2] {
            let c = camera(PerspectiveSpec {
                lens: ThinLens {
                    radius,
                    focal_distance: 3.0,
                },
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
    fn screen_window_and_aspect_move_the_image() {
        let c = camera(PerspectiveSpec {
            screen: Screen {
                window: Some([0.0, 1.0, 0.0, 1.0]),
                ..Default::default()
            },
            ..Default::default()
        });
        let corner = c.ray(&sample(0.0, 100.0, Vec2::ZERO), false).ray;
        assert!((corner.d - Vec3::Z).length() < 1e-7);
        let c = camera(PerspectiveSpec {
            screen: Screen {
                frame_aspect_ratio: Some(0.5),
                ..Default::default()
            },
            ..Default::default()
        });
        let top = c.ray(&sample(100.0, 0.0, Vec2::ZERO), false).ray;
        assert!((top.d.y / top.d.z - 2.0).abs() < 1e-6);
    }
}
