//! Chaos: renders that are killed, signalled, held up and continued at random, whole and in shards of random numbers and
//! orders. Each must end in the bytes of one undisturbed process.
//!
//! It takes twelve seconds; `FSTOP_CHAOS_MINUTES=30 cargo test --release --test program chaos -- --nocapture` takes thirty
//! minutes and says what happened. `FSTOP_CHAOS_SEED` repeats a run's choices, though not its timing.

use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// Stratified samples through a real lens.
const SCENE: &str = "tests/scenes/reference/realistic_dgauss50_full.pbrt";

/// One or two seconds of one processor.
const SAMPLES: &str = "400";

/// So many times may one render be disturbed before it is left alone: a disturbance may come before any work was kept.
const PATIENCE: u32 = 12;

/// xorshift64* (S. Vigna, "An experimental exploration of Marsaglia's xorshift generators, scrambled", 2016).
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        self.0.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 16
    }

    fn below(&mut self, end: u64) -> u64 {
        self.next() % end
    }

    fn shuffle<T>(&mut self, all: &mut [T]) {
        for end in (1..all.len()).rev() {
            all.swap(end, self.below(end as u64 + 1) as usize);
        }
    }
}

/// What happened. What came after a process had ended does not count.
#[derive(Debug, Default)]
struct Tally {
    renders: u32,
    shards: u32,
    kills: u32,
    signals: u32,
    holds: u32,
    /// Of one kill: time since the start of the process or the last write, whichever is later.
    most_lost: Duration,
}

struct Chaos {
    folder: tempfile::TempDir,
    random: Random,
    tally: Tally,
}

impl Chaos {
    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Runs the same command again and again, disturbing it, until it is done.
    ///
    /// `part`: how much of the whole render it is.
    fn finish(&mut self, output: &str, more: &[String], checkpoints: &[PathBuf], part: f64) {
        let spent = || checkpoints.iter().map(|file| spent(file)).sum::<Duration>();
        for attempt in 0.. {
            let threads = (1 + self.random.below(4)).to_string();
            let mut child = Command::new(env!("CARGO_BIN_EXE_fstop"))
                .args(["render", SCENE, "--quiet", "--checkpoint-every", "0.1s"])
                .args(["--threads", &threads, "-o"])
                .arg(self.path(output))
                .args(more)
                .stderr(Stdio::piped())
                .spawn()
                .expect("the program");
            let started = Instant::now();
            let before = spent();
            let fate = match attempt {
                0..PATIENCE => self.random.below(8),
                _ => u64::MAX,
            };
            // Somewhere between its start and a little after its end on two processors.
            let delay = Duration::from_secs_f64(part).mul_f64(self.random.below(1000) as f64 / 1e3);
            let delay = delay + Duration::from_millis(self.random.below(20));
            while started.elapsed() < delay && child.try_wait().expect("a child").is_none() {
                std::thread::sleep(Duration::from_millis(2));
            }
            let is_killed = self.disturb(&mut child, fate);
            let done = child.wait_with_output().expect("a child");
            let said = String::from_utf8_lossy(&done.stderr);
            self.tally.signals += u32::from((3..6).contains(&fate) && !done.status.success());
            if is_killed && done.status.code().is_none() {
                self.tally.kills += 1;
                let kept = spent().saturating_sub(before);
                let lost = started.elapsed().saturating_sub(kept);
                self.tally.most_lost = self.tally.most_lost.max(lost);
            }
            match done.status.code() {
                Some(0) => return,
                // Killed by us, before the program listened, or stopped where it can be continued; without a checkpoint
                // where there had been no work.
                None | Some(75 | 130) => {}
                Some(code) => panic!("exit code {code}: {said}"),
            }
        }
    }

    /// Returns whether the process was killed without warning.
    fn disturb(&mut self, child: &mut Child, fate: u64) -> bool {
        let id = child.id().to_string();
        let send = |signal: &str| {
            // It may have ended meanwhile.
            let mut kill = Command::new("kill");
            let sent = kill.args([signal, &id]).stderr(Stdio::null()).status();
            sent.expect("kill");
        };
        match fate {
            0..3 => {
                child.kill().expect("it can be killed");
                return true;
            }
            3..6 => {
                let signals = ["-TERM", "-INT", "-USR1", "-HUP"];
                send(signals[self.random.below(4) as usize]);
            }
            6 => {
                self.tally.holds += 1;
                send("-STOP");
                std::thread::sleep(Duration::from_millis(self.random.below(300)));
                send("-CONT");
            }
            _ => {}
        }
        false
    }

    /// One process, with passes or without.
    fn whole(&mut self, goal: &[String]) -> Vec<u8> {
        self.tally.renders += 1;
        let checkpoint = self.path("a.fsc");
        let name = checkpoint.display().to_string();
        let more = [goal, &["--checkpoint".into(), name]].concat();
        self.finish("a.exr", &more, &[checkpoint], 1.0);
        std::fs::read(self.path("a.exr")).expect("the image")
    }

    /// A random number of shards, in any order, some of them in one process.
    fn in_shards(&mut self, goal: &[String]) -> Vec<u8> {
        let of = 1 + self.random.below(12);
        let file = |shard: u64, chaos: &Chaos| chaos.path(&format!("a.shard-{shard}-of-{of}.fsc"));
        let mut ranges = Vec::new();
        let mut first = 1;
        while first <= of {
            let last = (first + self.random.below(3)).min(of);
            ranges.push((first, last));
            first = last + 1;
        }
        self.random.shuffle(&mut ranges);
        for (first, last) in ranges {
            self.tally.shards += (last - first + 1) as u32;
            let shard = format!("{first}-{last}/{of}");
            let more = [goal, &["--shard".into(), shard]].concat();
            let files: Vec<PathBuf> = (first..=last).map(|shard| file(shard, self)).collect();
            let part = (last - first + 1) as f64 / of as f64;
            self.finish("a.exr", &more, &files, part);
        }
        let mut files: Vec<PathBuf> = (1..=of).map(|shard| file(shard, self)).collect();
        self.random.shuffle(&mut files);
        let merged = Command::new(env!("CARGO_BIN_EXE_fstop"))
            .args(["merge", "--quiet", "-o"])
            .arg(self.path("a.exr"))
            .args(&files)
            .output()
            .expect("the program");
        let said = String::from_utf8_lossy(&merged.stderr);
        assert!(merged.status.success(), "{said}");
        files
            .iter()
            .for_each(|file| std::fs::remove_file(file).expect("a shard"));
        std::fs::read(self.path("a.exr")).expect("the image")
    }
}

/// The time of rendering that a checkpoint knows of: its last record of kind 3.
fn spent(checkpoint: &Path) -> Duration {
    let bytes = std::fs::read(checkpoint).unwrap_or_default();
    let mut rest = bytes
        .split_at_checked(b"fstop checkpoint 5\n".len())
        .map_or(&[][..], |b| b.1);
    let mut found = 0;
    while let Some((length, after)) = rest.split_first_chunk() {
        let length = u32::from_le_bytes(*length) as usize;
        let Some((body, after)) = after.split_at_checked(length) else {
            break;
        };
        if let [3, milliseconds @ ..] = body {
            found = u64::from_le_bytes(milliseconds.try_into().expect("eight bytes"));
        }
        rest = after.get(4..).unwrap_or_default();
    }
    Duration::from_millis(found)
}

#[test]
fn whatever_happens_the_bits_are_the_same() {
    let variable = |name: &str| {
        std::env::var(name)
            .ok()
            .and_then(|text| text.parse::<f64>().ok())
    };
    let time = variable("FSTOP_CHAOS_MINUTES").map_or(12.0, |minutes| 60.0 * minutes);
    let clock = std::time::UNIX_EPOCH
        .elapsed()
        .map_or(1, |since| since.as_nanos() as u64 >> 8);
    let seed = variable("FSTOP_CHAOS_SEED").map_or(clock % (1 << 40), |seed| seed as u64) | 1;
    println!("FSTOP_CHAOS_SEED={seed}");
    let mut chaos = Chaos {
        folder: tempfile::tempdir().expect("a folder"),
        random: Random(seed),
        tally: Tally::default(),
    };
    let owned = |words: [&str; 2]| words.map(String::from).to_vec();
    let goals = [owned(["--spp", SAMPLES]), owned(["--error", "2%"])];
    let references = goals.clone().map(|goal| {
        let output = chaos.path("reference.exr");
        let run = Command::new(env!("CARGO_BIN_EXE_fstop"))
            .args(["render", SCENE, "--quiet", "--no-checkpoint", "-o"])
            .arg(&output)
            .args(goal)
            .status();
        assert!(run.expect("the program").success());
        std::fs::read(&output).expect("the image")
    });
    let start = Instant::now();
    while start.elapsed().as_secs_f64() < time {
        let image = match chaos.random.below(3) {
            0 => (chaos.whole(&goals[0]), 0),
            1 => (chaos.in_shards(&goals[0]), 0),
            _ => (chaos.whole(&goals[1]), 1),
        };
        assert!(
            image.0 == references[image.1],
            "other bits with seed {seed}"
        );
    }
    println!("{:?}, one picture for each goal", chaos.tally);
}
