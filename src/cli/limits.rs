//! What a run takes: peak memory as the system tells it, seconds from stage to stage, and where it keeps its tables.

use std::path::PathBuf;
use std::time::Instant;

/// Peak resident memory of this process, bytes; 0 where the system does not tell.
pub fn peak_rss_bytes() -> u64 {
    let Ok(status) = std::fs::read_to_string("/proc/self/status") else { return 0 };
    let kib = status
        .lines()
        .find_map(|line| line.strip_prefix("VmHWM:"))
        .and_then(|rest| rest.trim().trim_end_matches("kB").trim().parse::<u64>().ok());
    kib.map_or(0, |kib| kib * 1024)
}

/// Seconds spent in each stage, measured from one `lap` to the next.
pub struct Stopwatch {
    last: Instant,
    start: Instant,
}

impl Stopwatch {
    /// Starts now.
    pub fn start() -> Self {
        let now = Instant::now();
        Self { last: now, start: now }
    }

    /// When it was started.
    pub fn began(&self) -> Instant {
        self.start
    }

    /// Seconds since the last lap.
    pub fn lap(&mut self) -> f64 {
        let now = Instant::now();
        let seconds = (now - self.last).as_secs_f64();
        self.last = now;
        seconds
    }

    /// Seconds since the start.
    pub fn total(&self) -> f64 {
        self.start.elapsed().as_secs_f64()
    }
}

/// Where optical tables are kept between runs: `$XDG_CACHE_HOME/mie-cloud`, or `~/.cache/mie-cloud`.
pub fn cache_folder() -> Option<PathBuf> {
    let folder = |name: &str| std::env::var_os(name).map(PathBuf::from).filter(|path| path.is_absolute());
    let base = folder("XDG_CACHE_HOME").or_else(|| folder("HOME").map(|home| home.join(".cache")));
    base.map(|base| base.join("mie-cloud"))
}
