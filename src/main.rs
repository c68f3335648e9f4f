//! The program: runs the command line and sets the exit code.

#![forbid(unsafe_code)]

use std::process::ExitCode;

fn main() -> ExitCode {
    mie_cloud::cli::run(std::env::args_os())
}
