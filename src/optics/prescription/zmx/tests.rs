use super::super::write::{LensFormat, WriteError};
use super::super::{Prescription, PrescriptionError, RowNote, decode, glass};
use super::*;
use crate::optics::Paraxial;
use crate::optics::coating::Coating;
use crate::optics::dispersion::{AbbeModel, LINE_D};
use proptest::prelude::*;

/// The Cooke triplet of Smith's book as Zemax writes it, semi-diameters chosen here, with every kind of line that
/// files have; the stop stands on its own.
const TRIPLET: &str = "VERS 140124 258 36214\r\nMODE SEQ\r\nNAME Cooke triplet\r\nUNIT MM X W X CM MR CPMM\r\nENPD 1.295E+1\r\n\
    GCAT SCHOTT\r\nWAVM 1 5.87E-1 1\r\nSURF 0\r\n  TYPE STANDARD\r\n  CURV 0.0 0 0 0 0 \"\"\r\n  DISZ INFINITY\r\n\
    SURF 1\r\n  TYPE STANDARD\r\n  CURV 4.5435E-2 0 0 0 0 \"\"\r\n  MIRR 2 0\r\n  DISZ 3.259\r\n  GLAS SK16 0 0 1.62 60.3 0 0 0\r\n  DIAM 9.5 1 0 0 1 \"\"\r\n\
    SURF 2\r\n  TYPE STANDARD\r\n  CURV -2.2948E-3 0 0 0 0 \"\"\r\n  DISZ 6.008\r\n  DIAM 9.5 1 0 0 1 \"\"\r\n\
    SURF 3\r\n  TYPE STANDARD\r\n  CURV -4.5018E-2 0 0 0 0 \"\"\r\n  DISZ 1.0\r\n  GLAS ___BLANK 1 0 1.62004 36.37 0 0 0\r\n  DIAM 5 1 0 0 1 \"\"\r\n\
    SURF 4\r\n  STOP\r\n  TYPE STANDARD\r\n  CURV 4.9280E-2 0 0 0 0 \"\"\r\n  DISZ 4.75\r\n  DIAM 5 1 0 0 1 \"\"\r\n\
    SURF 5\r\n  TYPE EVENASPH\r\n  CURV 1.2556E-2 0 0 0 0 \"\"\r\n  CONI -0.5\r\n  PARM 1 0\r\n  PARM 2 1e-7\r\n  DISZ 2.952\r\n  GLAS SK16 0 0 1.62 60.3\r\n  DIAM 7.5 1 0 0 1 \"\"\r\n\
    SURF 6\r\n  TYPE STANDARD\r\n  CURV -5.4328E-2 0 0 0 0 \"\"\r\n  DISZ 2\r\n  DIAM 7.5 1 0 0 1 \"\"\r\n\
    SURF 7\r\n  TYPE STANDARD\r\n  CURV 0.0\r\n  DISZ 40.208\r\n  DIAM 10\r\n\
    SURF 8\r\n  TYPE STANDARD\r\n  CURV 0.0\r\n  DISZ 0\r\n  DIAM 18\r\nTOL TOFF 0 0\r\n";

fn parse(text: &str) -> Result<Prescription, PrescriptionError> {
    super::parse(text, &Glasses::COMMON)
}

fn errors(text: &str) -> Vec<RowNote> {
    match parse(text) {
        Err(PrescriptionError::Rows(notes)) => notes,
        other => panic!("{other:?}"),
    }
}

#[test]
fn coatings_that_zemax_names_itself_come_back() {
    let coated = |name: &str| {
        let line = format!("  DIAM 9.5 1 0 0 1 \"\"\r\n  COAT {name}\r\nSURF 2");
        let text = TRIPLET.replacen("  DIAM 9.5 1 0 0 1 \"\"\r\nSURF 2", &line, 1);
        assert!(text.contains("COAT"));
        parse(&text).unwrap()
    };
    let lens = coated("AR");
    let layer = Coating::magnesium_fluoride(1000.0 * LINE_D);
    assert_eq!(lens.surfaces[0].coating, Some(layer));
    assert!(lens.surfaces[1..].iter().all(|s| s.coating.is_none()));
    // Of a catalogue of coatings, which is not here.
    assert_eq!(coated("HEAR1").surfaces, parse(TRIPLET).unwrap().surfaces);
    let mut written = lens.clone();
    let write = |lens: &Prescription| lens.write_as(LensFormat::Zemax, "coated");
    let back = parse(&write(&written).unwrap().text).unwrap();
    assert_eq!(back.surfaces[0].coating, lens.surfaces[0].coating);
    written.surfaces[2].coating = "1.38@550".parse().ok();
    assert_eq!(write(&written).unwrap_err(), WriteError::Coating(3));
}

#[test]
fn a_file_as_zemax_writes_it_is_read() {
    let utf16: Vec<u8> = std::iter::once(0xfeff)
        .chain(TRIPLET.encode_utf16())
        .flat_map(u16::to_le_bytes)
        .collect();
    let p = parse(&decode(&utf16)).unwrap();
    assert_eq!(p, parse(TRIPLET).unwrap());
    assert_eq!(p.surfaces.len(), 6);
    assert!(p.warnings.is_empty());
    // The auxiliary plane behind the lens is part of the film distance.
    assert!((p.film_distance - 42.208).abs() < 1e-12);
    assert!(p.surfaces[3].is_stop && p.surfaces[3].aperture == 10.0);
    assert_eq!(p.surfaces[2].abbe, Some(36.37));
    let a = p.surfaces[4].asphere.unwrap();
    assert_eq!((a.conic, a.terms[1]), (-0.5, 1e-7));
    // Radii 22.01, -435.76, -22.21, 20.29, 79.64, -18.41: the triplet of f = 50 mm.
    let f = Paraxial::new(&p.surfaces).cardinals.unwrap().focal_length;
    assert!((f - 50.0).abs() < 0.1, "{f}");
}

/// Two thin groups of f = 100 and −80 mm with an auxiliary plane between them, in three configurations.
const ZOOM: &str = "MODE SEQ\nUNIT MM\nSURF 0\n DISZ INFINITY\nSURF 1\n STOP\n CURV 0.01\n DISZ 0\n GLAS ___BLANK 1 0 2 0\n DIAM 9\n\
    SURF 2\n CURV 0\n DISZ 30\n DIAM 9\nSURF 3\n CURV 0\n DISZ 10\n DIAM 9\nSURF 4\n CURV -0.0125\n DISZ 0\n GLAS ___BLANK 1 0 2 0\n DIAM 9\n\
    SURF 5\n CURV 0\n DISZ 240\n MAZH 0 0\n DIAM 9\nSURF 6\n";

#[test]
fn configurations_are_positions_of_a_zoom() {
    // Older programs write no more than the value, newer ones some flags behind it.
    let zoom = parse(&format!(
        "{ZOOM}MNUM 3 1\nTHIC 2 1 30 0 0 0 1 1 1 0 0 \"\" 0\nTHIC 2 2 50\nTHIC 2 3 40\n"
    ))
    .unwrap();
    assert!(zoom.warnings.is_empty(), "{:?}", zoom.warnings);
    // 1/f = 1/100 − 1/80 + d/8000, and the image f (1 − d/100) behind the second group; the plane's 10 mm are part of d.
    for (d, f) in [(40.0, 400.0), (60.0, 200.0), (50.0, 800.0 / 3.0)] {
        let engraved = (100.0_f64 * f).round() / 100.0;
        let at = zoom.at_position(Some(engraved), f64::INFINITY).unwrap();
        assert!((at.surfaces[1].thickness - d).abs() < 1e-12, "{at:?}");
        assert!(
            (at.film_distance - f * (1.0 - d / 100.0)).abs() < 1e-9,
            "{at:?}"
        );
        let found = Paraxial::new(&at.surfaces).cardinals.unwrap().focal_length;
        assert!((found / f - 1.0).abs() < 1e-12);
    }
    assert_eq!(
        zoom.positions.as_ref().and_then(|p| p.zoom_range()),
        Some([200.0, 400.0])
    );
}

#[test]
fn configurations_of_near_objects_are_positions_of_focus() {
    // The second group moves to the film for an object at 1 m, 200 mm being between the groups' own distances of the image.
    let text = format!(
        "{ZOOM}MNUM 2 1\nTHIC 0 1 1e10\nTHIC 0 2 1000\nTHIC 2 1 30\nTHIC 2 2 35\nCRVT 1 2 0.02\n"
    );
    let lens = parse(&text).unwrap();
    let positions = lens.positions.as_ref().unwrap();
    assert!(positions.focuses() && positions.zoom_range().is_none());
    let near = lens.at_position(None, 1.0).unwrap();
    assert_eq!(near.surfaces[1].thickness, 45.0);
    // The first image lies 1/(1/100 − 1/1000) = 111.1 mm behind its group, 66.1 behind the second: 1/(1/66.1 − 1/80) = 380.8 mm.
    let behind = 1.0 / (1.0 / (1000.0 / 9.0 - 45.0) - 1.0 / 80.0);
    assert!(
        (near.film_distance - behind).abs() < 1e-9,
        "{}",
        near.film_distance
    );
    let [warning] = &lens.warnings[..] else {
        panic!("{:?}", lens.warnings)
    };
    assert!(warning.message.contains("differ by curvatures"));
    // What is no position is said, and the lens read as it was saved.
    for wrong in ["MNUM 2 1\nTHIC 2 3 1\n", "MNUM 2 1\nTHIC 2 1 x\n"] {
        assert!(errors(&format!("{ZOOM}{wrong}"))[0].message.len() > 10);
    }
    let still = parse(&format!("{ZOOM}MNUM 1 1\nTHIC 2 1 30\n")).unwrap();
    assert_eq!((still.positions, still.surfaces[1].thickness), (None, 40.0));
}

#[test]
fn inches_are_converted_everywhere() {
    let inches = parse(&TRIPLET.replace("UNIT MM", "UNIT IN")).unwrap();
    let scaled = parse(TRIPLET).unwrap().scaled(25.4);
    for (a, b) in inches.surfaces.iter().zip(&scaled.surfaces) {
        assert!((a.radius / b.radius - 1.0).abs() < 1e-14);
        assert!((a.aperture / b.aperture - 1.0).abs() < 1e-14);
        assert!((a.sag(100.0) / b.sag(100.0) - 1.0).abs() < 1e-12);
    }
}

#[test]
fn what_cannot_be_modeled_is_named_with_its_line() {
    let with = |from: &str, to: &str| errors(&TRIPLET.replace(from, to));
    for (from, to, expected) in [
        ("TYPE EVENASPH", "TYPE TOROIDAL", "surface type TOROIDAL"),
        (
            "GLAS SK16 0 0 1.62 60.3\r",
            "GLAS UNOBTAINIUM\r",
            "unknown glass UNOBTAINIUM",
        ),
        (
            "GLAS ___BLANK 1 0 1.62004",
            "GLAS MIRROR 0 0 1.62004",
            "mirrors",
        ),
        ("MODE SEQ", "MODE NSC", "mode NSC"),
        ("UNIT MM", "UNIT FURLONG", "unit FURLONG"),
        (
            "DISZ 6.008",
            "DISZ INFINITY",
            "expected a distance, found INFINITY",
        ),
        ("CONI -0.5", "CONI x", "expected a conic constant"),
        (
            "DIAM 10\r",
            "DIAM 10\r\n  OBSC 0 3\r",
            "central obscurations",
        ),
    ] {
        let notes = with(from, to);
        assert_eq!(notes.len(), 1, "{to}: {notes:?}");
        assert!(notes[0].message.contains(expected), "{to}: {}", notes[0]);
        let before = &TRIPLET[..TRIPLET.find(from).unwrap()];
        // The obscuration stands on a line of its own.
        let line = 1 + before.matches('\n').count() + usize::from(to.contains("OBSC"));
        assert_eq!(notes[0].line, line, "{to}: {}", notes[0]);
    }
    let ring = with("DIAM 10\r", "DIAM 10\r\n  CLAP 2 5\r");
    assert!(ring[0].message.contains("ring-shaped"), "{}", ring[0]);
    // Of the last step too the row is named: stop and last element have lost their diameters, and no aperture says how wide the light is
    // there.
    let open = TRIPLET.replace("DIAM 7.5 1 0 0 1 \"\"", "DIAM 0 0");
    let stop = open.replace("DIAM 5 1 0 0 1 \"\"", "DIAM 0 0");
    let notes = errors(&stop.replace("ENPD", "XXXX"));
    assert_eq!(
        notes.iter().map(|n| n.row).collect::<Vec<_>>(),
        [3, 4, 5, 6]
    );
    assert!(
        notes[0].message.contains("no clear diameter"),
        "{}",
        notes[0]
    );
    assert!(
        parse(&open).unwrap().warnings[0]
            .message
            .contains("2 clear diameter(s)")
    );
    let narrow = parse(&TRIPLET.replacen("DIAM 9.5", "CLAP 0 8\r\n  DIAM 9.5", 1)).unwrap();
    assert_eq!(narrow.surfaces[0].aperture, 16.0);
    assert!(matches!(
        parse("MODE SEQ\nSURF 0\n"),
        Err(PrescriptionError::Empty)
    ));
}

/// A field stop between air and air, a baffle within glass, and a dummy in front, all of them rims.
#[test]
fn rims_between_equal_media_block() {
    let with = |line: &str, to: &str| parse(&TRIPLET.replacen(line, to, 1)).unwrap();
    // The auxiliary plane behind the lens, 2 mm behind its last surface.
    let plane = "DISZ 40.208\r\n  DIAM 10\r";
    for (lines, diameter) in [
        ("CLAP 0 6 0\r\n  DISZ 40.208\r\n  DIAM 10\r", 12.0),
        ("DISZ 40.208\r\n  FLAP 0 6 0\r\n  DIAM 7 1\r", 14.0),
    ] {
        let p = with(plane, lines);
        assert!(p.warnings.is_empty(), "{:?}", p.warnings);
        assert_eq!(p.surfaces.len(), 7);
        let rim = p.surfaces[6];
        assert_eq!(
            (rim.aperture, rim.is_stop, rim.index),
            (diameter, false, 1.0)
        );
        assert!((p.film_distance - 40.208).abs() < 1e-12 && p.surfaces[5].thickness == 2.0);
    }
    // In front of the lens too, where other dummies are left out.
    let front = "SURF 1\r\n  DISZ 30\r\n  CLAP 0 9 0\r\nSURF 1\r\n";
    let p = with("SURF 1\r\n", front);
    assert_eq!(
        (
            p.surfaces.len(),
            p.surfaces[0].thickness,
            p.surfaces[0].aperture
        ),
        (7, 30.0, 18.0)
    );
    // Without an aperture nothing is blocked, and a semi-diameter by hand is worth a word.
    let p = with(plane, "DISZ 40.208\r\n  DIAM 3 1 0 0 1 \"\"\r");
    assert_eq!(p.surfaces.len(), 6);
    let note = &p.warnings[0];
    assert!(
        note.row == 7 && note.message.contains("blocks nothing"),
        "{note}"
    );
}

/// A biconvex lens of radii 200 mm, 1e-6 mm thick: its focal length is 100 mm / (n − 1).
fn index_of(head: &str, glass: &str) -> (f64, Prescription) {
    let p = parse(&format!(
        "MODE SEQ\nUNIT MM\n{head}\nSURF 0\n DISZ INFINITY\nSURF 1\n STOP\n CURV 5e-3\n DISZ 1e-6\n GLAS {glass}\n DIAM 10\n\
         SURF 2\n CURV -5e-3\n DISZ 95\n DIAM 10\nSURF 3\n"
    ))
    .unwrap();
    let f = Paraxial::new(&p.surfaces).cardinals.unwrap().focal_length;
    (1.0 + 100.0 / f, p)
}

#[test]
fn indices_are_those_of_the_primary_wavelength() {
    // Malitson's tables.
    for head in [
        "WAVM 1 0.248272 1\nWAVM 2 0.6 1",
        "WAVM 1 0.5 1\nWAVM 2 0.248272 1\nPWAV 2",
        "PWAV 3\nWAVL 0.4 0.5 0.248272\nWWGT 1 1 1",
    ] {
        for (glass, expected) in [("F_SILICA 0 0 1.5 40", 1.50841), ("CAF2", 1.46793)] {
            let (n, p) = index_of(head, glass);
            assert!((n - expected).abs() < 5e-5, "{head} {glass}: {n}");
            assert!(p.warnings.is_empty(), "{:?}", p.warnings);
            // At the d line it is what the catalog says.
            let d = p.at_wavelength(LINE_D, AbbeModel::NormalLine).surfaces[0].index;
            assert!(
                (d - glass::named(glass.split(' ').next().unwrap())
                    .unwrap()
                    .index)
                    .abs()
                    < 3e-5
            );
        }
    }
    // A glass known by two numbers: in the visible to 1e-4 (Schott's n_F of N-SF6: 1.82783), beyond with a warning.
    let (n, p) = index_of("WAVM 1 0.4861327 1", "N-SF6");
    assert!((n - 1.82783).abs() < 2e-4 && p.warnings.is_empty(), "{n}");
    let (_, p) = index_of("WAVM 1 0.35 1", "___BLANK 1 0 1.6 60");
    assert!(
        p.warnings[0].row == 1 && p.warnings[0].message.contains("0.35 µm is a guess"),
        "{:?}",
        p.warnings
    );
    // The d line as files round it, and none; the thickness makes 1e-9.
    let of_bk7 = glass::named("N-BK7").unwrap().index;
    for head in ["WAVM 1 5.876E-1 1", "WAVM 1 0.587 1", "", "PWAV 9"] {
        assert!((index_of(head, "N-BK7").0 - of_bk7).abs() < 1e-8, "{head}");
    }
    let (n, p) = index_of("WAVM 1 0 1", "N-BK7");
    assert!(
        (n - of_bk7).abs() < 1e-8 && p.warnings[0].line == 3,
        "{:?}",
        p.warnings
    );
}

#[test]
fn a_glass_is_picked_up_from_another_surface() {
    let p = parse(&TRIPLET.replacen("GLAS ___BLANK 1 0 1.62004", "GLAS ___BLANK 2 1 1.62004", 1))
        .unwrap();
    assert_eq!(
        (p.surfaces[2].index, p.surfaces[2].abbe),
        (p.surfaces[0].index, p.surfaces[0].abbe)
    );
    for wrong in ["5", "-1", "0.5", "x"] {
        let notes =
            errors(&TRIPLET.replacen("GLAS ___BLANK 1 0", &format!("GLAS ___BLANK 2 {wrong}"), 1));
        assert!(notes.len() == 1 && notes[0].row == 3, "{notes:?}");
    }
}

proptest! {
    /// Whatever the text, reading ends.
    #[test]
    fn reading_never_panics(words in prop::collection::vec(
        "SURF|TYPE|EVENASPH|WAVM|WAVL|PWAV|CLAP|FLAP|CURV|CONI|PARM|DISZ|GLAS|DIAM|STOP|MODE|SEQ|\n|\n|\n|-?[0-9]{1,3}|1e-?[0-9]{3}|INFINITY|nan|BK7|é", 0..80,
    )) {
        if let Ok(p) = parse(&words.join(" ")) {
            for s in &p.surfaces {
                prop_assert!(s.curvature().is_finite() && s.thickness.is_finite());
                prop_assert!(s.index > 0.0 && s.aperture > 0.0);
            }
        }
    }

    /// Whatever the bytes, they become text.
    #[test]
    fn decoding_never_panics(bytes in prop::collection::vec(any::<u8>(), 0..40)) {
        decode(&bytes);
    }
}

#[test]
fn a_glass_unknown_by_name_is_that_of_its_numbers() {
    let with = |glass: &str| TRIPLET.replacen("GLAS SK16 0 0 1.62 60.3 0 0 0", glass, 1);
    let p = parse(&with("GLAS NEWGLASS 0 0 1.7 50.5 0 0 0")).unwrap();
    assert_eq!((p.surfaces[0].index, p.surfaces[0].abbe), (1.7, Some(50.5)));
    assert!(p.warnings[0].message.contains("unknown glass NEWGLASS"));
    // 1.5 and 40 are what Zemax writes where it does not say.
    assert!(parse(&with("GLAS NEWGLASS 0 0 1.5 40 0 0 0")).is_err());
    let own = crate::optics::prescription::agf::parse("NM NEWGLASS 5 0\nCD 1.6 0.01\n");
    let glasses = Glasses::COMMON.with(own);
    let p = super::parse(&with("GLAS NEWGLASS 0 0 1.5 40 0 0 0"), &glasses).unwrap();
    assert!((p.surfaces[0].index - 1.61702).abs() < 1e-5 && p.surfaces[0].dispersion.is_some());
    assert_eq!(p.surfaces[0].glass.unwrap().as_str(), "NEWGLASS");
}

#[test]
fn types_that_are_centered_and_even_are_read() {
    let odd = TRIPLET.replace("TYPE EVENASPH", "TYPE ODDASPHE");
    // PARM 2 is r² there.
    assert_eq!(
        parse(&odd).unwrap().surfaces[4].asphere.unwrap().terms[0],
        1e-7
    );
    let wrong = errors(&odd.replace("PARM 1 0", "PARM 1 1e-3"));
    assert!(
        wrong[0].message.contains("surface 5 has a term"),
        "{}",
        wrong[0]
    );
    // A coordinate break between air and air, which tilts nothing.
    let fold = |tilt: &str| {
        let lines = format!(
            "SURF 2\r\n  TYPE COORDBRK\r\n  PARM 3 {tilt}\r\n  PARM 6 1\r\n  DISZ 0\r\nSURF 3\r\n"
        );
        TRIPLET.replacen("SURF 3\r\n", &lines, 1)
    };
    assert_eq!(parse(&fold("0")).unwrap().surfaces.len(), 6);
    assert!(
        errors(&fold("2.5"))[0]
            .message
            .contains("tilts or decenters")
    );
}

/// Half the angle of the cone from the object, and the f-number at the film: by hand, for a thin lens of f = 50 mm.
#[test]
fn flagged_apertures_are_angles_and_working_f_numbers() {
    let thin = |head: &str| {
        let text = format!(
            "MODE SEQ\nUNIT MM\n{head}\nSURF 0\n DISZ 100\nSURF 1\n STOP\n CURV 0.02\n DISZ 1e-9\n GLAS ___BLANK 1 0 1.5 60\n\
             SURF 2\n CURV -0.02\n DISZ 100\nSURF 3\n DISZ 0\n"
        );
        0.5 * parse(&text).unwrap().surfaces[0].aperture
    };
    // 2f − 2f: the working f-number is twice the other. Sag and aberration are some (h/f)² = 2 % and less of the small ones.
    for (head, expected) in [
        ("FNUM 8 0", 25.0 / 8.0),
        ("FNUM 8 1", 50.0 / 8.0),
        ("OBNA 0.02 0", 2.0),
        ("OBNA 2 1", 100.0 * 2f64.to_radians().tan()),
    ] {
        let radius = thin(head);
        assert!(
            (radius / expected - 1.0).abs() < 0.02,
            "{head}: {radius} {expected}"
        );
    }
}

#[test]
fn an_object_in_glass_is_refused() {
    let notes = errors(&TRIPLET.replacen("SURF 0\r", "SURF 0\r\n  GLAS WATER 0 0 1.333 55\r", 1));
    assert!(
        notes[0]
            .message
            .contains("the object lies in WATER of index 1.3330"),
        "{}",
        notes[0]
    );
}
