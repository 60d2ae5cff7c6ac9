//! One false-alarm rate over all commits to come.
//!
//! A suite that runs at every commit with α = 1 % raises a false alarm in every hundredth of them. If the kth commit is
//! given α·6/(π²k²) instead, all of them together have α, as Σ 1/k² = π²/6, and by the union bound that is true however
//! their images depend on each other (α-spending; D. P. Foster and R. A. Stine, "α-investing: a procedure for sequential
//! control of expected false discoveries", J. R. Stat. Soc. B 70(2), 2008, §2). It costs little: at the thousandth commit
//! a normal test among 100,000 asks for 7.5 standard errors instead of 5.3.

use crate::files::{self, FileProblem};
use crate::output::{self, OutputError};
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;
use std::fs::File;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// What the `k`th commit, counted from 1, may spend of `alpha`.
pub fn share(alpha: f64, k: usize) -> f64 {
    let k = k.max(1) as f64;
    alpha * 6.0 / (PI * PI * k * k)
}

/// What a commit has been given.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spent {
    /// Which commit it is, counted from 1.
    pub number: usize,
    /// Its false-alarm rate.
    pub alpha: f64,
}

/// The file that counts the commits.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Ledger {
    /// Of all commits together.
    alpha: f64,
    /// The names of those that have been given their share, in order; empty for one without a name.
    commits: Vec<String>,
}

/// Why a commit can be given nothing.
#[derive(Debug, thiserror::Error)]
pub enum SpendingError {
    /// It cannot be read.
    #[error("{}: cannot read: {reason}", .path.display())]
    Read {
        /// The ledger.
        path: PathBuf,
        /// Why.
        reason: FileProblem,
    },
    /// It is something else.
    #[error(
        "{}: this is not a count of commits that `fstop suite` has written ({reason}); with the file removed it begins again",
        .path.display()
    )]
    Form {
        /// The ledger.
        path: PathBuf,
        /// What is wrong.
        reason: String,
    },
    /// It was begun with another rate.
    #[error(
        "{}: the count of commits was begun for alpha = {before}, the suite says {now}: with the file removed it begins again",
        .path.display()
    )]
    Alpha {
        /// The ledger.
        path: PathBuf,
        /// The rate in the ledger.
        before: f64,
        /// The suite's.
        now: f64,
    },
    /// Another run has it, and does not let it go.
    #[error("{}: the count of commits is in use by another run", .0.display())]
    InUse(PathBuf),
    /// It cannot be written.
    #[error(transparent)]
    Write(#[from] OutputError),
}

impl SpendingError {
    /// Returns `true` if it might be given its share on another machine or later.
    pub fn is_failure(&self) -> bool {
        match self {
            SpendingError::Read { reason, .. } => reason.is_failure(),
            SpendingError::Write(error) => error.is_failure(),
            SpendingError::InUse(_) => true,
            SpendingError::Form { .. } | SpendingError::Alpha { .. } => false,
        }
    }
}

/// A ledger of many years is smaller than this.
const LARGEST: u64 = 64 << 20;

/// How long a run waits for others that have the ledger, each for a moment.
const PATIENCE: Duration = Duration::from_secs(10);

/// Returns the share of a new commit, or what a known one has been given: its images are assumed to be the same. The file
/// is written before anything is compared, so that what was spent is spent however the run ends.
///
/// # Errors
/// See [`SpendingError`].
pub fn spend(path: &Path, alpha: f64, commit: Option<&str>) -> Result<Spent, SpendingError> {
    let _held = hold(path)?;
    let mut ledger = match files::read(path, LARGEST) {
        Ok(bytes) => read(path, &bytes)?,
        Err(FileProblem::Missing) => Ledger {
            alpha,
            commits: Vec::new(),
        },
        Err(reason) => {
            return Err(SpendingError::Read {
                path: path.to_owned(),
                reason,
            });
        }
    };
    if ledger.alpha != alpha {
        return Err(SpendingError::Alpha {
            path: path.to_owned(),
            before: ledger.alpha,
            now: alpha,
        });
    }
    let name = commit.unwrap_or_default();
    let known = { ledger.commits.iter() }.position(|known| !name.is_empty() && known == name);
    let number = match known {
        Some(index) => index + 1,
        None => {
            ledger.commits.push(name.to_owned());
            let text = serde_json::to_string_pretty(&ledger).map_err(|e| form(path, &e))?;
            output::write(path, (text + "\n").as_bytes())?;
            ledger.commits.len()
        }
    };
    Ok(Spent {
        number,
        alpha: share(alpha, number),
    })
}

/// Keeps other runs from the ledger, so that no two are given the same number: by its folder, as the file itself is replaced when it is written.
fn hold(path: &Path) -> Result<Option<File>, SpendingError> {
    let folder = path.parent().filter(|folder| *folder != Path::new(""));
    let held = output::hold(folder.unwrap_or(Path::new(".")), PATIENCE);
    held.map_err(|output::InUse| SpendingError::InUse(path.to_owned()))
}

fn read(path: &Path, bytes: &[u8]) -> Result<Ledger, SpendingError> {
    serde_json::from_slice(bytes).map_err(|error| form(path, &error))
}

fn form(path: &Path, error: &serde_json::Error) -> SpendingError {
    SpendingError::Form {
        path: path.to_owned(),
        reason: error.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_commits_together_spend_alpha() {
        let first: f64 = (1..=100_000).map(|k| share(0.01, k)).sum();
        // What is left is 6/π² · α times the integral of 1/k² from there on, to a relative 1e-5.
        let left = 0.01 * 6.0 / (PI * PI) / 100_000.5;
        assert!((first + left - 0.01).abs() < 1e-12, "{first}");
    }

    #[cfg(unix)]
    #[test]
    fn runs_at_once_are_given_different_shares() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("state.json");
        let spend_all = || -> Vec<usize> {
            let spend = |_| spend(&path, 0.01, None).expect("a share").number;
            (0..5).map(spend).collect()
        };
        let mut numbers = std::thread::scope(|scope| {
            let runs = [0; 4].map(|_| scope.spawn(spend_all));
            runs.map(|run| run.join().expect("no panic")).concat()
        });
        numbers.sort_unstable();
        assert_eq!(numbers, (1..=20).collect::<Vec<usize>>());
    }

    #[test]
    fn a_commit_is_given_its_share_once() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("state.json");
        let spend = |alpha, commit| spend(&path, alpha, commit);
        let number = |commit| spend(0.01, commit).expect("a share").number;
        assert_eq!(
            [
                number(Some("a")),
                number(Some("b")),
                number(Some("a")),
                number(None),
                number(None)
            ],
            [1, 2, 1, 3, 4]
        );
        assert!(matches!(
            spend(0.02, None),
            Err(SpendingError::Alpha { .. })
        ));
        for text in ["", "[]", "{\"alpha\": 0.01}", "\u{0}"] {
            std::fs::write(&path, text).expect("a file");
            assert!(matches!(spend(0.01, None), Err(SpendingError::Form { .. })));
        }
    }
}
