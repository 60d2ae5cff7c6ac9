//! What is told of a render while it runs, and of how it ran: `--display-server`, `--write-partial`, `--stats`.

mod partial;
mod statistics;
mod tev;
mod viewer;

pub(super) use statistics::Times;

use super::checkpoint::CheckpointArgs;
use super::events;
use super::goal::duration;
use super::messages::Failure;
use crate::output::{self, OutputError, numbered};
use crate::session::{Outputs, Prepared, Rendered};
use clap::Args;
use partial::Partial;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::time::Duration;
use viewer::Viewer;

/// Arguments for those who look on.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "While it runs")]
pub(super) struct LiveArgs {
    /// Show the image as it grows to a viewer that speaks tev's protocol, such as localhost:14158. The render never waits
    /// for it
    #[arg(long, value_name = "HOST:PORT", value_parser = address, conflicts_with = "shard")]
    display_server: Option<String>,
    /// Write the unfinished image now and then, as OUTPUT.partial.exr, which is removed when the image is written: 30s, 5m
    #[arg(long, value_name = "TIME", value_parser = duration, allow_hyphen_values = true, conflicts_with = "shard")]
    write_partial: Option<Duration>,
    /// Write time by phase, rays, memory, samples, what lights and materials were met, and the lengths of paths as JSON
    #[arg(long, value_name = "FILE.json", conflicts_with = "shard")]
    stats: Option<PathBuf>,
}

/// Parses a host and a port; whether they exist is found out later.
fn address(text: &str) -> Result<String, String> {
    let parts = text.rsplit_once(':');
    let is_good = |(host, port): (&str, &str)| !host.is_empty() && port.parse::<u16>().is_ok();
    match parts.is_some_and(is_good) {
        true => Ok(text.to_string()),
        false => Err("expected HOST:PORT, such as localhost:14158".to_string()),
    }
}

/// Those who look at a frame.
pub(super) struct Onlookers {
    viewer: Option<Viewer>,
    partial: Option<Partial>,
}

impl LiveArgs {
    /// Refuses a file of statistics that cannot be written, or is one of those that are `read`, or that an image or a checkpoint is written over.
    pub(super) fn check(
        &self,
        outputs: &[Outputs],
        read: &[PathBuf],
        checkpoint: &CheckpointArgs,
    ) -> Result<(), Failure> {
        if self.stats.is_none() {
            return Ok(());
        }
        let images = outputs.iter().flat_map(Outputs::paths);
        let images: BTreeSet<PathBuf> = images.filter_map(output::resolved).collect();
        let checkpoints = checkpoint.places(outputs);
        let numbers = 1..=outputs.len();
        let all: Vec<PathBuf> = numbers.filter_map(|number| self.stats_of(number)).collect();
        let said = |failure: Failure| failure.said(|why| format!("--stats {why}"));
        for path in &all {
            let place = output::resolved(path);
            let is_in =
                |taken: &BTreeSet<PathBuf>| place.as_ref().is_some_and(|p| taken.contains(p));
            let taken = [
                (&images, "an image is written there"),
                (&checkpoints, "the checkpoint has this name"),
            ];
            if let Some((_, why)) = taken.into_iter().find(|(places, _)| is_in(places)) {
                let path = path.display();
                return Err(format!("--stats {path}: {why}").into());
            }
            output::check(path).map_err(Failure::from).map_err(said)?;
        }
        let checked = output::check_apart(&all, read).map_err(Failure::from);
        checked.map_err(said)
    }

    fn stats_of(&self, number: usize) -> Option<PathBuf> {
        { self.stats.as_ref() }.map(|path| numbered(path, number))
    }

    /// Lets those who are asked for look at a frame, which is about to be rendered.
    pub(super) fn start(&self, frame: &mut Prepared, outputs: &Outputs, quiet: bool) -> Onlookers {
        if self.stats.is_some() {
            frame.count();
        }
        let viewer = self.display_server.as_ref().map(|address| {
            let name = outputs.image().display().to_string();
            let live = frame.live();
            Viewer::start(
                address,
                (name, &frame.metadata().light_layers),
                &live,
                quiet,
            )
        });
        // Pipes and devices have nothing beside them.
        let is_plain = |image: &&Path| !image.exists() || image.is_file();
        let partial = self.write_partial.map(|every| {
            let images = outputs.paths().filter(is_plain).map(Path::to_owned);
            let how = (frame.metadata(), frame.encoding());
            Partial::start(every, images.collect(), &frame.live(), how, quiet)
        });
        Onlookers { viewer, partial }
    }

    /// Writes what was counted.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub(super) fn write(
        &self,
        frame: &Prepared,
        rendered: &Rendered,
        number: usize,
        times: &Times,
    ) -> Result<(), OutputError> {
        let Some(path) = self.stats_of(number) else {
            return Ok(());
        };
        let text = format!("{:#}\n", statistics::of(frame, rendered, number, times));
        output::write(&path, text.as_bytes())?;
        events::written(&path);
        Ok(())
    }
}

impl Onlookers {
    /// No more unfinished images are written. Returns the files of those that were.
    pub(super) fn stop_writing(&mut self) -> Vec<PathBuf> {
        self.partial.take().map(Partial::finish).unwrap_or_default()
    }

    /// The viewer gets the image.
    pub(super) fn show(&mut self, rendered: &Rendered) {
        if let Some(viewer) = self.viewer.take() {
            viewer.finish(&rendered.image, rendered.spp as f32);
        }
    }
}
