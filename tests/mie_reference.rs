//! Spheres against arbitrary-precision reference values, good to 20 digits (data: tests/data/mie), to the accuracy
//! that `mie::domain` promises.

use mie_cloud::mie::{Series, domain};
use num_complex::Complex64;
use serde_json::Value;

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

/// What the condition of an output allows; `pick` finds the number in the file's entry. Zero where it has none.
fn allowed_by_condition(case: &Value, key: &str, pick: impl Fn(&Value) -> Option<f64>) -> f64 {
    let condition = |kind: &str| pick(&case[kind][key]).unwrap_or(0.0);
    domain::CONDITION_ULPS * f64::EPSILON * (condition("cond_x") + condition("cond_m"))
}

/// One comparison: what, its error and its tolerance.
struct Deviation {
    what: String,
    error: f64,
    tolerance: f64,
}

fn efficiency_deviations(case: &Value, series: &Series) -> Vec<Deviation> {
    let q = series.efficiencies();
    let floor = domain::accuracy(series.x).efficiencies;
    let compare = |(key, got): (&str, f64)| {
        let want = number(case, key);
        let error = if want == 0.0 { got.abs() } else { (got / want - 1.0).abs() };
        let tolerance = allowed_by_condition(case, key, Value::as_f64).max(floor);
        Deviation { what: key.to_owned(), error, tolerance }
    };
    [("Qext", q.q_ext), ("Qsca", q.q_sca), ("Qabs", q.q_abs), ("g", q.g)].map(compare).into()
}

fn amplitude_deviations(case: &Value, series: &Series, angles: &[f64]) -> Vec<Deviation> {
    let mut got = [vec![Complex64::default(); angles.len()], vec![Complex64::default(); angles.len()]];
    let [s1, s2] = &mut got;
    series.amplitudes(angles, s1, s2).unwrap();
    let want = [complexes(&case["S1"]), complexes(&case["S2"])];
    let squares: f64 = want.iter().flatten().map(|s| s.norm_sqr()).sum();
    let rms = (squares / (2 * angles.len()) as f64).sqrt();
    let floor = domain::accuracy(series.x).amplitudes;
    let mut deviations = Vec::new();
    for (key, (got, want)) in ["S1", "S2"].into_iter().zip(got.iter().zip(&want)) {
        for (i, (got, want)) in got.iter().zip(want).enumerate() {
            let allowed = allowed_by_condition(case, key, |v| v[i].as_f64()) * want.norm() / rms;
            let what = format!("{key} at {} rad", angles[i]);
            deviations.push(Deviation { what, error: (got - want).norm() / rms, tolerance: allowed.max(floor) });
        }
    }
    // q_back is 4 |S1(180 deg)|^2 / x^2, so it inherits twice the error of S1 there.
    let back = want[0][angles.len() - 1].norm();
    let error = (series.efficiencies().q_back / number(case, "Qback") - 1.0).abs();
    let allowed = allowed_by_condition(case, "Qback", Value::as_f64);
    deviations.push(Deviation { what: "Qback".to_owned(), error, tolerance: allowed.max(2.0 * floor * rms / back) });
    deviations
}

/// Checks every case of a file, and that there are `n_cases`.
fn check_file(text: &str, n_cases: usize) {
    let file: Value = serde_json::from_str(text).unwrap();
    let angles: Vec<f64> = file["angles"].as_array().unwrap().iter().map(theta).collect();
    let cases = file["cases"].as_array().unwrap();
    assert_eq!(cases.len(), n_cases);
    let mut failures = Vec::new();
    for case in cases {
        let (x, m) = (number(case, "x"), Complex64::new(number(case, "m_re"), number(case, "m_im")));
        let series = Series::new(x, m).unwrap();
        let deviations = efficiency_deviations(case, &series).into_iter();
        for d in deviations.chain(amplitude_deviations(case, &series, &angles)) {
            if d.error.is_nan() || d.error > d.tolerance {
                failures
                    .push(format!("x = {x}, m = {m}: {} off by {:.1e}, allowed {:.1e}", d.what, d.error, d.tolerance));
            }
        }
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

#[test]
fn spheres_agree_with_the_reference() {
    check_file(include_str!("data/mie/reference.json"), 49);
}

#[test]
fn spheres_of_a_million_agree_with_the_reference() {
    check_file(include_str!("data/mie/reference_1e6.json"), 2);
}

#[test]
fn hard_spheres_agree_with_arbitrary_precision() {
    check_file(include_str!("data/mie/hard_cases.json"), 58);
}
