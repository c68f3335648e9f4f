//! What somebody sees who has just found the program: help, completions, manual, hints, progress, examples.

mod program;

use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::Stdio;
use std::time::{Duration, Instant};

use program::{Bench, assert_says, shipped, text};

#[path = "../examples/one_picture.rs"]
#[allow(dead_code, reason = "the test calls `draw`, not `main`")]
mod one_picture;
#[path = "../examples/one_sphere.rs"]
mod one_sphere;
#[path = "../examples/phase_table.rs"]
mod phase_table;

/// Every command, with the words that lead to it.
const COMMANDS: [&str; 15] = [
    "",
    "render",
    "generate",
    "mie",
    "inspect",
    "bench",
    "bench particles",
    "bench effects",
    "bench accuracy",
    "diff",
    "merge",
    "paper",
    "completions",
    "man",
    "help",
];

#[test]
fn help_is_short_or_long_and_ends_with_examples() {
    let bench = Bench::new();
    for command in COMMANDS.into_iter().filter(|command| !matches!(*command, "help")) {
        let (short, long) = (bench.ok(&format!("{command} -h")), bench.ok(&format!("{command} --help")));
        for help in [&short, &long] {
            assert_says(help, &["Usage: mie-cloud", command]);
        }
        assert!(short.lines().count() <= 60, "{command}: {} lines", short.lines().count());
        assert!(short.lines().all(|line| line.chars().count() <= 100), "{short}");
        assert_says(&short, &["Examples:\n  mie-cloud "]);
        if matches!(command, "render" | "generate") {
            assert!(long.lines().count() > short.lines().count() + 20, "{command}");
        }
    }
}

/// Expected: examples are understood, though their scenes are not there: no usage errors.
#[test]
fn the_examples_of_the_help_texts_are_sound() {
    let bench = Bench::new();
    let mut seen = 0;
    for command in COMMANDS.into_iter().filter(|command| !matches!(*command, "help" | "paper")) {
        let help = bench.ok(&format!("{command} -h"));
        for line in help.lines().filter_map(|line| line.strip_prefix("  mie-cloud ")) {
            let line = line.split(['>', '|', '&']).next().unwrap_or(line);
            // What is large or wants folders of the user's own.
            if line.contains("cumulus") || line.contains('~') || line.contains("bench particles") {
                continue;
            }
            // The scenes that the examples make are rendered small.
            let line = line.replace("render ball.glb", "render ball.glb --resolution 16x9 --spp 1");
            let output = bench.run(&line);
            assert_ne!(output.status.code(), Some(2), "{line}\n{}", text(&output.stderr));
            seen += 1;
        }
    }
    assert!(seen > 20, "{seen}");
}

#[test]
fn shells_and_manuals_know_every_command_and_flag() {
    let bench = Bench::new();
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        assert_says(&bench.ok(&format!("completions {shell}")), &["mie-cloud", "checkpoint-every"]);
    }
    assert_says(&bench.fails(2, "completions bsh"), &["bash"]);
    std::fs::create_dir(bench.path("man1")).expect("a folder");
    bench.ok("man --all man1");
    for command in COMMANDS.into_iter().filter(|command| *command != "help") {
        let page = bench.ok(&format!("man {command}"));
        let name = format!("mie-cloud {command}").trim().replace(' ', "-");
        assert_says(&page, &[&format!(".TH {}", name.to_uppercase()), ".SH SYNOPSIS"]);
        assert_eq!(page.into_bytes(), bench.read(&format!("man1/{name}.1")));
    }
    let pages = std::fs::read_dir(bench.path("man1")).expect("pages").count();
    assert_eq!(pages, COMMANDS.len() - 1, "every command stands in this test's list");
    assert_says(&bench.ok("man render"), &["checkpoint\\-every"]);
    assert_says(&bench.fails(2, "man rendr"), &["did you mean `render`?"]);
    assert_says(&bench.fails(1, "man --all nowhere"), &["nowhere", "create it"]);
}

#[test]
fn slips_in_any_kind_of_name_are_recognised() {
    let bench = Bench::with_cloud();
    let render = |rest: &str| format!("render cloud.glb -o a.exr --spp 1 {rest}");
    for (flags, meant) in [
        ("--previw a.png", "'--preview'"),
        ("--effects +glwo", "`glow`"),
        ("--aov dirct", "`direct`"),
        ("--set atmosfere.step_m=1", "`atmosphere.step_m`"),
        ("--set step_m=1", "`atmosphere.step_m`"),
        ("--set droplets.material=watre", "`water`"),
        ("--set droplets.phase=isotropc", "`isotropic`"),
        ("--set droplets.distribution=gama:reff=6um,veff=0.1", "`gamma`"),
        ("--set droplets.distribution=gamma:ref=6um,veff=0.1", "`reff`"),
        ("--set spectral.mode=band:8", "`bands`"),
        ("--set sun.spectrum=d56", "`d65`"),
        ("--set atmosphere.phase=isotropik", "`isotropic`"),
        ("--set atmosphere.sunlight=tru", "`true`"),
        ("--set accuracy.target=draf", "`draft`"),
        ("--set droplets.size_bins=aut", "`auto`"),
        ("--set effects.glow=atuo", "`auto`"),
        ("--effects aut", "`auto`"),
        ("--accuracy draf", "`draft`"),
    ] {
        assert_says(&bench.fails(2, &render(flags)), &[meant]);
    }
    assert_says(&bench.fails(2, "generate -o b.glb --shape cumulos"), &["'cumulus'", "puff"]);
    assert_says(&bench.fails(2, "mie --radius 5um --material watre"), &["`water`", "ice"]);
}

/// Expected: whoever mistypes a name is told which was meant, and which there are.
#[test]
fn slips_are_answered_with_all_that_there_is() {
    let bench = Bench::with_cloud();
    for (line, meant, another) in [
        ("rendr cloud.glb", "'render'", "generate, mie"),
        ("help rendr", "'render'", "generate, mie"),
        ("help bench acuracy", "'accuracy'", "particles, effects"),
        ("man rendr", "`render`", "generate, mie"),
        ("cloud.glb", "mie-cloud render cloud.glb -o", "generate, mie"),
        ("bench accuracy cloud.glb --knobs bandz", "`bands`", "spp, bands"),
        ("bench accuracy cloud.glb --targets fne", "`fine`", "draft, standard"),
        ("inspect cloud.glb --effects +glwo", "`glow`", "direct, multiple"),
        ("inspect cloud.glb --set atmosfere.step=1", "`atmosphere.step_m`", "atmosphere.depth_m"),
        ("inspect cloud.glb --set atmosfere=1", "atmosphere.step_m", "atmosphere.depth_m"),
        ("inspect cloud.glb --set kind=fog", "a node, mesh or material", "atmosphere.*"),
    ] {
        assert_says(&bench.fails(2, line), &[meant, another]);
    }
    assert_says(&bench.fails(2, "help render cloud"), &["`render` has no commands of its own"]);
}

/// A custom property whose name is almost ours would do nothing, and nobody would know why. Others' properties are their business.
#[test]
fn properties_that_are_almost_ours_are_pointed_out() {
    let bench = Bench::new();
    let inspect =
        |key: &str| {
            let settings = r#""mie_cloud": {"background": {"radiance": 1}}"#;
            bench.write("a.gltf", &format!(
            r#"{{"asset": {{"version": "2.0"}}, "scene": 0, "scenes": [{{"extras": {{{settings}, "{key}": 1}}}}]}}"#
        ));
            bench.run("inspect a.gltf")
        };
    for slip in [
        "miecloud",
        "mie-cloud.kind",
        "Mie_Cloud.atmosphere.step_m",
        "mie_cloud_kind",
        "mie cloud",
        "miecloud.image.resolution",
    ] {
        let output = inspect(slip);
        assert_eq!(output.status.code(), Some(3), "{slip}");
        assert_says(&text(&output.stderr), &["scenes[0].extras", slip, "`mie_cloud`"]);
    }
    for foreign in ["cloud", "mie", "mie_cloud_generator", "miecloudlike", "kind"] {
        assert_eq!(inspect(foreign).status.code(), Some(0), "{foreign}");
    }
}

/// Expected: whoever exports meshes without marks is told which meshes, and how to mark them.
#[test]
fn scenes_without_droplets_say_what_is_in_them() {
    let bench = Bench::new();
    let mesh = |mode: u32| {
        let accessor = r#"{"componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [0, 0, 0]}"#;
        let primitive = format!(r#"{{"attributes": {{"POSITION": 0}}, "mode": {mode}}}"#);
        format!(
            r#"{{"asset": {{"version": "2.0"}}, "scene": 0, "scenes": [{{"nodes": [0]}}], "accessors": [{accessor}],
            "nodes": [{{"mesh": 0, "name": "Cube"}}], "meshes": [{{"primitives": [{primitive}]}}]}}"#
        )
    };
    bench.write("mesh.gltf", &mesh(4));
    assert_says(
        &bench.fails(3, "inspect mesh.gltf"),
        &["nothing to render", "\"Cube\"", "--droplets", "kind = \"fog\""],
    );
    bench.write("points.gltf", &mesh(0));
    assert_says(&bench.fails(3, "inspect points.gltf"), &["points without a _RADIUS", "--radius"]);
    assert_says(&bench.fails(2, "inspect points.gltf --radius 1"), &["--radius", "cm"]);
}

/// Expected: no PNG is written into a file that others take for something else, no SVG either.
#[test]
fn names_of_files_promise_what_is_in_them() {
    let bench = Bench::with_cloud();
    let render = |preview: &str| format!("render cloud.glb -o a.exr --spp 1 -q --preview {preview}");
    for (line, better) in [
        (&*render("a.jpg"), "a.png"),
        (&*render("b.exr"), "b.png"),
        ("mie --radius 5um --plot p.png", "p.svg"),
        ("diff a.exr a.exr --picture d.svg", "d.png"),
        ("bench particles --counts 10 --plot p.pdf", "p.svg"),
    ] {
        assert_says(&bench.fails(2, line), &["name it", better]);
    }
    bench.ok(&render("no-ending"));
    assert_eq!(bench.files().len(), 3, "the cloud, the picture and its preview");
}

#[test]
fn messages_name_one_remedy_and_the_right_one() {
    let bench = Bench::with_cloud();
    for (flags, remedy) in [
        ("--effects glwo", "`+glow`"),
        ("--camera Camra", "`Camera`"),
        ("--crop 0,0,99,2", "X+W may be 12"),
        ("--spp 1 --resume none", "check the path"),
    ] {
        let line = format!("render cloud.glb -o a.exr {flags}");
        assert_says(&text(&bench.run(&line).stderr), &["error: ", remedy]);
    }
    assert_says(&bench.fails(2, "generate -o x.glb --optical-depth -1"), &["above zero"]);
    assert_says(&bench.fails(2, "generate -o x.obj"), &["x.obj", "`.glb`"]);
    assert!(!bench.fails(3, "inspect none.glb").contains("os error"));
    let said = |flags: &str| bench.fails(2, &format!("render cloud.glb -o a.exr --spp 1 {flags}"));
    let missing = said("--set droplets.material=no.csv");
    assert_says(&missing, &["no.csv cannot be read", "relative to the working folder"]);
    assert!(!missing.contains("beside the scene") && !missing.contains("; expected"), "{missing}");
    assert_says(&said("--set foo=1"), &["unknown key `foo`", "atmosphere.*", "docs/scene-format.md"]);
    assert_says(&said("--set accuracy.zzzzzz=1"), &["accuracy.target", "accuracy.glow_tolerance"]);
    assert_says(&said("--set droplets.albedo=2"), &["is out of range; expected 0 to 1"]);
    assert_says(&said("--radius -5um"), &["--radius", "-5um"]);
    assert_says(&said("--noise -1"), &["--noise", "between 0 and 1"]);
    assert_says(&bench.fails(2, "mie --radius 5um --material no.csv"), &["no.csv cannot be read", "check the path"]);
}

/// Expected: whatever is in a scene, what is said of it fits a terminal; only the first line, its path, is as long as it is.
#[test]
fn what_inspect_says_fits_a_terminal() {
    let bench = Bench::with_cloud();
    let shipped_scenes = ["fog", "fogbow", "corona", "cumulus", "steam", "drop", "droplet", "paper/fig01"];
    let scenes = shipped_scenes.map(|name| shipped(&format!("scenes/{name}.gltf")));
    for scene in scenes.iter().map(String::as_str).chain(["cloud.glb"]) {
        let said = bench.ok(&format!("inspect {scene}"));
        assert!(said.lines().skip(1).all(|line| line.chars().count() <= 80), "{said}");
        assert_says(&said, &["depth       about ", "picture     ", "  on  absorption", "  off "]);
    }
    assert_says(&bench.ok(&format!("inspect {}", scenes[5])), &["water, radii 280 um to 1 mm, phase mie"]);
    // A camera that looks away.
    bench.ok("generate -o behind.glb --count 3 --camera-position 0m,0m,9m --look-at 0m,0m,20m --size 2m -q");
    assert_says(&bench.ok("inspect behind.glb"), &["the camera sees no droplet"]);
}

#[test]
fn the_summary_fits_a_terminal() {
    let bench = Bench::with_cloud();
    let output = bench.run("render cloud.glb -o a.exr --spp 2");
    let said = text(&output.stderr);
    assert_says(&said, &["a.exr: 12x8, 2 spp, noise", "30 particles in 1 size bin, 3 wavelengths\n", "peak", "render"]);
    let summary = said.lines().skip_while(|line| !line.starts_with("a.exr"));
    assert!(summary.clone().count() <= 6 && summary.clone().all(|line| line.chars().count() <= 80), "{said}");
}

/// Expected: the preview of a picture that takes long is there at once, whole, and the picture is not.
#[test]
fn there_is_a_preview_long_before_the_picture() {
    let bench = Bench::with_cloud();
    let line = "render cloud.glb -o a.exr --preview a.png --resolution 800x600 --spp 1000000 -q";
    let mut child = bench.command(line).stdout(Stdio::null()).spawn().expect("the program starts");
    let begun = Instant::now();
    while !bench.path("a.png").exists() && begun.elapsed() < Duration::from_secs(60) {
        std::thread::sleep(Duration::from_millis(20));
    }
    let _ = child.kill();
    child.wait().expect("it ends");
    assert!(!bench.path("a.exr").exists());
    let bytes = bench.read("a.png");
    let mut reader = png::Decoder::new(std::io::Cursor::new(&bytes)).read_info().expect("a PNG");
    let mut rgb = vec![0; reader.output_buffer_size().expect("small")];
    reader.next_frame(&mut rgb).expect("one frame");
    assert_eq!(rgb.len(), 800 * 600 * 3);
    // The cloud is in the middle, and in every quarter of the picture.
    let brightest = |x0: usize, y0: usize| {
        (0..300).flat_map(|y| (0..400).map(move |x| (y0 + y, x0 + x))).map(|(y, x)| rgb[3 * (800 * y + x)]).max()
    };
    for (x0, y0) in [(0, 0), (400, 0), (0, 300), (400, 300)] {
        assert!(brightest(x0, y0) > Some(60), "{x0} {y0}: {:?}", brightest(x0, y0));
    }
}

/// Expected: a render that takes hours says so within seconds, once, with what to do instead; whoever set a limit is told nothing.
#[test]
fn long_renders_say_how_long_they_take() {
    let bench = Bench::with_cloud();
    let said = |flags: &str, until: &str| {
        let line = format!("render cloud.glb -o a.exr --resolution 160x120 {flags}");
        let mut child = bench.command(&line).stderr(Stdio::piped()).spawn().expect("the program starts");
        let lines = BufReader::new(child.stderr.take().expect("stderr")).lines().map_while(Result::ok);
        // The program ends by its own limit or by this test's.
        let heard: Vec<String> = lines
            .take(40)
            .scan(false, |done, line| (!std::mem::replace(done, line.contains(until))).then_some(line))
            .collect();
        let _ = child.kill();
        child.wait().expect("it ends");
        heard
    };
    let heard = said("--noise 0.00001", "--time-limit 60 gives");
    let last = heard.last().expect("a line");
    assert!(last.starts_with("up to about ") && last.contains("noise") && last.chars().count() <= 100, "{heard:?}");
    assert!(!said("--noise 0.00001 --time-limit 4", "rays/s").iter().any(|line| line.contains("gives about")));
}

#[test]
fn the_examples_of_the_library_run() {
    one_sphere::main().expect("one sphere");
    phase_table::main().expect("a table");
    let folder = tempfile::tempdir().expect("a folder");
    let (exr, png) = (folder.path().join("ball.exr"), folder.path().join("ball.png"));
    one_picture::draw(&exr, &png, 1).expect("a picture");
    let picture = mie_cloud::image::exr::read(&exr, Default::default()).expect("the picture");
    let opacity = picture.channel("A").expect("opacity");
    let middle = opacity[(picture.height as usize / 2) * picture.width as usize + picture.width as usize / 2];
    assert!(Path::new(&png).exists() && opacity[0] < 0.01 && middle > 0.05, "{middle}");
}
