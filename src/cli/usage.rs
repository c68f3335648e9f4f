//! Errors of usage as clap words them, with what it leaves out: which commands and flags there are, and which was meant.

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

/// The same error; where it is a flag that was cut short, with all flags that begin so.
pub fn with_flags(mut error: Error, arguments: &[OsString]) -> Error {
    let Some(ContextValue::String(word)) = error.get(ContextKind::InvalidArg).cloned() else { return error };
    let Some(begun) = word.strip_prefix("--").filter(|begun| begun.len() > 1) else { return error };
    if error.kind() != ErrorKind::UnknownArgument {
        return error;
    }
    let program = Cli::command();
    let longs = innermost(&program, arguments).get_arguments().filter_map(|argument| argument.get_long());
    let meant: Vec<String> = longs.filter(|long| long.starts_with(begun)).map(|long| format!("--{long}")).collect();
    if !meant.is_empty() {
        error.insert(ContextKind::SuggestedArg, ContextValue::Strings(meant));
    }
    error
}

/// The same error; where two flags both say when a picture is done, with what may have been meant.
pub fn with_conflicts(mut error: Error) -> Error {
    let Some(ContextValue::String(flag)) = error.get(ContextKind::InvalidArg).cloned() else { return error };
    let other = match error.get(ContextKind::PriorArg) {
        Some(ContextValue::String(other)) => other.clone(),
        Some(ContextValue::Strings(others)) => others.join(" "),
        _ => return error,
    };
    let is_goal =
        |flags: &str| ["--spp", "--noise", "--samples", "--accuracy"].iter().any(|goal| flags.starts_with(goal));
    if error.kind() == ErrorKind::ArgumentConflict && is_goal(&flag) && is_goal(&other) {
        let accuracy = [&flag, &other].iter().any(|flags| flags.starts_with("--accuracy"));
        let rest =
            if accuracy { "; for tables, bands and effects alone there is --set accuracy.target=LEVEL" } else { "" };
        let tip = format!("each of them says when the picture is done, so that one must be chosen{rest}");
        error.insert(ContextKind::Suggested, ContextValue::StyledStrs(vec![StyledStr::from(tip)]));
    }
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
