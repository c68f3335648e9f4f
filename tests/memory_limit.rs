//! Memory is counted before it is taken: whatever is asked for gets an answer, and what was foretold is what is used.

#![cfg(target_os = "linux")]

mod program;

use std::process::{Output, Stdio};

use mie_cloud::image::file::Existing;
use mie_cloud::image::{Picture, exr};
use program::{Bench, assert_says, text};
use serde_json::{Value, json};

/// A render of next to nothing but pixels.
const PIXELS: &str = "render cloud.glb -o a.exr -q --spp 1 --effects=-multiple,-shadows --threads 2";

/// Runs a command in an address space of so many MB, as under `ulimit -v`.
fn confined(bench: &Bench, megabytes: u64, line: &str) -> Output {
    let whole = bench.command(line);
    let mut command = std::process::Command::new("sh");
    command.args(["-c", "ulimit -v $0 && exec \"$@\"", &(megabytes * 1000).to_string()]).arg(whole.get_program());
    command.args(whole.get_args()).stdin(Stdio::null());
    command.current_dir(bench.path(".")).env("XDG_CACHE_HOME", bench.path("cache"));
    command.output().expect("a shell")
}

/// Expected: exit 1 with what is needed for what, what there is and what to do; nothing is written.
#[test]
fn what_does_not_fit_is_refused_before_the_work() {
    let bench = Bench::with_cloud();
    let film: &[&str] = &["not enough memory", "65536x65536 pixels", "--memory-limit allows 8.00 GB", "--resolution"];
    let spectral: &[&str] = &["8192x8192 pixels", "GB", "--spectral"];
    let cases: [(&str, &[&str]); 10] = [
        ("render cloud.glb -o a.exr --resolution 65536x65536 --memory-limit 8GB", film),
        ("render cloud.glb -o a.exr --resolution 65536x65536 --aov all --memory-limit 8GB", film),
        (
            "render cloud.glb -o a.exr --resolution 8192x8192 --set spectral.mode=bands:400 --spectral --memory-limit 64GB",
            spectral,
        ),
        (
            "render cloud.glb -o a.exr --samples 64..4032 --resolution 4000x4000 --memory-limit 4GB",
            &["4000x4000", "GB"],
        ),
        ("render cloud.glb -o a.exr --threads 2 --memory-limit 5MB", &["5.00 MB", "the program"]),
        ("render cloud.glb -o a.exr --memory-limit 1kB", &["the program", "--memory-limit allows 1.00 kB"]),
        ("inspect cloud.glb --memory-limit 1kB", &["the program", "--memory-limit allows 1.00 kB"]),
        ("generate -o b.glb --count 1e8 --memory-limit 1GB", &["100000000 particles", "GB", "--memory-limit"]),
        (
            "bench particles --counts 1e3,1e9 --memory-limit 20GB",
            &["1000000000 droplets", "--memory-limit allows 20.0 GB"],
        ),
        ("bench effects cloud.glb --resolution 9000x9000 --memory-limit 1GB", &["9000x9000 pixels", "1.00 GB"]),
    ];
    for (line, parts) in cases {
        assert_says(&bench.fails(1, line), parts);
    }
    // A flat picture is a small file.
    let meadow = bench.path("meadow.exr");
    let mut picture = Picture::new(3000, 1500);
    ["R", "G", "B"].into_iter().for_each(|name| picture.push(name, vec![0.5; 4_500_000]));
    exr::write(&meadow, &picture, Existing::Replace).expect("written");
    bench.ok("render cloud.glb -q -o part --samples 0..4 --resolution 500x500");
    for (line, parts) in [
        (
            "render cloud.glb -o a.exr --set background.image=meadow.exr --memory-limit 60MB",
            ["for the background's picture", "use a smaller picture"],
        ),
        ("diff meadow.exr meadow.exr --memory-limit 60MB", ["for the first picture", "use a smaller picture"]),
        ("merge part -o a.exr --memory-limit 60MB", ["2 times the sums of 500x500 pixels", "raise it"]),
        ("paper -o p --memory-limit 60MB", ["30 pictures of 320x180 pixels", "lower --resolution"]),
    ] {
        assert_says(&bench.fails(1, line), &parts);
    }
    for name in ["meadow.exr", "part"] {
        std::fs::remove_file(bench.path(name)).expect("removed");
    }
    let machine = bench.fails(1, "bench particles --counts 1e15");
    assert_says(&machine, &["the machine has", "--memory-limit"]);
    for (line, part) in [
        ("render cloud.glb -o a.exr --resolution 100000x100000", "65536"),
        ("render cloud.glb -o a.exr --spectral --set spectral.mode=bands:1000", "1 to 400"),
        ("generate -o b.glb --count 1e9", "GLB file"),
        ("render cloud.glb -o a.exr --memory-limit 5", "MiB"),
        ("render cloud.glb -o a.exr --memory-limit 0GB", "above zero"),
        ("render cloud.glb -o a.exr --memory-limit=-1GB", "non-negative"),
    ] {
        assert_says(&bench.fails(2, line), &[part]);
    }
    assert_eq!(bench.files().into_keys().collect::<Vec<_>>(), ["cloud.glb"], "nothing was written");
}

/// A file with holes costs no disk, and would fill any memory.
#[test]
fn files_larger_than_memory_are_not_read() {
    let bench = Bench::with_cloud();
    bench.write("huge.glb", "glTF");
    let huge = std::fs::File::options().write(true).open(bench.path("huge.glb"));
    huge.and_then(|file| file.set_len(1 << 42)).expect("a file with holes");
    assert_says(&bench.fails(1, "inspect huge.glb"), &["huge.glb", "4.40 TB", "--memory-limit"]);
    std::fs::File::create(bench.path("huge.bin")).and_then(|file| file.set_len(1 << 42)).expect("a file with holes");
    let count = 1u64 << 36;
    let scene = json!({
        "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": [0] }], "nodes": [{ "mesh": 0 }],
        "meshes": [{ "primitives": [{ "mode": 0, "attributes": { "POSITION": 0, "_RADIUS": 1 } }] }],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "count": count, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 1] },
            { "bufferView": 0, "componentType": 5126, "count": count, "type": "SCALAR" }],
        "bufferViews": [{ "buffer": 0, "byteLength": 1u64 << 42 }],
        "buffers": [{ "byteLength": 1u64 << 42, "uri": "huge.bin" }]
    });
    bench.write("huge.gltf", &scene.to_string());
    for line in ["inspect huge.gltf", "render huge.gltf -o a.exr", "inspect huge.gltf --memory-limit 3GB"] {
        assert_says(&bench.fails(1, line), &["huge.gltf", "buffers[0]", "huge.bin", "4.40 TB"]);
    }
}

/// Instances of instances, and an accessor without bytes, ask for a billion droplets with a few bytes of file.
#[test]
fn billions_of_instances_are_refused_whatever_is_allowed() {
    let bench = Bench::new();
    let positions = r#"{ "componentType": 5126, "count": 1000000000, "type": "VEC3" }"#;
    let scene: Value = serde_json::from_str(&format!(
        r#"{{ "asset": {{ "version": "2.0" }}, "extensionsUsed": ["EXT_mesh_gpu_instancing"],
            "scene": 0, "scenes": [{{ "nodes": [0] }}],
            "nodes": [{{ "mesh": 0, "extensions": {{ "EXT_mesh_gpu_instancing": {{ "attributes": {{ "TRANSLATION": 0 }} }} }} }}],
            "meshes": [{{ "primitives": [{{ "mode": 0, "attributes": {{ "POSITION": 1 }} }}] }}],
            "accessors": [{positions}, {{ "componentType": 5126, "count": 1, "type": "VEC3", "min": [0, 0, 0], "max": [0, 0, 0] }}] }}"#
    ))
    .expect("JSON");
    bench.write("instances.gltf", &scene.to_string());
    let said = bench.fails(3, "inspect instances.gltf --radius 1mm");
    assert_says(&said, &["1000000000 elements", "files of this size", "--memory-limit"]);
    let said = bench.fails(1, "inspect instances.gltf --radius 1mm --memory-limit 2GB");
    assert_says(&said, &["1000000000 elements", "40.0 GB", "--memory-limit"]);
}

/// Expected: where the system sets the limit, a picture or an answer, and never an abort.
#[test]
fn in_any_address_space_there_is_an_answer() {
    let bench = Bench::with_cloud();
    let mut codes = Vec::new();
    for megabytes in [400, 520, 640, 800, 1200] {
        let output =
            confined(&bench, megabytes, &format!("{PIXELS} --resolution 1200x1200 --set spectral.mode=mono:550nm"));
        let said = text(&output.stderr);
        match output.status.code() {
            Some(0) => assert_eq!(bench.picture("a.exr").n_pixels(), 1_440_000),
            Some(1) => assert_says(&said, &["not enough memory", "`ulimit -v` leaves", "--resolution"]),
            code => panic!("{megabytes} MB: {code:?} {said}"),
        }
        codes.push(output.status.code());
    }
    assert_eq!((codes[0], codes[4]), (Some(1), Some(0)), "{codes:?}");
    for line in [
        "render cloud.glb -o b.exr --resolution 65536x65536",
        "render cloud.glb -o b.exr --resolution 65536x65536 --memory-limit 900GB",
        "generate -o b.glb --count 1e8",
        "bench particles --counts 1e9",
        "paper --resolution 20000x20000",
    ] {
        let output = confined(&bench, 1000, line);
        assert_eq!(output.status.code(), Some(1), "{line}: {}", text(&output.stderr));
        assert_says(&text(&output.stderr), &["error: ", "GB"]);
    }
    let said = text(&confined(&bench, 200, "inspect cloud.glb").stderr);
    assert_says(&said, &["for the program", "`ulimit -v` leaves", "raise that limit"]);
    let said = text(&confined(&bench, 500, "render cloud.glb -o b.exr --spp 1 --threads 1024").stderr);
    assert_says(&said, &["error: cannot start threads; end other programs, or try --threads 1"]);
    assert_eq!(confined(&bench, 1000, "render cloud.glb -o b.exr --spp 1 -q").status.code(), Some(0));
}

/// Expected: what was foretold is enough, and not a multiple of what is used.
#[test]
fn what_is_foretold_is_what_is_used() {
    let bench = Bench::with_cloud();
    bench.ok(
        "generate -o many.glb --count 4e5 --kind droplets --size 1m --optical-depth 1 -q --distribution mono:r=5um",
    );
    let air = "--set atmosphere.scattering_per_m=0.1 --effects +glow";
    let cases = [
        (format!("{PIXELS} --resolution 900x900"), "sums of 900x900 pixels"),
        (format!("{PIXELS} --resolution 500x500 --aov all"), "sums of 500x500 pixels"),
        (format!("{PIXELS} --resolution 300x300 --set spectral.mode=bands:40 --spectral"), "sums of 300x300 pixels"),
        ("render many.glb -o a.exr -q --resolution 16x16 --spp 1 --threads 2".into(), "400000 droplets"),
        (format!("render many.glb -o a.exr -q --resolution 16x16 --spp 1 --threads 2 {air}"), "400000 droplets"),
    ];
    for (line, what) in cases {
        let said = bench.fails(1, &format!("{line} --memory-limit 30MB"));
        assert_says(&said, &[what]);
        let foretold = said.split("about ").nth(1).and_then(|rest| rest.split(" are needed").next()).expect("a number");
        let foretold = mie_cloud::units::parse_bytes(foretold).expect("bytes") as f64;
        bench.ok(&format!("{line} --stats a.json"));
        let used = bench.json("a.json")["peak_rss_bytes"].as_f64().expect("bytes");
        // Three digits are printed; the picture's blocks may compress to nothing.
        assert!(used <= 1.005 * foretold, "{line}: {used} of {foretold}");
        assert!(foretold <= 2.0 * used, "{line}: {used} of {foretold}");
    }
    let json: Value = serde_json::from_str(&bench.ok("inspect many.glb --json")).expect("JSON");
    let parts = json["memory_bytes"]["parts"].as_array().expect("parts");
    let sum: u64 = parts.iter().filter_map(|part| part["bytes"].as_u64()).sum();
    assert_eq!(json["memory_bytes"]["total"].as_u64(), Some(sum));
    assert_says(&bench.ok("inspect many.glb"), &["memory      about ", "400000 droplets"]);
}
