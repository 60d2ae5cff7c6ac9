//! `--checkpoint`, and the signals that stop a render where it can be continued.

use super::codes::LOST;
use super::goal::duration;
use super::messages::{self, Failure};
use crate::output::check_apart;
use crate::session::{Bytes, Checkpoint, Outputs, Prepared};
use clap::Args;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

/// A render that takes longer than this gets a checkpoint without being asked.
const UNASKED_AFTER: Duration = Duration::from_secs(10);

/// Arguments for interrupted renders.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "If it is interrupted")]
pub(super) struct CheckpointArgs {
    /// Keep the render in this file, from the first sample on. By default it is kept in OUTPUT.fsc if it takes longer
    /// than ten seconds, and the file is removed when the image is written. The same command again continues where it
    /// was, to the same bits as without interruption
    #[arg(long, value_name = "FILE.fsc")]
    checkpoint: Option<PathBuf>,
    /// The longest time whose work may be lost: 60s, 5m, 1h
    #[arg(long, value_name = "TIME", default_value = "60s", value_parser = duration, allow_hyphen_values = true)]
    checkpoint_every: Duration,
    /// Refuse a checkpoint of another scene or of other settings; without this option it is replaced, with a warning. A
    /// shard's is always refused
    #[arg(long)]
    resume: bool,
    /// Keep nothing: an interrupted render is lost
    #[arg(long, conflicts_with_all = ["checkpoint", "resume"])]
    no_checkpoint: bool,
}

impl CheckpointArgs {
    /// The longest time whose work may be lost.
    pub(super) fn every(&self) -> Duration {
        self.checkpoint_every
    }

    /// Refuses a checkpoint that an image would be written over.
    pub(super) fn check(&self, outputs: &[Outputs]) -> Result<(), Failure> {
        let place = |path: &Path| std::path::absolute(path).ok();
        let images = || outputs.iter().flat_map(Outputs::paths);
        for number in 1..=outputs.len() {
            let Some(path) = &self.checkpoint else { break };
            let path = crate::output::numbered(path, number);
            let meets = |image: &Path| place(image) == place(&path);
            if images().any(|image| meets(image) || meets(&partial(image))) {
                let path = path.display();
                return Err(format!("--checkpoint {path}: an image is written there").into());
            }
        }
        Ok(())
    }

    /// The checkpoint of one frame, if it is to have one. Pipes and devices have nothing beside them.
    pub(super) fn of_frame(&self, outputs: &Outputs, number: usize) -> Option<Checkpoint> {
        let image = outputs.image();
        let (path, after) = match &self.checkpoint {
            _ if self.no_checkpoint => return None,
            Some(path) => (crate::output::numbered(path, number), Duration::ZERO),
            None if image.exists() && !image.is_file() => return None,
            None => (with_more(image, ".fsc"), UNASKED_AFTER),
        };
        Some(Checkpoint {
            path,
            after,
            every: self.checkpoint_every,
            required: self.resume,
        })
    }
}

/// `image.exr` as `image.exr.fsc`.
fn with_more(path: &Path, ending: &str) -> PathBuf {
    let mut name = path.file_name().unwrap_or_default().to_owned();
    name.push(ending);
    path.with_file_name(name)
}

/// Where what there is of an interrupted image goes: `image.exr` as `image.partial.exr`.
pub(super) fn partial(path: &Path) -> PathBuf {
    let ending = path.extension().unwrap_or_default().to_string_lossy();
    path.with_extension(format!("partial.{ending}"))
}

/// Refuses unfinished images that would be written over files that are `read`. Shards write none.
pub(super) fn check_unfinished(outputs: &[Outputs], read: &[PathBuf]) -> Result<(), Failure> {
    let images = outputs.iter().flat_map(Outputs::paths);
    let unfinished: Vec<PathBuf> = images.map(partial).collect();
    Ok(check_apart(&unfinished, read)?)
}

/// From now on Ctrl-C, and what a cluster sends before it ends a job, set a flag. A second Ctrl-C ends the program at
/// once.
pub(super) fn listen(stop: &Arc<AtomicBool>) {
    use signal_hook::consts::{SIGINT, SIGTERM};
    use signal_hook::flag;
    #[cfg(unix)]
    let signals = {
        use signal_hook::consts::{SIGHUP, SIGUSR1};
        [SIGINT, SIGTERM, SIGUSR1, SIGHUP]
    };
    #[cfg(not(unix))]
    let signals = [SIGINT, SIGTERM];
    let ignored = ignored_signals();
    let is_heard = |signal: &i32| ignored >> (signal - 1) & 1 == 0;
    let ends = match is_heard(&SIGINT) {
        true => flag::register_conditional_shutdown(SIGINT, LOST.into(), Arc::clone(stop)).is_ok(),
        false => true,
    };
    let registered = { signals.into_iter() }
        // Such as by `nohup`, whose user wants the render to continue.
        .filter(is_heard)
        .map(|signal| flag::register(signal, Arc::clone(stop)));
    if !ends || registered.collect::<Vec<_>>().iter().any(Result::is_err) {
        messages::warning(
            "signals cannot be caught: an interrupted render continues from its checkpoint only",
        );
    }
}

/// The signals that the program was started to ignore, a bit each; none where that is not known.
fn ignored_signals() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = { status.lines() }.find_map(|line| line.strip_prefix("SigIgn:"));
    mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok())
        .unwrap_or_default()
}

/// What a render says of its checkpoint before it starts.
pub(super) fn announce(frame: &Prepared) {
    if !frame.replaced().is_empty() {
        messages::warning(format!(
            "the checkpoint there was is of another render and is replaced: {}",
            frame.replaced().join("; ")
        ));
    }
    if frame.lost() > 0 {
        messages::warning(format!(
            "the last {} of the checkpoint were cut off or are damaged: what they held is rendered again",
            Bytes(frame.lost())
        ));
    }
    if let Some(spent) = frame.resumes() {
        crate::console::say(format_args!(
            "continuing after {:.0} s",
            spent.as_secs_f64()
        ));
    }
}
