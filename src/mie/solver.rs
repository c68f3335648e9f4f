//! Solving spheres: the checked entry points and the scratch memory they share.

use num_complex::Complex64;
use pulp::{Arch, Simd, WithSimd};

use super::{
    Efficiencies, MieError, Series,
    coefficients::{BLOCK, Block},
    domain,
    efficiencies::Sums,
    terms::n_terms,
    waves::Waves,
};

/// Scratch memory for one thread that solves many spheres: it grows to the largest and is then reused.
///
/// ```
/// use mie_cloud::mie::Solver;
/// use num_complex::Complex64;
///
/// let mut solver = Solver::new();
/// for x in [1.0, 10.0, 100.0] {
///     let q = solver.efficiencies(x, Complex64::new(1.33, 0.0))?;
///     assert!(q.q_ext > 0.0);
/// }
/// # Ok::<(), mie_cloud::mie::MieError>(())
/// ```
#[derive(Clone, Debug, Default)]
pub struct Solver {
    waves: Waves,
}

impl Solver {
    /// A solver without memory yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// Efficiencies of the sphere of size parameter `x` and relative index `m`; the coefficients are not kept.
    ///
    /// # Errors
    /// [`MieError`] if `x` or `m` lies outside the domain.
    pub fn efficiencies(&mut self, x: f64, m: Complex64) -> Result<Efficiencies, MieError> {
        domain::check(x, m)?;
        Ok(Arch::new().dispatch(Solve { waves: &mut self.waves, x, m, a: &mut [], b: &mut [] }))
    }

    /// Scattering coefficients of the sphere of size parameter `x` and relative index `m`.
    ///
    /// # Errors
    /// [`MieError`] if `x` or `m` lies outside the domain.
    pub fn series(&mut self, x: f64, m: Complex64) -> Result<Series, MieError> {
        domain::check(x, m)?;
        let zeros = vec![Complex64::default(); n_terms(x)];
        let (mut a, mut b) = (zeros.clone(), zeros);
        let efficiencies = Arch::new().dispatch(Solve { waves: &mut self.waves, x, m, a: &mut a, b: &mut b });
        Ok(Series { x, m, a, b, efficiencies })
    }
}

/// Solves a sphere; keeps the coefficients if `a` and `b` have room for them.
struct Solve<'a> {
    waves: &'a mut Waves,
    x: f64,
    m: Complex64,
    a: &'a mut [Complex64],
    b: &'a mut [Complex64],
}

impl WithSimd for Solve<'_> {
    type Output = Efficiencies;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Efficiencies {
        let mut sums = Sums::new();
        let n_terms = self.waves.visit_blocks(
            self.x,
            self.m,
            #[inline(always)]
            |block| {
                sums.add(block);
                store(block, self.a, self.b);
            },
        );
        sums.finish(self.x, n_terms)
    }
}

/// Writes those orders of a block that the series keeps.
#[inline(always)]
fn store(block: &Block, a: &mut [Complex64], b: &mut [Complex64]) {
    let from = (block.first - 1).min(a.len());
    let to = a.len().min(from + BLOCK);
    for (i, (a, b)) in a[from..to].iter_mut().zip(&mut b[from..to]).enumerate() {
        *a = Complex64::new(block.a_re[i], block.a_im[i]);
        *b = Complex64::new(block.b_re[i], block.b_im[i]);
    }
}

/// Efficiencies of one sphere of size parameter `x` and relative index `m`.
///
/// A [`Solver`] saves the allocation where there are many.
///
/// # Errors
/// [`MieError`] if `x` or `m` lies outside the domain.
pub fn efficiencies(x: f64, m: Complex64) -> Result<Efficiencies, MieError> {
    Solver::new().efficiencies(x, m)
}

#[cfg(all(test, target_arch = "x86_64"))]
mod tests {
    use pulp::{
        Scalar,
        x86::{V3, V4},
    };

    use super::*;

    /// Efficiencies and coefficients by one instruction set.
    fn solved_by(simd: impl Simd, x: f64, m: Complex64) -> (Efficiencies, Vec<Complex64>, Vec<Complex64>) {
        let zeros = vec![Complex64::default(); n_terms(x)];
        let (mut a, mut b, mut waves) = (zeros.clone(), zeros, Waves::default());
        let efficiencies = simd.vectorize(BySimd(simd, Solve { waves: &mut waves, x, m, a: &mut a, b: &mut b }));
        (efficiencies, a, b)
    }

    /// `Solve` with an instruction set that is given.
    struct BySimd<'a, S>(S, Solve<'a>);

    impl<S: Simd> pulp::NullaryFnOnce for BySimd<'_, S> {
        type Output = Efficiencies;

        #[inline(always)]
        fn call(self) -> Efficiencies {
            self.1.with_simd(self.0)
        }
    }

    #[test]
    fn instruction_sets_agree_to_the_last_bit() {
        for (x, n, k) in [(1e-3, 1.33, 0.0), (0.7, 1.5, 0.1), (57.0, 1.33, 0.0), (321.0, 0.9, 1e-4), (4e3, 1.33, 1e-6)]
        {
            let m = Complex64::new(n, k);
            let want = solved_by(Scalar::new(), x, m);
            let others =
                [V3::try_new().map(|simd| solved_by(simd, x, m)), V4::try_new().map(|simd| solved_by(simd, x, m))];
            assert!(others.iter().flatten().all(|got| *got == want), "x = {x}, m = {m}");
        }
    }
}
