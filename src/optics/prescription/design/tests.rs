use super::super::zmx;
use super::*;

/// A file of a head and surfaces, in UTF-8.
fn lens(head: &str, surfaces: &str) -> Prescription {
    let text = format!("MODE SEQ\nUNIT MM\n{head}\nSURF 0\n DISZ INFINITY\n{surfaces}");
    zmx::parse(&text, &Glasses::COMMON).unwrap_or_else(|e| panic!("{e}"))
}

/// A thin biconvex lens of f = 100 mm with a stop 20 mm behind it.
const THIN: &str = "SURF 1\n CURV 0.01\n DISZ 1e-9\n GLAS ___BLANK 1 0 1.5 60\nSURF 2\n CURV -0.01\n DISZ 20\n\
    SURF 3\n STOP\n DISZ 80\nSURF 4\n DISZ 0\n";

fn half_diameters(lens: &Prescription) -> Vec<f64> {
    lens.surfaces.iter().map(|s| 0.5 * s.aperture).collect()
}

#[test]
fn the_axial_beam_says_how_wide_stop_and_lens_are() {
    // 1 mm at the lens, 0.8 mm at the stop; spherical aberration and the sag are some h²/f² and h²/(2R) = 1e-4 and 5e-3 of it.
    for head in ["ENPD 2", "FNUM 50 0"] {
        let [a, b, stop] = half_diameters(&lens(head, THIN))[..] else {
            panic!("three surfaces");
        };
        assert!((a - 1.0).abs() < 1e-9 && (b - 1.0).abs() < 1e-3, "{a} {b}");
        assert!((stop - 0.8).abs() < 1e-3, "{stop}");
    }
    // By the stop's own diameter: the beam that fills it.
    let p = lens("FLOA", &THIN.replace("STOP\n", "STOP\n DIAM 0.8 1\n"));
    let [a, _, stop] = half_diameters(&p)[..] else {
        panic!("three surfaces");
    };
    assert!(stop == 0.8 && (a - 1.0).abs() < 1e-3, "{a}");
    let axis = |w: &RowNote| w.message.contains("no field off it");
    assert!(p.warnings.iter().any(axis));
}

#[test]
fn a_stop_of_another_f_number_than_the_files_is_told() {
    for (diameter, is_told) in [("0.8", false), ("1.6", true)] {
        let p = lens(
            "ENPD 2",
            &THIN.replace("STOP\n", &format!("STOP\n DIAM {diameter} 1\n")),
        );
        let told = |w: &RowNote| w.message.contains("whose own diameter is");
        assert_eq!(p.warnings.iter().any(told), is_told, "{:?}", p.warnings);
    }
}

#[test]
fn a_stop_wider_than_any_ray_is_filled_as_far_as_rays_go() {
    // Two spheres of radius 20 mm, 5 mm apart, meet 9.7 mm from the axis; the stop behind them asks for some 15 mm there.
    let surfaces = "SURF 1\n CURV 0.05\n DISZ 5\n GLAS ___BLANK 1 0 1.5 60\nSURF 2\n CURV -0.05\n DISZ 10\n\
        SURF 3\n STOP\n DISZ 20\n DIAM 8.5 1\nSURF 4\n DISZ 0\n";
    let p = lens("FLOA", surfaces);
    let [a, b, stop] = half_diameters(&p)[..] else {
        panic!("three surfaces");
    };
    assert!(
        stop == 8.5 && 9.0 < a.min(b) && a.max(b) < 13.0,
        "{a} {b} {stop}"
    );
    let says = |w: &RowNote| {
        w.message
            .contains("no ray from the axis fills the stop of radius 8.5")
    };
    assert!(p.warnings.iter().any(says), "{:?}", p.warnings);
}

#[test]
fn fields_widen_what_is_far_from_the_stop() {
    // The entrance pupil lies 25 mm behind the lens: the chief ray of 2° is 25 tan 2° = 0.873 from the axis there, the rim's 1 more.
    let widest = |head: &str| half_diameters(&lens(head, THIN));
    let found = widest("ENPD 2\nFTYP 0 0 3 1\nYFLN 0 1 2");
    // Aberrations of the pupil are some h²/f² of the height, 4e-4, the surfaces' sag at that slope as much.
    assert!((found[0] - 1.873).abs() < 2e-3, "{found:?}");
    assert!((found[2] - 0.8).abs() < 1e-3, "{found:?}");
    // Half of the pupil is vignetted, on both sides.
    let found = widest("ENPD 2\nFTYP 0 0 2 1\nYFLN 0 2\nVCYN 0 0.5");
    assert!((found[0] - 1.373).abs() < 2e-3, "{found:?}");
    // Beside the meridional plane, by the height of the image f tan 2° = 3.492.
    let found = widest("ENPD 2\nFTYP 3 0 2 1\nXFLN 0 2.095\nYFLN 0 -2.794");
    assert!((found[0] - 1.873).abs() < 5e-3, "{found:?}");
}

#[test]
fn an_object_near_the_lens_is_seen_by_height_or_aperture() {
    // At 2f: image at 2f, stop 20 mm behind the lens where a beam of half width 1 has 0.9.
    let near = |head: &str| {
        let text =
            format!("MODE SEQ\n{head}\nSURF 0\n DISZ 200\n{THIN}").replace("DISZ 80", "DISZ 180");
        half_diameters(&zmx::parse(&text, &Glasses::COMMON).unwrap())
    };
    // The marginal ray goes to the edge of the entrance pupil, 25 mm behind the lens.
    let na = 1.125 / 225f64.hypot(1.125);
    let axis = near(&format!("OBNA {na}"));
    assert!(
        (axis[0] - 1.0).abs() < 1e-3 && (axis[2] - 0.9).abs() < 1e-3,
        "{axis:?}"
    );
    // Object height 10: the chief ray through the middle of that pupil is 10·25/225 = 1.111 high at the lens.
    let field = near(&format!("OBNA {na}\nFTYP 1 0 1 1\nYFLN 10"));
    assert!((field[0] - 2.111).abs() < 5e-3, "{field:?}");
}

#[test]
fn what_no_ray_decides_is_an_error() {
    let text = format!("MODE SEQ\nSURF 0\n DISZ INFINITY\n{THIN}");
    let Err(PrescriptionError::Rows(notes)) = zmx::parse(&text, &Glasses::COMMON) else {
        panic!("without an aperture");
    };
    assert_eq!(notes.len(), 3);
    assert!(
        notes[0].message.contains("no clear diameter"),
        "{}",
        notes[0]
    );
}

#[test]
fn texts_are_decoded_with_and_without_a_mark() {
    let text = "MODE SEQ\n";
    let wide = |unit: fn(u16) -> [u8; 2]| text.encode_utf16().flat_map(unit).collect::<Vec<u8>>();
    for (bytes, mark) in [
        (wide(u16::to_le_bytes), &[0xff, 0xfe][..]),
        (wide(u16::to_be_bytes), &[0xfe, 0xff]),
        (wide(u16::to_le_bytes), &[]),
        (text.into(), &[0xef, 0xbb, 0xbf]),
        (text.into(), &[]),
    ] {
        assert_eq!(decode(&[mark, &bytes].concat()), text);
    }
}
