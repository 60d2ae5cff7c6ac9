//! Files in the form of other programs, written here, with what they mean.

use fstop::optics::prescription::{Glasses, PrescriptionError, json, optbench, oslo, seq, zmx};
use fstop::optics::{Lens, Paraxial, Prescription};

fn focal_length(lens: &Prescription) -> f64 {
    Paraxial::new(&lens.surfaces)
        .cardinals
        .unwrap()
        .focal_length
}

fn messages(error: PrescriptionError) -> String {
    error.to_string()
}

/// A cemented doublet of f ≈ 100 mm behind its stop, as each format says it.
fn doublet(lens: &Prescription, about: &str) {
    let s = &lens.surfaces;
    let near =
        |x: f64, y: f64| assert!((x - y).abs() < 1e-9 * y.abs().max(1.0), "{about}: {x} {y}");
    assert_eq!(s.len(), 4, "{about}");
    assert!(s[0].is_stop && !s[1..].iter().any(|s| s.is_stop), "{about}");
    for (s, (radius, thickness)) in s[1..]
        .iter()
        .zip([(61.47, 6.0), (-43.47, 2.5), (-125.0, 0.0)])
    {
        near(s.radius, radius);
        near(s.thickness, thickness);
    }
    near(s[0].thickness, 3.0);
    near(lens.film_distance, 95.9);
    for (s, radius) in s.iter().zip([9.0, 12.0, 12.0, 12.5]) {
        near(0.5 * s.aperture, radius);
    }
    let [crown, flint, air] = [&s[1], &s[2], &s[3]];
    assert!(
        (crown.index - 1.5168).abs() < 1e-3 && (flint.index - 1.6727).abs() < 1e-3,
        "{about}"
    );
    assert_eq!(air.index, 1.0, "{about}");
    let asphere = air.asphere.unwrap_or_default();
    assert_eq!(
        (asphere.conic, asphere.terms[1], asphere.terms[2]),
        (-0.5, 2e-7, -1e-10),
        "{about}"
    );
    assert!(
        (focal_length(lens) - 100.0).abs() < 2.0,
        "{about} {}",
        focal_length(lens)
    );
    assert!(Lens::new(lens, lens.film_distance).is_ok());
}

const CODE_V: &str = "RDM;LEN       \"VERSION: 11.2; of CODE V\"\nTITLE 'Doublet ! with a stop'\nEPD   18.0\nDIM   M\nWL    656.3 587.6 &\n 486.1\nREF   2\n\
    XAN   0.0 0.0\nYAN   0.0 2.0\nVUY   0.0 0.1\nSO    0.0 0.1e11\nS     0.0 3.0\n  STO; CIR 9.0\nS     61.47 6.0 NBK7_SCHOTT\n  SLB \"front\"\n  CIR 12.0; CIR EDG 13\n\
    S     -43.47 2.5 672700.322\n  CCY 0\nS     -125.0 95.8\n  PIM\n  ASP\n  K   -0.5\n  A   0.2e-6; B -0.1e-9; C 0.0\n  D&\n   0.0\nSI    0.0 0.1\nCIR S3 12\nCIR S4 12.5\nGO \n";

#[test]
fn a_code_v_file_is_read() {
    let glasses = Glasses::COMMON;
    let read = |text: &str| seq::parse(text, &glasses);
    doublet(&read(CODE_V).unwrap(), "radii");
    let curved = CODE_V
        .replace("RDM;", "RDM N;")
        .replace("61.47 6.0", "0.016268098259313486 6.0");
    let curved = curved
        .replace("-43.47 2.5", "-0.02300437082700713 2.5")
        .replace("-125.0 95", "-0.008 95");
    doublet(&read(&curved).unwrap(), "curvatures");
    // Numbers of surfaces in front of their values, and a glass by two numbers.
    let numbered = CODE_V
        .replace("S     61.47", "S2    61.47")
        .replace("672700.322", "1.6727:32.2");
    doublet(&read(&numbered).unwrap(), "numbers");
    let private = "PRV\n  PWL 656.3 587.6 486.1\n 'FLINT' 1.6665 1.6727 1.6874\nEND\nSO ";
    doublet(
        &read(
            &CODE_V
                .replace("SO ", private)
                .replace("672700.322", "'FLINT'"),
        )
        .unwrap(),
        "private",
    );
    // Radius, curvature and glass as commands of their own, of the surface at hand or of one by its number.
    let alone = CODE_V
        .replace(
            "S     61.47 6.0 NBK7_SCHOTT",
            "S 0 6.0\n RDY 61.47; GLA NBK7_SCHOTT",
        )
        .replace(
            "S     -43.47 2.5 672700.322",
            "S 0 2.5\n CUY -0.02300437082700713",
        )
        .replace("GO ", "GLA S3 672700.322\nGO ");
    doublet(&read(&alone).unwrap(), "commands");
    // Of object and film, too.
    let ends = CODE_V
        .replace("SO    0.0 0.1e11\n", "SO\n THI 0.1e11\n")
        .replace("SI    0.0 0.1", "SI\n THI 0.1");
    doublet(&read(&ends).unwrap(), "ends");
    let curved_film = read(&CODE_V.replace("SI    0.0 0.1", "SI 0.0 0.1\nRDY SI -30")).unwrap();
    let text = "radius of -30.0000 mm: it is flat here";
    assert!(
        curved_film
            .warnings
            .iter()
            .any(|w| w.message.contains(text)),
        "{:?}",
        curved_film.warnings
    );
    let inches = read(&CODE_V.replace("DIM   M", "DIM I")).unwrap();
    assert!((inches.surfaces[1].radius - 61.47 * 25.4).abs() < 1e-9);
    for (from, to, expected) in [
        (
            "-43.47 2.5 672700.322",
            "-43.47 2.5 REFL",
            "surface 3: mirrors",
        ),
        (
            "-43.47 2.5 672700.322",
            "-43.47 2.5 UNOBTAINIUM_X",
            "unknown glass UNOBTAINIUM",
        ),
        ("  CCY 0", "  ADE 5.0", "surface 3 is tilted or decentered"),
        ("  CCY 0", "  CYL", "surface 3: a cylinder"),
        ("  CCY 0", "  J 1e-20", "term of r^20"),
        ("CIR 12.0", "CIR OBS 2.0", "surface 2: obscurations"),
        ("61.47 6.0", "x 6.0", "expected a radius"),
        ("  CCY 0", "  ZDE 2", "surface 3 is tilted or decentered"),
        ("GO ", "SCA 2\nGO ", "SCA changes the lens"),
        ("GO ", "GLA SO 333000.550\nGO ", "the object lies in"),
        ("0.0 0.1e11", "0.0 0.1e11 333000.550", "the object lies in"),
        ("DIM   M", "DIM F", "unit F"),
    ] {
        let error = messages(read(&CODE_V.replacen(from, to, 1)).unwrap_err());
        assert!(error.contains(expected), "{to}: {error}");
    }
    assert!(matches!(
        read("RDM\nEPD 3\n"),
        Err(PrescriptionError::Empty)
    ));
}

const OSLO: &str = "// OSLO 6.6 58447     0     0\nLEN NEW \"Doublet\" 100 5\nEBR  9.0\nANG  2.0\nDES  \"OSLO\"\nUNI  1.0\n// SRF 0\nAIR\nTH   1.0e+20\nAP   3.5e+18\n\
    NXT  // SRF 1\nAIR\nTH   3.0\nAP CHK 9.0\nAST\nNXT  // SRF 2\nGLA N-BK7\nRD   61.47\nTH   6.0\nAP   12.0\nNXT  // SRF 3\nWV 0.58756 0.48613 0.65627\n\
    GLA MOD FLINT      1.6727 1.6874 1.6665\nRD   -43.47; TH 2.5\nTCE  236.0\nAP   12.0\nNXT  // SRF 4\nAIR\nCV   -0.008\nCC -0.5\nAD 2e-7\nAE -1e-10\nTH   95.9\nAP   12.5\n\
    NXT  // SRF 5\nAIR\nWV 0.58756 0.48613 0.65627\nWW 1.0 1.0 1.0\nEND  5\nRFL\n";

#[test]
fn an_oslo_file_is_read() {
    let read = |text: &str| oslo::parse(text, &Glasses::COMMON);
    let lens = read(OSLO).unwrap();
    doublet(&lens, "oslo");
    // From three indices: (1.6727 − 1)/0.0209.
    assert!(
        (lens.surfaces[2].abbe.unwrap() - 32.19).abs() < 0.05,
        "{:?}",
        lens.surfaces[2].abbe
    );
    let inches = read(&OSLO.replace("UNI  1.0", "UNI 25.4")).unwrap();
    assert!((inches.surfaces[1].radius - 61.47 * 25.4).abs() < 1e-9);
    for (from, to, expected) in [
        ("TCE  236.0", "RFL", "surface 3: a mirror"),
        ("TCE  236.0", "TLA 3.0", "surface 3 is tilted"),
        ("TCE  236.0", "PK CV 1", "surface 3: pickups"),
        ("TCE  236.0", "PFL 100", "surface 3: an ideal lens"),
        ("TCE  236.0", "APN 1", "surface 3: special apertures"),
        ("// SRF 0\nAIR", "GLA N-BK7", "the object lies in N-BK7"),
        ("GLA N-BK7", "GLA NONE", "surface 2: unknown glass NONE"),
        ("RD   61.47", "RD x", "expected a radius"),
    ] {
        let error = messages(read(&OSLO.replacen(from, to, 1)).unwrap_err());
        assert!(error.contains(expected), "{to}: {error}");
    }
    // Left to the rays: the axial beam of 9 mm, and 2° more where it is 3 mm behind the stop.
    let open = read(&OSLO.replace("AP   12.0\nNXT  // SRF 3", "NXT")).unwrap();
    let radius = 0.5 * open.surfaces[1].aperture;
    assert!(
        (radius - 9.0 - 3.7 * 2f64.to_radians().tan()).abs() < 0.03,
        "{radius}"
    );
}

const OPTICAL_BENCH: &str = "[descriptive data]\ntitle\tDoublet\n[constants]\nBack Focus\t1\n[variable distances]\nFocal Length\t100\t99\nAngle of View\t4\t4\nF-Number\t5.6\n\
    Magnification\t0\t-0.1\nd0\tInfinity\t1000\nd1\t3.0\t4.0\nBf\t95.9\t105\n[lens data]\n1\tAS\td1\t\t18\n2\t61.47\t6\t1.5168\t24\t64.2\tN-BK7\tSchott\n\
    3\t-43.47\t2.5\t1.6727\t24\t32.2\n4*\t-125\tBf\t\t25\n[aspherical data]\n4*\t-125\t-0.5\t2e-7\t-1e-10\n[figure]\nx\n";

#[test]
fn an_optical_bench_table_is_read() {
    let read = |text: &str| optbench::parse(text, &Glasses::COMMON);
    let lens = read(OPTICAL_BENCH).unwrap();
    doublet(&lens, "optical bench");
    // Two positions of one focal length: groups that focus, at d0 + lens + Bf from the film.
    let near = lens.at_position(None, 1000.0 + 4.0 + 8.5 + 105.0).unwrap();
    assert_eq!(
        (near.surfaces[0].thickness, near.film_distance),
        (4.0, 105.0)
    );
    let zoom = OPTICAL_BENCH
        .replace("Focal Length\t100\t99", "Focal Length\t100\t150")
        .replace("Infinity\t1000", "Infinity\tInfinity");
    let zoom = read(&zoom).unwrap();
    assert_eq!(zoom.positions.as_ref().unwrap().zooms(), [100.0, 150.0]);
    assert_eq!(
        zoom.at_position(Some(150.0), f64::INFINITY)
            .unwrap()
            .film_distance,
        105.0
    );
    let fixed = read(
        &OPTICAL_BENCH
            .replace("d1\t3.0\t4.0", "d1\t3.0\t3.0")
            .replace("95.9\t105", "95.9"),
    )
    .unwrap();
    assert!(fixed.positions.is_none());
    // Odd terms between the even ones, which have to be 0.
    let odd = |terms: &str| {
        let text = OPTICAL_BENCH.replace("Back Focus\t1", "AsphericalOddCount\t2");
        read(&text.replace("2e-7\t-1e-10", terms))
    };
    doublet(&odd("0\t2e-7\t0\t-1e-10").unwrap(), "odd");
    assert!(messages(odd("1e-9\t2e-7").unwrap_err()).contains("term of r^3"));
    let second = OPTICAL_BENCH
        .replace("Back Focus\t1", "AsphericalA2")
        .replace("2e-7\t-1e-10", "0\t2e-7\t-1e-10");
    doublet(&read(&second).unwrap(), "A2");
    for (from, to, expected) in [
        ("2\t61.47\t6", "2\tXX\t6", "expected a radius"),
        ("2\t61.47\t6", "2\t61.47\td9", "expected a thickness"),
        ("4*\t-125\t-0.5", "7\t-125\t-0.5", "no row of [lens data]"),
        ("\t2e-7", "\tx", "expected a coefficient"),
    ] {
        let error = messages(read(&OPTICAL_BENCH.replacen(from, to, 1)).unwrap_err());
        assert!(error.contains(expected), "{to}: {error}");
    }
}

const ISET: &str = r#"{"name": "doublet", "description": "multi element lens", "type": "multi element lens", "surfaces": [
 {"radius": 0, "thickness": 3, "ior": 0, "semi_aperture": 9},
 {"radius": 61.47, "thickness": 6, "ior": 1.5168, "semi_aperture": 12},
 {"radius": [-43.47, -43.47], "thickness": 2.5, "ior": 1.6727, "semi_aperture": [12, 12]},
 {"radius": -125, "thickness": 95.9, "ior": 1, "semi_aperture": 12.5, "conic_constant": -0.5, "aspheric_terms": [0, 2e-7, -1e-10]}
], "metadata": {"focalLength": 0.1, "fNumber": 10}}"#;

#[test]
fn isets_json_and_its_table_are_read() {
    doublet(&json::parse(ISET).unwrap(), "json");
    let meters = ISET.replacen("\"name\"", "\"units\": \"m\", \"name\"", 1);
    assert_eq!(json::parse(&meters).unwrap().surfaces[1].radius, 61470.0);
    for (from, to, expected) in [
        ("[-43.47, -43.47]", "[-43.47, -44]", "two meridians"),
        ("\"ior\": 1.5168", "\"ior\": 0.5", "an ior of 0.5"),
        ("61.47", "1e-9", "radius of at least"),
        (
            "\"semi_aperture\": 12}",
            "\"semi_aperture\": 0}",
            "positive semi_aperture",
        ),
        ("\"surfaces\"", "\"nothing\"", "missing field `surfaces`"),
        ("\"radius\": 0,", "\"radius\": }", "expected value"),
        (
            "\"name\"",
            "\"units\": \"furlong\", \"name\"",
            "units furlong",
        ),
    ] {
        let error = messages(json::parse(&ISET.replacen(from, to, 1)).unwrap_err());
        assert!(error.contains(expected), "{to}: {error}");
    }
    let table = "# Name: doublet\n# Focal length (mm) \n100.000\n#    radius\t axpos\tN\taperture\n0\t3\t0\t18\n61.47\t6\t1.5168\t24\n-43.47\t2.5\t1.6727\t24\n-125\t95.9\t1\t25 k=-0.5 A4=2e-7 A6=-1e-10\n";
    doublet(&Prescription::parse(table).unwrap(), "table");
}

/// By their endings, and what has another by its content.
#[test]
fn files_are_told_apart() {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in [
        ("a.seq", CODE_V),
        ("a.LEN", OSLO),
        ("a.txt", OPTICAL_BENCH),
        ("a.dat", OPTICAL_BENCH),
        ("a.json", ISET),
        ("a.dat", ISET),
    ] {
        let file = folder.path().join(name);
        std::fs::write(&file, text).unwrap();
        doublet(&Prescription::read(&file).unwrap(), name);
    }
    let optiland = folder.path().join("o.json");
    std::fs::write(&optiland, include_str!("lenses/optiland.json")).unwrap();
    assert_eq!(Prescription::read(&optiland).unwrap().surfaces.len(), 6);
    // A catalogue beside the lens.
    let zemax = "MODE SEQ\nSURF 0\n DISZ INFINITY\nSURF 1\n CURV 0.02\n DISZ 5\n GLAS OWN 0 0 1.5 40\n DIAM 5\nSURF 2\n DISZ 9\n DIAM 5\nSURF 3\n";
    let file = folder.path().join("z.zmx");
    std::fs::write(&file, zemax).unwrap();
    assert!(messages(Prescription::read(&file).unwrap_err()).contains("unknown glass OWN"));
    std::fs::write(folder.path().join("own.agf"), "NM OWN 5 0\nCD 1.6\n").unwrap();
    assert_eq!(Prescription::read(&file).unwrap().surfaces[0].index, 1.6);
    assert!(zmx::parse(zemax, &Glasses::COMMON).is_err());
}
