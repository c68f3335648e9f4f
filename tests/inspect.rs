//! `inspect`: its text has everything that was understood, and its JSON the same numbers, which are those of a render.

mod program;
mod support;

use glam::{DQuat, DVec3};
use program::{Bench, assert_says};
use serde_json::{Value, json};
use support::{Gltf, everything};

fn inspected(bench: &Bench, line: &str) -> (String, Value) {
    let json = serde_json::from_str(&bench.ok(&format!("inspect {line} --json"))).expect("JSON");
    (bench.ok(&format!("inspect {line}")), json)
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().map(|all| all.iter().filter_map(Value::as_f64).collect()).unwrap_or_default()
}

fn assert_near(value: &Value, expected: &[f64]) {
    let found = if value.is_array() { numbers(value) } else { value.as_f64().into_iter().collect() };
    let near = |(a, b): (&f64, &f64)| (a - b).abs() <= 1e-6 * b.abs().max(1e-6);
    assert!(found.len() == expected.len() && found.iter().zip(expected).all(near), "{found:?}, not {expected:?}");
}

/// Droplets on a line that the camera looks at from its side, with radii of their own; drawn with a centimetre.
fn line_of_droplets(radii_um: &[f32]) -> Gltf {
    let mut gltf = Gltf::new();
    let places: Vec<f32> = (0..radii_um.len()).flat_map(|i| [0.05 * i as f32, 0.0, -10.0]).collect();
    let position = gltf.floats("VEC3", &places);
    let drawn = gltf.floats("SCALAR", &vec![0.01; radii_um.len()]);
    let own = gltf.floats("SCALAR", radii_um);
    let attributes = json!({ "POSITION": position, "_RADIUS": drawn, "_DROPLET_RADIUS_UM": own });
    gltf.json["meshes"] = json!([{ "primitives": [{ "mode": 0, "attributes": attributes }] }]);
    gltf.json["nodes"] = json!([{ "children": [1, 2] }, { "mesh": 0 }, { "name": "eye", "camera": 0 }]);
    gltf.json["cameras"] = json!([{ "type": "perspective", "perspective": { "yfov": 0.5, "znear": 0.1 } }]);
    gltf
}

/// Expected: the radii that the scene has, not those of a distribution that no droplet follows; and as many bins as a render makes.
#[test]
fn radii_of_their_own_are_counted() {
    let bench = Bench::new();
    let flags = "--set spectral.mode=mono:500nm --set image.resolution=4x3";
    // Few radii have a bin each, many share some.
    for n in [50_u16, 90] {
        let radii_um: Vec<f32> = (0..n).map(|i| 2f32.powf(f32::from(i) / 12.0)).collect();
        bench.write("a.gltf", &line_of_droplets(&radii_um).to_text());
        let (said, json) = inspected(&bench, &format!("a.gltf {flags}"));
        let (class, own) = (&json["classes"][0], &json["classes"][0]["own_radii"]);
        let radii_m: Vec<f64> = radii_um.iter().map(|um| f64::from(*um) * 1e-6).collect();
        let (edges, counts) = (numbers(&own["edges_m"]), numbers(&own["counts"]));
        assert_eq!((edges.len(), counts.len()), (17, 16));
        assert!(edges.windows(2).all(|edge| edge[0] < edge[1]), "{edges:?}");
        assert!(counts.iter().all(|count| *count >= 1.0) && counts.iter().sum::<f64>() == f64::from(n), "{counts:?}");
        // All are read in single precision.
        assert_near(&own["least_m"], &[radii_m[0]]);
        assert_near(&own["greatest_m"], &[radii_m[radii_m.len() - 1]]);
        assert_eq!((&own["least_m"], &own["greatest_m"]), (&json!(edges[0]), &json!(edges[16])));
        let sum = |power: i32| radii_m.iter().map(|r_m| r_m.powi(power)).sum::<f64>();
        assert_near(&own["effective_m"], &[sum(3) / sum(2)]);
        assert_eq!((&class["distribution_radii"], &class["particles"]), (&Value::Null, &json!(n)));
        let greatest = mie_cloud::units::short::length(radii_m[radii_m.len() - 1]);
        assert_eq!(class["sizes"], format!("radii 1 um to {greatest}"));
        let x = |r_m: f64| std::f64::consts::TAU * r_m / 500e-9;
        assert_near(&json["size_parameters"], &[x(radii_m[0]), x(radii_m[radii_m.len() - 1])]);

        bench.ok(&format!("render a.gltf -o a.exr --spp 1 -q --stats a.json {flags}"));
        assert_eq!(json["size_bins"], bench.json("a.json")["size_bins"]);
        assert_eq!(json["size_bins"].as_u64().map(|bins| bins == 50), Some(n == 50), "{}", json["size_bins"]);
        assert_eq!(class["size_bins"], json["size_bins"]);
        let bins = format!("bins        {} size bins at 1 wavelength, size parameters 12.6 to ", json["size_bins"]);
        assert_says(
            &said,
            &[&format!("water, radii 1 um to {greatest}, phase mie"), &bins, &format!(" {greatest}, effective ")],
        );
        // About as many in every bin: three full lines, but for those that have one more.
        let chart: Vec<&str> = said.lines().skip_while(|line| !line.starts_with("sizes ")).take(3).collect();
        assert!(chart.len() == 3 && chart[2].starts_with("            1 um ################ "), "{said}");
    }
}

#[test]
fn distributions_are_shown_by_shares() {
    let bench = Bench::new();
    let cloud = |distribution: &str| {
        bench.ok(&format!("generate -o a.glb --count 30 --size 2m --optical-depth 1 --distribution {distribution} -q"));
        inspected(&bench, "a.glb --set spectral.mode=rgb")
    };
    let (said, json) = cloud("gamma:reff=6um,veff=0.1,rmin=1um,rmax=20um");
    let law = &json["classes"][0]["distribution_radii"];
    let (edges, shares) = (numbers(&law["edges_m"]), numbers(&law["shares"]));
    assert!((shares.iter().sum::<f64>() - 1.0).abs() < 1e-12 && shares.len() == 16, "{shares:?}");
    assert_near(&json!([edges[0], edges[16]]), &[1e-6, 20e-6]);
    // The limits take a thousandth.
    assert!(law["effective_m"].as_f64().is_some_and(|reff_m| (reff_m / 6e-6 - 1.0).abs() < 1e-3), "{law}");
    assert_eq!((&json["classes"][0]["own_radii"], &json["size_bins"]), (&Value::Null, &json!(1)));
    assert_says(&said, &["\nsizes  ", "1 um ", " 20 um, effective 6 um\n", "bins        1 size bin at 3 wavelengths"]);

    let (said, json) = cloud("mono:r=5um");
    assert_eq!(json["classes"][0]["distribution_radii"]["shares"], json!([1.0]));
    assert_eq!(json["classes"][0]["distribution_radii"]["edges_m"], json!([5e-6, 5e-6]));
    assert!(!said.contains("\nsizes"), "one radius needs no chart: {said}");
}

/// Expected: bins as a render has them where droplets, parcels, balls of fog and several classes are together.
#[test]
fn every_form_of_droplets_has_its_bins() {
    let bench = Bench::new();
    bench.write("a.gltf", &everything().to_text());
    let (said, json) = inspected(&bench, "a.gltf --set spectral.mode=mono:550nm");
    bench.ok("render a.gltf -o a.exr --spp 1 -q --stats a.json --resolution 4x3 --set spectral.mode=mono:550nm");
    assert_eq!(json["size_bins"], bench.json("a.json")["size_bins"]);
    let classes = json["classes"].as_array().expect("classes");
    let sum = |key: &str| classes.iter().filter_map(|class| class[key].as_u64()).sum::<u64>();
    assert_eq!(Some(sum("particles")), bench.json("a.json")["particles"].as_u64());
    assert_eq!(Some(sum("size_bins")), json["size_bins"].as_u64());
    assert!(said.lines().skip(1).all(|line| line.chars().count() <= 80), "{said}");
}

#[test]
fn coverage_is_the_mean_of_alpha() {
    let bench = Bench::with_cloud();
    let (said, json) = inspected(&bench, "cloud.glb");
    bench.ok("render cloud.glb -o a.exr --spp 256 -q");
    let picture = bench.picture("a.exr");
    let alpha = picture.channel("A").expect("A");
    let mean = alpha.iter().map(|a| f64::from(*a)).sum::<f64>() / alpha.len() as f64;
    let coverage = json["coverage"].as_f64().expect("a number");
    // A grid of 32 x 21 rays.
    assert!((coverage / mean - 1.0).abs() < 0.1, "{coverage} against {mean}");
    assert_says(&said, &[&format!("coverage    about {} of the picture", mie_cloud::units::short::percent(coverage))]);
    let across = json["optical_depth"]["across"].as_f64().map(mie_cloud::units::short::number).expect("a number");
    assert_says(
        &said.split_whitespace().collect::<Vec<_>>().join(" "),
        &[&format!("about {across} across, from side to side")],
    );
}

#[test]
fn the_camera_is_told_with_its_direction() {
    let bench = Bench::new();
    let look = |rotation: DQuat| {
        let mut gltf = line_of_droplets(&[5.0, 6.0]);
        gltf.json["nodes"][2]["rotation"] = json!(rotation.to_array());
        gltf.json["nodes"][2]["translation"] = json!([1.0, 2.0, 3.0]);
        bench.write("a.gltf", &gltf.to_text());
        inspected(&bench, "a.gltf")
    };
    let quarter = std::f64::consts::FRAC_PI_2;
    let (said, json) = look(DQuat::from_rotation_y(quarter));
    assert_near(&json["camera"]["direction"], &[-1.0, 0.0, 0.0]);
    assert_near(&json["camera"]["up"], &[0.0, 1.0, 0.0]);
    assert_near(&json["camera"]["yfov_deg"], &[0.5_f64.to_degrees()]);
    assert_says(&said, &["camera      eye at (1, 2, 3) m, looking along (-1, 0, 0), 28.65 degrees high"]);
    let tilted = DQuat::from_rotation_y(0.3) * DQuat::from_rotation_x(-0.4);
    let (said, json) = look(tilted);
    assert_near(&json["camera"]["direction"], &(tilted * DVec3::NEG_Z).to_array());
    assert!(!said.contains(", up ("), "{said}");
    let (said, json) = look(DQuat::from_rotation_z(quarter));
    assert_near(&json["camera"]["up"], &[-1.0, 0.0, 0.0]);
    assert_says(&said, &["looking along (0, 0, -1), up (-1, 0, 0)"]);
}

#[test]
fn lights_air_background_and_accuracy_are_told() {
    let bench = Bench::new();
    bench.write("a.gltf", &everything().to_text());
    let air = "--set atmosphere.scattering_per_m=0.02 --set atmosphere.depth_m=7 --set background.radiance=0.25";
    let (said, json) =
        inspected(&bench, &format!("a.gltf {air} --set spectral.mode=bands:4 --set accuracy.target=0.05"));
    let sun = &json["suns"][0];
    assert_eq!((&sun["spectrum"], &sun["irradiance_w_per_m2_nm"]), (&json!("d65"), &Value::Null));
    assert_near(&sun["angular_diameter_deg"], &[0.533]);
    assert_near(&sun["color"], &[1.0, 0.9, 0.8]);
    let expected = json!({ "scattering_per_m": 0.02, "absorption_per_m": 0.0, "phase": "rayleigh", "depth_m": 7.0,
        "step_m": 0.25, "sunlight": true });
    assert_eq!(json["air"], expected);
    assert_eq!(json["background"], json!({ "radiance": [0.25, 0.25, 0.25], "image": null }));
    assert_near(&json["accuracy"]["target"], &[0.05]);
    assert_near(&json["accuracy"]["least_effect"], &[0.005]);
    let said = said.split_whitespace().collect::<Vec<_>>().join(" ");
    assert_says(&said, &["90000 lx", "0.533 degrees wide, spectrum d65, colour (1, 0.9, 0.8)", "phase rayleigh"]);

    let (said, json) = inspected(&bench, "a.gltf --set spectral.mode=rgb --set sun.irradiance=2.5 --effects=-glow");
    assert_near(&json["suns"][0]["irradiance_w_per_m2_nm"], &[2.5]);
    let said = said.split_whitespace().collect::<Vec<_>>().join(" ");
    assert_says(&said, &["irradiance 2.5 W m^-2 nm^-1, colour (1, 0.9, 0.8)"]);
    let switched = |name: &str| json["effects"][name]["switched"].as_bool();
    assert_eq!((switched("glow"), switched("multiple")), (Some(true), Some(false)));
}
