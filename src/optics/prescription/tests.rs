use super::*;
use proptest::prelude::*;

fn surfaces(text: &str) -> Vec<Surface> {
    Prescription::parse(text).unwrap().surfaces
}

fn errors(text: &str) -> Vec<RowNote> {
    match Prescription::parse(text) {
        Err(PrescriptionError::Rows(notes)) => notes,
        other => panic!("{other:?}"),
    }
}

#[test]
fn four_and_five_columns_say_the_same() {
    let four = surfaces("58.95 7.52 1.67 50.4\n169.66 0.24 1 50.4\n0 9 0 34.2\n-40 0 1 40\n");
    let five =
        surfaces("58.95 7.52 1.67 47.1 50.4\n169.66 0.24 1 0 50.4\n0 9 0 0 34.2\n-40 0 1 0 40\n");
    assert_eq!(five[0].abbe, Some(47.1));
    assert_eq!(four[1..], five[1..]);
    assert!(four[2].is_stop && !four[3].is_stop);
    assert_eq!(four[2].radius, f64::INFINITY);
}

#[test]
fn every_way_of_writing_a_file_is_read() {
    let plain = surfaces("58.95 7.52 1.67 50.4\n169.66 0.24 1 50.4\n0 9 0 34.2\n");
    for text in [
        // CRLF, tabs, comments anywhere, no last newline, blank lines.
        "# title\r\n58.95\t7.52\t1.67\t50.4 # front\r\n\r\n169.66\t0.24\t1\t50.4#rim\r\n0\t9\t0\t34.2",
        // A byte order mark, upper-case exponents, signs, bare dots.
        "\u{feff}5.895E1 +7.52 1.67 50.4\n1.6966E+2 .24 1. 50.4\n0. 9 0 342e-1",
        // Blank index: three columns, or an empty cell between tabs.
        "58.95 7.52 1.67 50.4\n169.66 0.24 50.4\n0 9 34.2\n",
        "58.95\t7.52\t1.67\t50.4\n169.66\t0.24\t\t50.4\n0\t9\t\t34.2\n",
        // Lines that end in CR alone; words for the stop and for air.
        "58.95 7.52 1.67 50.4\r169.66 0.24 air 50.4\rSTOP 9 0 34.2\r",
    ] {
        assert_eq!(surfaces(text), plain, "{text:?}");
    }
}

#[test]
fn the_lectures_table_is_read_with_its_blanks() {
    let p = Prescription::parse(
        "58.950 7.520 1.670 47.1 50.4\n169.660 0.240 50.4\n25.5 11.41 36.0\n9.000 34.2\n-79.460 72.228 40.0",
    )
    .unwrap();
    assert_eq!(p.surfaces.len(), 5);
    assert!(p.surfaces[3].is_stop);
    assert_eq!(
        (p.surfaces[3].thickness, p.surfaces[3].aperture),
        (9.0, 34.2)
    );
    assert_eq!(p.film_distance, 72.228);
    assert_eq!(p.surfaces[4].thickness, 0.0);
    // The two-column row is a guess, and said to be one.
    assert_eq!(p.warnings.len(), 1);
}

#[test]
fn planes_and_stops_are_told_apart() {
    // A plane-parallel plate written both ways, and a stop inside glass.
    let plate = surfaces("inf 5 1.5 20\nInfinity 0 1 20\n");
    assert!(plate.iter().all(|s| !s.is_stop && s.curvature() == 0.0));
    let p = Prescription::parse("0 5 1.5 20\n0 3 0 10\n0 0 1 20\n").unwrap();
    assert_eq!(
        p.surfaces.iter().map(|s| s.is_stop).collect::<Vec<_>>(),
        [false, true, false]
    );
    assert_eq!(p.surfaces[1].index, 1.5);
    // Of the planes that pbrt would take for stops, and of the stop that it would leave into air.
    assert_eq!(p.warnings.len(), 3);
}

#[test]
fn errors_name_row_line_and_column() {
    let notes = errors("# a lens\n50 5 1.5 20\n\n  -50 x 1 20\n30 2 SK16 20\n1 2 3\n");
    let places: Vec<_> = notes.iter().map(|n| (n.line, n.column, n.row)).collect();
    assert_eq!(places, [(4, 7, 2), (5, 6, 3)]);
    assert!(
        notes[0].message.contains("thickness in mm, found x"),
        "{}",
        notes[0]
    );
    assert!(
        notes[1].message.contains("glass names such as SK16"),
        "{}",
        notes[1]
    );
    let wrong = [
        ("50 5\n", "2 columns"),
        ("50 5 1.5\n", "may be an index or an aperture"),
        ("50 5 1.5 60 20 -1 0.001\n", "aspheric"),
        ("1e-9 5 1.5 20\n", "expected between 1e-6 and 1e30"),
        ("nan 5 1.5 20\n", "the radius in mm, found nan"),
        ("1e999 5 1.5 20\n", "the radius in mm"),
        ("50 inf 1.5 20\n", "the thickness in mm"),
        ("50 5 -1.5 20\n", "refractive index of -1.5"),
        ("50 5 1.5 0\n", "expected a positive length"),
        ("50 5 1.5 -60 20\n", "Abbe number of -60"),
        ("TYPE EVENASPH 1 2\n", "the radius in mm, found TYPE"),
        ("50 5 1.5 20 k=-1 k=-2\n", "k is given twice"),
        // Not radius, thickness, index 1, V 5168, aperture.
        ("50 5 1,5168 20\n", "found 1,5168"),
        ("50,5;5;1,5168;20\n", "found 50,5"),
        ("50, 5, 1,5\n", "found 50,"),
    ];
    for (text, expected) in wrong {
        let notes = errors(text);
        assert!(
            notes[0].to_string().contains(expected),
            "{text:?}: {}",
            notes[0]
        );
    }
    assert!(matches!(
        Prescription::parse("# nothing\n"),
        Err(PrescriptionError::Empty)
    ));
}

#[test]
fn commas_separate_columns_too() {
    let blanks = Prescription::parse("50 5 1.5 20\n-50 40 1 20\n").unwrap();
    for text in [
        "50,5,1.5,20\n-50,40,1,20\n",
        "50; 5; 1.5; 20\n-50;40;1;20\n",
    ] {
        assert_eq!(Prescription::parse(text).unwrap(), blanks, "{text}");
    }
}

/// One lens with dispersion and without, or a warning.
#[test]
fn a_dispersion_formula_and_its_column_are_of_one_glass() {
    // 1.5116 at the d line.
    let lens = |index: &str| {
        let text = format!("50 5 {index} 20 cauchy=1.5,0.004,0\n-50 40 1 20\n");
        let lens = Prescription::parse(&text).unwrap();
        let said = lens.warnings.first().map(ToString::to_string);
        (lens.surfaces[0].index, said.unwrap_or_default())
    };
    assert_eq!(lens("1.512"), (1.512, String::new()));
    let (index, said) = lens("1.7");
    assert!(index == 1.7 && said.contains("the column counts"), "{said}");
    let (index, said) = lens("1");
    assert!(
        (index - 1.5116).abs() < 1e-4 && said.contains("the formula counts"),
        "{said}"
    );
    let (index, said) = lens("0");
    assert!((index - 1.5116).abs() < 1e-4 && said.is_empty(), "{said}");
}

#[test]
fn stops_open_no_wider_than_their_row() {
    let mut p = Prescription::parse("50 5 1.5 20\n-50 2 1 20\n0 1 0 10\n0 0 0 6\n").unwrap();
    let notes = p.set_stops(8.0);
    assert_eq!(p.surfaces[2].aperture, 8.0);
    assert_eq!(p.surfaces[3].aperture, 6.0);
    assert_eq!(p.surfaces[0].aperture, 20.0);
    assert!(notes.len() == 1 && notes[0].contains("row 4"));
}

proptest! {
    /// Whatever the text, reading ends, and what it returns can be used.
    #[test]
    fn reading_never_panics(text in "([-+0-9.eE#=Ak,\t\r\n a-z]|inf|nan|\u{feff}|é){0,120}") {
        if let Ok(p) = Prescription::parse(&text) {
            for s in &p.surfaces {
                prop_assert!(s.curvature().is_finite() && s.thickness.is_finite());
                prop_assert!(s.index > 0.0 && s.aperture > 0.0);
            }
            prop_assert_eq!(p.surfaces.last().map(|s| s.thickness), Some(0.0));
        }
    }
}

#[test]
fn aspheric_and_dispersion_terms_are_read() {
    let s = surfaces(
        "50 5 1.5168 64.17 20 k=-0.5 A4=1e-6 a16=-2e-20 # rim\n-50\t2\t\t20 conic=-1\n\
         inf 3 1.5 20 A2=1e-3 cauchy=1.49,0.0042,1e-5\n60 0 1 20\n",
    );
    let a = s[0].asphere.unwrap();
    assert_eq!(
        (a.conic, a.terms[1], a.terms[7], a.terms[0]),
        (-0.5, 1e-6, -2e-20, 0.0)
    );
    // Blank cells between tabs still count before the words.
    assert_eq!((s[1].index, s[1].asphere.unwrap().conic), (1.0, -1.0));
    assert_eq!(s[2].curvature(), 2e-3);
    assert!(s[2].dispersion.is_some() && s[3].asphere.is_none());
}

#[test]
fn terms_that_cannot_be_read_are_named_with_their_place() {
    for (text, column, expected) in [
        ("50 5 1.5 20 k= -1\n", 13, "name=value without blanks"),
        ("50 5 1.5 20 A3=1\n", 13, "unknown term A3"),
        ("50 5 1.5 20 k=0 A18=1\n", 17, "unknown term A18"),
        ("50 5 1.5 20 A4=1e999\n", 13, "1 number(s)"),
        ("50 5 1.5 20 cauchy=1.5,0.004\n", 13, "3 number(s)"),
        ("50 5 1.5 20 cauchy=0.5,0,0\n", 13, "index of 0.5"),
        ("stop 5 1 20 k=-1\n", 1, "a stop with aspheric terms"),
    ] {
        let notes = errors(text);
        assert_eq!(notes[0].column, column, "{text}");
        assert!(notes[0].message.contains(expected), "{}", notes[0]);
    }
}

#[test]
fn scaling_keeps_the_shape() {
    let p = Prescription::parse("50 5 1.5 20 k=-0.5 A4=1e-5\n0 2 0 8\n-50 30 1 20\n").unwrap();
    let double = p.clone().scaled(2.0);
    assert_eq!(double.film_distance, 60.0);
    assert_eq!(double.surfaces[1].aperture, 16.0);
    assert!((double.surfaces[0].sag(16.0) - 2.0 * p.surfaces[0].sag(8.0)).abs() < 1e-14);
}

/// Lines of megabytes, which took minutes when each word's column was counted from the start.
#[test]
fn long_lines_are_read_in_proportion_to_their_length() {
    let words = 400_000;
    let extras = format!("50 5 1.5 20 {}\n-50 0 1 20\n", "A4=1e-6 ".repeat(words));
    assert!(errors(&extras)[0].message.contains("given twice"));
    let cells = format!("50 5 1.5 20\n{}", "é ".repeat(words));
    assert_eq!(errors(&cells)[0].line, 2);
    let bad = "50 5 1.5 20 ".to_string() + &"B=1 ".repeat(words);
    let message = Prescription::parse(&bad).unwrap_err().to_string();
    assert!(
        message.len() < 1000 && message.ends_with("; … and 399995 more"),
        "{message}"
    );
    // Each stands where it stands.
    assert!(
        message.contains("column 13 ") && message.contains("column 29 "),
        "{message}"
    );
}
