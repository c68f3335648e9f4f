//! The program as a process: what it writes and what it says when all is well.

mod program;

use std::path::PathBuf;

use mie_cloud::film::{Layer, Wanted};
use mie_cloud::image::Attribute;
use mie_cloud::scene::generate::CloudShape;
use mie_cloud::scene::settings::Effect;
use program::{Bench, assert_says, shipped, text};
use serde_json::Value;

#[test]
fn a_render_writes_picture_preview_and_stats() {
    let bench = Bench::with_cloud();
    bench.ok("render cloud.glb -o a.exr --preview a.png --stats a.json --spp 2");
    let picture = bench.picture("a.exr");
    assert_eq!((picture.width, picture.height), (12, 8));
    let names: Vec<&str> = picture.channels.iter().map(|channel| channel.name.as_str()).collect();
    assert_eq!(names.len(), 4, "{names:?}");
    for name in ["R", "G", "B", "A"] {
        let values = picture.channel(name).expect(name);
        assert!(values.iter().all(|value| value.is_finite() && *value >= 0.0), "{name}");
        assert!(values.iter().any(|value| *value > 0.0), "{name}");
    }
    let decoder = png::Decoder::new(std::io::Cursor::new(bench.read("a.png")));
    let reader = decoder.read_info().expect("a PNG");
    assert_eq!((reader.info().width, reader.info().height), (12, 8));
    assert_eq!(bench.json("a.json")["resolution"], serde_json::json!([12, 8]));
}

#[test]
fn the_shipped_droplet_scene_renders() {
    let bench = Bench::new();
    let scene = shipped("scenes/droplet.gltf");
    bench.ok(&format!("render {scene} -o a.exr --preview a.png --resolution 16x9 --spp 2 -q --set spectral.mode=rgb"));
    assert!(bench.picture("a.exr").channel("G").expect("G").iter().any(|value| *value > 0.0));
}

#[test]
fn stats_hold_every_key_with_sane_values() {
    let bench = Bench::with_cloud();
    bench.ok("render cloud.glb -o a.exr --stats a.json --spp 4 --seed 7 --threads 2");
    let stats = bench.json("a.json");
    let number = |pointer: &str| {
        let value = stats.pointer(pointer).unwrap_or_else(|| panic!("{pointer} is missing"));
        value.as_f64().unwrap_or_else(|| panic!("{pointer} is {value}"))
    };
    assert_eq!(stats["version"], env!("CARGO_PKG_VERSION"));
    assert!(stats["scene"].as_str().is_some_and(|scene| scene.ends_with("cloud.glb")));
    let exact = [("particles", 30.0), ("droplets", 0.0), ("parcels", 30.0), ("size_bins", 1.0), ("wavelengths", 3.0)];
    for (key, value) in exact.into_iter().chain([("spp", 4.0), ("seed", 7.0), ("threads", 2.0)]) {
        assert_eq!(number(&format!("/{key}")), value, "{key}");
    }
    let seconds = ["load", "bvh", "tables", "render", "write"].map(|stage| number(&format!("/seconds/{stage}")));
    assert!(seconds.iter().all(|second| *second >= 0.0));
    let sum: f64 = seconds.iter().sum();
    assert!(sum <= number("/seconds/total") * 1.001 && sum > 0.5 * number("/seconds/total"), "{seconds:?}");
    assert_eq!(number("/rays/camera"), 12.0 * 8.0 * 4.0);
    assert!(number("/rays/shadow") > 0.0);
    assert!(number("/rays/scatter") >= 0.0 && number("/rays/glow_queries") >= 0.0);
    assert!(number("/rays_per_second") > 0.0);
    // There is no air.
    let asked = ["direct, multiple", "air-multiple", "airlight", "glow"]
        .map(|name| number(&format!("/asked_per_sample/{name}")));
    assert_eq!(asked, [1.0, 0.0, 0.0, 0.0]);
    assert!(number("/noise") > 0.0 && number("/noise") < 10.0);
    assert!(number("/bvh_bytes") > 0.0 && number("/bvh_bytes") < 200.0 * 30.0);
    assert!(number("/geometry_bytes") >= 30.0 * 20.0 && number("/geometry_bytes") < 30.0 * 100.0);
    assert!(number("/table_bytes") > 1000.0);
    if cfg!(target_os = "linux") {
        assert!(number("/peak_rss_bytes") > 1e6 && number("/peak_rss_bytes") < 1e9);
    }
    assert!(stats["warnings"].is_array());
    for (_, name) in Effect::ALL {
        let effect = &stats["effects"][name];
        assert!(
            effect["on"].is_boolean() && effect["reason"].as_str().is_some_and(|r| !r.is_empty()),
            "{name}: {effect}"
        );
        assert!(effect["estimate"].is_number() || effect["estimate"].is_null(), "{name}: {effect}");
    }
}

#[test]
fn a_crop_is_that_part_of_the_whole_picture() {
    let bench = Bench::with_cloud();
    bench.ok("render cloud.glb -o whole.exr --spp 2 -q --aov all");
    bench.ok("render cloud.glb -o part.exr --spp 2 -q --aov all --crop 3,2,5,4");
    let (whole, part) = (bench.picture("whole.exr"), bench.picture("part.exr"));
    assert_eq!((part.width, part.height, part.frame.x, part.frame.y), (5, 4, 3, 2));
    assert_eq!((part.frame.full_width, part.frame.full_height), (12, 8));
    for channel in &part.channels {
        let full = whole.channel(&channel.name).expect("the same channels");
        for (i, value) in channel.values.iter().enumerate() {
            assert_eq!(*value, full[(i / 5 + 2) * 12 + i % 5 + 3], "{} at {i}", channel.name);
        }
    }
}

#[test]
fn bytes_depend_on_the_seed_and_not_on_threads_runs_or_cache() {
    let bench = Bench::with_cloud();
    let render = |name: &str, flags: &str| {
        bench.ok(&format!("render cloud.glb -o {name} --spp 3 -q --aov all {flags}"));
        bench.read(name)
    };
    let first = render("a.exr", "--threads 1");
    for (name, flags) in [("b.exr", "--threads 2"), ("c.exr", "--threads 7"), ("d.exr", ""), ("e.exr", "--no-cache")] {
        assert_eq!(first, render(name, flags), "{flags}");
    }
    assert_eq!(first, render("a.exr", "--seed 0"), "0 is the seed where none is given");
    assert_ne!(first, render("f.exr", "--seed 1"));
}

#[test]
fn a_damaged_cache_is_made_again_and_changes_nothing() {
    let bench = Bench::with_cloud();
    let render = |name: &str| {
        bench.ok(&format!("render cloud.glb -o {name} --spp 1 -q"));
        bench.read(name)
    };
    let cold = render("a.exr");
    let entries = || -> Vec<PathBuf> {
        let entries = std::fs::read_dir(bench.path("cache/mie-cloud")).expect("a cache");
        entries.map(|entry| entry.expect("entry").path()).collect()
    };
    assert!(entries().len() >= 3, "one entry per wavelength: {:?}", entries());
    assert_eq!(cold, render("b.exr"));
    let intact: Vec<Vec<u8>> = entries().iter().map(|path| std::fs::read(path).expect("read")).collect();
    for (i, path) in entries().iter().enumerate() {
        let mut bytes = std::fs::read(path).expect("read");
        match i % 3 {
            0 => bytes.truncate(bytes.len() / 2),
            1 => bytes.iter_mut().skip(40).for_each(|byte| *byte ^= 0x55),
            _ => bytes.clear(),
        }
        std::fs::write(path, bytes).expect("written");
    }
    assert_eq!(cold, render("c.exr"));
    let rebuilt: Vec<Vec<u8>> = entries().iter().map(|path| std::fs::read(path).expect("read")).collect();
    assert_eq!(rebuilt.len(), intact.len());
    assert!(rebuilt.iter().all(|entry| intact.contains(entry)), "entries are rebuilt");
    // A cache that cannot be written is no reason to fail.
    std::fs::remove_dir_all(bench.path("cache")).expect("removed");
    bench.write("cache", "a file where the folder should be");
    assert_eq!(cold, render("d.exr"));
}

#[test]
fn no_cache_leaves_no_cache() {
    let bench = Bench::with_cloud();
    bench.ok("render cloud.glb -o a.exr --spp 1 -q --no-cache");
    assert!(!bench.path("cache").exists());
}

#[test]
fn quiet_prints_nothing_and_data_alone_go_to_stdout() {
    let bench = Bench::with_cloud();
    let quiet = bench.run("render cloud.glb -o a.exr --spp 1 --quiet");
    assert_eq!((text(&quiet.stdout), text(&quiet.stderr)), (String::new(), String::new()));
    let quiet = bench.run("generate -o b.glb --count 3 -q");
    assert_eq!((text(&quiet.stdout), text(&quiet.stderr)), (String::new(), String::new()));
    let loud = bench.run("render cloud.glb -o a.exr --spp 2");
    assert_eq!(text(&loud.stdout), "");
    assert_says(&text(&loud.stderr), &["a.exr", "12x8", "2 spp", "noise", "30 particles", "rays/s", "peak memory"]);
    assert!(text(&bench.run("render cloud.glb -o a.exr --spp 1 -v").stderr).contains("effect direct: on"));
}

#[test]
fn inspect_understands_every_test_scene() {
    let bench = Bench::new();
    for name in ["fog_points.gltf", "fog_points.glb", "fog_instanced.gltf", "fog_instanced_required.gltf"] {
        let scene = shipped(&format!("tests/data/{name}"));
        let said = bench.ok(&format!("inspect {scene}"));
        assert_says(&said, &[name, "64 droplets", "depth", "sun", "camera", "picture", "effect"]);
        let json: Value = serde_json::from_str(&bench.ok(&format!("inspect {scene} --json"))).expect("JSON");
        assert_eq!(json["droplets"], 64, "{name}");
        assert!(json["optical_depth"]["across"].as_f64().is_some_and(|depth| depth > 0.0), "{name}");
        // One depth, said twice; and a word for each number.
        let seen = json["optical_depth"]["seen"].as_f64().map(mie_cloud::units::short::number).unwrap_or_default();
        assert_says(
            &said,
            &[&format!("optical depth about {seen} along"), &format!("about {seen} along the camera's rays, about ")],
        );
        for (name, depth) in json["optical_depth"].as_object().expect("depths").iter().filter(|(_, v)| v.is_number()) {
            assert!(json["optical_depth"]["meaning"][name].is_string(), "{name} {depth}");
        }
        assert_eq!(json["effects"].as_object().map(serde_json::Map::len), Some(Effect::ALL.len()));
        assert_eq!(
            json["hash"].as_str().map(str::len).filter(|length| *length >= 16),
            json["hash"].as_str().map(str::len)
        );
    }
    for name in ["fog.gltf", "droplet.gltf"] {
        bench.ok(&format!("inspect {} --json", shipped(&format!("scenes/{name}"))));
    }
    assert_eq!(bench.files().len(), 0, "inspecting writes nothing");
}

#[test]
fn what_is_generated_in_any_shape_kind_and_form_can_be_rendered() {
    let bench = Bench::new();
    let small = "--resolution 4x3 --spp 1 -q --set spectral.mode=mono:550nm";
    for shape in CloudShape::NAMES {
        for (kind, form, file) in [("droplets", "points", "a.glb"), ("parcels", "instances", "b.gltf")] {
            let count = if shape == "droplet" { 1 } else { 20 };
            let kind = if shape == "droplet" { "droplets" } else { kind };
            bench.ok(&format!(
                "generate -o {file} --shape {shape} --size 1m --count {count} --kind {kind} --as {form} \
                 --distribution mono:r=5um --optical-depth 0.5 -q"
            ));
            let json: Value = serde_json::from_str(&bench.ok(&format!("inspect {file} --json"))).expect("JSON");
            assert_eq!(json[kind], count, "{shape} {kind}");
            bench.ok(&format!("render {file} -o a.exr {small}"));
        }
    }
    assert!(bench.picture("a.exr").first_non_finite().is_none());
}

#[test]
fn bench_particles_gives_a_table_and_a_csv() {
    let bench = Bench::new();
    let output = bench.run("bench particles --counts 2e3,1e3 --repeat 1 --csv a.csv --json a.json --plot a.svg");
    let (table, said) = (text(&output.stdout), text(&output.stderr));
    assert_eq!(table.lines().count(), 3, "{table}");
    assert_says(&said, &["processors", "threads", "the same picture at each count"]);
    let csv = text(&bench.read("a.csv"));
    let records: Vec<Vec<&str>> = csv.lines().map(|line| line.split(',').collect()).collect();
    assert_eq!(records.len(), 3, "{csv}");
    let report = bench.json("a.json");
    assert_eq!(report["rows"][1]["count"], 2000);
    assert!(report["machine"]["threads"].as_u64().is_some_and(|n| n > 0) && report["stopped"].is_null());
    assert_eq!(report["columns"][1]["particles"], 2000.0);
    assert_says(&text(&bench.read("a.svg")), &["<svg", "render", "shadow", "1e3 to 2e3 droplets"]);
    assert!(records.iter().all(|record| record.len() == records[0].len()));
    assert!(records[1..].iter().flatten().all(|cell| cell.parse::<f64>().is_ok()), "{csv}");
    assert_eq!((records[1][0], records[2][0]), ("1000", "2000"));
    assert_says(&bench.fails(2, "bench particles --counts many"), &["--counts", "many"]);
    bench.fails(1, "bench particles --counts 1e3 --csv gone/a.csv");
    // So many need gigabytes that nobody has agreed to.
    let output = bench.run("bench particles --counts 2e7 --json b.json");
    assert_says(&text(&output.stderr), &["stopped before", "add --yes"]);
    assert_says(bench.json("b.json")["stopped"].as_str().expect("a reason"), &["GiB"]);
}

#[test]
fn diff_tells_equal_pictures_from_different_ones() {
    let bench = Bench::with_cloud();
    bench.ok("render cloud.glb -o a.exr --spp 4 -q --aov stderr");
    bench.ok("render cloud.glb -o b.exr --spp 4 -q --aov stderr --seed 5");
    let same = bench.ok("diff a.exr a.exr --max-rel 0");
    assert_says(&same, &["RMSE", "0 differ"]);
    assert!(!same.contains("worst"), "{same}");
    assert_says(&bench.ok("diff a.exr b.exr"), &["RMSE", "relative MSE", "mean ratio", "z-scores", "worst pixel"]);
    assert_eq!(bench.run("diff a.exr b.exr --max-rel 1e-6").status.code(), Some(1));
    assert_eq!(bench.run("diff a.exr b.exr --max-rel 100").status.code(), Some(0));
    bench.ok("diff a.exr b.exr --picture d.png");
    assert_eq!(&bench.read("d.png")[1..4], b"PNG");
    assert_says(&bench.fails(1, "diff a.exr b.exr --picture gone/d.png"), &["gone"]);
    assert_says(&bench.fails(1, "diff a.exr gone.exr"), &["gone.exr"]);
    assert_says(&bench.fails(1, "diff a.exr cloud.glb"), &["cloud.glb", "OpenEXR"]);
    bench.ok("render cloud.glb -o c.exr --spp 1 -q --resolution 3x3");
    assert_says(&bench.fails(1, "diff a.exr c.exr"), &["12", "3"]);
}

#[test]
fn diff_says_which_pixels_and_pictures_cannot_be_compared() {
    let bench = Bench::with_cloud();
    // The program itself writes no such pixels.
    for (name, green) in [("a.exr", 0.5), ("b.exr", f32::NAN)] {
        let pixel = |x, y| if x >= 7 && y >= 4 { (0.5_f32, green, 0.5_f32) } else { (0.25, 0.5, 0.75) };
        exr::prelude::write_rgb_file(bench.path(name), 9, 6, pixel).expect("written");
    }
    let output = bench.run("diff b.exr a.exr --max-rel 1");
    assert_eq!(output.status.code(), Some(1));
    assert_says(&text(&output.stdout), &["4 not finite", "not finite      (7, 4): ", "NaN", "never within --max-rel"]);
    assert!(!bench.ok("diff a.exr a.exr --max-rel 0").contains("never within"));

    let small = "--resolution 4x3 --spp 1 -q --set spectral.mode";
    for (out, mode) in
        [("c.exr", "bands:3"), ("d.exr", "bands:4"), ("e.exr", "mono:550nm"), ("f.exr", "bands:3 --absolute")]
    {
        bench.ok(&format!("render cloud.glb -o {out} {small}={mode}"));
    }
    let warned = |pair: &str| text(&bench.run(&format!("diff {pair}")).stderr);
    assert_eq!(warned("c.exr d.exr"), "");
    assert_says(&warned("e.exr c.exr"), &["mono:550nm, the second in bands:3"]);
    assert_says(&warned("f.exr c.exr"), &["1 cd/m^2 in the first", "31830.9", "whiteLuminance", "--absolute"]);
}

/// A file with any channels and values of two by two pixels; the program itself writes no NaN.
fn write_channels(bench: &Bench, name: &str, channels: &[(&str, [f32; 4])]) {
    use exr::prelude::{AnyChannel, AnyChannels, FlatSamples, Image, SmallVec, WritableImage};
    let channel = |(name, values): &(&str, [f32; 4])| AnyChannel::new(*name, FlatSamples::F32(values.to_vec()));
    let channels = AnyChannels::sort(channels.iter().map(channel).collect::<SmallVec<_>>());
    Image::from_channels((2, 2), channels).write().to_file(bench.path(name)).expect("written");
}

fn grey(value: f32) -> Vec<(&'static str, [f32; 4])> {
    ["R", "G", "B"].map(|name| (name, [value; 4])).into()
}

fn with_errors(value: f32, error: [f32; 4]) -> Vec<(&'static str, [f32; 4])> {
    let errors = ["stderr.R", "stderr.G", "stderr.B"].map(|name| (name, error));
    grey(value).into_iter().chain(errors).collect()
}

/// Expected: what no error explains is never said to agree.
#[test]
fn diff_tells_of_differences_that_no_error_explains() {
    let bench = Bench::new();
    write_channels(&bench, "a.exr", &with_errors(1.0, [0.0; 4]));
    write_channels(&bench, "b.exr", &with_errors(1.5, [0.0; 4]));
    let said = bench.ok("diff a.exr b.exr");
    assert_says(&said, &["z-scores        12 values differ without any recorded error\n"]);
    write_channels(&bench, "c.exr", &with_errors(1.5, [0.0, 0.1, 0.1, 0.1]));
    assert_says(
        &bench.ok("diff a.exr c.exr"),
        &["z-scores        mean -5.000", "3 values differ without any recorded error"],
    );
    assert!(!bench.ok("diff c.exr c.exr").contains("without any"));
    // One error that is no number takes the others' place as the scatter does, which is none here.
    write_channels(&bench, "d.exr", &with_errors(1.0, [f32::NAN, 0.1, 0.1, 0.1]));
    assert_says(&bench.ok("diff d.exr c.exr"), &["mean ratio      0.666667 +- 0.00e0\n"]);
}

#[test]
fn diff_gives_no_numbers_of_no_pixel() {
    let bench = Bench::new();
    write_channels(&bench, "a.exr", &grey(f32::NAN));
    write_channels(&bench, "b.exr", &grey(1.0));
    for pair in ["a.exr b.exr", "b.exr a.exr", "a.exr a.exr"] {
        let said = bench.ok(&format!("diff {pair}"));
        assert_says(&said, &["pixels          4 (", "4 not finite)"]);
        assert!(["RMSE", "MSE", "ratio", "z-scores", "worst"].iter().all(|number| !said.contains(number)), "{said}");
        bench.run(&format!("diff {pair} --max-rel 1")).status.code().filter(|code| *code == 1).expect("too much");
    }
}

#[test]
fn diff_tells_of_layers() {
    let bench = Bench::new();
    let with =
        |more: &[(&'static str, [f32; 4])]| grey(1.0).into_iter().chain(more.iter().copied()).collect::<Vec<_>>();
    write_channels(
        &bench,
        "a.exr",
        &with(&[("A", [1.0; 4]), ("direct.R", [2.0; 4]), ("glow.R", [1.0; 4]), ("glow.G", [1.0; 4])]),
    );
    write_channels(&bench, "b.exr", &with(&[("A", [1.0; 4]), ("direct.R", [1.0; 4]), ("depth.Z", [1.0; 4])]));
    let said = bench.ok("diff a.exr b.exr");
    let lines: Vec<&str> = said.lines().collect();
    assert_says(&said, &["0 differ in R, G or B", "only in the first: glow\n", "only in the second: depth\n"]);
    let at = lines.iter().position(|line| *line == "layers that differ").expect("layers");
    assert_eq!(lines[at + 1], "  direct        mean 2.000e0 against 1.000e0, RMSE 1.000e0, in R");
    assert!(lines[at + 2].starts_with("only in"), "{said}");
    assert!(!bench.ok("diff a.exr a.exr").contains("layers"));
}

#[test]
fn inspect_lists_the_droplets_that_there_are() {
    let bench = Bench::new();
    let scene = std::fs::read_to_string(shipped("scenes/fog.gltf")).expect("read");
    let marked = "\"mesh\": 0, \"extras\": {\"mie_cloud\": {\"distribution\": \"mono:r=7um\"}}";
    bench.write("a.gltf", &scene.replace("\"mesh\": 0", marked));
    let said = bench.ok("inspect a.gltf");
    let droplets: Vec<&str> = said.lines().filter(|line| line.starts_with("droplets")).collect();
    assert!(matches!(droplets[..], [one] if one.contains("mono:r=7um")), "{said}");
}

#[test]
fn layers_and_effects_may_be_written_alike() {
    let bench = Bench::with_cloud();
    for name in ["air-multiple", "air_multiple"] {
        bench.ok(&format!(
            "render cloud.glb -o a.exr --spp 1 -q --aov {name} --effects -{name} --set effects.{name}=auto"
        ));
        assert!(bench.picture("a.exr").channel("air_multiple.R").is_some());
    }
}

#[test]
fn effects_that_can_do_nothing_are_told_of() {
    let bench = Bench::with_cloud();
    let tiny = "--resolution 2x2 --spp 1";
    let said = |line: &str| text(&bench.run(line).stderr);
    let glow = said(&format!("render cloud.glb -o a.exr {tiny} --effects +glow,+multiple"));
    assert_says(&glow, &["warning: effect glow does nothing", "atmosphere.scattering_per_m is 0"]);
    assert!(!glow.contains("effect multiple does"), "{glow}");
    let lit = said(&format!("render cloud.glb -o a.exr {tiny} --effects +glow --set atmosphere.scattering_per_m=0.02"));
    assert!(!lit.contains("does nothing"), "{lit}");
    assert!(!said(&format!("render cloud.glb -o a.exr {tiny}")).contains("does nothing"));
    let inspected = said("inspect cloud.glb --set effects.refraction=on");
    assert_says(&inspected, &["warning: effect refraction does nothing", "no droplet is large enough to be seen"]);
}

#[test]
fn absolute_pictures_are_the_relative_ones_times_white() {
    let bench = Bench::with_cloud();
    let flags = "--spp 1 -q --set spectral.mode=bands:4";
    bench.ok(&format!("render cloud.glb -o a.exr {flags}"));
    bench.ok(&format!("render cloud.glb -o b.exr {flags} --absolute"));
    let (relative, absolute) = (bench.picture("a.exr"), bench.picture("b.exr"));
    let white = relative.white_luminance_cd_m2.expect("recorded");
    assert!((white / (1e5 / std::f32::consts::PI) - 1.0).abs() < 1e-5, "100 000 lx over pi, not {white}");
    assert_eq!(absolute.white_luminance_cd_m2, Some(1.0));
    assert!(relative.chromaticities.is_some());
    let pairs = relative.channel("G").expect("G").iter().zip(absolute.channel("G").expect("G"));
    // Both are rounded to 24 bits.
    assert!(pairs.clone().all(|(r, a)| (r * white - a).abs() <= 1e-6 * a), "{:?}", pairs.collect::<Vec<_>>());
    assert_eq!(relative.channel("A"), absolute.channel("A"));
    for mode in ["mono:550nm", "rgb"] {
        let said = bench.fails(2, &format!("render cloud.glb -o c.exr --absolute --set spectral.mode={mode}"));
        assert_says(&said, &["--absolute", mode.split(':').next().unwrap_or(mode), "bands"]);
    }
}

#[test]
fn spectral_channels_hold_every_wavelength() {
    let bench = Bench::with_cloud();
    bench.ok("render cloud.glb -o a.exr --spp 2 -q --set spectral.mode=bands:5 --spectral");
    let picture = bench.picture("a.exr");
    let spectral: Vec<_> = picture.channels.iter().filter(|channel| channel.name.starts_with("S0.")).collect();
    assert_eq!(spectral.len(), 5);
    for channel in spectral {
        assert!(channel.name.ends_with("nm"), "{}", channel.name);
        assert!(channel.values.iter().any(|value| *value > 0.0), "{}", channel.name);
    }
    // Two channels of one name cannot be: said before the render, not after it.
    let said = bench
        .fails(2, "render cloud.glb -o b.exr -q --set spectral.mode=rgb:550nm,550nm,450nm --spectral --spp 1000000");
    assert_says(&said, &["--spectral", "S0.550,000000nm", "spectral.mode"]);
    assert!(picture.attribute("spectralLayoutVersion").is_some(), "{:?}", picture.attributes);
}

/// What the header says that they are: radiance over the sun's irradiance, whatever that is.
#[test]
fn spectral_channels_are_relative_to_the_irradiance_in_every_mode() {
    let bench = Bench::with_cloud();
    for mode in ["mono:550nm", "rgb", "bands:3"] {
        let render = |out: &str, irradiance: &str| {
            bench.ok(&format!(
                "render cloud.glb -o {out} --spp 2 -q --spectral --set spectral.mode={mode} --set sun.irradiance={irradiance}"
            ));
            bench.picture(out)
        };
        let (one, more) = (render("a.exr", "1"), render("b.exr", "1.75"));
        for channel in one.channels.iter().filter(|channel| channel.name != "A") {
            let other = more.channel(&channel.name).expect(&channel.name);
            let is_spectral = channel.name.starts_with("S0.");
            let factor = if is_spectral || mode == "bands:3" { 1.0 } else { 1.75 };
            // Values of 24 bits.
            let agree = |(a, b): (&f32, &f32)| (a * factor - b).abs() <= 1e-6 * b.abs();
            assert!(channel.values.iter().zip(other).all(agree), "{mode}: {}", channel.name);
            assert!(channel.values.iter().any(|value| *value > 0.0), "{mode}: {}", channel.name);
        }
        assert_eq!(more.attribute("emissiveUnits"), Some(&Attribute::Text("sr^-1".into())));
    }
}

#[test]
fn the_layers_add_up_to_the_picture() {
    let bench = Bench::with_cloud();
    bench.ok(
        "render cloud.glb -o a.exr --spp 2 -q --aov all --set atmosphere.scattering_per_m=0.02 --set atmosphere.step_m=5 \
         --set background.radiance=0.25",
    );
    let picture = bench.picture("a.exr");
    for c in ["R", "G", "B"] {
        for (i, beauty) in picture.channel(c).expect(c).iter().enumerate() {
            let layers = Layer::ALL.iter().map(|(_, name)| picture.channel(&format!("{name}.{c}")).expect(name)[i]);
            let sum: f32 = layers.sum();
            assert!((sum - beauty).abs() <= 1e-6 * beauty, "{c} {i}: {sum} against {beauty}");
        }
    }
    for (wanted, name) in Wanted::all() {
        let suffix = match wanted {
            Wanted::Samples => "N",
            Wanted::Depth => "Z",
            _ => "G",
        };
        assert!(picture.channel(&format!("{name}.{suffix}")).is_some(), "{name}");
    }
    assert!(picture.channel("samples.N").expect("N").iter().all(|samples| *samples == 2.0));
    assert!(picture.channel("airlight.G").expect("airlight").iter().all(|value| *value > 0.0));
    assert!(picture.channel("background.G").expect("background").iter().all(|value| *value > 0.0));
    // Air that scatters the background into view may brighten it; weakening is all that it does otherwise.
    bench.ok(
        "render cloud.glb -o b.exr --spp 2 -q --aov all --set atmosphere.scattering_per_m=0.02 --set atmosphere.step_m=5 \
         --set background.radiance=0.25 --effects -air-multiple",
    );
    let weakened = bench.picture("b.exr");
    assert!(weakened.channel("background.G").expect("background").iter().all(|value| *value > 0.0 && *value < 0.25));
}

#[test]
fn pictures_record_what_made_them() {
    let bench = Bench::with_cloud();
    bench.ok("render cloud.glb -o a.exr --spp 3 --seed 11 -q");
    let picture = bench.picture("a.exr");
    let recorded = |name: &str| format!("{:?}", picture.attribute(name).unwrap_or_else(|| panic!("{name} is missing")));
    assert!(recorded("mieCloud:version").contains(env!("CARGO_PKG_VERSION")));
    assert!(recorded("mieCloud:seed").contains("11"));
    assert!(recorded("mieCloud:samples").contains('3'));
    assert!(recorded("mieCloud:scene").contains("cloud.glb"));
    assert!(recorded("mieCloud:settings").contains("atmosphere"));
    assert!(recorded("mieCloud:sceneHash").len() > 16);
    assert!(recorded("mieCloud:order").contains("unlimited"));
    bench.ok("render cloud.glb -o b.exr --spp 3 --seed 11 -q --effects -multiple,+shadows --order 2");
    let picture = bench.picture("b.exr");
    let Some(Attribute::Text(effects)) = picture.attribute("mieCloud:effects") else { panic!("effects are recorded") };
    let effects: Vec<&str> = effects.split(',').collect();
    assert!(
        effects.contains(&"direct") && effects.contains(&"shadows") && !effects.contains(&"multiple"),
        "{effects:?}"
    );
    assert_eq!(picture.attribute("mieCloud:order"), Some(&Attribute::Text("2".into())));
}

/// Of 12x8 pixels hundreds of samples are taken in the time that these tables take.
#[test]
fn time_limits_count_tables_which_are_told_of() {
    let bench = Bench::with_cloud();
    let line = "render cloud.glb -o a.exr --no-cache --threads 1 --time-limit 0.1 --stats a.json \
                --set spectral.mode=bands:6 --set droplets.distribution=gamma:reff=150um,veff=0.1";
    let output = bench.run(line);
    let (said, stats) = (text(&output.stderr), bench.json("a.json"));
    assert_eq!(output.status.code(), Some(0), "{said}");
    assert_eq!(stats["spp"], 1);
    assert_says(&said, &["--time-limit: it is over before the first sample"]);
    // The first line comes after a second; a very fast machine has nothing to tell.
    let is_quick = stats["seconds"]["tables"].as_f64().is_some_and(|tables_s| tables_s < 1.5);
    assert!(is_quick || said.lines().any(|line| line.starts_with("tables: ") && line.ends_with(" of 7")), "{said}");
    // Nobody expects the most samples that there may be.
    let said = text(&bench.run("render cloud.glb -o a.exr --time-limit 2.5").stderr);
    let lines: Vec<&str> = said.lines().filter(|line| line.starts_with("render: ")).collect();
    assert!(!lines.is_empty() && lines.iter().all(|line| line.contains(" spp") && !line.contains('/')), "{said}");
}

#[test]
fn noise_and_time_limits_end_a_render() {
    let bench = Bench::with_cloud();
    bench.ok("render cloud.glb -o a.exr --noise 0.2 --stats a.json -q");
    let stats = bench.json("a.json");
    assert!(stats["noise"].as_f64().is_some_and(|noise| noise <= 0.2), "{}", stats["noise"]);
    bench.ok("render cloud.glb -o a.exr --time-limit 0.01 --stats a.json -q");
    assert!(bench.json("a.json")["spp"].as_u64().is_some_and(|spp| spp >= 1));
}

#[test]
fn unknown_commands_are_usage_errors() {
    let bench = Bench::new();
    assert_says(&bench.ok("--version"), &["mie-cloud", env!("CARGO_PKG_VERSION")]);
    assert_says(&bench.ok("help render"), &["Usage: mie-cloud render"]);
    assert_says(&bench.fails(2, "frobnicate"), &["frobnicate"]);
    assert_says(&bench.fails(2, "bench frobnicate"), &["frobnicate"]);
    let bare = bench.run("");
    assert_eq!(bare.status.code(), Some(2));
    assert_says(&text(&bare.stderr), &["Usage: mie-cloud", "render"]);
}
