//! What limits the light: of images toward the scene, and by real rays.

use fstop::optics::pupil::boundary;
use fstop::optics::stops::{AxisPoint, StopImage, images_toward_film};
use fstop::optics::{Blocked, Lens, LensRay, Paraxial, Prescription, Surface};

/// All apertures as the scene sees them, from the axis point `from` in front of the lens: the lens turned round, seen from its
/// film.
pub(crate) fn images_toward_scene(surfaces: &[Surface], from: AxisPoint) -> Vec<StopImage> {
    let count = surfaces.len();
    let length: f64 = surfaces[..count - 1].iter().map(|s| s.thickness).sum();
    let turned = |i: usize| {
        let mut s = surfaces[i];
        (s.thickness, s.index) = match i {
            0 => (0.0, 1.0),
            _ => (surfaces[i - 1].thickness, surfaces[i - 1].index),
        };
        s.radius = -s.radius;
        if let Some(asphere) = &mut s.asphere {
            asphere.terms = asphere.terms.map(|a| -a);
        }
        s
    };
    let turned: Vec<Surface> = (0..count).rev().map(turned).collect();
    let from = match from {
        AxisPoint::At(z) => AxisPoint::At(length - z),
        AxisPoint::Infinity => AxisPoint::Infinity,
    };
    let mut images = images_toward_film(&turned, from);
    for image in &mut images {
        image.surface = count - 1 - image.surface;
        image.z = length - image.z;
    }
    images.reverse();
    images
}

/// The entrance pupil of an axis point in front of the lens: the aperture image of smallest solid angle.
pub(crate) fn entrance_pupil(surfaces: &[Surface], from: AxisPoint) -> StopImage {
    let images = images_toward_scene(surfaces, from).into_iter();
    let smallest = images.min_by(|a, b| a.opening.total_cmp(&b.opening));
    smallest.expect("a lens has surfaces")
}

/// What limits the light in one direction around the pupil.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Limit {
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
pub(crate) fn film_limits(lens: &Lens, radius: f64, plane_z: f64, count: usize) -> Vec<Limit> {
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
pub(crate) fn scene_limits(lens: &Lens, angle: f64, plane_z: f64, count: usize) -> Vec<Limit> {
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

#[test]
fn the_image_of_the_stop_toward_the_scene_is_the_entrance_pupil_of_first_order() {
    let p = Prescription::parse("50 6 1.5 20\n-40 3 1 20\n0 4 0 8\n-60 3 1.6 20\n-35 0 1 20\n")
        .unwrap();
    let entrance = Paraxial::new(&p.surfaces).entrance_pupil.unwrap();
    let scene = &images_toward_scene(&p.surfaces, AxisPoint::Infinity)[2];
    assert!((scene.z - entrance.z).abs() < 1e-12);
    assert!((scene.diameter - entrance.diameter).abs() < 1e-12);
    // Bare apertures of 10 mm, and of 8 mm 50 mm behind: 4/(d + 50) is less than 5/d.
    let p = Prescription::parse("0 50 0 10\n0 0 0 8\n").unwrap();
    let pupil = entrance_pupil(&p.surfaces, AxisPoint::At(-100.0));
    assert_eq!(pupil.surface, 1);
    assert!((pupil.opening - 4.0 / 150.0).abs() < 1e-15);
}
