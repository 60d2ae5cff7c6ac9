//! Error and time of every lens model for one lens, measured here and now.

use super::page::{cell, escaped, table};
use crate::optics::lanes::{Instructions, Lanes};
use crate::optics::models::{LensModel, ModelKind, Models};
use crate::optics::pupil::RINGS;
use crate::optics::{ExitPupil, Lens};
use std::hint::black_box;
use std::time::Instant;

/// Lanes in a bundle, as cameras trace them.
const BUNDLE: usize = 16;

/// Rays that are timed and, of exact lanes, compared.
const RAYS: usize = 8192;

/// The best of this many runs counts: what else the machine does can only slow one down.
const RUNS: usize = 5;

/// Pixels `auto` may be off.
const TOLERANCE: f64 = 0.1;

const KINDS: [ModelKind; 10] = [
    ModelKind::Polynomial(11),
    ModelKind::Polynomial(9),
    ModelKind::Polynomial(7),
    ModelKind::Polynomial(5),
    ModelKind::Polynomial(3),
    ModelKind::Table(5),
    ModelKind::Table(3),
    ModelKind::Table(1),
    ModelKind::Thick,
    ModelKind::Thin,
];

/// One model.
struct Row {
    name: String,
    /// Half and 99 of 100 rays are off by less than this many pixels.
    errors: Option<[f64; 2]>,
    /// Share of rays whose outcome (passed or blocked) is wrong, %.
    wrong: Option<f64>,
    /// ns a useful ray, from film point to weighted ray; those that pass counted.
    time: Option<f64>,
    /// Seconds to make the model.
    fit: Option<f64>,
}

/// All models of one lens.
pub struct ModelTable {
    rows: Vec<Row>,
    /// What `auto` takes, and why.
    choice: String,
    /// mm.
    pixel: f64,
}

impl ModelTable {
    /// Measures them over film heights up to `film_radius` mm, for pixels of `pixel` mm.
    pub fn measure(lens: &Lens, film_radius: f64, pixel: f64) -> ModelTable {
        let pupil = ExitPupil::new(lens, film_radius * (1.0 + 1e-6), RINGS);
        let start = Instant::now();
        let models = Models::new(lens, &pupil, film_radius);
        let measuring = start.elapsed().as_secs_f64();
        let bench = Bench {
            lens,
            pupil: &pupil,
            models: &models,
            pixel,
        };
        let mut rows = bench.exact();
        for kind in KINDS {
            let start = Instant::now();
            // A lens without such a model has no row for it.
            let Ok(model) = models.model(kind) else {
                continue;
            };
            let fit = measuring + start.elapsed().as_secs_f64();
            let error = models.error(&model, pixel);
            rows.push(Row {
                name: format!("{kind}, f32 lanes"),
                errors: error.map(|e| [e.p50, e.p99]),
                wrong: error.map(|e| 100.0 * e.wrong_outcome),
                time: bench.useful_time(&model),
                fit: Some(fit),
            });
        }
        let choice = models
            .choose(TOLERANCE, pixel)
            .map_or_else(|e| e.to_string(), |choice| choice.reason());
        ModelTable {
            rows,
            choice,
            pixel,
        }
    }

    /// As a section of the page.
    pub fn html(&self) -> String {
        let head = [
            "model",
            "error, median (px)",
            "99th percentile (px)",
            "wrong outcome (%)",
            "ns a useful ray",
            "fit (ms)",
        ];
        let pixels = |error: Option<f64>| {
            error.map_or_else(
                || "–".to_string(),
                |e| match e {
                    e if e >= 0.01 || e == 0.0 => format!("{e:.2}"),
                    e => format!("{e:.0e}"),
                },
            )
        };
        let rows = self.rows.iter().map(|row| {
            vec![
                row.name.clone(),
                pixels(row.errors.map(|e| e[0])),
                pixels(row.errors.map(|e| e[1])),
                cell(row.wrong, 2),
                cell(row.time, 0),
                cell(row.fit.map(|s| 1e3 * s), 0),
            ]
        });
        format!(
            "<section id=\"models\"><h2>Lens models</h2>\n{}<p>At {TOLERANCE} pixels <code>auto</code> takes {}.</p>\n\
             <p>Error: how far off in the picture a ray is, in pixels of {:.2} µm, over the whole image circle and pupil; times \
             measured when this page was made, one core, {}, bundles of {BUNDLE}. Exact lanes are rounded to single precision. \
             Exact models need no fit.</p></section>\n",
            table(&head, rows),
            escaped(&self.choice),
            1e3 * self.pixel,
            Instructions::best(BUNDLE).name()
        )
    }
}

/// What models are measured on.
struct Bench<'a> {
    lens: &'a Lens,
    pupil: &'a ExitPupil,
    models: &'a Models<'a>,
    pixel: f64,
}

impl Bench<'_> {
    /// The traced lens, one ray at a time and in lanes.
    fn exact(&self) -> Vec<Row> {
        let Ok(model) = self.models.model(ModelKind::Exact) else {
            return Vec::new();
        };
        let (errors, wrong) = self.lanes_error(&model);
        let one_by_one = Row {
            name: "exact, f64".to_string(),
            errors: errors.map(|_| [0.0; 2]),
            wrong: wrong.map(|_| 0.0),
            time: self.single_time(&model),
            fit: None,
        };
        let lanes = Row {
            name: "exact, f32 lanes".to_string(),
            errors,
            wrong,
            time: self.useful_time(&model),
            fit: None,
        };
        vec![one_by_one, lanes]
    }

    /// Median and 99th percentile error of rays in lanes, and the share of wrong outcomes in %; `None` where none passes.
    fn lanes_error(&self, model: &LensModel) -> (Option<[f64; 2]>, Option<f64>) {
        let (mut errors, mut passed, mut wrong) = (Vec::new(), 0usize, 0usize);
        for i in 0..RAYS {
            let (film, u) = self.models.sample(i);
            let Some(aim) = self.pupil.sample(film, u) else {
                continue;
            };
            let lane = |x: f64| Lanes::<1>::splat(x as f32);
            let traced =
                model.trace_lanes(&film.map(lane), &[lane(aim.point[0]), lane(aim.point[1])]);
            let exact = self.lens.trace_from_film(film, aim.point);
            passed += usize::from(exact.is_ok());
            match (exact, traced.get(0)) {
                (Ok(exact), Some(ray)) => {
                    let ray = crate::optics::LensRay {
                        o: ray.o.map(f64::from),
                        d: ray.d.map(f64::from),
                    };
                    errors.push(self.models.ray_error(&exact, &ray) / self.pixel);
                }
                (Err(_), None) => {}
                _ => wrong += 1,
            }
        }
        errors.sort_by(f64::total_cmp);
        let Some(last) = errors.len().checked_sub(1) else {
            return (None, None);
        };
        let part = |percent: usize| errors[(errors.len() * percent / 100).min(last)];
        let share = 100.0 * wrong as f64 / passed.max(1) as f64;
        (Some([part(50), part(99)]), Some(share))
    }

    /// ns a useful ray in bundles.
    fn useful_time(&self, model: &LensModel) -> Option<f64> {
        let bundles: Vec<_> = (0..RAYS / BUNDLE)
            .map(|b| {
                let mut film = [Lanes::<BUNDLE>::splat(0.0); 2];
                let mut u = film;
                for lane in 0..BUNDLE {
                    let (point, v) = self.models.sample(b * BUNDLE + lane);
                    for axis in 0..2 {
                        film[axis].0[lane] = point[axis] as f32;
                        u[axis].0[lane] = v[axis];
                    }
                }
                (film, u)
            })
            .collect();
        best(|| {
            let rays = bundles.iter().map(|(film, u)| {
                let rays = black_box(model.rays(self.pupil, film, u));
                rays.traced.passed.count() as usize
            });
            rays.sum()
        })
    }

    /// ns a useful ray in double precision, one at a time.
    fn single_time(&self, model: &LensModel) -> Option<f64> {
        let samples: Vec<_> = (0..RAYS).map(|i| self.models.sample(i)).collect();
        best(|| {
            let passed = samples.iter().filter(|(film, u)| {
                let Some(aim) = self.pupil.sample(*film, *u) else {
                    return false;
                };
                black_box(self.pupil.projected_solid_angle(*film, &aim));
                black_box(model.trace_from_film(*film, aim.point)).is_ok()
            });
            passed.count()
        })
    }
}

/// ns for each of those that `run` counts; `None` where it counts none.
fn best(mut run: impl FnMut() -> usize) -> Option<f64> {
    let times = (0..RUNS).filter_map(|_| {
        let start = Instant::now();
        let count = run();
        let ns = start.elapsed().as_secs_f64() * 1e9;
        (count > 0).then(|| ns / count as f64)
    });
    times.min_by(f64::total_cmp)
}
