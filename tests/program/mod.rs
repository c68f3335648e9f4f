//! Runs the program in a folder of its own.

#![allow(dead_code, reason = "each test binary uses a part")]

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use mie_cloud::image::{Picture, exr};
use serde_json::Value;
use tempfile::TempDir;

/// A folder of its own for one test, with a table cache in it.
pub struct Bench {
    folder: TempDir,
}

impl Bench {
    pub fn new() -> Self {
        Self { folder: tempfile::tempdir().expect("a temporary folder") }
    }

    /// With a cloud of 30 parcels, `cloud.glb`, that renders in an instant.
    pub fn with_cloud() -> Self {
        let bench = Self::new();
        bench.ok("generate -o cloud.glb --count 30 --size 2m --optical-depth 1 --distribution mono:r=5um -q \
             --set spectral.mode=rgb --set image.resolution=12x8");
        bench
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub fn write(&self, name: &str, text: &str) -> PathBuf {
        std::fs::write(self.path(name), text).expect("written");
        self.path(name)
    }

    pub fn read(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    pub fn json(&self, name: &str) -> Value {
        serde_json::from_slice(&self.read(name)).expect(name)
    }

    pub fn picture(&self, name: &str) -> Picture {
        exr::read(&self.path(name), exr::Limits::default()).expect(name)
    }

    /// The program in this folder; words are divided by spaces.
    pub fn command(&self, line: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_mie-cloud"));
        command.args(line.split_whitespace()).current_dir(self.folder.path()).stdin(Stdio::null());
        command.env("XDG_CACHE_HOME", self.path("cache"));
        command
    }

    pub fn run(&self, line: &str) -> Output {
        self.command(line).output().expect("the program starts")
    }

    /// Runs a command that must succeed; returns what it printed.
    pub fn ok(&self, line: &str) -> String {
        let output = self.run(line);
        assert_eq!(output.status.code(), Some(0), "{line}\n{}", text(&output.stderr));
        text(&output.stdout)
    }

    /// Runs a command that must fail with the given code; returns what it said. It prints no data and no panic.
    pub fn fails(&self, code: i32, line: &str) -> String {
        let output = self.run(line);
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(code), "{line}\n{said}");
        assert!(said.starts_with("error: ") || said.contains("\nerror: "), "{line}\n{said}");
        assert!(!said.contains("panicked"), "{line}\n{said}");
        assert_eq!(text(&output.stdout), "", "{line}");
        said
    }

    /// Every file here but the cache, with its bytes.
    pub fn files(&self) -> BTreeMap<String, Vec<u8>> {
        let entries = std::fs::read_dir(self.folder.path()).expect("listed").map(|entry| entry.expect("entry"));
        let files = entries.filter(|entry| entry.path().is_file());
        files
            .map(|entry| entry.file_name().to_string_lossy().into_owned())
            .map(|n| (n.clone(), self.read(&n)))
            .collect()
    }
}

pub fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).expect("UTF-8")
}

pub fn shipped(path: &str) -> String {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path).display().to_string()
}

pub fn assert_says(said: &str, parts: &[&str]) {
    for part in parts {
        assert!(said.contains(part), "`{part}` is not in: {said}");
    }
}
