//! Averages over sizes against an independent calculation with a million radii per case.

use mie_cloud::optics::distribution::SizeDistribution;
use mie_cloud::optics::size_average::{AverageAccuracy, SizeAverage, Sizes};
use num_complex::Complex64;
use serde_json::Value;

/// The distributions of the file, as this project writes them.
fn distribution(name: &str) -> SizeDistribution {
    let text = match name {
        // alpha / gamma / rc^gamma = 15.1186.
        "hazeL" => format!("modgamma:alpha=2,gamma=0.5,rc={:.16e}um", (4.0f64 / 15.1186).powi(2)),
        "cloudC1" => "modgamma:alpha=6,gamma=1,rc=4um".into(),
        "fog4" => "gamma:reff=4um,veff=0.1".into(),
        "fog10" => "gamma:reff=10um,veff=0.2".into(),
        "fog10b" => "gamma:reff=10um,veff=0.1".into(),
        "lognormal" => format!("lognormal:rg=0.1um,sigma={}", 2f64.ln()),
        other => panic!("unknown distribution {other}"),
    };
    let text = format!("{text},rmin=0.001um,rmax=60um");
    SizeDistribution::parse(&text, &|name| Err(name.into())).expect(&text)
}

fn number(case: &Value, key: &str) -> f64 {
    case[key].as_f64().expect(key)
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().expect("array").iter().map(|value| value.as_f64().expect("number")).collect()
}

#[test]
fn averages_agree_with_the_reference() {
    let text = include_str!("data/mie/size_averages.json");
    let file: Value = serde_json::from_str(text).expect("JSON");
    let angles: Vec<f64> = numbers(&file["angles_deg"]).iter().map(|deg| deg.to_radians()).collect();
    let mut failures = Vec::new();
    for case in file["cases"].as_array().expect("cases") {
        let name = case["dist"].as_str().expect("dist");
        let law = distribution(name).law();
        let m = Complex64::new(number(case, "m_re"), number(case, "m_im"));
        let sizes = Sizes::Law(Box::new(law));
        let average = SizeAverage::new(m, number(case, "wavelength_nm") * 1e-9, &sizes, AverageAccuracy::default())
            .expect("in the domain");
        assert!(average.ensemble.len() <= 4096);
        let relative = |found: f64, exact: f64| (found / exact - 1.0).abs();
        let c_ext = relative(average.cross_sections.c_ext_m2 * 1e12, number(case, "Cext_um2"));
        let g = relative(average.cross_sections.g, number(case, "g"));
        let area = relative(average.cross_sections.area_m2 * 1e12, number(case, "mean_area_um2"));
        let phase = average.phase(&angles).expect("angles");
        let mut p: Vec<f64> = phase
            .iter()
            .zip(numbers(&case["P"]))
            .map(|(p, exact)| relative(p * 4.0 * std::f64::consts::PI, exact))
            .collect();
        p.sort_by(f64::total_cmp);
        let (median, worst) = (p[p.len() / 2], p[p.len() - 1]);
        let is_haze = matches!(name, "hazeL" | "lognormal");
        let limit = if is_haze { 1e-4 } else { 1e-3 };
        let line = format!(
            "{name} {} radii: C_ext {c_ext:.1e}, g {g:.1e}, area {area:.1e}, p {median:.1e} {worst:.1e}; estimate {:?}",
            average.ensemble.len(),
            average.change,
        );
        println!("{line}");
        if !(c_ext < limit && g < limit && area < 1e-5 && median < 2e-3 && worst < 1e-2) {
            failures.push(line);
        }
    }
    assert!(failures.is_empty(), "{failures:#?}");
}
