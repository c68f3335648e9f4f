//! `bench effects` and `bench accuracy` as processes: what they print and write, and that the numbers are what they say.

mod program;

use program::{Bench, assert_says, text};
use serde_json::Value;

fn row<'a>(report: &'a Value, key: &str, name: &str) -> &'a Value {
    let rows = report["rows"].as_array().expect("rows");
    rows.iter().find(|row| row[key] == name).unwrap_or_else(|| panic!("{name} is not in {rows:?}"))
}

fn rms(row: &Value, difference: &str) -> f64 {
    row[difference]["square"].as_f64().expect("a square").max(0.0).sqrt()
}

/// A background far brighter than the sun: without it the picture is black, a change of its root mean square.
#[test]
fn effects_are_measured_and_the_plan_is_judged() {
    let bench = Bench::with_cloud();
    let said = bench
        .ok("bench effects cloud.glb --resolution 12x8 --spp 4 --effects -multiple --set background.radiance=1e4 \
         --set atmosphere.scattering_per_m=1e-9 --csv e.csv --json e.json --to-target --repeat 2");
    assert_says(&said, &["effect", "background", "right: needed", "by hand", "right: not needed", "within the target"]);
    let report = bench.json("e.json");
    assert_eq!(report["rows"].as_array().map(Vec::len), Some(11));
    let background = row(&report, "effect", "background");
    assert_eq!((&background["planned"], &background["verdict"]), (&Value::Bool(true), &Value::from("needed")));
    // The cloud hides at most half of the light anywhere: the root mean square is above the mean, and close to it.
    assert!((0.999..1.2).contains(&rms(background, "change")), "{background}");
    assert!((background["change"]["bias"].as_f64().expect("a bias") + 1.0).abs() < 0.01, "{background}");
    assert_eq!(row(&report, "effect", "multiple")["verdict"], "by_hand");
    // It has no rays of its own; paths do.
    assert!(background["predicted_share"].is_null() && background["time_share"].is_null(), "{background}");
    let told = row(&report, "effect", "multiple")["predicted_share"].as_f64().expect("a share");
    assert!((0.0..1.0).contains(&told) && told > 0.0, "{told}");
    let refraction = row(&report, "effect", "refraction");
    assert_eq!((&refraction["verdict"], rms(refraction, "change")), (&Value::from("rightly_off"), 0.0));
    assert!(report["same_samples"]["ratio"]["median"].as_f64().is_some_and(|ratio| ratio > 0.0));
    assert!(report["to_target"]["planned_spp"].as_u64().is_some_and(|spp| spp > 0), "{}", report["to_target"]);
    let csv = text(&bench.read("e.csv"));
    assert_eq!(csv.lines().count(), 12, "{csv}");
    assert!(csv.lines().all(|line| line.split(',').count() == 15), "{csv}");
}

/// Noise falls like one over the root of the samples, a wrong phase function is a bias, and what cannot matter is said.
#[test]
fn knobs_are_swept_and_priced() {
    let bench = Bench::with_cloud();
    let said = bench
        .ok("bench accuracy cloud.glb --resolution 24x16 --spp 16 --knobs spp,bands,phase --csv a.csv --json a.json \
         --plot a.svg");
    assert_says(&said, &["without effect in this scene: bands", "cheapest for 10.0 %", "cheapest for 0.5 %"]);
    let report = bench.json("a.json");
    let setting = |name: &str| rms(row(&report, "setting", name), "error");
    // 384 pixels, whose squared errors are known to some 15 % each.
    let ratio = setting("1") / setting("16");
    assert!((2.5..6.5).contains(&ratio), "{ratio}");
    let isotropic = row(&report, "setting", "isotropic");
    assert!(rms(isotropic, "error") > 0.2, "{isotropic}");
    assert!(report["rows"].as_array().expect("rows").iter().any(|row| row["pareto"] == true));
    let prices = report["prices"].as_array().expect("prices");
    let cpu_s: Vec<f64> = prices.iter().filter_map(|price| price["cpu_s"].as_f64()).collect();
    assert!(cpu_s.len() == 3 && cpu_s[0] <= cpu_s[1] && cpu_s[1] <= cpu_s[2], "{cpu_s:?}");
    let svg = text(&bench.read("a.svg"));
    assert_says(&svg, &["<svg", "spp", "phase", "isotropic", "processor seconds"]);
    let csv = text(&bench.read("a.csv"));
    assert!(csv.lines().all(|line| line.split(',').count() == 14), "{csv}");
}

/// The accuracy that is asked for, as far as a tenth and the noise of few pixels go.
#[test]
fn targets_are_judged() {
    let bench = Bench::with_cloud();
    let said = bench.ok("bench accuracy cloud.glb --resolution 12x8 --spp 64 --knobs target --json a.json");
    assert_says(&said, &["asked for 10.0 %", "asked for 2.0 %"]);
    let report = bench.json("a.json");
    let rows = report["rows"].as_array().expect("rows");
    assert_eq!(rows.len(), 3);
    for row in rows {
        let target: f64 = row["setting"].as_str().and_then(|text| text.parse().ok()).expect("a target");
        let [square, error] = ["square", "square_error"].map(|key| row["error"][key].as_f64().expect(key));
        assert!(square < (1.2 * target).powi(2) + 4.0 * error, "{row}");
        assert!(row["noise"].as_f64().is_some_and(|noise| noise < 1.5 * target), "{row}");
    }
}

/// What two pictures and a coarse reference tell of the whole error is what one of thousands of samples says of the same pictures.
#[test]
fn the_whole_error_is_what_a_sharp_reference_says() {
    let bench = Bench::new();
    bench.ok("generate -o soft.glb --count 300 --kind parcels --size 2m --optical-depth 1 --set spectral.mode=rgb \
         --set droplets.phase=hg:0.8 -q");
    bench.ok(
        "render soft.glb -o r.exr --set accuracy.target=0.005 --spp 4096 --seed 9 --aov stderr -q --resolution 24x16",
    );
    let common = "bench accuracy soft.glb --resolution 24x16 --spp 256 --knobs spp,target --targets 0.1,0.05";
    bench.ok(&format!("{common} --json own.json"));
    bench.ok(&format!("{common} --reference r.exr --json sharp.json"));
    let [own, sharp] = ["own.json", "sharp.json"].map(|name| bench.json(name));
    for setting in ["64", "256", "0.1", "0.05"] {
        let [(a, e), (b, f)] = [&own, &sharp].map(|report| {
            let error = &row(report, "setting", setting)["error"];
            let [square, error] = ["square", "square_error"].map(|key| error[key].as_f64().expect(key));
            assert!(error < 0.4 * square, "{setting}: too noisy to tell: {square} +- {error}");
            (square, error)
        });
        assert!((a - b).abs() < 4.0 * e.hypot(f), "{setting}: {a} +- {e}, by the reference {b} +- {f}");
    }
}

/// A picture of the same settings as a reference: only noise differs, and that is known from its standard errors.
#[test]
fn a_reference_may_come_from_elsewhere() {
    let bench = Bench::with_cloud();
    bench.ok("render cloud.glb -o r.exr --spp 32 --seed 9 --aov stderr -q --resolution 24x16");
    bench.ok(
        "bench accuracy cloud.glb --resolution 24x16 --spp 32 --knobs angle_tolerance --reference r.exr --json a.json",
    );
    let report = bench.json("a.json");
    assert_eq!(report["reference"], "r.exr");
    let fine = row(&report, "setting", "0.01");
    let noise = report["finest"]["noise"].as_f64().expect("noise");
    assert!(rms(fine, "error") < noise, "noise {noise}: {fine}");
    let said = bench.fails(2, "bench accuracy cloud.glb --reference r.exr");
    assert_says(&said, &["r.exr", "24x16", "64x36", "--resolution"]);
    let pixel = |x, y| (0.5_f32, if (x, y) == (7, 4) { f32::NAN } else { 0.5 }, 0.5_f32);
    ::exr::prelude::write_rgb_file(bench.path("nan.exr"), 24, 16, pixel).expect("written");
    let said = bench.fails(1, "bench accuracy cloud.glb --resolution 24x16 --reference nan.exr");
    assert_says(&said, &["nan.exr", "(7, 4)", "not finite", "anew"]);
    assert_says(&bench.fails(2, "bench accuracy cloud.glb --knobs size_bin"), &["size_bins"]);
    assert_says(&bench.fails(1, "bench effects cloud.glb --json gone/e.json"), &["gone"]);
    assert_says(&bench.fails(3, "bench effects gone.glb"), &["gone.glb"]);
}

/// Four bands are too few where the noise is low; eight are enough for a spread of sizes and, as tables are means over bands, not
/// far from it for a single one, whose fringes alone would make tens of percent.
#[test]
fn the_summary_names_what_dominates_the_error() {
    let bench = Bench::with_cloud();
    bench.ok("generate -o many.glb --count 30 --size 2m --optical-depth 1 --distribution gamma:reff=5um,veff=0.1 -q");
    let error = |scene: &str, bands: u32, spp: u32| {
        let line = format!(
            "render {scene} -o a.exr --resolution 12x8 --set spectral.mode=bands:{bands} --spp {spp} --stats a.json"
        );
        let said = bench.run(&line);
        let error = bench.json("a.json")["error"].clone();
        let first = error["parts"][0].clone();
        assert_says(&text(&said.stderr), &["estimated error", "most of it", first["knob"].as_str().expect("a knob")]);
        let squares: f64 = error["parts"]
            .as_array()
            .expect("parts")
            .iter()
            .map(|p| p["error"].as_f64().expect("an error").powi(2))
            .sum();
        assert!((error["total"].as_f64().expect("a total") / squares.sqrt() - 1.0).abs() < 1e-9, "{error}");
        (first["knob"].as_str().map(str::to_owned), error)
    };
    assert_eq!(error("many.glb", 8, 4).0.as_deref(), Some("spp"));
    assert_eq!(error("cloud.glb", 4, 2048).0.as_deref(), Some("bands"));
    for (scene, most) in [("many.glb", 0.02), ("cloud.glb", 0.1)] {
        let (_, smooth) = error(scene, 8, 64);
        let bands = smooth["parts"].as_array().expect("parts").iter().find(|part| part["knob"] == "bands");
        assert!(bands.and_then(|part| part["error"].as_f64()).is_some_and(|e| e < most), "{smooth}");
    }
}
