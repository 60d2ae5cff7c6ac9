//! Finding the pupils: which of a lens's apertures limits the light of a point.
//!
//! As the course's lecture has it (and Born and Wolf, *Principles of Optics*, 7th edition, §4.8.2): image every
//! aperture by the thick lens that lies behind it, into the space of the film; the image that
//! subtends the smallest solid angle at a point of the axis is the exit pupil, and its aperture the stop for
//! that point. Likewise through what lies in front, into the space of the scene, for the entrance
//! pupil. Rims of curved surfaces lie off their vertex planes by their sag, and are imaged from
//! there.
//!
//! That is Gaussian optics, good near the axis. Off the axis several apertures share in limiting
//! the light, and real rays say which: [`film_limits`] and [`scene_limits`].

use super::lens::Lens;
use super::paraxial::RayMatrix;
use super::pupil::boundary;
use super::surface::Surface;
use super::trace::{Blocked, LensRay};

/// The image of one aperture, seen from the film or from the scene.
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

/// Where on the axis the pupils are looked at from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum AxisPoint {
    /// At this z, mm.
    At(f64),
    /// Infinitely far.
    Infinity,
}

/// All apertures as the film sees them, from the axis point `from` behind the lens.
pub fn images_toward_film(surfaces: &[Surface], from: AxisPoint) -> Vec<StopImage> {
    let last = surfaces.len().saturating_sub(1);
    let length: f64 = surfaces[..last].iter().map(|s| s.thickness).sum();
    let behind = surfaces.last().map_or(1.0, |s| s.index);
    (0..surfaces.len())
        .map(|i| {
            // From the rim's plane, in the medium behind the surface, to the last vertex plane.
            let (rim, index) = (sag_of_rim(&surfaces[i]), surfaces[i].index);
            let mut m = RayMatrix::IDENTITY;
            let mut ahead = -rim;
            for k in i + 1..surfaces.len() {
                let n = surfaces[k - 1].index;
                m = m.transfer(ahead + surfaces[k - 1].thickness, n);
                m = m.refract(surfaces[k].curvature(), n, surfaces[k].index);
                ahead = 0.0;
            }
            if i == last {
                m = m.transfer(ahead, index);
            }
            image(i, &surfaces[i], &m, behind, |d| length + d, from)
        })
        .collect()
}

/// All apertures as the scene sees them, from the axis point `from` in front of the lens.
pub fn images_toward_scene(surfaces: &[Surface], from: AxisPoint) -> Vec<StopImage> {
    let index_before = |i: usize| if i == 0 { 1.0 } else { surfaces[i - 1].index };
    (0..surfaces.len())
        .map(|i| {
            // The lens turned round: from the rim's plane, in the medium in front of the surface,
            // to the first vertex plane.
            let rim = sag_of_rim(&surfaces[i]);
            let mut m = RayMatrix::IDENTITY;
            let mut ahead = rim;
            for k in (0..i).rev() {
                let n = surfaces[k].index;
                m = m.transfer(ahead + surfaces[k].thickness, n);
                m = m.refract(-surfaces[k].curvature(), n, index_before(k));
                ahead = 0.0;
            }
            if i == 0 {
                m = m.transfer(ahead, 1.0);
            }
            image(i, &surfaces[i], &m, 1.0, |d| -d, from)
        })
        .collect()
}

/// The exit pupil of an axis point behind the lens: the aperture image of smallest solid angle.
/// `None` for a lens without surfaces.
pub fn exit_pupil(surfaces: &[Surface], from: AxisPoint) -> Option<StopImage> {
    smallest(images_toward_film(surfaces, from))
}

/// The entrance pupil of an axis point in front of the lens: the aperture image of smallest solid
/// angle. `None` for a lens without surfaces.
pub fn entrance_pupil(surfaces: &[Surface], from: AxisPoint) -> Option<StopImage> {
    smallest(images_toward_scene(surfaces, from))
}

fn smallest(images: Vec<StopImage>) -> Option<StopImage> {
    images
        .into_iter()
        .min_by(|a, b| a.opening.total_cmp(&b.opening))
}

/// Of the rim, from the vertex toward the film.
fn sag_of_rim(s: &Surface) -> f64 {
    s.sag(s.clear_radius())
}

/// The image of an aperture by `m`, which ends at a vertex plane in a medium of index `n`;
/// `place` gives z of a point a distance beyond that plane.
fn image(
    surface: usize,
    s: &Surface,
    m: &RayMatrix,
    n: f64,
    place: impl Fn(f64) -> f64,
    from: AxisPoint,
) -> StopImage {
    // A ray from the rim's middle with reduced angle 1 is here at height b with reduced angle d, so
    // it seems to come from n·b/d before the plane; heights are magnified by 1/d.
    let distance = -n * m.b / m.d();
    let radius = s.clear_radius();
    let opening = match from {
        AxisPoint::Infinity => radius / m.d().abs(),
        // Backward from the axis point: a ray of slope 1 there has reduced angle n and comes to the
        // rim's plane at height b·n − d·(distance from the plane) (the inverse matrix, det = 1).
        // Finite for an image at infinity too.
        AxisPoint::At(z) => {
            let ahead = (z - place(0.0)) * (place(1.0) - place(0.0));
            radius / (m.b * n + m.d() * ahead).abs()
        }
    };
    StopImage {
        surface,
        z: place(distance),
        diameter: 2.0 * radius / m.d().abs(),
        opening,
    }
}

/// What limits the light in one direction around the pupil.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limit {
    /// Direction on the plane perpendicular to the axis, radians from the azimuth of the film or scene point.
    pub angle: f64,
    /// The last point of the plane, in that direction from the pupil's middle, that light passes through,
    /// along and across the azimuth; mm.
    pub point: [f64; 2],
    /// What ends the rays just beyond.
    pub blocked: Blocked,
}

/// The exit pupil of the film point (`radius`, 0) by real rays: its outline on the plane `plane_z` in
/// `count` directions over half a turn (the other half is the mirror image), each with the
/// aperture that limits it. Empty where no light arrives. The region is taken to be star-shaped about
/// the middle of its extent along the azimuth, which that of any convex region is.
pub fn film_limits(lens: &Lens, radius: f64, plane_z: f64, count: usize) -> Vec<Limit> {
    let trace = |p: [f64; 2]| {
        let out = lens.trace_from_film([radius, 0.0], [p[0], p[1], plane_z]);
        out.err()
    };
    let outline = boundary(lens, radius, plane_z);
    let (Some(first), Some(last)) = (outline.first(), outline.last()) else {
        return Vec::new();
    };
    let size = |p: &[f64; 2]| (p[0] - first[0]).hypot(p[1]);
    let reach = outline.iter().map(size).fold(0.0, f64::max);
    limits(trace, 0.5 * (first[0] + last[0]), 2.0 * reach, count)
}

/// The entrance pupil by real rays, for light from a distant object: a parallel beam at `angle` (radians,
/// less than a right angle) to the axis, tilted so that it comes from −x. Its outline on the plane
/// `plane_z` perpendicular to the axis, as in [`film_limits`]. Pupils narrower than a thousandth of
/// the front element are overlooked.
pub fn scene_limits(lens: &Lens, angle: f64, plane_z: f64, count: usize) -> Vec<Limit> {
    /// Rays tried along the azimuth to find those that pass.
    const SCAN: usize = 4096;
    let tangent = angle.tan();
    let front = &lens.surfaces()[0];
    let sag = front.sag(front.clear_radius()).abs();
    // A beam as wide as the front element, whose rim lies off the vertex plane, and in front of it.
    let reach = front.clear_radius() + sag * tangent.abs();
    let start = -reach - sag - plane_z.abs();
    let trace = |p: [f64; 2]| {
        let x = p[0] - (plane_z - start) * tangent;
        let ray = LensRay::new([x, p[1], start], [tangent, 0.0, 1.0]);
        lens.tracer().to_film(&ray).err()
    };
    let at = |i: usize| plane_z * tangent + reach * (2.0 * i as f64 / SCAN as f64 - 1.0);
    let passing = |i: &usize| trace([at(*i), 0.0]).is_none();
    match ((0..=SCAN).find(passing), (0..=SCAN).rev().find(passing)) {
        (Some(low), Some(high)) => {
            let center = 0.5 * (at(low) + at(high));
            limits(trace, center, 4.0 * reach, count)
        }
        _ => Vec::new(),
    }
}

/// Around `center`, where light passes, to `reach`, where none does.
fn limits(
    trace: impl Fn([f64; 2]) -> Option<Blocked>,
    center: f64,
    reach: f64,
    count: usize,
) -> Vec<Limit> {
    let limit = |i: usize| {
        let angle = std::f64::consts::PI * i as f64 / count.max(2).saturating_sub(1) as f64;
        let (sin, cos) = angle.sin_cos();
        let point = |t: f64| [center + t * cos, t * sin.max(0.0)];
        let (mut inside, mut outside) = (0.0, reach);
        let mut blocked = trace(point(outside))?;
        // To 15 digits.
        for _ in 0..52 {
            let t = 0.5 * (inside + outside);
            match trace(point(t)) {
                None => inside = t,
                Some(b) => (outside, blocked) = (t, b),
            }
        }
        Some(Limit {
            angle,
            point: point(inside),
            blocked,
        })
    };
    match trace([center, 0.0]) {
        None => (0..count).filter_map(limit).collect(),
        Some(_) => Vec::new(),
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
    fn the_images_of_the_stop_are_the_pupils_of_first_order() {
        let s = surfaces("50 6 1.5 20\n-40 3 1 20\n0 4 0 8\n-60 3 1.6 20\n-35 0 1 20\n");
        let p = Paraxial::new(&s);
        let (exit, entrance) = (p.exit_pupil.unwrap(), p.entrance_pupil.unwrap());
        let film = &images_toward_film(&s, AxisPoint::Infinity)[2];
        let scene = &images_toward_scene(&s, AxisPoint::Infinity)[2];
        assert!((film.z - exit.z).abs() < 1e-12 && (film.diameter - exit.diameter).abs() < 1e-12);
        assert!((scene.z - entrance.z).abs() < 1e-12);
        assert!((scene.diameter - entrance.diameter).abs() < 1e-12);
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
        // From the scene likewise: 4/(d + 50) against 5/d.
        assert_eq!(
            entrance_pupil(&s, AxisPoint::At(-100.0)).unwrap().surface,
            1
        );
        assert!(
            (entrance_pupil(&s, AxisPoint::At(-100.0)).unwrap().opening - 4.0 / 150.0).abs()
                < 1e-15
        );
        assert_eq!(entrance_pupil(&[], AxisPoint::Infinity), None);
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

    #[test]
    fn real_rays_tell_which_aperture_limits_which_side() {
        // Two bare apertures again, the film 100 behind the second, 60 off the axis: the first is
        // seen on the second's plane enlarged by 100/150 about the film point.
        let p = Prescription::parse("0 50 0 10\n0 0 0 8\n").unwrap();
        let lens = Lens::new(&p, 100.0).unwrap();
        // Circle of radius 5·2/3 about 6·(1 − 2/3), and of radius 4 about 0.
        let limits = film_limits(&lens, 6.0, 50.0, 91);
        let (first, last) = (&limits[0], &limits[90]);
        assert_eq!((first.blocked.surface, last.blocked.surface), (1, 0));
        assert!((first.point[0] - 4.0).abs() < 1e-12);
        assert!((last.point[0] - (2.0 - 10.0 / 3.0)).abs() < 1e-12);
        for limit in &limits {
            let [x, y] = limit.point;
            let (a, b) = ((x - 2.0).hypot(y) - 10.0 / 3.0, x.hypot(y) - 4.0);
            let edge = if limit.blocked.surface == 0 { a } else { b };
            assert!(edge.abs() < 1e-12 && a.max(b) < 1e-12, "{limit:?}");
        }
        // So far off the axis that the circles do not overlap.
        assert!(film_limits(&lens, 40.0, 50.0, 91).is_empty());
        // A parallel beam at 5.7 degrees: the second aperture is seen from in front 5 mm aside.
        let limits = scene_limits(&lens, 0.1f64.atan(), 0.0, 91);
        assert_eq!(
            (limits[0].blocked.surface, limits[90].blocked.surface),
            (1, 0)
        );
        assert!(
            (limits[0].point[0] - (4.0 - 5.0)).abs() < 1e-11,
            "{:?}",
            limits[0]
        );
        assert!((limits[90].point[0] + 5.0).abs() < 1e-11);
    }
}
