//! Finding the pupils: which of a lens's apertures limits the light of a point.
//!
//! As the course's lecture has it (and Born and Wolf, *Principles of Optics*, 7th edition, §4.8.2): image every
//! aperture by the thick lens that lies behind it, into the space of the film; the image that
//! subtends the smallest solid angle at a point of the axis is the exit pupil, and its aperture the stop for
//! that point. Rims of curved surfaces lie off their vertex planes by their sag, and are imaged from
//! there.
//!
//! That is Gaussian optics, good near the axis; [`super::pupil`] finds with real rays what passes off the axis.

use super::paraxial::RayMatrix;
use super::surface::Surface;

/// The image of one aperture, seen from the film.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StopImage {
    /// The surface whose aperture it is, from 0 at the scene.
    pub surface: usize,
    /// Where the image lies on the axis, mm; infinite for an aperture in a focal plane.
    pub z: f64,
    /// Diameter of the image, mm; infinite where z is.
    pub diameter: f64,
    /// Of the edge of the image seen from the axis point asked for: the tangent of the angle with the
    /// axis. For a point at infinity, the radius of the image in mm.
    pub opening: f64,
}

/// Where on the axis the images are looked at from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum AxisPoint {
    /// At this z, mm.
    At(f64),
    /// Infinitely far.
    Infinity,
}

/// All apertures as the film sees them, from the axis point `from` behind the lens.
pub fn images_toward_film(surfaces: &[Surface], from: AxisPoint) -> Vec<StopImage> {
    let images = 0..surfaces.len();
    images.map(|i| image(surfaces, i, from)).collect()
}

/// The exit pupil of an axis point behind the lens: the aperture image of smallest solid angle.
/// `None` for a lens without surfaces.
pub fn exit_pupil(surfaces: &[Surface], from: AxisPoint) -> Option<StopImage> {
    let images = images_toward_film(surfaces, from).into_iter();
    images.min_by(|a, b| a.opening.total_cmp(&b.opening))
}

/// The aperture of surface `i` as it is seen from the axis point `from` behind the lens.
fn image(surfaces: &[Surface], i: usize, from: AxisPoint) -> StopImage {
    let (s, last) = (&surfaces[i], surfaces.len() - 1);
    let length: f64 = surfaces[..last].iter().map(|s| s.thickness).sum();
    let (radius, n) = (s.clear_radius(), surfaces[last].index);
    // From the rim's plane, in the medium behind the surface, to the last vertex plane.
    let mut m = RayMatrix::IDENTITY;
    let mut ahead = -s.sag(radius);
    for pair in surfaces[i..].windows(2) {
        m = m.transfer(ahead + pair[0].thickness, pair[0].index);
        m = m.refract(pair[1].curvature(), pair[0].index, pair[1].index);
        ahead = 0.0;
    }
    if i == last {
        m = m.transfer(ahead, s.index);
    }
    // A ray from the rim's middle with reduced angle 1 is here at height b with reduced angle d, so
    // it seems to come from n·b/d before the plane; heights are magnified by 1/d.
    let distance = -n * m.b / m.d();
    let opening = match from {
        AxisPoint::Infinity => radius / m.d().abs(),
        // Backward from the axis point: a ray of slope 1 there has reduced angle n and comes to the
        // rim's plane at height b·n − d·(distance from the plane) (the inverse matrix, det = 1).
        // Finite for an image at infinity too.
        AxisPoint::At(z) => radius / (m.b * n + m.d() * (z - length)).abs(),
    };
    StopImage {
        surface: i,
        z: length + distance,
        diameter: 2.0 * radius / m.d().abs(),
        opening,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::{Paraxial, Prescription};

    fn surfaces(text: &str) -> Vec<Surface> {
        Prescription::parse(text).unwrap().surfaces
    }

    #[test]
    fn the_image_of_the_stop_is_the_exit_pupil_of_first_order() {
        let s = surfaces("50 6 1.5 20\n-40 3 1 20\n0 4 0 8\n-60 3 1.6 20\n-35 0 1 20\n");
        let exit = Paraxial::new(&s).exit_pupil.unwrap();
        let film = &images_toward_film(&s, AxisPoint::Infinity)[2];
        assert!((film.z - exit.z).abs() < 1e-12 && (film.diameter - exit.diameter).abs() < 1e-12);
    }

    #[test]
    fn the_smallest_solid_angle_depends_on_where_one_looks_from() {
        // Two bare apertures, 10 mm at z = 0 and 8 mm at z = 50: no glass, so images are
        // the apertures themselves.
        let s = surfaces("0 50 0 10\n0 0 0 8\n");
        let pupil = |z: f64| exit_pupil(&s, AxisPoint::At(z)).unwrap();
        // From near behind, the far one looks smaller: 5/60 against 4/10.
        assert_eq!(pupil(60.0).surface, 0);
        assert!((pupil(60.0).opening - 5.0 / 60.0).abs() < 1e-15);
        // From 250 on, 4/(z − 50) is less than 5/z.
        assert_eq!(pupil(240.0).surface, 0);
        assert_eq!(pupil(260.0).surface, 1);
        assert_eq!(exit_pupil(&s, AxisPoint::Infinity).unwrap().surface, 1);
        assert_eq!(exit_pupil(&[], AxisPoint::Infinity), None);
    }

    #[test]
    fn a_stop_in_the_focal_plane_has_its_image_at_infinity_and_a_finite_opening() {
        // Thin plano-convex lens of f = 100, the stop 100 in front of it: from the film the stop's edge is
        // seen at 2.5/100 wherever one looks from.
        let s = surfaces("0 100 0 5\n50 0 1.5 40\ninf 0 1 40\n");
        for z in [120.0, 300.0] {
            let image = images_toward_film(&s, AxisPoint::At(z))[0];
            assert!((image.opening - 0.025).abs() < 1e-15, "{image:?}");
            assert!(image.z.abs() > 1e12);
        }
    }
}
