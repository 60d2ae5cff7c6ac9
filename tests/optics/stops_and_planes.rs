//! A plane of glass told from a stop, in lens files and in everything that is done with them.

use crate::limits::film_limits;
use fstop::optics::prescription::{Glasses, zmx};
use fstop::optics::stop_shape::StopPolygon;
use fstop::optics::stops::{AxisPoint, exit_pupil, images_toward_film};
use fstop::optics::{Lens, LensRay, LensTracer, Paraxial, Prescription, StopShape};

fn dat(text: &str) -> Prescription {
    Prescription::parse(text).unwrap_or_else(|e| panic!("{text}: {e}"))
}

/// Stop?, index behind, and the number of warnings.
fn rows(text: &str) -> (Vec<(bool, f64)>, usize) {
    let p = dat(text);
    (
        p.surfaces.iter().map(|s| (s.is_stop, s.index)).collect(),
        p.warnings.len(),
    )
}

#[test]
fn radius_zero_is_a_stop_where_no_medium_changes() {
    // In air: blank, 0 and 1 are air.
    for index in ["0", "1", "1.0"] {
        let text = format!("50 5 1.5 20\n-50 2 1 20\n0 3 {index} 8\n");
        assert_eq!(
            rows(&text),
            (vec![(false, 1.5), (false, 1.0), (true, 1.0)], 0),
            "{text}"
        );
    }
    // Inside glass: 0, behind which pbrt's light would be in air, and the glass's own index change nothing ...
    for (index, said) in [("0", 1), ("1.5", 0)] {
        let text = format!("50 2 1.5 20\n0 3 {index} 8\n-50 0 1 20\n");
        let (found, warnings) = rows(&text);
        assert_eq!(found, [(false, 1.5), (true, 1.5), (false, 1.0)], "{text}");
        assert_eq!(warnings, said, "{text}");
    }
    // ... and another does: to air, to another glass, from air to glass. These are planes, and pbrt would take them for stops.
    for (text, row) in [
        ("50 2 1.5 20\n0 3 1 8\n-50 0 1 20\n", 1),
        ("50 2 1.5 20\n0 3 1.7 8\n-50 0 1 20\n", 1),
        ("0 5 1.5 20\n-50 0 1 20\n", 0),
    ] {
        let p = dat(text);
        assert!(
            !p.has_stop() && p.surfaces[row].curvature() == 0.0,
            "{text}"
        );
        let said = p
            .warnings
            .iter()
            .find(|w| w.row == row + 1)
            .expect("a warning");
        assert!(
            said.message.contains("read as a plane glass surface"),
            "{said}"
        );
        assert_eq!(said.line, row + 1);
    }
    // `inf` is a plane whatever the media, and says nothing.
    assert_eq!(
        rows("inf 5 1.5 20\ninf 3 1 20\ninf 0 1 20\n"),
        (vec![(false, 1.5), (false, 1.0), (false, 1.0)], 0)
    );
    // `stop` is a stop whatever the index column says.
    assert_eq!(
        rows("50 2 1.5 20\nstop 3 1 8\n-50 0 1 20\n").0[1],
        (true, 1.5)
    );
}

#[test]
fn a_plane_of_glass_refracts_and_a_stop_does_not() {
    let plane = LensTracer::<f64>::new(&dat("0 5 1.5 20\ninf 0 1 20\n").surfaces);
    let stop = LensTracer::<f64>::new(&dat("0 5 0 20\ninf 0 1 20\n").surfaces);
    let ray = LensRay::new([0.0, 0.0, -1.0], [0.6, 0.0, 0.8]);
    // Through a plate of 5 mm: sideways by tan(asin(0.6/1.5)) of it; without one straight on.
    let shift = |t: &LensTracer<f64>| t.to_film(&ray).expect("it passes").o[0] - 0.75;
    assert!((shift(&plane) - 5.0 * 0.4 / 0.84f64.sqrt()).abs() < 1e-14);
    assert!((shift(&stop) - 5.0 * 0.75).abs() < 1e-14);
}

#[test]
fn only_stops_are_stopped_down_and_scaling_keeps_them() {
    let text = "0 5 1.5 20\n-60 2 1 20\n0 3 0 12\n0 4 1.6 18\n40 30 1 18\n";
    let mut p = dat(text).scaled(2.0);
    assert!(p.set_stops(9.0).is_empty());
    let apertures: Vec<f64> = p.surfaces.iter().map(|s| s.aperture).collect();
    assert_eq!(apertures, [40.0, 40.0, 9.0, 36.0, 36.0]);
    let stops: Vec<bool> = p.surfaces.iter().map(|s| s.is_stop).collect();
    assert_eq!(stops, [false, false, true, false, false]);
    assert_eq!(
        (Paraxial::new(&p.surfaces).stop, p.film_distance),
        (2, 60.0)
    );
    // And the pupil search finds the stop, not a plane.
    assert_eq!(
        exit_pupil(&p.surfaces, AxisPoint::At(120.0)).map(|i| i.surface),
        Some(2)
    );
}

/// A singlet whose front surface is the stop, behind it a window.
fn zemax(stop_of_plane: bool) -> Prescription {
    let (curved, plane) = if stop_of_plane {
        ("", "  STOP\n")
    } else {
        ("  STOP\n", "")
    };
    let text = format!(
        "MODE SEQ\nUNIT MM\nSURF 0\n  DISZ INFINITY\nSURF 1\n{curved}  CURV 0.02\n  DISZ 5\n  GLAS ___BLANK 1 0 1.5 60\n  DIAM 10\n\
         SURF 2\n  CURV -0.01\n  DISZ 3\n  DIAM 10\nSURF 3\n{plane}  CURV 0\n  DISZ 2\n  GLAS ___BLANK 1 0 1.7 50\n  DIAM 9\n\
         SURF 4\n  CURV 0\n  DISZ 60\n  DIAM 9\nSURF 5\n"
    );
    zmx::parse(&text, &Glasses::COMMON).unwrap_or_else(|e| panic!("{text}: {e}"))
}

#[test]
fn zemax_marks_a_refracting_surface_as_the_stop() {
    for (stop_of_plane, row) in [(false, 0), (true, 2)] {
        let mut p = zemax(stop_of_plane);
        assert_eq!(p.surfaces.len(), 4);
        let stops: Vec<usize> = (0..4).filter(|i| p.surfaces[*i].is_stop).collect();
        assert_eq!(stops, [row]);
        // The stop is a glass surface: it still refracts, so the lens is the same wherever the flag is.
        let other = zemax(!stop_of_plane);
        let f = |p: &Prescription| {
            Paraxial::new(&p.surfaces)
                .cardinals
                .expect("a focal length")
                .focal_length
        };
        assert_eq!(f(&p), f(&other));
        let ray = LensRay::new([1.0, 0.5, -3.0], [0.05, 0.0, 1.0]);
        let through = |p: &Prescription| LensTracer::<f64>::new(&p.surfaces).to_film(&ray);
        assert_eq!(through(&p), through(&other));
        // Stopping down closes that surface, and it limits the light everywhere.
        assert!(p.set_stops(4.0).is_empty());
        assert_eq!(p.surfaces[row].aperture, 4.0);
        assert_eq!(Paraxial::new(&p.surfaces).stop, row);
        let lens = Lens::new(&p, p.film_distance).expect("a lens");
        assert_eq!(
            exit_pupil(lens.surfaces(), AxisPoint::At(lens.film_z())).map(|i| i.surface),
            Some(row)
        );
        for limit in film_limits(&lens, 2.0, lens.length(), 9) {
            assert_eq!(limit.blocked.surface, row);
        }
        // Its image lies off the vertex plane's by the sag of the rim: 2²/(2·50) at the front surface.
        let rim = images_toward_film(lens.surfaces(), AxisPoint::Infinity)[row].z;
        let pupil = Paraxial::new(lens.surfaces())
            .exit_pupil
            .expect("a pupil")
            .z;
        assert_eq!((rim - pupil).abs() > 1e-3, row == 0, "{rim} {pupil}");
        // A diaphragm has its shape there too.
        let bladed = lens
            .clone()
            .with_stop_shape(StopShape::Polygon(StopPolygon::of_blades(3, 0.0)));
        let down = |x: f64, y: f64| LensRay::new([x, y, -5.0], [0.0, 0.0, 1.0]);
        let passes = |l: &Lens, y: f64| l.tracer().to_film(&down(0.0, y)).is_ok();
        // Upward lies a corner, at the rim; downward a side, half as far.
        assert!(passes(&bladed, 1.7) && passes(&lens, -1.7) && !passes(&bladed, -1.7));
    }
}

#[test]
fn a_refracting_stop_keeps_its_radius_in_what_is_printed() {
    let p = zemax(false);
    let report = fstop::optics::LensReport::new(&Lens::new(&p, p.film_distance).expect("a lens"));
    assert!(report.to_string().contains("S 50.0000"), "{report}");
    assert_eq!(
        (report.surfaces[0].radius, report.surfaces[0].stop),
        (Some(50.0), true)
    );
}
