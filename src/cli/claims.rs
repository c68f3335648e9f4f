//! The files that a command writes, claimed before any work is done: none is what it reads, or another one of them.

use std::path::{Path, PathBuf};

use anyhow::anyhow;

use super::args::RenderArgs;
use super::checkpoint;
use super::failure::Failure;
use super::output;
use crate::image::file::{Existing, check_writable, follow_links};

/// What a file that a scene needs is called.
const READ_BY_SCENE: &str = "is read by the scene";

/// Output files, each with its flag.
#[derive(Clone, Debug)]
pub struct Outputs<'a>(Vec<(&'static str, &'a Path)>);

impl<'a> Outputs<'a> {
    /// Those of the flags that were given.
    pub fn new(given: impl IntoIterator<Item = (&'static str, Option<&'a PathBuf>)>) -> Self {
        Self(given.into_iter().filter_map(|(flag, path)| path.map(|path| (flag, path.as_path()))).collect())
    }

    /// Refuses outputs that cannot be written, and two of one name.
    pub fn check(&self, existing: Existing) -> Result<(), Failure> {
        for (i, (flag, path)) in self.0.iter().enumerate() {
            // A checkpoint is there to be replaced.
            let existing = if *flag == "--checkpoint" { Existing::Replace } else { existing };
            check_writable(path, existing).map_err(|error| Failure::other(anyhow::Error::new(error).context(*flag)))?;
            if let Some((other, _)) = self.0[..i].iter().find(|(_, earlier)| names_same_file(earlier, path)) {
                let error = anyhow!("{other} and {flag} both name {}; give each a file of its own", path.display());
                return Err(Failure::usage(error));
            }
        }
        Ok(())
    }

    /// Refuses outputs that would replace an input; `what` it is continues the sentence that begins with its name.
    pub fn spare(&self, what: &str, inputs: impl IntoIterator<Item = impl AsRef<Path>>) -> Result<(), Failure> {
        for input in inputs {
            let hit = self.0.iter().find(|(_, output)| names_same_file(output, input.as_ref()));
            if let Some((flag, output)) = hit {
                return Err(Failure::usage(anyhow!("{flag} {}: {what}; name another file", output.display())));
            }
        }
        Ok(())
    }

    /// Refuses outputs that would replace a scene.
    pub fn spare_scene(&self, scene: &Path) -> Result<(), Failure> {
        self.spare("is the scene itself", [scene])
    }

    /// Refuses outputs that would replace buffers, tables or the background of a scene that has been read.
    pub fn spare_files(&self, files: &[PathBuf]) -> Result<(), Failure> {
        self.spare(READ_BY_SCENE, files)
    }
}

/// What a render writes.
pub fn outputs(args: &RenderArgs) -> Outputs<'_> {
    Outputs::new([
        ("--output", Some(&args.output)),
        ("--preview", args.preview.as_ref()),
        ("--stats", args.stats.as_ref()),
        ("--checkpoint", args.checkpoint.as_ref()),
    ])
}

/// Refuses outputs of a render that cannot be written, or that would replace what is needed.
pub fn check_outputs(args: &RenderArgs, existing: Existing) -> Result<(), Failure> {
    let outputs = outputs(args);
    outputs.spare_scene(&args.scene.scene)?;
    output::check_kind(&args.output).map_err(Failure::usage)?;
    outputs.check(existing)?;
    // The checkpoint may go on in the file that it began in.
    let others = Outputs(outputs.0.iter().filter(|(flag, _)| *flag != "--checkpoint").copied().collect());
    others.spare("is the checkpoint to go on from", &args.resume)?;
    args.checkpoint.iter().try_for_each(|path| checkpoint::check_kept(path, args.resume.as_deref()))
}

/// Whether two files, which need not exist yet, are one. Devices such as `/dev/null` may be named twice.
pub fn names_same_file(a: &Path, b: &Path) -> bool {
    let place = |path: &Path| {
        let path = follow_links(path).ok()?;
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        folder.canonicalize().ok().zip(path.file_name().map(ToOwned::to_owned))
    };
    let is_device = a.metadata().is_ok_and(|metadata| !metadata.is_file());
    !is_device && (same_file(a, b) || (place(a).is_some() && place(a) == place(b)))
}

fn same_file(a: &Path, b: &Path) -> bool {
    matches!((a.canonicalize(), b.canonicalize()), (Ok(a), Ok(b)) if a == b)
}
