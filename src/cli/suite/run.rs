//! `fstop suite run SUITE`.

use super::image::{Kind, NoPicture, Picture, Studio};
use super::update;
use crate::cli::codes::{ANSWER_IS_NO, LOST};
use crate::cli::compare::folders::write_page;
use crate::cli::compare::{Report, incomparable, input};
use crate::cli::messages::{self, Failure};
use crate::cli::results::{Outcome, Results, Row, Status, Thumbnails};
use crate::compare::Options;
use crate::console;
use crate::suite::{Family, Scene, Suite, Sums, hash, spend};
use crate::syntax::suggest::nearest;
use clap::{Args, ValueEnum};
use std::path::PathBuf;
use std::sync::atomic::Ordering::Relaxed;
use std::time::{Duration, Instant};

/// Arguments of `fstop suite run`.
#[derive(Args, Debug)]
pub(super) struct RunArgs {
    /// The suite file (TOML)
    #[arg(value_name = "SUITE")]
    suite: PathBuf,
    /// Only the scenes of these names; the false-alarm rate is shared among all nevertheless
    #[arg(
        help_heading = "What is run",
        long,
        value_name = "NAME",
        value_delimiter = ','
    )]
    only: Vec<String>,
    /// Render new references, of several runs each, for images that are new or changed, or for all
    #[arg(help_heading = "What is run", long, value_enum, value_name = "WHICH", num_args = 0..=1, require_equals = true, default_missing_value = "changed")]
    update: Option<Update>,
    /// Name of the commit, where the false-alarm rate is shared among commits: one that has been tested before spends nothing
    /// more
    #[arg(help_heading = "What is run", long, value_name = "NAME")]
    commit: Option<String>,
    /// Folder for images and reports, instead of the suite's
    #[arg(help_heading = "Output", short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// Print JSON instead of text
    #[arg(help_heading = "Output", long)]
    json: bool,
    /// Write a page for each image, not only for those that do not agree
    #[arg(help_heading = "Output", long)]
    pages: bool,
    /// Pages without FLIP, which takes the longest
    #[arg(help_heading = "Output", long)]
    no_flip: bool,
    /// Print only errors and the result
    #[arg(help_heading = "Output", long)]
    quiet: bool,
}

#[derive(ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Update {
    /// Images that are new, or differ from their reference
    Changed,
    /// All images
    All,
}

/// How often the reports of what is done are written while others are rendered.
const REPORTED: Duration = Duration::from_secs(2);

/// Runs a suite; returns the exit code.
pub(super) fn run(args: &RunArgs) -> Result<u8, Failure> {
    let suite = Suite::read(&args.suite)?;
    let scenes = chosen(&suite, &args.only)?;
    let mut sums = Sums::read(&suite.references)?;
    // Before a commit is given its share.
    let studio = Studio::open(&suite, args.output.as_ref())?;
    let mut results = begun(&suite, &scenes, args)?;
    let options = Options {
        alpha: results.family.share(),
        ..suite.options.clone()
    };
    test(args, &studio, &scenes, &sums, &options, &mut results);
    if args.only.is_empty() {
        results.rows.extend(orphans(&suite, &sums));
    }
    let paged = write_pages(args, &studio, &mut results, &options);
    let done = paged.and_then(|()| match args.update {
        Some(which) => update::update(&studio, &scenes, which, &mut sums, &options, &mut results),
        None => Ok(true),
    });
    results.settle();
    results.write(&studio.output)?;
    let is_done = done?;
    console::answer(match args.json {
        true => results.json()?,
        false => results.text(),
    })?;
    if !args.quiet {
        console::say(format_args!(
            "{}",
            studio.output.join("index.html").display()
        ));
    }
    match studio.stop.load(Relaxed) {
        true => Ok(LOST),
        // What was asked for was not done, whatever the images say.
        false if !is_done => Ok(ANSWER_IS_NO),
        false => Ok(results.code()),
    }
}

/// The scenes of these names, or all.
pub(super) fn chosen<'a>(suite: &'a Suite, names: &[String]) -> Result<Vec<&'a Scene>, Failure> {
    let known = || suite.scenes.iter().map(|scene| scene.name.as_str());
    for name in names {
        if !known().any(|known| known == name) {
            let meant = nearest(name, known());
            let meant = meant.map(|meant| format!("; did you mean `{meant}`?"));
            let message = format!(
                "the suite has no scene `{name}`{}",
                meant.unwrap_or_default()
            );
            return Err(message.into());
        }
    }
    let is_asked = |scene: &&Scene| names.is_empty() || names.contains(&scene.name);
    Ok(suite.scenes.iter().filter(is_asked).collect())
}

/// Results before anything is rendered: the false-alarm rate is settled by then.
fn begun(suite: &Suite, scenes: &[&Scene], args: &RunArgs) -> Result<Results, Failure> {
    let all = suite.options.alpha;
    let spent = match &suite.commits {
        Some(file) => {
            let spent = spend(file, all, args.commit.as_deref());
            Some(spent.map_err(|e| Failure::new(&e, e.is_failure()))?)
        }
        None if args.commit.is_some() => {
            messages::warning(
                "--commit has no effect: the suite does not share its false-alarm rate among commits",
            );
            None
        }
        None => None,
    };
    let alpha = spent.map_or(all, |spent| spent.alpha);
    let row = |scene: &&Scene| Row::new(scene.name.clone(), Outcome::NotRun);
    Ok(Results {
        title: suite.name.clone(),
        family: Family {
            alpha,
            images: suite.scenes.len(),
            correction: suite.options.correction,
        },
        level: alpha,
        spent: spent.map(|spent| (spent, all)),
        rows: scenes.iter().map(row).collect(),
    })
}

/// Renders and compares, scene by scene; what is done is in the reports soon.
fn test(
    args: &RunArgs,
    studio: &Studio,
    scenes: &[&Scene],
    sums: &Sums,
    options: &Options,
    results: &mut Results,
) {
    let mut written = Instant::now();
    for (index, scene) in scenes.iter().enumerate() {
        let row = match studio.picture(scene, &scene.seeds, Kind::Image) {
            Ok(picture) => compared(studio, scene, picture, sums, options),
            Err(NoPicture::Failed(why)) => Row::new(scene.name.clone(), Outcome::Failed(why)),
            Err(NoPicture::Interrupted) => return,
        };
        if !args.quiet {
            let (number, count, name) = (index + 1, scenes.len(), &scene.name);
            let seconds = row
                .seconds
                .map_or(String::new(), |s| format!(" ({s:.1} s)"));
            let word = row.status().word();
            console::say(format_args!("[{number}/{count}] {name}: {word}{seconds}"));
        }
        if let Some(place) = results.rows.get_mut(index) {
            *place = row;
        }
        if written.elapsed() > REPORTED {
            results.settle();
            // A disk that is full now may not be at the end; the images are there.
            if let Err(failure) = results.write(&studio.output) {
                messages::warning(failure.text());
            }
            written = Instant::now();
        }
    }
}

/// An image against its reference.
fn compared(
    studio: &Studio,
    scene: &Scene,
    picture: Picture,
    sums: &Sums,
    options: &Options,
) -> Row {
    let thumbnails = Thumbnails::one("image", &picture.input.loaded.image);
    let seconds = picture.time.as_secs_f64();
    let mut row = match reference(studio.suite, scene, sums) {
        Ok(None) => Row::new(scene.name.clone(), Outcome::New),
        Ok(Some((reference, note))) => {
            match Report::new(input::pair(picture.input, reference), options) {
                Ok(report) => {
                    let mut row = report.row(&scene.name, options);
                    row.notes.extend(note);
                    row
                }
                Err(error) => Row::new(scene.name.clone(), incomparable(&error)),
            }
        }
        Err(why) => Row::new(scene.name.clone(), Outcome::Failed(why)),
    };
    row.seconds = Some(seconds);
    if row.comparison().is_none() {
        row.thumbnails = thumbnails;
    }
    row
}

/// The reference, with what is to be said about it; `None` if there is none.
pub(super) fn reference(
    suite: &Suite,
    scene: &Scene,
    sums: &Sums,
) -> Result<Option<(input::Input, Option<String>)>, String> {
    let path = &scene.reference;
    if !path.exists() {
        return Ok(None);
    }
    let place = path.display();
    let listed = update::listed(suite, scene);
    let listed = listed.and_then(|name| sums.of(&name).map(str::to_owned));
    let accepted = scene.sha256.as_ref().map(|(sum, _)| sum.clone()).or(listed);
    let note = match accepted {
        Some(accepted) => {
            let found = hash(path).map_err(|e| format!("{place}: cannot read: {e}"))?;
            if found != accepted {
                return Err(format!(
                    "the reference {place} is not the one that was accepted: its SHA-256 is {found}, not {accepted}"
                ));
            }
            None
        }
        None if update::listed(suite, scene).is_some() => {
            Some("no SHA-256 of the reference is known: `--update=all` writes one".to_owned())
        }
        None => {
            let found = hash(path).map_err(|e| format!("{place}: cannot read: {e}"))?;
            Some(format!(
                "no SHA-256 of the reference is known: add `sha256 = \"{found}\"` to the scene if this is the one that is meant"
            ))
        }
    };
    let read = input::read(path).map_err(|failure| failure.text())?;
    Ok(Some((read.plain(), note)))
}

/// References that were accepted once and are no scene's any more: a test has vanished.
fn orphans(suite: &Suite, sums: &Sums) -> Vec<Row> {
    let names = suite
        .scenes
        .iter()
        .filter_map(|scene| update::listed(suite, scene));
    let known: Vec<String> = names.collect();
    let orphans = sums
        .names()
        .filter(|name| !known.iter().any(|known| known == name));
    orphans
        .map(|name| Row::new(name, Outcome::Missing))
        .collect()
}

/// A page for each image that differs, or may, by the level that all of them have led to.
fn write_pages(
    args: &RunArgs,
    studio: &Studio,
    results: &mut Results,
    options: &Options,
) -> Result<(), Failure> {
    results.settle();
    let options = Options {
        alpha: results.level,
        ..options.clone()
    };
    for row in &mut results.rows {
        let is_calm = row.status() == Status::Agree && !args.pages;
        let scene = studio
            .suite
            .scenes
            .iter()
            .find(|scene| scene.name == row.name);
        let (Some(scene), Some(_), false) = (scene, row.comparison(), is_calm) else {
            continue;
        };
        let reference = input::read(&scene.reference)?.plain();
        let pair = input::pair(studio.again(scene)?, reference);
        let mut report = Report::new(pair, &options)?;
        if !args.no_flip {
            report = report.with_flip();
        }
        row.page = Some(write_page(&studio.output, &row.name, &report, &options)?);
    }
    Ok(())
}
