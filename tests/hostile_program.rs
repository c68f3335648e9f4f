//! Broken and malicious files through the program: how it ends and how much memory it takes. Children are measured one
//! after the other, so this is one test in a file of its own.

#![cfg(target_os = "linux")]

use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use nix::sys::resource::{UsageWho, getrusage};

/// Runs the program; returns what it said.
fn run(arguments: &[&str], folder: &Path) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_mie-cloud"));
    command.args(arguments).current_dir(folder).stdin(Stdio::null());
    command.output().expect("the program starts")
}

/// The largest resident memory of any child so far, bytes.
fn peak_bytes() -> u64 {
    // Linux counts KiB.
    getrusage(UsageWho::RUSAGE_CHILDREN).expect("usage").max_rss() as u64 * 1024
}

fn hostile_files() -> Vec<(u64, PathBuf)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/hostile");
    let entries = std::fs::read_dir(folder).expect("hostile files").map(|entry| entry.expect("entry"));
    let mut files: Vec<_> = entries.map(|entry| (entry.metadata().expect("size").len(), entry.path())).collect();
    // The peak only grows, and so does what is allowed.
    files.sort();
    files
}

/// Expected: exit code 0 or 3, never a signal or a panic, and at most 64 MiB and 20 times the file's size.
#[test]
fn hostile_files_end_soon_in_little_memory() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let files = hostile_files();
    assert_eq!(files.len(), 39);
    for (bytes, path) in files {
        let path = path.to_str().expect("UTF-8");
        let render = ["render", path, "-o", "a.exr", "--resolution", "8x8", "--spp", "1", "--no-cache"];
        for arguments in [&["inspect", path][..], &render] {
            let output = run(arguments, folder.path());
            let said = String::from_utf8_lossy(&output.stderr);
            assert!(matches!(output.status.code(), Some(0 | 3)), "{arguments:?}: {}\n{said}", output.status);
            assert!(!said.contains("panicked"), "{arguments:?}\n{said}");
            if output.status.code() == Some(3) {
                assert!(said.contains(path), "the file is named: {said}");
            }
            let (peak, most) = (peak_bytes(), (64 << 20) + 20 * bytes);
            assert!(peak <= most, "{arguments:?} took {} MiB, {} are allowed", peak >> 20, most >> 20);
        }
    }
}
