//! A warning is a value: what was noticed, and what to do about it.

use std::fmt;

/// Something the user should know that does not stop the program.
#[derive(Clone, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Warning {
    /// What was noticed, naming the element of the scene.
    pub what: String,
    /// What to do about it, naming the flag or key; empty where nothing need be done.
    pub remedy: String,
}

impl Warning {
    /// A warning that says what was noticed and what to do.
    pub fn new(what: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self { what: what.into(), remedy: remedy.into() }
    }
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.remedy.is_empty() { f.write_str(&self.what) } else { write!(f, "{}; {}", self.what, self.remedy) }
    }
}
