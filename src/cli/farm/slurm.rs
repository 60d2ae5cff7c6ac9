//! Scripts for Slurm, from the templates beside this file: an array with a task for each shard, and a job that merges.

use crate::cli::codes::BAD_INPUT;
use crate::cli::encoding::EncodingArgs;
use crate::cli::messages::{self, Failure};
use crate::cli::render::RenderArgs;
use crate::session::{OutputNames, Outputs, Process, Scene, parse_size};
use crate::{console, output};
use clap::{Args, Parser};
use std::path::{Path, PathBuf};

const RENDER: &str = include_str!("render.sbatch");
const MERGE: &str = include_str!("merge.sbatch");

/// What the script does with a task that is to continue.
const TRAPS: &str = include_str!("traps.sh");
const AGAIN: &str = include_str!("again.sh");

/// The same where that is left to the user.
const TRAP: &str = "# Both signals end the render and keep its work.
trap 'kill -TERM \"$render\" 2>/dev/null' USR1 TERM
";

/// The shortest time limit, in seconds: a task that is told to end two minutes before it, or three, still gets on.
const SHORTEST: u64 = 5 * 60;

/// Largest number of an array's task as Slurm comes (`MaxArraySize` less 1).
const USUAL_TASKS: u32 = 1000;

/// Arguments of `fstop farm slurm`.
#[derive(Args, Debug)]
#[command(after_long_help = super::EXAMPLES)]
pub(super) struct SlurmArgs {
    /// Scene file
    scene: PathBuf,
    /// Image that the shards are merged into; the scripts are written beside it. By default SCENE.exr in this folder
    #[arg(help_heading = "Output", short, long)]
    output: Option<PathBuf>,
    /// Also a PNG of the image
    #[arg(help_heading = "Output", long)]
    png: Option<PathBuf>,
    /// Also the variance of each pixel's mean (channels var.R, var.G, var.B)
    #[arg(help_heading = "Output", long)]
    variance: bool,
    #[command(flatten)]
    encoding: EncodingArgs,
    /// How many pieces of equal cost the work is divided into; each loads the scene anew
    #[arg(help_heading = "Tasks", long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    shards: u32,
    /// Processors of each task
    #[arg(help_heading = "Tasks", long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..))]
    cpus: u32,
    /// Memory of each task, such as 8G, or `auto` for a quarter more than `fstop check --memory` forecasts; by default
    /// what the cluster gives
    #[arg(help_heading = "Tasks", long, value_name = "SIZE|auto", value_parser = memory)]
    mem: Option<Memory>,
    /// Time limit of each task as Slurm writes it: minutes, hours:minutes:seconds or days-hours; by default the
    /// partition's
    #[arg(help_heading = "Tasks", long, value_name = "LIMIT", value_parser = time_limit)]
    time: Option<String>,
    /// Partition, or several with commas
    #[arg(help_heading = "Tasks", long, value_parser = partition)]
    partition: Option<String>,
    /// Put tasks back into the queue that meet their time limit, are preempted or lose their node: they continue from
    /// their checkpoints
    #[arg(help_heading = "Tasks", long)]
    requeue: bool,
    /// Further options of `fstop render`, after `--`
    #[arg(last = true, value_name = "OPTIONS")]
    options: Vec<String>,
}

/// Memory that is asked for.
#[derive(Clone, Copy, Debug)]
enum Memory {
    Forecast,
    Bytes(u64),
}

impl Memory {
    /// In MiB, of which Slurm has whole ones; the scene was read since `before`.
    fn mebibytes(self, scene: &Scene, before: &Process) -> Result<u64, Failure> {
        let bytes = match self {
            Memory::Bytes(bytes) => bytes,
            Memory::Forecast => {
                let forecasts = scene.forecasts(before)?;
                let peaks = forecasts.iter().map(|forecast| forecast.in_passes.total());
                let peak = peaks.max().unwrap_or_default();
                // Forecasts are right within 20 %.
                peak.saturating_add(peak / 4)
            }
        };
        Ok(bytes.div_ceil(1 << 20))
    }
}

/// Writes both scripts, and prints how they are submitted.
pub(super) fn run(args: &SlurmArgs) -> u8 {
    let render = match understood(args) {
        Ok(Rendering { args }) => args,
        Err(error) => {
            let _ = error.print();
            return BAD_INPUT;
        }
    };
    match write(args, &render) {
        Ok(()) => 0,
        Err(failure) => failure.exit(),
    }
}

/// `fstop render` by itself.
#[derive(Parser)]
#[command(
    bin_name = "fstop render",
    about = "Renders a scene file to an image",
    long_about = None
)]
struct Rendering {
    #[command(flatten)]
    args: RenderArgs,
}

/// Checks that `render` takes the further options: better now than after a night in a queue.
fn understood(args: &SlurmArgs) -> Result<Rendering, clap::Error> {
    let shard = format!("1/{}", args.shards);
    let ours = [
        "render",
        "scene.pbrt",
        "-o",
        "image.exr",
        "--threads",
        "1",
        "--shard",
        &shard,
    ];
    let theirs = args.options.iter().map(String::as_str);
    Rendering::try_parse_from(ours.into_iter().chain(theirs))
}

/// Refuses options of `render` that make no sense in these scripts.
fn fitting(option: &str) -> Result<(), String> {
    let (name, _) = option.split_once('=').unwrap_or((option, ""));
    match name {
        "--png" | "--variance" | "--half" | "--exposure" => {
            Err(format!("{name} is for the merge, too: write it before `--`"))
        }
        "--error" => Err("--error is reached in rounds, and these scripts are of one: see docs/farm.md".to_owned()),
        "--keep-going" => Err(
            "--keep-going: shards would end with 1, which Slurm takes for failures, and not be merged".to_owned(),
        ),
        _ => Ok(()),
    }
}

fn write(args: &SlurmArgs, render: &RenderArgs) -> Result<(), Failure> {
    args.options.iter().try_for_each(|option| fitting(option))?;
    let scene = &args.scene;
    if !scene.is_file() {
        return Err(format!("{}: there is no such scene file", scene.display()).into());
    }
    let stem = scene.file_stem().unwrap_or_default();
    let image = { args.output.clone() }.unwrap_or_else(|| {
        let mut image = stem.to_owned();
        image.push(".exr");
        image.into()
    });
    let before = Process::measured();
    let scene = render.scene(scene)?;
    let written = OutputNames {
        image: Some(image.clone()),
        png: args.png.clone(),
        ..OutputNames::default()
    };
    let (outputs, _) = scene.outputs(&written)?;
    let memory = { args.mem }.map(|memory| memory.mebibytes(&scene, &before));
    let memory = memory.transpose()?;
    render.check_shards(scene)?;
    let names = Names::of(args, &image, &outputs)?;
    let [render, merge] = ["render.sbatch", "merge.sbatch"].map(|end| image.with_extension(end));
    for (path, template) in [(&render, RENDER), (&merge, MERGE)] {
        let script = filled(template, |name| value(name, args, memory, &names));
        output::write(path, script.as_bytes())?;
    }
    if args.shards > USUAL_TASKS {
        messages::warning(format!(
            "--shards {}: many clusters take {USUAL_TASKS} at most (`scontrol show config | grep MaxArraySize`)",
            args.shards
        ));
    }
    let [render, merge] = [word(&render)?, word(&merge)?];
    Ok(console::answer(format!(
        "job=$(sbatch --parsable {render})\n\
         sbatch --dependency=afterok:${{job%%;*}} --kill-on-invalid-dep=yes {merge}"
    ))?)
}

/// The names in the scripts, as words of the shell.
struct Names {
    fstop: String,
    scene: String,
    image: String,
    /// The merge of each frame, a line each.
    merges: String,
    /// Name of the job.
    job: String,
}

impl Names {
    fn of(args: &SlurmArgs, image: &Path, frames: &[Outputs]) -> Result<Names, String> {
        let fstop = std::env::current_exe()
            .map_err(|error| format!("it is not known where fstop lies: {error}"))?;
        let merges: Result<String, String> = frames.iter().map(|of| merge(args, of)).collect();
        let stem = image.file_stem().unwrap_or_default().to_string_lossy();
        Ok(Names {
            fstop: word(&fstop)?,
            scene: word(&args.scene)?,
            image: word(image)?,
            merges: merges?,
            job: format!("fstop-{}", stem.replace(|c| !is_plain(c), "_")),
        })
    }
}

/// The line that merges the shards of a frame; their names start with that of the image, without its ending.
fn merge(args: &SlurmArgs, frame: &Outputs) -> Result<String, String> {
    let [stem, image] = [&frame.image().with_extension(""), frame.image()].map(word);
    let mut line = format!("merge {} -o {}", stem?, image?);
    if let Some(png) = frame.paths().nth(1) {
        line += &format!(" --png {}", word(png)?);
    }
    if args.variance {
        line += " --variance";
    }
    Ok(line + &args.encoding.words() + "\n")
}

/// What replaces a name of a template.
fn value(name: &str, args: &SlurmArgs, memory: Option<u64>, names: &Names) -> String {
    match name {
        "fstop" => names.fstop.clone(),
        "scene" => names.scene.clone(),
        "output" => names.image.clone(),
        "merges" => names.merges.clone(),
        "job" => names.job.clone(),
        "shards" => args.shards.to_string(),
        "cpus" => args.cpus.to_string(),
        "options" => { args.options.iter() }
            .map(|option| quoted(option))
            .chain(args.variance.then(|| "--variance".to_owned()))
            .collect::<Vec<_>>()
            .join(" "),
        "limits" => limits(args, memory),
        "requeue" if args.requeue => {
            "# A task that is preempted or loses its node goes back into the queue.\n#SBATCH --requeue\n"
                .to_owned()
        }
        "traps" if args.requeue => TRAPS.to_owned(),
        "again" if args.requeue => AGAIN.to_owned(),
        "traps" => TRAP.to_owned(),
        _ => String::new(),
    }
}

/// The lines of what was asked for, from memory in MiB to partition.
fn limits(args: &SlurmArgs, memory: Option<u64>) -> String {
    let memory = memory.map(|mebibytes| format!("--mem={mebibytes}M"));
    let time = args.time.as_ref().map(|limit| format!("--time={limit}"));
    let partition = { args.partition.as_ref() }.map(|name| format!("--partition={name}"));
    let lines = [memory, time, partition].into_iter().flatten();
    lines.map(|line| format!("#SBATCH {line}\n")).collect()
}

/// A template with each `{{name}}` replaced.
fn filled(template: &str, value: impl Fn(&str) -> String) -> String {
    let mut parts = template.split("{{");
    let mut text = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let (name, rest) = part.split_once("}}").unwrap_or((part, ""));
        text += &value(name);
        text += rest;
    }
    text
}

/// A path as one word of the shell, which no program takes for an option.
fn word(path: &Path) -> Result<String, String> {
    let name = path
        .to_str()
        .filter(|name| !name.contains(char::is_control));
    let name = name.ok_or_else(|| {
        let path = path.display();
        format!("{path:?}: a name in a script is UTF-8 without control characters; rename it")
    })?;
    Ok(match name.starts_with('-') {
        true => quoted(&format!("./{name}")),
        false => quoted(name),
    })
}

/// A text as one word of the shell.
fn quoted(text: &str) -> String {
    match !text.is_empty() && text.chars().all(is_plain) {
        true => text.to_owned(),
        false => format!("'{}'", text.replace('\'', r"'\''")),
    }
}

/// Means nothing but itself, to the shell and to Slurm.
fn is_plain(c: char) -> bool {
    c.is_ascii_alphanumeric() || "/._-+,:=".contains(c)
}

fn memory(text: &str) -> Result<Memory, String> {
    match text {
        "auto" => Ok(Memory::Forecast),
        _ => { parse_size(text).map(Memory::Bytes) }.map_err(|error| format!("{error}, or auto")),
    }
}

fn partition(text: &str) -> Result<String, String> {
    let is_name = |name: &str| !name.is_empty() && name.chars().all(is_plain);
    match text.split(',').all(is_name) {
        true => Ok(text.to_owned()),
        false => Err("expected the name of a partition (`sinfo` lists them)".to_owned()),
    }
}

/// Checks a time limit as Slurm has it, which must leave a task time to get on.
fn time_limit(text: &str) -> Result<String, String> {
    match seconds(text) {
        Some(0..SHORTEST) => Err(format!(
            "a task is told to end two minutes before its limit, or three: it takes {} at least",
            SHORTEST / 60
        )),
        Some(_) => Ok(text.to_owned()),
        None => Err(
            "expected minutes, hours:minutes:seconds, days-hours or days-hours:minutes".to_owned(),
        ),
    }
}

/// The seconds of a time limit: `90`, `90:00`, `1:30:00`, `1-12`, `1-12:00`, `1-12:00:00`.
fn seconds(text: &str) -> Option<u64> {
    let (days, clock) = match text.split_once('-') {
        Some((days, clock)) => (Some(days.parse::<u32>().ok()?), clock),
        None => (None, text),
    };
    let numbers = clock.split(':').map(|number| number.parse::<u32>().ok());
    let numbers: Vec<u64> = numbers
        .map(|number| number.map(u64::from))
        .collect::<Option<_>>()?;
    let (hours, minutes, seconds) = match (days, numbers.as_slice()) {
        (None, &[minutes]) => (0, minutes, 0),
        (None, &[minutes, seconds]) => (0, minutes, seconds),
        (Some(_), &[hours]) => (hours, 0, 0),
        (Some(_), &[hours, minutes]) => (hours, minutes, 0),
        (_, &[hours, minutes, seconds]) => (hours, minutes, seconds),
        _ => return None,
    };
    Some(((u64::from(days.unwrap_or(0)) * 24 + hours) * 60 + minutes) * 60 + seconds)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_limits_are_slurms() {
        for (text, expected) in [
            ("90", 5400),
            ("90:30", 5430),
            ("1:30:00", 5400),
            ("1-12", 129_600),
            ("0-0:10", 600),
            ("1-0:0:1", 86_401),
        ] {
            assert_eq!(seconds(text), Some(expected), "{text}");
        }
        for bad in ["", "x", "-1", "1h", "1:2:3:4", "1-", "1.5", "+-3"] {
            assert_eq!(seconds(bad), None, "{bad}");
        }
        assert!(time_limit("4").is_err() && time_limit("5").is_ok());
    }

    #[test]
    fn words_are_one_word() {
        assert_eq!(quoted("a/b-1.exr"), "a/b-1.exr");
        assert_eq!(quoted("it's $HOME"), r"'it'\''s $HOME'");
        assert_eq!(quoted(""), "''");
        assert_eq!(word(Path::new("-x.pbrt")).as_deref(), Ok("./-x.pbrt"));
        assert!(word(Path::new("a\nb")).is_err());
    }

    #[test]
    fn values_are_not_templates() {
        let text = filled("a {{x}} {{y}} b", |name| format!("<{{{{{name}}}}}>"));
        assert_eq!(text, "a <{{x}}> <{{y}}> b");
    }
}
