//! `fstop compare BASE/ NEW/`: all images of two folders, by their names.

use super::{CompareArgs, Failure, Report, incomparable, input};
use crate::cli::results::{self, Outcome, Results, Row, Status, Thumbnails};
use crate::compare::Options;
use crate::console;
use crate::output;
use crate::suite::Family;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// The images that are paired.
const EXTENSIONS: [&str; 7] = ["exr", "pfm", "hdr", "png", "tga", "jpg", "jpeg"];

/// Compares, prints and writes; returns the exit code.
pub(super) fn run(args: &CompareArgs) -> Result<u8, Failure> {
    args.check_outputs(&[])?;
    if let Some(folder) = &args.report {
        results::make(folder)?;
    }
    let (base, new) = (&args.a, &args.b);
    let (of_base, of_new) = (names(base)?, names(new)?);
    let names: BTreeSet<&String> = of_base.union(&of_new).collect();
    if names.is_empty() {
        let [a, b] = [base, new].map(|path| path.display());
        return Err(format!("there are no images in `{a}` and `{b}`").into());
    }
    let both = of_base.intersection(&of_new).count();
    let mut results = empty(
        args,
        both,
        format!("{} → {}", base.display(), new.display()),
    );
    let options = Options {
        alpha: results.family.share(),
        ..args.options()
    };
    for name in names {
        let row = match (of_base.contains(name), of_new.contains(name)) {
            (true, true) => compared(args, name, &options),
            (true, false) => alone(base, name, Outcome::Missing),
            _ => alone(new, name, Outcome::New),
        };
        results.rows.push(row);
    }
    results.settle();
    if let Some(folder) = &args.report {
        pages(args, &mut results, folder, &options)?;
        results.write(folder)?;
    }
    if let Some(file) = &args.html {
        output::write(file, results.page().as_bytes())?;
    }
    write_results(args, &results)?;
    console::answer(match args.json {
        true => results.json()?,
        false => results.text(),
    })?;
    Ok(results.code())
}

fn empty(args: &CompareArgs, images: usize, title: String) -> Results {
    let options = args.options();
    Results {
        title,
        family: Family {
            alpha: options.alpha,
            images: images.max(1),
            correction: options.correction,
        },
        level: options.alpha,
        spent: None,
        rows: Vec::new(),
    }
}

/// The result of two images, for those forms that hold many.
pub(super) fn of_one(args: &CompareArgs, report: &Report, options: &Options) -> Results {
    let [a, b] = report
        .inputs
        .each_ref()
        .map(|input| input.path.display().to_string());
    let mut results = empty(args, 1, "fstop compare".to_owned());
    results.rows = vec![report.row(&format!("{a} and {b}"), options)];
    results
}

/// Writes them for build servers and pull requests, where that was asked for.
pub(super) fn write_results(args: &CompareArgs, results: &Results) -> Result<(), Failure> {
    if let Some(file) = &args.junit {
        output::write(file, results.junit().as_bytes())?;
    }
    if let Some(file) = &args.markdown {
        output::write(file, results.markdown().as_bytes())?;
    }
    Ok(())
}

/// The images of a folder and those below, with `/` between folders.
fn names(folder: &Path) -> Result<BTreeSet<String>, Failure> {
    let mut names = BTreeSet::new();
    let mut left = vec![String::new()];
    while let Some(below) = left.pop() {
        let path = folder.join(&below);
        let failed =
            |e: std::io::Error| Failure::new(format!("{}: cannot read: {e}", path.display()), true);
        for entry in std::fs::read_dir(&path).map_err(failed)? {
            let entry = entry.map_err(failed)?;
            let name = entry.file_name();
            // Links to folders are not followed: they may lead in circles.
            let is_folder = entry.file_type().is_ok_and(|kind| kind.is_dir());
            let ending = { Path::new(&name).extension() }.map(|ending| ending.to_ascii_lowercase());
            let is_image =
                ending.is_some_and(|ending| EXTENSIONS.iter().any(|known| ending == *known));
            if !is_folder && !is_image {
                continue;
            }
            let name = name.into_string().map_err(|name| {
                let place = path.join(name);
                format!("{place:?}: names of images in folders are UTF-8; rename it")
            })?;
            match is_folder {
                true => left.push(format!("{below}{name}/")),
                false => drop(names.insert(below.clone() + &name)),
            }
        }
    }
    Ok(names)
}

/// The image is the new one, the reference the other.
fn pair(args: &CompareArgs, name: &str) -> Result<[input::Input; 2], Failure> {
    input::read_pair(&args.b.join(name), &args.a.join(name))
}

fn compared(args: &CompareArgs, name: &str, options: &Options) -> Row {
    let inputs = match pair(args, name) {
        Ok(inputs) => inputs,
        Err(failure) => return Row::new(name, Outcome::Failed(failure.text())),
    };
    match Report::new(inputs, options) {
        Ok(report) => report.row(name, options),
        Err(error) => Row::new(name, incomparable(&error)),
    }
}

fn alone(folder: &Path, name: &str, outcome: Outcome) -> Row {
    let mut row = Row::new(name, outcome);
    match input::read(&folder.join(name)) {
        Ok(input) => row.thumbnails = Thumbnails::one("image", &input.loaded.image),
        Err(failure) => row.notes.push(failure.text()),
    }
    row
}

/// A page for each image that differs, or may.
fn pages(
    args: &CompareArgs,
    results: &mut Results,
    folder: &Path,
    options: &Options,
) -> Result<(), Failure> {
    let options = Options {
        alpha: results.level,
        ..options.clone()
    };
    for row in &mut results.rows {
        let is_alarming = matches!(row.status(), Status::Changed | Status::CannotTell);
        if is_alarming && row.comparison().is_some() {
            let mut report = Report::new(pair(args, &row.name)?, &options)?;
            if !args.no_flip {
                report = report.with_flip();
            }
            row.page = Some(write_page(folder, &row.name, &report, &options)?);
        }
    }
    Ok(())
}

/// Writes an image's page below a folder of reports, and returns its place there.
pub(in crate::cli) fn write_page(
    folder: &Path,
    name: &str,
    report: &Report,
    options: &Options,
) -> Result<String, Failure> {
    let place = format!("pages/{name}.html");
    let file: PathBuf = folder.join(&place);
    results::make(file.parent().unwrap_or(folder))?;
    output::write(&file, report.page(options)?.as_bytes())?;
    Ok(place)
}
