//! Lenses, films, distances and rays at the ends of what can be written down: each gives a right answer, measured
//! against a closed form or 32 digits (`exact_optics`), or a clear error; never a panic, a hang or a NaN.
//!
//! "Right" is meant as numerical analysts do: an answer is as good as the data when it differs from the exact one no
//! more than exact answers for data that are off by a few roundings do ([`Neighbourhood`]). That holds however
//! ill-conditioned the question is, and is as strict as can be where it is not.

mod exact_optics;

use exact_optics::dd::Dd;
use exact_optics::{ExactLens, Outcome};
use fstop::math::Vec2;
use fstop::optics::lanes::{FilmTracer, Lanes};
use fstop::optics::pupil::RINGS;
use fstop::optics::real::{Plain, Real};
use fstop::optics::{
    Cause, ExitPupil, FocusError, Lens, LensRay, LensTracer, Paraxial, Prescription, Surface,
    best_focus, focus,
};
use proptest::prelude::*;

fn prescription(text: &str) -> Prescription {
    Prescription::parse(text).unwrap_or_else(|e| panic!("{text}: {e}"))
}

/// A lens and where its film is.
struct Case {
    name: String,
    text: String,
    film_distance: f64,
}

fn case(name: impl Into<String>, text: impl Into<String>, film_distance: f64) -> Case {
    Case {
        name: name.into(),
        text: text.into(),
        film_distance,
    }
}

/// Radii from a tenth of a millimetre to a thousand kilometres, both ways round, and planes.
fn radii() -> Vec<Case> {
    let mut cases = vec![case("plane", "inf 5 1.5 20\ninf 0 1 20\n", 50.0)];
    for exponent in -1..=9 {
        for side in [1.0, -1.0] {
            let radius = side * 10f64.powi(exponent);
            let aperture = (1.8 * radius.abs()).min(20.0);
            let thickness = 0.2 * aperture;
            cases.push(case(
                format!("radius {radius}"),
                format!("{radius} {thickness} 1.5 {aperture}\n{} 0 1 {aperture}\n", -2.0 * radius),
                2.5 * aperture,
            ));
        }
    }
    cases
}

fn apertures() -> Vec<Case> {
    let scaled = |aperture: f64| {
        let a = aperture;
        let text = format!("{} {} 1.5 {a}\n{} 0 1 {a}\n0 {} 0 {a}\n", 3.0 * a, 0.3 * a, -4.0 * a, 0.1 * a);
        case(format!("aperture {a}"), text, 2.0 * a)
    };
    let tiny = |aperture: f64| {
        let text = format!("50 5 1.5 20\n-50 2 1 20\n0 0 0 {aperture}\n");
        case(format!("stop {aperture} of a lens of 20"), text, 45.0)
    };
    [1e-3, 1e-2, 1.0, 1e2, 1e3].map(scaled).into_iter().chain([1e-3, 1e-1, 1e3].map(tiny)).collect()
}

fn thicknesses() -> Vec<Case> {
    vec![
        case("cemented", "60 8 1.6 30\n-40 0 1.6 30\n-40 2 1.7 30\n-200 0 1 30\n", 80.0),
        case("no thickness at all", "60 0 1.6 30\n-60 0 1 30\n", 50.0),
        case("thickness 1e5", "1e5 1e5 1.5 500\n-1e5 0 1 500\n", 1e5),
        case("air space 1e5", "inf 5 1.5 50\ninf 1e5 1 50\n1e5 5 1.5 500\ninf 0 1 500\n", 2e5),
        case("negative thickness", "50 -3 1 20\n60 5 1.5 20\n-60 0 1 20\n", 50.0),
    ]
}

fn indices() -> Vec<Case> {
    [1.0, 1.0000001, 4.0, 6.0]
        .map(|n| case(format!("index {n}"), format!("30 5 {n} 20\n40 0 1 20\n"), 8.0))
        .into()
}

fn films() -> Vec<Case> {
    const LENS: &str = "50 5 1.5168 20\n-50 2 1 20\n0 3 0 10\n60 4 1.62 20\n-45 0 1 20\n";
    [1e-6, 1e-3, 1e6].map(|d| case(format!("film {d} mm behind"), LENS, d)).into()
}

fn counts() -> Vec<Case> {
    let window = "inf 0.01 1.5 30\ninf 0.01 1 30\n".repeat(100);
    let relay = "90 4 1.5 40\n-90 40 1 40\n".repeat(100);
    vec![
        case("no stop", "50 5 1.5 20\n-50 0 1 20\n", 45.0),
        case("two stops", "50 5 1.5 30\n-50 2 1 30\n0 6 0 9\n0 0 0 8\n", 30.0),
        case("one surface", "60 0 1.5 20\n", 40.0),
        case("one stop", "0 0 0 5\n", 40.0),
        case("200 surfaces of windows", window, 20.0),
        case("200 surfaces of lenses", relay, 40.0),
        case("surfaces that cross", "20 1 1.5 25\n-20 0 1 25\n", 15.0),
        case("surfaces that cross, concave", "-20 1 1.5 25\n20 1 1 25\n-30 0 1 25\n", 15.0),
    ]
}

fn all() -> impl Iterator<Item = Case> {
    [radii(), apertures(), thicknesses(), indices(), films(), counts()].into_iter().flatten()
}

/// The exact answer, and those for data that are off by some roundings.
struct Neighbourhood {
    center: Outcome,
    shaken: Vec<Outcome>,
    /// Relative rounding of the number type.
    epsilon: f64,
}

/// Every number of lens and ray is off by this many roundings: what a few operations on each of them make.
const ROUNDINGS: f64 = 3.0;

/// Patterns of up and down that are tried.
const PATTERNS: u64 = 8;

impl Neighbourhood {
    /// Of the ray from `o` (z from the last vertex where `behind`) along `d`.
    fn new(lens: &ExactLens, o: [f64; 3], d: [f64; 3], behind: bool, epsilon: f64) -> Neighbourhood {
        let trace = |lens: &ExactLens, o: [f64; 3], d: [f64; 3]| {
            let mut o = o.map(Dd::from);
            if behind {
                o[2] = o[2] + lens.length();
            }
            lens.trace(o, d.map(Dd::from))
        };
        let by = ROUNDINGS * epsilon;
        let shaken = (1..=PATTERNS).map(|pattern| {
            let shake = |x: f64, bit: u64| x * if pattern >> bit & 1 == 0 { 1.0 + by } else { 1.0 - by };
            let o = [shake(o[0], 0), shake(o[1], 1), shake(o[2], 2)];
            let d = [shake(d[0], 1), shake(d[1], 2), shake(d[2], 0)];
            trace(&lens.shaken(by, pattern), o, d)
        });
        Neighbourhood { center: trace(lens, o, d), shaken: shaken.collect(), epsilon }
    }

    /// Is what was found one of these answers?
    fn holds(&self, found: Result<([f64; 3], [f64; 3]), Option<(usize, Cause)>>, length: f64) -> Result<(), String> {
        let outcomes = || std::iter::once(&self.center).chain(&self.shaken);
        let (o, d) = match (found, &self.center.end) {
            (Ok(ray), Ok(_)) => ray,
            // Lanes say that a ray ended, not where.
            (Err(None), _) if outcomes().any(|o| o.end.is_err()) => return Ok(()),
            (Err(Some(end)), _) if outcomes().any(|o| o.end.as_ref().is_err_and(|e| *e == end)) => return Ok(()),
            (Ok(_), Err(_)) if outcomes().any(|o| o.end.is_ok()) => return Ok(()),
            // On the edge of two things at once the patterns may all fall to one side.
            _ if self.center.margin < 4.0 * ROUNDINGS * self.epsilon => return Ok(()),
            _ => return Err(format!("found {found:?}, exact {:?}", self.center)),
        };
        let Ok(exact) = &self.center.end else { return Ok(()) };
        let difference = |a: [f64; 3], b: [Dd; 3]| -> f64 {
            (0..3).map(|i| (Dd::from(a[i]) - b[i]).hi.abs()).fold(0.0, f64::max)
        };
        let spread = |pick: fn(&([Dd; 3], [Dd; 3])) -> [Dd; 3]| -> f64 {
            let center = pick(exact);
            let passing = self.shaken.iter().filter_map(|o| o.end.as_ref().ok());
            passing.map(|other| difference(center.map(|x| x.hi), pick(other))).fold(0.0, f64::max)
        };
        let size = exact.0.iter().map(|x| x.hi.abs()).fold(length, f64::max);
        // The rounding of the answer itself comes on top, and z is a sum with the lens's length.
        let most = [2.0 * spread(|r| r.0) + 4.0 * self.epsilon * size, 2.0 * spread(|r| r.1) + 4.0 * self.epsilon];
        let errors = [difference(o, exact.0), difference(d, exact.1)];
        let right = errors.iter().zip(&most).all(|(error, most)| error <= most);
        right.then_some(()).ok_or_else(|| format!("off by {errors:?}, at most {most:?}: {o:?} {d:?}, exact {exact:?}"))
    }
}

/// Well-spread numbers from 0 to 1 (Roberts' R sequence in four dimensions, 2018).
fn spread(i: usize) -> [f64; 4] {
    std::array::from_fn(|k| (0.5 + (i + 1) as f64 / 1.167_303_978_261_418_7f64.powi(k as i32 + 1)).fract())
}

/// A film point, and a point of the rear vertex plane to aim at: most pass, some just do not.
fn aim(surfaces: &[Surface], film_distance: f64, i: usize) -> ([f64; 2], [f64; 2]) {
    let r = spread(i);
    let rear = surfaces[surfaces.len() - 1].clear_radius();
    let narrowest = surfaces.iter().map(Surface::clear_radius).fold(rear, f64::min);
    // A third of them anywhere on the rear element, a third through the size of the narrowest rim, a third near the axis
    // and not oblique.
    let (reach, film) = match i % 3 {
        0 => (1.05 * rear, film_distance.min(rear)),
        1 => (1.05 * narrowest, 0.2 * film_distance.min(rear)),
        _ => (0.5 * narrowest.min(film_distance), 0.01 * film_distance.min(narrowest)),
    };
    let at = |radius: f64, turn: f64| [radius * (6.3 * turn).cos(), radius * (6.3 * turn).sin()];
    (at(film * r[0].sqrt(), r[1]), at(reach * r[2].sqrt(), r[3]))
}

/// One ray in number type `B`, both directions.
fn trace_in<B: Plain + Real>(
    tracer: &LensTracer<B>,
    ray: &LensRay<f64>,
) -> (LensRay<f64>, Result<([f64; 3], [f64; 3]), Option<(usize, Cause)>>) {
    let rounded = LensRay { o: ray.o.map(B::round_from), d: ray.d.map(B::round_from) };
    let out = if ray.d[2] > 0.0 { tracer.to_film(&rounded) } else { tracer.to_scene(&rounded) };
    // What was traced is the rounded ray.
    let traced = LensRay { o: rounded.o.map(B::to_f64), d: rounded.d.map(B::to_f64) };
    let result = out.map(|r| (r.o.map(B::to_f64), r.d.map(B::to_f64)));
    (traced, result.map_err(|b| Some((b.surface, b.cause))))
}

const DOUBLE: f64 = f64::EPSILON / 2.0;
const SINGLE: f64 = f32::EPSILON as f64 / 2.0;

/// Traces `count` rays through the lens in f64, f32 and f32 lanes, and back; the number that passed in f64.
fn check_rays(name: &str, surfaces: &[Surface], film_distance: f64, count: usize) -> Result<usize, String> {
    let exact = ExactLens::new(surfaces);
    let length = exact.length().hi;
    let (double, single) = (LensTracer::<f64>::new(surfaces), LensTracer::<f32>::new(surfaces));
    let mut passed = 0;
    for i in 0..count {
        let (film, rear) = aim(surfaces, film_distance, i);
        let start = LensRay::through([film[0], film[1], length + film_distance], [rear[0], rear[1], length]);
        let (ray, found) = trace_in(&double, &start);
        let told = |what: &str, e: String| format!("{name}, {what}, ray {i} from {film:?} to {rear:?}: {e}");
        Neighbourhood::new(&exact, ray.o, ray.d, false, DOUBLE)
            .holds(found, length)
            .map_err(|e| told("f64", e))?;
        let (ray, narrow) = trace_in(&single, &start);
        Neighbourhood::new(&exact, ray.o, ray.d, false, SINGLE)
            .holds(narrow, length)
            .map_err(|e| told("f32", e))?;
        if let Ok((o, d)) = found {
            passed += 1;
            let back = LensRay { o, d: d.map(|x| -x) };
            let (ray, found) = trace_in(&double, &back);
            Neighbourhood::new(&exact, ray.o, ray.d, false, DOUBLE)
                .holds(found, length)
                .map_err(|e| told("f64 to the film", e))?;
            let (ray, narrow) = trace_in(&single, &back);
            Neighbourhood::new(&exact, ray.o, ray.d, false, SINGLE)
                .holds(narrow, length)
                .map_err(|e| told("f32 to the film", e))?;
        }
    }
    check_lanes(name, surfaces, film_distance, &exact, count)?;
    Ok(passed)
}

/// Bundles of rays by way of [`FilmTracer`], which aims from film to rear vertex plane.
fn check_lanes(name: &str, surfaces: &[Surface], film_distance: f64, exact: &ExactLens, count: usize) -> Result<(), String> {
    const N: usize = 8;
    let lens = Prescription { surfaces: surfaces.to_vec(), film_distance, warnings: Vec::new() };
    let lens = Lens::new(&lens, film_distance).map_err(|e| e.to_string())?;
    let tracer: FilmTracer = FilmTracer::new(&lens, lens.length());
    for bundle in 0..count / N {
        let mut film = [Lanes::<N>::splat(0.0); 2];
        let mut rear = film;
        for lane in 0..N {
            let (from, to) = aim(surfaces, film_distance, bundle * N + lane);
            for axis in 0..2 {
                film[axis].0[lane] = from[axis] as f32;
                rear[axis].0[lane] = to[axis] as f32;
            }
        }
        let traced = tracer.trace(&film, &rear);
        for lane in 0..N {
            let found = traced.get(lane).map(|r| (r.o.map(f64::from), r.d.map(f64::from))).ok_or(None);
            let o = [f64::from(film[0].0[lane]), f64::from(film[1].0[lane]), film_distance];
            let d = [f64::from(rear[0].0[lane]) - o[0], f64::from(rear[1].0[lane]) - o[1], -film_distance];
            let told = |e| format!("{name}, lane {lane} from {o:?} along {d:?}: {e}");
            Neighbourhood::new(exact, o, d, true, SINGLE).holds(found, exact.length().hi).map_err(told)?;
        }
    }
    Ok(())
}

#[test]
fn rays_are_right_to_rounding_in_every_extreme_lens() {
    for case in all() {
        let surfaces = prescription(&case.text).surfaces;
        let count = if surfaces.len() > 50 { 24 } else { 96 };
        let passed = check_rays(&case.name, &surfaces, case.film_distance, count).unwrap_or_else(|e| panic!("{e}"));
        assert!(passed >= count / 8, "{}: only {passed} of {count} rays passed", case.name);
    }
}
#[allow(unused)]
fn _use(_: FocusError, _: Paraxial, _: ExitPupil) { let _ = (RINGS, best_focus::film_distance, focus::plane_of_focus, Vec2::ZERO); }
