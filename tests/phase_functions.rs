//! Every phase function: normalised, sampled as it is evaluated, with the mean cosine that it claims.

use std::f64::consts::PI;

use mie_cloud::optics::hg_draine::HgDraine;
use mie_cloud::optics::phase_build::{TableAccuracy, build_adaptive};
use mie_cloud::optics::phase_function::PhaseFunction;
use mie_cloud::optics::phase_table::PhaseTable;
use mie_cloud::optics::size_average::{AverageAccuracy, SizeAverage, Sizes};
use num_complex::Complex64;
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64Mcg;
use statrs::distribution::{ChiSquared, ContinuousCDF};

/// Uniform in [0, 1) with 53 bits.
fn uniform(rng: &mut Pcg64Mcg) -> f64 {
    (rng.next_u64() >> 11) as f64 * 2f64.powi(-53)
}

fn hg_table(g: f64, tolerance: f64) -> PhaseTable {
    let exact = PhaseFunction::henyey_greenstein(g);
    let values = |theta: &[f64]| -> Result<Vec<f64>, ()> {
        Ok(theta.iter().map(|theta| exact.eval(2.0 * (0.5 * theta).sin().powi(2))).collect())
    };
    let accuracy = TableAccuracy { tolerance, max_nodes: 32_768 };
    build_adaptive(1.0 / (1.0 - g.abs()), accuracy, values).expect("no errors").expect("a table").table
}

fn mie_average(r_um: f64) -> SizeAverage {
    let sizes = Sizes::Radii(vec![(r_um * 1e-6, 1.0)]);
    SizeAverage::new(Complex64::new(1.333, 1e-9), 550e-9, &sizes, AverageAccuracy::default()).expect("in the domain")
}

fn mie_table(r_um: f64) -> PhaseTable {
    mie_average(r_um).phase_table(1e-3).expect("in the domain").expect("a table").table
}

fn file_table() -> PhaseTable {
    let theta: Vec<f64> = [0.0, 1.0, 10.0, 40.0, 90.0, 91.0, 140.0, 180.0].map(f64::to_radians).to_vec();
    PhaseTable::from_samples(&theta, &[1e3, 200.0, 5.0, 0.0, 0.3, 4.0, 0.1, 0.2]).expect("a table")
}

fn all() -> Vec<(String, PhaseFunction)> {
    let mut all = vec![("isotropic".into(), PhaseFunction::Isotropic), ("rayleigh".into(), PhaseFunction::Rayleigh)];
    for g in [0.0, 1e-9, 0.85, -0.6, 0.9999, -0.9999] {
        all.push((format!("hg:{g}"), PhaseFunction::henyey_greenstein(g)));
    }
    for diameter_um in [5.0, 20.0, 50.0] {
        let function = HgDraine::new(diameter_um).expect("in the fitted range");
        all.push((format!("hg-draine {diameter_um}"), PhaseFunction::HgDraine(function)));
    }
    all.push(("table of hg:0.9".into(), PhaseFunction::Tabulated(hg_table(0.9, 1e-3))));
    all.push(("file".into(), PhaseFunction::Tabulated(file_table())));
    for r_um in [0.01, 1.0, 20.0] {
        all.push((format!("mie {r_um} um"), PhaseFunction::Tabulated(mie_table(r_um))));
    }
    all
}

/// Integral of 2 pi p f over h, by midpoints in s = sqrt(h/2) between neighbouring quantiles.
fn integrate(phase: &PhaseFunction, f: impl Fn(f64) -> f64) -> f64 {
    let quantile = |i: usize| if i == 2000 { 1.0 } else { (0.5 * phase.sample(i as f64 / 2000.0)).sqrt() };
    let mut edges: Vec<f64> = (0..=2000).map(quantile).collect();
    edges[0] = 0.0;
    edges.sort_by(f64::total_cmp);
    let mut sum = 0.0;
    for edge in edges.windows(2) {
        let width = (edge[1] - edge[0]) / 512.0;
        for i in 0..512 {
            let s = edge[0] + (f64::from(i) + 0.5) * width;
            let h = 2.0 * s * s;
            sum += 8.0 * PI * s * phase.eval(h) * f(h) * width;
        }
    }
    sum
}

#[test]
fn every_function_integrates_to_one_and_has_its_mean_cosine() {
    for (name, phase) in all() {
        let total = integrate(&phase, |_| 1.0);
        assert!((total - 1.0).abs() < 1e-4, "{name}: {total}");
        let g = integrate(&phase, |h| 1.0 - h);
        assert!((g - phase.mean_cosine()).abs() < 1e-4, "{name}: {g} {}", phase.mean_cosine());
    }
}

#[test]
fn sampling_inverts_the_cumulative_probability() {
    for (name, phase) in all() {
        if name.starts_with("hg-draine") {
            continue;
        }
        for i in 0..1000 {
            let u = (f64::from(i) + 0.5) / 1000.0;
            let h = phase.sample(u);
            assert!((0.0..=2.0).contains(&h), "{name} {u}: {h}");
            // A backward peak is only as sharp as h near 2 has digits.
            let tolerance = if name == "hg:-0.9999" { 1e-7 } else { 1e-9 };
            assert!((phase.cdf(h) - u).abs() < tolerance, "{name} {u}: {}", phase.cdf(h));
        }
    }
}

#[test]
fn samples_are_distributed_as_the_function_is_evaluated() {
    let all = all();
    // Significance 0.01 over all functions (Sidak).
    let level = 1.0 - 0.99f64.powf(1.0 / all.len() as f64);
    for (name, phase) in all {
        let mut rng = Pcg64Mcg::seed_from_u64(7);
        // Cells of equal probability by midpoint integration of eval, not by the function's own cdf.
        const CELLS: usize = 200;
        const FINE: usize = 200_000;
        // Fine at both ends.
        let s_of = |i: usize| {
            let (t, back) = (i as f64 / FINE as f64, (FINE - i) as f64 / FINE as f64);
            t.powi(4) / (t.powi(4) + back.powi(4))
        };
        let mut cumulative = vec![0.0];
        for i in 0..FINE {
            let s = 0.5 * (s_of(i) + s_of(i + 1));
            let share = 8.0 * PI * s * phase.eval(2.0 * s * s) * (s_of(i + 1) - s_of(i));
            cumulative.push(cumulative[i] + share);
        }
        let total = cumulative[FINE];
        assert!((total - 1.0).abs() < 1e-4, "{name}: {total}");
        let mut edges: Vec<f64> = Vec::new();
        let mut expected = Vec::new();
        let mut last = 0.0;
        for cell in 1..=CELLS {
            let i = cumulative.partition_point(|share| *share < total * cell as f64 / CELLS as f64).min(FINE);
            edges.push(2.0 * s_of(i).powi(2));
            expected.push((cumulative[i] - last) / total);
            last = cumulative[i];
        }
        const SAMPLES: usize = 200_000;
        let (mut counts, mut mean, mut square) = (vec![0.0; CELLS], 0.0, 0.0);
        for _ in 0..SAMPLES {
            let h = phase.sample(uniform(&mut rng));
            counts[edges.partition_point(|edge| *edge <= h).min(CELLS - 1)] += 1.0;
            mean += (1.0 - h) / SAMPLES as f64;
            square += (1.0 - h).powi(2) / SAMPLES as f64;
        }
        let cells = expected.iter().zip(&counts).filter(|(expected, _)| **expected * SAMPLES as f64 >= 5.0);
        let chi2: f64 = cells
            .clone()
            .map(|(expected, count)| (count - expected * SAMPLES as f64).powi(2) / (expected * SAMPLES as f64))
            .sum();
        let freedom = (cells.count() - 1) as f64;
        let p_value = 1.0 - ChiSquared::new(freedom).expect("freedom").cdf(chi2);
        assert!(p_value > level, "{name}: chi2 {chi2} with {freedom} degrees of freedom, p = {p_value:e}");
        let sigma = ((square - mean * mean).max(1e-30) / SAMPLES as f64).sqrt();
        assert!((mean - phase.mean_cosine()).abs() < 4.0 * sigma, "{name}: {mean} {}", phase.mean_cosine());
    }
}

#[test]
fn the_largest_value_bounds_every_value() {
    for (name, phase) in all() {
        let largest = (0..100_000).map(|i| phase.eval(2.0 * (f64::from(i) / 99_999.0).powi(8))).fold(0.0, f64::max);
        assert!(largest <= phase.max_value() * (1.0 + 1e-12), "{name}");
        assert!(largest >= phase.max_value() * 0.9, "{name}: {largest} {}", phase.max_value());
    }
}

#[test]
fn extreme_numbers_stay_in_range() {
    for (name, phase) in all() {
        for u in [0.0, f64::MIN_POSITIVE, 1e-300, 0.5, 1.0 - f64::EPSILON / 2.0] {
            let h = phase.sample(u);
            assert!((0.0..=2.0).contains(&h), "{name} {u}: {h}");
            assert!(phase.eval(h).is_finite() && phase.eval(h) >= 0.0, "{name} {u}");
        }
        for h in [0.0, 1e-300, 1e-16, 2.0 - 4e-16, 2.0] {
            assert!(phase.eval(h).is_finite() && phase.eval(h) >= 0.0, "{name} {h}");
        }
    }
}

#[test]
fn a_table_of_henyey_greenstein_is_henyey_greenstein() {
    for (g, tolerance) in [(0.0, 1e-3), (0.85, 1e-3), (0.85, 1e-5), (-0.7, 1e-3), (0.9999, 1e-3)] {
        let (table, exact) = (hg_table(g, tolerance), PhaseFunction::henyey_greenstein(g));
        assert!((table.mean_cosine() - g).abs() < tolerance, "{g}: {}", table.mean_cosine());
        for i in 0..=5000 {
            let h = 2.0 * (f64::from(i) / 5000.0).powi(6);
            let error = table.eval(h) / exact.eval(h) - 1.0;
            assert!(error.abs() < 2.0 * tolerance + 2e-6, "{g} {tolerance} {h}: {error:e}");
        }
    }
}

#[test]
fn a_table_of_mie_is_mie() {
    for r_um in [0.01, 1.0, 5.0, 20.0, 100.0] {
        let average = mie_average(r_um);
        let table = mie_table(r_um);
        assert!((table.mean_cosine() - average.cross_sections.g).abs() < 1e-5, "{r_um}: {}", table.mean_cosine());
        let mut rng = Pcg64Mcg::seed_from_u64(3);
        let theta: Vec<f64> = (0..2000).map(|_| PI * uniform(&mut rng)).chain([0.0, PI]).collect();
        let exact = average.phase(&theta).expect("angles");
        let mut errors: Vec<f64> = theta
            .iter()
            .zip(&exact)
            .map(|(theta, exact)| (table.eval(2.0 * (0.5 * theta).sin().powi(2)) / exact - 1.0).abs())
            .collect();
        errors.sort_by(f64::total_cmp);
        let (most, worst) = (errors[errors.len() * 99 / 100], errors[errors.len() - 1]);
        println!(
            "{r_um} um: {} cells, g {:e}, {most:e} {worst:e}",
            table.cell_count(),
            table.mean_cosine() - average.cross_sections.g
        );
        assert!(most < 1.5e-3 && worst < 1e-2, "{r_um}: {most} {worst}");
    }
}

#[test]
fn the_forward_peak_of_a_fog_droplet_is_held() {
    // A regular grid in mu of 1001 nodes integrates this to four.
    let table = mie_table(20.0);
    let forward = mie_average(20.0).phase(&[0.0]).expect("angles")[0];
    assert!((table.eval(0.0) / forward - 1.0).abs() < 1e-3);
    assert!((table.max_value() / forward - 1.0).abs() < 1e-3);
}

#[test]
fn the_fitted_blend_refuses_what_it_was_not_fitted_to() {
    assert!(HgDraine::new(4.99).is_none() && HgDraine::new(50.01).is_none() && HgDraine::new(f64::NAN).is_none());
}

#[test]
fn what_cannot_be_normalised_is_no_table() {
    assert!(PhaseTable::from_samples(&[0.0, PI], &[0.0, 0.0]).is_none());
    assert!(PhaseTable::from_samples(&[0.0, PI], &[1.0, f64::NAN]).is_none());
    assert!(PhaseTable::from_samples(&[0.0, PI], &[1.0, -1.0]).is_none());
    assert!(PhaseTable::from_samples(&[0.0, 2.0], &[1.0, 1.0]).is_none());
    assert!(PhaseTable::from_samples(&[0.0, 1.0, 1.0, PI], &[1.0; 4]).is_none());
    assert!(PhaseTable::from_samples(&[], &[]).is_none());
}
