//! `--write-partial`: a thread that writes the unfinished image now and then.

use crate::cli::checkpoint::partial;
use crate::cli::messages;
use crate::film::{self, Encoding, FilmMetadata};
use crate::session::Live;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::Duration;

/// Images that are being written.
pub(super) struct Partial {
    /// Closed when the render is over.
    over: Sender<()>,
    /// Answers which files there are.
    thread: Option<JoinHandle<Vec<PathBuf>>>,
}

impl Partial {
    /// Writes `live` again and again beside the images of these names.
    pub(super) fn start(
        every: Duration,
        images: Vec<PathBuf>,
        live: &Arc<Live>,
        (metadata, encoding): (FilmMetadata, Encoding),
        quiet: bool,
    ) -> Partial {
        let (over, orders) = channel::<()>();
        let live = Arc::clone(live);
        let thread = std::thread::Builder::new().name("partial".into());
        let thread = thread.spawn(move || {
            let (mut written, mut quiet) = (Vec::new(), quiet);
            while let Err(RecvTimeoutError::Timeout) = orders.recv_timeout(every) {
                let trouble = write(&live, &images, (&metadata, &encoding), &mut written);
                if let Some(error) = trouble.filter(|_| !std::mem::replace(&mut quiet, true)) {
                    messages::warning(format!("--write-partial: {error}; the render continues"));
                }
            }
            written
        });
        Partial {
            over,
            thread: thread.ok(),
        }
    }

    /// Writes no more. Returns the files that were written.
    pub(super) fn finish(self) -> Vec<PathBuf> {
        drop(self.over);
        let thread = self.thread.map(JoinHandle::join);
        thread.and_then(Result::ok).unwrap_or_default()
    }
}

/// Writes each file, whole or not at all. Returns what went wrong last.
fn write(
    live: &Live,
    images: &[PathBuf],
    (metadata, encoding): (&FilmMetadata, &Encoding),
    written: &mut Vec<PathBuf>,
) -> Option<film::WriteError> {
    let (image, spp) = live.image();
    if spp == 0.0 {
        return None;
    }
    let metadata = FilmMetadata {
        spp: spp.round().clamp(1.0, f64::from(u32::MAX)) as u32,
        ..metadata.clone()
    };
    let mut trouble = None;
    for path in images.iter().map(|image| partial(image)) {
        match film::write_as(&path, &image, &metadata, encoding) {
            Ok(()) if !written.contains(&path) => written.push(path),
            Ok(()) => {}
            Err(error) => trouble = Some(error),
        }
    }
    trouble
}
