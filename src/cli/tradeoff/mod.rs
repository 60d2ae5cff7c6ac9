//! `fstop tradeoff SCENE`: measures what each setting costs and gains on a scene.

mod chart;
mod page;
mod text;

use super::ReadArgs;
use super::goal::relative;
use super::messages::{self, Failure};
use crate::console;
use crate::output;
use crate::session::{Problems, RenderOptions, Scene};
use crate::tradeoff::{Estimate, Measurement, Settings, Study, study};
use clap::Args;
use serde_json::{Value, json};
use std::path::PathBuf;
use std::time::Duration;

/// Examples for the long help.
const EXAMPLES: &str = "Examples:
  fstop tradeoff scene.pbrt --error 1%
  fstop tradeoff scene.pbrt --time 300 --html page.html";

/// Arguments of `fstop tradeoff`.
#[derive(Args, Debug)]
#[command(after_long_help = EXAMPLES)]
pub(super) struct TradeoffArgs {
    /// Scene file; if it has several frames, the first
    scene: PathBuf,
    /// Relative error to recommend a setting for
    #[arg(help_heading = "How it is measured", long, value_parser = relative, default_value = "1%", allow_hyphen_values = true, value_name = "REL")]
    error: f64,
    /// Seconds that the study may take; twice the time makes its results 1.4 times as precise
    #[arg(help_heading = "How it is measured", long, value_parser = super::goal::seconds, default_value = "60", allow_hyphen_values = true, value_name = "SECONDS")]
    time: Duration,
    /// Render the image at full size; otherwise it is reduced if it has more than 40000 pixels
    #[arg(help_heading = "How it is measured", long)]
    full_size: bool,
    /// Print the result as JSON
    #[arg(help_heading = "Output", long)]
    json: bool,
    /// Also write a page with charts here
    #[arg(help_heading = "Output", long, value_name = "FILE")]
    html: Option<PathBuf>,
    /// Threads; by default one per processor
    #[arg(
        help_heading = "How it is measured",
        long,
        default_value_t = 0,
        hide_default_value = true
    )]
    threads: usize,
    /// Seed of all random samples
    #[arg(help_heading = "How it is measured", long, default_value_t = 0)]
    seed: u64,
    /// Print only the result
    #[arg(help_heading = "Output", long)]
    quiet: bool,
    #[command(flatten)]
    read: ReadArgs,
}

/// Studies the scene.
pub(super) fn run(args: &TradeoffArgs) -> u8 {
    study_scene(args).map_or_else(Failure::exit, |()| 0)
}

/// More pixels give no more precision than as many more samples.
const PIXELS: u32 = 40_000;

fn study_scene(args: &TradeoffArgs) -> Result<(), Failure> {
    if let Some(path) = &args.html {
        output::check(path)?;
    }
    let print = |problems: &Problems| {
        if !args.quiet {
            messages::print(problems);
        }
    };
    let scene = Scene::load(&args.scene, &args.read.options(args.read.policy()))?;
    print(scene.problems());
    if let Some(path) = &args.html {
        output::check_apart(&[path], &scene.files_read())?;
    }
    if !args.quiet {
        args.read.warn_of_no_lens(&scene);
    }
    let frames = scene.into_frames();
    let mut frame = frames.into_iter().next().ok_or("no frame".to_string())?;
    let full = frame.resolution();
    if !args.full_size {
        frame.shrink(PIXELS);
    }
    let shrunk = frame.resolution() != full;
    let options = RenderOptions {
        seed: args.seed,
        threads: args.threads,
        ..RenderOptions::default()
    };
    let frame = frame.prepare(&options)?;
    print(frame.problems());
    let settings = Settings {
        time: args.time,
        target: args.error,
        seed: args.seed,
    };
    let say = |what: String| {
        if !args.quiet {
            console::say(format_args!("{what} ..."));
        }
    };
    let result = study(frame, &settings, &say)?;
    let name = args.scene.file_name().unwrap_or_default().to_string_lossy();
    let answer = if args.json {
        format!("{:#}", json_of(&result, &name))
    } else {
        text::report(&result, &name, shrunk)
    };
    // Each is written wherever the other goes.
    let told = console::answer(answer.trim_end());
    if let Some(path) = &args.html {
        let page = page::html(&result, &name, shrunk)?;
        output::write(path, page.as_bytes())?;
    }
    Ok(told?)
}

fn json_of(study: &Study, scene: &str) -> Value {
    let settings: Vec<Value> = study
        .measured
        .iter()
        .map(|(candidate, m)| {
            let mut value = json_of_measured(m);
            value["setting"] = json!(candidate.setting.name());
            value["value"] = json!(candidate.value);
            value
        })
        .collect();
    let failed: Vec<Value> = study
        .failed
        .iter()
        .map(|(candidate, why)| {
            json!({ "setting": candidate.setting.name(), "value": candidate.value, "why": why.to_string() })
        })
        .collect();
    let recommendation = study.recommendation.as_ref().map(|r| {
        let turned: Vec<Value> = r
            .turned
            .iter()
            .map(|&i| &study.measured[i].0)
            .map(|candidate| json!({ "setting": candidate.setting.name(), "value": candidate.value }))
            .collect();
        json!({
            "relativeError": r.target,
            "settings": turned,
            "spp": r.spp,
            "processorSeconds": r.seconds,
            "sentence": text::sentence(study),
            "verified": study.verified.as_ref().map(json_of_measured),
        })
    });
    json!({
        "scene": scene,
        "resolution": study.resolution,
        "reference": { "relativeError": study.reference_error, "spp": study.reference_spp },
        "processors": study.processors,
        "slope": study.slope,
        "settings": settings,
        "failed": failed,
        "recommendation": recommendation,
    })
}

fn json_of_measured(m: &Measurement) -> Value {
    let estimate = |e: Estimate| json!({ "value": finite(e.value), "within": finite(e.within) });
    json!({
        "spp": m.spp,
        "relativeError": estimate(m.error()),
        "relativeBias": estimate(m.bias()),
        "variance": estimate(m.variance),
        "processorSeconds": estimate(m.seconds),
        "efficiency": estimate(m.efficiency),
    })
}

/// `None` for infinities, which JSON lacks.
fn finite(x: f64) -> Option<f64> {
    x.is_finite().then_some(x)
}
