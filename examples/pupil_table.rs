//! Measures what part of the sampled rays passes a lens, for four ways of aiming at the exit pupil,
//! and writes `docs/generated/pupil.md`: `cargo run --release --features studies --example pupil_table`.
//!
//! The lenses, their film planes and image circles are those of `tests/golden`. With lens names as
//! arguments only those are measured, and nothing is written.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a panic is an answer here"
)]
#![allow(clippy::print_stdout)]

use fstop::cameras::pbrt_pupil_box::{self, PupilBox, pupil_box};
use fstop::math::Vec2;
use fstop::math::sampling::concentric_disk;
use fstop::optics::pupil::{RINGS, projected_solid_angle};
use fstop::optics::{ExitPupil, Lens, Prescription, PupilSample};
use serde_json::Value;
use std::error::Error;
use std::fmt::Write;
use std::path::Path;
use std::time::Instant;

/// All of `tests/golden` that the prescription reader can hold.
const LENSES: [&str; 12] = [
    "course_dgauss_100",
    "dgauss_50",
    "wide_22",
    "telephoto_250",
    "fisheye_10",
    "tessar_100",
    "triplet_50",
    "petzval_50",
    "retrofocus_35",
    "canon_uw_14",
    "nikon_50_f1.2",
    "zoom_80_200_wide",
];

/// Full-frame film, mm.
const FILM: [f64; 2] = [36.0, 24.0];

/// Rays per film height, and per image: their pass fractions are good to some 0.1 %.
const RAYS: u32 = 1 << 16;

const HEAD: &str = "# The exit pupil: measured

Written by `cargo run --release --features studies --example pupil_table`, not by hand. [The exit pupil](../pupil.md) says what is measured, and how.

";

fn main() -> Result<(), Box<dyn Error>> {
    let names: Vec<String> = std::env::args().skip(1).collect();
    let chosen = |name: &&&str| names.is_empty() || names.iter().any(|n| n == **name);
    let mut tables = String::new();
    for (stops, scale) in [("full aperture", 1.0), ("two stops down", 0.25)] {
        writeln!(tables, "{}", header(stops))?;
        for name in LENSES.iter().filter(&chosen) {
            let rows = Bench::read(name, scale)?.rows(name);
            print!("{rows}");
            tables += &rows;
        }
        tables += "\n";
    }
    if names.is_empty() {
        let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/generated/pupil.md");
        std::fs::write(page, format!("{HEAD}{}\n", tables.trim_end()))?;
    }
    Ok(())
}

fn header(stops: &str) -> String {
    format!(
        "**Passing rays at {stops}, %**, at five film heights (parts of the image circle's radius) and averaged over \
         a full-frame image inside the image circle. (−x): part of the pupil's light that is never sampled, %.\n\n\
         | lens | aimed at | 0 | ¼ | ½ | ¾ | 1 | image | set-up, ms |\n|---|---|---|---|---|---|---|---|---|"
    )
}

/// One lens at one stop.
struct Bench {
    lens: Lens,
    /// Of the image circle, mm.
    radius: f64,
    /// Projected solid angles of the pupil at the five film heights, sr.
    golden: Vec<f64>,
}

/// A way of aiming: from film point and lens sample to a point and the area it stands for.
type Aim<'a> = Box<dyn Fn([f64; 2], Vec2) -> Option<PupilSample> + 'a>;

impl Bench {
    fn read(name: &str, scale: f64) -> Result<Bench, Box<dyn Error>> {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden");
        let mut prescription = Prescription::read(&folder.join(format!("{name}.dat")))?;
        for s in prescription.surfaces.iter_mut().filter(|s| s.is_stop) {
            s.aperture *= scale;
        }
        let data: Value = serde_json::from_str(&std::fs::read_to_string(
            folder.join(format!("{name}.json")),
        )?)?;
        let number = |v: &Value| v.as_f64().ok_or("no number");
        let distance = number(&data["film_z"])? - number(&data["first_order"]["length"])?;
        let fields = data["fields"].as_array().ok_or("no fields")?;
        let key = if scale == 1.0 { "1" } else { "0.25" };
        Ok(Bench {
            lens: Lens::new(&prescription, distance)?,
            radius: number(&data["image_radius"])?,
            golden: fields
                .iter()
                .map(|f| f["proj_solid_angle_sr"][key].as_f64().unwrap_or(f64::NAN))
                .collect(),
        })
    }

    /// Half the film's diagonal, as far as the image circle reaches.
    fn reach(&self) -> f64 {
        self.radius.min(0.5 * FILM[0].hypot(FILM[1]))
    }

    fn rows(&self, name: &str) -> String {
        let (mut set_up, mut pupil) = (f64::INFINITY, None);
        for _ in 0..5 {
            let clock = Instant::now();
            let found = ExitPupil::new(&self.lens, self.reach(), RINGS);
            set_up = set_up.min(1e3 * clock.elapsed().as_secs_f64());
            pupil = Some(found);
        }
        let boxes: Vec<Option<PupilBox>> = (0..pbrt_pupil_box::RINGS)
            .map(|ring| pupil_box(&self.lens, 2.0 * self.reach(), ring))
            .collect();
        let aims: [(&str, Aim, String); 4] = [
            ("rear element", self.rear_disk(), String::new()),
            ("paraxial exit pupil", self.paraxial_disk(), String::new()),
            ("pbrt-v3's boxes", self.boxes(&boxes), String::new()),
            (
                "**fstop**",
                Box::new(|film, u| pupil.as_ref()?.sample(film, u)),
                format!(
                    "{set_up:.0} ({} rings)",
                    pupil.as_ref().map_or(0, ExitPupil::rings)
                ),
            ),
        ];
        let mut text = String::new();
        for (aim_name, aim, note) in aims {
            let mut cells = Vec::new();
            for (i, golden) in self.golden.iter().enumerate() {
                let film = [0.25 * i as f64 * self.radius, 0.0];
                let (passed, mean) = self.measure(|_| Some(film), &aim);
                let lost = 1.0 - mean / golden;
                // The means are good to a few in ten thousand.
                cells.push(if lost > 2e-3 {
                    format!("{:.1} (−{:.1})", 100.0 * passed, 100.0 * lost)
                } else {
                    format!("{:.1}", 100.0 * passed)
                });
            }
            let (picture, _) = self.measure(|u| self.film_point(u), &aim);
            text += &format!(
                "| {name} | {aim_name} | {} | {:.1} | {note} |\n",
                cells.join(" | "),
                100.0 * picture
            );
        }
        text
    }

    /// A point of the image; `None` outside the image circle.
    fn film_point(&self, u: Vec2) -> Option<[f64; 2]> {
        let u = u.as_dvec2();
        let p = [FILM[0] * (u.x - 0.5), FILM[1] * (u.y - 0.5)];
        (p[0].hypot(p[1]) <= self.radius).then_some(p)
    }

    /// Part of the rays that passes, and their mean projected solid angle.
    fn measure(&self, film: impl Fn(Vec2) -> Option<[f64; 2]>, aim: &Aim) -> (f64, f64) {
        let (mut rays, mut passed, mut sum) = (0u32, 0u32, 0.0);
        for i in 0..RAYS {
            // The four-dimensional R sequence (Roberts 2018).
            let r =
                |k: i32| (0.5 + f64::from(i) / 1.167_303_978_261_418_7f64.powi(k)).fract() as f32;
            let Some(film) = film(Vec2::new(r(1), r(2))) else {
                continue;
            };
            rays += 1;
            let Some(sample) = aim(film, Vec2::new(r(3), r(4))) else {
                continue;
            };
            if self.lens.trace_from_film(film, sample.point).is_ok() {
                passed += 1;
                sum += projected_solid_angle([film[0], film[1], self.lens.film_z()], &sample);
            }
        }
        (f64::from(passed) / f64::from(rays), sum / f64::from(rays))
    }

    fn rear_disk(&self) -> Aim<'_> {
        disk(0.5 * self.lens.rear().aperture, self.lens.length())
    }

    fn paraxial_disk(&self) -> Aim<'_> {
        match self.lens.paraxial().exit_pupil {
            Some(pupil) => disk(0.5 * pupil.diameter, pupil.z),
            None => Box::new(|_, _| None),
        }
    }

    fn boxes<'a>(&'a self, boxes: &'a [Option<PupilBox>]) -> Aim<'a> {
        let half = 1.5 * 0.5 * self.lens.rear().aperture;
        let whole = PupilBox {
            low: [-half; 2],
            high: [half; 2],
        };
        Box::new(move |film, u| {
            let radius = film[0].hypot(film[1]);
            let ring = (radius / self.reach() * boxes.len() as f64) as usize;
            let b = boxes[ring.min(boxes.len() - 1)].unwrap_or(whole);
            let u = u.as_dvec2().to_array();
            let [x, y] = [0, 1].map(|i| b.low[i] + u[i] * (b.high[i] - b.low[i]));
            let (cos, sin) = if radius > 0.0 {
                (film[0] / radius, film[1] / radius)
            } else {
                (1.0, 0.0)
            };
            Some(PupilSample {
                point: [cos * x - sin * y, sin * x + cos * y, self.lens.length()],
                area: b.area(),
            })
        })
    }
}

/// A disk about the axis.
fn disk<'a>(radius: f64, z: f64) -> Aim<'a> {
    Box::new(move |_, u| {
        let p = radius * concentric_disk(u).as_dvec2();
        Some(PupilSample {
            point: [p.x, p.y, z],
            area: std::f64::consts::PI * radius * radius,
        })
    })
}
