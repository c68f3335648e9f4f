//! The program as a process that is killed and goes on from its checkpoint: the picture must not show it.

#![cfg(unix)]

mod program;

use std::process::Stdio;
use std::time::{Duration, Instant};

use mie_cloud::image::sealed::Sealer;
use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;
use program::{Bench, assert_says, text};

/// A fixed number of samples, and as many as the noise asks for; each takes about half a second.
const RENDERS: [&str; 2] =
    ["render cloud.glb --spp 6000 --aov all --spectral", "render cloud.glb --noise 0.06 --aov all --seed 3"];

/// Starts the render again and again, kills it at a moment that is as good as random, until it comes to its end; returns
/// how often it was killed after it had kept something.
fn killed_again_and_again(bench: &Bench, render: &str, moments: &mut impl Iterator<Item = u64>) -> u32 {
    let mut kills = 0;
    loop {
        let resume = if bench.path("c").exists() { "--resume c" } else { "" };
        let line = format!("{render} -q -o killed.exr --checkpoint c --checkpoint-every 0.01 {resume}");
        let mut child = bench.command(&line).stderr(Stdio::piped()).spawn().expect("the program starts");
        let end = moments.next().map(|ms| Instant::now() + Duration::from_millis(ms));
        while end.is_none_or(|end| Instant::now() < end) && child.try_wait().expect("asked").is_none() {
            std::thread::sleep(Duration::from_millis(1));
        }
        let _ = child.kill();
        let output = child.wait_with_output().expect("it ends");
        match output.status.code() {
            Some(0) => return kills,
            // Killed.
            None => kills += u32::from(bench.path("c").exists()),
            Some(_) => panic!("{line}\n{}", text(&output.stderr)),
        }
    }
}

fn killed_renders_agree(kills_each: u32) {
    use rand::{RngExt, SeedableRng};
    let mut rng = rand_pcg::Pcg64Mcg::seed_from_u64(u64::from(kills_each));
    for render in RENDERS {
        let bench = Bench::with_cloud();
        let begun = Instant::now();
        bench.ok(&format!("{render} -q -o whole.exr"));
        let whole_ms = begun.elapsed().as_millis() as u64;
        let mut kills = 0;
        while kills < kills_each {
            let _ = std::fs::remove_file(bench.path("c"));
            // Several short lives, then one to the end.
            let lives: Vec<u64> = (0..5).map(|_| rng.random_range(0..whole_ms.max(2))).collect();
            kills += killed_again_and_again(&bench, render, &mut lives.into_iter());
            assert_eq!(bench.read("killed.exr"), bench.read("whole.exr"), "{render} after {kills} kills");
        }
    }
}

/// Expected: the bytes of a render that was never killed.
#[test]
fn killed_renders_go_on_to_the_same_bytes() {
    killed_renders_agree(5);
}

/// The same at fifty moments.
#[test]
#[ignore = "half a minute of processor time, in the full check: cargo test --test resume -- --ignored"]
fn killed_renders_go_on_to_the_same_bytes_from_fifty_moments() {
    killed_renders_agree(50);
}

/// Expected: an interrupt keeps the checkpoint too, whose render goes on to the end with the rays of both halves counted.
#[test]
fn an_interrupted_render_goes_on() {
    let bench = Bench::with_cloud();
    let render = "render cloud.glb --spp 8000 --aov samples";
    let line = format!("{render} -q -o a.exr --checkpoint c --checkpoint-every 0.01");
    let child = bench.command(&line).stderr(Stdio::piped()).spawn().expect("the program starts");
    let begun = Instant::now();
    while !bench.path("c").exists() && begun.elapsed() < Duration::from_secs(60) {
        std::thread::sleep(Duration::from_millis(1));
    }
    kill(Pid::from_raw(i32::try_from(child.id()).expect("a process number")), Signal::SIGINT).expect("sent");
    let output = child.wait_with_output().expect("it ends");
    assert_eq!(output.status.code(), Some(130), "{}", text(&output.stderr));
    assert_says(&text(&output.stderr), &["a.exr keeps", "--resume c"]);
    bench.ok(&format!("{render} -q -o a.exr --stats a.json --checkpoint c --resume c"));
    bench.ok(&format!("{render} -q -o b.exr --stats b.json"));
    assert_eq!(bench.read("a.exr"), bench.read("b.exr"));
    assert_eq!(bench.json("a.json")["rays"], bench.json("b.json")["rays"]);
    // A finished checkpoint gives its picture at once.
    bench.ok(&format!("{render} -q -o again.exr --resume c"));
    assert_eq!(bench.read("again.exr"), bench.read("b.exr"));
}

#[test]
fn a_checkpoint_of_another_render_is_refused_with_what_differs() {
    let bench = Bench::with_cloud();
    bench.ok("generate -o other.glb --count 31 --size 2m --optical-depth 1 --distribution mono:r=5um -q \
              --set spectral.mode=rgb --set image.resolution=12x8");
    bench.ok("render cloud.glb -q -o a.exr --spp 4 --checkpoint c");
    let before = bench.read("a.exr");
    let cases: [(&str, &[&str]); 9] = [
        ("other.glb --spp 4", &["the scene has hash"]),
        ("cloud.glb --spp 8", &["--spp 4", "not --spp 8", "settled when a render begins", "--samples", "`merge`"]),
        ("cloud.glb --noise 0.1", &["--spp 4", "not --noise 0.1"]),
        ("cloud.glb --spp 4 --seed 1", &["--seed is 0, not 1"]),
        ("cloud.glb --spp 4 --resolution 6x4", &["image.resolution is [12,8], not [6,4]"]),
        ("cloud.glb --spp 4 --crop 0,0,4,4", &["--crop is [0,0,12,8], not [0,0,4,4]"]),
        ("cloud.glb --spp 4 --set atmosphere.scattering_per_m=0.5", &["atmosphere.scattering_per_m is", "not 0.5"]),
        ("cloud.glb --spp 4 --order 1", &["--order is unset, not 1"]),
        ("cloud.glb --spp 4 --effects=-shadows", &["--effects"]),
    ];
    for (flags, parts) in cases {
        let said = bench.fails(2, &format!("render {flags} -o a.exr --resume c"));
        assert_says(&said, parts);
        assert_says(&said, &["--resume c", "begin anew"]);
    }
    let said = bench.fails(2, "render cloud.glb -o a.exr --spp 4 --checkpoint c");
    assert_says(&said, &["--checkpoint c", "may hold work", "--resume c"]);
    assert_says(&bench.fails(2, "render cloud.glb -o c --spp 4 --resume c"), &["--output c", "to go on from"]);
    assert_eq!(bench.read("a.exr"), before);
}

/// Expected: a record whose checksum is right but whose head lies is refused, before memory is taken for what it promises.
#[test]
fn checkpoints_that_lie_are_refused() {
    let bench = Bench::with_cloud();
    bench.ok("render cloud.glb -q -o a.exr --spp 2 --checkpoint c");
    let whole = bench.read("c");
    let head_bytes = u64::from_le_bytes(whole[..8].try_into().expect("eight bytes")) as usize;
    let (head, sums) = (text(&whole[8..8 + head_bytes]), &whole[8 + head_bytes..whole.len() - 24]);
    let seal = |length: u64, head: &str, sums: &[u8]| {
        let mut bytes = Vec::new();
        let mut sealer = Sealer::new(&mut bytes);
        [&length.to_le_bytes()[..], head.as_bytes(), sums].iter().for_each(|part| sealer.put(part).expect("put"));
        sealer.seal().expect("sealed");
        std::fs::write(bench.path("d"), bytes).expect("written");
    };
    let refused = || bench.fails(1, "render cloud.glb -o b.exr --spp 2 --resume d");
    seal(head_bytes as u64, &head, sums);
    bench.ok("render cloud.glb -q -o b.exr --spp 2 --resume d");
    for (from, to) in [
        ("\"width\":12", "\"width\":4294967295"),
        ("\"height\":8", "\"height\":0"),
        ("\"width\":12,\"height\":8", "\"width\":8,\"height\":12"),
        ("\"n_films\":1", "\"n_films\":18446744073709551615"),
        ("\"n_films\":1", "\"n_films\":0"),
        ("\"n_spectral\":0", "\"n_spectral\":18446744073709551615"),
        ("\"layers\":[]", "\"layers\":[\"rainbow\"]"),
        ("\"round\":null", "\"round\":{\"targets\":{\"ByTile\":[[1,2]]},\"expected\":1}"),
        ("\"round\":null", "\"round\":7"),
        ("{", "["),
    ] {
        assert!(head.contains(from), "{from} is not in {head}");
        let lie = head.replacen(from, to, 1);
        seal(lie.len() as u64, &lie, sums);
        assert_says(&refused(), &["d"]);
    }
    for length in [0, head_bytes as u64 + 1, u64::MAX] {
        seal(length, &head, sums);
        assert_says(&refused(), &["damaged"]);
    }
    seal(head_bytes as u64, &head, &sums[8..]);
    assert_says(&refused(), &["damaged"]);
}

/// Expected: whatever byte is changed, and wherever the file ends, an error that names it.
#[test]
fn damaged_checkpoints_are_refused() {
    let bench = Bench::with_cloud();
    bench.ok("render cloud.glb -q -o a.exr --spp 2 --checkpoint c");
    let whole = bench.read("c");
    let n = whole.len();
    let write = |bytes: &[u8]| std::fs::write(bench.path("d"), bytes).expect("written");
    for at in [0, 5, 40, n / 2, n - 25, n - 20, n - 10, n - 3] {
        let mut bytes = whole.clone();
        bytes[at] ^= 0x40;
        write(&bytes);
        assert_says(&bench.fails(1, "render cloud.glb -o b.exr --spp 2 --resume d"), &["--resume", "d"]);
    }
    for length in [0, 7, 24, n / 2, n - 1] {
        write(&whole[..length]);
        assert_says(&bench.fails(1, "render cloud.glb -o b.exr --spp 2 --resume d"), &["--resume", "d"]);
    }
    assert_says(&bench.fails(1, "render cloud.glb -o b.exr --spp 2 --resume missing"), &["missing", "cannot read"]);
    assert_says(
        &bench.fails(1, "render cloud.glb -o b.exr --spp 2 --resume a.exr"),
        &["a.exr holds no sums", "`--resume` goes on from what `--checkpoint` writes"],
    );
    assert!(!bench.path("b.exr").exists());
}
