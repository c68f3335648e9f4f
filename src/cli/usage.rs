//! Errors of usage as clap words them, with what it leaves out: which commands there are, and which was meant.

use std::ffi::OsString;

use clap::builder::StyledStr;
use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{Command, CommandFactory, Error};

use super::args::Cli;
use super::manual::names;
use crate::suggest::closest;

/// The same error; where it is a command that does not exist, with the one that was meant and all there are.
pub fn with_commands(mut error: Error, arguments: &[OsString]) -> Error {
    let Some(ContextValue::String(word)) = error.get(ContextKind::InvalidSubcommand).cloned() else { return error };
    if error.kind() != ErrorKind::InvalidSubcommand {
        return error;
    }
    let program = Cli::command();
    let above = innermost(&program, arguments);
    let known: Vec<&str> = names(above).collect();
    if let (Some(name), None) = (closest(&word, known.iter().copied()), error.get(ContextKind::SuggestedSubcommand)) {
        let name = ContextValue::Strings(vec![name.to_owned()]);
        error.insert(ContextKind::SuggestedSubcommand, name);
    }
    let all = match known.as_slice() {
        [] => format!("`{}` has no commands of its own", above.get_name()),
        _ => format!("the commands are {}", known.join(", ")),
    };
    let tips = [rendered(&word), Some(all)].into_iter().flatten().map(StyledStr::from).collect();
    error.insert(ContextKind::Suggested, ContextValue::StyledStrs(tips));
    error
}

/// What whoever names a scene where a command belongs may have meant.
fn rendered(word: &str) -> Option<String> {
    let is_scene = [".gltf", ".glb"].iter().any(|ending| word.to_lowercase().ends_with(ending));
    is_scene.then(|| format!("to render it: mie-cloud render {word} -o picture.exr"))
}

/// The command below which the unknown one was looked for; `help bench x` looks below `bench`.
fn innermost<'a>(program: &'a Command, arguments: &[OsString]) -> &'a Command {
    let words = arguments.iter().skip(1).filter_map(|word| word.to_str()).filter(|word| *word != "help");
    let mut command = program;
    for word in words {
        match command.find_subcommand(word) {
            Some(below) => command = below,
            None => break,
        }
    }
    command
}
