//! The files that a render writes, claimed before any work is done: none is the scene, or another one of them.

use std::path::{Path, PathBuf};

use anyhow::anyhow;

use super::args::RenderArgs;
use super::checkpoint;
use super::failure::Failure;
use super::output;
use crate::image::file::{Existing, check_writable};

/// Refuses outputs that cannot be written, or that would replace what is needed.
pub fn check_outputs(args: &RenderArgs, existing: Existing) -> Result<(), Failure> {
    // Of the scene itself there is more to say than that it is no picture.
    if !same_file(&args.output, &args.scene.scene) {
        output::check_kind(&args.output).map_err(Failure::usage)?;
    }
    let outputs: Vec<(&str, &PathBuf)> =
        [("--output", Some(&args.output)), ("--preview", args.preview.as_ref()), ("--stats", args.stats.as_ref())]
            .into_iter()
            .chain([("--checkpoint", args.checkpoint.as_ref())])
            .filter_map(|(flag, path)| path.map(|path| (flag, path)))
            .collect();
    for (i, (flag, path)) in outputs.iter().enumerate() {
        // A checkpoint is there to be replaced.
        let existing = if *flag == "--checkpoint" { Existing::Replace } else { existing };
        check_writable(path, existing).map_err(|error| Failure::other(anyhow::Error::new(error).context(*flag)))?;
        if same_file(path, &args.scene.scene) {
            return Err(Failure::usage(anyhow!("{flag} {}: is the scene itself; name another file", path.display())));
        }
        if *flag != "--checkpoint" && args.resume.as_ref().is_some_and(|resume| same_file(path, resume)) {
            return Err(Failure::usage(anyhow!(
                "{flag} {}: is the checkpoint to go on from; name another file",
                path.display()
            )));
        }
        if let Some((other, _)) = outputs[..i].iter().find(|(_, earlier)| names_same_file(earlier, path)) {
            let error = anyhow!("{other} and {flag} both name {}; give each a file of its own", path.display());
            return Err(Failure::usage(error));
        }
    }
    args.checkpoint.iter().try_for_each(|path| checkpoint::check_kept(path, args.resume.as_deref()))
}

/// Whether two outputs, which need not exist yet, are one file. Devices such as `/dev/null` may be named twice.
pub fn names_same_file(a: &Path, b: &Path) -> bool {
    let place = |path: &Path| {
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        folder.canonicalize().ok().zip(path.file_name().map(ToOwned::to_owned))
    };
    let is_device = a.metadata().is_ok_and(|metadata| !metadata.is_file());
    !is_device && (same_file(a, b) || (place(a).is_some() && place(a) == place(b)))
}

fn same_file(a: &Path, b: &Path) -> bool {
    matches!((a.canonicalize(), b.canonicalize()), (Ok(a), Ok(b)) if a == b)
}
