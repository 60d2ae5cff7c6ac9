//! `render --progress json`: what happens, for programs; one JSON object a line on standard error, and nothing else.

use crate::console;
use crate::session::{Outputs, Process, Step};
use serde_json::{Value, json};
use std::path::Path;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Between two lines of progress passes at most this.
const EVERY: Duration = Duration::from_millis(900);

/// Files written so far, for the last line.
static WRITTEN: Mutex<Vec<String>> = Mutex::new(Vec::new());

/// What is known of the render.
#[derive(Clone, Debug)]
struct State {
    started: Instant,
    /// Of the frame, when its first sample was due.
    sampling: Option<Instant>,
    frame: usize,
    done: u64,
    total: Option<u64>,
    pass: Option<u32>,
    spp: Option<f64>,
    error: Option<f64>,
    /// Time that sampling may take.
    limit: Option<Duration>,
    over: bool,
}

impl State {
    fn event(&self) -> Value {
        let sampling = { self.sampling }.map(|since| since.elapsed().as_secs_f64());
        let rate = { sampling }.and_then(|s| (s > 0.0).then(|| self.done as f64 / s));
        let by_samples = { self.total.zip(rate) }.and_then(|(total, rate)| {
            (rate > 0.0).then(|| total.saturating_sub(self.done) as f64 / rate)
        });
        let by_time = { self.limit.zip(sampling) }
            .map(|(limit, spent)| (limit.as_secs_f64() - spent).max(0.0));
        let process = Process::measured();
        json!({
            "event": "progress",
            "stage": if sampling.is_some() { "sampling" } else { "loading" },
            "frame": self.frame,
            "done": self.done,
            "total": self.total,
            "rate": rate,
            "left_s": by_samples.or(by_time),
            "elapsed_s": self.started.elapsed().as_secs_f64(),
            "memory_bytes": process.now,
            "peak_memory_bytes": process.peak,
            "pass": self.pass,
            "spp": self.spp,
            "error": self.error,
        })
    }
}

/// Tells of a render, at least every second while it lives.
pub(super) struct Events {
    state: Arc<(Mutex<State>, Condvar)>,
    clock: Option<JoinHandle<()>>,
}

impl Events {
    /// From now on everything on standard error is JSON.
    pub(super) fn start(scene: &Path, output: Option<&Path>) -> Events {
        console::speak_json();
        tell(json!({
            "event": "start",
            "fstop": env!("CARGO_PKG_VERSION"),
            "scene": scene.display().to_string(),
            "output": output.map(|path| path.display().to_string()),
            "process": std::process::id(),
        }));
        let state = State {
            started: Instant::now(),
            sampling: None,
            frame: 1,
            done: 0,
            total: None,
            pass: None,
            spp: None,
            error: None,
            limit: None,
            over: false,
        };
        let state = Arc::new((Mutex::new(state), Condvar::new()));
        let shared = Arc::clone(&state);
        // Without a thread of its own, there are lines when work is done.
        let clock = std::thread::Builder::new().name("progress".into());
        let clock = clock.spawn(move || tick(&shared)).ok();
        Events { state, clock }
    }

    /// A frame's turn has come; the first is 1.
    pub(super) fn frame(&self, number: usize, of: usize, outputs: &Outputs) {
        let outputs: Vec<_> = outputs.paths().map(|p| p.display().to_string()).collect();
        tell(json!({"event": "frame", "frame": number, "frames": of, "outputs": outputs}));
        let mut state = lock(&self.state.0);
        *state = State {
            frame: number,
            sampling: None,
            done: 0,
            total: None,
            pass: None,
            spp: None,
            error: None,
            ..state.clone()
        };
    }

    /// The frame's first sample is due.
    pub(super) fn sampling(&self, limit: Option<Duration>) {
        let mut state = lock(&self.state.0);
        (state.sampling, state.limit) = (Some(Instant::now()), limit);
        (state.done, state.total) = (0, None);
    }

    /// Takes note of a step.
    pub(super) fn step(&self, step: Step) {
        let mut state = lock(&self.state.0);
        match step {
            Step::Samples { done, all } => {
                // Threads may be late with what they have to say.
                state.done = state.done.max(done);
                state.total = (all > 0).then_some(all);
            }
            Step::Pass { number, spp, error } => {
                (state.pass, state.spp, state.error) = (Some(number), Some(spp), error);
            }
        }
    }

    /// Tells what there is to tell now: the frame is done.
    pub(super) fn frame_done(&self) {
        let state = lock(&self.state.0);
        tell(state.event());
    }
}

impl Drop for Events {
    fn drop(&mut self) {
        lock(&self.state.0).over = true;
        self.state.1.notify_all();
        if let Some(clock) = self.clock.take() {
            let _ = clock.join();
        }
    }
}

/// Tells of the progress now and then, until it is over.
fn tick((state, over): &(Mutex<State>, Condvar)) {
    let mut state = lock(state);
    loop {
        let waited = over.wait_timeout_while(state, EVERY, |state| !state.over);
        state = waited.unwrap_or_else(PoisonError::into_inner).0;
        if state.over {
            return;
        }
        tell(state.event());
    }
}

/// Numbers, which a panic elsewhere cannot have left inconsistent.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A file was written.
pub(super) fn written(path: &Path) {
    lock(&WRITTEN).push(path.display().to_string());
}

/// The last line, if programs listen.
pub(super) fn end(code: u8) {
    if console::is_json() {
        let written = &*lock(&WRITTEN);
        tell(json!({
            "event": "end",
            "code": code,
            "written": written,
            "peak_memory_bytes": Process::measured().peak,
        }));
    }
}

fn tell(event: Value) {
    console::say_text(&format!("{event}\n"));
}
