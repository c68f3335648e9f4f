//! The forward lobe that a scene's droplets have in common: what their phase functions show above an almost even level.
//!
//! A phase function p is split into that lobe's share of it and the rest, which has no peak: theory (47). The lobe is a
//! staircase over h, cheap to draw from and to look up. Legend: h = 1 - cos of the scattering angle.

use std::f64::consts::TAU;

use crate::optics::phase_function::PhaseFunction;

/// What exceeds this value in the forward half is the lobe, sr^-1. Measured on cubes of Mie fog of depth 0.1 to 30: half of
/// it doubles the noise of thick fog, whose chains get long; twice as much doubles that of thin fog, whose rest has a peak.
const LEVEL: f64 = 0.06;

/// A mixture that stays below this value has no peak that is worth a path of its own, sr^-1: at an asymmetry of 0.5, where
/// Henyey and Greenstein's function reaches 0.5, both ways cost the same.
const LEAST_PEAK: f64 = 0.6;

/// A droplet's lobe is cut at this multiple of the common one, so that no chain has a surprising weight. In a cloud of single
/// droplets of 10 um with an effective variance of 0.2 and depth 5, 2 leaves so much of the largest ones' peaks that the noise
/// doubles; 32 changes nothing.
const HIGHEST: f64 = 8.0;

/// The staircase nowhere falls below this fraction of `LEVEL`, so that all of every lobe can be drawn.
const FLOOR: f64 = 0.05;

/// Steps per doubling of h, as a power of two: a step is 12 % of h wide at most.
const STEP_BITS: u32 = 3;

/// The first step ends at this h, half a microradian.
const FIRST_H: f64 = 1.0 / (1u64 << 43) as f64;

/// The common lobe at every wavelength.
#[derive(Clone, Debug)]
pub(super) struct ForwardLobes {
    by_wavelength: Vec<Staircase>,
}

/// One wavelength's lobe.
#[derive(Clone, Debug)]
struct Staircase {
    /// Lower ends of the steps, and the upper end of the last.
    h: Vec<f64>,
    /// Density per steradian.
    density: Vec<f64>,
    /// Probability below each step's upper end.
    cdf: Vec<f64>,
    /// Integral of the lobe before it was normalised.
    share: f64,
    /// Highest value of the mixture, sr^-1.
    peak: f64,
}

impl ForwardLobes {
    /// The lobe of a mixture, from its phase functions with their weights at every wavelength; `None` where they have
    /// no forward peak.
    pub fn new(mixtures: &[Vec<(f64, &PhaseFunction)>]) -> Option<Self> {
        let by_wavelength: Vec<Staircase> = mixtures.iter().map(|mixture| Staircase::new(mixture)).collect();
        by_wavelength.iter().all(|lobe| lobe.peak >= LEAST_PEAK).then_some(Self { by_wavelength })
    }

    /// The lobe's share of a phase function whose value at h is `p`, sr^-1.
    #[inline]
    pub fn part(&self, wavelength: usize, h: f64, p: f64) -> f64 {
        let lobe = &self.by_wavelength[wavelength];
        (p - LEVEL).clamp(0.0, HIGHEST * lobe.share * lobe.density(h))
    }

    /// Density with which a wavelength draws h, per steradian.
    #[inline]
    pub fn density(&self, wavelength: usize, h: f64) -> f64 {
        self.by_wavelength[wavelength].density(h)
    }

    /// h of a small turn, from a uniform number in [0, 1).
    #[inline]
    pub fn sample(&self, wavelength: usize, u: f64) -> f64 {
        self.by_wavelength[wavelength].sample(u)
    }

    /// Share of the light that goes into the lobe, of all wavelengths' mean.
    pub fn share(&self) -> f64 {
        self.by_wavelength.iter().map(|lobe| lobe.share).sum::<f64>() / self.by_wavelength.len() as f64
    }

    /// How unlikely a turn by h is to be drawn, sr: the same number for every path that has such a turn.
    #[inline]
    pub fn rarity(&self, h: f64) -> f64 {
        let middle = &self.by_wavelength[self.by_wavelength.len() / 2];
        1.0 / middle.density(h).max(1e-3 * LEVEL)
    }
}

impl Staircase {
    fn new(mixture: &[(f64, &PhaseFunction)]) -> Self {
        let total: f64 = mixture.iter().map(|(weight, _)| weight).sum();
        let below = |h: f64| mixture.iter().map(|(weight, phase)| weight / total * phase.cdf(h)).sum::<f64>();
        let n_steps = step_of(1.0);
        let mut h: Vec<f64> = (0..=n_steps).map(lower_end).collect();
        let solid_angle = |h: &[f64]| TAU * (h[1] - h[0]);
        let mut excess: Vec<f64> =
            h.windows(2).map(|h| ((below(h[1]) - below(h[0])) / solid_angle(h) - LEVEL).max(0.0)).collect();
        let lit = excess.iter().rposition(|excess| *excess > 0.0).map_or(0, |last| last + 1);
        h.truncate(lit + 1);
        excess.truncate(lit);
        let share = excess.iter().zip(h.windows(2)).map(|(excess, h)| excess * solid_angle(h)).sum();
        let peak = LEVEL + excess.iter().copied().fold(0.0, f64::max);
        excess.iter_mut().for_each(|excess| *excess += FLOOR * LEVEL);
        let mut sum = 0.0;
        let mut cdf: Vec<f64> = Vec::with_capacity(lit);
        for (excess, h) in excess.iter().zip(h.windows(2)) {
            sum += excess * solid_angle(h);
            cdf.push(sum);
        }
        cdf.iter_mut().for_each(|below| *below /= sum);
        excess.iter_mut().for_each(|excess| *excess /= sum);
        Self { h, density: excess, cdf, share, peak }
    }

    #[inline]
    fn density(&self, h: f64) -> f64 {
        self.density.get(step_of(h)).copied().unwrap_or(0.0)
    }

    #[inline]
    fn sample(&self, u: f64) -> f64 {
        let step = self.cdf.partition_point(|below| *below <= u).min(self.cdf.len() - 1);
        let before = if step == 0 { 0.0 } else { self.cdf[step - 1] };
        let z = (u - before) / (self.cdf[step] - before);
        self.h[step] + z * (self.h[step + 1] - self.h[step])
    }
}

/// Steps are equal parts of each doubling of h: the leading bits of a float number them.
#[inline]
fn step_of(h: f64) -> usize {
    if h < FIRST_H {
        return 0;
    }
    1 + ((h.to_bits() >> (52 - STEP_BITS)) - (FIRST_H.to_bits() >> (52 - STEP_BITS))) as usize
}

fn lower_end(step: usize) -> f64 {
    if step == 0 {
        return 0.0;
    }
    f64::from_bits((FIRST_H.to_bits() >> (52 - STEP_BITS)).wrapping_add(step as u64 - 1) << (52 - STEP_BITS))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lobes(g: f64) -> Option<ForwardLobes> {
        let phase = PhaseFunction::henyey_greenstein(g);
        ForwardLobes::new(&[vec![(1.0, &phase)]])
    }

    #[test]
    fn steps_begin_where_they_say() {
        for step in [0, 1, 2, 9, 100, 344] {
            assert_eq!(step_of(lower_end(step)), step);
            assert_eq!(step_of(lower_end(step + 1).next_down()), step);
        }
    }

    #[test]
    fn only_sharp_functions_have_a_lobe() {
        assert!(lobes(0.0).is_none() && lobes(0.4).is_none() && lobes(-0.9).is_none());
        assert!(lobes(0.6).is_some() && lobes(0.9999).is_some());
    }

    /// The share of Henyey-Greenstein's function above the level, by its closed form.
    #[test]
    fn the_lobe_has_what_exceeds_the_level() {
        let phase = PhaseFunction::henyey_greenstein(0.85);
        let lobes = lobes(0.85).expect("it is sharp");
        let end = (0..2_000_000).map(|i| f64::from(i) * 5e-7).find(|h| phase.eval(*h) < LEVEL).expect("it falls");
        let share = phase.cdf(end) - LEVEL * TAU * end;
        assert!((lobes.share() - share).abs() < 2e-3, "{} {share}", lobes.share());
        assert_eq!(lobes.part(0, end + 0.1, 1.0), 0.0);
        // Steps are flat where the function falls, by a tenth at most.
        let h = 0.01;
        assert!((lobes.part(0, h, phase.eval(h)) / lobes.share() / lobes.density(0, h) - 1.0).abs() < 0.1);
    }

    /// Chi-squared over the steps that hold most of the probability.
    #[test]
    fn samples_follow_the_density() {
        let lobes = lobes(0.9).expect("it is sharp");
        let lobe = &lobes.by_wavelength[0];
        let n = 400_000u32;
        let mut count = vec![0u32; lobe.density.len()];
        (0..n).for_each(|i| count[step_of(lobes.sample(0, (f64::from(i) + 0.5) / f64::from(n)))] += 1);
        for (step, count) in count.iter().enumerate() {
            let expected = lobe.density[step] * TAU * (lobe.h[step + 1] - lobe.h[step]) * f64::from(n);
            assert!((f64::from(*count) - expected).abs() <= 2.0, "{step} {count} {expected}");
        }
    }
}
