//! Amplitudes S1, S2 of one sphere at any angles.

use num_complex::Complex64;
use pulp::{Arch, Simd, WithSimd};

use super::{
    Angles, MieError, Series,
    angles::Source,
    angular::{Order, OrderPair, Split, sum_orders},
};

/// The independent elements of the scattering matrix of a sphere at one angle (Bohren & Huffman 1983, eq. 4.77).
///
/// S21 = S12, S22 = S11, S43 = -S34 and S44 = S33; the others are zero.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ScatteringMatrix {
    /// (|S1|^2 + |S2|^2) / 2, the intensity of unpolarised light.
    pub s11: f64,
    /// (|S2|^2 - |S1|^2) / 2; -s12 / s11 is the degree of polarisation.
    pub s12: f64,
    /// Re(S1 S2*).
    pub s33: f64,
    /// Im(S2 S1*).
    pub s34: f64,
}

impl ScatteringMatrix {
    /// The matrix that belongs to the amplitudes `s1`, `s2`.
    pub fn from_amplitudes(s1: Complex64, s2: Complex64) -> Self {
        let (perpendicular, parallel) = (s1.norm_sqr(), s2.norm_sqr());
        let cross = s2 * s1.conj();
        Self {
            s11: 0.5 * (parallel + perpendicular),
            s12: 0.5 * (parallel - perpendicular),
            s33: cross.re,
            s34: cross.im,
        }
    }

    /// This matrix plus `weight` times another: spheres that scatter independently add up.
    pub fn plus(self, weight: f64, other: Self) -> Self {
        Self {
            s11: self.s11 + weight * other.s11,
            s12: self.s12 + weight * other.s12,
            s33: self.s33 + weight * other.s33,
            s34: self.s34 + weight * other.s34,
        }
    }
}

impl Series {
    /// Amplitudes S1 and S2 (Bohren & Huffman 1983, eq. 4.74) at `theta_rad`, each in 0 ..= pi.
    ///
    /// # Errors
    /// [`MieError::Angle`] for an angle out of range, [`MieError::Lengths`] if the slices differ in length.
    pub fn amplitudes(&self, theta_rad: &[f64], s1: &mut [Complex64], s2: &mut [Complex64]) -> Result<(), MieError> {
        self.amplitudes_at(&Angles::new(theta_rad)?, s1, s2)
    }

    /// As [`Series::amplitudes`] at prepared angles.
    ///
    /// # Errors
    /// [`MieError::Lengths`] if a slice differs in length from `angles`.
    pub fn amplitudes_at(&self, angles: &Angles, s1: &mut [Complex64], s2: &mut [Complex64]) -> Result<(), MieError> {
        check_length(angles, s1.len())?;
        check_length(angles, s2.len())?;
        let mut folded = vec![[0.0; 8]; angles.h.len()];
        Arch::new().dispatch(FoldedAmplitudes { orders: &self.orders(), h: &angles.h, out: &mut folded });
        if angles.h.first() == Some(&0.0) {
            folded[0] = self.exact_axis();
        }
        for ((source, s1), s2) in angles.sources.iter().zip(s1).zip(s2) {
            let s = match source {
                Source::Forward(entry) => &folded[*entry as usize][..4],
                Source::Backward(entry) => &folded[*entry as usize][4..],
            };
            *s1 = Complex64::new(s[0], s[1]);
            *s2 = Complex64::new(s[2], s[3]);
        }
        Ok(())
    }

    /// Weighted coefficients in pairs of orders, the last pair filled up with zeros.
    pub(super) fn orders(&self) -> Vec<OrderPair> {
        let order = |i: usize| {
            let n = (i + 1) as f64;
            let Some((a, b)) = self.a.get(i).zip(self.b.get(i)) else { return Order::default() };
            let weight = (2.0 * n + 1.0) / (n * (n + 1.0));
            Order {
                a_re: weight * a.re,
                a_im: weight * a.im,
                b_re: weight * b.re,
                b_im: weight * b.im,
                step: 1.0 + 1.0 / n,
                n,
            }
        };
        (0..self.a.len().div_ceil(2)).map(|pair| [order(2 * pair), order(2 * pair + 1)]).collect()
    }

    /// Amplitudes at exactly 0 and pi, laid out like an entry of [`FoldedAmplitudes`]: S1 = S2 and S1 = -S2.
    pub(super) fn exact_axis(&self) -> [f64; 8] {
        let (mut forward, mut backward) = (Complex64::default(), Complex64::default());
        for (i, (a, b)) in self.a.iter().zip(&self.b).enumerate().rev() {
            let weight = (2 * i + 3) as f64 * 0.5;
            forward += weight * (a + b);
            backward += if i % 2 == 0 { weight * (a - b) } else { weight * (b - a) };
        }
        let (f, b) = (forward, backward);
        [f.re, f.im, f.re, f.im, b.re, b.im, -b.re, -b.im]
    }
}

/// Refuses results whose number is not that of the angles.
pub(super) fn check_length(angles: &Angles, len: usize) -> Result<(), MieError> {
    if len == angles.len() { Ok(()) } else { Err(MieError::Lengths { angles: angles.len(), values: len }) }
}

/// Whether two vectors of angles go together. Each needs 13 registers, so AVX-512 (32) holds two and AVX2 (16) one;
/// single numbers wait for each other less in twos (measured: 1.6 times faster).
#[inline(always)]
pub(super) fn in_twos<S: Simd>() -> bool {
    S::REGISTER_COUNT >= 32 || S::F64_LANES == 1
}

/// Calls `visit` with every vector of folded angles summed, and its index.
#[inline(always)]
pub(super) fn for_each_vector<S: Simd>(
    simd: S,
    orders: &[OrderPair],
    h: &[f64],
    mut visit: impl FnMut(usize, Split<S::f64s>),
) {
    let (vectors, _) = S::as_simd_f64s(h);
    let (pairs, rest) = if in_twos::<S>() { vectors.as_chunks::<2>() } else { (&[][..], vectors) };
    for (i, pair) in pairs.iter().enumerate() {
        let [first, second] = sum_orders(simd, orders, *pair);
        visit(2 * i, first);
        visit(2 * i + 1, second);
    }
    for (i, &h) in rest.iter().enumerate() {
        let [sums] = sum_orders(simd, orders, [h]);
        visit(2 * pairs.len() + i, sums);
    }
}

/// Writes [S1 re, im, S2 re, im] forward and the same backward for every folded angle.
struct FoldedAmplitudes<'a> {
    orders: &'a [OrderPair],
    h: &'a [f64],
    out: &'a mut [[f64; 8]],
}

impl WithSimd for FoldedAmplitudes<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let lanes = S::F64_LANES;
        let mut planes = vec![0.0; 8 * lanes];
        let out = self.out;
        for_each_vector(
            simd,
            self.orders,
            self.h,
            #[inline(always)]
            |vector, split| {
                let (slots, _) = S::as_mut_simd_f64s(&mut planes);
                let (forward, backward) = (split.forward(simd), split.backward(simd));
                slots[..4].copy_from_slice(&forward);
                slots[4..8].copy_from_slice(&backward);
                for lane in 0..lanes {
                    for plane in 0..8 {
                        out[vector * lanes + lane][plane] = planes[plane * lanes + lane];
                    }
                }
            },
        );
    }
}

#[cfg(all(test, target_arch = "x86_64"))]
mod tests {
    use pulp::{
        Scalar,
        x86::{V3, V4},
    };

    use super::*;

    /// Runs the angular sums by one instruction set.
    fn amplitudes_by(simd: impl Simd, series: &Series, angles: &Angles) -> Vec<[f64; 8]> {
        let mut out = vec![[0.0; 8]; angles.h.len()];
        simd.vectorize(FoldedAmplitudes { orders: &series.orders(), h: &angles.h, out: &mut out });
        out
    }

    /// Products and sums are rounded once on every processor, so that tables are the same wherever they are made.
    #[test]
    fn instruction_sets_agree_to_the_last_bit() {
        let theta: Vec<f64> = (0..=90).map(|i| f64::from(i).to_radians()).collect();
        let angles = Angles::new(&theta).unwrap();
        for (x, n, k) in [(0.3, 1.33, 0.0), (40.0, 1.5, 0.01), (400.0, 1.33, 0.0)] {
            let series = Series::new(x, Complex64::new(n, k)).unwrap();
            let want = amplitudes_by(Scalar::new(), &series, &angles);
            let others = [
                V3::try_new().map(|simd| amplitudes_by(simd, &series, &angles)),
                V4::try_new().map(|simd| amplitudes_by(simd, &series, &angles)),
            ];
            for got in others.into_iter().flatten() {
                assert!(got == want, "x = {x}");
            }
        }
    }
}
