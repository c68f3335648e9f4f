//! The program as a process that is interrupted: what it keeps, how it ends.

#![cfg(unix)]

mod program;

use std::process::{Child, Stdio};
use std::time::{Duration, Instant};

use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;
use program::{Bench, assert_says, text};

/// More samples than any test waits for.
const ENDLESS: &str = "render cloud.glb -o a.exr --preview a.png --stats a.json --aov samples --spp 4000000000 --checkpoint c \
     --checkpoint-every 0.05";

fn start(bench: &Bench, line: &str) -> Child {
    bench.command(line).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().expect("the program starts")
}

fn send(child: &Child, signal: Signal) {
    kill(Pid::from_raw(i32::try_from(child.id()).expect("a process number")), signal).expect("the signal is sent");
}

/// Waits for the first checkpoint, which shows that samples have been taken.
fn await_samples(bench: &Bench) {
    let begun = Instant::now();
    while !bench.path("c").exists() {
        assert!(begun.elapsed() < Duration::from_secs(60), "no checkpoint");
        std::thread::sleep(Duration::from_millis(5));
    }
}

#[test]
fn an_interrupt_saves_what_there_is_and_ends_with_130() {
    for signal in [Signal::SIGINT, Signal::SIGTERM] {
        let bench = Bench::with_cloud();
        let child = start(&bench, ENDLESS);
        await_samples(&bench);
        let sent = Instant::now();
        send(&child, signal);
        let output = child.wait_with_output().expect("it ends");
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(130), "{signal}\n{said}");
        assert!(sent.elapsed() < Duration::from_secs(20), "a tile of the picture takes less: {:?}", sent.elapsed());
        let samples = &bench.picture("a.exr").channel("samples.N").expect("samples").to_vec();
        assert!(samples.iter().all(|n| *n >= 1.0), "{samples:?}");
        let mean = samples.iter().sum::<f32>() / samples.len() as f32;
        let spp = bench.json("a.json")["spp"].as_f64().expect("spp");
        assert!((spp - f64::from(mean)).abs() <= 0.5 + 1e-6 * spp, "{spp} {mean}");
        assert_says(&said, &["interrupted: a.exr keeps", &format!(" {spp} samples per pixel")]);
        assert_eq!(bench.read("a.png")[1..4], *b"PNG");
        let names: Vec<String> = bench.files().into_keys().collect();
        assert_eq!(names, ["a.exr", "a.json", "a.png", "c", "cloud.glb"], "nothing else is left behind");
    }
}

/// Expected: a render that is killed, or interrupted before it has anything to keep, leaves the previous file as it was.
///
/// Where this test runs in the background of a shell, SIGINT is ignored until the program listens to it: there may be a picture then.
#[test]
fn previous_files_survive_an_early_end() {
    // Tables of a broad distribution take a while, without a cache.
    let slow = format!("{ENDLESS} --no-cache --set droplets.distribution=gamma:reff=200um,veff=0.1");
    for signal in [Signal::SIGINT, Signal::SIGTERM, Signal::SIGKILL] {
        let bench = Bench::with_cloud();
        bench.write("a.exr", "previous");
        let mut child = start(&bench, &slow);
        while child.try_wait().expect("it is ours").is_none() {
            std::thread::sleep(Duration::from_millis(50));
            send(&child, signal);
        }
        let output = child.wait_with_output().expect("it ends");
        assert!(!output.status.success(), "{}", text(&output.stderr));
        if bench.read("a.exr") == b"previous" {
            assert!(!bench.path("a.json").exists() && (signal == Signal::SIGINT || !bench.path("a.png").exists()));
        } else {
            assert_eq!((signal, output.status.code()), (Signal::SIGINT, Some(130)), "{}", text(&output.stderr));
            assert_eq!(bench.picture("a.exr").n_pixels(), 96);
        }
    }
}

/// Rationale: one pixel is one tile, which an interrupt lets finish, and whose rounds grow to seconds. Expected: the second
/// signal ends the program there and then; the previous file is as it was, or the new one whole.
#[test]
fn a_second_interrupt_ends_it_at_once() {
    let mut ended_early = 0;
    for (first, second) in
        [(Signal::SIGINT, Signal::SIGINT), (Signal::SIGTERM, Signal::SIGTERM), (Signal::SIGINT, Signal::SIGTERM)]
    {
        let bench = Bench::with_cloud();
        bench.write("a.exr", "previous");
        let child = start(&bench, &format!("{ENDLESS} --crop 6,4,1,1"));
        await_samples(&bench);
        std::thread::sleep(Duration::from_millis(700));
        send(&child, first);
        std::thread::sleep(Duration::from_millis(20));
        send(&child, second);
        let sent = Instant::now();
        let output = child.wait_with_output().expect("it ends");
        assert!(sent.elapsed() < Duration::from_millis(400), "{:?}", sent.elapsed());
        assert_eq!(output.status.code(), Some(130), "{first} {second}\n{}", text(&output.stderr));
        if bench.read("a.exr") == b"previous" {
            ended_early += 1;
            assert!(!bench.path("a.png").exists() && !bench.path("a.json").exists());
        } else {
            assert_eq!(bench.picture("a.exr").n_pixels(), 1);
        }
        let left: Vec<String> = bench.files().into_keys().filter(|name| name.contains(".tmp")).collect();
        assert!(left.len() <= 1, "at most the checkpoint that was being written: {left:?}");
    }
    assert!(ended_early >= 2, "a round of a second ends within 20 ms now and then only: {ended_early} of 3");
}

/// Expected: a checkpoint whose folder vanishes is no reason to lose the render: it is warned about, the picture is
/// written, and the exit code says that something failed.
#[test]
fn a_checkpoint_that_cannot_be_written_any_more_costs_nothing_else() {
    let bench = Bench::with_cloud();
    std::fs::create_dir(bench.path("kept")).expect("made");
    let line = "render cloud.glb -o a.exr --time-limit 1s --checkpoint kept/c --checkpoint-every 50ms";
    let child = start(&bench, line);
    let begun = Instant::now();
    while !bench.path("kept/c").exists() {
        assert!(begun.elapsed() < Duration::from_secs(60), "no checkpoint");
        std::thread::sleep(Duration::from_millis(2));
    }
    // A checkpoint may be written at this very moment.
    while std::fs::remove_dir_all(bench.path("kept")).is_err() {}
    let output = child.wait_with_output().expect("it ends");
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert_says(&said, &["warning: no checkpoint: ", "kept", "error: --checkpoint: "]);
    assert_eq!(bench.picture("a.exr").n_pixels(), 96);
}
