//! `fstop completions SHELL` and `fstop man DIR`: what shells and `man` want to know of the command line, from its definition.

use super::codes::IO_FAILED;
use super::{Cli, messages};
use crate::console;
use clap::{Args, CommandFactory};
use clap_complete::{Shell, generate};
use std::path::PathBuf;

/// Examples for the long help.
const COMPLETIONS: &str = "Examples:
  fstop completions bash > ~/.local/share/bash-completion/completions/fstop
  fstop completions fish > ~/.config/fish/completions/fstop.fish";

/// Arguments of `fstop completions`.
#[derive(Args, Debug)]
#[command(after_long_help = COMPLETIONS)]
pub(super) struct CompletionsArgs {
    /// The shell whose script is wanted
    #[arg(value_enum)]
    shell: Shell,
}

/// Prints the shell's script.
pub(super) fn print(args: &CompletionsArgs) -> u8 {
    let mut script = Vec::new();
    generate(args.shell, &mut Cli::command(), "fstop", &mut script);
    let script = String::from_utf8_lossy(&script);
    match console::answer(script.trim_end()) {
        Ok(()) => 0,
        Err(error) => {
            messages::error(error);
            IO_FAILED
        }
    }
}

/// Examples for the long help.
const MAN: &str = "Examples:
  fstop man man1 && man man1/fstop-render.1
  fstop man ~/.local/share/man/man1";

/// Arguments of `fstop man`.
#[derive(Args, Debug)]
#[command(after_long_help = MAN)]
pub(super) struct ManArgs {
    /// Folder to write the pages to; it is made where there is none
    folder: PathBuf,
}

/// Writes `fstop.1`, and a page for each command.
pub(super) fn write(args: &ManArgs) -> u8 {
    let folder = &args.folder;
    let written = std::fs::create_dir_all(folder)
        .and_then(|()| clap_mangen::generate_to(Cli::command(), folder));
    match written {
        Ok(()) => 0,
        Err(error) => {
            messages::error(format!("cannot write to {}: {error}", folder.display()));
            IO_FAILED
        }
    }
}
