//! The command line: one file per command. Progress and messages go to standard error, results to standard output or
//! files.
//!
//! | exit code | meaning |
//! |--:|---|
//! | 0 | done |
//! | 1 | the answer is no, or the image does not show the whole scene (`--keep-going`) |
//! | 2 | bad input: the same command will never work |
//! | 3 | it cannot be told |
//! | 70 | a bug in fstop |
//! | 74 | a file could not be read or written on this machine |
//! | 75 | interrupted, and the same command continues from the checkpoint |
//! | 130 | interrupted without a checkpoint |

mod bugs;
mod check;
mod checkpoint;
mod codes;
mod compare;
mod completions;
mod encoding;
mod events;
mod farm;
mod goal;
mod html;
mod lens;
mod live;
mod merge;
mod messages;
mod progress;
mod render;
mod results;
mod shard;
mod suite;
mod summary;
mod tradeoff;
mod values;

use crate::cameras::Compat;
use crate::console;
use crate::math::instruction_set;
use crate::optics::models::ModelKind;
use crate::params::Dialect;
use crate::scene::dialect::DialectChoice;
use crate::session::{Policy, ReadOptions, Scene, parse_size, threads_started};
use crate::syntax::suggest::nearest;
use clap::{Args, Parser, Subcommand, ValueEnum};
use codes::{BAD_INPUT, IO_FAILED};
use std::ffi::OsString;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

#[derive(Parser)]
#[command(name = "fstop", version, about, long_about = None, after_help = concat!("`fstop SCENE` alone means `fstop render SCENE`.\n\n", codes::exit_codes!()))]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Render a scene to an EXR (or PNG, PFM, TGA by the output's extension)
    Render(render::RenderArgs),
    /// List every problem of scene files without rendering
    Check(check::CheckArgs),
    /// Describe a lens: surfaces, focal length, f-number, planes and pupils
    Lens(lens::LensArgs),
    /// Test whether two images agree, or all those of two folders
    Compare(compare::CompareArgs),
    /// Render many scenes, by any renderer, and test whether their images agree with references. Exit code 1: one does not
    Suite(suite::SuiteArgs),
    /// Make one image of the shards that `render --shard` leaves. Exit code 0: done; 1: some are missing, or another round is
    /// needed
    Merge(merge::MergeArgs),
    /// Measure what each setting costs and gains on a scene, and recommend the cheapest one for an error
    Tradeoff(tradeoff::TradeoffArgs),
    /// Write what a render farm needs to render a scene in shards
    Farm(farm::FarmArgs),
    /// Print a shell's script that completes commands and options
    Completions(completions::CompletionsArgs),
    /// Write a manual page for each command
    Man(completions::ManArgs),
}

/// How scene files are read; shared by `render` and `check`.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "How the scene is read")]
pub(crate) struct ReadArgs {
    /// Treat warnings as errors
    #[arg(long)]
    strict: bool,
    /// Read the file as pbrt-v2 or pbrt-v3 instead of deciding from its contents
    #[arg(long, value_enum)]
    dialect: Option<DialectArg>,
    /// Reproduce a quirk of another renderer that changes the image
    #[arg(long, value_enum)]
    compat: Option<CompatArg>,
    /// Realistic camera: lens model, instead of the scene's choice
    #[arg(long, value_enum)]
    lens_model: Option<LensModelArg>,
    /// Realistic camera: set the stop by this f-number, instead of the scene's diameter or number
    #[arg(long, value_name = "N", value_parser = parse_f_number, allow_negative_numbers = true)]
    f_number: Option<f64>,
    /// Realistic camera: focus on what the image shows at this point, such as 0.5,0.4: fractions of its width and height, from the upper left
    #[arg(long, value_name = "X,Y", value_parser = parse_focus_point, allow_negative_numbers = true)]
    focus_point: Option<[f64; 2]>,
    /// Memory that images, meshes and the film may take, such as 8G; exceeding it is an error at the line that needs
    /// more. By default what the machine, or this process's control group, provides
    #[arg(long, value_name = "SIZE", value_parser = parse_size)]
    max_memory: Option<u64>,
    /// Read no file outside this folder, whatever the scene names, nor write its image anywhere else unless -o says so:
    /// for services that render untrusted scenes
    #[arg(long, value_name = "DIR")]
    files_within: Option<PathBuf>,
}

#[derive(ValueEnum, Clone, Copy, Debug)]
enum LensModelArg {
    Exact,
    Thick,
    Thin,
}

#[derive(ValueEnum, Clone, Copy, Debug)]
enum DialectArg {
    V2,
    V3,
}

#[derive(ValueEnum, Clone, Copy, Debug)]
enum CompatArg {
    /// Realistic camera: sample the rear element's flat disk, drop samples whose neighbor is vignetted
    #[value(name = "pbrt-v2")]
    PbrtV2,
}

/// An f-number, with or without its f/.
fn parse_f_number(text: &str) -> Result<f64, String> {
    let number = text.strip_prefix("f/").unwrap_or(text).parse::<f64>();
    let number = number.ok().filter(|n| *n > 0.0 && n.is_finite());
    number.ok_or_else(|| "expected a positive number, such as 5.6 or f/5.6".to_string())
}

/// A point of the image.
fn parse_focus_point(text: &str) -> Result<[f64; 2], String> {
    let part = |text: &str| text.trim().parse().ok().filter(|x| (0.0..=1.0).contains(x));
    let point = text
        .split_once(',')
        .and_then(|(x, y)| Some([part(x)?, part(y)?]));
    point.ok_or_else(|| "expected two numbers from 0 to 1, such as 0.5,0.4".to_string())
}

impl ReadArgs {
    fn policy(&self) -> Policy {
        match self.strict {
            true => Policy::Warnings,
            false => Policy::Errors,
        }
    }

    /// Warns of options for lenses where the scene has none.
    fn warn_of_no_lens(&self, scene: &Scene) {
        let given = [
            ("--lens-model", self.lens_model.is_some()),
            ("--f-number", self.f_number.is_some()),
            ("--focus-point", self.focus_point.is_some()),
            ("--compat", self.compat.is_some()),
        ];
        for (option, _) in { given.iter() }.filter(|(_, is_given)| *is_given && !scene.has_lens()) {
            messages::warning(format!(
                "{option} has no effect: the scene has no `realistic` camera, whose lens it would set"
            ));
        }
    }

    fn options(&self, policy: Policy) -> ReadOptions {
        ReadOptions {
            policy,
            dialect: match self.dialect {
                None => DialectChoice::Auto,
                Some(DialectArg::V2) => DialectChoice::Fixed(Dialect::V2),
                Some(DialectArg::V3) => DialectChoice::Fixed(Dialect::V3),
            },
            compat: self.compat.map(|CompatArg::PbrtV2| Compat::PbrtV2),
            lens_model: self.lens_model.map(|model| match model {
                LensModelArg::Exact => ModelKind::Exact,
                LensModelArg::Thick => ModelKind::Thick,
                LensModelArg::Thin => ModelKind::Thin,
            }),
            f_number: self.f_number,
            focus_point: self.focus_point,
            max_memory: self.max_memory,
            files_within: self.files_within.clone(),
            details: false,
        }
    }
}

/// Runs the command line and returns the exit code.
pub fn run(args: impl IntoIterator<Item = OsString>) -> ExitCode {
    let args = args.into_iter().collect();
    let code = bugs::caught(|| run_command(args));
    events::end(code);
    ExitCode::from(code)
}

fn run_command(args: Vec<OsString>) -> u8 {
    if let Err(message) = instruction_set::check_variable() {
        return messages::Failure::from(message).exit();
    }
    let args = match with_default_command(args) {
        Ok(args) => args,
        Err(message) => return messages::Failure::from(message).exit(),
    };
    let is_for_programs = wants_json(&args);
    let cli = match Cli::try_parse_from(args) {
        Ok(cli) => cli,
        Err(error) if is_for_programs && error.use_stderr() => {
            console::speak_json();
            let text = error.render().to_string();
            let text = text.strip_prefix("error: ").unwrap_or(&text);
            return messages::Failure::from(text.trim_end().to_string()).exit();
        }
        Err(error) => {
            let printed = error.print().and_then(|()| std::io::stdout().flush());
            return match error.use_stderr() {
                true => BAD_INPUT,
                false => console::delivered(printed).map_or(IO_FAILED, |()| 0),
            };
        }
    };
    let own_pool = matches!(cli.command, Command::Render(_) | Command::Tradeoff(_));
    if !own_pool {
        // Rayon's own default would take any number from RAYON_NUM_THREADS. This fails only if the pool has already
        // been started.
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads_started(0));
        let _ = pool.build_global();
    }
    if is_for_programs {
        // From here on all is told by what is rendered; a panic before that is, too.
        console::speak_json();
    }
    bugs::rehearse();
    match cli.command {
        Command::Render(args) => render::run(&args),
        Command::Check(args) => check::run(&args),
        Command::Lens(args) => lens::run(&args),
        Command::Compare(args) => compare::run(&args),
        Command::Suite(args) => suite::run(&args),
        Command::Merge(args) => merge::run(&args),
        Command::Tradeoff(args) => tradeoff::run(&args),
        Command::Farm(args) => farm::run(&args),
        Command::Completions(args) => completions::print(&args),
        Command::Man(args) => completions::write(&args),
    }
}

/// Returns `true` if programs read what a command line leads to, although it may be none.
fn wants_json(args: &[OsString]) -> bool {
    let is_asked = |pair: &[OsString]| pair[0] == "--progress" && pair[1] == "json";
    args.windows(2).any(is_asked) || args.iter().any(|arg| arg == "--progress=json")
}

/// `fstop SCENE` means `fstop render SCENE`: if the first argument is neither a command nor a request for help,
/// `render` is inserted before it. If it is not a file either but nearly a command, that is an error.
fn with_default_command(mut args: Vec<OsString>) -> Result<Vec<OsString>, String> {
    const COMMANDS: [&str; 11] = [
        "render",
        "check",
        "lens",
        "compare",
        "suite",
        "merge",
        "tradeoff",
        "farm",
        "completions",
        "man",
        "help",
    ];
    const HELP: [&str; 4] = ["-h", "--help", "-V", "--version"];
    let Some(first) = args.get(1).map(|a| a.to_string_lossy().into_owned()) else {
        return Ok(args);
    };
    if COMMANDS.contains(&first.as_str()) || HELP.contains(&first.as_str()) {
        return Ok(args);
    }
    if let Some(meant) = nearest(&first, COMMANDS).filter(|_| !Path::new(&first).exists()) {
        return Err(format!(
            "there is no command `{first}`, nor a scene of this name; did you mean `{meant}`?"
        ));
    }
    args.insert(1, "render".into());
    Ok(args)
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn definition_is_consistent() {
        Cli::command().debug_assert();
    }

    fn completed(line: &str) -> Result<Vec<OsString>, String> {
        with_default_command(line.split(' ').map(OsString::from).collect())
    }

    #[test]
    fn a_scene_alone_is_rendered() {
        let args = completed("fstop a.pbrt --spp 4").expect("a scene");
        assert_eq!(args[1], "render");
        let args = completed("fstop check a.pbrt").expect("a command");
        assert_eq!(args.len(), 3);
    }

    #[test]
    fn a_mistyped_command_is_answered_with_the_right_one() {
        for (line, meant) in [
            ("fstop compar a b", "compare"),
            ("fstop rendr a.pbrt", "render"),
            ("fstop Check a.pbrt", "check"),
            ("fstop tradeof a.pbrt", "tradeoff"),
        ] {
            let message = completed(line).expect_err(line);
            assert!(
                message.ends_with(&format!("did you mean `{meant}`?")),
                "{message}"
            );
        }
        // Options, and names unlike any command, are left to `render`.
        for line in ["fstop --spp 4 a.pbrt", "fstop ball.pbrt", "fstop -"] {
            assert!(completed(line).is_ok(), "{line}");
        }
    }

    /// Every long help ends with two examples, and all options have headings.
    #[test]
    fn help_has_examples_and_headings() {
        for command in Cli::command().get_subcommands_mut() {
            let help = command.render_long_help().to_string();
            let (_, examples) = help.split_once("Examples:\n").expect("examples");
            let count = examples
                .lines()
                .filter(|l| l.starts_with("  fstop "))
                .count();
            assert_eq!(count, 2, "{help}");
            for long in ["threads", "film-diagonal"] {
                let option = command.get_arguments().find(|a| a.get_long() == Some(long));
                assert!(
                    option.is_none_or(|o| o.is_hide_default_value_set()),
                    "{long}"
                );
            }
            let headed = command
                .get_arguments()
                .filter(|a| a.get_help_heading().is_some());
            let options = command.get_arguments();
            let options = options.filter(|a| !a.is_positional() && a.get_id() != "help");
            assert_eq!(headed.count(), options.count(), "{help}");
        }
    }
}
