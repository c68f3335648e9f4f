//! `mie-cloud mie`: what one sphere or a size distribution does to light.

use super::args::MieArgs;
use super::failure::Failure;

/// Runs the command.
pub fn run(_args: &MieArgs) -> Result<u8, Failure> {
    Ok(0)
}
