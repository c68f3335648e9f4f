//! Why the program ends without doing what was asked, and with which exit code.

use std::fmt;

use crate::excerpt::printable;

/// Exit code for everything that is neither the user's flags nor the scene.
pub const FAILURE: u8 = 1;
/// Exit code for flags that do not make sense.
pub const USAGE: u8 = 2;
/// Exit code for a scene that cannot be read or rendered.
pub const SCENE: u8 = 3;
/// Exit code after an interrupt whose work was saved.
pub const INTERRUPTED: u8 = 130;

/// The system's errors without their numbers, as in `No such file or directory (os error 2)`: the words say it.
fn without_numbers(text: &str) -> String {
    let mut parts = text.split(" (os error ");
    let first = parts.next().unwrap_or_default().to_owned();
    parts.fold(first, |said, part| {
        said + part.trim_start_matches(|c: char| c.is_ascii_digit() || c == '-').strip_prefix(')').unwrap_or(part)
    })
}

/// An error with the exit code of whoever is at fault.
#[derive(Debug)]
pub struct Failure {
    exit_code: u8,
    error: anyhow::Error,
}

impl Failure {
    /// The flags are at fault.
    pub fn usage(error: impl Into<anyhow::Error>) -> Self {
        Self { exit_code: USAGE, error: error.into() }
    }

    /// The scene is at fault.
    pub fn scene(error: impl Into<anyhow::Error>) -> Self {
        Self { exit_code: SCENE, error: error.into() }
    }

    /// Something else went wrong.
    pub fn other(error: impl Into<anyhow::Error>) -> Self {
        Self { exit_code: FAILURE, error: error.into() }
    }

    /// The program's exit code.
    pub fn exit_code(&self) -> u8 {
        self.exit_code
    }

    /// Whether whoever read the output has gone, which is nobody's fault.
    pub fn is_closed_pipe(&self) -> bool {
        // Of stdout, that is: errors of files that were named are of other types.
        self.error.downcast_ref::<std::io::Error>().is_some_and(|e| e.kind() == std::io::ErrorKind::BrokenPipe)
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut said = String::new();
        // Errors of files have words of their own.
        if self.error.is::<std::io::Error>() && self.error.chain().count() == 1 {
            said.push_str("cannot write to stdout");
        }
        for cause in self.error.chain() {
            let text = cause.to_string();
            // Errors that already quote their cause say it once.
            if said.contains(&text) {
                continue;
            }
            if !said.is_empty() {
                said.push_str(": ");
            }
            said.push_str(&text);
        }
        f.write_str(&printable(&without_numbers(&said)))
    }
}

#[cfg(test)]
mod tests {
    use super::without_numbers;

    #[test]
    fn the_systems_words_are_enough() {
        let said = "a.glb: cannot be read (No such file or directory (os error 2)); check the path";
        assert_eq!(without_numbers(said), "a.glb: cannot be read (No such file or directory); check the path");
        assert_eq!(without_numbers("b: No space left on device (os error 28)"), "b: No space left on device");
        assert_eq!(without_numbers("as it is"), "as it is");
    }
}
