//! The report as CSV: `#` lines with everything that does not depend on the angle, then one row per angle.
//!
//! Angle and phase function come first, so that the file serves as the phase model `table:FILE.csv`.

use std::io::{self, Write};

use crate::study::MieReport;
use crate::study::mie_report::{ColumnValues, NORMALIZATION, Value};

/// Writes the report; numbers have all their digits.
pub fn write(out: &mut dyn Write, report: &MieReport) -> io::Result<()> {
    for quantity in &report.quantities {
        write!(out, "# {} = ", quantity.key)?;
        write_value(out, &quantity.value)?;
        writeln!(out, " [{}] {}", quantity.unit, quantity.meaning)?;
    }
    writeln!(out, "# column angle_deg [deg] scattering angle, 0 is forward")?;
    for column in &report.columns {
        writeln!(out, "# column {} [{}] {}", column.key, column.unit, column.meaning)?;
    }
    writeln!(out, "# normalization: {NORMALIZATION}")?;
    write!(out, "angle_deg")?;
    for column in &report.columns {
        match column.values {
            ColumnValues::Complex(_) => write!(out, ",{0}_re,{0}_im", column.key)?,
            _ => write!(out, ",{}", column.key)?,
        }
    }
    writeln!(out)?;
    (0..report.angles_deg.len()).try_for_each(|i| write_row(out, report, i))
}

fn write_row(out: &mut dyn Write, report: &MieReport, i: usize) -> io::Result<()> {
    write!(out, "{:?}", report.angles_deg[i])?;
    for column in &report.columns {
        match &column.values {
            ColumnValues::Real(values) => write!(out, ",{:?}", values[i])?,
            ColumnValues::Complex(values) => write!(out, ",{:?},{:?}", values[i].re, values[i].im)?,
            ColumnValues::Undefined => write!(out, ",")?,
        }
    }
    writeln!(out)
}

fn write_value(out: &mut dyn Write, value: &Value) -> io::Result<()> {
    match value {
        Value::Number(value) => write!(out, "{value:?}"),
        Value::Count(value) => write!(out, "{value}"),
        Value::Complex(value) => write!(out, "{:?},{:?}", value.re, value.im),
        // A line of its own cannot end early.
        Value::Text(value) => write!(out, "{}", value.replace(['\n', '\r'], " ")),
        Value::Undefined => write!(out, "undefined"),
        Value::Fields(fields) => {
            for (i, (name, value)) in fields.iter().enumerate() {
                write!(out, "{}{name} {value:?}", if i == 0 { "" } else { ", " })?;
            }
            Ok(())
        }
    }
}
