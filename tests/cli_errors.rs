//! The program as a process: how it ends, and what it says, when something is wrong.

mod program;

use std::process::Stdio;

use program::{Bench, assert_says, text};

#[test]
fn wrong_flags_end_with_2_and_name_flag_and_remedy() {
    let bench = Bench::with_cloud();
    let cases: [(&str, &[&str]); 34] = [
        ("--resoluton 8x8", &["--resoluton", "--resolution"]),
        ("--resolution 8", &["--resolution", "640x360"]),
        ("--resolution 0x8", &["--resolution", "1 to 65536"]),
        ("--spp 0", &["--spp"]),
        ("--spp 1 --noise 0.1", &["--spp", "--noise"]),
        (
            "--spp 4 --accuracy fine",
            &["--spp", "--accuracy", "when the picture is done", "--set accuracy.target=LEVEL"],
        ),
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
        ("--res 8x8", &["'--res'", "'--resolution'", "'--resume'"]),
        ("--set sun.direction=1,0,0", &["`sun.direction`", "suns are directional lights of the glTF scene"]),
        ("--set sun.intensity=1e5", &["`sun.intensity`", "lux", "known are sun.spectrum"]),
        ("--set camera.position=0,0,1", &["`camera.position`", "nodes of the glTF scene", "--camera"]),
        ("--set droplets.radius=10um", &["`droplets.radius`", "droplets.distribution=mono:r=10um"]),
        ("--set fog.extinction=1", &["`fog.extinction`", "extinction_per_m", "extras.mie_cloud"]),
        ("--set extinction=1", &["`extinction`", "extinction_per_m", "extras.mie_cloud"]),
        ("--set sun.spektrum=d65", &["did you mean `sun.spectrum`"]),
        ("--set atmosphere.step_m=-1", &["--set", "atmosphere.step_m", "above 0"]),
        ("--set nonsense", &["--set", "KEY=VALUE"]),
        ("--set droplets.distribution=gamma:reff=6", &["--set", "reff", "unit"]),
        ("--camera Side", &["--camera", "Side", "Camera"]),
        ("--radius 5", &["--radius", "unit"]),
        ("--threads 0", &["--threads"]),
        ("--threads 1025", &["--threads", "1..=1024"]),
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
    for flag in ["-o", "-o a.exr --preview", "-o a.exr --stats", "-o a.exr --checkpoint"] {
        let long = format!("render missing.gltf {flag} {}", "x".repeat(300));
        assert_says(&bench.fails(1, &long), &["xxx: the disk takes no name like this", "shorter"]);
    }
    let said = bench.fails(2, "render cloud.glb -o picture --preview ./picture");
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

/// Expected: a named pipe that nobody reads to its end is a file that could not be written, and the others are.
#[cfg(target_os = "linux")]
#[test]
fn a_picture_that_nobody_takes_is_an_error() {
    let bench = Bench::with_cloud();
    let made = std::process::Command::new("mkfifo").arg(bench.path("pipe")).status().expect("mkfifo");
    assert!(made.success());
    let line = "render cloud.glb -q -o pipe --resolution 400x300 --spp 1 --stats a.json";
    let render = bench.command(line).stderr(Stdio::piped()).spawn().expect("the program starts");
    // Opened, and left before anything comes.
    drop(std::fs::File::open(bench.path("pipe")).expect("a pipe"));
    let output = render.wait_with_output().expect("it ends");
    assert_eq!(output.status.code(), Some(1), "{}", text(&output.stderr));
    assert_says(&text(&output.stderr), &["cannot write pipe", "Broken pipe"]);
    assert_eq!(bench.json("a.json")["spp"], 1);
}

/// Expected: nobody reads the table; the files are written all the same.
#[test]
fn bench_particles_writes_its_files_where_nobody_reads_the_table() {
    let bench = Bench::new();
    let (reader, writer) = std::io::pipe().expect("a pipe");
    drop(reader);
    let mut command = bench.command("bench particles --counts 10,20 --repeat 1 --csv a.csv --json a.json");
    let output = command.stdout(writer).stderr(Stdio::piped()).output().expect("the program starts");
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    assert_eq!(text(&bench.read("a.csv")).lines().count(), 3);
    assert_eq!(bench.json("a.json")["rows"].as_array().map(Vec::len), Some(2));
}

/// Expected: whoever reads the messages may go; the work goes on.
#[cfg(unix)]
#[test]
fn a_render_survives_the_reader_of_its_messages() {
    let bench = Bench::with_cloud();
    let (reader, writer) = std::io::pipe().expect("a pipe");
    drop(reader);
    let line = "render cloud.glb -o a.exr --spp 1 -v";
    let status = bench.command(line).stdout(Stdio::null()).stderr(writer).status().expect("the program starts");
    assert_eq!(status.code(), Some(0));
    assert_eq!(bench.picture("a.exr").n_pixels(), 96);
}

/// Expected: a disk without room is named, and the files that were there are as they were.
#[cfg(target_os = "linux")]
#[test]
fn full_disks_end_with_1_and_name_the_file() {
    let bench = Bench::with_cloud();
    bench.ok("render cloud.glb -o part.exr --samples 0..4 -q");
    let full = ["/dev/full", "No space left"];
    for flags in ["-o /dev/full --spp 1", "-o a.exr --preview /dev/full --spp 1", "-o a.exr --stats /dev/full --spp 1"]
    {
        assert_says(&bench.fails(1, &format!("render cloud.glb -q {flags}")), &full);
    }
    // What else there is written.
    bench.fails(1, "render cloud.glb -q -o /dev/full --preview b.png --stats b.json --spp 1");
    assert!(bench.path("b.png").exists() && bench.json("b.json")["spp"] == 1);
    bench.fails(1, "render cloud.glb -q -o b.exr --preview /dev/full --stats c.json --spp 1");
    assert!(bench.picture("b.exr").n_pixels() == 96 && bench.json("c.json")["spp"] == 1);
    std::fs::remove_file(bench.path("b.json")).expect("removed");
    bench.fails(1, "merge part.exr -o /dev/full --preview c.png");
    assert!(bench.path("c.png").exists());
    assert_says(&bench.fails(1, "render cloud.glb -q -o /dev/full --samples 0..4"), &full);
    assert_says(&bench.fails(1, "merge part.exr -o /dev/full"), &full);
    assert_says(&bench.fails(1, "mie --radius 1um -o /dev/full"), &full);
    // Without a checkpoint there is a picture still.
    std::fs::remove_file(bench.path("a.exr")).expect("removed");
    let said = bench.fails(1, "render cloud.glb -o a.exr --spp 1 --checkpoint /dev/full");
    assert_says(&said, &["--checkpoint", "/dev/full", "No space left"]);
    assert_eq!(bench.picture("a.exr").n_pixels(), 96);
    for line in ["mie --radius 1um", "inspect cloud.glb", "diff a.exr a.exr", "--help", "--version"] {
        let stdout = std::fs::OpenOptions::new().write(true).open("/dev/full").expect("/dev/full");
        let output = bench.command(line).stdout(stdout).stderr(Stdio::piped()).output().expect("the program starts");
        assert_eq!(output.status.code(), Some(1), "{line}");
        assert_says(&text(&output.stderr), &["error: cannot write to stdout: No space left"]);
    }
}

/// Expected: a target that may not be written is named before any work, and kept.
#[test]
fn targets_that_may_not_be_written_are_kept() {
    let bench = Bench::with_cloud();
    let set_read_only = |name: &str| {
        let mut permissions = std::fs::metadata(bench.write(name, "precious")).expect("there").permissions();
        permissions.set_readonly(true);
        std::fs::set_permissions(bench.path(name), permissions).expect("set");
    };
    for (name, flags) in
        [("a.exr", "-o a.exr"), ("a.png", "-o b.exr --preview a.png"), ("a.json", "-o b.exr --stats a.json")]
    {
        set_read_only(name);
        assert_says(&bench.fails(1, &format!("render missing.gltf {flags}")), &[name, "read-only"]);
        assert_eq!(bench.read(name), b"precious");
    }
    set_read_only("c");
    let said = bench.fails(1, "render missing.gltf -o b.exr --checkpoint c --resume c");
    assert_says(&said, &["--checkpoint", "c is read-only"]);
    let said = bench.fails(1, "render missing.gltf -o b.exr --checkpoint gone/c");
    assert_says(&said, &["--checkpoint", "gone", "create it first"]);
    assert_says(&bench.fails(1, "merge missing.exr -o gone/a.exr"), &["gone", "create it first"]);
}

#[test]
fn clouds_that_cannot_be_generated_are_usage_errors() {
    let bench = Bench::new();
    let cases: [(&str, &[&str]); 19] = [
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
        ("--set droplets.distribution=mono:r=50um", &["--set droplets.distribution", "--distribution"]),
        ("--shape cumulus --size 1km,1mm,1km", &["cumulus", "10 times", "slab"]),
        ("--shape cumulus --size 10m,200m,10m", &["20 times"]),
        ("--camera-position 1e13m,0m,0m --look-at 0m,0m,0m", &["camera", "1e12 m"]),
        ("--yfov 1e-300", &["camera", "1e12 m", "field of view"]),
        ("--kind droplets --optical-depth 1e-300", &["1e-10 m", "--count"]),
        ("--kind droplets --size 1nm", &["raise `--size`\n"]),
        ("--shape droplet --size 1nm --kind parcels", &["droplets"]),
        ("--count 50 --liquid-water 1e29g/m3", &["1e36", "--liquid-water"]),
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
    // What was checked is what is written: with its prefix, as objects one after the other, as numbers.
    bench.ok("generate -o a.gltf --count 2 -q --optical-depth 1 --set mie_cloud.accuracy.target=0.2 --set atmosphere={\"step_m\":0.5} \
         --set atmosphere={\"depth_m\":5} --set background.radiance=1");
    bench.ok("inspect a.gltf");
    let settings = &bench.json("a.gltf")["scenes"][0]["extras"]["mie_cloud"];
    assert_eq!(settings["accuracy"], serde_json::json!({ "target": 0.2 }));
    assert_eq!(settings["atmosphere"], serde_json::json!({ "step_m": 0.5, "depth_m": 5 }));
    assert_eq!(settings["background"]["radiance"], 1);
}

/// The material that `--set` names is that of the optical depth: what is written is what `inspect` and a render find.
#[test]
fn generate_fills_clouds_of_the_material_that_it_writes() {
    let bench = Bench::new();
    bench.ok(
        "generate -o a.gltf --count 50 -q --optical-depth 2 --shape slab --size 10m,1m,10m --distribution mono:r=5um",
    );
    bench.ok(
        "generate -o b.gltf --count 50 -q --optical-depth 2 --shape slab --size 10m,1m,10m --distribution mono:r=5um \
         --set droplets.material=n=1.01,k=0",
    );
    let droplets = |name: &str| {
        let made = bench.json(name)["asset"]["extras"]["mie_cloud_generator"]["made"].clone();
        assert!((made["optical_depth"].as_f64().unwrap_or(0.0) - 2.0).abs() < 1e-9, "{made}");
        made["droplets"].as_f64().expect("a number")
    };
    // Extinction efficiencies at 550 nm by `mie`: of water, and of what hardly differs from air.
    let q_ext = |index: &str| -> f64 {
        let json = bench.ok(&format!("mie --radius 5um --wavelength 550nm {index} --format json"));
        let json: serde_json::Value = serde_json::from_str(&json).expect("JSON");
        json["q_ext"].as_f64().unwrap_or_else(|| panic!("{json}"))
    };
    let expected = q_ext("--material water") / q_ext("--index 1.01,0");
    let found = droplets("b.gltf") / droplets("a.gltf");
    assert!(expected > 2.0 && (found / expected - 1.0).abs() < 1e-6, "{found} against {expected}");
}

/// Expected: a file that outgrows `ulimit -f` is an error of its write: named, the old file kept, no half one left.
#[cfg(target_os = "linux")]
#[test]
fn limits_of_files_end_with_1_and_keep_the_old_file() {
    let bench = Bench::with_cloud();
    bench.ok("render cloud.glb -o part.exr --samples 0..4 -q --resolution 64x64");
    let render = "render cloud.glb -q --spp 1 --resolution 64x64";
    let cases = [
        (format!("{render} -o a.exr"), "a.exr"),
        (format!("{render} -o /dev/null --preview a.png"), "a.png"),
        (format!("{render} -o /dev/null --checkpoint a.exr --resume a.exr"), "a.exr"),
        ("render cloud.glb -q --samples 4..8 --resolution 64x64 -o a.exr".into(), "a.exr"),
        ("merge part.exr -o a.exr".into(), "a.exr"),
        ("generate -o a.exr.glb --count 1e5 --size 2m".into(), "a.exr.glb"),
        ("mie --radius 1um --angles 0:180:0.1 -o a.exr".into(), "a.exr"),
        ("mie --radius 1um --plot a.svg".into(), "a.svg"),
    ];
    bench.ok(&format!("{render} -o first.exr --checkpoint c"));
    for (line, name) in cases {
        let old = if line.contains("--checkpoint") { bench.read("c") } else { b"previous".to_vec() };
        std::fs::write(bench.path(name), &old).expect("written");
        let before = bench.files();
        let whole = bench.command(&line);
        let mut command = std::process::Command::new("sh");
        // Blocks of 512 bytes.
        command.args(["-c", "ulimit -f 4 && exec \"$@\"", "sh"]).arg(whole.get_program()).args(whole.get_args());
        command.current_dir(bench.path(".")).env("XDG_CACHE_HOME", bench.path("cache")).stdin(Stdio::null());
        let output = command.output().expect("a shell");
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{line}: {} {said}", output.status);
        assert_says(&said, &["error: ", name, "File too large"]);
        assert!(bench.files() == before, "{line}: {:?}", bench.files().keys());
    }
}

/// Times are quantities with units like any other.
#[test]
fn times_have_units() {
    let bench = Bench::with_cloud();
    for time in ["0.01", "10ms", "0.01s", "1e-2s", "0m10ms"] {
        bench.ok(&format!("render cloud.glb -o a.exr -q --time-limit {time}"));
    }
    for (time, part) in
        [("5x", "1h30m"), ("0", "above zero"), ("-1s", "non-negative"), ("1e300", "within reason"), ("1h30", "1h30m")]
    {
        assert_says(&bench.fails(2, &format!("render cloud.glb -o a.exr --time-limit={time}")), &[part]);
    }
    assert_says(&bench.fails(2, "render cloud.glb -o a.exr --checkpoint c --checkpoint-every 1y"), &["1h30m"]);
}

/// Expected: where Mie theory ends, its limit is named, for one droplet and for many.
#[test]
fn droplets_beyond_mie_theory_are_named() {
    let bench = Bench::new();
    for line in [
        "generate -o a.glb --count 10 --kind droplets --size 1km --distribution mono:r=0.1m --optical-depth 0.1",
        "generate -o a.glb --count 2000 --kind parcels --size 100km --distribution lognormal:rg=50mm,sigma=0.5,rmax=1m",
        "generate -o a.glb --shape droplet --size 1m --distribution mono:r=1m",
    ] {
        let said = bench.fails(2, line);
        assert_says(&said, &["1e6", "8.754e-2 m", "size parameter", "--distribution"]);
        assert!(!said.contains("NaN"), "{said}");
    }
    bench.ok(
        "generate -o a.glb --count 10 --size 1km --kind droplets --distribution mono:r=80mm --optical-depth 0.1 -q",
    );
}

/// What a command reads is never what it writes: buffers, tables and pictures that a scene names, too.
#[test]
fn outputs_never_replace_inputs_or_each_other() {
    let bench = Bench::with_cloud();
    // A droplet whose buffer, background and material are files of their own.
    let settings =
        r#""extras": { "mie_cloud": { "background.image": "meadow.exr", "droplets.material": "glass.csv" } }"#;
    bench.write("lone.gltf", &POINT.replace(r#""nodes": [0]"#, &format!(r#""nodes": [0], {settings}"#)));
    bench.ok("render cloud.glb -o meadow.exr --spp 1 -q");
    bench.write("glass.csv", "wavelength_nm,n,k\n300,1.5,0\n900,1.5,0\n");
    let numbers = [0.0_f32, 0.0, 0.0, 0.5].map(f32::to_le_bytes).concat();
    std::fs::write(bench.path("data.bin"), numbers).expect("written");
    bench.ok("inspect lone.gltf");
    let before = bench.files();
    let cases = [
        ("render lone.gltf -o meadow.exr", "--output meadow.exr: is read by the scene"),
        ("render lone.gltf -o ./data.bin", "--output ./data.bin: is read by the scene"),
        ("render lone.gltf -o a.exr --stats data.bin", "--stats data.bin: is read by the scene"),
        ("render lone.gltf -o a.exr --checkpoint glass.csv", "glass.csv"),
        (
            "render cloud.glb -o a.exr --set background.image=meadow.exr --stats meadow.exr",
            "--stats meadow.exr: is read by the scene",
        ),
        ("bench effects cloud.glb --json cloud.glb", "--json cloud.glb: is the scene itself"),
        ("bench effects lone.gltf --csv data.bin", "--csv data.bin: is read by the scene"),
        ("diff lone.gltf data.bin --picture ./data.bin", "--picture ./data.bin: is one of the pictures"),
        ("bench effects cloud.glb --csv x --json ./x", "--csv and --json both name ./x"),
        ("bench accuracy cloud.glb --csv cloud.glb", "--csv cloud.glb: is the scene itself"),
        ("bench accuracy cloud.glb --reference meadow.exr --json meadow.exr", "--json meadow.exr: is the reference"),
        ("bench particles --counts 10 --repeat 1 --csv x --json x", "--csv and --json both name x"),
        ("mie --radius 5um --material glass.csv -o glass.csv", "--output glass.csv: is read as a table"),
        ("mie --radius 5um -o x --plot ./x", "--output and --plot both name ./x"),
    ];
    for (line, part) in cases {
        assert_says(&bench.fails(2, line), &[part]);
    }
    assert!(bench.files() == before, "every file is as it was, and none is new");
    // Devices may be read and written.
    bench.ok("mie --radius 5um -o /dev/null --plot /dev/null");
    // A link to what is not there yet is that file.
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink("a.exr", bench.path("link.json")).expect("linked");
        for flag in ["--stats", "--checkpoint"] {
            let said = bench.fails(2, &format!("render cloud.glb -o a.exr {flag} link.json"));
            assert_says(&said, &["--output", flag, "both name"]);
        }
    }
}

/// A file does not write to the terminal.
#[test]
fn names_in_scenes_are_printed_without_control_characters() {
    let bench = Bench::with_cloud();
    bench.ok("generate -o cloud.gltf --count 2 -q");
    let text = String::from_utf8(bench.read("cloud.gltf")).expect("text");
    assert!(text.contains(r#""name": "Camera""#) || text.contains(r#""name":"Camera""#), "{text}");
    bench.write("cloud.gltf", &text.replace("\"Camera\"", r#""\u001b[31mX\nfoo""#));
    let said = bench.ok("inspect cloud.gltf");
    assert!(!said.contains('\u{1b}') && said.contains(r"\u{1b}[31mX\nfoo"), "{said}");
}

/// A ball of fog whose droplets no number counts is named, not rendered as one of infinitely many.
#[test]
fn balls_of_fog_with_more_droplets_than_can_be_counted_are_named() {
    let bench = Bench::new();
    let numbers = [0.0_f32, 0.0, 0.0, 1e11].map(f32::to_le_bytes).concat();
    std::fs::write(bench.path("data.bin"), numbers).expect("written");
    let marks = r#""kind": "fog", "extinction_per_m": 1e12, "distribution": "mono:r=0.01um""#;
    let scene = POINT.replace(r#""mesh": 0"#, &format!(r#""mesh": 0, "extras": {{ "mie_cloud": {{ {marks} }} }}"#));
    bench.write("fog.gltf", &scene);
    let said = bench.fails(3, "render fog.gltf -o a.exr --spp 1 --resolution 4x4");
    assert_says(&said, &["particle 0", "3e38", "density"]);
}

/// A droplet whose position and radius lie in `data.bin`.
const POINT: &str = r#"{ "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": [0] }],
    "nodes": [{ "mesh": 0 }],
    "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0, "_RADIUS": 1 }, "mode": 0 }] }],
    "buffers": [{ "uri": "data.bin", "byteLength": 16 }],
    "bufferViews": [{ "buffer": 0, "byteLength": 12 }, { "buffer": 0, "byteOffset": 12, "byteLength": 4 }],
    "accessors": [{ "bufferView": 0, "componentType": 5126, "count": 1, "type": "VEC3", "min": [0, 0, 0], "max": [0, 0, 0] },
        { "bufferView": 1, "componentType": 5126, "count": 1, "type": "SCALAR" }] }"#;
