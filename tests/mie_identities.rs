//! Spheres of any size and index obey what every Lorenz-Mie solution obeys, and never end in a NaN.

use std::f64::consts::PI;

use mie_cloud::mie::{Angles, IntensitySum, MieError, ScatteringMatrix, Series, Solver, domain, efficiencies};
use num_complex::Complex64;
use proptest::prelude::*;

/// Log-uniform between two positive bounds.
fn log_uniform(low: f64, high: f64) -> impl Strategy<Value = f64> {
    (low.ln()..high.ln()).prop_map(move |ln| ln.exp().clamp(low, high))
}

/// Real indices over the whole range, half of them close to 1.
fn real_part() -> impl Strategy<Value = f64> {
    prop_oneof![
        log_uniform(0.05, 20.0),
        log_uniform(1e-15, 1e-2).prop_map(|d| 1.0 + d),
        log_uniform(1e-15, 1e-2).prop_map(|d| 1.0 - d),
        Just(1.0),
        Just(0.05),
        Just(20.0),
    ]
}

/// Absorption from none over hardly any to metallic.
fn imaginary_part() -> impl Strategy<Value = f64> {
    prop_oneof![Just(0.0), Just(100.0), Just(f64::MIN_POSITIVE), log_uniform(1e-14, 100.0)]
}

fn index() -> impl Strategy<Value = Complex64> {
    (real_part(), imaginary_part()).prop_map(|(n, k)| Complex64::new(n, k))
}

fn assert_sane(x: f64, m: Complex64, solver: &mut Solver) {
    let q = solver.efficiencies(x, m).unwrap();
    for (name, value) in [("q_ext", q.q_ext), ("q_sca", q.q_sca), ("q_abs", q.q_abs), ("q_back", q.q_back)] {
        assert!(value.is_finite() && value >= 0.0, "{name} = {value} for x = {x}, m = {m}");
    }
    assert!(q.q_pr.is_finite() && q.g.is_finite() && q.g.abs() <= 1.0 + 1e-14, "{q:?} for x = {x}, m = {m}");
    assert!(m.im > 0.0 || q.q_abs == 0.0, "{q:?} for x = {x}, m = {m}");
}

#[test]
fn corners_of_the_domain_are_finite() {
    let mut solver = Solver::new();
    for x in [1e-6, 1e-3, 0.99999, 1.0, 1.5, 2.0, 10.0, 1e4, 1e6] {
        for n in [0.05, 0.7, 1.0 - f64::EPSILON / 2.0, 1.0, 1.0 + f64::EPSILON, 1.5, 20.0] {
            for k in [0.0, f64::MIN_POSITIVE, 1e-12, 1e-6, 1.0, 100.0] {
                assert_sane(x, Complex64::new(n, k), &mut solver);
            }
        }
    }
}

#[test]
fn what_lies_outside_the_domain_is_refused() {
    let good = Complex64::new(1.33, 0.0);
    for x in [0.0, -1.0, 9e-7, 1.1e6, f64::NAN, f64::INFINITY] {
        assert!(matches!(Series::new(x, good), Err(MieError::SizeParameter(_))), "x = {x}");
    }
    for (n, k) in [(0.049, 0.0), (20.1, 0.0), (1.33, -1e-9), (1.33, 101.0), (f64::NAN, 0.0), (1.33, f64::NAN)] {
        assert!(matches!(efficiencies(1.0, Complex64::new(n, k)), Err(MieError::Index { .. })), "{n} {k}");
    }
    for theta in [-1e-9, 3.2, f64::NAN] {
        assert!(matches!(Angles::new(&[theta]), Err(MieError::Angle(_))), "{theta}");
    }
    let series = Series::new(1.0, good).unwrap();
    assert_eq!(series.intensities(&[0.0, 1.0], &mut [0.0]), Err(MieError::Lengths { angles: 2, values: 1 }));
    assert_eq!(series.intensities(&[], &mut []), Ok(()));
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, rng_seed: proptest::test_runner::RngSeed::Fixed(3), cases: 500, ..ProptestConfig::default() })]

    #[test]
    fn every_sphere_of_the_domain_has_finite_efficiencies(x in log_uniform(1e-6, 1e5), m in index()) {
        assert_sane(x, m, &mut Solver::new());
    }

    #[test]
    fn amplitudes_are_finite_at_any_angle(x in log_uniform(1e-6, 1e4), m in index(), theta in 0.0..PI) {
        let angles = [0.0, 1e-300, 1e-9, theta, PI / 2.0, PI - 1e-9, PI];
        let (mut s1, mut s2) = ([Complex64::default(); 7], [Complex64::default(); 7]);
        Series::new(x, m).unwrap().amplitudes(&angles, &mut s1, &mut s2).unwrap();
        prop_assert!(s1.iter().chain(&s2).all(|s| s.is_finite()));
    }

    #[test]
    fn lossless_spheres_have_re_c_equal_to_the_square_of_c(x in log_uniform(1e-6, 1e4), n in real_part()) {
        let series = Series::new(x, Complex64::new(n, 0.0)).unwrap();
        for c in series.a.iter().chain(&series.b) {
            // Both sides come from p^2 and q^2; squares below 1e-300 lose digits to underflow.
            prop_assert!((c.re - c.norm_sqr()).abs() <= 4.0 * f64::EPSILON * c.re + 1e-300, "{c}");
        }
    }

    #[test]
    fn absorbing_spheres_extinguish_what_they_scatter_and_absorb(x in log_uniform(1e-6, 1e4), m in index()) {
        let series = Series::new(x, m).unwrap();
        let q = series.efficiencies();
        prop_assert_eq!(q.q_ext, q.q_sca + q.q_abs);
        // A passive sphere: |c|^2 <= Re c for every coefficient.
        for c in series.a.iter().chain(&series.b) {
            prop_assert!(c.norm_sqr() <= c.re * (1.0 + 1e-9) + 1e-18, "{c}");
        }
    }

    #[test]
    fn forward_amplitudes_obey_the_optical_theorem(x in log_uniform(1e-6, 1e4), m in index()) {
        let series = Series::new(x, m).unwrap();
        let (mut s1, mut s2) = ([Complex64::default(); 2], [Complex64::default(); 2]);
        series.amplitudes(&[0.0, PI], &mut s1, &mut s2).unwrap();
        let q = series.efficiencies();
        prop_assert_eq!(s1[0], s2[0]);
        prop_assert_eq!(s1[1], -s2[1]);
        prop_assert!((4.0 * s1[0].re / (x * x) - q.q_ext).abs() <= 1e-13 * q.q_ext + 1e-300);
        // The sum of N terms of about sqrt(q_ext) x each, alternating in sign.
        let back = 4.0 * s1[1].norm_sqr() / (x * x);
        prop_assert!((back - q.q_back).abs() <= 1e-10 * q.q_back + 1e-13 * q.q_sca, "{} {}", back, q.q_back);
    }

    #[test]
    fn spheres_keep_polarised_light_polarised(x in log_uniform(1e-3, 1e3), m in index(), theta in 0.0..PI) {
        let (mut s1, mut s2) = ([Complex64::default()], [Complex64::default()]);
        Series::new(x, m).unwrap().amplitudes(&[theta], &mut s1, &mut s2).unwrap();
        let f = ScatteringMatrix::from_amplitudes(s1[0], s2[0]);
        // Bohren & Huffman (1983), eq. 4.77 as printed, and S11^2 = S12^2 + S33^2 + S34^2.
        let i = Complex64::i();
        let s34 = 0.5 * i * (s1[0] * s2[0].conj() - s2[0] * s1[0].conj());
        let total = f.s12 * f.s12 + f.s33 * f.s33 + f.s34 * f.s34;
        prop_assert!((f.s34 - s34.re).abs() <= 1e-14 * f.s11);
        prop_assert!((total - f.s11 * f.s11).abs() <= 1e-13 * f.s11 * f.s11);
    }

    #[test]
    fn small_spheres_scatter_as_rayleigh_found(x in log_uniform(1e-6, 1e-4), n in 0.05..3.0, k in 0.01..3.0) {
        let m = Complex64::new(n, k);
        let polarisability = (m * m - 1.0) / (m * m + 2.0);
        // The next term is smaller by x^2 |m|^2 and more where m^2 is close to -2.
        prop_assume!((m * m + 2.0).norm() > 0.3);
        let q = efficiencies(x, m).unwrap();
        let sca = 8.0 / 3.0 * x.powi(4) * polarisability.norm_sqr();
        let abs = 4.0 * x * polarisability.im;
        prop_assert!((q.q_sca / sca - 1.0).abs() < 1e-5, "{} {}", q.q_sca, sca);
        prop_assert!((q.q_abs / abs - 1.0).abs() < 1e-5, "{} {}", q.q_abs, abs);
    }
}

/// Nodes and weights of Gauss-Legendre quadrature in theta over 0 ..= pi.
fn gauss(n: usize) -> Vec<(f64, f64)> {
    let legendre = |z: f64| {
        let (mut p0, mut p1) = (1.0, z);
        for k in 2..=n {
            (p0, p1) = (p1, ((2 * k - 1) as f64 * z * p1 - (k - 1) as f64 * p0) / k as f64);
        }
        (p1, n as f64 * (z * p1 - p0) / (z * z - 1.0))
    };
    let node = |i: usize| {
        let mut z = (PI * (i as f64 + 0.75) / (n as f64 + 0.5)).cos();
        for _ in 0..10 {
            let (p, slope) = legendre(z);
            z -= p / slope;
        }
        let slope = legendre(z).1;
        (0.5 * PI * (1.0 - z), PI / ((1.0 - z * z) * slope * slope))
    };
    (0..n).map(node).collect()
}

#[test]
fn integrals_of_the_intensity_are_q_sca_and_g() {
    for (x, n, k) in [(0.1, 1.5, 0.0), (3.0, 1.33, 0.0), (30.0, 1.5, 0.1), (100.0, 0.75, 0.0), (100.0, 1.33, 1e-6)] {
        let series = Series::new(x, Complex64::new(n, k)).unwrap();
        let q = series.efficiencies();
        // The integrand is a trigonometric polynomial of degree 2 n_terms + 2 at most.
        let nodes = gauss(2 * q.n_terms + 40);
        let theta: Vec<f64> = nodes.iter().map(|node| node.0).collect();
        let mut intensity = vec![0.0; theta.len()];
        series.intensities(&theta, &mut intensity).unwrap();
        let moment = |f: fn(f64) -> f64| -> f64 {
            nodes.iter().zip(&intensity).map(|((t, w), i)| w * t.sin() * i * f(*t)).sum()
        };
        let (zeroth, first) = (moment(|_| 1.0), moment(f64::cos));
        // Rounding of about 1e3 terms; the quadrature itself is exact to 1e-14.
        assert!((2.0 * zeroth / (x * x) / q.q_sca - 1.0).abs() < 1e-11, "q_sca at x = {x}");
        assert!((first / zeroth / q.g - 1.0).abs() < 1e-10 / q.g.abs(), "g at x = {x}");
    }
}

#[test]
fn intensities_are_the_mean_squares_of_the_amplitudes() {
    let theta: Vec<f64> = (0..=37).map(|i| f64::from(i) * PI / 37.0).chain([0.1, 0.2, 3.0]).collect();
    let angles = Angles::new(&theta).unwrap();
    let mut sum = IntensitySum::new(&angles);
    let mut want = vec![0.0; theta.len()];
    // More spheres than a batch holds, of very different numbers of terms.
    for (i, weight) in (0..37).zip([2.0, 0.25, 1.0].into_iter().cycle()) {
        let x = 0.5 + f64::from(i * i * 7 % 151);
        let series = Series::new(x, Complex64::new(1.4, 0.001)).unwrap();
        let mut s1 = vec![Complex64::default(); theta.len()];
        let mut s2 = s1.clone();
        series.amplitudes_at(&angles, &mut s1, &mut s2).unwrap();
        sum.add(&series, weight);
        for ((want, s1), s2) in want.iter_mut().zip(&s1).zip(&s2) {
            *want += 0.5 * weight * (s1.norm_sqr() + s2.norm_sqr());
        }
    }
    let mut got = vec![0.0; theta.len()];
    sum.write(&mut got).unwrap();
    for (got, want) in got.iter().zip(&want) {
        assert!((got / want - 1.0).abs() < 1e-13, "{got} {want}");
    }
}

#[test]
fn a_solver_gives_the_same_after_any_other_sphere() {
    let mut solver = Solver::new();
    let spheres = [(1e3, 1.0001, 0.0), (0.1, 3.0, 1.0), (50.0, 0.8, 1e-3), (2.0, 1.00001, 1e-7), (300.0, 1.33, 0.0)];
    for (x, n, k) in spheres {
        let m = Complex64::new(n, k);
        assert_eq!(solver.efficiencies(x, m), efficiencies(x, m));
        assert_eq!(Series::new(x, m).map(|s| s.efficiencies()), efficiencies(x, m));
    }
}

#[test]
fn accuracy_is_promised_over_the_whole_domain() {
    let [low, high] = domain::SIZE_PARAMETER;
    assert!(domain::ACCURACY.is_sorted_by(|a, b| a.x_max < b.x_max));
    assert_eq!(domain::accuracy(low).x_max, 100.0);
    assert_eq!(domain::accuracy(high).x_max, high);
}
