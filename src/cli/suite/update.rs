//! `fstop suite run --update`: new references, of several runs each.

use super::image::{Kind, NoPicture, Studio};
use super::run::Update;
use crate::cli::compare::input::Input;
use crate::cli::compare::{Report, input};
use crate::cli::messages::Failure;
use crate::cli::results::{self, Outcome, Results, Row, Status};
use crate::compare::Options;
use crate::console;
use crate::film;
use crate::output;
use crate::suite::{Scene, Suite, Sums, hash, metadata};
use std::path::Path;

/// The name of a scene's reference among the hashes of the folder of references; `None` if it is elsewhere.
pub(super) fn listed(suite: &Suite, scene: &Scene) -> Option<String> {
    let path = scene.reference.strip_prefix(&suite.references).ok()?;
    let parts = path
        .components()
        .map(|part| part.as_os_str().to_string_lossy());
    Some(parts.collect::<Vec<_>>().join("/"))
}

/// Renders and accepts references for the images that ask for one. Returns `true` if all have one.
pub(super) fn update(
    studio: &Studio,
    scenes: &[&Scene],
    which: Update,
    sums: &mut Sums,
    options: &Options,
    results: &mut Results,
) -> Result<bool, Failure> {
    let mut is_done = true;
    // From the last place in the file to the first: those before keep theirs.
    let mut sums_in_file = Vec::new();
    for scene in scenes {
        let Some(row) = results.rows.iter_mut().find(|row| row.name == scene.name) else {
            continue;
        };
        let is_asked = match (row.status(), which) {
            (Status::NotRun, _) => false,
            (Status::Agree | Status::CannotTell, Update::Changed) => false,
            // Without an image there is nothing to accept.
            _ => row.seconds.is_some(),
        };
        if !is_asked {
            continue;
        }
        match accept(studio, scene, sums, options, row) {
            Ok(sum) => {
                let place = scene.sha256.as_ref().map(|(_, place)| place.clone());
                sums_in_file.extend(place.map(|place| (place, sum)));
            }
            Err(NoPicture::Interrupted) => break,
            Err(NoPicture::Failed(why)) => {
                is_done = false;
                row.notes.push(format!("no new reference: {why}"));
            }
        }
    }
    for row in { results.rows.iter_mut() }.filter(|row| matches!(row.outcome, Outcome::Missing)) {
        sums.forget(&row.name)?;
        row.accepted = Some("No scene has this reference any more: its SHA-256 is forgotten, the file is still there.".to_owned());
    }
    rewrite(studio.suite, sums_in_file)?;
    Ok(is_done)
}

/// Makes one; returns its hash.
fn accept(
    studio: &Studio,
    scene: &Scene,
    sums: &mut Sums,
    options: &Options,
    row: &mut Row,
) -> Result<String, NoPicture> {
    let failed = |e: &dyn std::fmt::Display| NoPicture::Failed(e.to_string());
    let seeds = &scene.baseline_seeds;
    console::say(format_args!(
        "{}: a new reference of {} runs",
        scene.name,
        seeds.len()
    ));
    let picture = studio.picture(scene, seeds, Kind::Reference)?;
    let pixels = &picture.input.loaded.image.pixels;
    let broken = pixels.iter().filter(|pixel| !pixel.is_finite()).count();
    if broken == pixels.len() {
        let why = "none of its pixels has a finite value".to_owned();
        return Err(NoPicture::Failed(why));
    }
    if broken > 0 {
        row.notes.push(format!(
            "{broken} pixels of the new reference are infinite or not a number: they are not compared"
        ));
    }
    results::make(scene.reference.parent().unwrap_or(&scene.reference))?;
    keep(scene, &picture.input)?;
    let sum = hash(&scene.reference).map_err(|e| failed(&e))?;
    if let Some(name) = listed(studio.suite, scene) {
        sums.accept(&name, sum.clone()).map_err(|e| failed(&e))?;
    }
    let runs = match seeds.len() {
        1 => "one run".to_owned(),
        n => format!("{n} runs"),
    };
    let samples = picture.input.loaded.spp;
    let samples = samples.map_or_else(String::new, |spp| format!(" of {spp} samples a pixel"));
    row.accepted = Some(format!("Accepted: the mean of {runs}{samples}."));
    // Other seeds of the same program: whatever differs here is not the program's change.
    let image = studio.again(scene)?;
    if let Ok(report) = Report::new(input::pair(image, picture.input), options)
        && !report.comparison.agrees()
    {
        row.notes.push(format!(
            "The new reference differs from the image of the test's seeds, although the same command has rendered both. {}",
            report.comparison.sentence()
        ));
    }
    Ok(sum)
}

/// Writes a reference: the renderer's own bytes, unless its name asks for another format, or they do not say how many samples there
/// are, which is known now and not later.
fn keep(scene: &Scene, input: &Input) -> Result<(), NoPicture> {
    let failed = |e: &dyn std::fmt::Display| NoPicture::Failed(e.to_string());
    let ending = |path: &Path| {
        let ending = path.extension().unwrap_or_default();
        ending.to_string_lossy().to_lowercase()
    };
    let is_exr = ending(&scene.reference) == "exr";
    let is_same = ending(&scene.reference) == ending(&input.path);
    let is_said = || film::read(&input.path).is_ok_and(|own| own.spp == input.loaded.spp);
    if is_same && (!is_exr || is_said()) {
        let bytes = std::fs::read(&input.path).map_err(|e| failed(&e))?;
        return output::write(&scene.reference, &bytes).map_err(|e| failed(&e));
    }
    if !["exr", "pfm"].contains(&ending(&scene.reference).as_str()) {
        let (reference, image) = (scene.reference.display(), input.path.display());
        return Err(NoPicture::Failed(format!(
            "{reference}: {image} cannot be written in the format of this name: end the scene's `reference` in .exr"
        )));
    }
    let seed = scene.baseline_seeds.first().copied().unwrap_or_default();
    let noted = metadata(&input.loaded, &scene.file, seed);
    let written = film::write(&scene.reference, &input.loaded.image, &noted);
    written.map_err(|e| failed(&e))
}

/// Writes the hashes that the suite file itself holds.
fn rewrite(suite: &Suite, mut sums: Vec<(std::ops::Range<usize>, String)>) -> Result<(), Failure> {
    if sums.is_empty() {
        return Ok(());
    }
    let path = &suite.file;
    let text = std::fs::read_to_string(path);
    let mut text =
        text.map_err(|e| Failure::new(format!("{}: cannot read: {e}", path.display()), true))?;
    sums.sort_by_key(|(place, _)| std::cmp::Reverse(place.start));
    for (place, sum) in sums {
        if text.get(place.clone()).is_some() {
            text.replace_range(place, &format!("\"{sum}\""));
        }
    }
    Ok(output::write(path, text.as_bytes())?)
}
