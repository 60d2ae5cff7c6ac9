//! `--checkpoint`, and the signals that stop a render where it can be continued.

use super::codes::LOST;
use super::goal::duration;
use super::messages::{self, Failure};
use crate::output::{check_apart, numbered, resolved};
use crate::session::{Bytes, Checkpoint, Outputs, Prepared};
use clap::Args;
#[cfg(unix)]
use std::collections::BTreeMap;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
#[cfg(unix)]
use std::sync::atomic::Ordering::Relaxed;
use std::time::Duration;
#[cfg(unix)]
use std::time::Instant;

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

    /// Refuses a checkpoint that an image would be written over, or that is one of the files that are `read`.
    pub(super) fn check(&self, outputs: &[Outputs], read: &[PathBuf]) -> Result<(), Failure> {
        let Some(checkpoint) = &self.checkpoint else {
            return Ok(());
        };
        let images = outputs.iter().flat_map(Outputs::paths);
        let images = images.flat_map(|image| [image.to_owned(), partial(image)]);
        let images: BTreeSet<PathBuf> = images.filter_map(|image| resolved(&image)).collect();
        let numbers = 1..=outputs.len();
        let all: Vec<PathBuf> = numbers.map(|number| numbered(checkpoint, number)).collect();
        let is_taken = |path: &&PathBuf| resolved(path).is_some_and(|path| images.contains(&path));
        if let Some(path) = all.iter().find(is_taken) {
            let path = path.display();
            return Err(format!("--checkpoint {path}: an image is written there").into());
        }
        Ok(check_apart(&all, read)?)
    }

    /// Where the checkpoints of the frames may be.
    pub(super) fn places(&self, outputs: &[Outputs]) -> BTreeSet<PathBuf> {
        let frames = outputs.iter().zip(1..);
        let checkpoints = frames.filter_map(|(one, number)| self.of_frame(one, number));
        { checkpoints.filter_map(|checkpoint| resolved(&checkpoint.path)) }.collect()
    }

    /// The checkpoint of one frame, if it is to have one. Pipes and devices have nothing beside them.
    pub(super) fn of_frame(&self, outputs: &Outputs, number: usize) -> Option<Checkpoint> {
        let image = outputs.image();
        let (path, after) = match &self.checkpoint {
            _ if self.no_checkpoint => return None,
            Some(path) => (numbered(path, number), Duration::ZERO),
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

/// Refuses unfinished images that would be written over files that are `read`, or over other images. Shards write none.
pub(super) fn check_unfinished(outputs: &[Outputs], read: &[PathBuf]) -> Result<(), Failure> {
    let images = || outputs.iter().flat_map(Outputs::paths);
    let unfinished: Vec<PathBuf> = images().map(partial).collect();
    let places: BTreeSet<PathBuf> = unfinished
        .iter()
        .filter_map(|path| resolved(path))
        .collect();
    let is_unfinished = |image: &&Path| resolved(image).is_some_and(|path| places.contains(&path));
    if let Some(image) = images().find(is_unfinished) {
        let image = image.display();
        return Err(
            format!("{image}: unfinished images of the other output have this name").into(),
        );
    }
    Ok(check_apart(&unfinished, read)?)
}

/// Signals that come within this time are one: `timeout` sends each twice, and clusters send SIGTERM to a job and to its steps.
#[cfg(unix)]
const TOGETHER: [Duration; 2] = [Duration::from_millis(300), Duration::from_secs(60)];

/// From now on Ctrl-C, and what a cluster sends before it ends a job, set a flag. Later another Ctrl-C or SIGTERM ends the program at
/// once, as where a pipe has no reader. What is written beyond a limit of the size of files fails as on a full disk, instead of ending the program.
#[cfg(unix)]
pub(super) fn listen(stop: &Arc<AtomicBool>) {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM, SIGUSR1, SIGXFSZ};
    use signal_hook::flag;
    use signal_hook::iterator::Signals;
    let _ = flag::register(SIGXFSZ, Arc::default());
    let ignored = ignored_signals();
    // Such as by `nohup`, whose user wants the render to continue.
    let is_heard = |signal: &i32| ignored >> (signal - 1) & 1 == 0;
    let heard = [SIGINT, SIGTERM, SIGUSR1, SIGHUP];
    let heard: Vec<i32> = heard.into_iter().filter(is_heard).collect();
    let of_thread = Arc::clone(stop);
    let listening = Signals::new(&heard).and_then(|mut signals| {
        let listen = move || {
            let mut first = BTreeMap::new();
            for signal in signals.forever() {
                of_thread.store(true, Relaxed);
                let since = *first.entry(signal).or_insert_with(Instant::now);
                let [interrupts, terminations] = TOGETHER;
                let is_another = match signal {
                    SIGINT => since.elapsed() > interrupts,
                    SIGTERM => since.elapsed() > terminations,
                    _ => false,
                };
                if is_another {
                    signal_hook::low_level::exit(LOST.into());
                }
            }
        };
        std::thread::Builder::new()
            .name("signals".to_string())
            .spawn(listen)
    });
    let caught = listening.map(drop).or_else(|_| {
        // Without a thread they set the flag, and end nothing.
        let flags = heard
            .iter()
            .map(|signal| flag::register(*signal, Arc::clone(stop)));
        flags.collect::<Result<Vec<_>, _>>().map(drop)
    });
    warn_if_not(caught);
}

/// From now on Ctrl-C sets a flag; a second one ends the program at once.
#[cfg(not(unix))]
pub(super) fn listen(stop: &Arc<AtomicBool>) {
    use signal_hook::consts::{SIGINT, SIGTERM};
    use signal_hook::flag;
    let ends = flag::register_conditional_shutdown(SIGINT, LOST.into(), Arc::clone(stop));
    let flags = [SIGINT, SIGTERM].map(|signal| flag::register(signal, Arc::clone(stop)));
    let all = flags.into_iter().chain([ends]);
    warn_if_not(all.collect::<Result<Vec<_>, _>>().map(drop));
}

fn warn_if_not(caught: std::io::Result<()>) {
    if caught.is_err() {
        messages::warning(
            "signals cannot be caught: an interrupted render continues from its checkpoint only",
        );
    }
}

/// The signals that the program was started to ignore, a bit each; none where that is not known.
#[cfg(unix)]
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
