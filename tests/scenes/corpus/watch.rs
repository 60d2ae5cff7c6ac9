//! Work that may panic or hang, tried piece by piece.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::mpsc;
use std::time::Duration;

/// A scene that takes longer hangs: the slowest valid one takes a fiftieth of it in a debug build.
const PATIENCE: Duration = Duration::from_secs(60);

/// Does one piece of work; what it said where it panicked.
pub(super) fn trouble(work: impl FnOnce()) -> Option<String> {
    let panicked = catch_unwind(AssertUnwindSafe(work)).err()?;
    let text = panicked
        .downcast_ref::<String>()
        .map(String::as_str)
        .or_else(|| panicked.downcast_ref::<&str>().copied());
    Some(text.unwrap_or("a panic without words").to_owned())
}

/// Runs `work` beside a watch: it reports what it is about to try, and must do so often enough.
pub(super) fn under_watch(work: impl FnOnce(&dyn Fn(&str)) -> Vec<String> + Send + 'static) {
    let (report, reports) = mpsc::channel();
    let worker = std::thread::spawn(move || {
        let work = AssertUnwindSafe(work);
        work.0(&|what| drop(report.send(what.to_owned())))
    });
    let mut last = String::from("the start");
    loop {
        match reports.recv_timeout(PATIENCE) {
            Ok(what) => last = what,
            Err(mpsc::RecvTimeoutError::Disconnected) => break,
            Err(mpsc::RecvTimeoutError::Timeout) => panic!("hangs at {last}"),
        }
    }
    let troubles = worker.join().expect("troubles are caught one by one");
    assert!(
        troubles.is_empty(),
        "{} troubles:\n{}",
        troubles.len(),
        troubles.join("\n")
    );
}
