//! Intensities of unpolarised light: of one sphere, and weighted sums over many spheres at the same angles.
//!
//! Many spheres share the angular recurrence: it runs once per batch of spheres, a table of a few angles and orders
//! at a time that stays in the first-level cache, and each sphere then costs its sums alone.

use pulp::{Arch, Simd, WithSimd};

use super::{
    Angles, MieError, Series,
    amplitudes::{check_length, for_each_vector, in_twos},
    angles::{Source, TILE},
    angular::{Angular, OrderPair, PiTau, Split, start, sum_tabulated, tabulate},
};

/// Spheres per batch: the recurrence then costs less than a tenth of the sums (measured: no gain beyond).
const BATCH: usize = 16;

/// Pairs of orders that may wait, 3 MB of them: huge spheres gain nothing from waiting for each other.
const MAX_PENDING_PAIRS: usize = 1 << 15;

/// Pairs of orders per table: 64 orders of pi and tau at [`TILE`] angles take 16 kB.
const PAIRS_PER_TABLE: usize = 32;

impl Series {
    /// Intensities (|S1|^2 + |S2|^2) / 2 of unpolarised light at `theta_rad`, each in 0 ..= pi.
    ///
    /// # Errors
    /// As [`Series::amplitudes`].
    pub fn intensities(&self, theta_rad: &[f64], out: &mut [f64]) -> Result<(), MieError> {
        self.intensities_at(&Angles::new(theta_rad)?, out)
    }

    /// As [`Series::intensities`] at prepared angles. An [`IntensitySum`] is faster for many spheres.
    ///
    /// # Errors
    /// [`MieError::Lengths`] if `out` differs in length from `angles`.
    pub fn intensities_at(&self, angles: &Angles, out: &mut [f64]) -> Result<(), MieError> {
        check_length(angles, out.len())?;
        let mut sum = IntensitySum::new(angles);
        sum.add(self, 1.0);
        sum.write(out)
    }
}

/// A weighted sum of the intensities of many spheres at the same angles.
///
/// ```
/// use mie_cloud::mie::{Angles, IntensitySum, Solver};
/// use num_complex::Complex64;
///
/// let angles = Angles::new(&[0.0, 1.0, 2.0])?;
/// let mut solver = Solver::new();
/// let mut sum = IntensitySum::new(&angles);
/// for x in [1.0, 10.0, 100.0] {
///     sum.add(&solver.series(x, Complex64::new(1.33, 0.0))?, 1.0 / 3.0);
/// }
/// let mut mean = [0.0; 3];
/// sum.write(&mut mean)?;
/// # Ok::<(), mie_cloud::mie::MieError>(())
/// ```
#[derive(Clone, Debug)]
pub struct IntensitySum<'a> {
    angles: &'a Angles,
    /// Spheres that wait for their batch to be full.
    pending: Vec<Pending>,
    /// Sums at the folded angles and at their mirror images.
    forward: Vec<f64>,
    backward: Vec<f64>,
}

/// A sphere to be added.
#[derive(Clone, Debug)]
struct Pending {
    orders: Vec<OrderPair>,
    weight: f64,
    /// Intensities at exactly 0 and pi.
    on_axis: [f64; 2],
}

impl<'a> IntensitySum<'a> {
    /// An empty sum at `angles`.
    pub fn new(angles: &'a Angles) -> Self {
        let zeros = vec![0.0; angles.h.len()];
        Self { angles, pending: Vec::new(), forward: zeros.clone(), backward: zeros }
    }

    /// Adds `weight` times the intensities (|S1|^2 + |S2|^2) / 2 of `series`.
    pub fn add(&mut self, series: &Series, weight: f64) {
        let s = series.exact_axis();
        let on_axis = [s[0] * s[0] + s[1] * s[1], s[4] * s[4] + s[5] * s[5]];
        self.pending.push(Pending { orders: series.orders(), weight, on_axis });
        let pairs: usize = self.pending.iter().map(|sphere| sphere.orders.len()).sum();
        if self.pending.len() == BATCH || pairs > MAX_PENDING_PAIRS {
            self.flush();
        }
    }

    /// Writes the sum so far, one value per angle in the order they were given.
    ///
    /// # Errors
    /// [`MieError::Lengths`] if `out` differs in length from the angles.
    pub fn write(&mut self, out: &mut [f64]) -> Result<(), MieError> {
        check_length(self.angles, out.len())?;
        self.flush();
        for (out, source) in out.iter_mut().zip(&self.angles.sources) {
            *out = match *source {
                Source::Forward(entry) => self.forward[entry as usize],
                Source::Backward(entry) => self.backward[entry as usize],
            };
        }
        Ok(())
    }

    /// Adds the waiting spheres. Entries at exactly 0 and pi take their exact values instead of the recurrence's.
    fn flush(&mut self) {
        let axis = (self.angles.h.first() == Some(&0.0)).then(|| [self.forward[0], self.backward[0]]);
        let (forward, backward) = (&mut self.forward, &mut self.backward);
        match &self.pending[..] {
            [] => return,
            [sphere] => Arch::new().dispatch(AddOne { sphere, h: &self.angles.h, forward, backward }),
            spheres => Arch::new().dispatch(AddBatch { spheres, h: &self.angles.h, forward, backward }),
        }
        if let Some([mut forward, mut backward]) = axis {
            for sphere in &self.pending {
                forward += sphere.weight * sphere.on_axis[0];
                backward += sphere.weight * sphere.on_axis[1];
            }
            (self.forward[0], self.backward[0]) = (forward, backward);
        }
        self.pending.clear();
    }
}

/// Adds the weighted intensities of one sphere at every folded angle and its mirror image.
struct AddOne<'a> {
    sphere: &'a Pending,
    h: &'a [f64],
    forward: &'a mut [f64],
    backward: &'a mut [f64],
}

impl WithSimd for AddOne<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let half_weight = simd.splat_f64s(0.5 * self.sphere.weight);
        let (forward, _) = S::as_mut_simd_f64s(self.forward);
        let (backward, _) = S::as_mut_simd_f64s(self.backward);
        for_each_vector(
            simd,
            &self.sphere.orders,
            self.h,
            #[inline(always)]
            |vector, split| {
                forward[vector] = add_intensity(simd, half_weight, forward[vector], split.forward(simd));
                backward[vector] = add_intensity(simd, half_weight, backward[vector], split.backward(simd));
            },
        );
    }
}

/// The same for several spheres.
struct AddBatch<'a> {
    spheres: &'a [Pending],
    h: &'a [f64],
    forward: &'a mut [f64],
    backward: &'a mut [f64],
}

impl WithSimd for AddBatch<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let stride = TILE / S::F64_LANES;
        let (h, _) = S::as_simd_f64s(self.h);
        let (forward, _) = S::as_mut_simd_f64s(self.forward);
        let (backward, _) = S::as_mut_simd_f64s(self.backward);
        let zero = simd.splat_f64s(0.0);
        let mut table = vec![PiTau { pi: zero, tau: zero }; 2 * PAIRS_PER_TABLE * stride];
        let mut sums = vec![Split::zero(simd); self.spheres.len() * stride];
        let tiles = forward.chunks_exact_mut(stride).zip(backward.chunks_exact_mut(stride));
        for (h, (forward, backward)) in h.chunks_exact(stride).zip(tiles) {
            sums.fill(Split::zero(simd));
            sum_tile(simd, self.spheres, h, &mut table, &mut sums);
            for (sphere, sums) in self.spheres.iter().zip(sums.chunks_exact(stride)) {
                let half_weight = simd.splat_f64s(0.5 * sphere.weight);
                for (i, split) in sums.iter().enumerate() {
                    forward[i] = add_intensity(simd, half_weight, forward[i], split.forward(simd));
                    backward[i] = add_intensity(simd, half_weight, backward[i], split.backward(simd));
                }
            }
        }
    }
}

/// Sums the series of all spheres at one tile of angles; `sums` has the vectors of the first sphere, then the next.
#[inline(always)]
fn sum_tile<S: Simd>(
    simd: S,
    spheres: &[Pending],
    h: &[S::f64s],
    table: &mut [PiTau<S::f64s>],
    sums: &mut [Split<S::f64s>],
) {
    let stride = TILE / S::F64_LANES;
    let Some(longest) = spheres.iter().map(|sphere| &sphere.orders[..]).max_by_key(|orders| orders.len()) else {
        return;
    };
    let mut angular = [start(simd, [h[0], h[1]]); TILE / 2];
    for (angular, h) in angular.iter_mut().zip(h.as_chunks::<2>().0) {
        *angular = start(simd, *h);
    }
    for first in (0..longest.len()).step_by(PAIRS_PER_TABLE) {
        let until = longest.len().min(first + PAIRS_PER_TABLE);
        tabulate_tile(simd, &longest[first..until], &mut angular[..stride / 2], table);
        for (sphere, sums) in spheres.iter().zip(sums.chunks_exact_mut(stride)) {
            let until = sphere.orders.len().min(until);
            if let Some(orders) = sphere.orders.get(first..until) {
                sum_sphere(simd, orders, table, sums);
            }
        }
    }
}

#[inline(always)]
fn tabulate_tile<S: Simd>(
    simd: S,
    orders: &[OrderPair],
    angular: &mut [[Angular<S::f64s>; 2]],
    table: &mut [PiTau<S::f64s>],
) {
    let stride = TILE / S::F64_LANES;
    for (i, angular) in angular.iter_mut().enumerate() {
        tabulate(simd, orders, angular, table, [stride, 2 * i]);
    }
}

#[inline(always)]
fn sum_sphere<S: Simd>(simd: S, orders: &[OrderPair], table: &[PiTau<S::f64s>], sums: &mut [Split<S::f64s>]) {
    let stride = TILE / S::F64_LANES;
    if in_twos::<S>() {
        for (i, sums) in sums.as_chunks_mut::<2>().0.iter_mut().enumerate() {
            sum_tabulated(simd, orders, table, sums, [stride, 2 * i]);
        }
    } else {
        for (i, sums) in sums.as_chunks_mut::<1>().0.iter_mut().enumerate() {
            sum_tabulated(simd, orders, table, sums, [stride, i]);
        }
    }
}

/// `sum` plus `half_weight` (|S1|^2 + |S2|^2) from [S1 re, S1 im, S2 re, S2 im].
#[inline(always)]
fn add_intensity<S: Simd>(simd: S, half_weight: S::f64s, sum: S::f64s, [a, b, c, d]: [S::f64s; 4]) -> S::f64s {
    let s1 = simd.mul_add_f64s(a, a, simd.mul_f64s(b, b));
    let s2 = simd.mul_add_f64s(c, c, simd.mul_f64s(d, d));
    simd.mul_add_f64s(half_weight, simd.add_f64s(s1, s2), sum)
}

#[cfg(all(test, target_arch = "x86_64"))]
mod tests {
    use num_complex::Complex64;
    use pulp::{
        Scalar,
        x86::{V3, V4},
    };

    use super::*;

    /// Sums a batch by one instruction set: forward, then backward.
    fn batch_by(simd: impl Simd, spheres: &[Pending], h: &[f64]) -> Vec<f64> {
        let (mut forward, mut backward) = (vec![0.0; h.len()], vec![0.0; h.len()]);
        simd.vectorize(AddBatch { spheres, h, forward: &mut forward, backward: &mut backward });
        [forward, backward].concat()
    }

    /// Sums one sphere by one instruction set: forward, then backward.
    fn one_by(simd: impl Simd, sphere: &Pending, h: &[f64]) -> Vec<f64> {
        let (mut forward, mut backward) = (vec![0.0; h.len()], vec![0.0; h.len()]);
        simd.vectorize(AddOne { sphere, h, forward: &mut forward, backward: &mut backward });
        [forward, backward].concat()
    }

    /// Expected: the same bits, also where a sphere is added alone.
    #[test]
    fn instruction_sets_agree_to_the_last_bit() {
        let theta: Vec<f64> = (0..=100).map(|i| f64::from(i) * 0.03).collect();
        let angles = Angles::new(&theta).unwrap();
        let spheres: Vec<Pending> = [0.1, 5.0, 31.0, 200.0]
            .iter()
            .map(|&x| Series::new(x, Complex64::new(1.4, 1e-3)).unwrap())
            .map(|series| Pending { orders: series.orders(), weight: 0.7, on_axis: [0.0; 2] })
            .collect();
        let batch = batch_by(Scalar::new(), &spheres, &angles.h);
        let one = one_by(Scalar::new(), &spheres[3], &angles.h);
        let others = [
            V3::try_new().map(|simd| (batch_by(simd, &spheres, &angles.h), one_by(simd, &spheres[3], &angles.h))),
            V4::try_new().map(|simd| (batch_by(simd, &spheres, &angles.h), one_by(simd, &spheres[3], &angles.h))),
        ];
        assert!(others.iter().flatten().all(|got| *got == (batch.clone(), one.clone())));
    }
}
