//! Tables of whole scenes: every phase model, the cap, the cache, overrides, and the errors.

use std::f64::consts::PI;
use std::fs;
use std::path::Path;

use mie_cloud::mie;
use mie_cloud::optics::DropletClass;
use mie_cloud::optics::bins::{BinPlan, DropletSize};
use mie_cloud::optics::count::{TableCount, TableStore};
use mie_cloud::optics::distribution::SizeDistribution;
use mie_cloud::optics::material::Material;
use mie_cloud::optics::phase_function::PhaseFunction;
use mie_cloud::optics::phase_model::PhaseModel;
use mie_cloud::optics::size_average::AverageAccuracy;
use mie_cloud::optics::tables::{OpticalTables, OpticsError, TableSettings};
use num_complex::Complex64;

fn class(phase: &str) -> DropletClass {
    let read = |_: &str| Ok("angle_deg,value\n0,2\n90,1\n180,1.5\n".into());
    DropletClass {
        material: Material::Water,
        phase: PhaseModel::parse(phase, &read).expect(phase),
        distribution: SizeDistribution::default(),
        albedo: None,
    }
}

fn settings<'a>(wavelengths_m: &'a [f64], cache: Option<&'a Path>) -> TableSettings<'a> {
    TableSettings {
        wavelengths_m,
        band_edges_m: &[],
        size_parameter_cap: 2e4,
        accuracy: AverageAccuracy::picture(),
        store: TableStore { cache, count: None },
    }
}

fn plan(classes: &[DropletClass], radii_um: &[f64]) -> BinPlan {
    let droplet = |um: &f64| DropletSize { class: 0, radius_m: (um * 1e-6) as f32, count: 1.0 };
    BinPlan::new(classes, radii_um.iter().map(droplet), None)
}

/// 8 bands over the visible range.
fn bands() -> Vec<f64> {
    (0..8).map(|i| (405.0 + 50.0 * f64::from(i)) * 1e-9).collect()
}

#[test]
fn a_single_radius_is_exact() {
    let classes = [class("mie")];
    let plan = plan(&classes, &[5.0]);
    let tables = OpticalTables::build(&plan, &classes, &settings(&[550e-9], None)).expect("tables");
    let optics = tables.get(plan.bin_of(0, 5e-6), 0);
    let m = Material::Water.index(550e-9).expect("visible");
    let q = mie::efficiencies(2.0 * PI * 5e-6 / 550e-9, m).expect("in the domain");
    assert!((optics.q_ext / q.q_ext - 1.0).abs() < 1e-12);
    assert!((optics.q_sca / q.q_sca - 1.0).abs() < 1e-12);
    assert!((optics.c_ext_m2 / (q.q_ext * PI * 25e-12) - 1.0).abs() < 1e-12);
    assert!((optics.g - q.g).abs() < 1e-12);
    assert!((optics.phase.mean_cosine() - q.g).abs() < 1e-4);
    assert!((tables.bins[0].mean_area_m2 / (PI * 25e-12) - 1.0).abs() < 1e-12);
}

#[test]
fn the_largest_efficiency_is_that_of_the_visible_range_in_every_mode() {
    let classes = [class("mie")];
    let plan = plan(&classes, &[0.3, 1.0, 5.0]);
    let q_max = |wavelengths_m: &[f64]| -> Vec<f64> {
        let tables = OpticalTables::build(&plan, &classes, &settings(wavelengths_m, None)).expect("tables");
        for bin in &tables.bins {
            assert!(bin.optics.iter().all(|optics| optics.q_ext <= bin.q_max));
        }
        tables.bins.iter().map(|bin| bin.q_max).collect()
    };
    let (mono, bands) = (q_max(&[550e-9]), q_max(&bands()));
    for ((mono, bands), r_m) in mono.iter().zip(&bands).zip([0.3e-6, 1e-6, 5e-6]) {
        assert!((mono / bands - 1.0).abs() < 0.02, "{mono} {bands}");
        let exact = (380..=780).map(|nm| {
            let wavelength_m = f64::from(nm) * 1e-9;
            let m = Material::Water.index(wavelength_m).expect("visible");
            mie::efficiencies(2.0 * PI * r_m / wavelength_m, m).expect("in the domain").q_ext
        });
        assert!((mono / exact.fold(0.0, f64::max) - 1.0).abs() < 0.03, "{mono}");
    }
}

#[test]
fn every_phase_model_has_its_function() {
    for (name, phase) in [
        ("isotropic", PhaseFunction::Isotropic),
        ("rayleigh", PhaseFunction::Rayleigh),
        ("hg:0.5", PhaseFunction::henyey_greenstein(0.5)),
    ] {
        let classes = [class(name)];
        let plan = BinPlan::of_distribution(&classes[0]);
        let tables = OpticalTables::build(&plan, &classes, &settings(&[550e-9], None)).expect(name);
        assert_eq!(*tables.get(0, 0).phase, phase, "{name}");
    }
    let build = |name: &str| {
        let classes = [class(name)];
        OpticalTables::build(&BinPlan::of_distribution(&classes[0]), &classes, &settings(&[550e-9], None)).expect(name)
    };
    let exact = build("mie");
    let g = build("hg").get(0, 0).phase.mean_cosine();
    assert!((g - exact.get(0, 0).g).abs() < 2e-3 && (0.8..0.9).contains(&g), "{g}");
    let fitted = build("hg-draine").get(0, 0).phase.mean_cosine();
    assert!((fitted - g).abs() < 0.03, "{fitted} {g}");
    assert!(matches!(*build("table:f.csv").get(0, 0).phase, PhaseFunction::Tabulated(_)));
}

/// Rationale: a table is normalised to what it shows of a peak. Set-up: Henyey-Greenstein of g = 0.95, whose peak is some degrees wide. Expected: a warning where
/// the integral of the table is off, and only there.
#[test]
fn tables_that_miss_a_peak_are_warned_of() {
    let g: f64 = 0.95;
    let value = |theta: f64| (1.0 - g * g) / (1.0 + g * g - 2.0 * g * theta.cos()).powf(1.5);
    for (step_deg, is_coarse) in [(20.0, true), (10.0, true), (5.0, true), (1.0, false), (0.25, false)] {
        let rows = (0..=(180.0 / step_deg) as u32).map(|i| f64::from(i) * step_deg);
        let csv: String = rows.map(|deg| format!("{deg},{}\n", value(deg.to_radians()))).collect();
        let phase = PhaseModel::parse("table:f.csv", &|_| Ok(csv.clone())).expect("a table");
        let classes = [DropletClass { phase, ..class("mie") }];
        let plan = BinPlan::of_distribution(&classes[0]);
        let tables = OpticalTables::build(&plan, &classes, &settings(&[550e-9], None)).expect("tables");
        let said: Vec<String> = tables.warnings.iter().map(ToString::to_string).collect();
        assert_eq!(said.len(), usize::from(is_coarse), "{step_deg} degrees: {said:?}");
        assert!(!is_coarse || said[0].contains("f.csv") && said[0].contains("more angles"), "{said:?}");
    }
}

#[test]
fn the_fitted_blend_is_refused_outside_its_range() {
    let classes = [class("hg-draine")];
    let error = OpticalTables::build(&plan(&classes, &[1.0]), &classes, &settings(&[550e-9], None)).unwrap_err();
    assert!(matches!(error, OpticsError::HgDraine { .. }), "{error}");
    assert!(error.to_string().contains("5 to 50 um"), "{error}");
}

#[test]
fn the_albedo_can_be_overridden() {
    for albedo in [0.0, 0.3, 1.0] {
        let classes = [DropletClass { albedo: Some(albedo), ..class("mie") }];
        let tables = OpticalTables::build(&BinPlan::of_distribution(&classes[0]), &classes, &settings(&[550e-9], None))
            .expect("tables");
        let optics = tables.get(0, 0);
        assert_eq!(optics.albedo, albedo);
        assert!((optics.c_sca_m2 - albedo * optics.c_ext_m2).abs() < 1e-24);
    }
}

#[test]
fn absorbing_droplets_have_their_albedo() {
    let material = Material::Constant { n: 1.5, k: 0.1 };
    let classes = [DropletClass { material, ..class("mie") }];
    let tables = OpticalTables::build(&plan(&classes, &[2.0]), &classes, &settings(&[550e-9], None)).expect("tables");
    let q = mie::efficiencies(2.0 * PI * 2e-6f64 / 550e-9, Complex64::new(1.5, 0.1)).expect("in the domain");
    assert!((tables.get(0, 0).albedo - q.q_sca / q.q_ext).abs() < 1e-6);
}

#[test]
fn large_drops_share_the_phase_function_at_the_cap() {
    let classes = [class("mie")];
    let plan = plan(&classes, &[500.0, 700.0]);
    let capped = TableSettings { size_parameter_cap: 1000.0, ..settings(&[550e-9], None) };
    let tables = OpticalTables::build(&plan, &classes, &capped).expect("tables");
    let (a, b) = (tables.get(0, 0), tables.get(1, 0));
    assert!(std::sync::Arc::ptr_eq(&a.phase, &b.phase));
    assert!(a.c_ext_m2 < b.c_ext_m2 && (a.q_ext - 2.0).abs() < 0.1);
    assert_eq!(tables.warnings.len(), 1);
    assert!(tables.warnings[0].to_string().contains("accuracy.size_parameter_cap"));
    assert!(tables.bytes() < 2 * a.phase.bytes());
}

#[test]
fn a_five_millimetre_drop_is_no_burden() {
    let classes = [class("mie")];
    let plan = plan(&classes, &[5000.0]);
    let tables = OpticalTables::build(&plan, &classes, &settings(&[550e-9], None)).expect("tables");
    let optics = tables.get(0, 0);
    assert!((optics.q_ext - 2.0).abs() < 0.01);
    assert!((optics.phase.mean_cosine() - optics.g).abs() < 0.01, "{} {}", optics.phase.mean_cosine(), optics.g);
    // The diffraction peak of x = 2e4: x^2 Q_ext^2 / (16 pi Q_sca).
    assert!((optics.phase.eval(0.0) / (4e8 * 2.0 / (16.0 * PI)) - 1.0).abs() < 0.05, "{:e}", optics.phase.eval(0.0));
}

#[test]
fn the_cache_and_the_threads_change_nothing() {
    let classes = [class("mie"), DropletClass { material: Material::Ice, ..class("mie") }];
    let droplets = (0..300u16).map(|i| DropletSize {
        class: i % 2,
        radius_m: if i < 2 { 0.0 } else { 2e-6 + f32::from(i) * 1e-8 },
        count: 1.0,
    });
    let plan = BinPlan::new(&classes, droplets, Some(3));
    let build = |cache| OpticalTables::build(&plan, &classes, &settings(&[450e-9, 650e-9], cache)).expect("tables");
    let equal = |a: &OpticalTables, b: &OpticalTables| {
        a.bins.iter().zip(&b.bins).all(|(a, b)| a.q_max == b.q_max && a.optics == b.optics)
    };
    let folder = tempfile::tempdir().expect("a folder");
    let plain = build(None);
    assert!(equal(&plain, &build(Some(folder.path()))));
    let entries: Vec<_> =
        fs::read_dir(folder.path()).expect("entries").map(|entry| entry.expect("entry").path()).collect();
    assert!(entries.len() >= plan.bins.len() * 2);
    assert!(equal(&plain, &build(Some(folder.path()))), "from the cache");
    for path in entries {
        fs::write(path, b"damaged").expect("written");
    }
    assert!(equal(&plain, &build(Some(folder.path()))), "damaged entries are made again");
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a pool");
    assert!(equal(&plain, &one.install(|| build(None))));
}

#[test]
fn wavelengths_outside_the_data_are_refused() {
    let classes = [class("mie")];
    let error = OpticalTables::build(&plan(&classes, &[5.0]), &classes, &settings(&[1e-3], None)).unwrap_err();
    assert!(matches!(error, OpticsError::Material(_)), "{error}");
}

#[test]
fn tables_of_a_fog_at_eight_wavelengths_take_a_fraction_of_a_second() {
    let classes = [class("mie")];
    let start = std::time::Instant::now();
    let tables = OpticalTables::build(&BinPlan::of_distribution(&classes[0]), &classes, &settings(&bands(), None))
        .expect("tables");
    let cells: Vec<usize> = tables.bins[0].optics.iter().map(|optics| optics.phase.bytes()).collect();
    println!("fog, 8 wavelengths: {:?}; bytes {cells:?}", start.elapsed());
    // A hundred times what is usual: a bound against mistakes, not a benchmark.
    assert!(start.elapsed().as_secs() < 30);
}

#[test]
fn hard_cases_give_finite_tables() {
    let material = |n, k| Material::Constant { n, k };
    let distribution = |text: &str| SizeDistribution::parse(text, &|name| Err(name.into())).expect(text);
    let cases = [
        (Material::Water, "mono:r=0.1nm"),
        (Material::Water, "mono:r=10nm"),
        (material(0.2, 3.5), "mono:r=2um"),
        (material(1.0001, 0.0), "mono:r=3um"),
        (material(10.0, 50.0), "mono:r=1um"),
        (material(2.0, 0.0), "gamma:reff=6um,veff=0.000001"),
        (Material::Ice, "gamma:reff=6um,veff=0.49"),
        (Material::Water, "lognormal:rg=0.01um,sigma=1.2"),
        (Material::Water, "gamma:reff=50um,veff=0.2"),
        (Material::Water, "gamma:reff=2mm,veff=0.1"),
    ];
    for (material, text) in cases {
        let classes = [DropletClass { material, distribution: distribution(text), ..class("mie") }];
        let accuracy = AverageAccuracy { max_radii: 64, ..AverageAccuracy::picture() };
        let small = TableSettings { size_parameter_cap: 1000.0, accuracy, ..settings(&[550e-9], None) };
        let tables = OpticalTables::build(&BinPlan::of_distribution(&classes[0]), &classes, &small).expect(text);
        let optics = tables.get(0, 0);
        for value in [optics.c_ext_m2, optics.c_sca_m2, optics.q_ext, tables.bins[0].q_max, optics.phase.max_value()] {
            assert!(value > 0.0 && value.is_finite(), "{text}: {optics:?}");
        }
        assert!((0.0..=1.0).contains(&optics.albedo), "{text}: {}", optics.albedo);
        let capped = !tables.warnings.is_empty();
        let difference = (optics.phase.mean_cosine() - optics.g).abs();
        assert!(difference < if capped { 0.02 } else { 0.01 }, "{text}: {difference}");
        for i in 0..100 {
            let h = optics.phase.sample(f64::from(i) / 100.0);
            assert!((0.0..=2.0).contains(&h) && optics.phase.eval(h) > 0.0, "{text}: {h}");
        }
    }
}

#[test]
fn bins_of_a_cloud_add_up_to_its_distribution() {
    let classes = [class("mie")];
    let law = classes[0].distribution.law();
    let radii: Vec<f32> = (0..100_000).map(|i| law.quantile((f64::from(i) + 0.5) / 1e5) as f32).collect();
    let droplet = |radius_m: &f32| DropletSize { class: 0, radius_m: *radius_m, count: 1.0 };
    let plan = BinPlan::new(&classes, radii.iter().map(droplet), None);
    let sliced = OpticalTables::build(&plan, &classes, &settings(&[550e-9], None)).expect("tables");
    let whole = BinPlan::of_distribution(&classes[0]);
    let whole = OpticalTables::build(&whole, &classes, &settings(&[550e-9], None)).expect("tables");
    let whole = whole.get(0, 0);
    // A droplet removes light over the Q_ext of its bin times its own area, as it does in pictures.
    let mut counts = vec![0.0; plan.bins.len()];
    let (mut c_ext, mut c_sca) = (0.0, vec![0.0; plan.bins.len()]);
    for radius_m in &radii {
        let bin = plan.bin_of(0, *radius_m) as usize;
        let area_m2 = PI * f64::from(*radius_m).powi(2);
        counts[bin] += 1.0;
        c_ext += sliced.bins[bin].optics[0].q_ext * area_m2 / 1e5;
        c_sca[bin] += sliced.bins[bin].optics[0].q_sca * area_m2 / 1e5;
    }
    assert!((c_ext / whole.c_ext_m2 - 1.0).abs() < 2e-3, "{}", c_ext / whole.c_ext_m2);
    let total: f64 = c_sca.iter().sum();
    for degrees in [0.0f64, 0.5, 2.0, 10.0, 40.0, 90.0, 120.0, 142.0, 165.0, 178.0, 180.0] {
        let h = 2.0 * (0.5 * degrees.to_radians()).sin().powi(2);
        let mixed: f64 =
            sliced.bins.iter().zip(&c_sca).map(|(bin, c_sca)| c_sca / total * bin.optics[0].phase.eval(h)).sum();
        let error = (mixed / whole.phase.eval(h) - 1.0).abs();
        println!("{degrees}: {error:e}");
        assert!(error < 0.02, "{degrees}: {error}");
    }
}

/// A ball of a metre as a droplet is a mistake that is warned about, not an error.
#[test]
fn droplets_beyond_the_series_take_the_efficiencies_of_its_largest() {
    let classes = [class("isotropic")];
    let tables = OpticalTables::build(&plan(&classes, &[1e6]), &classes, &settings(&[550e-9], None)).expect("tables");
    let optics = tables.get(0, 0);
    assert!((optics.q_ext - 2.0).abs() < 1e-3 && optics.q_ext > 2.0, "{}", optics.q_ext);
    assert!((optics.c_ext_m2 / (PI * optics.q_ext) - 1.0).abs() < 1e-6);
    assert!((tables.bins[0].mean_volume_m3 / (4.0 / 3.0 * PI) - 1.0).abs() < 1e-6);
}

/// The table of a single radius in a band is the mean over the band's wavelengths, here by brute force.
#[test]
fn a_single_radius_is_averaged_over_its_band() {
    let classes = [class("mie")];
    let edges_m = [530e-9, 580e-9];
    for radius_um in [0.3, 10.0] {
        let plan = plan(&classes, &[radius_um]);
        let in_band = TableSettings { band_edges_m: &edges_m, ..settings(&[555e-9], None) };
        let tables = OpticalTables::build(&plan, &classes, &in_band).expect("tables");
        let optics = tables.get(0, 0);
        let m = Material::Water.index(555e-9).expect("visible");
        let angles = mie::Angles::new(&[0.0, 0.02, 0.3, 1.0, 1.7, 2.4, 2.5, 3.0, PI]).expect("angles");
        let theta = [0.0, 0.02, 0.3, 1.0, 1.7, 2.4, 2.5, 3.0, PI];
        let n = 4000;
        let (mut c_ext, mut c_sca, mut scattered) = (0.0, 0.0, [0.0; 9]);
        for i in 0..n {
            let wavelength_m = edges_m[0] + (f64::from(i) + 0.5) / f64::from(n) * (edges_m[1] - edges_m[0]);
            let k = 2.0 * PI / wavelength_m;
            let r_m = f64::from((radius_um * 1e-6) as f32);
            let series = mie::Solver::new().series(k * r_m, m).expect("in the domain");
            let q = series.efficiencies();
            let share = PI * r_m * r_m / f64::from(n);
            c_ext += share * q.q_ext;
            c_sca += share * q.q_sca;
            let mut sum = mie::IntensitySum::new(&angles);
            sum.add(&series, 1.0);
            let mut intensities = [0.0; 9];
            sum.write(&mut intensities).expect("as many as angles");
            scattered.iter_mut().zip(intensities).for_each(|(sum, i)| *sum += i / (k * k * f64::from(n)));
        }
        assert!((optics.c_ext_m2 / c_ext - 1.0).abs() < 4e-3, "{} {c_ext}", optics.c_ext_m2);
        assert!((optics.c_sca_m2 / c_sca - 1.0).abs() < 4e-3);
        for (theta, scattered) in theta.iter().zip(scattered) {
            let p = optics.phase.eval(1.0 - theta.cos());
            // Twenty times the tolerance of averages: that of the worst angle, and as much for the radii left out.
            assert!((p * optics.c_sca_m2 / scattered - 1.0).abs() < 4e-2, "{radius_um} {theta}: {p}");
        }
    }
}

#[test]
fn every_table_is_counted() {
    let classes = [class("mie")];
    let plan = plan(&classes, &[5.0, 50.0]);
    let count = TableCount::default();
    let bands = bands();
    let store = TableStore { cache: None, count: Some(&count) };
    let counted = TableSettings { store, size_parameter_cap: 100.0, ..settings(&bands, None) };
    OpticalTables::build(&plan, &classes, &counted).expect("tables");
    let n_bins = plan.bins.len();
    // Bins at each wavelength, one more for each bin's largest cross section, and what the large ones share at each.
    let expected = n_bins * bands.len() + n_bins + bands.len();
    assert_eq!((n_bins, count.made_of()), (2, (expected, expected)));
}
