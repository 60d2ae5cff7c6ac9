//! What shards of an adaptive render do next.

use super::Identity;
use crate::files::{self, FileError};
use crate::output::{self, OutputError};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// The passes of an adaptive render after the first, as far as they are decided; all shards follow it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Plan {
    /// What it is of.
    pub of: Identity,
    /// Samples per pixel of each half's tiles after the second pass, the third …
    pub passes: Vec<[Vec<u32>; 2]>,
}

/// Bytes of the largest plan: of a thousand passes of the largest image.
const LARGEST: u64 = 1 << 33;

/// Why a plan cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum PlanError {
    /// It cannot be read.
    #[error(transparent)]
    Unreadable(#[from] FileError),
    /// It is something else.
    #[error("{}: this is no plan of `fstop merge --plan`: {why}", .path.display())]
    Foreign {
        /// The file.
        path: PathBuf,
        /// In words.
        why: String,
    },
    /// It is of another render.
    #[error("{}: this is the plan of another render: {}", .path.display(), .differences.join("; "))]
    Differs {
        /// The file.
        path: PathBuf,
        /// In sentences.
        differences: Vec<String>,
    },
}

impl PlanError {
    /// Returns `true` if it might be read on another machine or later.
    pub fn is_failure(&self) -> bool {
        match self {
            PlanError::Unreadable(error) => error.is_failure,
            PlanError::Foreign { .. } | PlanError::Differs { .. } => false,
        }
    }
}

impl Plan {
    /// Reads a plan of this render.
    ///
    /// # Errors
    /// A file that is none.
    pub fn read(path: &Path, of: &Identity) -> Result<Plan, PlanError> {
        let path_of = || path.to_owned();
        let read = files::read(path, LARGEST);
        let named = |why: &str| format!("{}: cannot read: {why}", path.display());
        let bytes = read.map_err(|problem| FileError::from(problem).said(named))?;
        let plan: Plan = serde_json::from_slice(&bytes).map_err(|error| PlanError::Foreign {
            path: path_of(),
            why: error.to_string(),
        })?;
        let differences = of.differences(&plan.of);
        match differences.is_empty() {
            true => Ok(plan),
            false => Err(PlanError::Differs {
                path: path_of(),
                differences,
            }),
        }
    }

    /// Writes it.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn write(&self, path: &Path) -> Result<(), OutputError> {
        let text = serde_json::to_vec(self).unwrap_or_default();
        output::write(path, &text)
    }
}
