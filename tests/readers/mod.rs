//! One function for everything that is read: it feeds bytes to the reader and panics where a promise is broken.
//!
//! The fuzzers of `fuzz/` and the tests of damaged files share these functions, so that what one finds the other replays.
//! The promises: no panic; an error is short, printable and names its file; what is accepted is finite, in range, and no
//! larger than the bytes can justify.

#![allow(dead_code, reason = "each test binary and each fuzzer uses a part")]

pub mod files;
pub mod pictures;
pub mod scenes;
pub mod tables;
pub mod words;

use std::path::Path;

/// Feeds bytes to a reader; the folder is for files that it needs, and prepared by [`prepare`].
pub type Reader = fn(&[u8], &Path);

/// Every reader, by the name of its fuzzer and of its folders of seeds and kept files.
pub const READERS: [(&str, Reader); 11] = [
    ("scene", scenes::scene),
    ("settings", scenes::settings),
    ("exr", pictures::exr),
    ("diff", pictures::diff),
    ("part", files::part),
    ("resume", files::resume),
    ("table", files::table),
    ("csv", tables::csv),
    ("values", words::values),
    ("arguments", words::arguments),
    ("recipe", words::recipe),
];

/// A buffer and three tables beside the scenes, for them to name.
pub fn prepare(folder: &Path) {
    std::fs::create_dir_all(folder).expect("a folder");
    let write = |name: &str, bytes: &[u8]| std::fs::write(folder.join(name), bytes).expect(name);
    write("b.bin", &[0x3f; 256]);
    write("n.csv", b"wavelength_nm,n,k\n300,1.3,1e-9\n900,1.4,1e-6\n");
    write("p.csv", b"angle_deg,value\n0,10\n90,1\n180,2\n");
    write("r.csv", b"radius_um,dn_dr\n1,0\n5,2\n20,0\n");
}

/// Checks what is said of a defect: it names the file, is not the file itself, and changes no terminal.
pub fn check_message(message: &str, file: &str) {
    const LONGEST: usize = 4000;
    assert!(message.contains(file), "the message does not name {file}: {message:?}");
    assert!(message.len() < LONGEST + file.len(), "the message has {} bytes: {message:.200}", message.len());
    assert!(!message.is_empty());
    let control = message.chars().find(|c| c.is_control() && *c != '\n');
    assert!(control.is_none(), "the message holds {control:?}: {message:?}");
}
