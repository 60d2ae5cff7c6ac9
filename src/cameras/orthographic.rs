//! `Camera "orthographic"`: parallel projection, optionally with depth of field.
//!
//! Parameters (docs/scene-language.md §3.1): `frameaspectratio`, `screenwindow` xmin xmax ymin ymax in
//! scene units, `lensradius` 0 and `focaldistance` 1e6 (1e30 for pbrt-v2 files), `shutteropen` 0,
//! `shutterclose` 1; `hither` and `yon` in pbrt-v2 files.
//! Source: Pharr, Jakob and Humphreys 2016, §6.2.1 and 6.2.3.
//!
//! With a lens, a film point's rays start on a disk around its own point of the plane z = 0 and meet
//! again in the plane of focus (a telecentric lens). pbrt-v3 forgets the film point when it places
//! them on the lens, which makes a perspective image of what should be a parallel one.

use super::camera_transform::{CameraSpaceRay, CameraTransform};
use super::kinds::OrdinaryCamera;
use super::{CameraError, CameraRay, CameraSample, Clip, FilmGeometry, Screen, Shutter, ThinLens};
use crate::math::DVec2;
use crate::math::Rgb;
use crate::math::transform::Transform;
use crate::params::ParamReader;

/// An orthographic camera as the scene file describes it.
#[derive(Clone, Debug, PartialEq)]
pub struct OrthographicSpec {
    /// What the film shows, in scene units.
    pub screen: Screen,
    /// The lens around every film point's ray.
    pub lens: ThinLens,
    /// When light is let in.
    pub shutter: Shutter,
    /// Clip planes.
    pub clip: Clip,
}

impl Default for OrthographicSpec {
    fn default() -> OrthographicSpec {
        OrthographicSpec {
            screen: Screen::default(),
            lens: ThinLens::default(),
            shutter: Shutter::default(),
            clip: Clip::NONE,
        }
    }
}

impl OrthographicSpec {
    /// Reads the parameters; what means nothing is an error and leaves the default.
    pub fn from_params(params: &ParamReader) -> OrthographicSpec {
        OrthographicSpec {
            screen: Screen::from_params(params),
            lens: ThinLens::from_params(params),
            shutter: Shutter::from_params(params),
            clip: Clip::from_params(params),
        }
    }
}

/// An orthographic camera ready to make rays.
#[derive(Clone, Debug)]
pub struct Orthographic {
    spec: OrthographicSpec,
    transform: CameraTransform,
    /// Position of raster point (0, 0) in z = 0, and its change per pixel.
    corner: DVec2,
    per_pixel: DVec2,
}

impl Orthographic {
    /// Puts `spec` behind `film`. Both resolutions are positive.
    pub fn new(
        spec: &OrthographicSpec,
        film: &FilmGeometry,
        render_from_camera: &Transform,
    ) -> Result<Orthographic, CameraError> {
        let (corner, per_pixel) = spec.screen.raster(film);
        Ok(Orthographic {
            transform: CameraTransform::new(render_from_camera, spec.clip),
            spec: spec.clone(),
            corner,
            per_pixel,
        })
    }

    /// The ray for `sample`; its weight is 1.
    pub fn ray(&self, sample: &CameraSample, want_differentials: bool) -> CameraRay {
        let raster = sample.raster.as_dvec2();
        let lens = self.spec.lens.point(sample.lens);
        let through = |raster: DVec2| CameraSpaceRay {
            o: (self.corner + self.per_pixel * raster + lens).extend(0.0),
            d: self.spec.lens.turn(lens).extend(1.0),
        };
        let time = self.spec.shutter.time(sample.time);
        CameraRay {
            ray: self.transform.ray(&through(raster), time),
            weight: 1.0,
            tint: Rgb::ONE,
            differentials: want_differentials.then(|| {
                self.transform.differentials(
                    &through(raster + DVec2::X),
                    &through(raster + DVec2::Y),
                    time,
                )
            }),
        }
    }
}

impl OrdinaryCamera for Orthographic {
    fn transform(&mut self) -> &mut CameraTransform {
        &mut self.transform
    }

    fn has_lens(&self) -> bool {
        self.spec.lens.radius > 0.0
    }

    fn describe(&self, film: &FilmGeometry) -> Vec<String> {
        let spec = &self.spec;
        let [xmin, xmax, ymin, ymax] = spec.screen.window(film);
        let lens = if spec.lens.radius > 0.0 {
            format!(", {}", spec.lens.describe())
        } else {
            String::new()
        };
        vec![
            format!("orthographic camera{lens}"),
            format!(
                "field of view {} x {} scene units",
                (xmax - xmin).abs(),
                (ymax - ymin).abs()
            ),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{DVec3, UVec2, Vec2, Vec3};
    use crate::params::testing::read;

    const FILM: FilmGeometry = FilmGeometry {
        resolution: UVec2::new(200, 100),
        diagonal_mm: 35.0,
    };

    fn sample(x: f32, y: f32, lens: Vec2) -> CameraSample {
        CameraSample {
            raster: Vec2::new(x, y),
            time: 0.5,
            lens,
            wavelength: 0.5,
        }
    }

    fn camera(text: &str) -> Orthographic {
        let outcome = read("orthographic", text, OrthographicSpec::from_params);
        assert!(outcome.messages.is_empty(), "{:?}", outcome.messages);
        Orthographic::new(&outcome.value, &FILM, &Transform::IDENTITY).unwrap()
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
            let c = camera(text);
            let corner = c.ray(&sample(0.0, 0.0, Vec2::ZERO), false).ray;
            assert_eq!((corner.o, corner.d), (top_left.extend(0.0), Vec3::Z));
            let other = c.ray(&sample(200.0, 0.0, Vec2::ONE), false).ray;
            assert_eq!((other.o.x, other.d), (right, Vec3::Z));
        }
    }

    #[test]
    fn rays_of_one_film_point_meet_in_focus_and_spread_by_the_lens() {
        let c = camera(r#""float lensradius" .25 "float focaldistance" 6"#);
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
    fn differentials_are_the_neighboring_pixels_rays() {
        for text in ["", r#""float lensradius" .25 "float focaldistance" 6"#] {
            let c = camera(text);
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
    fn a_scaled_camera_sees_more() {
        let spec = OrthographicSpec::default();
        let c = Orthographic::new(&spec, &FILM, &Transform::scale(DVec3::splat(10.0))).unwrap();
        let corner = c.ray(&sample(0.0, 0.0, Vec2::ZERO), false).ray;
        assert_eq!((corner.o, corner.d), (Vec3::new(-20.0, 10.0, 0.0), Vec3::Z));
    }
}
