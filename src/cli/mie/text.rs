//! The report for reading: aligned columns, ten digits of the quantities, seven of the functions.

use std::io::{self, Write};

use crate::study::MieReport;
use crate::study::mie_report::{ColumnValues, NORMALIZATION, Quantity, Value};

/// Longest line of the closing note.
const WIDTH: usize = 100;

/// Writes the report.
pub fn write(out: &mut dyn Write, report: &MieReport) -> io::Result<()> {
    let widest = |length: &dyn Fn(&Quantity) -> usize| report.quantities.iter().map(length).max().unwrap_or(0);
    let name_width = widest(&|quantity| quantity.key.len());
    // Descriptions may be longer than the column of numbers.
    let value_width = widest(&|quantity| shown(&quantity.value).chars().count()).min(34);
    for quantity in &report.quantities {
        let (value, unit) = (shown(&quantity.value), quantity.unit);
        let unit = if matches!(unit, "1" | "text") { "" } else { unit };
        writeln!(out, "{:name_width$}  {value:value_width$}  {unit:3}  {}", quantity.key, quantity.meaning)?;
    }
    writeln!(out)?;
    write!(out, "{:>12}", "angle (deg)")?;
    for column in &report.columns {
        let unit = if column.unit == "1" { String::new() } else { format!(" ({})", column.unit) };
        match column.values {
            ColumnValues::Complex(_) => write!(out, " {:>14} {:>14}", column.key.to_owned() + " re", "im")?,
            _ => write!(out, " {:>14}", column.key.to_owned() + &unit)?,
        }
    }
    writeln!(out)?;
    for i in 0..report.angles_deg.len() {
        write_row(out, report, i)?;
    }
    writeln!(out)?;
    wrapped(NORMALIZATION).iter().try_for_each(|line| writeln!(out, "{line}"))
}

fn write_row(out: &mut dyn Write, report: &MieReport, i: usize) -> io::Result<()> {
    write!(out, "{:>12}", report.angles_deg[i])?;
    for column in &report.columns {
        match &column.values {
            ColumnValues::Real(values) => write!(out, " {:>14.6e}", values[i])?,
            ColumnValues::Complex(values) => write!(out, " {:>14.6e} {:>14.6e}", values[i].re, values[i].im)?,
            ColumnValues::Undefined => write!(out, " {:>14}", "-")?,
        }
    }
    writeln!(out)
}

fn shown(value: &Value) -> String {
    match value {
        Value::Number(value) => digits(*value),
        Value::Count(value) => value.to_string(),
        Value::Complex(value) => format!("{} + {} i", digits(value.re), digits(value.im)),
        Value::Text(value) => value.clone(),
        Value::Undefined => "-".into(),
        Value::Fields(fields) => {
            let parts: Vec<String> = fields.iter().map(|(name, value)| format!("{name} {value:.1e}")).collect();
            parts.join(", ")
        }
    }
}

/// Ten significant digits, plain where the number is neither large nor small.
fn digits(value: f64) -> String {
    let rounded: f64 = format!("{value:.9e}").parse().unwrap_or(value);
    if rounded == 0.0 || (1e-4..1e7).contains(&rounded.abs()) { rounded.to_string() } else { format!("{rounded:e}") }
}

/// Breaks a text at its spaces.
fn wrapped(text: &str) -> Vec<String> {
    let mut lines = vec![String::new()];
    for word in text.split_whitespace() {
        let last = lines.len() - 1;
        if !lines[last].is_empty() && lines[last].len() + word.len() >= WIDTH {
            lines.push(word.into());
        } else {
            let space = if lines[last].is_empty() { "" } else { " " };
            lines[last] += space;
            lines[last] += word;
        }
    }
    lines
}
