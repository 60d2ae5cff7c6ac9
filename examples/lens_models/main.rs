//! Writes `docs/lens-models.md` and `docs/lens-models.svg`: error and time of every lens model for every lens in
//! `tests/golden`.
//!
//! `cargo run --release --example lens_models`

#![allow(clippy::print_stderr)]

mod figure;

use figure::{Axis, Point};
use fstop::cameras::BUNDLE;
use fstop::math::Vec2;
use fstop::optics::lanes::{Instructions, Lanes};
use fstop::optics::models::{LensModel, ModelError, ModelKind, Models};
use fstop::optics::pupil::RINGS;
use fstop::optics::{ExitPupil, Lens, LensRay, Prescription};
use std::error::Error;
use std::fmt::Write;
use std::hint::black_box;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// mm: a full-frame sensor of 6000 × 4000.
const PIXEL: f64 = 0.006;

const KINDS: [ModelKind; 9] = [
    ModelKind::Exact,
    ModelKind::Polynomial(9),
    ModelKind::Polynomial(7),
    ModelKind::Polynomial(5),
    ModelKind::Polynomial(3),
    ModelKind::Table(5),
    ModelKind::Table(3),
    ModelKind::Table(1),
    ModelKind::Thick,
];

const TOLERANCES: [f64; 5] = [20.0, 5.0, 1.0, 0.5, 0.1];

fn main() -> Result<(), Box<dyn Error>> {
    let root = PathBuf::from(env!("CARGO_MANIFEST_DIR"));
    let mut lenses: Vec<PathBuf> = std::fs::read_dir(root.join("tests/golden"))?
        .filter_map(|entry| Some(entry.ok()?.path()))
        .filter(|path| path.extension().is_some_and(|e| e == "dat"))
        // Even aspheres, which the prescription has no room for.
        .filter(|path| path.file_stem().is_some_and(|s| s != "noct_58_f0.95"))
        .collect();
    lenses.sort();
    let mut table = String::new();
    let mut choices = String::new();
    let mut alone = String::new();
    let mut points = Vec::new();
    for path in &lenses {
        for (name, scale) in [("full", 1.0), ("/4", 0.25)] {
            let setting = Setting::read(path, scale)?;
            let label = format!(
                "{} {name}",
                path.file_stem().unwrap_or_default().to_string_lossy()
            );
            eprintln!("{label}");
            setting.report(&label, &mut table, &mut choices, &mut alone, &mut points)?;
        }
    }
    let text = format!(
        "{INTRODUCTION}\nInstructions: {}; bundles of {LANES}.\n\n{HEADER}{table}\n{CHOICES}{choices}\n{ALONE}{alone}\n{CONCLUSION}",
        Instructions::best(LANES).name()
    );
    std::fs::write(root.join("docs/lens-models.md"), text)?;
    let x = Axis {
        title: "99th percentile error, pixels (f64 tracing, right to 1e-9, is drawn at the left end)",
        low: -4,
        high: 3,
    };
    let y = Axis {
        title: "time per useful ray, ns",
        low: 1,
        high: 3,
    };
    let svg = figure::scatter(&points, [x, y]);
    std::fs::write(root.join("docs/lens-models.svg"), svg)?;
    Ok(())
}

/// A lens, its stop set, focused at infinity.
struct Setting {
    lens: Lens,
    film_radius: f64,
}

impl Setting {
    fn read(path: &Path, scale: f64) -> Result<Setting, Box<dyn Error>> {
        let mut prescription = Prescription::read(path)?;
        for s in prescription.surfaces.iter_mut().filter(|s| s.is_stop) {
            s.aperture *= scale;
        }
        let golden: serde_json::Value =
            serde_json::from_str(&std::fs::read_to_string(path.with_extension("json"))?)?;
        let film_radius = golden["image_radius"].as_f64().ok_or("no image_radius")?;
        let film_distance = Lens::focused(&prescription, f64::INFINITY)?;
        Ok(Setting {
            lens: Lens::new(&prescription, film_distance)?,
            film_radius,
        })
    }

    fn report(
        &self,
        label: &str,
        table: &mut String,
        choices: &mut String,
        alone_table: &mut String,
        points: &mut Vec<Point>,
    ) -> Result<(), Box<dyn Error>> {
        let pupil = ExitPupil::new(&self.lens, self.film_radius, RINGS);
        let start = Instant::now();
        let models = Models::new(&self.lens, &pupil, self.film_radius);
        let measuring = start.elapsed().as_secs_f64();
        write!(table, "| {label} | {} |", self.lens.surfaces().len())?;
        write!(alone_table, "| {label} |")?;
        let mut slowest: f64 = 0.0;
        for kind in KINDS {
            let start = Instant::now();
            let model = models.model(kind)?;
            slowest = slowest.max(measuring + start.elapsed().as_secs_f64());
            let error = models.error(&model, PIXEL).ok_or("dark")?;
            let (alone, useful) = (
                trace_time(&models, &pupil, &model),
                useful_time(&models, &pupil, &model),
            );
            let single = alone_time(&models, &pupil, &model);
            write!(alone_table, " {single:.0} |")?;
            if kind == ModelKind::Exact {
                write!(alone_table, " {useful:.0} | {:.1} |", single / useful)?;
            }
            let mut point = |series: String, error: f64, ns: f64| {
                points.push(measured(label, series, [error, ns]));
            };
            let exact = kind == ModelKind::Exact;
            let double = if exact { 1e-9 } else { error.p99 };
            point(format!("{kind}, f64, one at a time"), double, single);
            point(
                format!("{kind}, f32 lanes"),
                self.lanes_error(&models, &pupil, &model),
                useful,
            );
            write!(
                table,
                " {} · {alone:.0}, {useful:.0} |",
                errors(kind, &error)
            )?;
        }
        self.thin(label, &models, &pupil, points)?;
        writeln!(table, " {:.2} |", slowest)?;
        write!(choices, "| {label} |")?;
        for tolerance in TOLERANCES {
            let choice = models.choose(tolerance, PIXEL)?;
            write!(choices, " {} |", choice.model.kind())?;
        }
        writeln!(choices)?;
        writeln!(alone_table)?;
        Ok(())
    }

    /// The points of the thin model, which is in no table: it aims at a disk of its own, and maps its rays as `thick`
    /// does, single precision or double.
    fn thin(
        &self,
        label: &str,
        models: &Models,
        pupil: &ExitPupil,
        points: &mut Vec<Point>,
    ) -> Result<(), Box<dyn Error>> {
        let model = models.model(ModelKind::Thin)?;
        let error = models.error(&model, PIXEL).ok_or("dark")?.p99;
        for (series, ns) in [
            ("thin, f32 lanes", useful_time(models, pupil, &model)),
            (
                "thin, f64, one at a time",
                alone_time(models, pupil, &model),
            ),
        ] {
            points.push(measured(label, series.into(), [error, ns]));
        }
        Ok(())
    }

    /// 99th percentile, in pixels, of the error in lanes, rounding included.
    fn lanes_error(&self, models: &Models, pupil: &ExitPupil, model: &LensModel) -> f64 {
        let mut errors = Vec::new();
        for (film, point) in aims(models, pupil) {
            let traced = model.trace_lanes(&film, &point);
            for i in 0..LANES {
                let film = film.map(|x| f64::from(x.0[i]));
                let at = [
                    f64::from(point[0].0[i]),
                    f64::from(point[1].0[i]),
                    pupil.plane_z(),
                ];
                if let (Some(ray), Ok(exact)) = (traced.get(i), self.lens.trace_from_film(film, at))
                {
                    let ray = LensRay {
                        o: ray.o.map(f64::from),
                        d: ray.d.map(f64::from),
                    };
                    errors.push(models.ray_error(&exact, &ray) / PIXEL);
                }
            }
        }
        errors.sort_by(f64::total_cmp);
        errors.get(errors.len() * 99 / 100).copied().unwrap_or(0.0)
    }
}

/// A point of the figure: error in pixels and time in ns of a lens.
fn measured(lens: &str, series: String, at: [f64; 2]) -> Point {
    Point {
        label: format!("{lens}, {series}: {:.1e} px, {:.0} ns", at[0], at[1]),
        hollow: series.contains("f64"),
        series,
        at,
    }
}

fn errors(kind: ModelKind, e: &ModelError) -> String {
    if kind == ModelKind::Exact {
        return "0".into();
    }
    let short = |x: f64| match x {
        _ if x >= 10.0 => format!("{x:.0}"),
        _ if x >= 1.0 => format!("{x:.1}"),
        _ if x >= 0.01 => format!("{x:.2}"),
        _ => format!("{x:.0e}"),
    };
    format!(
        "{}/{}/{} {:.1}%",
        short(e.rms),
        short(e.p99),
        short(e.max),
        100.0 * e.wrong_outcome
    )
}

/// As many as the camera traces together.
const LANES: usize = BUNDLE;
const BUNDLES: usize = 128;

type Points = [Lanes<LANES>; 2];

/// Film points and numbers for the pupil.
fn samples(models: &Models) -> Vec<(Points, Points)> {
    (0..BUNDLES)
        .map(|b| {
            let s: [_; LANES] = std::array::from_fn(|i| models.sample(b * LANES + i));
            let lane = |f: &dyn Fn(usize) -> f32| Lanes(std::array::from_fn(f));
            (
                [lane(&|i| s[i].0[0] as f32), lane(&|i| s[i].0[1] as f32)],
                [lane(&|i| s[i].1.x), lane(&|i| s[i].1.y)],
            )
        })
        .collect()
}

/// Film points and pupil points.
fn aims(models: &Models, pupil: &ExitPupil) -> Vec<(Points, Points)> {
    samples(models)
        .into_iter()
        .map(|(film, u)| {
            let point = |i: usize| {
                let at = [f64::from(film[0].0[i]), f64::from(film[1].0[i])];
                let u = Vec2::new(u[0].0[i], u[1].0[i]);
                pupil
                    .sample(at, u)
                    .map_or([0.0; 2], |p| [p.point[0] as f32, p.point[1] as f32])
            };
            let p: [[f32; 2]; LANES] = std::array::from_fn(point);
            (film, [Lanes(p.map(|p| p[0])), Lanes(p.map(|p| p[1]))])
        })
        .collect()
}

/// ns for a ray from film point to scene, vignetted or not.
fn trace_time(models: &Models, pupil: &ExitPupil, model: &LensModel) -> f64 {
    let aims = aims(models, pupil);
    shortest(|| {
        for (film, point) in &aims {
            black_box(model.trace_lanes(film, point));
        }
        BUNDLES * LANES
    })
}

/// ns for a ray that passes, pupil sampled, traced and weighted, in f64 one at a time.
fn alone_time(models: &Models, pupil: &ExitPupil, model: &LensModel) -> f64 {
    let samples: Vec<([f64; 2], Vec2)> = (0..BUNDLES * 8).map(|i| models.sample(i)).collect();
    shortest(|| {
        let mut passed = 0;
        for (film, u) in &samples {
            let Some(aim) = model.sample_pupil(pupil, *film, *u) else {
                continue;
            };
            if let Ok(ray) = model.trace_from_film(*film, aim.point) {
                black_box((ray, pupil.projected_solid_angle(*film, &aim)));
                passed += 1;
            }
        }
        passed
    })
}

/// ns for a ray that passes: pupil sampled, traced, weighted.
fn useful_time(models: &Models, pupil: &ExitPupil, model: &LensModel) -> f64 {
    let samples = samples(models);
    shortest(|| {
        let mut passed = 0;
        for (film, u) in &samples {
            passed += black_box(model.rays(pupil, film, u)).traced.passed.count() as usize;
        }
        passed
    })
}

/// The shortest time of many, over what was done: others share the processor.
fn shortest(mut f: impl FnMut() -> usize) -> f64 {
    (0..40).fold(f64::INFINITY, |best, _| {
        let start = Instant::now();
        let count = f();
        best.min(start.elapsed().as_secs_f64() * 1e9 / count.max(1) as f64)
    })
}

const INTRODUCTION: &str = "# Lens models: error and time

Written by `cargo run --release --example lens_models`. Lenses of `tests/golden`, focused at infinity, stop full and at
a quarter of its diameter, over the whole image circle; pixels of 6 µm (6000 × 4000 on full frame).

Each entry: rms/99th percentile/largest error in pixels, share of rays whose outcome (passed or blocked) is wrong · ns a
ray for film point to scene, ns a useful ray (pupil sampled, traced, weighted; those that pass counted).
`Fit`: measuring the pupil, tracing and fitting the slowest of the models, in seconds.

![time per useful ray against error](lens-models.svg)
";

const HEADER: &str =
    "| lens | rows | exact | polynomial 9 | 7 | 5 | 3 | table 5 | 3 | 1 | thick | fit s |
|---|---|---|---|---|---|---|---|---|---|---|---|
";

const CHOICES: &str = "## What `auto` takes

By tolerance of the 99th percentile, in pixels.

| lens | 20 | 5 | 1 | 0.5 | 0.1 |
|---|---|---|---|---|---|
";

const ALONE: &str = "## One ray at a time

ns a useful ray in f64, for what is not rendered in bundles; and how many times as fast lanes are.

| lens | exact | in lanes | ratio | polynomial 9 | 7 | 5 | 3 | table 5 | 3 | 1 | thick |
|---|---|---|---|---|---|---|---|---|---|---|---|
";

const CONCLUSION: &str = "## What it means

- In lanes, exact tracing costs about 1.05 ns a surface: 13 ns for the 11 rows of a double Gauss, 35 for the 33 of a zoom. A
  polynomial costs 11 (degree 3), 18 (5), 29 (7) or 46 ns (9), whatever the lens: it needs more numbers at once than
  there are registers. So exact tracing beats every polynomial of degree 9, and degree 7 but for the zoom;
  `auto` takes it wherever degree 5 (from 17 rows on), degree 3 (from 9) or `thick` is not enough.
- Sampling the pupil and weighing costs 8 ns with every model: a useful ray takes 17 to 43 ns exactly, 21 through a double Gauss,
  and 19 with a polynomial of degree 3, which is off by several pixels. Exact is the default for good reason.
- Against the same in f64, one ray at a time, lanes are 14 (7 rows) to 20 times (33 rows) as fast.
- Tables of polynomials in the pupil cost 17 (degree 1) to 69 ns (5). `auto` keeps only degree 1 on its list, for long lenses
  with steep distortion.
- One at a time, polynomials cost 82 to 119 ns and exact tracing 230 to 870.
- `thick` and `thin` map rays alike; `thin` has its aperture in the principal plane, so it is not in the table of errors.
";
