//! Where the image shows a point: OpenEXR's `worldToNDC`, (0, 0) the upper left and (1, 1) the
//! lower right corner of the full image.

use super::realistic::Form;
use super::{CameraSpec, FilmGeometry, ProjectiveSpec, RealisticSpec};
use crate::math::DMat4;
use glam::DVec4;

impl CameraSpec {
    /// Camera space to OpenEXR's normalized device coordinates. For a traced lens this is the
    /// paraxial image: a pinhole at the entrance pupil, without distortion. `None` for
    /// `environment`, whose image is no projection, and for a lens without pupils.
    pub fn ndc_from_camera(&self, film: &FilmGeometry) -> Option<DMat4> {
        match self {
            CameraSpec::Projective(spec) => Some(projective(spec, film)),
            CameraSpec::Realistic(spec) => realistic(spec, film),
            CameraSpec::Environment(_) => None,
        }
    }

    /// Width of a pixel over its height as the camera sees them, to four digits; `None` for all but projections without a traced lens, whose
    /// screen window may have other proportions than the image.
    pub fn pixel_aspect(&self, film: &FilmGeometry) -> Option<f32> {
        let CameraSpec::Projective(spec) = self else {
            return None;
        };
        let [xmin, xmax, ymin, ymax] = spec.window(film);
        let size = film.resolution.as_dvec2();
        let aspect = (xmax - xmin).abs() * size.y / ((ymax - ymin).abs() * size.x);
        Some(((aspect * 1e4).round() * 1e-4) as f32).filter(|aspect| *aspect != 1.0)
    }

    /// Name of the lens file without folders; `None` without a traced lens.
    pub fn lens_name(&self) -> Option<String> {
        match self {
            CameraSpec::Realistic(spec) => Some(spec.lens_name.clone()),
            _ => None,
        }
    }
}

/// x/z in `left`…`right` to 0…1, y/z in `top`…`bottom` to 0…1, for points seen from `pinhole_z`.
fn pinhole(left: f64, right: f64, top: f64, bottom: f64, pinhole_z: f64) -> DMat4 {
    let (sx, sy) = (1.0 / (right - left), 1.0 / (bottom - top));
    let projection = DMat4::from_cols(
        DVec4::new(sx, 0.0, 0.0, 0.0),
        DVec4::new(0.0, sy, 0.0, 0.0),
        DVec4::new(-left * sx, -top * sy, 1.0, 1.0),
        DVec4::ZERO,
    );
    projection * DMat4::from_translation(glam::DVec3::new(0.0, 0.0, -pinhole_z))
}

fn projective(spec: &ProjectiveSpec, film: &FilmGeometry) -> DMat4 {
    let [xmin, xmax, ymin, ymax] = spec.window(film);
    if spec.fov.is_some() {
        return pinhole(xmin, xmax, ymax, ymin, 0.0);
    }
    let (sx, sy) = (1.0 / (xmax - xmin), 1.0 / (ymin - ymax));
    let scale = DMat4::from_scale(glam::DVec3::new(sx, sy, 1.0));
    scale * DMat4::from_translation(glam::DVec3::new(-xmin, -ymax, 0.0))
}

/// A pinhole at the entrance pupil, and the film at the focal length that goes with it.
fn realistic(spec: &RealisticSpec, film: &FilmGeometry) -> Option<DMat4> {
    let lens = &spec.lens;
    let entrance = lens.paraxial().entrance_pupil?;
    let slope_per_mm = 1.0 / lens.pinhole_focal_length()?;
    let [width, height] = film.size_mm(spec.diagonal(film));
    let (x, y) = (0.5 * width * slope_per_mm, 0.5 * height * slope_per_mm);
    if !(x.is_finite() && y.is_finite() && x != 0.0 && y != 0.0) {
        return None;
    }
    // Lens coordinates run toward the film in mm from the front vertex; camera z toward the scene.
    let pinhole_z = match spec.form {
        Form::Course => -entrance.z,
        Form::Pbrt3 => (lens.film_z() - entrance.z) * 1e-3,
    };
    if let Some(film_plane) = spec.tilted_film() {
        let exit = lens.paraxial().exit_pupil?;
        let film_per_slope = lens.pinhole_focal_length()?;
        let on_film = film_plane.homography(exit.z);
        // Slopes to the flat film, where the image is upside down; the tilted film's own coordinates; parts of its size from the upper
        // left corner, which is the film's lower right.
        let flat = DMat4::from_scale(glam::DVec3::new(-film_per_slope, -film_per_slope, 1.0));
        let (sx, sy) = (1.0 / width, 1.0 / height);
        let shown = DMat4::from_cols(
            DVec4::new(-sx, 0.0, 0.0, 0.0),
            DVec4::new(0.0, sy, 0.0, 0.0),
            DVec4::Z,
            DVec4::new(0.5, 0.5, 0.0, 1.0),
        );
        let seen = DMat4::from_translation(glam::DVec3::new(0.0, 0.0, -pinhole_z));
        return Some(shown * on_film * flat * seen);
    }
    // What a shifted lens adds to the window.
    let [dx, dy] = spec.shift.map(|mm| mm * slope_per_mm);
    Some(pinhole(dx - x, dx + x, dy + y, dy - y, pinhole_z))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cameras::{Camera, CameraSample, Screen};
    use crate::math::transform::Transform;
    use crate::math::{UVec2, Vec2};

    #[test]
    fn points_on_a_rays_way_are_shown_where_it_started() {
        let film = FilmGeometry {
            resolution: UVec2::new(30, 20),
            diagonal_mm: 35.0,
        };
        let screen = Screen {
            window: Some([-1.0, 3.0, 0.5, 2.0]),
            ..Screen::default()
        };
        for fov in [Some(90.0), None] {
            let spec = CameraSpec::Projective(Box::new(ProjectiveSpec {
                fov,
                screen: screen.clone(),
                ..ProjectiveSpec::default()
            }));
            let camera = Camera::new(&spec, &film, &Transform::IDENTITY).unwrap();
            let sample = CameraSample {
                raster: Vec2::new(12.0, 5.0),
                time: 0.0,
                lens: Vec2::ZERO,
                wavelength: 0.5,
            };
            let ray = camera.ray(&sample, false).unwrap().ray;
            let shown = spec
                .ndc_from_camera(&film)
                .unwrap()
                .project_point3(ray.at(7.0).as_dvec3());
            // A ray in single precision, followed for 7 units.
            assert!((shown.x - 0.4).abs() < 1e-6 && (shown.y - 0.25).abs() < 1e-6);
        }
    }
}
