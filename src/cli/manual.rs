//! `mie-cloud completions` and `mie-cloud man`: what shells and `man` know of the arguments, from their definition.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use anyhow::{Context, anyhow};
use clap::{Args, CommandFactory};
use clap_complete::Shell;
use clap_mangen::Man;

use super::args::Cli;
use super::failure::Failure;
use super::say::say;
use crate::image::file::{Existing, write_atomically};
use crate::suggest::no_such;

#[derive(Debug, Args)]
pub struct CompletionsArgs {
    /// Shell that the script is for
    pub shell: Shell,
}

#[derive(Debug, Args)]
pub struct ManArgs {
    /// Command whose page is printed, e.g. `render` or `bench accuracy` [default: the program's own page]
    #[arg(value_name = "COMMAND")]
    pub command: Vec<String>,
    /// Writes all pages into this folder instead, which must be there
    #[arg(long, value_name = "FOLDER", conflicts_with = "command")]
    pub all: Option<PathBuf>,
}

/// Prints a completion script.
pub fn completions(args: &CompletionsArgs) -> Result<u8, Failure> {
    // By way of memory, since clap_complete ends the program where a pipe is closed.
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut Cli::command(), "mie-cloud", &mut script);
    print(&script)
}

/// Prints one manual page, or writes all of them.
pub fn man(args: &ManArgs) -> Result<u8, Failure> {
    let program = built();
    match &args.all {
        Some(folder) => {
            let n = write_all(&program, folder).map_err(Failure::other)?;
            say!("{}: {n} pages", folder.display());
            Ok(0)
        }
        None => print(&page(find(&program, &args.command)?).map_err(Failure::other)?),
    }
}

/// The definition, with the full names of all commands in it.
fn built() -> clap::Command {
    let mut program = Cli::command();
    program.build();
    program
}

/// Commands that have pages: all but `help`.
fn pages(command: &clap::Command) -> impl Iterator<Item = &clap::Command> {
    command.get_subcommands().filter(|command| command.get_name() != "help")
}

/// Their names.
pub fn names(command: &clap::Command) -> impl Iterator<Item = &str> {
    pages(command).map(clap::Command::get_name)
}

fn find<'a>(program: &'a clap::Command, path: &[String]) -> Result<&'a clap::Command, Failure> {
    path.iter().try_fold(program, |command, name| {
        command.find_subcommand(name).ok_or_else(|| {
            Failure::usage(match names(command).next() {
                Some(_) => anyhow!(no_such("command", name, names(command))),
                None => anyhow!("there is no command `{name}`; `{}` has no commands of its own", command.get_name()),
            })
        })
    })
}

/// A page as roff.
fn page(command: &clap::Command) -> io::Result<Vec<u8>> {
    let full_name = file_stem(command);
    let mut page = Vec::new();
    Man::new(command.clone()).title(full_name.to_uppercase()).render(&mut page)?;
    Ok(page)
}

/// `mie-cloud-bench-accuracy` for `mie-cloud bench accuracy`.
fn file_stem(command: &clap::Command) -> String {
    command.get_display_name().unwrap_or(command.get_name()).to_owned()
}

/// Writes the pages of a command and all below it; returns how many.
fn write_all(command: &clap::Command, folder: &Path) -> anyhow::Result<usize> {
    let path = folder.join(format!("{}.1", file_stem(command)));
    let text = page(command).with_context(|| format!("cannot make {}", path.display()))?;
    write_atomically(&path, Existing::Replace, |out| out.write_all(&text))?;
    pages(command).try_fold(1, |n, below| Ok(n + write_all(below, folder)?))
}

fn print(bytes: &[u8]) -> Result<u8, Failure> {
    let mut out = io::stdout().lock();
    out.write_all(bytes).and_then(|()| out.flush()).map_err(Failure::other)?;
    Ok(0)
}
