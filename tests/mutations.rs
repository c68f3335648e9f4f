//! Damaged files through every reader, by the thousand and always the same ones: no panic, no message without the file's
//! name, little time and little memory. One test only, because it measures the memory of the process.

mod mutator;
mod program;
mod readers;
mod seeds;
mod support;

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::Mutex;

use mutator::Mutator;
use nix::time::{ClockId, clock_gettime};
use peak_alloc::PeakAlloc;
use readers::{READERS, Reader};
use seeds::Seed;

#[global_allocator]
static MEMORY: PeakAlloc = PeakAlloc;

/// What the last panic said; those that the library catches itself say nothing.
static PANIC: Mutex<String> = Mutex::new(String::new());

/// Processor time of this thread, s.
fn seconds() -> f64 {
    let now = clock_gettime(ClockId::CLOCK_THREAD_CPUTIME_ID).expect("a clock");
    now.tv_sec() as f64 + 1e-9 * now.tv_nsec() as f64
}

/// What a reader may allocate beyond what was there: the promise of scenes, and the limit that is given to pictures.
fn allowance_bytes(n_bytes: usize) -> usize {
    (64 << 20) + 20 * n_bytes
}

/// The longest that one file may take, s: the slowest takes a fifth, on a busy machine.
const LONGEST_S: f64 = 5.0;

/// Feeds bytes to a reader and measures it; returns what was wrong, and keeps the bytes.
fn check(reader: Reader, bytes: &[u8], folder: &Path) -> Option<String> {
    let (begun, before) = (seconds(), MEMORY.current_usage());
    MEMORY.reset_peak_usage();
    let outcome = catch_unwind(AssertUnwindSafe(|| reader(bytes, folder)));
    let (taken_s, peak) = (seconds() - begun, MEMORY.peak_usage().saturating_sub(before));
    let wrong = match outcome {
        Err(_) => PANIC.lock().expect("one thread").clone(),
        Ok(()) if taken_s > LONGEST_S => format!("it took {taken_s:.1} s"),
        Ok(()) if peak > allowance_bytes(bytes.len()) => format!("it took {peak} bytes for {}", bytes.len()),
        Ok(()) => return None,
    };
    let path = std::env::temp_dir().join(format!("mie-cloud-broken-{:016x}", xxhash_rust::xxh3::xxh3_64(bytes)));
    std::fs::write(&path, bytes).expect("written");
    Some(format!("{}: {wrong}", path.display()))
}

/// Damaged files per reader, so that each takes a second or less.
fn count(reader: &str) -> usize {
    match reader {
        "part" | "resume" | "recipe" => 150,
        "scene" => 1000,
        "csv" | "exr" => 4000,
        "arguments" | "values" => 500,
        _ => 1500,
    }
}

#[test]
fn damaged_files_never_break_a_reader() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    readers::prepare(folder.path());
    std::panic::set_hook(Box::new(|panic| *PANIC.lock().expect("one thread") = panic.to_string()));
    let mut broken = Vec::new();
    for (k, (name, reader)) in (0..).zip(READERS) {
        let begun = seconds();
        let seeds: Vec<Seed> = seeds::of(name, 20_000);
        let mut feed = |bytes: &[u8], what: String| {
            broken.extend(check(reader, bytes, folder.path()).map(|wrong| format!("{name}, {what}: {wrong}")));
        };
        seeds.iter().for_each(|seed| feed(&seed.bytes, seed.name.clone()));
        let mut mutator = Mutator::new(k);
        for i in 0..count(name) {
            let mut bytes = seeds[i % seeds.len()].bytes.clone();
            mutator.damage(&mut bytes, &seeds[i * 7 % seeds.len()].bytes);
            feed(&bytes, format!("damage {i}"));
        }
        println!("{name}: {} seeds, {} damaged files, {:.2} s", seeds.len(), count(name), seconds() - begun);
    }
    drop(std::panic::take_hook());
    assert!(broken.is_empty(), "{} files broke a reader:\n{}", broken.len(), broken.join("\n"));
}

#[test]
#[ignore = "writes the fuzzers' seeds, for fuzz/seeds.sh"]
fn write_the_seeds() {
    let Some(corpus) = std::env::var_os("MIE_CLOUD_CORPUS") else { return };
    for (name, _) in READERS {
        let folder = Path::new(&corpus).join(name);
        std::fs::create_dir_all(&folder).expect("a folder");
        for seed in seeds::of(name, 20_000) {
            std::fs::write(folder.join(&seed.name), &seed.bytes).expect("written");
        }
    }
}
