//! A value as it stands in a file or on the command line, read as what a key expects.

use serde_json::Value;

use super::folder::Folder;
use crate::suggest::did_you_mean;

/// A value for a key, and the folder from which it names files.
#[derive(Clone, Copy)]
pub struct Given<'a> {
    /// What was given; text where it comes from the command line.
    pub value: &'a Value,
    /// Where files that it names are looked for.
    pub folder: &'a Folder,
}

/// Why a value does not fit.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Misfit {
    /// What is wrong; what is expected stands in the key's description.
    Problem(String),
    /// What is wrong and what is expected, as whoever reads such values says it.
    Sentence(String),
}

impl From<&str> for Misfit {
    fn from(problem: &str) -> Self {
        Self::Problem(problem.into())
    }
}

/// The result of reading a value.
pub type Fit<T> = Result<T, Misfit>;

impl<'a> Given<'a> {
    /// The same place, another value.
    pub fn with<'b>(&self, value: &'b Value) -> Given<'b>
    where
        'a: 'b,
    {
        Given { value, folder: self.folder }
    }

    /// A finite number; text is read as one.
    pub fn number(&self) -> Fit<f64> {
        let number = match self.value {
            Value::Number(number) => number.as_f64(),
            Value::String(text) => text.trim().parse().ok(),
            _ => None,
        };
        number.filter(|n| n.is_finite()).ok_or_else(|| "is not a finite number".into())
    }

    /// A number with `low <= number <= high`.
    pub fn within(&self, low: f64, high: f64) -> Fit<f64> {
        let number = self.number()?;
        if (low..=high).contains(&number) { Ok(number) } else { Err("is out of range".into()) }
    }

    /// A number with `0 < number <= high`.
    pub fn positive(&self, high: f64) -> Fit<f64> {
        let number = self.within(0.0, high)?;
        if number > 0.0 { Ok(number) } else { Err("is out of range".into()) }
    }

    /// A whole number in a range.
    pub fn whole(&self, low: u32, high: u32) -> Fit<u32> {
        let number = self.within(low.into(), high.into())?;
        // Within u32, so the conversion is exact for whole numbers.
        if number.fract() == 0.0 { Ok(number as u32) } else { Err("is not a whole number".into()) }
    }

    /// Text; numbers are taken as they are written.
    pub fn text(&self) -> Fit<String> {
        match self.value {
            Value::String(text) => Ok(text.clone()),
            Value::Number(number) => Ok(number.to_string()),
            _ => Err("is not text".into()),
        }
    }

    /// A yes or no: `true`, `false`, `on`, `off`, 1, 0 (Blender stores truth as an integer).
    pub fn truth(&self) -> Fit<Truth> {
        match self.value {
            Value::Bool(true) => Ok(Truth::Yes),
            Value::Bool(false) => Ok(Truth::No),
            _ => match self.text()?.trim() {
                "true" | "on" | "1" | "1.0" => Ok(Truth::Yes),
                "false" | "off" | "0" | "0.0" => Ok(Truth::No),
                _ => Err(self.no_word("is neither true nor false", ["true", "false", "on", "off"])),
            },
        }
    }

    /// The misfit of a text that is none of the words that are accepted here, with the one that was meant.
    pub fn no_word<'w>(&self, problem: &str, words: impl IntoIterator<Item = &'w str>) -> Misfit {
        let text = self.value.as_str().unwrap_or_default().trim();
        Misfit::Problem(format!("{problem}{}", did_you_mean(text, words)))
    }

    /// A list: an array, or text divided at commas.
    pub fn list(&self) -> Fit<Vec<Value>> {
        match self.value {
            Value::Array(items) => Ok(items.clone()),
            Value::String(text) => Ok(text.split(',').map(|item| Value::String(item.trim().into())).collect()),
            _ => Err("is not a list".into()),
        }
    }

    /// Reads text by one of the parsers of `optics`, which asks for the files that it names.
    pub fn parse<T, E: std::fmt::Display>(
        &self,
        parse: impl Fn(&str, crate::optics::ReadText) -> Result<T, E>,
    ) -> Fit<T> {
        let folder = self.folder;
        parse(&self.text()?, &|name: &str| folder.read_text(name)).map_err(|e| Misfit::Sentence(e.to_string()))
    }
}

/// A yes or no.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Truth {
    Yes,
    No,
}
