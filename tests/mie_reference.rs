//! Spheres against arbitrary-precision reference values, good to 20 digits (data: tests/data/mie).

use mie_cloud::mie::Series;
use num_complex::Complex64;
use serde_json::Value;

/// Error of `got` relative to `want`, in units of its tolerance.
fn ratio(got: f64, want: f64, tolerance: f64) -> f64 {
    if want == 0.0 { if got == 0.0 { 0.0 } else { f64::INFINITY } } else { (got / want - 1.0).abs() / tolerance }
}

fn number(case: &Value, key: &str) -> f64 {
    case[key].as_f64().unwrap_or_else(|| panic!("{key} missing in {case}"))
}

fn complexes(values: &Value) -> Vec<Complex64> {
    let part = |v: &Value| v.as_f64().unwrap();
    values.as_array().unwrap().iter().map(|s| Complex64::new(part(&s[0]), part(&s[1]))).collect()
}

fn theta(angle: &Value) -> f64 {
    angle["theta_rad"].as_f64().unwrap_or_else(|| number(angle, "theta_deg").to_radians())
}

/// cond_x + cond_m of one output; zero where the file has none.
fn condition(case: &Value, key: &str) -> f64 {
    case["cond_x"][key].as_f64().unwrap_or(0.0) + case["cond_m"][key].as_f64().unwrap_or(0.0)
}

/// Tolerance of S1, S2 relative to their root mean square.
fn amplitude_tolerance(x: f64) -> f64 {
    match x {
        x if x <= 100.0 => 1e-12,
        x if x <= 3e3 => 2e-11,
        x if x <= 2e4 => 2e-10,
        x if x <= 1e5 => 1e-8,
        _ => 1e-7,
    }
}

fn check_file(text: &str) -> Vec<String> {
    let file: Value = serde_json::from_str(text).unwrap();
    let angles: Vec<f64> = file["angles"].as_array().unwrap().iter().map(theta).collect();
    let mut failures = Vec::new();
    for case in file["cases"].as_array().unwrap() {
        let (x, m) = (number(case, "x"), Complex64::new(number(case, "m_re"), number(case, "m_im")));
        let series = Series::new(x, m).unwrap();
        let q = series.efficiencies();
        let mut worst = Vec::new();
        for (key, got) in [("Qext", q.q_ext), ("Qsca", q.q_sca), ("Qabs", q.q_abs), ("g", q.g), ("Qback", q.q_back)] {
            let tolerance = (4.0 * f64::EPSILON * condition(case, key)).max(1e-12);
            worst.push((key, ratio(got, number(case, key), tolerance), tolerance));
        }
        let mut s1 = vec![Complex64::default(); angles.len()];
        let mut s2 = s1.clone();
        series.amplitudes(&angles, &mut s1, &mut s2).unwrap();
        let want = [complexes(&case["S1"]), complexes(&case["S2"])];
        let rms = (want.iter().flatten().map(|s| s.norm_sqr()).sum::<f64>() / (2 * angles.len()) as f64).sqrt();
        for (key, got, want) in [("S1", &s1, &want[0]), ("S2", &s2, &want[1])] {
            for i in 0..angles.len() {
                let cond =
                    case["cond_x"][key][i].as_f64().unwrap_or(0.0) + case["cond_m"][key][i].as_f64().unwrap_or(0.0);
                let tolerance = amplitude_tolerance(x).max(4.0 * f64::EPSILON * cond * want[i].norm() / rms);
                worst.push((key, (got[i] - want[i]).norm() / rms / tolerance, tolerance));
            }
        }
        if std::env::var("SHOW").is_ok() {
            let w: Vec<String> = ["Qext", "Qsca", "Qabs", "g", "Qback", "S1", "S2"]
                .iter()
                .map(|k| {
                    let e = worst
                        .iter()
                        .filter(|w| w.0 == *k)
                        .fold((0.0, 0.0), |a: (f64, f64), w| if w.1 > a.0 { (w.1, w.1 * w.2) } else { a });
                    format!("{k} {:.1e}/{:.2}", e.1, e.0)
                })
                .collect();
            println!("{x:>10.4e} {m} N={} {}", q.n_terms, w.join(" "));
        }
        for (key, ratio, tolerance) in worst {
            if ratio.is_nan() || ratio > 1.0 {
                failures.push(format!("x = {x}, m = {m}: {key} off by {ratio:.1} tolerances of {tolerance:.1e}"));
            }
        }
    }
    failures
}

#[test]
fn efficiencies_and_amplitudes_agree_with_the_reference() {
    let failures = check_file(include_str!("data/mie/reference.json"));
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

#[test]
fn a_sphere_of_a_million_agrees_with_the_reference() {
    let failures = check_file(include_str!("data/mie/reference_1e6.json"));
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}
