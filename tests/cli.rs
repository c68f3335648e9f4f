//! The program as a process: what it writes, what it says, and how it ends.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use mie_cloud::film::{Layer, Wanted};
use mie_cloud::image::{Picture, exr};
use mie_cloud::scene::generate::CloudShape;
use mie_cloud::scene::settings::Effect;
use serde_json::Value;
use tempfile::TempDir;

/// A folder of its own for one test, with a table cache in it.
struct Bench {
    folder: TempDir,
}

impl Bench {
    fn new() -> Self {
        Self { folder: tempfile::tempdir().expect("a temporary folder") }
    }

    /// With a cloud of 30 parcels, `cloud.glb`, that renders in an instant.
    fn with_cloud() -> Self {
        let bench = Self::new();
        bench.ok("generate -o cloud.glb --count 30 --size 2m --optical-depth 1 --distribution mono:r=5um -q \
             --set spectral.mode=rgb --set image.resolution=12x8");
        bench
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn write(&self, name: &str, text: &str) -> PathBuf {
        std::fs::write(self.path(name), text).expect("written");
        self.path(name)
    }

    fn read(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    fn json(&self, name: &str) -> Value {
        serde_json::from_slice(&self.read(name)).expect(name)
    }

    fn picture(&self, name: &str) -> Picture {
        exr::read(&self.path(name), exr::Limits::default()).expect(name)
    }

    /// The program in this folder; words are divided by spaces.
    fn command(&self, line: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_mie-cloud"));
        command.args(line.split_whitespace()).current_dir(self.folder.path()).stdin(Stdio::null());
        command.env("XDG_CACHE_HOME", self.path("cache"));
        command
    }

    fn run(&self, line: &str) -> Output {
        self.command(line).output().expect("the program starts")
    }

    /// Runs a command that must succeed; returns what it printed.
    fn ok(&self, line: &str) -> String {
        let output = self.run(line);
        assert_eq!(output.status.code(), Some(0), "{line}\n{}", text(&output.stderr));
        text(&output.stdout)
    }

    /// Runs a command that must fail with the given code; returns what it said. It prints no data and no panic.
    fn fails(&self, code: i32, line: &str) -> String {
        let output = self.run(line);
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(code), "{line}\n{said}");
        assert!(said.starts_with("error: ") || said.contains("\nerror: "), "{line}\n{said}");
        assert!(!said.contains("panicked"), "{line}\n{said}");
        assert_eq!(text(&output.stdout), "", "{line}");
        said
    }

    /// Every file here but the cache, with its bytes.
    fn files(&self) -> BTreeMap<String, Vec<u8>> {
        let entries = std::fs::read_dir(self.folder.path()).expect("listed").map(|entry| entry.expect("entry"));
        let files = entries.filter(|entry| entry.path().is_file());
        files
            .map(|entry| entry.file_name().to_string_lossy().into_owned())
            .map(|n| (n.clone(), self.read(&n)))
            .collect()
    }
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).expect("UTF-8")
}

fn shipped(path: &str) -> String {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path).display().to_string()
}

fn assert_says(said: &str, parts: &[&str]) {
    for part in parts {
        assert!(said.contains(part), "`{part}` is not in: {said}");
    }
}

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
fn wrong_flags_end_with_2_and_name_flag_and_remedy() {
    let bench = Bench::with_cloud();
    let cases: [(&str, &[&str]); 24] = [
        ("--resoluton 8x8", &["--resoluton", "--resolution"]),
        ("--resolution 8", &["--resolution", "640x360"]),
        ("--resolution 0x8", &["--resolution", "1 to 65536"]),
        ("--spp 0", &["--spp"]),
        ("--spp 1 --noise 0.1", &["--spp", "--noise"]),
        ("--noise 2", &["--noise", "between 0 and 1"]),
        ("--accuracy fin", &["--accuracy", "fine"]),
        ("--crop 0,0,0,4", &["--crop", "at least 1"]),
        ("--crop 0,0,13,4", &["--crop", "12x8"]),
        ("--effects +shadow", &["--effects", "did you mean `shadows`"]),
        ("--effects shadows", &["--effects", "+shadows"]),
        ("--effects +rainbow", &["--effects", "rainbow", "shadows"]),
        ("--aov dirct", &["--aov", "did you mean `direct`"]),
        ("--aov everything", &["--aov", "everything", "depth"]),
        ("--set atmosphere.step=1", &["--set", "did you mean `atmosphere.step_m`"]),
        ("--set atmosphere.step_m=-1", &["--set", "atmosphere.step_m", "above 0"]),
        ("--set nonsense", &["--set", "KEY=VALUE"]),
        ("--set droplets.distribution=gamma:reff=6", &["--set", "reff", "unit"]),
        ("--camera Side", &["--camera", "Side", "Camera"]),
        ("--radius 5", &["--radius", "unit"]),
        ("--threads 0", &["--threads"]),
        ("--absolute", &["--absolute", "bands"]),
        ("--quiet --verbose", &["--quiet", "--verbose"]),
        ("--seed -1", &["-1"]),
    ];
    for (flags, parts) in cases {
        let said = bench.fails(2, &format!("render cloud.glb -o a.exr {flags}"));
        assert_says(&said, parts);
        assert!(!bench.path("a.exr").exists(), "{flags}");
    }
    assert_says(&bench.fails(2, "render cloud.glb"), &["--output"]);
    assert_says(&bench.fails(2, "rendr cloud.glb"), &["rendr", "render"]);
    assert_says(&bench.fails(2, "inspect"), &["SCENE"]);
}

#[test]
fn flags_are_checked_before_the_scene_is_read() {
    let bench = Bench::new();
    for flags in ["--effects +shadow", "--aov dirct"] {
        bench.fails(2, &format!("render missing.gltf -o a.exr {flags}"));
    }
}

#[test]
fn effects_that_are_not_there_yet_blame_whoever_asked() {
    let bench = Bench::with_cloud();
    let said = bench.fails(2, "render cloud.glb -o a.exr --effects +glow");
    assert_says(&said, &["--effects +glow", "not in this version", "--effects -glow"]);
    assert_says(
        &bench.fails(2, "render cloud.glb -o a.exr --set effects.glow=on"),
        &["--set effects.glow", "not in this"],
    );
    assert_says(&bench.fails(2, "inspect cloud.glb --effects +glow"), &["--effects +glow"]);
    bench.ok("generate -o glow.glb --count 2 --set effects.glow=on -q");
    assert_says(&bench.fails(3, "render glow.glb -o a.exr"), &["glow.glb", "effects.glow", "--effects -glow"]);
    assert_says(&bench.fails(3, "render glow.glb -o a.exr --effects -shadows"), &["glow.glb", "effects.glow"]);
    bench.ok("render glow.glb -o a.exr --effects -glow --resolution 2x2 --spp 1 -q --set spectral.mode=mono:550nm");
}

#[test]
fn missing_broken_and_empty_scenes_end_with_3_and_say_what_to_do() {
    let bench = Bench::new();
    assert_says(&bench.fails(3, "render missing.gltf -o a.exr"), &["missing.gltf", "check the path"]);
    bench.write("broken.gltf", "{ \"asset\": ");
    assert_says(&bench.fails(3, "render broken.gltf -o a.exr"), &["broken.gltf", "glTF", "export"]);
    bench.write("text.gltf", "just text");
    bench.fails(3, "inspect text.gltf");
    bench.write("empty.gltf", r#"{ "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": [] }] }"#);
    assert_says(&bench.fails(3, "render empty.gltf -o a.exr"), &["empty.gltf", "--droplets", "--radius", "fog"]);
    bench.fails(3, "inspect .");
    assert_eq!(bench.files().len(), 3, "nothing was written");
}

#[test]
fn outputs_that_cannot_be_are_refused_before_any_work() {
    let bench = Bench::with_cloud();
    std::fs::create_dir(bench.path("folder")).expect("created");
    // The scene does not exist, so that a complaint about the output shows that it was looked at first.
    let cases = [("-o gone/a.exr", "gone"), ("-o folder", "folder"), ("-o a.exr --preview gone/a.png", "--preview")];
    for (flags, part) in cases.into_iter().chain([("-o a.exr --stats gone/a.json", "--stats")]) {
        assert_says(&bench.fails(1, &format!("render missing.gltf {flags}")), &[part]);
    }
    for flags in ["-o a.png", "-o a.JPG"] {
        assert_says(&bench.fails(2, &format!("render missing.gltf {flags}")), &["OpenEXR", "a.exr", "--preview"]);
    }
    let said = bench.fails(2, "render cloud.glb -o a.exr --preview ./a.exr");
    assert_says(&said, &["--output", "--preview", "a file of its own"]);
    assert_says(&bench.fails(2, "render cloud.glb -o cloud.glb"), &["the scene itself"]);
    assert_eq!(bench.files().keys().collect::<Vec<_>>(), ["cloud.glb"]);
}

#[cfg(unix)]
#[test]
fn folders_that_cannot_be_written_are_named() {
    use std::os::unix::fs::PermissionsExt;
    let bench = Bench::with_cloud();
    std::fs::create_dir(bench.path("locked")).expect("created");
    std::fs::set_permissions(bench.path("locked"), PermissionsExt::from_mode(0o555)).expect("locked");
    // The administrator may write everywhere.
    if std::fs::write(bench.path("locked/try"), "").is_err() {
        assert_says(&bench.fails(1, "render missing.gltf -o locked/a.exr"), &["locked", "choose"]);
    }
    assert_says(&bench.fails(1, "render missing.gltf -o /proc/a.exr"), &["/proc"]);
}

#[test]
fn no_clobber_keeps_every_file() {
    let bench = Bench::with_cloud();
    let outputs = ["a.exr", "a.png", "a.json"];
    for name in outputs {
        let _ = outputs.map(|name| std::fs::remove_file(bench.path(name)));
        bench.write(name, "precious");
        let said = bench.fails(1, "render cloud.glb -o a.exr --preview a.png --stats a.json --spp 1 --no-clobber");
        assert_says(&said, &[name, "exists"]);
        assert_eq!(bench.read(name), b"precious");
        assert_eq!(bench.files().len(), 2, "nothing else was written");
    }
    bench.fails(1, "generate -o cloud.glb --count 2 --no-clobber");
    bench.ok("render cloud.glb -o b.exr --spp 1 --no-clobber -q");
}

#[test]
fn the_old_picture_survives_every_failure() {
    let bench = Bench::with_cloud();
    bench.write("a.exr", "old");
    bench.write("bad.gltf", "{}");
    for (code, flags) in [(3, "bad.gltf"), (2, "cloud.glb --aov x"), (2, "cloud.glb --set spectral.mode=x")] {
        bench.fails(code, &format!("render {flags} -o a.exr"));
        assert_eq!(bench.read("a.exr"), b"old", "{flags}");
    }
    bench.ok("render cloud.glb -o a.exr --spp 1 -q");
    assert!(bench.picture("a.exr").n_pixels() == 96);
    let left: Vec<String> = bench.files().into_keys().filter(|name| name.contains("tmp")).collect();
    assert!(left.is_empty(), "{left:?}");
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

/// What is written to a pipe that nobody reads is no error.
#[cfg(unix)]
#[test]
fn a_closed_pipe_is_not_an_error() {
    let bench = Bench::with_cloud();
    for line in ["inspect cloud.glb", "inspect cloud.glb --json", "diff cloud.exr cloud.exr", "--help", "render --help"]
    {
        bench.ok("render cloud.glb -o cloud.exr --spp 1 -q");
        let (reader, writer) = std::io::pipe().expect("a pipe");
        drop(reader);
        let output = bench.command(line).stdout(writer).stderr(Stdio::piped()).output().expect("the program starts");
        assert_eq!(output.status.code(), Some(0), "{line}: {}", text(&output.stderr));
        assert!(!text(&output.stderr).contains("error"), "{line}: {}", text(&output.stderr));
    }
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
fn clouds_that_cannot_be_generated_are_usage_errors() {
    let bench = Bench::new();
    let cases: [(&str, &[&str]); 10] = [
        ("--shape bal", &["--shape", "ball"]),
        ("--size 2", &["--size", "unit"]),
        ("--size 1m,2m", &["size"]),
        ("--count 0", &["--count"]),
        ("--count 1.5", &["--count", "whole number"]),
        ("--distribution gama:reff=5um", &["--distribution"]),
        ("--liquid-water 0.3", &["--liquid-water", "g/m3"]),
        ("--liquid-water 0.3g/m3 --optical-depth 1", &["--liquid-water", "--optical-depth"]),
        ("--as spheres", &["--as", "points", "instances"]),
        ("--set atmosphere.step_m.x=2", &["--set", "did you mean `atmosphere.step_m`"]),
    ];
    for (flags, parts) in cases {
        assert_says(&bench.fails(2, &format!("generate -o a.glb {flags}")), parts);
    }
    assert_says(&bench.fails(2, "generate -o a.obj"), &["a.obj", ".glb"]);
    assert_says(&bench.fails(1, "generate -o gone/a.glb"), &["gone"]);
    assert_eq!(bench.files().len(), 0);
}

/// A setting that no scene understands would make a file that cannot be read back.
#[test]
fn generate_checks_the_settings_that_it_writes() {
    let bench = Bench::new();
    let said = bench.fails(2, "generate -o a.glb --count 2 --set atmosphere.step=1");
    assert_says(&said, &["--set", "atmosphere.step", "atmosphere.step_m"]);
    assert!(!bench.path("a.glb").exists());
}

#[test]
fn bench_particles_gives_a_table_and_a_csv() {
    let bench = Bench::new();
    let table = bench.ok("bench particles --counts 1e3,2e3 --csv a.csv");
    let rows: Vec<Vec<&str>> = table.lines().map(|line| line.split_whitespace().collect()).collect();
    assert_eq!(rows.len(), 3, "{table}");
    let csv = text(&bench.read("a.csv"));
    let records: Vec<Vec<&str>> = csv.lines().map(|line| line.split(',').collect()).collect();
    assert_eq!(records, rows, "the same numbers");
    assert!(records.iter().all(|record| record.len() == records[0].len()));
    assert!(records[1..].iter().flatten().all(|cell| cell.parse::<f64>().is_ok()), "{csv}");
    assert_eq!((records[1][0], records[2][0]), ("1000", "2000"));
    assert_says(&bench.fails(2, "bench particles --counts many"), &["--counts", "many"]);
    bench.fails(1, "bench particles --counts 1e3 --csv gone/a.csv");
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
    assert_says(&bench.fails(1, "diff a.exr gone.exr"), &["gone.exr"]);
    assert_says(&bench.fails(1, "diff a.exr cloud.glb"), &["cloud.glb", "OpenEXR"]);
    bench.ok("render cloud.glb -o c.exr --spp 1 -q --resolution 3x3");
    assert_says(&bench.fails(1, "diff a.exr c.exr"), &["12", "3"]);
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
    assert!(picture.attribute("spectralLayoutVersion").is_some(), "{:?}", picture.attributes);
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
    assert!(picture.channel("background.G").expect("background").iter().all(|value| *value > 0.0 && *value < 0.25));
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
fn every_command_has_help_and_unknown_ones_are_usage_errors() {
    let bench = Bench::new();
    for command in ["", "render", "generate", "mie", "inspect", "bench", "bench particles", "diff"] {
        for flag in ["--help", "-h"] {
            assert_says(&bench.ok(&format!("{command} {flag}")), &["Usage: mie-cloud", command]);
        }
    }
    assert_says(&bench.ok("--version"), &["mie-cloud", env!("CARGO_PKG_VERSION")]);
    assert_says(&bench.ok("help render"), &["Usage: mie-cloud render"]);
    assert_says(&bench.fails(2, "frobnicate"), &["frobnicate"]);
    assert_says(&bench.fails(2, "bench frobnicate"), &["frobnicate"]);
    let bare = bench.run("");
    assert_eq!(bare.status.code(), Some(2));
    assert_says(&text(&bare.stderr), &["Usage: mie-cloud", "render"]);
}
