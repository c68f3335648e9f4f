//! The command line: arguments in, exit code out. Data go to stdout, everything else to stderr.

mod args;
mod bench_accuracy;
mod bench_args;
mod bench_effects;
mod bench_particles;
mod busy;
mod checkpoint;
mod claims;
mod diff;
mod diff_report;
mod effects;
mod failure;
mod foretell;
mod generate;
mod generate_args;
mod help;
mod identity;
mod inspect;
mod inspect_histogram;
mod inspect_json;
mod inspect_light;
mod inspect_report;
mod inspect_sizes;
mod interrupt;
mod job;
mod limits;
mod manual;
mod measured;
mod memory;
mod merge;
mod mie;
mod output;
mod paper;
mod previews;
mod progress;
mod render;
mod say;
mod scene;
mod stats;
mod usage;
mod values;
mod wrapped;

use std::ffi::OsString;
use std::process::ExitCode;

use clap::Parser;

use args::{BenchCommand, Cli, Command};
use failure::Failure;
use say::say;

/// Runs the program with the given arguments (the first is its own name) and returns its exit code: 0 done, 1 failure,
/// 2 usage, 3 the scene is at fault, 130 interrupted after saving.
pub fn run(arguments: impl IntoIterator<Item = OsString>) -> ExitCode {
    let arguments: Vec<OsString> = arguments.into_iter().collect();
    let cli = match Cli::try_parse_from(&arguments) {
        Ok(cli) => cli,
        Err(error) => {
            let error = usage::with_conflicts(usage::with_flags(usage::with_commands(error, &arguments), &arguments));
            // Help and version are not errors.
            let printed = error.print();
            return if error.use_stderr() {
                ExitCode::from(failure::USAGE)
            } else {
                code_of(printed.map(|()| 0).map_err(Failure::other))
            };
        }
    };
    interrupt::outlive_limits_of_files();
    code_of(dispatch(cli.command))
}

/// The exit code, with the failure said if there is one; nobody reading stdout is none.
fn code_of(outcome: Result<u8, Failure>) -> ExitCode {
    match outcome {
        Ok(code) => ExitCode::from(code),
        Err(failure) if failure.is_closed_pipe() => ExitCode::SUCCESS,
        Err(failure) => {
            say!("error: {failure}");
            ExitCode::from(failure.exit_code())
        }
    }
}

/// What [`run`] would return for the arguments, or say on failure, without its saying it: for tests that feed the commands
/// damaged files.
///
/// # Errors
/// The text of the failure.
#[doc(hidden)]
pub fn outcome(arguments: impl IntoIterator<Item = OsString>) -> Result<u8, String> {
    let cli = Cli::try_parse_from(arguments).map_err(|error| error.to_string())?;
    dispatch(cli.command).map_err(|failure| failure.to_string())
}

/// Reads arguments and does nothing, for tests of what is read.
///
/// # Errors
/// The text of the failure; help and version are among them.
#[doc(hidden)]
pub fn understand(arguments: impl IntoIterator<Item = OsString>) -> Result<(), String> {
    Cli::try_parse_from(arguments).map(drop).map_err(|error| error.to_string())
}

fn dispatch(command: Command) -> Result<u8, Failure> {
    match command {
        Command::Render(args) => render::run(&args),
        Command::Generate(args) => with_threads(|| generate::run(&args)),
        Command::Mie(args) => with_threads(|| mie::run(&args)),
        Command::Inspect(args) => with_threads(|| inspect::run(&args)),
        Command::Bench(BenchCommand::Particles(args)) => bench_particles::run(&args),
        Command::Bench(BenchCommand::Effects(args)) => bench_effects::run(&args),
        Command::Bench(BenchCommand::Accuracy(args)) => bench_accuracy::run(&args),
        Command::Diff(args) => with_threads(|| diff::run(&args)),
        Command::Merge(args) => with_threads(|| merge::run(&args)),
        Command::Paper(args) => paper::run(&args),
        Command::Completions(args) => manual::completions(&args),
        Command::Man(args) => manual::man(&args),
    }
}

/// Runs a command that does not choose its threads: if they cannot be started that is an error here, and would be a panic where
/// they are first needed.
fn with_threads(work: impl FnOnce() -> Result<u8, Failure> + Send) -> Result<u8, Failure> {
    render::in_thread_pool(None, work)?
}
