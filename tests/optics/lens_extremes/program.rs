//! `fstop lens` with all it writes, run as a user would: on the extreme lenses it ends soon, with numbers that are
//! numbers; on files that say something impossible it ends with the file, the line and the reason.

use super::cases::{self, Case};
use super::exact_optics::ExactLens;
use serde_json::Value;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// What a run left behind.
struct Run {
    code: i32,
    out: String,
    err: String,
}

/// No lens takes as long as this, on however busy a machine.
const PATIENCE: Duration = Duration::from_secs(60);

/// Runs `fstop` in `folder`.
fn run(folder: &Path, arguments: &[&str]) -> Run {
    let file = |name: &str| std::fs::File::create(folder.join(name)).expect("a file");
    let mut child = Command::new(env!("CARGO_BIN_EXE_fstop"))
        .args(arguments)
        .current_dir(folder)
        .stdout(Stdio::from(file("out")))
        .stderr(Stdio::from(file("err")))
        .spawn()
        .expect("the program starts");
    let start = Instant::now();
    let status = loop {
        match child.try_wait().expect("a child") {
            Some(status) => break status,
            None if start.elapsed() > PATIENCE => {
                child.kill().expect("a child to end");
                panic!("{arguments:?} takes more than {PATIENCE:?}");
            }
            None => std::thread::sleep(Duration::from_millis(5)),
        }
    };
    let text = |name: &str| std::fs::read_to_string(folder.join(name)).expect("text");
    // No code: a signal.
    Run {
        code: status.code().unwrap_or(-1),
        out: text("out"),
        err: text("err"),
    }
}

/// Words that are no numbers, in text that is not markup.
fn has_no_number(text: &str) -> Option<&str> {
    text.split(|c: char| !c.is_alphanumeric())
        .find(|word| ["NaN", "nan", "inf", "Infinity"].contains(word))
}

/// The lens's numbers and drawing, and its page.
fn describe(case: &Case, with_page: bool) -> Result<(), String> {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (name, file) = (&case.name, "lens.dat");
    std::fs::write(folder.path().join(file), &case.text).expect("a lens file");
    let distance = case.film_distance.to_string();
    let arguments = ["lens", file, "--film-distance", &distance, "--svg", "a.svg"];
    let page: &[&str] = if with_page {
        &["--analysis", "--report", "a.html"]
    } else {
        &[]
    };
    let shown = run(folder.path(), &[&arguments[..], page].concat());
    let json = run(
        folder.path(),
        &["lens", file, "--film-distance", &distance, "--json"],
    );
    if shown.code != 0 || json.code != 0 {
        return Err(format!(
            "{name}: {} {}: {}",
            shown.code, json.code, shown.err
        ));
    }
    let names: &[&str] = if with_page {
        &["a.svg", "a.html"]
    } else {
        &["a.svg"]
    };
    let read = |f: &&str| std::fs::read_to_string(folder.path().join(f)).expect("what was written");
    let files: Vec<String> = names.iter().map(read).collect();
    if let Some(word) = files.iter().find_map(|text| has_no_number(text)) {
        return Err(format!("{name}: {word} in drawing or page"));
    }
    // Infinity is a distance people focus at; "inf" is how it is written.
    if shown.out.contains("NaN") || shown.out.contains("nan") {
        return Err(format!("{name}: {}", shown.out));
    }
    let value: Value = serde_json::from_str(&json.out).map_err(|e| format!("{name}: {e}"))?;
    // The program's focal length is the lens's.
    let exact = ExactLens::new(&case.prescription().surfaces);
    let behind = exact.rows[exact.rows.len() - 1].index;
    let power = -(exact.matrix()[2] * behind).hi;
    match value["effective_focal_length"].as_f64() {
        Some(f) if (f * power - 1.0).abs() < 1e-9 => Ok(()),
        None if power.abs() < 1.1e-12 => Ok(()),
        found => Err(format!("{name}: focal length {found:?}, power {power:e}")),
    }
}

#[test]
fn every_extreme_lens_is_described() {
    // A page takes half a second, of a lens of 200 surfaces 15: every fifth lens of reasonable size has one made.
    let wrong: Vec<String> = cases::all()
        .enumerate()
        .filter_map(|(i, case)| describe(&case, i % 5 == 0 && case.text.len() < 1000).err())
        .collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn what_cannot_be_is_refused_with_file_and_line() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for (text, line, reason) in [
        ("# nothing\n", None, "no surfaces"),
        (
            "50 5 1.5 20\n1e-9 0 1 20\n",
            Some(2),
            "a radius of 0.000000001 mm",
        ),
        ("50 5 1.5 20\nnan 0 1 20\n", Some(2), "found nan"),
        ("50 1e999 1.5 20\n", Some(1), "the thickness in mm"),
        ("\n\n50 5 NaN 20\n", Some(3), "glass names such as NaN"),
        ("50 5 0.5 20\n", Some(1), "a refractive index of 0.5"),
        ("50 5 7 20\n", Some(1), "a refractive index of 7"),
        ("50 5 1.5 0\n", Some(1), "an aperture diameter of 0 mm"),
        ("50 5 1.5 -3\n", Some(1), "an aperture diameter of -3 mm"),
        ("50 5 1.5 inf\n", Some(1), "the aperture diameter in mm"),
    ] {
        std::fs::write(folder.path().join("odd.dat"), text).expect("a lens file");
        let run = run(folder.path(), &["lens", "odd.dat"]);
        assert_eq!(run.code, 2, "{text:?}: {}", run.err);
        let place = line.map_or(String::new(), |line| format!("line {line}, "));
        for part in ["odd.dat: ", &place, reason] {
            assert!(run.err.contains(part), "{text:?}: {part} in {}", run.err);
        }
        assert_eq!(run.out, "");
    }
}

#[test]
fn options_at_the_ends_are_taken_or_refused() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let lens = "50 5 1.5 20\n-50 2 1 20\n0 0 0 8\n";
    std::fs::write(folder.path().join("a.dat"), lens).expect("a lens file");
    // 1/f = 0.5 (2/50 − 0.5·5/(1.5·50²)).
    let f = 1.0 / (0.5 * (2.0 / 50.0 - 0.5 * 5.0 / (1.5 * 2500.0)));
    let json = |options: &[&str]| {
        run(
            folder.path(),
            &[&["lens", "a.dat", "--json"], options].concat(),
        )
    };
    let number = |run: &Run, name: &str| {
        let value: Value = serde_json::from_str(&run.out).expect("JSON");
        value[name].as_f64()
    };
    for scale in ["1e-3", "1", "1e6"] {
        let found =
            number(&json(&["--scale", scale]), "effective_focal_length").expect("a focal length");
        let scale: f64 = scale.parse().expect("a number");
        assert!((found / (scale * f) - 1.0).abs() < 1e-12, "{found}");
    }
    for (diameter, expected) in [("1e-3", 1e3), ("8", 0.125)] {
        let found = number(&json(&["--aperture", diameter]), "f_number").expect("an f-number");
        let full = number(&json(&[]), "f_number").expect("an f-number") * 8.0;
        assert!(
            (found / (expected * full) - 1.0).abs() < 1e-12,
            "{diameter} {found}"
        );
    }
    // Closed, it has no f-number and no entrance pupil to speak of, and is described all the same.
    let closed = json(&["--aperture", "0", "--analysis"]);
    assert_eq!(
        (closed.code, number(&closed, "f_number")),
        (0, None),
        "{}",
        closed.err
    );
    for distance in ["1e-6", "1e6"] {
        assert_eq!(
            number(&json(&["--film-distance", distance]), "film_distance"),
            distance.parse().ok()
        );
    }
    // The least distance between film and object: 4 f and the gap between the principal planes.
    let gap = {
        let run = json(&[]);
        number(&run, "rear_principal_plane").expect("a plane")
            - number(&run, "front_principal_plane").expect("a plane")
    };
    let least = 1e-3 * (4.0 * f + gap);
    for (factor, code) in [(1.0 + 1e-9, 0), (1.001, 0), (1.0 - 1e-9, 2), (0.5, 2)] {
        let run = json(&["--focus", &(factor * least).to_string()]);
        assert_eq!(run.code, code, "{factor}: {}", run.err);
        assert!(
            code == 0
                || run
                    .err
                    .contains(&format!("{:.2} mm for this lens", 1e3 * least)),
            "{}",
            run.err
        );
    }
    for refused in [
        ["--scale", "0"],
        ["--scale", "inf"],
        ["--scale", "nan"],
        ["--aperture", "-1"],
        ["--aperture", "inf"],
        ["--film-distance", "0"],
        ["--film-distance", "-1"],
        ["--film-distance", "nan"],
        ["--film-diagonal", "0"],
        ["--film-diagonal", "inf"],
        ["--focus", "0"],
        ["--focus", "nan"],
        ["--focus", "best:1e-9"],
    ] {
        let run = json(&refused);
        assert_eq!(
            (run.code, run.out.as_str()),
            (2, ""),
            "{refused:?}: {}",
            run.err
        );
        assert!(run.err.contains("error"), "{refused:?}: {}", run.err);
    }
}
