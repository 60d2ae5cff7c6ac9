//! `fstop suite plan SUITE`: how many samples find a difference.

use super::image::{Kind, NoPicture, Studio};
use super::run::{chosen, reference};
use crate::cli::codes::{ANSWER_IS_NO, LOST};
use crate::cli::compare::json::findable;
use crate::cli::goal::relative;
use crate::cli::messages::Failure;
use crate::compare::{self, Options, POWER};
use crate::console;
use crate::suite::{Aim, Family, MAX_SPP, Plan, Scene, Step, Suite, Sums};
use clap::Args;
use serde_json::{Value, json};
use std::path::PathBuf;

/// Arguments of `fstop suite plan`.
#[derive(Args, Debug)]
pub(super) struct PlanArgs {
    /// The suite file (TOML)
    #[arg(value_name = "SUITE")]
    suite: PathBuf,
    /// The difference that is to be found: 0.005 or 0.5%
    #[arg(help_heading = "What is planned", long, value_name = "REL", default_value = "1%", value_parser = relative, allow_hyphen_values = true)]
    difference: f64,
    /// Side in pixels of the blocks it is in; 0 for the whole image
    #[arg(
        help_heading = "What is planned",
        long,
        value_name = "PX",
        default_value_t = 32
    )]
    block: u32,
    /// Only the scenes of these names
    #[arg(
        help_heading = "What is planned",
        long,
        value_name = "NAME",
        value_delimiter = ','
    )]
    only: Vec<String>,
    /// Folder for images, instead of the suite's
    #[arg(help_heading = "Output", short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// Print JSON instead of text
    #[arg(help_heading = "Output", long)]
    json: bool,
}

/// Plans; returns the exit code.
pub(super) fn run(args: &PlanArgs) -> Result<u8, Failure> {
    let suite = Suite::read(&args.suite)?;
    let scenes = chosen(&suite, &args.only)?;
    let sums = Sums::read(&suite.references)?;
    let studio = Studio::open(&suite, args.output.as_ref())?;
    let aim = Aim {
        relative: args.difference,
        side: (args.block > 0).then_some(args.block),
    };
    let family = Family {
        alpha: suite.options.alpha,
        images: suite.scenes.len(),
        correction: suite.options.correction,
    };
    let mut options = Options {
        alpha: family.share(),
        ..suite.options.clone()
    };
    options
        .blocks
        .extend(aim.side.filter(|side| !suite.options.blocks.contains(side)));
    let (mut plans, mut code) = (Vec::new(), 0);
    for scene in scenes {
        let plan = match planned(&studio, scene, &sums, aim, &options) {
            Ok(plan) => Ok(plan),
            Err(NoPicture::Interrupted) => return Ok(LOST),
            Err(NoPicture::Failed(why)) => Err(why),
        };
        if !plan
            .as_ref()
            .is_ok_and(|plan| plan.kept.or(plan.anew).is_some())
        {
            code = ANSWER_IS_NO;
        }
        plans.push((scene, plan));
    }
    let told = match args.json {
        true => format!("{:#}", json_of(&plans, aim, options.alpha)),
        false => plans
            .iter()
            .map(|(scene, plan)| text(scene, plan, aim))
            .collect::<Vec<_>>()
            .join("\n"),
    };
    console::answer(told)?;
    Ok(code)
}

fn planned(
    studio: &Studio,
    scene: &Scene,
    sums: &Sums,
    aim: Aim,
    options: &Options,
) -> Result<Plan, NoPicture> {
    let pilot = studio.picture(scene, &scene.seeds, Kind::Image)?.input;
    let theirs = reference(studio.suite, scene, sums).map_err(NoPicture::Failed)?;
    let [own, new] = [&scene.seeds, &scene.baseline_seeds].map(|seeds| seeds.len() as f64);
    let pair = match theirs {
        Some((theirs, _)) => {
            let [pilot, theirs] = crate::cli::compare::input::pair(pilot, theirs);
            (pilot, Some(theirs))
        }
        None => (pilot, None),
    };
    let reference = pair.1.as_ref().map(|input| &input.loaded);
    let plan = Plan::new(&pair.0.loaded, reference, new / own, aim, options);
    plan.map_err(|error| NoPicture::Failed(error.to_string()))
}

fn text(scene: &Scene, plan: &Result<Plan, String>, aim: Aim) -> String {
    let name = &scene.name;
    let place = match aim.side {
        None => "the whole image".to_owned(),
        Some(side) => format!("any block of {side} × {side}"),
    };
    let plan = match plan {
        Ok(plan) => plan,
        Err(why) => return format!("{name}: no plan: {}", why.replace('\n', "\n    ")),
    };
    let aimed = compare::relative(aim.relative);
    let now = compare::relative(plan.now.relative);
    let [samples, runs] = [scene.seeds.len(), scene.baseline_seeds.len()];
    let all = u64::from(scene.spp) * samples as u64;
    let mut text = format!(
        "{name}: {all} spp find {now} in {place} with {:.0} %",
        100.0 * POWER
    );
    let each = |step: Step| {
        step.spp
            .div_ceil(u32::try_from(samples).unwrap_or(u32::MAX))
    };
    let said = |step: Step| match samples {
        1 => format!("{} spp", step.spp),
        n => format!("{n} runs of {} spp", each(step)),
    };
    if let Some(step) = plan.kept {
        let all = said(step);
        text += &format!("\n    {all} will find {aimed}, with the reference there is");
    }
    if let Some(step) = plan.anew {
        let (or, all, spp) = (
            if plan.kept.is_some() { "or " } else { "" },
            said(step),
            each(step),
        );
        text += &format!(
            "\n    {or}{all} will find {aimed}, with a new reference of {runs} runs of {spp} spp"
        );
    }
    if plan.kept.or(plan.anew).is_none() {
        text += &format!("\n    not even {MAX_SPP} spp will find {aimed}");
    }
    text
}

type Planned<'a> = (&'a Scene, Result<Plan, String>);

fn json_of(plans: &[Planned], aim: Aim, alpha: f64) -> Value {
    let step = |step: Option<Step>| {
        step.map(|step| json!({ "spp": step.spp, "found": findable(&step.found) }))
    };
    let plan = |(scene, plan): &Planned| match plan {
        Ok(plan) => json!({
            "name": scene.name,
            "spp": scene.spp,
            "now": findable(&plan.now),
            "with_the_reference": step(plan.kept),
            "with_a_new_reference": step(plan.anew),
            "runs_of_a_new_reference": scene.baseline_seeds.len(),
        }),
        Err(why) => json!({ "name": scene.name, "error": why }),
    };
    json!({
        "difference": aim.relative,
        "side": aim.side,
        "power": POWER,
        "alpha": alpha,
        "scenes": plans.iter().map(plan).collect::<Vec<_>>(),
    })
}
