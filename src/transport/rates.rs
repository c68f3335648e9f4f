//! How often a sample asks each of its estimators: what is dear and steady less than once, what is cheap and noisy several
//! times, so that the picture's noise falls fastest (theory (143), (144)).
//!
//! A pure function of the scene: `pilot.rs` counts work instead of looking at a clock.

use super::random::PathRandom;

/// An estimator that is asked apart from the others.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Part {
    /// `direct` and `multiple`.
    Paths,
    /// `air-multiple`.
    AirPaths,
    Airlight,
    Glow,
}

impl Part {
    pub const ALL: [Self; 4] = [Self::Paths, Self::AirPaths, Self::Airlight, Self::Glow];

    /// Exponents to choose from, those near one ask per sample first. What is met by chance on a path may be rare and bright: a short look
    /// misses that and takes it for steady. So only what is gathered along the camera's ray is asked less than once.
    fn exponents(self, work: f64) -> Vec<i8> {
        if work <= 0.0 {
            return vec![0];
        }
        let least = if matches!(self, Self::Airlight | Self::Glow) { RAREST } else { 0 };
        let mut exponents: Vec<i8> = (least..=OFTENEST).collect();
        exponents.sort_by_key(|exponent| exponent.abs());
        exponents
    }
}

/// How often each estimator is asked per sample, as powers of two: exponents from -16 to 16, others count as the nearest,
/// but for `i8::MIN`, which is never.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rates {
    /// Light that droplets scatter, once or many times.
    pub paths: i8,
    /// Light that air and droplets scatter one after the other.
    pub air_paths: i8,
    /// Sunlight that air scatters.
    pub airlight: i8,
    /// Light that droplets scatter into the air.
    pub glow: i8,
}

/// No exponent counts for more.
const MOST_EXPONENT: i8 = 16;

/// The exponent of what is never asked.
const NEVER: i8 = i8::MIN;

/// Once in four samples is four times in the fewest that a pixel has; more seldom, dark pixels with one such sample would stand out among
/// those with none, although the noise were less. More than eight times gains little over a new camera ray.
const RAREST: i8 = -2;
const OFTENEST: i8 = 3;

/// Rates that promise to gain less than this stay even: the look is a rough one, and even rates spread noise evenly.
const LEAST_GAIN: f64 = 1.5;

/// How an estimator is asked in one sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Ask {
    /// How many times.
    pub times: u32,
    /// What each is worth.
    pub weight: f64,
}

/// What asking costs, and what it leaves as noise.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Asked {
    /// Mean square of what is found, over pixels and channels.
    pub square: f64,
    /// Mean square of its expectation.
    pub mean_square: f64,
    /// Work per time.
    pub work: f64,
}

impl Asked {
    /// Variance per sample at 2^exponent times per sample (theory (143)).
    fn variance(&self, exponent: i8) -> f64 {
        let rate = f64::from(exponent).exp2();
        match exponent < 0 {
            true => self.square / rate - self.mean_square,
            false => (self.square - self.mean_square) / rate,
        }
    }
}

impl Rates {
    /// Everything once per sample.
    pub const EVEN: Self = Self { paths: 0, air_paths: 0, airlight: 0, glow: 0 };

    /// Nothing but what every sample has: background, discs, sunlight on glass.
    pub(super) const NOTHING: Self = Self { paths: NEVER, air_paths: NEVER, airlight: NEVER, glow: NEVER };

    fn of(&self, part: Part) -> i8 {
        match part {
            Part::Paths => self.paths,
            Part::AirPaths => self.air_paths,
            Part::Airlight => self.airlight,
            Part::Glow => self.glow,
        }
    }

    /// The layers of each estimator, and how many times it is asked per sample on average.
    pub fn per_sample(&self) -> [(&'static str, f64); 4] {
        let names = ["direct, multiple", "air-multiple", "airlight", "glow"];
        std::array::from_fn(|i| (names[i], f64::from(self.of(Part::ALL[i])).exp2()))
    }

    fn from_exponents([paths, air_paths, airlight, glow]: [i8; 4]) -> Self {
        Self { paths, air_paths, airlight, glow }
    }

    /// Nothing but one estimator.
    pub(super) fn only(part: Part) -> Self {
        Self::from_exponents(Part::ALL.map(|other| if other == part { 0 } else { NEVER }))
    }

    /// How one sample asks each estimator, indexed by `Part`.
    pub(super) fn asks(&self, random: &PathRandom) -> [Ask; Part::ALL.len()] {
        Part::ALL.map(|part| match self.of(part) {
            NEVER => Ask { times: 0, weight: 0.0 },
            0 => Ask { times: 1, weight: 1.0 },
            exponent @ 1.. => {
                let exponent = exponent.min(MOST_EXPONENT);
                Ask { times: 1 << exponent, weight: f64::from(-exponent).exp2() }
            }
            exponent => {
                let every = 1 << -exponent.max(-MOST_EXPONENT);
                let times = u32::from(random.is_its_turn(part as u32, every));
                Ask { times, weight: f64::from(every) }
            }
        })
    }

    /// The rates at which work times variance is least (theory (144)); `rest` is what every sample has.
    pub(super) fn best(rest: Asked, parts: [Asked; Part::ALL.len()]) -> Self {
        let cost = |exponents: [i8; 4]| {
            let (mut variance, mut work) = (rest.variance(0), rest.work);
            for (asked, exponent) in parts.iter().zip(exponents) {
                variance += asked.variance(exponent);
                work += asked.work * f64::from(exponent).exp2();
            }
            variance.max(0.0) * work
        };
        let choices = Part::ALL.map(|part| part.exponents(parts[part as usize].work));
        let (mut best, mut least) = ([0; 4], cost([0; 4]));
        let enough = least / LEAST_GAIN;
        for &a in &choices[0] {
            for &b in &choices[1] {
                for &c in &choices[2] {
                    for &d in &choices[3] {
                        let cost = cost([a, b, c, d]);
                        if cost < least.min(enough) {
                            (best, least) = ([a, b, c, d], cost);
                        }
                    }
                }
            }
        }
        Self::from_exponents(best)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn asked(deviation: f64, mean: f64, work: f64) -> Asked {
        Asked { square: deviation * deviation + mean * mean, mean_square: mean * mean, work }
    }

    #[test]
    fn what_is_dear_and_steady_is_asked_seldom() {
        let noisy_and_cheap = asked(10.0, 1.0, 1.0);
        let steady_and_dear = asked(0.01, 0.1, 100.0);
        let rest = asked(0.0, 0.0, 1.0);
        let rates = Rates::best(rest, [noisy_and_cheap, asked(0.0, 0.0, 0.0), noisy_and_cheap, steady_and_dear]);
        assert_eq!(rates, Rates { paths: 3, air_paths: 0, airlight: 3, glow: -2 });
    }

    /// Expected: what scatters as it costs, or not at all, stays as it is; a mean alone is noise where it is asked seldom.
    #[test]
    fn rates_stay_even_where_little_is_gained() {
        let (same, none) = (asked(1.0, 1.0, 1.0), asked(0.0, 0.0, 0.0));
        assert_eq!(Rates::best(none, [same; 4]), Rates::EVEN);
        assert_eq!(Rates::best(none, [none; 4]), Rates::EVEN);
        assert_eq!(Rates::best(none, [none, none, none, asked(1e-6, 1.0, 100.0)]), Rates::EVEN);
    }

    /// Expected: with independent scatter the best rates go with deviation over the root of work, to a factor of 2.
    #[test]
    fn the_best_rates_go_with_deviation_over_the_root_of_work() {
        let parts = [asked(2.0, 0.0, 1.0), asked(1.0, 0.0, 1.0), asked(1.0, 0.0, 16.0), asked(1.0, 0.0, 16.0)];
        let rates = Rates::best(asked(0.0, 0.0, 0.0), parts);
        let relative = Part::ALL.map(|part| rates.of(part) - rates.of(Part::AirPaths));
        assert_eq!(relative, [1, 0, -2, -2]);
        // Paths are asked once at least, however dear.
        let dear = [asked(0.01, 0.1, 100.0), asked(0.01, 0.1, 100.0), asked(10.0, 1.0, 1.0), asked(10.0, 1.0, 1.0)];
        let rates = Rates::best(asked(0.0, 0.0, 0.0), dear);
        assert_eq!([rates.paths, rates.air_paths], [0; 2]);
    }

    #[test]
    fn weights_make_up_for_turns() {
        let rates = Rates { paths: 2, air_paths: -3, airlight: 0, glow: -1 };
        let n = 64_000u64;
        let mut sums = [0.0; 4];
        for pixel in 0..n {
            let asks = rates.asks(&PathRandom::new(1, pixel, (pixel % 40) as u32));
            sums.iter_mut().zip(asks).for_each(|(sum, ask)| *sum += f64::from(ask.times) * ask.weight);
        }
        // One in eight times eight has a standard deviation of sqrt(7); five of them.
        let off = sums.map(|sum| (sum / n as f64 - 1.0).abs());
        assert!(off.iter().all(|off| *off < 5.0 * 7f64.sqrt() / (n as f64).sqrt()), "{off:?}");
        assert_eq!([off[0], off[2]], [0.0; 2]);
    }
}
