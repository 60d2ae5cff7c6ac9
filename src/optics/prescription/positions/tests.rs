use super::*;
use crate::optics::Paraxial;

/// Two thin groups, the distance between them and that of the film by zoom and focus.
const ZOOM: &str = "zoom 150 150 250 250\nfocus inf 2 inf 2\ngap D 40 42 55 58 # mm\n\
    gap film 90 95 60 66\n0 0 0 10\n100 0 2 30\ninf D 1 30\n-80 0 2 30\ninf film 1 30\n";

#[test]
fn positions_of_the_file_are_exact_and_between_them_linear() {
    let lens = Prescription::parse(ZOOM).unwrap();
    let gaps = |zoom: f64, mm: f64| {
        let lens = lens.at_position(Some(zoom), mm).unwrap();
        [lens.surfaces[2].thickness, lens.film_distance]
    };
    assert_eq!(gaps(150.0, f64::INFINITY), [40.0, 90.0]);
    assert_eq!(gaps(150.0, 2000.0), [42.0, 95.0]);
    assert_eq!(gaps(250.0, f64::INFINITY), [55.0, 60.0]);
    assert_eq!(gaps(250.0, 2000.0), [58.0, 66.0]);
    // Half way in both: the mean of four.
    assert_eq!(gaps(200.0, 4000.0), [48.75, 77.75]);
    // Nearer than the file goes: the groups stay where they are at its nearest.
    assert_eq!(gaps(150.0, 500.0), [42.0, 95.0]);
    // Without a position: the first.
    assert_eq!(lens.surfaces[2].thickness, 40.0);
    assert_eq!(lens.film_distance, 90.0);
    assert_eq!(
        lens.at_position(None, f64::INFINITY).unwrap().surfaces,
        lens.surfaces
    );
}

#[test]
fn a_zoom_scales_as_a_whole() {
    let lens = Prescription::parse(ZOOM).unwrap();
    let focal = |p: &Prescription| Paraxial::new(&p.surfaces).cardinals.unwrap().focal_length;
    for (zoom, mm) in [(150.0, f64::INFINITY), (180.0, 3000.0), (250.0, 2000.0)] {
        let [plain, scaled] = [(1.0, 1.0), (0.5, 0.5)].map(|(size, distance)| {
            let lens = lens.clone().scaled(size);
            focal(&lens.at_position(Some(zoom), mm * distance).unwrap())
        });
        // Half, by exact halves.
        assert!((scaled / plain - 0.5).abs() < 1e-15);
    }
}

#[test]
fn what_no_position_is_says_so() {
    let lens = Prescription::parse(ZOOM).unwrap();
    assert_eq!(
        lens.at_position(Some(300.0), 1e3),
        Err(PositionError::OutOfRange {
            asked: 300.0,
            low: 150.0,
            high: 250.0
        })
    );
    assert!(lens.at_position(Some(f64::NAN), 1e3).is_err());
    let fixed = Prescription::parse("50 5 1.5 20\n-50 0 1 20\n").unwrap();
    assert_eq!(
        fixed.at_position(Some(50.0), 1e3),
        Err(PositionError::NoZoom)
    );
    assert_eq!(fixed.at_position(None, 1e3).as_ref(), Ok(&fixed));
}

#[test]
fn mistakes_are_found_at_their_lines() {
    const ROWS: &str = "50 D 1.5 20\n-50 0 1 20\n";
    for (lines, found) in [
        (
            "zoom 1 2\ngap D 1\n",
            "line 2, column 1: 1 numbers for 2 positions",
        ),
        (
            "zoom 1 1\ngap D 1 2\n",
            "line 1, column 1: expected each pair",
        ),
        (
            "zoom 1 2\nfocus inf\ngap D 1 2\n",
            "line 1, column 1: 2 zooms and 1 distances",
        ),
        ("gap D 1\n", "line 1, column 1: a gap without positions"),
        (
            "zoom 1\ngap D 1\ngap E 2\n",
            "line 3, column 1: no row has the thickness E",
        ),
        (
            "zoom 1\ngap D 1\ngap D 2\n",
            "line 3, column 5: D: expected a name",
        ),
        (
            "zoom 1\nzoom 1\ngap D 1\n",
            "line 2, column 1: a second `zoom` line",
        ),
        (
            "zoom -1\ngap D 1\n",
            "line 1, column 6: expected a positive number",
        ),
        (
            "zoom 1e300\ngap D 1\n",
            "line 1, column 6: expected a positive number",
        ),
        (
            "focus 0\ngap D 1\n",
            "line 1, column 7: expected a positive number",
        ),
        (
            "zoom\ngap D 1\n",
            "line 1, column 1: expected 1 to 1000 numbers",
        ),
        (
            "gap\nzoom 1\n",
            "line 1, column 1: expected the name of a gap",
        ),
        (
            "zoom 1\ngap D x\n",
            "line 2, column 7: expected a thickness",
        ),
    ] {
        let error = Prescription::parse(&format!("{lines}{ROWS}")).unwrap_err();
        assert!(error.to_string().contains(found), "{lines}{error}");
    }
}

/// Every text of these words is read or refused, and every lens that is read has all its positions.
#[test]
fn no_text_panics() {
    const WORDS: [&str; 16] = [
        "zoom",
        "focus",
        "gap",
        "D",
        "E",
        "inf",
        "0",
        "1",
        "2.5",
        "-3",
        "1e308",
        "nan",
        "\n",
        "\n",
        "\n50 D 1.5 20\n",
        "#",
    ];
    let mut state = 1u64;
    let mut read = 0;
    for _ in 0..20_000 {
        let mut text = String::new();
        for _ in 0..14 {
            // Knuth's linear congruential generator, its high bits.
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            text += WORDS[(state >> 60) as usize];
            text.push(' ');
        }
        let text = format!("zoom 1 2\ngap D 1 2\n{text}\n50 D 1.5 20\n-50 0 1 20\n");
        let Ok(lens) = Prescription::parse(&text) else {
            continue;
        };
        read += 1;
        for zoom in [None, Some(1.0), Some(1.7), Some(2.0)] {
            let at = lens.at_position(zoom, 1e3).unwrap();
            assert!(
                at.surfaces.iter().all(|s| s.thickness.is_finite()),
                "{text}"
            );
        }
    }
    assert!(read > 100, "{read}");
}
