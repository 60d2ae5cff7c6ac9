//! Runs a command to its end, or to that of our patience.

use std::ffi::OsString;
use std::fs::File;
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::time::{Duration, Instant};

/// Why a command has not done its work.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum RunError {
    /// It cannot be started.
    #[error("cannot start `{program}`: {reason}")]
    Start {
        /// The program.
        program: String,
        /// Why.
        reason: String,
    },
    /// It said that it failed.
    #[error("the command failed ({0})")]
    Failed(String),
    /// It took too long, and was ended with all that it had started.
    #[error("the command did not end within {} s, and was stopped", .0.as_secs_f64())]
    TimedOut(Duration),
    /// The suite was interrupted, and the command with it.
    #[error("interrupted")]
    Interrupted,
}

/// How often a command is asked whether it has ended: at first, and at most.
const ASKED: [Duration; 2] = [Duration::from_millis(2), Duration::from_millis(100)];

/// Runs a command in `folder`; what it prints, on either stream, goes to the file `log`. Ends it, and on Unix all processes of its
/// group, if it takes longer than `limit` or `stop` is set. Returns how long it took.
///
/// # Errors
/// See [`RunError`].
pub fn run(
    command: &[OsString],
    folder: &Path,
    log: &Path,
    limit: Duration,
    stop: &AtomicBool,
) -> Result<Duration, RunError> {
    let started = Instant::now();
    let mut child = start(command, folder, log)?;
    let [mut pause, longest] = ASKED;
    loop {
        let waited = child
            .try_wait()
            .map_err(|e| RunError::Failed(e.to_string()));
        if let Some(status) = waited? {
            return ended(status).map(|()| started.elapsed());
        }
        let is_late = started.elapsed() > limit;
        if is_late || stop.load(Relaxed) {
            end(&mut child);
            return Err(match is_late {
                true => RunError::TimedOut(limit),
                false => RunError::Interrupted,
            });
        }
        std::thread::sleep(pause);
        pause = (pause * 2).min(longest);
    }
}

fn start(command: &[OsString], folder: &Path, log: &Path) -> Result<Child, RunError> {
    let name = command.first().cloned().unwrap_or_default();
    let failed = |reason: std::io::Error| RunError::Start {
        program: name.to_string_lossy().into_owned(),
        reason: match reason.kind() {
            std::io::ErrorKind::NotFound => "there is no such program".to_owned(),
            _ => reason.to_string(),
        },
    };
    let output = File::create(log).map_err(failed)?;
    let errors = output.try_clone().map_err(failed)?;
    // A name without folders is looked for in PATH, one with is the suite's.
    let beside = folder.join(&name);
    let is_path = Path::new(&name).components().count() > 1;
    let mut process = Command::new(if is_path { beside.into() } else { name.clone() });
    process.args(command.iter().skip(1)).current_dir(folder);
    process.stdin(Stdio::null()).stdout(output).stderr(errors);
    #[cfg(unix)]
    std::os::unix::process::CommandExt::process_group(&mut process, 0);
    process.spawn().map_err(failed)
}

fn ended(status: ExitStatus) -> Result<(), RunError> {
    if status.success() {
        return Ok(());
    }
    #[cfg(unix)]
    if let Some(signal) = std::os::unix::process::ExitStatusExt::signal(&status) {
        return Err(RunError::Failed(format!("ended by signal {signal}")));
    }
    let code = status
        .code()
        .map_or("unknown".to_owned(), |code| code.to_string());
    Err(RunError::Failed(format!("exit code {code}")))
}

fn end(child: &mut Child) {
    #[cfg(unix)]
    {
        use rustix::process::{Pid, Signal, kill_process_group};
        let group = i32::try_from(child.id()).ok().and_then(Pid::from_raw);
        // It may have ended by itself meanwhile.
        let _ = group.map(|group| kill_process_group(group, Signal::KILL));
    }
    let _ = child.kill();
    let _ = child.wait();
}

/// The end of what a command has printed, for people: at most so many lines.
pub fn last_lines(log: &Path, most: usize) -> String {
    const LONGEST: usize = 4096;
    let bytes = std::fs::read(log).unwrap_or_default();
    let bytes = &bytes[bytes.len().saturating_sub(LONGEST)..];
    let text = String::from_utf8_lossy(bytes);
    let lines: Vec<&str> = { text.lines() }
        .filter(|line| !line.trim().is_empty())
        .collect();
    lines[lines.len().saturating_sub(most)..].join("\n")
}

#[cfg(test)]
#[cfg(unix)]
mod tests {
    use super::*;

    fn run_line(line: &str, limit: Duration, stop: bool) -> (Result<Duration, RunError>, String) {
        let folder = tempfile::tempdir().expect("a folder");
        let log = folder.path().join("log");
        let command: Vec<OsString> = ["sh", "-c", line].map(OsString::from).to_vec();
        let done = run(&command, folder.path(), &log, limit, &AtomicBool::new(stop));
        (done, last_lines(&log, 2))
    }

    #[test]
    fn commands_end_as_they_do() {
        let long = Duration::from_secs(60);
        let (done, said) = run_line("echo one; echo two >&2; echo three", long, false);
        assert!(done.is_ok());
        assert_eq!(said, "two\nthree");
        let (failed, said) = run_line("echo no light; exit 3", long, false);
        assert_eq!(failed, Err(RunError::Failed("exit code 3".to_owned())));
        assert_eq!(said, "no light");
        let (killed, _) = run_line("kill -9 $$", long, false);
        assert_eq!(
            killed,
            Err(RunError::Failed("ended by signal 9".to_owned()))
        );
    }

    /// With what it has started: a grandchild would hold the machine, or the log, for a minute.
    #[test]
    fn patience_ends() {
        let limit = Duration::from_millis(200);
        let started = Instant::now();
        let (late, _) = run_line("sleep 60 & sleep 60; wait", limit, false);
        assert_eq!(late, Err(RunError::TimedOut(limit)));
        let (stopped, _) = run_line("sleep 60", Duration::from_secs(60), true);
        assert_eq!(stopped, Err(RunError::Interrupted));
        // A busy machine takes its time, but not that of the commands.
        assert!(started.elapsed() < Duration::from_secs(30));
    }

    #[test]
    fn programs_that_are_not_there() {
        let folder = tempfile::tempdir().expect("a folder");
        let command = [OsString::from("no-such-renderer")];
        let (limit, stop) = (Duration::from_secs(1), AtomicBool::new(false));
        let done = run(
            &command,
            folder.path(),
            &folder.path().join("log"),
            limit,
            &stop,
        );
        let message = done.expect_err("no program").to_string();
        assert_eq!(
            message,
            "cannot start `no-such-renderer`: there is no such program"
        );
    }
}
