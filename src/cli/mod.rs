//! The command line: one file per command. Progress and messages go to standard error, results to standard output or
//! files. Exit code 0: done; 1: the answer is no, or the image does not show the whole scene (`--keep-going`); 2: bad
//! input; 75: interrupted, and the same command continues; 130: interrupted without a checkpoint.

mod check;
mod checkpoint;
mod compare;
mod farm;
mod goal;
mod html;
mod lens;
mod merge;
mod messages;
mod progress;
mod render;
mod shard;
mod tradeoff;

use crate::budget::parse_size;
use crate::cameras::Compat;
use crate::console;
use crate::optics::models::ModelKind;
use crate::params::Dialect;
use crate::scene::dialect::DialectChoice;
use crate::session::{Policy, ReadOptions, threads_started};
use crate::syntax::suggest::nearest;
use clap::{Args, Parser, Subcommand, ValueEnum};
use std::ffi::OsString;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Exit code of a question answered with no.
pub(crate) const ANSWER_IS_NO: u8 = 1;

/// Exit code for input that cannot be used.
pub(crate) const BAD_INPUT: u8 = 2;

/// Exit code of an interrupted render that its checkpoint continues (EX_TEMPFAIL of sysexits.h).
pub(crate) const INTERRUPTED: u8 = 75;

/// Exit code of an interrupted render without a checkpoint, as shells give it for SIGINT.
pub(crate) const LOST: u8 = 130;

/// Exit code for images of a scene with missing files.
pub(crate) const NOT_ALL: u8 = 1;

#[derive(Parser)]
#[command(name = "fstop", version, about, long_about = None, after_help = "`fstop SCENE` alone means `fstop render SCENE`.")]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Render a scene to an EXR (or PNG, PFM, TGA by the output's extension). Exit code 0: done; 1: done in spite of
    /// errors (--keep-going); 2: refused
    Render(render::RenderArgs),
    /// List every problem of scene files without rendering
    Check(check::CheckArgs),
    /// Describe a lens: surfaces, focal length, f-number, planes and pupils
    Lens(lens::LensArgs),
    /// Test whether two images agree. Exit code 0: they agree; 1: they differ
    Compare(compare::CompareArgs),
    /// Make one image of the shards that `render --shard` leaves. Exit code 0: done; 1: some are missing, or another round is
    /// needed
    Merge(merge::MergeArgs),
    /// Measure what each setting costs and gains on a scene, and recommend the cheapest one for an error
    Tradeoff(tradeoff::TradeoffArgs),
    /// Write what a render farm needs to render a scene in shards
    Farm(farm::FarmArgs),
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

impl ReadArgs {
    fn policy(&self) -> Policy {
        match self.strict {
            true => Policy::Warnings,
            false => Policy::Errors,
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
            max_memory: self.max_memory,
            files_within: self.files_within.clone(),
            details: false,
        }
    }
}

/// Runs the command line and returns the exit code.
pub fn run(args: impl IntoIterator<Item = OsString>) -> ExitCode {
    let args = match with_default_command(args.into_iter().collect()) {
        Ok(args) => args,
        Err(message) => return messages::refused(message),
    };
    let cli = match Cli::try_parse_from(args) {
        Ok(cli) => cli,
        Err(error) => {
            let printed = error.print().and_then(|()| std::io::stdout().flush());
            if error.use_stderr() {
                return ExitCode::from(BAD_INPUT);
            }
            return console::delivered(printed)
                .map_or(ExitCode::from(BAD_INPUT), |()| ExitCode::SUCCESS);
        }
    };
    let own_pool = matches!(cli.command, Command::Render(_) | Command::Tradeoff(_));
    if !own_pool {
        // Rayon's own default would take any number from RAYON_NUM_THREADS. This fails only if the pool has already
        // been started.
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads_started(0));
        let _ = pool.build_global();
    }
    match cli.command {
        Command::Render(args) => render::run(&args),
        Command::Check(args) => check::run(&args),
        Command::Lens(args) => lens::run(&args),
        Command::Compare(args) => compare::run(&args),
        Command::Merge(args) => merge::run(&args),
        Command::Tradeoff(args) => tradeoff::run(&args),
        Command::Farm(args) => farm::run(&args),
    }
}

/// `fstop SCENE` means `fstop render SCENE`: if the first argument is neither a command nor a request for help,
/// `render` is inserted before it. If it is not a file either but nearly a command, that is an error.
fn with_default_command(mut args: Vec<OsString>) -> Result<Vec<OsString>, String> {
    const COMMANDS: [&str; 8] = [
        "render", "check", "lens", "compare", "merge", "tradeoff", "farm", "help",
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
