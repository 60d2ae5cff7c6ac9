//! Analysis of a lens that sees behind itself.

use super::{Beam, ChiefFinder, Effort, Film, LensAnalysis, ObjectPlane, Spot};
use crate::optics::pupil::RINGS;
use crate::optics::{ExitPupil, Lens, LensRay, LensTracer, Prescription};

/// A fisheye of some 8 mm for 206°: two strong menisci in front of an achromat. Made for these tests.
const FISHEYE: &str = "45 2.5 1.6968 84\n17 12 1 33.6\n60 2 1.6968 42\n13 14 1 25\n35 5 1.7552 18\n\
    -60 3 1 18\n0 0.8 1 5\n-300 4 1.5168 12\n-14 0.5 1 12\n60 1.2 1.7552 14\n16 4.5 1.5168 14\n-24 0 1 14\n";

fn fisheye() -> Lens {
    let p = Prescription::parse(FISHEYE).unwrap();
    Lens::new(&p, Lens::focused(&p, f64::INFINITY).unwrap()).unwrap()
}

/// Film height and field angle in degrees of the ray that leaves the middle of the stop at `angle` with the axis; `None`
/// where it is blocked in front of the stop or behind.
fn from_stop(lens: &Lens, angle: f64) -> Option<[f64; 2]> {
    let surfaces = lens.surfaces();
    let stop = lens.paraxial().stop;
    let (sin, cos) = angle.sin_cos();
    let behind = LensTracer::<f64>::new(&surfaces[stop..])
        .to_film(&LensRay::new([0.0; 3], [0.0, sin, cos]))
        .ok()?;
    let before: f64 = surfaces[..stop].iter().map(|s| s.thickness).sum();
    let front = LensTracer::<f64>::new(&surfaces[..stop])
        .to_scene(&LensRay::new([0.0, 0.0, before], [0.0, -sin, -cos]))
        .ok()?;
    let t = (lens.film_z() - before - behind.o[2]) / behind.d[2];
    let height = behind.o[1] + t * behind.d[1];
    Some([
        height,
        front.d[1].hypot(front.d[0]).atan2(-front.d[2]).to_degrees(),
    ])
}

#[test]
fn the_image_circle_ends_where_the_rims_end_it() {
    let lens = fisheye();
    // The steepest ray through the middle of the stop that gets through on both sides.
    let (mut low, mut high) = (0.5, 1.2);
    assert!(from_stop(&lens, low).is_some() && from_stop(&lens, high).is_none());
    for _ in 0..50 {
        let middle = 0.5 * (low + high);
        match from_stop(&lens, middle) {
            Some(_) => low = middle,
            None => high = middle,
        }
    }
    let [height, angle] = from_stop(&lens, low).unwrap();
    assert!(angle > 100.0, "{angle}");
    let found = ChiefFinder::new(&lens).limit(40.0).unwrap();
    // Both searches end after 40 halvings or more of lengths of 20 mm.
    assert!(
        (found[0] - height).abs() < 1e-7,
        "{found:?} {height} {angle}"
    );
    assert!(
        (found[1] - angle).abs() < 1e-5,
        "{found:?} {height} {angle}"
    );
}

#[test]
fn beams_from_behind_land_where_their_rays_come_from() {
    let lens = fisheye();
    let finder = ChiefFinder::new(&lens);
    let limit = finder.limit(40.0).unwrap()[0];
    let pupil = ExitPupil::new(&lens, limit, RINGS);
    let mut behind = 0;
    for part in [0.5, 0.8, 0.9, 0.95, 0.99] {
        let chief = finder.find(part * limit).unwrap();
        behind += u32::from(chief.field_angle().to_degrees() > 90.0);
        let beam = Beam::new(&lens, &pupil, &chief, ObjectPlane::INFINITY).unwrap();
        let points = beam.grid(&lens, 32);
        // Most of the rectangle around the beam is beam.
        assert!(points.len() > 300, "{part}: {}", points.len());
        for (p, [x, y]) in points {
            let ray = beam.ray(p);
            // Back through the lens from where it landed, aimed by its last stretch.
            let out = lens.tracer().to_film(&ray).unwrap();
            let back = lens.trace_from_film([x, y], out.o).unwrap();
            for i in 0..3 {
                assert!(
                    (back.d[i] + ray.d[i]).abs() < 1e-9,
                    "{part}: {ray:?} {back:?}"
                );
            }
        }
        let spot = Spot::trace(&lens, &beam, 32);
        assert!(spot.rms_radius() < 1.0, "{}", spot.rms_radius());
    }
    assert!(behind >= 2);
}

#[test]
fn the_whole_field_is_analyzed() {
    let effort = Effort {
        fields: 9,
        rays_across: 24,
        pupil_samples: 1 << 10,
    };
    let analysis = LensAnalysis::new(&fisheye(), Film::FULL_FRAME, ObjectPlane::INFINITY, &effort);
    let angles: Vec<f64> = analysis.fields.iter().map(|f| f.field_angle).collect();
    assert_eq!(angles.len(), 9, "{angles:?}");
    assert!(
        angles.windows(2).all(|a| a[0] < a[1]) && angles[8] > 100.0,
        "{angles:?}"
    );
    // The tangent of the angle says nothing there, and the angle does.
    assert!(
        analysis.fields[8].distortion.is_none() && analysis.fields[8].f_theta_distortion.is_some()
    );
    assert!(
        analysis
            .fields
            .iter()
            .all(|f| f.spot_rms.is_some() && f.cos4_field >= 0.0)
    );
    assert_eq!((analysis.spots.len(), analysis.fans.len()), (5, 5));
    assert!(analysis.fans[4].tangential.len() > 20);
}
