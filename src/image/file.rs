//! Output files that appear whole or not at all: written beside their place under another name, then renamed.

use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, ErrorKind, Write};
use std::path::{Path, PathBuf};

use thiserror::Error;

/// What to do with a file that is already there.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Existing {
    /// Replace it once the new one is complete.
    #[default]
    Replace,
    /// Keep it, and report an error.
    Keep,
}

/// An output file could not be written.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum FileError {
    /// The path names no file.
    #[error("{0} does not name a file; write folder/name.exr")]
    NoName(PathBuf),
    /// A folder is in the place of the file.
    #[error("{0} is a folder; name a file inside it")]
    IsFolder(PathBuf),
    /// The disk takes no file of such a name.
    #[error("{0}: the disk takes no name like this, or none as long; choose a shorter one")]
    BadName(PathBuf),
    /// The folder is missing.
    #[error("the folder {folder} of {path} does not exist; create it first")]
    NoFolder { path: PathBuf, folder: PathBuf },
    /// The file is there and must be kept.
    #[error("{0} exists; choose another name, or allow it to be replaced")]
    Exists(PathBuf),
    /// The file that is there may not be written.
    #[error("{0} is read-only; make it writable or choose another name")]
    ReadOnly(PathBuf),
    /// Symbolic links go round in a circle.
    #[error("{0} is a symbolic link that leads back to itself; remove it or choose another name")]
    LinkLoop(PathBuf),
    /// The folder does not take a new file.
    #[error("cannot create a file in {folder}: {source}; choose a folder that can be written")]
    Folder { folder: PathBuf, source: io::Error },
    /// Writing failed; the previous file is as it was.
    #[error("cannot write {path}: {source}")]
    Write { path: PathBuf, source: io::Error },
}

/// Where the bytes go.
enum Target {
    /// A device or pipe, written directly.
    Stream(PathBuf),
    /// A file with its folder, links resolved.
    File { path: PathBuf, folder: PathBuf },
}

/// Checks, before any work is done, that a file can be written at `path`. Leaves nothing behind.
///
/// # Errors
/// When the folder is missing or cannot be written, a folder is in the file's place, or the file must be kept.
pub fn check_writable(path: &Path, existing: Existing) -> Result<(), FileError> {
    if let Target::File { path, folder } = find_target(path)? {
        check_existing(&path, existing)?;
        Temporary::create(&folder)?;
    }
    Ok(())
}

/// Writes a file by `write`, whole or not at all.
///
/// Bytes go to a temporary file in the same folder, are flushed to the disk, and take the name in one step, so that
/// on any failure the previous file is as it was. Links are followed. Devices and pipes are written directly.
///
/// # Errors
/// As [`check_writable`], and when `write` or the disk fails.
///
/// ```
/// use mie_cloud::image::file::{Existing, write_atomically};
/// let path = std::env::temp_dir().join("mie-cloud-doc.txt");
/// write_atomically(&path, Existing::Replace, |writer| writeln!(writer, "done"))?;
/// assert_eq!(std::fs::read_to_string(&path)?, "done\n");
/// # std::fs::remove_file(&path)?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn write_atomically(
    path: &Path,
    existing: Existing,
    write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<(), FileError> {
    let failed = |source| FileError::Write { path: path.into(), source };
    match find_target(path)? {
        Target::Stream(stream) => {
            let file = OpenOptions::new().write(true).open(stream).map_err(failed)?;
            write_all(file, write).map(drop).map_err(failed)
        }
        Target::File { path: target, folder } => {
            let previous = check_existing(&target, existing)?;
            let (temporary, file) = Temporary::create(&folder)?;
            let file = write_all(file, write).map_err(failed)?;
            if let Some(previous) = previous {
                file.set_permissions(previous.permissions()).map_err(failed)?;
            }
            file.sync_all().map_err(failed)?;
            drop(file);
            temporary.publish(&target, existing).map_err(|source| match source.kind() {
                ErrorKind::AlreadyExists if existing == Existing::Keep => FileError::Exists(path.into()),
                _ => failed(source),
            })?;
            sync_folder(&folder);
            Ok(())
        }
    }
}

fn write_all(file: File, write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<File> {
    let mut writer = BufWriter::new(file);
    write(&mut writer)?;
    writer.into_inner().map_err(io::IntoInnerError::into_error)
}

/// Follows links, and tells files from devices.
fn find_target(path: &Path) -> Result<Target, FileError> {
    match fs::metadata(path) {
        Ok(metadata) if metadata.is_dir() => return Err(FileError::IsFolder(path.into())),
        Ok(metadata) if !metadata.is_file() => return Ok(Target::Stream(path.into())),
        _ => {}
    }
    let resolved = follow_links(path)?;
    // `a/` has the file name `a`: the text tells that a folder was meant.
    let ends_open =
        path.as_os_str().as_encoded_bytes().last().is_some_and(|last| std::path::is_separator(*last as char));
    if resolved.file_name().is_none() || ends_open {
        return Err(FileError::NoName(path.into()));
    }
    let folder = match resolved.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder.to_path_buf(),
        _ => PathBuf::from("."),
    };
    if !folder.is_dir() {
        return Err(FileError::NoFolder { path: path.into(), folder });
    }
    Ok(Target::File { path: resolved, folder })
}

/// Resolves links at the end of the path one by one, so that a link to a file yet to be made works too.
pub(crate) fn follow_links(path: &Path) -> Result<PathBuf, FileError> {
    /// Linux gives up after as many (path_resolution(7)).
    const MOST_LINKS: usize = 40;
    let mut resolved = path.to_path_buf();
    for _ in 0..MOST_LINKS {
        match fs::read_link(&resolved) {
            Ok(next) => resolved = resolved.parent().unwrap_or(Path::new("")).join(next),
            Err(_) => return Ok(resolved),
        }
    }
    Err(FileError::LinkLoop(path.into()))
}

/// Whether the file that is there may be replaced; its metadata if there is one.
fn check_existing(path: &Path, existing: Existing) -> Result<Option<fs::Metadata>, FileError> {
    match fs::metadata(path) {
        Ok(_) if existing == Existing::Keep => Err(FileError::Exists(path.into())),
        Ok(metadata) if metadata.permissions().readonly() => Err(FileError::ReadOnly(path.into())),
        Ok(metadata) => Ok(Some(metadata)),
        Err(error) if error.kind() == ErrorKind::InvalidFilename => Err(FileError::BadName(path.into())),
        Err(_) => Ok(None),
    }
}

/// Makes the new name last through a power cut where the system can; the file itself is already safe.
fn sync_folder(folder: &Path) {
    if let Ok(folder) = File::open(folder) {
        let _ = folder.sync_all();
    }
}

/// A file under a name of its own, removed unless it is published.
struct Temporary {
    path: PathBuf,
}

impl Temporary {
    /// Creates a file that did not exist, named after the process.
    fn create(folder: &Path) -> Result<(Self, File), FileError> {
        /// Files of one process at a time are few; leftovers of a killed one with the same number may be in the way.
        const MOST_TRIES: u32 = 10_000;
        let failed = |source| FileError::Folder { folder: folder.into(), source };
        for number in 0..MOST_TRIES {
            let path = folder.join(format!(".mie-cloud-{}-{number}.tmp", std::process::id()));
            match OpenOptions::new().write(true).create_new(true).open(&path) {
                Ok(file) => return Ok((Self { path }, file)),
                Err(error) if error.kind() == ErrorKind::AlreadyExists => {}
                Err(error) => return Err(failed(error)),
            }
        }
        Err(failed(io::Error::new(ErrorKind::AlreadyExists, "it is full of temporary files `.mie-cloud-*.tmp`")))
    }

    /// Gives the file its name in one step.
    fn publish(self, target: &Path, existing: Existing) -> io::Result<()> {
        match existing {
            Existing::Replace => fs::rename(&self.path, target),
            Existing::Keep => self.publish_new(target),
        }
    }

    /// A link fails where a file exists, without a gap between looking and writing. File systems without links get an
    /// empty file first, which claims the name just as exclusively.
    fn publish_new(&self, target: &Path) -> io::Result<()> {
        match fs::hard_link(&self.path, target) {
            Err(error) if error.kind() != ErrorKind::AlreadyExists => {
                OpenOptions::new().write(true).create_new(true).open(target)?;
                fs::rename(&self.path, target).inspect_err(|_| drop(fs::remove_file(target)))
            }
            result => result,
        }
    }
}

impl Drop for Temporary {
    fn drop(&mut self) {
        // After a rename there is nothing left to remove.
        let _ = fs::remove_file(&self.path);
    }
}
