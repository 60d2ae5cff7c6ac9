//! This process's memory, where the system tells.

/// What a process has now, and has had at most, in bytes; `None` where the system does not tell (other than Linux).
#[derive(Clone, Copy, Debug)]
pub struct Process {
    /// Resident now.
    pub now: Option<u64>,
    /// Resident at most so far.
    pub peak: Option<u64>,
}

impl Process {
    /// This process.
    pub fn measured() -> Process {
        let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
        let of = |name: &str| {
            let line = status.lines().find_map(|line| line.strip_prefix(name))?;
            let kib: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
            Some(1024 * kib)
        };
        Process {
            now: of("VmRSS:"),
            peak: of("VmHWM:"),
        }
    }

    /// What has been added since: at most, and now; nothing where the system does not tell.
    pub fn growth(&self) -> [u64; 2] {
        let now = Process::measured();
        let since = |later: Option<u64>| Some(later?.saturating_sub(self.now?));
        [since(now.peak), since(now.now)].map(Option::unwrap_or_default)
    }
}
