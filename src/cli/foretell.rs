//! How long a render will take, and how noisy it will be then, foretold from its first rounds: said once, where it is long.

use crate::transport::Until;
use crate::units::short::{percent, time};

/// Renders that take longer than this are foretold, s.
const LONG_S: f64 = 60.0;

/// Before this the first samples tell too little, s.
const FORETOLD_AFTER_S: f64 = 2.0;

/// What somebody may want instead of a long render, s.
const SHORT_S: f64 = 60.0;

/// What is known at the end of a round.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SoFar {
    /// Time since the render began or was gone on with, s.
    pub elapsed_s: f64,
    /// Samples of all pixels together that were there before.
    pub begun: u64,
    /// Samples that there are.
    pub taken: u64,
    /// Samples that the finished picture will have, as far as can be told.
    pub expected: u64,
    /// Standard error of the picture relative to its mean; not finite where it is not known yet.
    pub noise: f64,
}

impl SoFar {
    /// Time that the rest takes, s: samples take as long as those so far. Infinite where nothing is known.
    pub fn left_s(&self) -> f64 {
        let since = self.taken.saturating_sub(self.begun);
        if since == 0 || self.elapsed_s < FORETOLD_AFTER_S {
            return f64::INFINITY;
        }
        self.elapsed_s * self.expected.saturating_sub(self.taken) as f64 / since as f64
    }

    /// Noise at the end: it falls like the root of the number of samples.
    pub fn noise_then(&self, samples: f64) -> f64 {
        self.noise * (self.taken as f64 / samples.max(1.0)).sqrt()
    }

    /// What to say of a render that takes long; nothing of others, or where it is not known yet.
    pub fn foretold(&self, until: Until) -> Option<String> {
        let left_s = self.left_s();
        if !left_s.is_finite() || left_s < LONG_S || !self.noise.is_finite() {
            return None;
        }
        if self.noise == 0.0 {
            return match until {
                Until::Samples(n) => Some(format!("about {} to {n} spp, all alike so far", time(left_s))),
                _ => None,
            };
        }
        let noise = self.noise_then(self.expected as f64);
        let left = time(left_s);
        Some(match until {
            Until::Range { first, end } => format!("about {left} for samples {first}..{end}"),
            Until::Samples(n) => {
                format!("about {left} to {n} spp, with {} noise then; {}", percent(noise), self.instead())
            }
            // The end is where the noise is what was asked for, or where there are as many samples as may be; before samples go
            // where the noise is, it looks farther away than it is.
            Until::Noise { target, .. } if noise < 2.0 * target => {
                format!("up to about {left} to {} noise; {}", percent(target), self.instead())
            }
            Until::Noise { at_most, .. } => {
                format!("up to about {left} to {at_most} spp ({} noise); {}", percent(noise), self.instead())
            }
        })
    }

    /// What a short render would give.
    fn instead(&self) -> String {
        let each_s = self.elapsed_s / self.taken.saturating_sub(self.begun).max(1) as f64;
        let noise = self.noise_then(SHORT_S / each_s);
        format!("--time-limit {SHORT_S:.0} gives about {}", percent(noise))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TO_FIVE_PERCENT: Until = Until::Noise { target: 0.05, at_most: 65_536 };

    /// After 10 s a thousand pixels have 4 samples each and 50 % of noise: a tenth of it takes a hundred times as many.
    fn known() -> SoFar {
        SoFar { elapsed_s: 10.0, begun: 0, taken: 4000, expected: 400_000, noise: 0.5 }
    }

    #[test]
    fn long_renders_are_foretold_with_what_to_do() {
        let said = known().foretold(TO_FIVE_PERCENT);
        assert_eq!(said.as_deref(), Some("up to about 16 min to 5 % noise; --time-limit 60 gives about 20 %"));
        let said = SoFar { expected: 64_000, ..known() }.foretold(Until::Samples(64));
        assert_eq!(
            said.as_deref(),
            Some("about 2 min to 64 spp, with 12 % noise then; --time-limit 60 gives about 20 %")
        );
        let said = known().foretold(Until::Range { first: 0, end: 400 });
        assert_eq!(said.as_deref(), Some("about 16 min for samples 0..400"));
    }

    /// A target that the most samples do not reach is not promised.
    #[test]
    fn what_will_not_be_reached_is_not_promised() {
        let until = Until::Noise { target: 0.005, at_most: 400 };
        let said = known().foretold(until).expect("it is long");
        assert!(said.starts_with("up to about 16 min to 400 spp (5 % noise);"), "{said}");
    }

    #[test]
    fn what_was_there_before_took_no_time() {
        let resumed = SoFar { begun: 2000, ..known() };
        assert!((resumed.left_s() / known().left_s() - 2.0).abs() < 1e-12);
    }

    #[test]
    fn nothing_is_said_of_what_is_short_or_unknown() {
        for so_far in [
            SoFar { expected: 20_000, ..known() },
            SoFar { elapsed_s: 1.0, ..known() },
            SoFar { begun: 4000, ..known() },
            SoFar { noise: f64::INFINITY, ..known() },
            // A black picture.
            SoFar { noise: 0.0, ..known() },
        ] {
            assert_eq!(so_far.foretold(TO_FIVE_PERCENT), None, "{so_far:?}");
        }
        assert_eq!(SoFar { expected: 4000, ..known() }.left_s(), 0.0);
        let said = SoFar { noise: 0.0, ..known() }.foretold(Until::Samples(400));
        assert_eq!(said.as_deref(), Some("about 16 min to 400 spp, all alike so far"));
    }
}
