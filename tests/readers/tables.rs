//! CSV files: materials, phase functions, size distributions.

use std::path::Path;

use mie_cloud::optics::distribution::SizeDistribution;
use mie_cloud::optics::material::Material;
use mie_cloud::optics::phase_model::{AngleTable, PhaseModel};
use mie_cloud::optics::phase_table::PhaseTable;

use super::check_message;

/// A CSV file, read as each of the three.
pub fn csv(bytes: &[u8], _folder: &Path) {
    let read = |_: &str| String::from_utf8(bytes.to_vec()).map_err(|_| "t.csv is not UTF-8 text".to_owned());
    match Material::parse("t.csv", &read) {
        Ok(material) => check_material(&material),
        Err(error) => check_message(&error.to_string(), "t.csv"),
    }
    match PhaseModel::parse("table:t.csv", &read) {
        Ok(PhaseModel::Table(table)) => check_phase(&table, bytes.len()),
        Ok(other) => panic!("{other} is no table"),
        Err(error) => check_message(&error.to_string(), "t.csv"),
    }
    match SizeDistribution::parse("csv:t.csv", &read) {
        Ok(sizes) => check_sizes(&sizes),
        Err(error) => check_message(&error.to_string(), "t.csv"),
    }
}

fn check_material(material: &Material) {
    for nm in [380.0, 550.0, 780.0] {
        match material.index(nm * 1e-9) {
            Ok(m) => assert!((0.05..=20.0).contains(&m.re) && (0.0..=100.0).contains(&m.im), "{m} at {nm} nm"),
            Err(error) => check_message(&error.to_string(), "t.csv"),
        }
    }
}

fn check_phase(table: &AngleTable, n_bytes: usize) {
    let table = PhaseTable::from_samples(&table.theta_rad, &table.value).expect("what was checked is a table");
    assert!(table.heap_bytes() < (64 << 10) * n_bytes, "{} bytes", table.heap_bytes());
    assert!(table.mean_cosine().abs() <= 1.0 + 1e-9, "g = {}", table.mean_cosine());
    for i in 0..=16 {
        let u = f64::from(i) / 16.0;
        let (h, p, cdf) = (table.sample(u), table.eval(2.0 * u), table.cdf(2.0 * u));
        assert!((0.0..=2.0).contains(&h), "sample {u} is {h}");
        assert!(p >= 0.0 && (-1e-9..=1.0 + 1e-9).contains(&cdf), "at {u}: {p}, {cdf}");
    }
}

/// Sizes that were accepted have a mean size within their limits.
pub fn check_sizes(sizes: &SizeDistribution) {
    let law = sizes.law();
    let (lower, upper) = (sizes.r_min_m, sizes.r_max_m);
    let slack = 1.0 + 1e-6;
    for u in [0.0, 0.01, 0.5, 0.99, 1.0] {
        let r_m = law.quantile(u);
        assert!(lower <= r_m * slack && r_m <= upper * slack, "{sizes}: quantile {u} is {r_m}");
    }
    let reff_m = law.effective_radius_m();
    assert!(lower <= reff_m * slack && reff_m <= upper * slack, "{sizes}: effective radius {reff_m}");
}
