//! Feeds a reader in a folder of the process's own.

#[path = "../../../tests/readers/mod.rs"]
pub mod readers;

use std::panic::{AssertUnwindSafe, catch_unwind, set_hook};
use std::path::PathBuf;
use std::sync::{Mutex, OnceLock};

use readers::Reader;

/// Where readers find and write files; in memory where the system has such a folder.
static FOLDER: OnceLock<PathBuf> = OnceLock::new();

/// What the last panic said.
static PANIC: Mutex<String> = Mutex::new(String::new());

/// Runs a reader. The fuzzer's own hook ends the process at every panic; those that the library catches itself, as it does
/// around a decoder of others, are no findings.
pub fn read(reader: Reader, bytes: &[u8]) {
    let folder = FOLDER.get_or_init(|| {
        set_hook(Box::new(|panic| PANIC.lock().unwrap_or_else(|e| e.into_inner()).clone_from(&panic.to_string())));
        let memory = PathBuf::from("/dev/shm");
        let root = if memory.is_dir() { memory } else { std::env::temp_dir() };
        let folder = root.join(format!("mie-cloud-fuzz-{}", std::process::id()));
        readers::prepare(&folder);
        folder
    });
    if catch_unwind(AssertUnwindSafe(|| reader(bytes, folder))).is_err() {
        eprintln!("{}", PANIC.lock().unwrap_or_else(|e| e.into_inner()));
        std::process::abort();
    }
}
