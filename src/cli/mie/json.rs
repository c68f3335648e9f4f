//! The report as JSON: one line per key, every number with all its digits.

use std::io::{self, Write};

use num_complex::Complex64;
use serde::ser::{Serialize, SerializeMap, SerializeSeq, Serializer};
use serde_json::ser::Formatter;

use crate::study::MieReport;
use crate::study::mie_report::{ColumnValues, NORMALIZATION, Value};

/// Writes the report.
pub fn write(mut out: &mut dyn Write, report: &MieReport) -> io::Result<()> {
    let mut serializer = serde_json::Serializer::with_formatter(&mut out, LinePerKey { depth: 0 });
    Report(report).serialize(&mut serializer)?;
    writeln!(out)
}

struct Report<'a>(&'a MieReport);

impl Serialize for Report<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let report = self.0;
        let mut map = serializer.serialize_map(None)?;
        for quantity in &report.quantities {
            match &quantity.value {
                Value::Number(value) => map.serialize_entry(quantity.key, value)?,
                Value::Count(value) => map.serialize_entry(quantity.key, value)?,
                Value::Complex(value) => map.serialize_entry(quantity.key, &[value.re, value.im])?,
                Value::Text(value) => map.serialize_entry(quantity.key, value)?,
                Value::Fields(fields) => map.serialize_entry(quantity.key, &Fields(fields))?,
                Value::Undefined => map.serialize_entry(quantity.key, &())?,
            }
        }
        map.serialize_entry("angles_deg", &report.angles_deg)?;
        for column in &report.columns {
            match &column.values {
                ColumnValues::Real(values) => map.serialize_entry(column.key, values)?,
                ColumnValues::Complex(values) => map.serialize_entry(column.key, &Pairs(values))?,
                ColumnValues::Undefined => map.serialize_entry(column.key, &())?,
            }
        }
        let quantities = report.quantities.iter().map(|quantity| (quantity.key, quantity.unit));
        let columns = report.columns.iter().map(|column| (column.key, column.unit));
        let units: Vec<_> = quantities.chain([("angles_deg", "deg")]).chain(columns).collect();
        map.serialize_entry("units", &Fields(&units))?;
        map.serialize_entry("normalization", NORMALIZATION)?;
        map.end()
    }
}

/// Names and values as an object, in their order.
struct Fields<'a, T>(&'a [(&'static str, T)]);

impl<T: Serialize> Serialize for Fields<'_, T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.0.iter().map(|(name, value)| (name, value)))
    }
}

/// Complex numbers as [real, imaginary].
struct Pairs<'a>(&'a [Complex64]);

impl Serialize for Pairs<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut list = serializer.serialize_seq(Some(self.0.len()))?;
        for value in self.0 {
            list.serialize_element(&[value.re, value.im])?;
        }
        list.end()
    }
}

/// Breaks lines between the keys of the outermost object only: arrays have thousands of numbers.
struct LinePerKey {
    depth: usize,
}

impl Formatter for LinePerKey {
    fn begin_object<W: ?Sized + Write>(&mut self, writer: &mut W) -> io::Result<()> {
        self.depth += 1;
        writer.write_all(b"{")
    }

    fn end_object<W: ?Sized + Write>(&mut self, writer: &mut W) -> io::Result<()> {
        self.depth -= 1;
        writer.write_all(if self.depth == 0 { b"\n}" } else { b"}" })
    }

    fn begin_object_key<W: ?Sized + Write>(&mut self, writer: &mut W, first: bool) -> io::Result<()> {
        let before: &[u8] = match (self.depth, first) {
            (1, true) => b"\n  ",
            (1, false) => b",\n  ",
            (_, true) => b"",
            (_, false) => b", ",
        };
        writer.write_all(before)
    }

    fn begin_object_value<W: ?Sized + Write>(&mut self, writer: &mut W) -> io::Result<()> {
        writer.write_all(b": ")
    }
}
