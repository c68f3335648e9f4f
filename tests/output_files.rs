//! Output files: a failed write leaves the old file, and places where no file can be are named before any work.

use std::fs;
use std::io::{self, Write};
use std::path::Path;

use mie_cloud::image::file::{FileError, check_writable, write_atomically};
use mie_cloud::image::png::write_preview;
use mie_cloud::image::{Existing, Picture};

fn write_text(path: &Path, existing: Existing, text: &str) -> Result<(), FileError> {
    write_atomically(path, existing, |writer| writer.write_all(text.as_bytes()))
}

fn names_in(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> =
        fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

#[test]
fn a_failed_write_leaves_the_old_file_and_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.txt");
    write_text(&path, Existing::Replace, "old").unwrap();
    let full = |writer: &mut dyn Write| {
        writer.write_all(&[0; 100_000])?;
        Err(io::Error::from(io::ErrorKind::StorageFull))
    };
    assert!(matches!(write_atomically(&path, Existing::Replace, full), Err(FileError::Write { .. })));
    let panicked = std::panic::catch_unwind(|| {
        write_atomically(&path, Existing::Replace, |_| panic!("a bug in the writer, for this test"))
    });
    assert!(panicked.is_err());
    assert_eq!(fs::read_to_string(&path).unwrap(), "old");
    assert_eq!(names_in(folder.path()), ["a.txt"]);
    write_text(&path, Existing::Replace, "new").unwrap();
    assert_eq!(fs::read_to_string(&path).unwrap(), "new");
}

#[test]
fn a_file_that_must_be_kept_is_kept() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.txt");
    write_text(&path, Existing::Keep, "old").unwrap();
    assert!(matches!(write_text(&path, Existing::Keep, "new"), Err(FileError::Exists(_))));
    assert!(matches!(check_writable(&path, Existing::Keep), Err(FileError::Exists(_))));
    // A file that appears while the new one is being written is kept too.
    let late = folder.path().join("late.txt");
    let result = write_atomically(&late, Existing::Keep, |writer| {
        fs::write(&late, "came first")?;
        writer.write_all(b"came second")
    });
    assert!(matches!(result, Err(FileError::Exists(_))));
    assert_eq!(fs::read_to_string(&late).unwrap(), "came first");
    assert_eq!(fs::read_to_string(&path).unwrap(), "old");
    assert_eq!(names_in(folder.path()), ["a.txt", "late.txt"]);
}

#[test]
fn places_where_no_file_can_be_are_named_before_any_work() {
    let folder = tempfile::tempdir().unwrap();
    let missing = folder.path().join("no/such/a.exr");
    for existing in [Existing::Replace, Existing::Keep] {
        assert!(matches!(check_writable(folder.path(), existing), Err(FileError::IsFolder(_))));
        assert!(matches!(check_writable(&missing, existing), Err(FileError::NoFolder { .. })));
        assert!(matches!(check_writable(Path::new(""), existing), Err(FileError::NoName(_))));
        assert!(matches!(check_writable(&folder.path().join("new/"), existing), Err(FileError::NoName(_))));
        let under_a_file = folder.path().join("file");
        fs::write(&under_a_file, "").unwrap();
        assert!(matches!(check_writable(&under_a_file.join("a.exr"), existing), Err(FileError::NoFolder { .. })));
    }
    let message = check_writable(&missing, Existing::Replace).unwrap_err().to_string();
    assert!(message.contains("a.exr") && message.contains("create it first"), "{message}");
    check_writable(&folder.path().join("a.exr"), Existing::Keep).unwrap();
    assert_eq!(names_in(folder.path()), ["file"], "a check leaves nothing behind");
}

#[cfg(unix)]
#[test]
fn links_are_followed_and_permissions_kept() {
    use std::os::unix::fs::{PermissionsExt, symlink};
    let folder = tempfile::tempdir().unwrap();
    let (kept, link, dangling) =
        (folder.path().join("real.txt"), folder.path().join("link"), folder.path().join("dangling"));
    fs::write(&kept, "old").unwrap();
    fs::set_permissions(&kept, fs::Permissions::from_mode(0o640)).unwrap();
    symlink("real.txt", &link).unwrap();
    symlink("made.txt", &dangling).unwrap();
    write_text(&link, Existing::Replace, "new").unwrap();
    write_text(&dangling, Existing::Keep, "made").unwrap();
    assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
    assert_eq!(fs::read_to_string(&kept).unwrap(), "new");
    assert_eq!(fs::metadata(&kept).unwrap().permissions().mode() & 0o777, 0o640);
    assert_eq!(fs::read_to_string(folder.path().join("made.txt")).unwrap(), "made");
    fs::set_permissions(&kept, fs::Permissions::from_mode(0o440)).unwrap();
    assert!(matches!(write_text(&link, Existing::Replace, "newer"), Err(FileError::ReadOnly(_))));
    symlink("round", folder.path().join("round")).unwrap();
    assert!(matches!(check_writable(&folder.path().join("round"), Existing::Replace), Err(FileError::LinkLoop(_))));
}

#[cfg(target_os = "linux")]
#[test]
fn devices_are_written_directly_and_unwritable_folders_named() {
    write_text(Path::new("/dev/null"), Existing::Keep, "text").unwrap();
    let full = write_text(Path::new("/dev/full"), Existing::Replace, "text");
    assert!(matches!(&full, Err(FileError::Write { source, .. }) if source.kind() == io::ErrorKind::StorageFull));
    // Not even root creates files there.
    let error = check_writable(Path::new("/proc/self/a.exr"), Existing::Replace).unwrap_err();
    assert!(matches!(error, FileError::Folder { .. }));
}

#[test]
fn a_preview_is_a_png_with_the_pictures_shape_and_the_same_bytes_each_time() {
    let folder = tempfile::tempdir().unwrap();
    let mut picture = Picture::new(30, 20);
    for (name, factor) in [("R", 0.5), ("G", 0.6), ("B", 0.8)] {
        picture.push(name, (0..600).map(|index| factor * (index % 30) as f32).collect());
    }
    let [first, second] = ["a.png", "b.png"].map(|name| {
        let path = folder.path().join(name);
        write_preview(&path, &picture, Existing::Keep).unwrap();
        fs::read(path).unwrap()
    });
    assert!(first == second);
    assert_eq!(first[16..24], [0, 0, 0, 30, 0, 0, 0, 20], "width and height in IHDR");
}
