//! Focal length, pupils and focus against 32 digits, and the film of the smallest spot.

use super::cases::{self, Case, prescription};
use super::exact_optics::ExactLens;
use super::exact_optics::dd::Dd;
use super::neighborhood::{DOUBLE, PATTERNS, ROUNDINGS};
use super::rays::lens;
use fstop::optics::{
    FocusError, Lens, LensRay, LensTracer, Paraxial, Prescription, Surface, best_focus, focus,
};
use proptest::prelude::*;

/// Rounding of what is exact, mm: the difference of focal lengths of a million kilometers at most, in twice double precision.
const OF_EXACT: f64 = 1e-20;

/// Is `found` the value of `exact` for this lens, or for one that is off by a few roundings?
fn right(lens: &ExactLens, found: f64, exact: impl Fn(&ExactLens) -> Dd) -> Result<(), String> {
    let center = exact(lens);
    let by = ROUNDINGS * DOUBLE;
    let spread = (1..=PATTERNS)
        .map(|pattern| (exact(&lens.shaken(by, pattern)) - center).hi.abs())
        .fold(0.0, f64::max);
    // The matrix is rounded at every row, which the data are not. z is counted from the first vertex, so that what is not small itself has roundings of the lens's length.
    let most = (2.0 + lens.rows.len() as f64) * spread
        + (ROUNDINGS + lens.rows.len() as f64)
            * DOUBLE
            * center.hi.abs().max(lens.length().hi.abs())
        + OF_EXACT;
    let error = (Dd::from(found) - center).hi.abs();
    // What is not a number is not right; at a pole anything large is.
    let holds =
        error <= most || (!most.is_finite() && !found.is_nan()) || (spread > 0.1 * center.hi.abs());
    holds
        .then_some(())
        .ok_or_else(|| format!("{found}, exact {}, at most {most:e} off", center.hi))
}

/// The matrix from the first vertex plane to the vertex of row `i`, before it refracts.
fn to_row(lens: &ExactLens, i: usize) -> [Dd; 4] {
    if i == 0 {
        return [Dd::ONE, Dd::ZERO, Dd::ZERO, Dd::ONE];
    }
    let [a, b, c, d] = lens.matrix_of(0, i);
    let t = lens.rows[i - 1].thickness;
    [a + t * c, b + t * d, c, d]
}

fn absolute(x: Dd) -> Dd {
    if x.hi < 0.0 { -x } else { x }
}

/// Everything [`Paraxial`] says.
fn check_first_order(surfaces: &[Surface]) -> Result<(), String> {
    let (p, exact) = (Paraxial::new(surfaces), ExactLens::new(surfaces));
    let told = |what: &'static str| move |e: String| format!("{what}: {e}");
    // n'u' of a parallel ray at height 1: 0 for an afocal lens.
    let power = |l: &ExactLens| -(l.rows[l.rows.len() - 1].index * l.matrix()[2]);
    match p.cardinals {
        None => {
            // A focal length of a million kilometers counts as none.
            let weak = power(&exact).hi.abs() <= 1.1e-12;
            let far = (l_over(&exact, 0)).max(l_over(&exact, 3)) >= 0.9e12;
            right(&exact, 0.0, power)
                .or_else(|e| if weak || far { Ok(()) } else { Err(e) })
                .map_err(told("no focal length"))?;
        }
        Some(c) => {
            let rear = |l: &ExactLens| -(l.matrix()[0] / l.matrix()[2]);
            let front = |l: &ExactLens| l.matrix()[3] / l.matrix()[2];
            let focal = |l: &ExactLens| Dd::ONE / power(l);
            let behind = |l: &ExactLens| l.rows[l.rows.len() - 1].index;
            right(&exact, c.focal_length, focal).map_err(told("focal length"))?;
            right(&exact, c.back_focal_distance, rear).map_err(told("back focal distance"))?;
            right(&exact, c.front_focal_point, front).map_err(told("front focal point"))?;
            right(&exact, c.rear_focal_point, |l| l.length() + rear(l))
                .map_err(told("rear focal point"))?;
            right(&exact, c.front_principal_plane, |l| front(l) + focal(l))
                .map_err(told("front principal plane"))?;
            right(&exact, c.rear_principal_plane, |l| {
                l.length() + rear(l) - behind(l) * focal(l)
            })
            .map_err(told("rear principal plane"))?;
        }
    }
    let clear = |l: &ExactLens| l.rows[p.stop].clear_radius * Dd::from(2.0);
    if let Some(pupil) = p.entrance_pupil {
        let matrix = |l: &ExactLens| to_row(l, p.stop);
        right(&exact, pupil.z, |l| matrix(l)[1] / matrix(l)[0]).map_err(told("entrance pupil"))?;
        right(&exact, pupil.diameter, |l| {
            clear(l) / absolute(matrix(l)[0])
        })
        .map_err(told("its diameter"))?;
    }
    if let Some(pupil) = p.exit_pupil {
        let matrix = |l: &ExactLens| l.matrix_of(p.stop, l.rows.len());
        right(&exact, pupil.z, |l| {
            l.length() - matrix(l)[1] / matrix(l)[3]
        })
        .map_err(told("exit pupil"))?;
        let magnification = |[a, b, c, d]: [Dd; 4]| absolute(a - b * c / d);
        right(&exact, pupil.diameter, |l| {
            clear(l) * magnification(matrix(l))
        })
        .map_err(told("its diameter"))?;
    }
    Ok(())
}

/// |matrix element over the power|: a focal distance.
fn l_over(lens: &ExactLens, element: usize) -> f64 {
    let matrix = lens.matrix();
    (matrix[element].hi / matrix[2].hi).abs()
}

#[test]
fn first_order_data_are_right_to_rounding() {
    for case in cases::all() {
        check_first_order(&case.prescription().surfaces)
            .unwrap_or_else(|e| panic!("{}: {e}", case.name));
    }
}

/// How far from the film at `q` mm behind the last vertex things are sharp.
fn sharp_distance(lens: &ExactLens, q: f64) -> Dd {
    let ([a, b, c, d], q) = (lens.matrix(), Dd::from(q));
    // From (0, z) through the lens to height 0 on the film.
    let z = (b + q * d) / (a + q * c);
    lens.length() + q - z
}

/// The film that is sharp at `distance` from itself: of two the one nearer the lens. Where there is none, that of the
/// least distance.
fn exact_film(lens: &ExactLens, distance: f64) -> Dd {
    // Of the object plane z = length + q − distance: (b − a z) + q (d − c z) = 0, a quadratic equation for q.
    let ([a, b, c, d], z) = (lens.matrix(), lens.length() - Dd::from(distance));
    let (half, rest) = ((a + c * z - d) * Dd::from(0.5), a * z - b);
    // c is negative where there is an image, so this is the smaller root.
    (-half + (half * half - c * rest).sqrt()) / c
}

/// The film for an object `distance` from it, or why there is none.
fn check_focus(prescription: &Prescription, distance: f64) -> Result<Option<f64>, String> {
    let surfaces = &prescription.surfaces;
    let lens = ExactLens::new(surfaces);
    let cardinals = Paraxial::new(surfaces).cardinals;
    match focus::film_distance_for_focus(cardinals, distance) {
        Ok(q) if distance.is_infinite() => {
            right(&lens, q, |l| -(l.matrix()[0] / l.matrix()[2]))
                .map_err(|e| format!("infinity: {e}"))?;
            Ok(Some(q))
        }
        Ok(q) => {
            if !(q > 0.0 && q.is_finite()) {
                return Err(format!("a film distance of {q}"));
            }
            right(&lens, q, |l| exact_film(l, distance))
                .map_err(|e| format!("focus at {distance}: film {e}"))?;
            Ok(Some(q))
        }
        Err(FocusError::TooNear { minimum, asked }) => {
            let no_nearer =
                (asked.is_nan() || asked < minimum * (1.0 + 1e-12)) && minimum.is_finite();
            no_nearer
                .then_some(None)
                .ok_or_else(|| format!("{asked} is not below {minimum}"))
        }
        Err(FocusError::NoImage { focal_length }) => {
            let none = focal_length.is_none_or(|f| f <= 0.0);
            none.then_some(None)
                .ok_or_else(|| format!("no image with {focal_length:?}"))
        }
        Err(FocusError::InsideLens { inside, .. }) => (inside >= 0.0 && inside.is_finite())
            .then_some(None)
            .ok_or_else(|| format!("{inside} inside")),
        // Of tilted films alone.
        Err(error @ FocusError::Unsettled { .. }) => Err(error.to_string()),
    }
}

#[test]
fn focusing_at_just_above_and_below_the_least_distance() {
    let mut focused = 0;
    for case in cases::all() {
        let prescription = case.prescription();
        let check = |distance: f64| {
            check_focus(&prescription, distance).unwrap_or_else(|e| panic!("{}: {e}", case.name))
        };
        let Ok(minimum) =
            focus::minimum_focus_distance(Paraxial::new(&prescription.surfaces).cardinals)
        else {
            for distance in [1.0, 1e3, f64::INFINITY] {
                assert_eq!(check(distance), None, "{}", case.name);
            }
            continue;
        };
        for factor in [1.0 + 1e-9, 1.0 + 1e-6, 1.1, 2.0, 1e3, 1e9, f64::INFINITY] {
            focused += usize::from(check(factor * minimum).is_some());
        }
        // At the least distance itself rounding decides whether it is one; the answer is right or says what is.
        for roundings in -8i32..=8 {
            check(minimum * (1.0 + f64::from(roundings) * f64::EPSILON));
        }
        for factor in [
            1.0 - 1e-9,
            0.5,
            1e-9,
            0.0,
            -1.0,
            f64::NAN,
            f64::NEG_INFINITY,
        ] {
            assert_eq!(check(factor * minimum), None, "{} {factor}", case.name);
        }
        // No film is sharp nearer than what is called the least distance.
        let exact = ExactLens::new(&prescription.surfaces);
        let bfd = Paraxial::new(&prescription.surfaces)
            .cardinals
            .map_or(0.0, |c| c.back_focal_distance);
        for factor in [1e-6, 1e-3, 0.1, 0.5, 1.0, 2.0, 10.0, 1e3] {
            let f = minimum / 4.0;
            let nearest = sharp_distance(&exact, bfd + factor * f).hi;
            assert!(
                nearest >= minimum * (1.0 - 1e-9),
                "{}: {nearest} {minimum}",
                case.name
            );
        }
    }
    assert!(focused > 100, "{focused}");
}

#[test]
fn the_smallest_spot_of_a_perfect_surface_is_its_focus() {
    // An ellipsoid of conic constant −1/n² unites all rays of a distant point in its far focus, nR/(n − 1) behind its
    // vertex (Born and Wolf §4.2.2): from a tenth of a millimeter to a thousand kilometers.
    for exponent in -1..=9 {
        for n in [1.3, 1.5, 4.0] {
            let radius = 10f64.powi(exponent);
            let text = format!("{radius} 0 {n} {radius} k={}\n", -1.0 / (n * n));
            let found =
                best_focus::film_distance(&prescription(&text), f64::INFINITY).expect("a focus");
            let exact = n * radius / (n - 1.0);
            // The index of the conic constant is rounded too.
            assert!(
                (found / exact - 1.0).abs() < 1e-9,
                "{text}: {found} {exact}"
            );
        }
    }
}

/// Mean square height on the film at `q` of the axial beam from `object_z`, by rays the same part of which pass.
fn spot(tracer: &LensTracer<f64>, object_z: f64, edge: f64, length: f64, q: f64) -> f64 {
    let count = 512;
    let squares = (0..count).filter_map(|i| {
        let y = edge * ((f64::from(i) + 0.5) / f64::from(count)).sqrt();
        let ray = if object_z.is_finite() {
            LensRay::through([0.0, 0.0, object_z], [0.0, y, 0.0])
        } else {
            LensRay {
                o: [0.0, y, 0.0],
                d: [0.0, 0.0, 1.0],
            }
        };
        let out = tracer.to_film(&ray).ok()?;
        let height = out.o[1] + (length + q - out.o[2]) * out.d[1] / out.d[2];
        Some(height * height)
    });
    squares.sum()
}

#[test]
fn the_smallest_spot_is_found_or_the_reason_told() {
    let mut found = 0;
    for Case { name, text, .. } in cases::all() {
        let prescription = prescription(&text);
        let tracer = LensTracer::<f64>::new(&prescription.surfaces);
        let length = prescription.length();
        for distance in [1.0, 100.0, 1e3, 1e6, f64::INFINITY] {
            let best = best_focus::film_distance(&prescription, distance);
            let gaussian = Lens::focused(&prescription, distance);
            let q = match (best, gaussian) {
                (Ok(q), Ok(_)) => q,
                (Err(e), _) => {
                    assert!(!e.to_string().contains("NaN"), "{name}: {e}");
                    continue;
                }
                (Ok(q), Err(e)) => panic!("{name}: {q} although {e}"),
            };
            assert!(q > 0.0 && q.is_finite(), "{name} {distance}: {q}");
            let object_z = length + q - distance;
            let edge = edge(&tracer, object_z);
            let spot = |q: f64| spot(&tracer, object_z, edge, length, q);
            let least = spot(q);
            // A hundredth of a millimeter either way, or what counts for such a lens.
            for shift in [-1e-4 * q, 1e-4 * q] {
                // Squares have twice the relative rounding, and rays start as far away as the object.
                assert!(
                    spot(q + shift) >= least * (1.0 - 1e-6),
                    "{name} {distance}: {q} {least:e}"
                );
            }
            found += 1;
        }
    }
    assert!(found > 60, "{found}");
}

/// The largest height on the first vertex plane up to which the rays from `object_z` pass, by halving.
fn edge(tracer: &LensTracer<f64>, object_z: f64) -> f64 {
    let passes = |y: f64| {
        let ray = if object_z.is_finite() {
            LensRay::through([0.0, 0.0, object_z], [0.0, y, 0.0])
        } else {
            LensRay {
                o: [0.0, y, 0.0],
                d: [0.0, 0.0, 1.0],
            }
        };
        tracer.to_film(&ray).is_ok()
    };
    let (mut low, mut high) = (0.0, 1e-6);
    while passes(high) && high < 1e6 {
        (low, high) = (high, 2.0 * high);
    }
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if passes(middle) {
            low = middle
        } else {
            high = middle
        }
    }
    low
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    /// Between the extremes too.
    #[test]
    fn first_order_data_and_focus_are_right_in_every_lens(
        surfaces in lens(1..10),
        distance in (-3.0..9.0f64).prop_map(|e| 10f64.powf(e)),
    ) {
        let prescription = Prescription { surfaces, film_distance: 0.0, positions: None, warnings: Vec::new() };
        check_first_order(&prescription.surfaces).map_err(TestCaseError::fail)?;
        check_focus(&prescription, distance).map_err(TestCaseError::fail)?;
        check_focus(&prescription, f64::INFINITY).map_err(TestCaseError::fail)?;
        if let Ok(q) = best_focus::film_distance(&prescription, distance) {
            prop_assert!(q > 0.0 && q.is_finite());
        }
    }
}
