//! Time that this process has kept processors busy, which other programs on the machine do not lengthen.

use std::time::Instant;

/// Measures a stretch of work.
pub struct Clock {
    wall: Instant,
    cpu_s: Option<f64>,
}

/// How long a stretch of work took.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Took {
    /// Processor seconds of all threads together; the time on the wall where the system does not tell.
    pub cpu_s: f64,
    /// Seconds on the wall.
    pub wall_s: f64,
}

impl Clock {
    /// Starts now.
    pub fn start() -> Self {
        Self { wall: Instant::now(), cpu_s: cpu_seconds() }
    }

    /// What was taken since the start.
    pub fn took(&self) -> Took {
        let wall_s = self.wall.elapsed().as_secs_f64();
        let cpu_s = cpu_seconds().zip(self.cpu_s).map_or(wall_s, |(now, then)| now - then);
        Took { cpu_s, wall_s }
    }
}

#[cfg(unix)]
fn cpu_seconds() -> Option<f64> {
    let time = nix::time::clock_gettime(nix::time::ClockId::CLOCK_PROCESS_CPUTIME_ID).ok()?;
    Some(time.tv_sec() as f64 + 1e-9 * time.tv_nsec() as f64)
}

#[cfg(not(unix))]
fn cpu_seconds() -> Option<f64> {
    None
}
