//! Memory budget of a scene.
//!
//! Whatever a file claims or a parameter asks for is charged before it is allocated, so that too much is an error with
//! a location in the scene and does not end the process. Large items are charged: images, meshes with their trees,
//! compressed data, Ptex files, the film. Nothing is charged per ray.

use std::fmt;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

/// The memory left of a limit. Shared by the threads that load files.
#[derive(Debug)]
pub struct Budget {
    limit: u64,
    left: AtomicU64,
}

/// Error: something does not fit in the memory budget.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "needs {} of memory, of which {} are left within the limit of {} (see --max-memory)",
    Bytes(*.needed),
    Bytes(*.left),
    Bytes(*.limit)
)]
pub struct OverBudget {
    /// Bytes it would take.
    pub needed: u64,
    /// Bytes left in the budget.
    pub left: u64,
    /// Bytes of the whole budget.
    pub limit: u64,
}

/// Bytes charged until this is dropped.
#[derive(Debug)]
pub struct Held<'a> {
    budget: &'a Budget,
    bytes: u64,
}

impl Budget {
    /// A budget of `limit` bytes; `None` for what the machine provides.
    pub fn new(limit: Option<u64>) -> Budget {
        let limit = limit.or_else(of_machine).unwrap_or(u64::MAX);
        Budget {
            limit,
            left: AtomicU64::new(limit),
        }
    }

    /// A budget for data that is known to be small.
    pub fn unlimited() -> Budget {
        Budget::new(Some(u64::MAX))
    }

    /// Bytes left.
    pub fn left(&self) -> u64 {
        self.left.load(Relaxed)
    }

    /// Charges `bytes` permanently.
    ///
    /// # Errors
    /// Fails, without charging anything, if fewer bytes are left.
    pub fn take(&self, bytes: u64) -> Result<(), OverBudget> {
        let taken = self
            .left
            .fetch_update(Relaxed, Relaxed, |left| left.checked_sub(bytes));
        taken.map(drop).map_err(|left| OverBudget {
            needed: bytes,
            left,
            limit: self.limit,
        })
    }

    /// Charges `bytes` until the returned value is dropped.
    ///
    /// # Errors
    /// As for [`Budget::take`].
    pub fn hold(&self, bytes: u64) -> Result<Held<'_>, OverBudget> {
        self.take(bytes)?;
        Ok(Held {
            budget: self,
            bytes,
        })
    }
}

impl Drop for Held<'_> {
    fn drop(&mut self) {
        self.budget.left.fetch_add(self.bytes, Relaxed);
    }
}

/// A number of bytes in human-readable form.
pub struct Bytes(pub u64);

impl fmt::Display for Bytes {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let units = ["KiB", "MiB", "GiB", "TiB", "PiB", "EiB"];
        if self.0 < 1024 {
            return write!(f, "{} bytes", self.0);
        }
        let step = (self.0.ilog2() / 10).min(units.len() as u32);
        let value = self.0 as f64 / f64::from(1 << 10).powi(step as i32);
        write!(f, "{value:.1} {}", units[step as usize - 1])
    }
}

/// Parses a size such as `8G`, `512MiB` or `1000000`; units are powers of 1024.
///
/// # Errors
/// Fails for anything else, stating what was expected.
pub fn parse_size(text: &str) -> Result<u64, String> {
    let expected = || "expected a size such as 8G, 512M or 1000000 (bytes)".to_string();
    let digits = text.trim_end_matches(|c: char| c.is_ascii_alphabetic());
    let power = match text[digits.len()..].to_ascii_uppercase().as_str() {
        "" | "B" => 0,
        "K" | "KB" | "KIB" => 1,
        "M" | "MB" | "MIB" => 2,
        "G" | "GB" | "GIB" => 3,
        "T" | "TB" | "TIB" => 4,
        _ => return Err(expected()),
    };
    let number: f64 = digits.trim().parse().map_err(|_| expected())?;
    let bytes = number * 1024f64.powi(power);
    if bytes >= 1.0 && bytes < u64::MAX as f64 {
        Ok(bytes as u64)
    } else {
        Err(expected())
    }
}

/// One over the fraction of the machine's memory that is left to other processes.
const RESERVE: u64 = 16;

/// Memory available without swapping, and within the limits of this process's control groups, minus a reserve. `None`
/// if the operating system does not report it (other than Linux).
fn of_machine() -> Option<u64> {
    let available = available(&std::fs::read_to_string("/proc/meminfo").ok()?)?;
    let groups = std::fs::read_to_string("/proc/self/cgroup").unwrap_or_default();
    let within_groups = groups.lines().filter_map(left_in_group).min();
    let left = available.min(within_groups.unwrap_or(u64::MAX));
    Some(left - left / RESERVE)
}

/// `MemAvailable` of `/proc/meminfo`, in bytes.
fn available(meminfo: &str) -> Option<u64> {
    let line = meminfo
        .lines()
        .find_map(|line| line.strip_prefix("MemAvailable:"))?;
    let kilobytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    kilobytes.checked_mul(1024)
}

/// Memory left in the control group named by a line of `/proc/self/cgroup`, and in its ancestors (cgroups(7): version 2
/// has one line `0::PATH`, version 1 a line `N:memory:PATH`).
fn left_in_group(line: &str) -> Option<u64> {
    let mut fields = line.splitn(3, ':');
    let (_, controllers, path) = (fields.next()?, fields.next()?, fields.next()?);
    let (root, limit, usage, cache) = match controllers {
        "" => (
            "/sys/fs/cgroup",
            "memory.max",
            "memory.current",
            "inactive_file ",
        ),
        "memory" => (
            "/sys/fs/cgroup/memory",
            "memory.limit_in_bytes",
            "memory.usage_in_bytes",
            "total_inactive_file ",
        ),
        _ => return None,
    };
    // Inside a container the group is the root itself, whatever its path.
    let groups = std::path::Path::new(path).ancestors();
    let folders = groups.map(|group| {
        let group = group.strip_prefix("/").unwrap_or(group);
        std::path::Path::new(root).join(group)
    });
    let left = |folder: std::path::PathBuf| {
        let number = |name: &str| -> Option<u64> {
            let text = std::fs::read_to_string(folder.join(name)).ok()?;
            text.trim().parse().ok()
        };
        let used = number(usage).unwrap_or(0);
        let statistics = std::fs::read_to_string(folder.join("memory.stat")).unwrap_or_default();
        let dropped = statistics.lines().find_map(|line| line.strip_prefix(cache));
        let dropped = dropped.and_then(|n| n.parse().ok()).unwrap_or(0);
        Some(number(limit)?.saturating_sub(used.saturating_sub(dropped)))
    };
    folders.filter_map(left).min()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_charged_is_gone_and_what_is_held_comes_back() {
        let budget = Budget::new(Some(1000));
        budget.take(300).expect("enough");
        {
            let _held = budget.hold(600).expect("enough");
            let over = OverBudget {
                needed: 101,
                left: 100,
                limit: 1000,
            };
            assert_eq!(budget.take(101), Err(over));
            assert_eq!(budget.left(), 100);
        }
        assert_eq!(budget.left(), 700);
        assert!(budget.hold(701).is_err());
        Budget::unlimited().take(u64::MAX).expect("no limit");
    }

    #[test]
    fn sizes_are_read_and_said() {
        for (text, bytes) in [("1", 1), ("2k", 2048), ("1.5M", 3 << 19), ("8GiB", 8 << 30)] {
            assert_eq!(parse_size(text), Ok(bytes), "{text}");
        }
        for text in ["", "G", "0", "-1G", "1X", "nan", "inf", "1e30", "20000000T"] {
            assert!(parse_size(text).is_err(), "{text}");
        }
        let said = [100, 1024, 3 << 29, u64::MAX].map(|bytes| Bytes(bytes).to_string());
        assert_eq!(said, ["100 bytes", "1.0 KiB", "1.5 GiB", "16.0 EiB"]);
    }

    #[test]
    fn the_machines_memory_is_known() {
        assert_eq!(
            available("MemTotal: 9 kB\nMemAvailable:   2 kB\n"),
            Some(2048)
        );
        assert_eq!(available("MemTotal: 9 kB\n"), None);
        assert_eq!(left_in_group("3:cpu:/"), None);
        #[cfg(target_os = "linux")]
        assert!(of_machine().is_some_and(|bytes| bytes > 1 << 20));
    }
}
