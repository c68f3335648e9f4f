//! Words to the user, on stderr. Perhaps nobody reads them any more, which is no reason to lose the work.

/// Prints a line, as `eprintln!` does, which would end the program where the line cannot be written.
macro_rules! say {
    ($($part:tt)*) => {{
        use std::io::Write as _;
        let _ = writeln!(std::io::stderr(), $($part)*);
    }};
}

pub(super) use say;
