//! The lenses.

use fstop::optics::{Lens, Prescription};

/// A lens and where its film is.
pub(super) struct Case {
    pub name: String,
    pub text: String,
    pub film_distance: f64,
}

pub(super) fn case(name: impl Into<String>, text: impl Into<String>, film_distance: f64) -> Case {
    Case {
        name: name.into(),
        text: text.into(),
        film_distance,
    }
}

/// Radii from a tenth of a millimeter to a thousand kilometers, both ways round, and planes.
pub(super) fn radii() -> Vec<Case> {
    let mut cases = vec![case("plane", "inf 5 1.5 20\ninf 0 1 20\n", 50.0)];
    for exponent in -1..=9 {
        for side in [1.0, -1.0] {
            let radius = side * 10f64.powi(exponent);
            let aperture = (1.8 * radius.abs()).min(20.0);
            let thickness = 0.2 * aperture;
            cases.push(case(
                format!("radius {radius}"),
                format!(
                    "{radius} {thickness} 1.5 {aperture}\n{} 0 1 {aperture}\n",
                    -2.0 * radius
                ),
                2.5 * aperture,
            ));
        }
    }
    cases
}

pub(super) fn apertures() -> Vec<Case> {
    let scaled = |aperture: f64| {
        let a = aperture;
        let text = format!(
            "{} {} 1.5 {a}\n{} 0 1 {a}\n0 {} 0 {a}\n",
            3.0 * a,
            0.3 * a,
            -4.0 * a,
            0.1 * a
        );
        case(format!("aperture {a}"), text, 2.0 * a)
    };
    let tiny = |aperture: f64| {
        let text = format!("50 5 1.5 20\n-50 2 1 20\n0 0 0 {aperture}\n");
        case(format!("stop {aperture} of a lens of 20"), text, 45.0)
    };
    [1e-3, 1e-2, 1.0, 1e2, 1e3]
        .map(scaled)
        .into_iter()
        .chain([1e-3, 1e-1, 1e3].map(tiny))
        .collect()
}

pub(super) fn thicknesses() -> Vec<Case> {
    vec![
        case(
            "cemented",
            "60 8 1.6 30\n-40 0 1.6 30\n-40 2 1.7 30\n-200 0 1 30\n",
            80.0,
        ),
        case("no thickness at all", "60 0 1.6 30\n-60 0 1 30\n", 50.0),
        case("thickness 1e5", "1e5 1e5 1.5 500\n-1e5 0 1 500\n", 1e5),
        case(
            "air space 1e5",
            "inf 5 1.5 50\ninf 1e5 1 50\n1e5 5 1.5 500\ninf 0 1 500\n",
            2e5,
        ),
        case(
            "negative thickness",
            "50 -3 1 20\n60 5 1.5 20\n-60 0 1 20\n",
            50.0,
        ),
    ]
}

pub(super) fn indices() -> Vec<Case> {
    [1.0, 1.0000001, 4.0, 6.0]
        .map(|n| {
            case(
                format!("index {n}"),
                format!("30 5 {n} 20\n40 0 1 20\n"),
                8.0,
            )
        })
        .into()
}

pub(super) fn films() -> Vec<Case> {
    const LENS: &str = "50 5 1.5168 20\n-50 2 1 20\n0 3 0 10\n60 4 1.62 20\n-45 0 1 20\n";
    [1e-6, 1e-3, 1e6]
        .map(|d| case(format!("film {d} mm behind"), LENS, d))
        .into()
}

pub(super) fn counts() -> Vec<Case> {
    let window = "inf 0.01 1.5 30\ninf 0.01 1 30\n".repeat(100);
    let relay = "90 4 1.5 40\n-90 40 1 40\n".repeat(100);
    vec![
        case("no stop", "50 5 1.5 20\n-50 0 1 20\n", 45.0),
        case(
            "two stops",
            "50 5 1.5 30\n-50 2 1 30\n0 6 0 9\n0 0 0 8\n",
            30.0,
        ),
        case("one surface", "60 0 1.5 20\n", 40.0),
        case("one stop", "0 0 0 5\n", 40.0),
        case("200 surfaces of windows", window, 20.0),
        case("200 surfaces of lenses", relay, 40.0),
        case("surfaces that cross", "20 1 1.5 25\n-20 0 1 25\n", 15.0),
        case(
            "surfaces that cross, concave",
            "-20 1 1.5 25\n20 1 1 25\n-30 0 1 25\n",
            15.0,
        ),
    ]
}

pub(super) fn all() -> impl Iterator<Item = Case> {
    [
        radii(),
        apertures(),
        thicknesses(),
        indices(),
        films(),
        counts(),
    ]
    .into_iter()
    .flatten()
}

impl Case {
    pub(super) fn prescription(&self) -> Prescription {
        prescription(&self.text)
    }

    pub(super) fn lens(&self) -> Lens {
        Lens::new(&self.prescription(), self.film_distance).expect("a film behind the lens")
    }
}

pub(super) fn prescription(text: &str) -> Prescription {
    Prescription::parse(text).unwrap_or_else(|e| panic!("{text}: {e}"))
}
