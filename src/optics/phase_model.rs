//! Which phase function stands for a size bin: exact Mie, or one of the approximations it is compared with.

use std::f64::consts::PI;
use std::fmt;
use std::sync::Arc;

use thiserror::Error;

use super::ReadText;
use super::csv::{CsvError, Row, parse_numeric};
use crate::suggest::did_you_mean;

/// The phase model of a droplet class.
#[derive(Clone, Debug, PartialEq)]
pub enum PhaseModel {
    /// Exact Lorenz-Mie, averaged over the bin.
    Mie,
    /// Henyey-Greenstein; `None` takes the exact asymmetry of the bin.
    HenyeyGreenstein { g: Option<f64> },
    /// Jendersie & d'Eon (2023), a blend fitted to fog droplets of 5..50 um diameter.
    HgDraine,
    /// Rayleigh.
    Rayleigh,
    /// Isotropic.
    Isotropic,
    /// Read from a file, normalised on load.
    Table(Arc<AngleTable>),
}

/// A phase function tabulated over the scattering angle.
#[derive(Clone, Debug, PartialEq)]
pub struct AngleTable {
    /// Where it came from.
    pub name: String,
    /// Scattering angles from 0 to pi, strictly increasing, rad.
    pub theta_rad: Vec<f64>,
    /// Values, >= 0, in any unit.
    pub value: Vec<f64>,
}

/// A phase model could not be read.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum PhaseModelError {
    /// Not a phase model.
    #[error("`{0}` is not a phase model{hint}; accepted are mie, hg, hg:0.85, hg-draine, rayleigh, isotropic and table:FILE.csv", hint = did_you_mean(.0, NAMES))]
    Unknown(String),
    /// The asymmetry is not a number between -1 and 1.
    #[error("phase model hg:{0}: the asymmetry must be a number above -1 and below 1, like hg:0.85")]
    Asymmetry(String),
    /// The file is not a numeric CSV.
    #[error(transparent)]
    Csv(#[from] CsvError),
    /// The angles do not increase.
    #[error("{file}, line {line}: scattering angles must increase from line to line; sort the rows")]
    Order { file: String, line: usize },
    /// The angles do not span 0 to 180 degrees.
    #[error("{file}: scattering angles run from {first} to {last} degrees; they must run from 0 (forward) to 180")]
    Span { file: String, first: f64, last: f64 },
    /// A value is negative.
    #[error("{file}, line {line}: a phase function cannot be negative ({value})")]
    Negative { file: String, line: usize, value: f64 },
    /// All values are zero.
    #[error("{0}: a phase function needs a value above zero")]
    Dark(String),
}

const NAMES: [&str; 6] = ["mie", "hg", "hg-draine", "rayleigh", "isotropic", "table"];

impl PhaseModel {
    /// Reads `mie`, `hg`, `hg:0.85`, `hg-draine`, `rayleigh`, `isotropic` or `table:FILE.csv` (angle_deg,value).
    ///
    /// # Errors
    /// When the text is none of these, |g| >= 1 or the file is defective.
    pub fn parse(text: &str, read: ReadText) -> Result<Self, PhaseModelError> {
        let text = text.trim();
        match text.split_once(':').map(|(name, argument)| (name.trim(), argument.trim())) {
            Some(("hg", g)) => match g.parse() {
                Ok(value) if -1.0 < value && value < 1.0 => Ok(Self::HenyeyGreenstein { g: Some(value) }),
                _ => Err(PhaseModelError::Asymmetry(g.into())),
            },
            Some(("table", file)) => {
                let unreadable = |reason| CsvError::Unreadable { file: file.into(), reason };
                let content = read(file).map_err(unreadable)?;
                Ok(Self::Table(Arc::new(AngleTable::parse(file, &content)?)))
            }
            Some((name, _)) => Err(PhaseModelError::Unknown(name.into())),
            None => Self::named(text).ok_or_else(|| PhaseModelError::Unknown(text.into())),
        }
    }

    fn named(name: &str) -> Option<Self> {
        match name {
            "mie" => Some(Self::Mie),
            "hg" => Some(Self::HenyeyGreenstein { g: None }),
            "hg-draine" => Some(Self::HgDraine),
            "rayleigh" => Some(Self::Rayleigh),
            "isotropic" => Some(Self::Isotropic),
            _ => None,
        }
    }
}

impl fmt::Display for PhaseModel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Mie => f.write_str("mie"),
            Self::HenyeyGreenstein { g: None } => f.write_str("hg"),
            Self::HenyeyGreenstein { g: Some(g) } => write!(f, "hg:{g}"),
            Self::HgDraine => f.write_str("hg-draine"),
            Self::Rayleigh => f.write_str("rayleigh"),
            Self::Isotropic => f.write_str("isotropic"),
            Self::Table(table) => write!(f, "table:{}", table.name),
        }
    }
}

/// How far from 0 and 180 degrees a table may end and still be taken to reach them: rounding in printed radians.
const SPAN_SLACK_DEG: f64 = 1e-6;

impl AngleTable {
    /// Reads the columns angle_deg and value from the text of a CSV file.
    ///
    /// # Errors
    /// When a row is not numbers, angles do not increase from 0 to 180 degrees, or values are negative or all zero.
    pub fn parse(name: &str, text: &str) -> Result<Self, PhaseModelError> {
        let csv = parse_numeric(name, text, 2, 2)?;
        let mut theta_rad: Vec<f64> = csv.rows.iter().map(|row| row.values[0].to_radians()).collect();
        let value: Vec<f64> = csv.rows.iter().map(|row| row.values[1]).collect();
        let end = csv.rows.len() - 1;
        let in_order = |theta_rad: &[f64]| match theta_rad.windows(2).position(|pair| pair[1] <= pair[0]) {
            Some(i) => Err(PhaseModelError::Order { file: name.into(), line: csv.rows[i + 1].line }),
            None => Ok(()),
        };
        in_order(&theta_rad)?;
        if let Some(Row { line, values }) = csv.rows.iter().find(|row| row.values[1] < 0.0) {
            return Err(PhaseModelError::Negative { file: name.into(), line: *line, value: values[1] });
        }
        let (first, last) = (csv.rows[0].values[0], csv.rows[end].values[0]);
        if first.abs() > SPAN_SLACK_DEG || (last - 180.0).abs() > SPAN_SLACK_DEG {
            return Err(PhaseModelError::Span { file: name.into(), first, last });
        }
        // What lies within the slack of the ends may meet them now.
        (theta_rad[0], theta_rad[end]) = (0.0, PI);
        in_order(&theta_rad)?;
        let table = Self { name: name.into(), theta_rad, value };
        if table.value.iter().all(|value| *value == 0.0) {
            return Err(PhaseModelError::Dark(name.into()));
        }
        Ok(table)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Result<PhaseModel, PhaseModelError> {
        PhaseModel::parse(text, &|name| match name {
            "ok.csv" => Ok("# measured\nangle_deg,value\n0,10\n90,1\n180,2\n".into()),
            "short.csv" => Ok("0,1\n170,1\n".into()),
            "back.csv" => Ok("0,1\n90,1\n80,1\n180,1\n".into()),
            "negative.csv" => Ok("0,1\n90,-1\n180,1\n".into()),
            "dark.csv" => Ok("0,0\n180,0\n".into()),
            _ => Err("no such file".into()),
        })
    }

    #[test]
    fn models_are_read_back() {
        for text in ["mie", "hg", "hg:0.85", "hg:-0.9999", "hg-draine", "rayleigh", "isotropic", "table:ok.csv"] {
            assert_eq!(parse(text).expect(text).to_string(), text);
        }
    }

    #[test]
    fn what_lies_outside_a_models_range_is_refused() {
        use PhaseModelError::*;
        for text in ["hg:1", "hg:-1", "hg:NaN", "hg:", "hg:x"] {
            assert!(matches!(parse(text), Err(Asymmetry(_))), "{text}");
        }
        assert!(matches!(parse("table:short.csv"), Err(Span { .. })));
        assert!(matches!(parse("table:back.csv"), Err(Order { line: 3, .. })));
        assert!(matches!(parse("table:negative.csv"), Err(Negative { line: 2, .. })));
        assert!(matches!(parse("table:dark.csv"), Err(Dark(_))));
        assert!(matches!(parse("table:none.csv"), Err(Csv(CsvError::Unreadable { .. }))));
        assert!(parse("raleigh").unwrap_err().to_string().contains("did you mean `rayleigh`"));
    }
}
