//! `mie-cloud mie` as a program: its numbers against reference values, its formats, its files and its complaints.

use std::f64::consts::PI;
use std::fs;
use std::io::Read;
use std::process::{Command, Stdio};

use assert_cmd::Command as Program;
use mie_cloud::optics::phase_model::PhaseModel;
use serde_json::Value;

fn program(args: &[&str]) -> Program {
    let mut program = Program::cargo_bin("mie-cloud").unwrap();
    program.arg("mie").args(args);
    program
}

fn output(args: &[&str]) -> String {
    String::from_utf8(program(args).assert().success().get_output().stdout.clone()).unwrap()
}

fn json(args: &[&str]) -> Value {
    serde_json::from_str(&output(&[args, &["--format", "json"]].concat())).unwrap()
}

fn complaint(args: &[&str], code: i32) -> String {
    let assert = program(args).assert().code(code);
    assert!(assert.get_output().stdout.is_empty(), "{args:?} printed data");
    String::from_utf8(assert.get_output().stderr.clone()).unwrap()
}

fn number(of: &Value, key: &str) -> f64 {
    of[key].as_f64().unwrap_or_else(|| panic!("no number {key}"))
}

fn numbers(of: &Value) -> Vec<f64> {
    of.as_array().unwrap().iter().map(|value| value.as_f64().unwrap()).collect()
}

fn pairs(of: &Value) -> Vec<[f64; 2]> {
    of.as_array().unwrap().iter().map(|pair| [pair[0].as_f64().unwrap(), pair[1].as_f64().unwrap()]).collect()
}

/// Relative difference.
fn off(found: f64, exact: f64) -> f64 {
    if found == exact { 0.0 } else { (found / exact - 1.0).abs() }
}

/// Spheres of the reference, one of each kind: small, of size one, metallic, large, near 1.
const CASES: [(f64, f64, f64); 6] = [
    (1e-6, 1.5, 1.0),
    (1.0, 10.0, 0.0),
    (10.0, 10.0, 10.0),
    (1000.0, 1.33, 1e-8),
    (100.0, 1.0001, 0.0),
    (7.0, 2.5, 0.0),
];

#[test]
fn spheres_agree_with_the_reference() {
    let file: Value = serde_json::from_str(include_str!("data/mie/reference.json")).unwrap();
    let angles: Vec<Option<f64>> = file["angles"].as_array().unwrap().iter().map(|a| a["theta_deg"].as_f64()).collect();
    let list: Vec<String> = angles.iter().flatten().map(f64::to_string).collect();
    for (x, n, k) in CASES {
        let case = file["cases"]
            .as_array()
            .unwrap()
            .iter()
            .find(|case| (number(case, "x"), number(case, "m_re"), number(case, "m_im")) == (x, n, k));
        let case = case.unwrap_or_else(|| panic!("x = {x} is not in the reference"));
        let (size, index) = (x.to_string(), format!("{n},{k}"));
        let found = json(&["--size-parameter", &size, "--index", &index, "--angles", &list.join(",")]);
        for (key, reference) in
            [("q_ext", "Qext"), ("q_sca", "Qsca"), ("q_abs", "Qabs"), ("q_back", "Qback"), ("g", "g")]
        {
            // The tolerance of the solver: its rounding, or that of x and m where the sphere is sensitive to them.
            let condition = |of: &str| case[of][reference].as_f64().unwrap_or(0.0);
            let tolerance = (4.0 * f64::EPSILON * (condition("cond_x") + condition("cond_m"))).max(1e-12);
            let error = off(number(&found, key), number(case, reference));
            assert!(error <= tolerance, "x = {x}: {key} off by {error:e}");
        }
        for (key, reference) in [("s1", "S1"), ("s2", "S2")] {
            let exact: Vec<[f64; 2]> = pairs(&case[reference])
                .into_iter()
                .zip(&angles)
                .filter_map(|(value, angle)| angle.map(|_| value))
                .collect();
            let values = pairs(&found[key]);
            assert_eq!(values.len(), exact.len());
            let rms = (exact.iter().map(|[a, b]| a * a + b * b).sum::<f64>() / exact.len() as f64).sqrt();
            for (value, exact) in values.iter().zip(&exact) {
                let error = (value[0] - exact[0]).hypot(value[1] - exact[1]) / rms;
                // The reference's own requirement at x = 1000; smaller spheres are far below it.
                assert!(error < 2e-11, "x = {x}: {key} off by {error:e}");
            }
        }
        assert_eq!((number(&found, "size_parameter"), numbers(&found["index"])), (x, vec![n, k]));
        assert!(found["terms"].as_u64().unwrap() as f64 > x);
        let q_pr = number(case, "Qext") - number(case, "g") * number(case, "Qsca");
        assert!(off(number(&found, "q_pr"), q_pr) < 1e-9);
    }
}

#[test]
fn distributions_agree_with_the_reference() {
    let file: Value = serde_json::from_str(include_str!("data/mie/size_averages.json")).unwrap();
    let angles: Vec<String> = numbers(&file["angles_deg"]).iter().map(f64::to_string).collect();
    // hazeL: alpha / gamma / rc^gamma = 15.1186.
    let haze = format!("modgamma:alpha=2,gamma=0.5,rc={:e}um", (4.0f64 / 15.1186).powi(2));
    for (name, text, limit) in [
        ("hazeL", haze.as_str(), 1e-4),
        ("cloudC1", "modgamma:alpha=6,gamma=1,rc=4um", 1e-3),
        ("fog4", "gamma:reff=4um,veff=0.1", 1e-3),
    ] {
        let case = file["cases"].as_array().unwrap().iter().find(|case| case["dist"] == name).unwrap();
        let limits = format!("{text},rmin={}um,rmax={}um", number(case, "r_min_um"), number(case, "r_max_um"));
        let wavelength = format!("{}nm", number(case, "wavelength_nm"));
        let index = format!("{},{}", number(case, "m_re"), number(case, "m_im"));
        let args = ["--distribution", &limits, "--wavelength", &wavelength, "--index", &index];
        let found = json(&[&args[..], &["--angles", &angles.join(",")]].concat());
        assert!(off(number(&found, "c_ext_m2") * 1e12, number(case, "Cext_um2")) < limit, "{name}");
        assert!(off(number(&found, "c_sca_m2") * 1e12, number(case, "Csca_um2")) < limit, "{name}");
        assert!(off(number(&found, "area_m2") * 1e12, number(case, "mean_area_um2")) < 1e-6, "{name}");
        assert!(off(number(&found, "g"), number(case, "g")) < limit, "{name}");
        // Absorption goes with the volume: it has no resonances to miss.
        assert!((number(&found, "albedo") - number(case, "ssa")).abs() < 1e-3 * number(case, "coalbedo") + 1e-15);
        // The file's phase functions have mean 1 over the sphere.
        let mut errors: Vec<f64> = numbers(&found["phase"])
            .iter()
            .zip(numbers(&case["P"]))
            .map(|(p, exact)| off(p * 4.0 * PI, exact))
            .collect();
        errors.sort_by(f64::total_cmp);
        assert!(errors[errors.len() / 2] < 2e-3 && errors[errors.len() - 1] < 1e-2, "{name}: {errors:?}");
        assert!((64..=4096).contains(&found["radii"].as_u64().unwrap()));
        let change = number(&found["convergence"], "phase_median");
        assert!(change > 0.0 && change < 1e-2, "{name}: {change}");
        assert!(off(number(&found, "effective_radius_um"), number(case, "r_eff_um")) < 1e-6, "{name}");
    }
}

#[test]
fn phase_functions_integrate_to_one_and_have_the_mean_cosine_g() {
    for args in [
        &["--size-parameter", "1e-3", "--index", "1.5,0.1"][..],
        &["--radius", "2um", "--material", "ice", "--wavelength", "600nm"],
        &["--distribution", "lognormal:rg=0.3um,sigma=0.4"],
    ] {
        let found = json(&[args, &["--angles", "0:180:0.05"]].concat());
        let mu: Vec<f64> = numbers(&found["angles_deg"]).iter().map(|deg| deg.to_radians().cos()).collect();
        let p = numbers(&found["phase"]);
        let (mut total, mut cosine) = (0.0, 0.0);
        for i in 1..mu.len() {
            let width = 2.0 * PI * (mu[i - 1] - mu[i]);
            total += 0.5 * width * (p[i - 1] + p[i]);
            cosine += 0.5 * width * (p[i - 1] * mu[i - 1] + p[i] * mu[i]);
        }
        // The trapezoidal rule with 0.05 degrees on structures of 180 / x > 3 degrees.
        assert!((total - 1.0).abs() < 1e-4, "{args:?}: {total}");
        assert!((cosine - number(&found, "g")).abs() < 1e-4, "{args:?}: {cosine}");
    }
}

#[test]
fn the_scattering_matrix_is_that_of_the_amplitudes() {
    let found = json(&["--radius", "1um", "--index", "1.5,0.01", "--angles", "0,1,37.5,90,141,180"]);
    let [s11, s12, s33, s34] = ["s11", "s12", "s33", "s34"].map(|key| numbers(&found[key]));
    for (i, (s1, s2)) in pairs(&found["s1"]).iter().zip(pairs(&found["s2"])).enumerate() {
        let (i1, i2) = (s1[0] * s1[0] + s1[1] * s1[1], s2[0] * s2[0] + s2[1] * s2[1]);
        let close = |found: f64, exact: f64| (found - exact).abs() <= 1e-14 * (i1 + i2);
        assert!(close(s11[i], 0.5 * (i2 + i1)) && close(s12[i], 0.5 * (i2 - i1)));
        // Bohren & Huffman 4.77: S33 = (S2* S1 + S2 S1*) / 2, S34 = i (S1 S2* - S2 S1*) / 2.
        assert!(close(s33[i], s1[0] * s2[0] + s1[1] * s2[1]) && close(s34[i], s2[1] * s1[0] - s2[0] * s1[1]));
        assert!(close((s12[i].powi(2) + s33[i].powi(2) + s34[i].powi(2)).sqrt(), s11[i]), "one sphere is pure");
    }
    assert_eq!((s12[0], s34[0], s33[0]), (0.0, 0.0, s11[0]), "exactly forward");
    assert_eq!((s12[5], s34[5], s33[5]), (0.0, 0.0, -s11[5]), "exactly backward");
}

#[test]
fn an_average_over_one_radius_is_one_sphere() {
    let rest = ["--wavelength", "633nm", "--index", "1.4,0.001", "--angles", "0:180:15"];
    let sphere = json(&[&["--radius", "1.5um"][..], &rest].concat());
    let average = json(&[&["--distribution", "mono:r=1.5um"][..], &rest].concat());
    for key in ["c_ext_m2", "c_sca_m2", "c_abs_m2", "albedo", "g"] {
        assert!(off(number(&average, key), number(&sphere, key)) < 1e-13, "{key}");
    }
    for key in ["phase", "s11", "s12", "s33", "s34"] {
        let scale = numbers(&sphere["s11"]);
        for ((a, b), scale) in numbers(&average[key]).iter().zip(numbers(&sphere[key])).zip(scale) {
            assert!((a - b).abs() <= 1e-12 * scale, "{key}: {a} {b}");
        }
    }
    assert_eq!(average["radii"], 1);
    assert_eq!((number(&sphere, "radius_um"), number(&sphere, "wavelength_nm")), (1.5, 633.0));
}

#[test]
fn a_size_parameter_with_a_wavelength_is_a_radius() {
    let found = json(&["--size-parameter", "10", "--wavelength", "500nm", "--material", "water"]);
    assert!(off(number(&found, "radius_um"), 10.0 * 0.5 / (2.0 * PI)) < 1e-14);
    let back = json(&["--radius", &format!("{}um", number(&found, "radius_um")), "--wavelength", "500nm"]);
    assert!(off(number(&back, "q_ext"), number(&found, "q_ext")) < 1e-12);
}

#[test]
fn csv_has_the_numbers_of_json_and_serves_as_a_phase_model() {
    let args = ["--radius", "1um", "--angles", "0:180:2"];
    let csv = output(&[&args[..], &["--format", "csv"]].concat());
    let found = json(&args);
    let header = csv.lines().find(|line| !line.starts_with('#')).unwrap();
    assert_eq!(header, "angle_deg,phase,s11,s12,s33,s34,s1_re,s1_im,s2_re,s2_im");
    let rows: Vec<Vec<f64>> = csv
        .lines()
        .skip_while(|line| *line != header)
        .skip(1)
        .map(|line| line.split(',').map(|field| field.parse().unwrap()).collect())
        .collect();
    assert_eq!(rows.len(), 91);
    for (column, key) in ["angles_deg", "phase", "s11", "s12", "s33", "s34"].iter().enumerate() {
        let values: Vec<f64> = rows.iter().map(|row| row[column]).collect();
        assert_eq!(values, numbers(&found[key]), "{key}");
    }
    let s2: Vec<[f64; 2]> = rows.iter().map(|row| [row[8], row[9]]).collect();
    assert_eq!(s2, pairs(&found["s2"]));
    let q_ext = csv.lines().find_map(|line| line.strip_prefix("# q_ext = ")).unwrap();
    assert_eq!(q_ext.split(' ').next().unwrap().parse::<f64>().unwrap(), number(&found, "q_ext"));
    let model = PhaseModel::parse("table:mie.csv", &|_| Ok(csv.clone())).unwrap();
    let PhaseModel::Table(table) = model else { panic!("not a table") };
    assert_eq!(table.value, numbers(&found["phase"]));
}

#[test]
fn every_format_names_units_and_normalisation() {
    for form in ["text", "csv", "json"] {
        for what in [["--radius", "1um"], ["--distribution", "mono:r=1um"]] {
            let text = output(&[&what[..], &["--format", form]].concat());
            for word in ["sr^-1", "integrates to 1 over the sphere", "nm", "m^2", "deg"] {
                assert!(text.contains(word), "{form} {what:?}: no {word}");
            }
        }
    }
    let found = json(&["--size-parameter", "1", "--index", "1.33,0"]);
    assert_eq!((&found["units"]["phase"], &found["units"]["angles_deg"]), (&"sr^-1".into(), &"deg".into()));
}

#[test]
fn text_is_a_table_for_reading() {
    let text = output(&["--size-parameter", "10", "--index", "1.33,0", "--angles", "0,180"]);
    let row = |name: &str| text.lines().find(|line| line.starts_with(name)).unwrap_or_else(|| panic!("no {name}"));
    assert_eq!(row("size_parameter").split_whitespace().nth(1), Some("10"));
    assert!(row("q_ext").contains("extinction"));
    assert_eq!(text.lines().filter(|line| line.trim_start().starts_with("180 ")).count(), 1);
}

#[test]
fn what_scatters_nothing_has_no_phase_function() {
    for what in
        [["--size-parameter", "5"], ["--distribution", "mono:r=1um"], ["--distribution", "gamma:reff=1um,veff=0.1"]]
    {
        let args = [&what[..], &["--index", "1,0"]].concat();
        let found = json(&args);
        assert_eq!((&found["phase"], &found["g"], &found["albedo"]), (&Value::Null, &Value::Null, &Value::Null));
        for form in ["csv", "text"] {
            let text = output(&[&args[..], &["--format", form]].concat());
            assert!(!text.contains("NaN") && !text.contains("inf"), "{text}");
        }
        let folder = tempfile::tempdir().unwrap();
        let plot = folder.path().join("p.svg");
        assert!(complaint(&[&args[..], &["--plot", plot.to_str().unwrap()]].concat(), 2).contains("scatters nothing"));
        assert!(!plot.exists());
    }
}

#[test]
fn the_ends_of_the_domain_give_finite_numbers() {
    for x in ["1e-6", "1e6"] {
        for index in ["0.05,0", "20,100", "1.33,1e-9"] {
            let text = output(&["--size-parameter", x, "--index", index, "--angles", "0,90,180", "--format", "json"]);
            assert!(!text.contains("null"), "{x} {index}: {text}");
        }
    }
}

#[test]
fn flags_that_make_no_sense_are_named() {
    let sphere = ["--size-parameter", "5", "--index", "1.33,0"];
    for (args, said) in [
        (&[][..], "--distribution <D>"),
        (&["--radius", "1um", "--distribution", "mono:r=1um"], "cannot be used with"),
        (&["--radius", "1um", "--size-parameter", "5"], "cannot be used with"),
        (&["--radius", "1um", "--index", "1.33,0", "--material", "ice"], "cannot be used with"),
        (&["--size-parameter", "5"], "--index N,K"),
        (&["--size-parameter", "-5", "--index", "1.33,0"], "1e-6 to 1e6"),
        (&["--size-parameter", "NaN", "--index", "1.33,0"], "not a number"),
        (&["--size-parameter", "2e6", "--index", "1.33,0"], "1e-6 to 1e6"),
        (&["--radius", "1um", "--index", "1.33,-0.1"], "k > 0 absorbs"),
        (&["--radius", "1um", "--index", "-1.33,0.1"], "0.05 <= n <= 20"),
        (&["--radius", "1um", "--index", "1,2,3"], "N,K"),
        (&["--radius", "5"], "needs a unit"),
        (&["--radius", "0um"], "above zero"),
        (&["--radius", "10m"], "--radius"),
        (&["--radius", "1e-30m"], "--radius 1e-30 m at 550 nm"),
        (&["--radius", "1um", "--wavelength", "450nm,550nm"], "one wavelength is needed"),
        (&["--radius", "1um", "--wavelength", "-550nm"], "--wavelength"),
        (&["--distribution", "lognormal:rg=3um,sigma=1.4"], "rmax=50um"),
        (&["--radius", "1um", "--wavelength", "0nm"], "above zero"),
        (&["--radius", "1um", "--wavelength", "1mm"], "205.1162 to 200000 nm"),
        (&["--radius", "1um", "--material", "watr"], "did you mean `water`"),
        (&["--radius", "1um", "--material", "none.csv"], "none.csv"),
        (&["--distribution", "gamma:reff=5um"], "needs the key `veff`"),
        (&["--distribution", "gama:reff=5um"], "did you mean `gamma`"),
        (&["--distribution", "csv:none.csv"], "none.csv"),
        (&["--distribution", "mono:r=1km"], "--distribution mono:r=1km at 550 nm"),
    ] {
        let text = complaint(args, 2);
        assert!(text.contains(said), "{args:?}: {text}");
    }
    for (angles, said) in
        [("0:181:1", "0 is forward"), ("0:180:0", "above zero"), ("a", "degrees"), ("0:180:1e-9", "longer step")]
    {
        let text = complaint(&[&sphere[..], &["--angles", angles]].concat(), 2);
        assert!(text.contains(said), "{angles}: {text}");
    }
}

#[test]
fn files_appear_whole_and_outputs_are_checked_first() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let args = ["--radius", "1um", "--format", "json"];
    let file = path("a.json");
    assert!(output(&[&args[..], &["-o", &file]].concat()).is_empty());
    assert_eq!(fs::read_to_string(&file).unwrap(), output(&args));
    // A usage error keeps the old file.
    complaint(&["--radius", "10m", "-o", &file], 2);
    assert_eq!(fs::read_to_string(&file).unwrap(), output(&args));
    for flag in ["-o", "--plot"] {
        let text = complaint(&["--radius", "1um", flag, &path("none/a.svg")], 1);
        assert!(text.contains("does not exist"), "{text}");
    }
    let both = path("both.svg");
    assert!(complaint(&["--radius", "1um", "-o", &both, "--plot", &both], 2).contains("both name"));
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
}

#[test]
fn a_closed_pipe_is_no_error() {
    let mut child = Command::new(assert_cmd::cargo::cargo_bin("mie-cloud"))
        .args(["mie", "--radius", "1um", "--angles", "0:180:0.01", "--format", "csv"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut first = [0; 16];
    child.stdout.take().unwrap().read_exact(&mut first).unwrap();
    let done = child.wait_with_output().unwrap();
    assert_eq!((done.status.code(), String::from_utf8(done.stderr).unwrap().as_str()), (Some(0), ""));
}

#[test]
fn plots_are_labelled_and_the_same_each_time() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("p.svg");
    for (args, words) in [
        (&["--radius", "5um"][..], ["r = 5 µm", "λ = 550 nm", "forward peak"]),
        (&["--size-parameter", "1500", "--index", "1.5,1e-4"], ["x = 1500", "10⁻⁴ i", "band: minimum to maximum"]),
        (&["--size-parameter", "1e-3", "--index", "1.33"], ["x = 0.001", "m = 1.33", "0.1"]),
        (&["--distribution", "gamma:reff=6um,veff=0.1"], ["gamma:reff=6um,veff=0.1", "µm²", "forward peak"]),
    ] {
        let draw = || {
            output(&[args, &["--plot", path.to_str().unwrap()]].concat());
            fs::read_to_string(&path).unwrap()
        };
        let svg = draw();
        for word in ["scattering angle θ (degrees)", "phase function p(θ) (sr⁻¹)", "−S₁₂/S₁₁"].iter().chain(&words)
        {
            assert!(svg.contains(word), "{args:?}: no {word}");
        }
        assert!(svg.starts_with("<svg width=\"880\"") && svg.trim_end().ends_with("</svg>"));
        assert!(!svg.contains("NaN") && !svg.contains("inf"));
        assert!(svg.len() < 400_000, "{} bytes", svg.len());
        assert_eq!(svg, draw());
    }
}

/// Labels of the axis tell what is shown, and the inset of the forward peak has no place in a close-up.
#[test]
fn plots_show_the_angles_that_are_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("p.svg");
    let draw = |flags: &[&str]| {
        let drop = ["--radius", "50um", "--plot", path.to_str().unwrap()];
        output(&[&drop[..], flags].concat());
        fs::read_to_string(&path).unwrap()
    };
    let has = |svg: &str, label: &str| svg.contains(&format!("\n{label}\n"));
    let whole = draw(&[]);
    assert!(has(&whole, "180") && has(&whole, "150") && whole.contains("forward peak"));
    assert_eq!(whole, draw(&["--angles", "0:180:45"]));
    assert_eq!(whole, draw(&["--angles", "90"]));
    let bow = draw(&["--angles", "130:145:0.5"]);
    assert!(has(&bow, "130") && has(&bow, "144") && !has(&bow, "150") && !bow.contains("forward peak"), "{bow}");
    let close = draw(&["--angles", "140.05,140"]);
    assert!(has(&close, "140.040") && !has(&close, "141"));
}

#[test]
fn help_names_units_defaults_and_examples() {
    let help = output(&["--help"]);
    for word in ["[default: 550nm]", "[default: water]", "[default: 0:180:10]", "Examples:", "degrees", "5um"] {
        assert!(help.contains(word), "no {word} in {help}");
    }
}
