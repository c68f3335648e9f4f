//! Small numeric CSV files: `#` lines and one header line are skipped, every other defect is an error with its line.

use thiserror::Error;

use crate::excerpt::excerpt;

/// A CSV file could not be read as numbers.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum CsvError {
    /// The file itself could not be read; `reason` says why and what to do.
    #[error("{file} {reason}")]
    Unreadable { file: String, reason: String },
    /// A row has the wrong number of fields.
    #[error("{file}, line {line}: {found} fields where {expected} are needed; separate them by commas")]
    Fields { file: String, line: usize, found: usize, expected: usize },
    /// A field is not a finite number.
    #[error("{file}, line {line}: `{text}` is not a finite number; only the first line may be a header")]
    Number { file: String, line: usize, text: String },
    /// Too few rows.
    #[error("{file}: {found} rows of numbers, at least {needed} are needed")]
    Rows { file: String, found: usize, needed: usize },
}

/// One row of numbers and the line of the file it stands on (from 1).
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Line number, from 1.
    pub line: usize,
    /// The fields.
    pub values: Vec<f64>,
}

/// The numbers of a CSV file.
#[derive(Clone, Debug, PartialEq)]
pub struct NumericCsv {
    /// Names in the header line, trimmed, lower case; `None` where there is no header.
    pub header: Option<Vec<String>>,
    /// The rows, each with at least the number of fields that was asked for.
    pub rows: Vec<Row>,
}

/// Reads the numbers of a CSV text; `file` is named in errors.
///
/// Rows may have more than `min_fields` fields, but all rows and the header have the same number.
///
/// # Errors
/// When a row has too few fields or a different number of fields than the first, a field is not a finite number, or
/// there are fewer than `min_rows` rows.
pub fn parse_numeric(file: &str, text: &str, min_fields: usize, min_rows: usize) -> Result<NumericCsv, CsvError> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let mut csv = NumericCsv { header: None, rows: Vec::new() };
    let mut width = None;
    let lines = text.lines().enumerate().map(|(i, line)| (i + 1, line.trim()));
    for (line, content) in lines.filter(|(_, content)| !content.is_empty() && !content.starts_with('#')) {
        let fields: Vec<&str> = content.split(',').map(str::trim).collect();
        let expected = *width.get_or_insert(fields.len().max(min_fields));
        if fields.len() != expected {
            return Err(CsvError::Fields { file: file.into(), line, found: fields.len(), expected });
        }
        let is_first = csv.header.is_none() && csv.rows.is_empty();
        if is_first && fields.iter().all(|field| field.parse::<f64>().is_err()) {
            csv.header = Some(fields.iter().map(|field| field.to_lowercase()).collect());
        } else {
            csv.rows.push(Row { line, values: parse_fields(file, line, &fields)? });
        }
    }
    if csv.rows.len() < min_rows {
        return Err(CsvError::Rows { file: file.into(), found: csv.rows.len(), needed: min_rows });
    }
    Ok(csv)
}

fn parse_fields(file: &str, line: usize, fields: &[&str]) -> Result<Vec<f64>, CsvError> {
    let parse = |text: &&str| match text.parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ => Err(CsvError::Number { file: file.into(), line, text: excerpt(text) }),
    };
    fields.iter().map(parse).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comments_and_one_header_are_skipped() -> Result<(), CsvError> {
        let csv = parse_numeric("a.csv", "\u{feff}# note\r\n\r\nA_deg, Value\r\n0,1\r\n180,2\r\n", 2, 2)?;
        assert_eq!(csv.header, Some(vec!["a_deg".into(), "value".into()]));
        assert_eq!(csv.rows[1], Row { line: 5, values: vec![180.0, 2.0] });
        Ok(())
    }

    #[test]
    fn defects_name_their_line() {
        let number = parse_numeric("a.csv", "a,b\n1,2\nc,d\n", 2, 1);
        assert_eq!(number, Err(CsvError::Number { file: "a.csv".into(), line: 3, text: "c".into() }));
        let nan = parse_numeric("a.csv", "1,2\n3,NaN\n", 2, 1);
        assert!(matches!(nan, Err(CsvError::Number { line: 2, .. })));
        let fields = parse_numeric("a.csv", "1,2\n3\n", 2, 1);
        assert_eq!(fields, Err(CsvError::Fields { file: "a.csv".into(), line: 2, found: 1, expected: 2 }));
        assert!(matches!(parse_numeric("a.csv", "a,b\n", 2, 1), Err(CsvError::Rows { found: 0, needed: 1, .. })));
    }
}
