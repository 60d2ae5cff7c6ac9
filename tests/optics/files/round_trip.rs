//! Read, write, read: the same lens, in every format.

use fstop::optics::Prescription;
use fstop::optics::prescription::write::{LensFormat, WriteError};
use std::path::{Path, PathBuf};

/// Every lens of the project.
fn lenses() -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut files = Vec::new();
    for folder in ["lenses", "tests/golden"] {
        for entry in std::fs::read_dir(root.join(folder)).unwrap() {
            let path = entry.unwrap().path();
            if path.extension().is_some_and(|e| e == "dat") {
                files.push(path);
            }
        }
    }
    assert!(files.len() >= 18, "{}", files.len());
    files
}

/// The lens after it has been written and read, in a folder of its own.
fn back(lens: &Prescription, ending: &str) -> Result<Prescription, WriteError> {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join(format!("lens.{ending}"));
    let written = lens.write_as(LensFormat::of(&file).unwrap(), "a lens")?;
    std::fs::write(&file, &written.text).unwrap();
    if let Some(catalogue) = written.catalogue {
        std::fs::write(folder.path().join("lens.agf"), catalogue).unwrap();
    }
    Ok(Prescription::read(&file).unwrap_or_else(|e| panic!("{e}\n{}", written.text)))
}

/// Equal, numbers to 1e-12 of themselves.
fn same(a: &Prescription, b: &Prescription, about: &str) {
    let near = |x: f64, y: f64| x == y || (x - y).abs() <= 1e-12 * x.abs();
    assert_eq!(a.surfaces.len(), b.surfaces.len(), "{about}");
    assert!(near(a.film_distance, b.film_distance), "{about}");
    for (i, (s, t)) in a.surfaces.iter().zip(&b.surfaces).enumerate() {
        let about = format!("{about}, surface {}: {s:?} {t:?}", i + 1);
        for (x, y) in [
            (s.radius, t.radius),
            (s.thickness, t.thickness),
            (s.index, t.index),
            (s.aperture, t.aperture),
            (s.abbe.unwrap_or(0.0), t.abbe.unwrap_or(0.0)),
        ] {
            // A plane has no sides.
            assert!(
                near(x, y) || (x.is_infinite() && y.is_infinite()),
                "{about}"
            );
        }
        let [p, q] = [s, t].map(|s| s.asphere.unwrap_or_default());
        assert!(near(p.conic, q.conic), "{about}");
        assert!(
            p.terms.iter().zip(&q.terms).all(|(x, y)| near(*x, *y)),
            "{about}"
        );
        assert_eq!(
            (s.dispersion, s.glass, s.is_stop, s.coating),
            (t.dispersion, t.glass, t.is_stop, t.coating),
            "{about}"
        );
    }
}

/// Positions of the same names, values and gaps.
fn same_positions(a: &Prescription, b: &Prescription, about: &str) {
    let tables = [a, b].map(|lens| {
        let lines = lens.to_table().unwrap();
        let positions = |line: &&str| {
            ["zoom", "focus", "gap"]
                .iter()
                .any(|word| line.starts_with(word))
        };
        lines
            .lines()
            .filter(positions)
            .map(str::to_string)
            .collect::<Vec<_>>()
    });
    assert_eq!(tables[0], tables[1], "{about}");
}

#[test]
fn every_lens_of_the_project_comes_back_from_every_format() {
    for path in lenses() {
        let lens = Prescription::read(&path).unwrap();
        for ending in ["dat", "json", "zmx"] {
            let about = format!("{} as {ending}", path.display());
            let read = back(&lens, ending).unwrap();
            same(&lens, &read, &about);
            if ending != "zmx" {
                same_positions(&lens, &read, &about);
            }
        }
    }
}

#[test]
fn aspheres_glasses_formulas_baffles_and_media_come_back() {
    for text in [
        "50 5 1.5168 64.2 20 k=-0.8 A2=1e-9 A16=-3e-30 glass=N-BK7\n0 1 0 0 10\ninf 2 1 0 12\n-50 1e-300 1.33 20\n",
        "1e30 1 1.5168000345005883 64.17 20 glass=X-1 sellmeier=1.03961212,0.231792344,1.01046945,0.00600069867,0.0200179144,103.560653\n\
         -1e-3 7 1.5168000345005883 64.17 25 1e-3 sellmeier=1.03961212,0.231792344,1.01046945,0.00600069867,0.0200179144,103.560653\n\
         -30 7 1 25\n",
        "inf 3 1.5170194862906337 0 20 agf=5,1.5,0.01\n-40 -2 1 0 20\n",
    ] {
        let text = text.replace("25 1e-3 sell", "25 sell");
        let lens = Prescription::parse(&text).unwrap();
        for ending in ["dat", "json"] {
            same(&lens, &back(&lens, ending).unwrap(), ending);
        }
        // There two glasses of one formula are one.
        let mut zemax = lens.clone();
        if text.contains("X-1") {
            zemax.surfaces[1].glass = zemax.surfaces[0].glass;
        }
        same(&zemax, &back(&zemax, "zmx").unwrap(), "zmx");
    }
}

#[test]
fn zooms_come_back_from_the_formats_that_say_them() {
    for head in [
        "zoom 150 150 250 250\nfocus inf 2 inf 2\ngap D 1 2 3 4\ngap E 4 3 2 1\n",
        "focus inf 0.5 2 4\ngap D 1 2 3 4\ngap E 4 3 2 1\n",
        "zoom 1 2 3 4\ngap D 1 2 3 4\ngap E 4 3 2 1\n",
    ] {
        let text = format!("{head}50 D 1.5 20\n-50 D 1 20\n0 E 0 10\n");
        let lens = Prescription::parse(&text).unwrap();
        for ending in ["dat", "json"] {
            let read = back(&lens, ending).unwrap();
            same(&lens, &read, ending);
            same_positions(&lens, &read, ending);
        }
        // Zemax calls gaps by their surface; what they are at each position is the same.
        let read = back(&lens, "zmx").unwrap();
        assert!(read.warnings.is_empty(), "{:?}", read.warnings);
        same(&lens, &read, "zmx");
        let [lens, read] = [&lens, &read].map(|l| l.positions.as_ref().unwrap());
        assert_eq!(lens.zooms(), read.zooms());
        assert_eq!(lens.focuses(), read.focuses());
    }
}

/// At each position, and between them.
#[test]
fn groups_move_as_they_did_when_zemax_has_had_them() {
    let text = "zoom 150 150 250 250\nfocus inf 2 inf 2\ngap D 1 2 3 4\ngap E 4 3 2 1\n\
        50 3 1.5 20\n-50 D 1 20\n0 D 0 10\n60 2 1.6 20\n-70 E 1 20\n";
    let lens = Prescription::parse(text).unwrap();
    let read = back(&lens, "zmx").unwrap();
    for zoom in [150.0, 200.0, 250.0] {
        for distance in [f64::INFINITY, 2000.0, 5000.0] {
            let [a, b] = [&lens, &read].map(|l| l.at_position(Some(zoom), distance).unwrap());
            same(&a, &b, "zmx");
        }
    }
    // Other programs find the object where it is: 2 m from the film, 3 + 2 × 2 + 2 + 3 mm behind the first vertex.
    let written = lens.write_as(LensFormat::Zemax, "").unwrap().text;
    assert!(written.contains("MNUM 4 1\n") && written.contains("THIC 0 2 1.988e3 "));
    // Without our notes they are positions that focal lengths name; of those, the far ones.
    let plain: String = { written.lines() }
        .filter(|line| !line.starts_with("NOTE"))
        .map(|line| format!("{line}\n"))
        .collect();
    let plain = fstop::optics::prescription::zmx::parse(&plain, &Default::default()).unwrap();
    assert_eq!(plain.positions.unwrap().zooms().len(), 2);
}

#[test]
fn coatings_come_back() {
    let line = 1000.0 * fstop::optics::dispersion::LINE_D;
    let text = format!("50 5 1.5 20 coating=1.38@{line}\n-50 1 1 20\n0 30 0 10\n");
    let lens = Prescription::parse(&text).unwrap();
    assert!(lens.surfaces[0].coating.is_some() && lens.surfaces[1].coating.is_none());
    for ending in ["dat", "json", "zmx"] {
        same(&lens, &back(&lens, ending).unwrap(), ending);
    }
    let other = Prescription::parse("50 5 1.5 20 coating=1.45@500\n-50 1 1 20\n").unwrap();
    for ending in ["dat", "json"] {
        same(&other, &back(&other, ending).unwrap(), ending);
    }
    assert_eq!(back(&other, "zmx"), Err(WriteError::Coating(1)));
}

#[test]
fn what_a_format_cannot_say_it_says() {
    let lens = |text: &str| Prescription::parse(text).unwrap();
    let zemax = |text: &str| lens(text).write_as(LensFormat::Zemax, "").unwrap_err();
    assert_eq!(
        zemax("0 1 0 10\n50 5 1.5 20\n-50 1 1 20\n0 3 0 8\n"),
        WriteError::Stops(4)
    );
    assert_eq!(
        zemax("50 5 1.5168 64 20 cauchy=1.5046,0.0042,0\n-50 1 1 0 20\n"),
        WriteError::Formula(1)
    );
    assert_eq!(
        zemax("50 5 1.52 0 20 agf=5,1.5,0.01\n-50 1 1 0 20\n"),
        WriteError::Index(1)
    );
    let mut bare = lens("50 5 1.5 20\n-50 0 1 20\n");
    bare.surfaces[1].aperture = f64::INFINITY;
    for format in [LensFormat::Table, LensFormat::Zemax, LensFormat::Json] {
        assert_eq!(bare.write_as(format, ""), Err(WriteError::NoDiameter(2)));
    }
    for (name, format) in [
        ("a.DAT", Some(LensFormat::Table)),
        ("a.zmx", Some(LensFormat::Zemax)),
        ("a.txt", None),
        ("a", None),
    ] {
        assert_eq!(LensFormat::of(Path::new(name)), format);
    }
}
