//! The machine, the threads and the build that times were measured with.

use std::fmt;

use serde::Serialize;

/// What times depend on beside the work.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Machine {
    /// Name of the processor, where the system tells; else its architecture.
    pub processor: String,
    /// Processors that this process may use.
    pub processors: usize,
    /// Threads that render.
    pub threads: usize,
    /// Memory of the machine, bytes; 0 where the system does not tell.
    pub memory_bytes: u64,
    /// Operating system and architecture.
    pub system: String,
    /// Version of the program and how it was built.
    pub build: String,
}

impl Machine {
    /// This one, as threads of the present pool see it.
    pub fn here() -> Self {
        let (system, arch) = (std::env::consts::OS, std::env::consts::ARCH);
        let profile = if cfg!(debug_assertions) { "debug assertions on" } else { "release" };
        Self {
            processor: entry("/proc/cpuinfo", "model name").unwrap_or_else(|| arch.to_owned()),
            processors: std::thread::available_parallelism().map_or(1, usize::from),
            threads: rayon::current_num_threads(),
            memory_bytes: memory_bytes("MemTotal").unwrap_or(0),
            system: format!("{system} {arch}"),
            build: format!("mie-cloud {}, {profile}", env!("CARGO_PKG_VERSION")),
        }
    }
}

impl fmt::Display for Machine {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let Self { processor, processors, threads, memory_bytes, system, build } = self;
        let gib = *memory_bytes as f64 / f64::from(1 << 30);
        write!(f, "{processor}, {processors} processors, {gib:.0} GiB, {system}; {threads} threads; {build}")
    }
}

fn memory_bytes(name: &str) -> Option<u64> {
    entry("/proc/meminfo", name)?.trim_end_matches("kB").trim().parse::<u64>().ok().map(|kib| kib * 1024)
}

/// The first value of this name in a file of names and values.
fn entry(file: &str, name: &str) -> Option<String> {
    let text = std::fs::read_to_string(file).ok()?;
    let (_, value) = text.lines().filter_map(|line| line.split_once(':')).find(|(key, _)| key.trim() == name)?;
    Some(value.trim().to_owned())
}
