//! `--shard K/N`: equal parts of a render, for different machines.

use super::events::{self, Events};
use super::messages::{self, Failure};
use super::render::{End, Flaws, RenderArgs, watched};
use crate::console;
use crate::output::numbered;
use crate::session::{Frame, Outputs, RenderOptions, ShardError, ShardFile, Shards, Step};
use clap::Args;
use std::path::{Path, PathBuf};
use std::sync::Once;
use std::time::{Duration, Instant};

/// Arguments for shards.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "On many machines")]
pub(super) struct ShardArgs {
    /// Render one of N equal parts into OUT.shard-K-of-N.fsc; `fstop merge` makes the image of all of them. 3/8, or
    /// several with the scene loaded once: 5-8/64; `auto` asks Slurm, Kubernetes or AWS Batch. A shard that was
    /// interrupted is continued, one that is finished is skipped
    #[arg(long, value_name = "K/N", value_parser = requested, conflicts_with_all = ["checkpoint", "no_checkpoint", "time"])]
    shard: Option<Requested>,
    /// With --error: what `fstop merge --plan` has planned for the next round
    #[arg(long, value_name = "FILE", requires_all = ["shard", "error"])]
    plan: Option<PathBuf>,
}

/// Which shards.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Requested {
    Auto,
    Range { first: u32, last: u32, of: u32 },
}

/// Parses `3/8`, `5-8/64` or `auto`.
fn requested(text: &str) -> Result<Requested, String> {
    if text == "auto" {
        return Ok(Requested::Auto);
    }
    let expected = || {
        let most = Shards::MOST;
        format!(
            "expected K/N such as 3/8, with K from 1 to N and N up to {most}, or 5-8/64, or auto"
        )
    };
    let (range, of) = text.split_once('/').ok_or_else(expected)?;
    let (first, last) = range.split_once('-').unwrap_or((range, range));
    let number = |text: &str| text.parse::<u32>().map_err(|_| expected());
    let (first, last, of) = (number(first)?, number(last)?, number(of)?);
    let good = 1 <= first && first <= last && last <= of && of <= Shards::MOST;
    let range = Requested::Range { first, last, of };
    good.then_some(range).ok_or_else(expected)
}

/// What the engine that started this process says of its place among others, from its environment.
fn from_engine(variable: impl Fn(&str) -> Option<String>) -> Result<Requested, String> {
    let number = |name: &str| match variable(name) {
        None => Ok(None),
        Some(text) => match text.trim().parse::<i64>() {
            Ok(number) => Ok(Some(number)),
            Err(_) => Err(format!("--shard auto: {name} is `{text}`, not a number")),
        },
    };
    let given = number("FSTOP_SHARDS")?;
    let slurm = number("SLURM_ARRAY_TASK_ID")?;
    let (number, of) = if let Some(id) = slurm {
        let (first, step) = (
            number("SLURM_ARRAY_TASK_MIN")?.unwrap_or(1),
            number("SLURM_ARRAY_TASK_STEP")?.unwrap_or(1).max(1),
        );
        let of = given.map_or_else(|| number("SLURM_ARRAY_TASK_COUNT"), |of| Ok(Some(of)))?;
        let last = number("SLURM_ARRAY_TASK_MAX")?;
        let is_whole = (0..=1).contains(&first)
            && last
                .zip(of)
                .is_none_or(|(last, of)| last == first + (of - 1).saturating_mul(step));
        if given.is_none() && !is_whole {
            return Err(
                "--shard auto: this array of Slurm does not begin at 0 or 1, or has gaps: if it repeats a part of \
                 another, set FSTOP_SHARDS to the number of shards of that"
                    .to_string(),
            );
        }
        // With FSTOP_SHARDS the array may be a part of the first one, submitted again.
        let place = match given {
            Some(_) => id,
            None => id.saturating_sub(first) / step + 1,
        };
        (place, of)
    } else if let Some(index) = number("JOB_COMPLETION_INDEX")? {
        (index.saturating_add(1), given)
    } else if let Some(index) = number("AWS_BATCH_JOB_ARRAY_INDEX")? {
        let of = given.map_or_else(|| number("AWS_BATCH_JOB_ARRAY_SIZE"), |of| Ok(Some(of)))?;
        (index.saturating_add(1), of)
    } else {
        return Err(
            "--shard auto: neither Slurm (SLURM_ARRAY_TASK_ID) nor Kubernetes (JOB_COMPLETION_INDEX) nor AWS Batch \
             (AWS_BATCH_JOB_ARRAY_INDEX) has started this process as one of many"
                .to_string(),
        );
    };
    let of = of.ok_or("--shard auto: set FSTOP_SHARDS to the number of shards")?;
    requested(&format!("{number}/{of}"))
        .map_err(|_| format!("--shard auto: there is no shard {number} of {of}"))
}

impl ShardArgs {
    /// The shards to render, if the image is not rendered whole.
    pub(super) fn range(&self) -> Result<Option<(u32, u32, u32)>, String> {
        let range = match self.shard {
            Some(Requested::Auto) => from_engine(|name| std::env::var(name).ok())?,
            Some(range) => range,
            None => return Ok(None),
        };
        Ok(match range {
            Requested::Range { first, last, of } => Some((first, last, of)),
            Requested::Auto => None,
        })
    }

    /// Those of a frame, with their files.
    pub(super) fn of_frame(
        &self,
        (first, last, of): (u32, u32, u32),
        outputs: &Outputs,
        number: usize,
        every: Duration,
    ) -> Shards {
        let file = |shard: u32| ShardFile {
            number: shard,
            of,
            path: shard_path(outputs.image(), shard, of),
        };
        let mut shards = Shards::new((first..=last).map(file).collect(), every);
        shards.plan = self.plan.as_ref().map(|plan| numbered(plan, number));
        shards
    }
}

/// `a/image.exr` as `a/image.shard-3-of-8.fsc`.
fn shard_path(image: &Path, number: u32, of: u32) -> PathBuf {
    image.with_extension(format!("shard-{number}-of-{of}.fsc"))
}

/// Renders the shards of a frame that are not finished.
pub(super) fn render_shards(
    args: &RenderArgs,
    options: &RenderOptions,
    frame: Frame,
    shards: &Shards,
    (listening, events): (&Once, Option<&Events>),
) -> Result<Flaws, End> {
    let say = |file: &ShardFile, what: &str| {
        if !args.is_quiet() {
            console::say(format_args!("{}: {what}", file.path.display()));
        }
    };
    let rest = frame.unfinished(shards, options)?;
    for file in { shards.files.iter() }.filter(|file| !rest.files().contains(file)) {
        say(file, "finished before");
    }
    if rest.files().is_empty() {
        return Ok(Flaws::default());
    }
    let frame = args.prepare(frame, options, listening)?;
    for file in rest.files() {
        let started = Instant::now();
        let render = |report: &(dyn Fn(Step) + Sync)| frame.render_shard(file, &rest, report);
        let done = watched(args, events, false, render);
        let failed = |error: ShardError| Failure::new(&error, error.is_failure());
        if !done.map_err(failed)? {
            say(file, "interrupted; the same command continues");
            return Err(End::Interrupted { kept: true });
        }
        let ShardFile { number, of, .. } = file;
        let seconds = started.elapsed().as_secs_f64();
        events::written(&file.path);
        say(
            file,
            &format!("shard {number}/{of} is done, {seconds:.2} s"),
        );
    }
    Ok(Flaws::passed(frame.problems().recoverable_errors()))
}

/// Says which options are those of `merge`: each with whether it is given.
pub(super) fn warn(options: &[(&str, bool)]) {
    for (option, _) in options.iter().filter(|(_, is_given)| *is_given) {
        messages::warning(format!(
            "{option} has no effect with --shard: `fstop merge` has it"
        ));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shards_are_named_from_1() {
        let range = |first, last, of| Ok(Requested::Range { first, last, of });
        assert_eq!(requested("3/8"), range(3, 3, 8));
        assert_eq!(requested("5-8/64"), range(5, 8, 64));
        assert_eq!(requested("1/1"), range(1, 1, 1));
        assert_eq!(requested("auto"), Ok(Requested::Auto));
        for wrong in [
            "0/8", "9/8", "8-5/64", "3", "/8", "3/", "3/8/9", "-1/8", "a/b", "1/100001",
        ] {
            assert!(requested(wrong).unwrap_err().contains("K/N"), "{wrong}");
        }
    }

    #[test]
    fn engines_are_understood() {
        let of = |variables: &[(&str, &str)]| {
            from_engine(|name| {
                let found = variables.iter().find(|(variable, _)| *variable == name);
                found.map(|(_, value)| (*value).to_string())
            })
        };
        let one = |number, of| {
            Ok(Requested::Range {
                first: number,
                last: number,
                of,
            })
        };
        let slurm = [
            ("SLURM_ARRAY_TASK_ID", "3"),
            ("SLURM_ARRAY_TASK_MIN", "1"),
            ("SLURM_ARRAY_TASK_COUNT", "4"),
        ];
        assert_eq!(of(&slurm), one(3, 4));
        assert_eq!(
            of(&[&slurm[..], &[("SLURM_ARRAY_TASK_STEP", "2")]].concat()),
            one(2, 4)
        );
        // Some of them again.
        assert_eq!(
            of(&[&slurm[..], &[("FSTOP_SHARDS", "64")]].concat()),
            one(3, 64)
        );
        let kubernetes = [("JOB_COMPLETION_INDEX", "0"), ("FSTOP_SHARDS", "8")];
        assert_eq!(of(&kubernetes), one(1, 8));
        let aws = [
            ("AWS_BATCH_JOB_ARRAY_INDEX", "7"),
            ("AWS_BATCH_JOB_ARRAY_SIZE", "8"),
        ];
        assert_eq!(of(&aws), one(8, 8));
        for (wrong, what) in [
            (&[][..], "neither Slurm"),
            (&kubernetes[..1], "set FSTOP_SHARDS"),
            (
                &[&slurm[..], &[("SLURM_ARRAY_TASK_MAX", "7")]].concat(),
                "has gaps",
            ),
            (
                &[("SLURM_ARRAY_TASK_ID", "3"), ("SLURM_ARRAY_TASK_MIN", "3")],
                "has gaps",
            ),
            (
                &[("JOB_COMPLETION_INDEX", "8"), ("FSTOP_SHARDS", "8")],
                "no shard 9 of 8",
            ),
            (&[("JOB_COMPLETION_INDEX", "x")], "is `x`, not a number"),
        ] {
            let message = of(wrong).unwrap_err();
            assert!(message.contains(what), "{message}");
        }
    }

    #[test]
    fn shards_stand_beside_the_image() {
        let path = shard_path(Path::new("a/image.2.exr"), 3, 8);
        assert_eq!(path, Path::new("a/image.2.shard-3-of-8.fsc"));
    }
}
