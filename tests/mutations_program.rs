//! Hostile and damaged files through the program, which may have little memory: it says what is wrong and names the file;
//! it never aborts, and no signal ends it.

#![cfg(target_os = "linux")]

mod mutator;
mod program;
mod readers;
mod seeds;
mod support;

use std::process::{Command, Output, Stdio};

use mutator::Mutator;
use program::{Bench, text};
use readers::files::CLOUD;

/// Address space of a child, KiB: the program with one thread, the 64 MiB that any scene may take, and as much for a
/// picture.
const ADDRESS_SPACE_KIB: u32 = 600_000;

/// Runs the program in a shell that limits its address space and its processor time.
fn run(bench: &Bench, line: &str) -> Output {
    let limits = format!("ulimit -v {ADDRESS_SPACE_KIB}; ulimit -t 20; exec \"$0\" \"$@\"");
    let mut shell = Command::new("sh");
    shell.args(["-c", &limits, env!("CARGO_BIN_EXE_mie-cloud")]).args(line.split_whitespace());
    shell.current_dir(bench.path("")).stdin(Stdio::null()).env("XDG_CACHE_HOME", bench.path("cache"));
    shell.env("RAYON_NUM_THREADS", "1").output().expect("the program starts")
}

/// Runs a command whose file may be anything: it ends by itself, and a failure is one that names the file.
fn survives(bench: &Bench, line: &str, file: &str, why: &str) {
    let output = run(bench, line);
    let said = text(&output.stderr);
    let code = output.status.code();
    assert!(matches!(code, Some(0..=3)), "{why}: {line}: {}\n{said:.2000}", output.status);
    assert!(!said.contains("panicked") && !said.contains("allocation"), "{why}: {line}\n{said:.2000}");
    if code != Some(0) {
        let error = said.lines().find(|line| line.starts_with("error: "));
        assert!(error.is_some_and(|error| error.contains(file)), "{why}: {line}\n{said:.2000}");
    }
}

/// How the program reads a kind of file: its name, and the commands.
const READ_BY: [(&str, &str, &[&str]); 4] = [
    ("scene", "f.gltf", &["inspect f.gltf"]),
    ("exr", "f.exr", &["diff f.exr f.exr", "render c.glb -o o.exr -q --spp 1 --set background.image=f.exr"]),
    ("part", "f.exr", &["merge f.exr -o o.exr --allow-gaps -q", "render c.glb -o o.exr -q --spp 4 --resume f.exr"]),
    (
        "csv",
        "f.csv",
        &["mie --radius 1um --material f.csv", "mie --distribution csv:f.csv --angles 0,90,180 --index 1.33"],
    ),
];

#[test]
fn damaged_files_end_in_a_message_where_memory_is_short() {
    let bench = Bench::new();
    bench.ok(&format!("generate -o c.glb {}", CLOUD.join(" ")));
    let mut mutator = Mutator::new(11);
    for (kind, file, lines) in READ_BY {
        let seeds = seeds::of(kind, 20_000);
        for i in 0..20 {
            let seed = &seeds[i * 5 % seeds.len()];
            let mut bytes = seed.bytes.clone();
            if i > 0 {
                mutator.damage(&mut bytes, &seeds[i % seeds.len()].bytes);
            }
            std::fs::write(bench.path(file), &bytes).expect("written");
            lines.iter().for_each(|line| survives(&bench, line, file, &format!("{} damaged, {i}", seed.name)));
        }
    }
}

#[test]
fn hostile_files_end_in_a_message_where_memory_is_short() {
    let bench = Bench::new();
    let hostile = seeds::of("scene", 1 << 20).into_iter().filter(|seed| seed.name.starts_with("hostile"));
    let mut count = 0;
    for seed in hostile {
        std::fs::write(bench.path("f.gltf"), &seed.bytes).expect("written");
        survives(&bench, "inspect f.gltf", "f.gltf", &seed.name);
        count += 1;
    }
    assert_eq!(count, 39);
}

/// Files without end and files that hold nothing but their length.
#[test]
fn endless_files_are_not_read_to_their_end() {
    let bench = Bench::new();
    bench.ok("generate -o c.glb --count 4 --size 2m -q");
    for name in ["f.gltf", "f.exr", "f.csv"] {
        let file = std::fs::File::create(bench.path(name)).expect("created");
        // A terabyte that takes no room on the disk.
        file.set_len(1 << 40).expect("a sparse file");
    }
    for (line, file) in [
        ("inspect f.gltf", "f.gltf"),
        ("inspect /dev/zero", "/dev/zero"),
        ("inspect .", "."),
        ("diff f.exr f.exr", "f.exr"),
        ("diff /dev/zero c.glb", "/dev/zero"),
        ("merge f.exr -o o.exr", "f.exr"),
        ("merge /dev/zero -o o.exr", "/dev/zero"),
        ("render c.glb -o o.exr --resume f.exr", "f.exr"),
        ("render c.glb -o o.exr --set background.image=f.exr", "f.exr"),
        ("render c.glb -o o.exr --set background.image=/dev/zero", "/dev/zero"),
        ("render c.glb -o o.exr --set droplets.material=f.csv", "f.csv"),
        ("render c.glb -o o.exr --set droplets.phase=table:/dev/zero", "/dev/zero"),
        ("mie --radius 1um --material f.csv", "f.csv"),
        ("mie --radius 1um --material csv:/dev/zero", "/dev/zero"),
        ("mie --distribution csv:/dev/zero --index 1.33", "/dev/zero"),
        ("generate -o d.glb --distribution csv:/dev/zero", "/dev/zero"),
    ] {
        let output = run(&bench, line);
        let said = text(&output.stderr);
        assert!(matches!(output.status.code(), Some(1..=3)), "{line}: {}\n{said}", output.status);
        assert!(said.contains(file) && said.len() < 3000 && !said.contains("panicked"), "{line}\n{said}");
    }
}
