//! Which files may be read: a scene's own stay under its folder, the user's are unrestricted; both must be regular files.

use std::cell::RefCell;
use std::collections::BTreeSet;
use std::fs::File;
use std::io::Read;
use std::path::{Component, Path, PathBuf};

/// Text files named by settings (tables of indices, sizes, phases) above this are refused, bytes.
const TEXT_LIMIT_BYTES: u64 = 16 << 20;

/// A place from which files are named. It remembers which were, so that no output replaces one of them.
#[derive(Clone, Debug)]
pub struct Folder {
    place: Place,
    named: RefCell<BTreeSet<PathBuf>>,
}

#[derive(Clone, Debug)]
enum Place {
    /// The folder of a scene file: nothing outside it may be read.
    Scene(PathBuf),
    /// Paths that the user typed: relative to the working folder, unrestricted.
    User,
}

/// Why a file may not be read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Refusal {
    /// Continues the sentence that begins with the file's name.
    pub problem: String,
    /// What to do.
    pub remedy: &'static str,
}

const MOVE_IT: &str = "put the file beside the scene, or embed it as a data: URI or in a .glb";
const CHECK_IT: &str = "check the path, which is relative to the working folder";

impl Folder {
    /// The folder in which a scene file lies.
    pub fn of_scene(scene: &Path) -> Self {
        let folder = scene.parent().filter(|folder| !folder.as_os_str().is_empty());
        Self::at(Place::Scene(folder.unwrap_or(Path::new(".")).to_path_buf()))
    }

    /// Paths that the user types: relative to the working folder, unrestricted.
    pub fn of_user() -> Self {
        Self::at(Place::User)
    }

    fn at(place: Place) -> Self {
        Self { place, named: RefCell::default() }
    }

    /// The files that were found here so far, each once.
    pub fn files(&self) -> Vec<PathBuf> {
        self.named.borrow().iter().cloned().collect()
    }

    /// Finds a file by its (already decoded) relative path.
    ///
    /// # Errors
    /// When the path is absolute or leaves the folder, also by a symbolic link, or is no regular file.
    pub fn resolve(&self, name: &str) -> Result<PathBuf, Refusal> {
        let path = match &self.place {
            Place::User => PathBuf::from(name),
            Place::Scene(folder) => inside(folder, name)?,
        };
        let info = std::fs::metadata(&path).map_err(|e| self.remedied(unreadable(e)))?;
        if !info.is_file() {
            return Err(self.remedied(refusal("is not a regular file")));
        }
        if !self.named.borrow().contains(&path) {
            self.named.borrow_mut().insert(path.clone());
        }
        Ok(path)
    }

    /// What the user typed need not lie beside the scene.
    fn remedied(&self, refusal: Refusal) -> Refusal {
        match self.place {
            Place::User => Refusal { remedy: CHECK_IT, ..refusal },
            Place::Scene(_) => refusal,
        }
    }

    /// Reads a file of at most `limit_bytes`.
    ///
    /// # Errors
    /// As [`Folder::resolve`], and when the file is larger.
    pub fn read(&self, name: &str, limit_bytes: u64) -> Result<Vec<u8>, Refusal> {
        read_file(&self.resolve(name)?, limit_bytes).map_err(|r| self.remedied(r))
    }

    /// Reads a text file that a setting names, as `optics` asks for it.
    ///
    /// # Errors
    /// Why the file cannot be read, and what to do: continues the sentence that begins with its name.
    pub fn read_text(&self, name: &str) -> Result<String, String> {
        let bytes = self.read(name, TEXT_LIMIT_BYTES).map_err(|r| format!("{}; {}", r.problem, r.remedy))?;
        String::from_utf8(bytes).map_err(|_| "is not UTF-8 text; save it as such".into())
    }

    /// Reads a text file that the user names on a command line: any that can be read, a pipe too, but not without end.
    ///
    /// # Errors
    /// Why the file cannot be read, and what to do: continues the sentence that begins with its name.
    pub fn read_typed_text(&self, name: &str) -> Result<String, String> {
        self.named.borrow_mut().insert(name.into());
        let mut bytes = Vec::new();
        let unreadable = |e: std::io::Error| format!("cannot be read ({e}); {CHECK_IT}");
        let file = File::open(name).map_err(unreadable)?;
        file.take(TEXT_LIMIT_BYTES + 1).read_to_end(&mut bytes).map_err(unreadable)?;
        if bytes.len() as u64 > TEXT_LIMIT_BYTES {
            return Err(format!("has more than {TEXT_LIMIT_BYTES} bytes, the most that is read"));
        }
        String::from_utf8(bytes).map_err(|_| "is not UTF-8 text; save it as such".into())
    }
}

fn refusal(problem: impl Into<String>) -> Refusal {
    Refusal { problem: problem.into(), remedy: MOVE_IT }
}

/// Joins a relative path to the scene's folder, following links, and refuses whatever ends up elsewhere.
fn inside(folder: &Path, name: &str) -> Result<PathBuf, Refusal> {
    if name.is_empty() || name.contains('\0') {
        return Err(refusal("is not a file name"));
    }
    for component in Path::new(name).components() {
        match component {
            Component::Normal(_) | Component::CurDir => {}
            Component::ParentDir => return Err(refusal("leaves the scene's folder with `..`")),
            Component::RootDir | Component::Prefix(_) => return Err(refusal("is an absolute path")),
        }
    }
    let real = |path: &Path| std::fs::canonicalize(path).map_err(|e| refusal(format!("cannot be read ({e})")));
    let (folder, path) = (real(folder)?, real(&folder.join(name))?);
    if path.starts_with(&folder) { Ok(path) } else { Err(refusal("is a link that leaves the scene's folder")) }
}

/// Reads a regular file whose size has been checked first; a file that grows meanwhile is cut at its size.
///
/// # Errors
/// When it cannot be read, is no regular file or is larger.
pub fn read_file(path: &Path, limit_bytes: u64) -> Result<Vec<u8>, Refusal> {
    let (file, size_bytes) = open_regular(path)?;
    if size_bytes > limit_bytes {
        return Err(refusal(format!("has {size_bytes} bytes; at most {limit_bytes} are read")));
    }
    take(file, size_bytes)
}

/// Reads the first `at_most_bytes` of a regular file, or all of it if it is shorter.
///
/// # Errors
/// When it cannot be read or is no regular file.
pub fn read_start(path: &Path, at_most_bytes: u64) -> Result<Vec<u8>, Refusal> {
    let (file, size_bytes) = open_regular(path)?;
    take(file, size_bytes.min(at_most_bytes))
}

fn unreadable(e: std::io::Error) -> Refusal {
    refusal(format!("cannot be read ({e})"))
}

fn open_regular(path: &Path) -> Result<(File, u64), Refusal> {
    let file = File::open(path).map_err(unreadable)?;
    let info = file.metadata().map_err(unreadable)?;
    if info.is_file() { Ok((file, info.len())) } else { Err(refusal("is not a regular file")) }
}

fn take(file: File, size_bytes: u64) -> Result<Vec<u8>, Refusal> {
    let mut bytes = Vec::new();
    let size = usize::try_from(size_bytes).unwrap_or(usize::MAX);
    bytes.try_reserve_exact(size).map_err(|_| refusal("does not fit into memory"))?;
    file.take(size_bytes).read_to_end(&mut bytes).map_err(unreadable)?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_scene_reads_only_below_its_folder() -> Result<(), Box<dyn std::error::Error>> {
        let dir = tempfile::tempdir()?;
        let home = dir.path().join("scene");
        std::fs::create_dir_all(home.join("sub"))?;
        std::fs::write(dir.path().join("outside"), "x")?;
        std::fs::write(home.join("sub/a.bin"), "abc")?;
        let folder = Folder::of_scene(&home.join("scene.gltf"));
        assert_eq!(folder.read("sub/a.bin", 3).as_deref(), Ok(b"abc".as_slice()));
        assert!(folder.read("sub/a.bin", 2).is_err());
        for bad in ["../outside", "sub/../../outside", "/etc/hostname", "sub", "", "missing.bin", "a\0b"] {
            assert!(folder.read(bad, 1000).is_err(), "{bad}");
        }
        assert_eq!(folder.files(), [home.canonicalize()?.join("sub/a.bin")]);
        Ok(())
    }

    #[cfg(unix)]
    #[test]
    fn links_that_leave_the_folder_and_devices_are_refused() -> Result<(), Box<dyn std::error::Error>> {
        let dir = tempfile::tempdir()?;
        let home = dir.path().join("scene");
        std::fs::create_dir_all(&home)?;
        std::fs::write(dir.path().join("outside"), "x")?;
        std::os::unix::fs::symlink(dir.path().join("outside"), home.join("link"))?;
        std::os::unix::fs::symlink("/dev/zero", home.join("zero"))?;
        let folder = Folder::of_scene(&home.join("scene.gltf"));
        assert!(folder.read("link", 10).is_err_and(|r| r.problem.contains("link")));
        assert!(folder.read("zero", 10).is_err());
        assert!(Folder::of_user().read("/dev/zero", 10).is_err_and(|r| r.problem.contains("regular")));
        Ok(())
    }
}
