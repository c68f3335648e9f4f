//! How much memory the program may take: `--memory-limit`, or what the machine has to give; checked before the work is begun.

use anyhow::anyhow;

use super::failure::Failure;
use crate::transport::need::Need;
use crate::units::format_bytes;

/// Memory that may be taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MemoryLimit {
    /// `--memory-limit`, bytes.
    pub allowed: Option<u64>,
    /// What can be had without swapping, within the limits of the container and of `ulimit -v`; none where the system does
    /// not tell.
    pub available: Option<u64>,
    /// Whether `available` must not be passed, as by `ulimit -v`: what the user allows is no more then.
    is_hard: bool,
}

impl MemoryLimit {
    /// The limit of this process, with `--memory-limit` if it was given.
    pub fn new(allowed: Option<u64>) -> Self {
        let free = [meminfo_bytes(), container_bytes()].into_iter().flatten().min();
        let hard = address_space_bytes().filter(|hard| free.is_none_or(|free| *hard <= free));
        Self { allowed, available: hard.or(free), is_hard: hard.is_some() }
    }

    /// Bytes that may be taken.
    pub fn bytes(&self) -> u64 {
        match (self.allowed, self.available) {
            // Whoever names a limit knows what else the machine will give.
            (Some(allowed), Some(available)) if self.is_hard => allowed.min(available),
            (allowed, available) => allowed.or(available).unwrap_or(u64::MAX),
        }
    }

    /// What the machine sets as a limit to readers that have one of their own; none where the user has set one.
    pub fn of_machine(&self) -> Option<u64> {
        self.available.filter(|_| self.allowed.is_none() || self.is_hard)
    }

    /// Refuses what does not fit.
    ///
    /// # Errors
    /// Says how much is needed for what, how much there is, and what to do.
    pub fn check(&self, need: &Need) -> Result<(), Failure> {
        let limit = self.bytes();
        if need.total() <= limit {
            return Ok(());
        }
        let parts: Vec<String> =
            need.items.iter().take(3).map(|item| format!("{} for {}", format_bytes(item.bytes), item.what)).collect();
        let (whose, raise) = match (self.allowed, self.is_hard && self.available == Some(limit)) {
            (_, true) => ("`ulimit -v` leaves", "raise that limit"),
            (Some(_), _) => ("--memory-limit allows", "raise it if there is more"),
            (None, _) => ("the machine has", "try all the same with --memory-limit"),
        };
        // The program itself becomes no smaller.
        let remedy = need.items.first().map(|item| item.remedy).filter(|remedy| !remedy.is_empty());
        let remedy = remedy.map_or(String::new(), |remedy| format!("{remedy}, or "));
        Err(Failure::other(anyhow!(
            "not enough memory: about {} are needed ({}), and {whose} {}; {remedy}{raise}",
            format_bytes(need.total()),
            parts.join(", "),
            format_bytes(limit)
        )))
    }
}

/// Memory that can be had without swapping, where the system tells.
fn meminfo_bytes() -> Option<u64> {
    kib_line(&std::fs::read_to_string("/proc/meminfo").ok()?, "MemAvailable:")
}

/// What the control group of this process leaves it, where there is one with a limit (cgroups v2, at any level).
fn container_bytes() -> Option<u64> {
    let groups = std::fs::read_to_string("/proc/self/cgroup").ok()?;
    let own = groups.lines().find_map(|line| line.strip_prefix("0::/"))?;
    let read = |folder: &std::path::Path, name: &str| std::fs::read_to_string(folder.join(name)).ok();
    let left = |folder: &std::path::Path| -> Option<u64> {
        let most: u64 = read(folder, "memory.max")?.trim().parse().ok()?;
        // Files in the cache give way.
        let stat = read(folder, "memory.stat")?;
        let used = stat.lines().find_map(|line| line.strip_prefix("anon "))?.trim().parse().ok()?;
        Some(most.saturating_sub(used))
    };
    let root = std::path::Path::new("/sys/fs/cgroup");
    root.join(own).ancestors().take_while(|folder| folder.starts_with(root)).filter_map(left).min()
}

/// Address space that `ulimit -v` leaves, without what each thread's allocator sets aside (glibc: 64 MiB).
#[cfg(target_os = "linux")]
fn address_space_bytes() -> Option<u64> {
    use nix::sys::resource::{RLIM_INFINITY, Resource, getrlimit};
    const PER_THREAD: u64 = 64 << 20;
    let (limit, _) = getrlimit(Resource::RLIMIT_AS).ok()?;
    if limit == RLIM_INFINITY {
        return None;
    }
    let used = kib_line(&std::fs::read_to_string("/proc/self/status").ok()?, "VmSize:").unwrap_or(0);
    let threads = rayon::current_num_threads() as u64;
    Some(limit.saturating_sub(used).saturating_sub(threads.saturating_mul(PER_THREAD)))
}

#[cfg(not(target_os = "linux"))]
fn address_space_bytes() -> Option<u64> {
    None
}

/// The value of a line such as `MemAvailable:  123 kB`, bytes.
fn kib_line(text: &str, name: &str) -> Option<u64> {
    let value = text.lines().find_map(|line| line.strip_prefix(name))?;
    value.trim().trim_end_matches("kB").trim().parse::<u64>().ok().map(|kib| kib.saturating_mul(1024))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn limit(allowed: Option<u64>, available: Option<u64>, is_hard: bool) -> MemoryLimit {
        MemoryLimit { allowed, available, is_hard }
    }

    #[test]
    fn the_user_knows_better_than_the_machine_but_not_than_its_hard_limit() {
        assert_eq!(limit(Some(9), Some(5), false).bytes(), 9);
        assert_eq!(limit(Some(9), Some(5), true).bytes(), 5);
        assert_eq!(limit(Some(3), Some(5), true).bytes(), 3);
        assert_eq!(limit(None, Some(5), false).bytes(), 5);
        assert_eq!(limit(None, None, false).bytes(), u64::MAX);
        assert_eq!(limit(Some(9), Some(5), false).of_machine(), None);
        assert_eq!(limit(Some(9), Some(5), true).of_machine(), Some(5));
    }

    #[test]
    fn what_does_not_fit_is_refused_with_what_it_is_for() {
        let mut need = Need::default();
        need.add("a film", 4_000_000_000, "lower --resolution");
        need.add("droplets", 1_000_000_000, "use fewer");
        let said = |limit: MemoryLimit| limit.check(&need).map_err(|error| error.to_string()).unwrap_err();
        let text = said(limit(Some(1_000_000_000), None, false));
        for part in ["5.00 GB", "4.00 GB for a film", "--memory-limit allows 1.00 GB", "lower --resolution"] {
            assert!(text.contains(part), "{text}");
        }
        assert!(said(limit(None, Some(7), false)).contains("the machine has 7 B"));
        let program = limit(Some(5_000_000), None, false).check(&Need::of_program()).unwrap_err().to_string();
        assert!(program.ends_with("allows 5.00 MB; raise it if there is more"), "{program}");
        assert!(said(limit(Some(9), Some(7), true)).contains("ulimit"));
        assert!(limit(None, Some(5_000_000_000), false).check(&need).is_ok());
    }

    #[test]
    fn this_machine_has_memory() {
        assert!(kib_line("MemTotal: 9 kB\nMemAvailable:    8 kB\n", "MemAvailable:") == Some(8192));
        assert!(MemoryLimit::new(None).bytes() > 1 << 20);
    }
}
