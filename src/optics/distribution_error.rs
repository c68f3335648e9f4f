//! Why a size distribution was refused.

use thiserror::Error;

use super::csv::CsvError;
use crate::suggest::did_you_mean;
use crate::units::UnitError;

/// The forms of a size distribution.
pub(super) const FORMS: [&str; 5] = ["mono", "gamma", "modgamma", "lognormal", "csv"];

/// A size distribution could not be read.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum DistributionError {
    /// Not a size distribution.
    #[error("`{0}` is not a size distribution{hint}; accepted are mono:r=5um, gamma:reff=6um,veff=0.1, modgamma:alpha=6,gamma=1,rc=4um, lognormal:rg=3um,sigma=0.4 and csv:FILE", hint = did_you_mean(.0, FORMS))]
    Form(String),
    /// A key that the form does not have.
    #[error("size distribution `{form}` has no key `{key}`{hint}; it takes {accepted}", hint = did_you_mean(key, accepted.split(", ")))]
    Key { form: &'static str, key: String, accepted: &'static str },
    /// A key that the form needs.
    #[error("size distribution `{form}` needs the key `{key}`; it takes {accepted}")]
    Missing { form: &'static str, key: &'static str, accepted: &'static str },
    /// A key stands twice.
    #[error("size distribution `{form}`: the key `{key}` stands twice; remove one")]
    Twice { form: &'static str, key: String },
    /// A value is not a number.
    #[error("size distribution, {key}={text}: a number is needed")]
    Number { key: String, text: String },
    /// A length cannot be read.
    #[error("size distribution, key `{key}`: {reason}")]
    Length { key: String, reason: UnitError },
    /// A value is out of range.
    #[error("size distribution: {key} = {value} must lie {accepted}")]
    Range { key: &'static str, value: f64, accepted: &'static str },
    /// No droplets between the limits.
    #[error(
        "size distribution {of}: rmin = {rmin_um} um and rmax = {rmax_um} um hold none of its droplets; both must be above zero and enclose a part of it"
    )]
    Limits { of: String, rmin_um: f64, rmax_um: f64 },
    /// The file is not a numeric CSV.
    #[error(transparent)]
    Csv(#[from] CsvError),
    /// The header names other columns.
    #[error("{0}: the columns must be radius_um,dn_dr")]
    Header(String),
    /// The radii do not increase.
    #[error("{file}, line {line}: radii must lie from 1e-9 to 1e21 um and increase from line to line; sort the rows")]
    Order { file: String, line: usize },
    /// A number of droplets is negative.
    #[error("{file}, line {line}: dn_dr = {value} cannot be negative")]
    Negative { file: String, line: usize, value: f64 },
}
