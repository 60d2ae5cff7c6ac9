//! `fstop lens`: JSON says all that the text does, and the page has all that is promised, alone.

use crate::common::program::fstop;
use serde_json::Value;

const LENS: &str = "tests/golden/triplet_50.dat";

/// A lens whose glasses disperse: an achromat behind its stop.
const ACHROMAT: &str = "0 2 0 0 12\n61 4 1.5168 64.2 20\n-45 2 1.6727 32.2 20\n-130 0 1 0 20\n";

/// All numbers of a JSON value.
fn numbers(value: &Value, found: &mut Vec<f64>) {
    match value {
        Value::Number(n) => found.extend(n.as_f64()),
        Value::Array(items) => items.iter().for_each(|v| numbers(v, found)),
        Value::Object(fields) => fields.values().for_each(|v| numbers(v, found)),
        _ => {}
    }
}

#[test]
fn json_has_every_number_of_the_text() {
    let run = |format: &[&str]| {
        let run = fstop([&["lens", LENS, "--analysis"], format].concat());
        assert_eq!(run.code, 0, "{}", run.stderr);
        run.stdout
    };
    let json: Value = serde_json::from_str(&run(&["--json"])).expect("JSON");
    let mut known = Vec::new();
    numbers(&json, &mut known);
    let text = run(&[]);
    let mut checked = 0;
    for word in text.split([' ', '\n', '/']) {
        // Row numbers and such have no decimals.
        let (Ok(value), Some((_, decimals))) = (word.parse::<f64>(), word.split_once('.')) else {
            continue;
        };
        // Half a unit in the last place shown, in the unit shown: mm, m, um, %.
        let half = 0.5001 * 10f64.powi(-(decimals.len() as i32));
        let same = |k: &f64| {
            [1.0, 1e-3, 1e3, 100.0]
                .iter()
                .any(|unit| (k * unit - value).abs() <= half)
        };
        assert!(known.iter().any(same), "{word} is not in the JSON");
        checked += 1;
    }
    assert!(checked > 200, "{checked}");
}

/// The names of all elements, and that each ends where it should.
fn elements(page: &str) -> Vec<String> {
    let mut open: Vec<String> = Vec::new();
    let mut all = Vec::new();
    for tag in page.split('<').skip(1) {
        let (tag, _) = tag.split_once('>').expect("a tag ends");
        let name: String = tag
            .trim_start_matches('/')
            .chars()
            .take_while(|c| c.is_alphanumeric())
            .collect();
        if tag.starts_with('!') || tag.starts_with('?') || name == "meta" || tag.ends_with('/') {
            all.push(name);
        } else if tag.starts_with('/') {
            assert_eq!(open.pop(), Some(name), "{tag}");
        } else {
            all.push(name.clone());
            open.push(name);
        }
    }
    assert!(open.is_empty(), "{open:?}");
    all
}

#[test]
fn the_page_is_whole_and_alone() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("page.html");
    let name = file.to_string_lossy().into_owned();
    let lens = folder.path().join("achromat.dat");
    std::fs::write(&lens, ACHROMAT).expect("a lens");
    let lens = lens.to_string_lossy().into_owned();
    let run = fstop(["lens", &lens, "--report", &name]);
    assert_eq!(run.code, 0, "{}", run.stderr);
    let page = std::fs::read_to_string(&file).expect("the page");
    let all = elements(&page);
    let count = |name: &str| all.iter().filter(|n| *n == name).count();
    // A section for each figure, of which some have several panels, and one of numbers.
    assert!(
        count("svg") >= 20 && count("section") == count("figure") + 1,
        "{} {}",
        count("svg"),
        count("section")
    );
    assert!(count("table") >= 6 && count("script") == 0 && count("link") == 0 && count("img") == 0);
    // Every item of the list, each with what its axes or columns are in.
    for (section, parts) in [
        ("cross-section", &["Cross-section", "mm"][..]),
        ("spots", &["Spot diagrams", "µm"]),
        ("fans", &["Ray aberrations", "µm"]),
        ("mtf", &["MTF over the field", "lp/mm", "mm"]),
        ("distortion", &["Distortion", "%", "mm"]),
        (
            "illumination",
            &["Relative illumination", "cos⁴", "%", "mm"],
        ),
        (
            "mtf-frequency",
            &["MTF by frequency", "by waves", "contrast"],
        ),
        ("mtf-focus", &["MTF through focus", "mm", "contrast"]),
        (
            "field-curves",
            &["Field curves", "tangential", "Petzval", "mm"],
        ),
        ("longitudinal", &["Longitudinal aberration", "pupil", "mm"]),
        ("focal-shift", &["Chromatic focal shift", "nm", "mm"]),
        ("color", &["Lateral color", "F (486 nm)", "µm"]),
        ("grid", &["Distortion grid", "mm"]),
        ("footprints", &["Pupil footprints", "radii"]),
    ] {
        let (_, rest) = page
            .split_once(&format!("<section id=\"{section}\""))
            .unwrap_or_else(|| panic!("no {section}"));
        let (body, _) = rest.split_once("</section>").expect("its end");
        for part in parts {
            assert!(body.contains(part), "{section}: {part}");
        }
    }
    for part in [
        "view, horizontal",
        "view, diagonal",
        "Focus table",
        "sharp from",
        "Over the field",
        "Seidel sums",
        "S_V distortion",
        "Prescription",
    ] {
        assert!(page.contains(part), "{part}");
    }
    let links = page.replace("http://www.w3.org/2000/svg", "");
    for outside in ["http:", "https:", "src=", "@import", "url(", "NaN"] {
        assert!(!links.contains(outside), "{outside}");
    }
}

#[test]
fn tables_over_the_field_have_as_many_rows_as_asked_for_and_json_all() {
    let rows = |options: &[&str]| {
        let run = fstop([&["lens", LENS, "--analysis"], options].concat());
        assert_eq!(run.code, 0, "{}", run.stderr);
        let (_, rest) = run
            .stdout
            .split_once("lp/mm\n")
            .expect("the table over the field");
        rest.lines()
            .skip(1)
            .take_while(|line| !line.is_empty())
            .count()
    };
    assert_eq!(
        (rows(&[]), rows(&["--rows", "25"]), rows(&["--rows", "1"])),
        (6, 25, 1)
    );
    assert_eq!(fstop(["lens", LENS, "--analysis", "--rows", "26"]).code, 2);
    let folder = tempfile::tempdir().expect("a temporary folder");
    let lens = folder.path().join("achromat.dat");
    std::fs::write(&lens, ACHROMAT).expect("a lens");
    let run = fstop(["lens", &lens.to_string_lossy(), "--analysis", "--json"]);
    let json: Value = serde_json::from_str(&run.stdout).expect("JSON");
    let analysis = &json["analysis"];
    assert_eq!(analysis["fields"].as_array().map(Vec::len), Some(25));
    // Every figure has its numbers.
    for (name, least) in [
        ("mtf", 5),
        ("footprints", 5),
        ("field_curves", 25),
        ("longitudinal", 3),
    ] {
        assert!(
            analysis[name]
                .as_array()
                .is_some_and(|all| all.len() >= least),
            "{name}"
        );
    }
    for (name, part) in [
        ("seidel", "surfaces"),
        ("distortion_grid", "points"),
        ("color", "focal_shift"),
    ] {
        assert!(
            analysis[name][part]
                .as_array()
                .is_some_and(|all| all.len() >= 4),
            "{name}"
        );
    }
}

/// Three elements have six surfaces, which make fifteen pairs; a layer makes all of them fainter.
#[test]
fn ghosts_are_listed_pair_by_pair() {
    let list = |options: &[&str]| -> (f64, Vec<Value>) {
        let run = fstop([&["lens", LENS, "--json", "--ghosts", "5"], options].concat());
        assert_eq!(run.code, 0, "{}", run.stderr);
        let table: Value = serde_json::from_str(&run.stdout).expect("JSON");
        let rows = table["ghosts"].as_array().expect("rows").clone();
        (table["transmitted"].as_f64().expect("a share"), rows)
    };
    let light = |rows: &[Value]| {
        rows.iter()
            .filter_map(|row| row["light"].as_f64())
            .sum::<f64>()
    };
    let (direct, bare) = list(&[]);
    let (more, coated) = list(&["--coating", "1.38@550"]);
    assert!(
        (0.6..0.8).contains(&direct) && (0.9..0.98).contains(&more),
        "{direct} {more}"
    );
    assert!((10..=15).contains(&bare.len()), "{}", bare.len());
    assert!(light(&bare) > 1e-3 && light(&coated) < 0.5 * light(&bare));
    let text = fstop(["lens", LENS, "--ghosts", "5"]).stdout;
    let lines = text.lines().filter(|line| !line.is_empty());
    assert_eq!(lines.count(), bare.len() + 2, "{text}");
    assert!(text.contains("with reflections counted"), "{text}");
    for wrong in [["--ghosts", "90"], ["--coating", "1.38@550"]] {
        assert_eq!(fstop(["lens", LENS, wrong[0], wrong[1]]).code, 2);
    }
    let run = fstop(["lens", LENS, "--ghosts", "5", "--coating", "glass"]);
    assert!(
        run.code == 2 && run.stderr.contains("1.38@550"),
        "{}",
        run.stderr
    );
}
