//! Values of arguments as they are written: numbers, lengths with units, sizes, pairs.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use clap::builder::{OsStringValueParser, TypedValueParser};
use num_complex::Complex64;

use crate::film::{block_of, is_whole};
use crate::plan::accuracy_level;
use crate::scene::keys::ACCURACY_NAMES;
use crate::suggest::did_you_mean;
use crate::units::{parse_bytes, parse_length_m, parse_time_s};

/// More threads than any machine has processors only wait for each other.
pub const MOST_THREADS: i64 = 1024;

/// Endings of file names that promise a format.
const FORMATS: [&str; 17] = [
    "exr", "png", "svg", "jpg", "jpeg", "tif", "tiff", "hdr", "pfm", "ppm", "bmp", "webp", "pdf", "json", "csv",
    "gltf", "glb",
];

/// The ending of a file's name, where it promises another format than `own`.
pub fn promises_other(path: &Path, own: &str) -> bool {
    let ending = path.extension().and_then(|ending| ending.to_str()).unwrap_or("").to_lowercase();
    ending != own && FORMATS.contains(&ending.as_str())
}

/// A file that is written in the format `own`, whose name promises no other.
pub fn file_as(own: &'static str) -> impl TypedValueParser<Value = PathBuf> {
    OsStringValueParser::new().try_map(move |name: OsString| {
        let path = PathBuf::from(name);
        match promises_other(&path, own) {
            true => {
                let better = path.with_extension(own);
                Err(format!("the file is {}; name it {}", own.to_uppercase(), better.display()))
            }
            false => Ok(path),
        }
    })
}

pub fn length(text: &str) -> Result<f64, String> {
    let value = parse_length_m(text).map_err(|e| e.to_string())?;
    if value > 0.0 { Ok(value) } else { Err("a length above zero is needed".into()) }
}

/// A length, where somebody may want several.
pub fn one_wavelength(text: &str) -> Result<f64, String> {
    if text.contains(',') {
        return Err("one wavelength is needed; run the command once for each".into());
    }
    length(text)
}

/// A length of time above zero, s.
pub fn parse_time(text: &str) -> Result<f64, String> {
    let seconds = parse_time_s(text).map_err(|e| e.to_string())?;
    if seconds > 0.0 { Ok(seconds) } else { Err("a time above zero is needed".into()) }
}

/// An amount of memory above zero, bytes.
pub fn parse_memory(text: &str) -> Result<u64, String> {
    let bytes = parse_bytes(text).map_err(|e| e.to_string())?;
    if bytes > 0 { Ok(bytes) } else { Err("an amount above zero is needed, e.g. 4GB".into()) }
}

pub fn parse_key_value(text: &str) -> Result<(String, String), String> {
    let (key, value) = text.split_once('=').ok_or("write KEY=VALUE, e.g. atmosphere.step_m=0.1")?;
    Ok((key.trim().to_owned(), value.trim().to_owned()))
}

pub fn number(text: &str) -> Result<f64, String> {
    text.trim().parse::<f64>().ok().filter(|v| v.is_finite()).ok_or_else(|| format!("`{text}` is not a number"))
}

pub fn parse_positive(text: &str) -> Result<f64, String> {
    number(text).and_then(|v| if v > 0.0 { Ok(v) } else { Err("a number above zero is needed".into()) })
}

pub fn parse_nonnegative(text: &str) -> Result<f64, String> {
    number(text).and_then(|v| if v >= 0.0 { Ok(v) } else { Err("a number not below zero is needed".into()) })
}

pub fn parse_share(text: &str) -> Result<f64, String> {
    number(text)
        .ok()
        .filter(|v| *v > 0.0 && *v < 1.0)
        .ok_or_else(|| format!("a number between 0 and 1 is needed{}", percent_hint(text)))
}

/// An index such as `1.33,0`, or `1.33` without absorption; its range is the theory's business.
pub fn parse_index(text: &str) -> Result<Complex64, String> {
    let form = "write real and imaginary part as N,K, e.g. 1.33,0";
    let parts: Result<Vec<f64>, String> = text.split(',').map(number).collect();
    match parts.map_err(|problem| format!("{problem}; {form}"))?[..] {
        [n] => Ok(Complex64::new(n, 0.0)),
        [n, k] => Ok(Complex64::new(n, k)),
        _ => Err(form.into()),
    }
}

pub fn parse_accuracy(text: &str) -> Result<f64, String> {
    accuracy_level(text).ok_or_else(|| {
        let names = ACCURACY_NAMES.map(|(name, _)| name);
        let hint = did_you_mean(text, names) + &percent_hint(text);
        format!("{} or a number above 0 and at most 1 is needed{hint}", names.join(", "))
    })
}

/// What a number of percent would be, where one seems to be meant: empty else.
fn percent_hint(text: &str) -> String {
    let percent = text.trim().trim_end_matches('%').trim_end().parse::<f64>().ok();
    let meant = percent.filter(|v| (text.contains('%') || *v >= 1.0) && *v > 0.0 && *v < 100.0);
    meant.map_or(String::new(), |v| format!("; {v} % is {}", v / 100.0))
}

fn whole<const N: usize>(text: &str, separator: char, form: &str) -> Result<[u32; N], String> {
    let parts: Option<Vec<u32>> = text.split(separator).map(|part| part.trim().parse().ok()).collect();
    parts.and_then(|p| p.try_into().ok()).ok_or_else(|| format!("`{text}` is not of the form {form}"))
}

pub fn parse_resolution(text: &str) -> Result<[u32; 2], String> {
    let size = whole::<2>(text, 'x', "WxH, e.g. 640x360")?;
    if size.iter().all(|side| (1..=65_536).contains(side)) {
        Ok(size)
    } else {
        Err("each side must be 1 to 65536 pixels".into())
    }
}

pub fn parse_crop(text: &str) -> Result<[u32; 4], String> {
    let crop = whole::<4>(text, ',', "X,Y,W,H, e.g. 0,0,64,64")?;
    if crop[2] > 0 && crop[3] > 0 { Ok(crop) } else { Err("width and height must be at least 1".into()) }
}

/// A range of samples that cuts no block, e.g. `64..128`.
pub fn parse_samples(text: &str) -> Result<[u32; 2], String> {
    let ends = text.split_once("..").map(|(start, end)| (start.trim().parse::<u32>(), end.trim().parse::<u32>()));
    let Some((Ok(start), Ok(end))) = ends else { return Err("write A..B, e.g. 0..64 or 64..128".into()) };
    if start >= end {
        return Err(format!("{start}..{end} is empty; write A..B with A < B, e.g. 0..64"));
    }
    if is_whole(&(start..end)) {
        return Ok([start, end]);
    }
    let (first, last) = (block_of(start), block_of(end));
    let starts = [first.start, if first.start == start { start } else { first.end }];
    let ends = [last.start, if last.start == end { end } else { last.end }];
    let mut allowed: Vec<[u32; 2]> =
        starts.iter().flat_map(|a| ends.map(|b| [*a, b])).filter(|[a, b]| a < b && is_whole(&(*a..*b))).collect();
    allowed.sort_unstable();
    allowed.dedup();
    let allowed: Vec<String> = allowed.iter().map(|[a, b]| format!("{a}..{b}")).collect();
    let nearest = match allowed.is_empty() {
        true => "begin and end it at multiples of a larger power of two".into(),
        false => format!("the nearest ranges that do not: {}", allowed.join(", ")),
    };
    Err(format!("it cuts samples that are drawn together; {nearest}"))
}

/// A count may be written 1e6.
pub fn parse_count(text: &str) -> Result<u64, String> {
    let value = number(text)?;
    if value >= 1.0 && value.fract() == 0.0 && value <= 1e15 {
        Ok(value as u64)
    } else {
        Err("a whole number of at least 1 is needed, e.g. 1e6".into())
    }
}

/// A point such as `0m,1.5m,-3m`.
pub fn parse_point(text: &str) -> Result<[f64; 3], String> {
    let coordinate = |part: &str| match part.trim().strip_prefix('-') {
        Some(positive) => parse_length_m(positive).map(|value| -value),
        None => parse_length_m(part.trim()),
    };
    let parts: Vec<f64> = text.split(',').map(coordinate).collect::<Result<_, _>>().map_err(|e| e.to_string())?;
    parts.try_into().map_err(|_| "three coordinates separated by commas are needed, e.g. 0m,1.5m,3m".into())
}

pub fn parse_water(text: &str) -> Result<f64, String> {
    let (value, unit) = crate::units::split_unit(text.trim());
    if !matches!(unit, "g/m3" | "g/m^3") {
        return Err("write grams per cubic metre, e.g. 0.3g/m3".into());
    }
    parse_positive(value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_sizes_and_water_are_read_with_their_units() {
        assert_eq!(parse_count("1e6"), Ok(1_000_000));
        assert!(parse_count("1.5").is_err());
        assert_eq!(parse_point("20m,-2m,0.5km"), Ok([20.0, -2.0, 500.0]));
        assert_eq!(parse_water("0.3g/m3"), Ok(0.3));
        assert!(parse_water("0.3").is_err());
    }

    #[test]
    fn percent_are_answered_with_the_share_that_was_meant() {
        let said = |text| parse_share(text).err().unwrap_or_default();
        assert!(said("5").ends_with("; 5 % is 0.05") && said("2.5%").ends_with("; 2.5 % is 0.025"), "{}", said("5"));
        assert!(parse_accuracy("2%").err().unwrap_or_default().ends_with("; 2 % is 0.02"));
        assert!(!said("-1").contains('%') && !said("0").contains('%') && !said("200").contains('%'));
    }

    #[test]
    fn ranges_of_samples_cut_no_block() {
        assert_eq!(parse_samples("0..64"), Ok([0, 64]));
        assert_eq!(parse_samples("64..112"), Ok([64, 112]));
        let said = |text| parse_samples(text).err().unwrap_or_default();
        assert!(said("64..100").ends_with("64..96, 64..112"), "{}", said("64..100"));
        assert!(said("3..9").ends_with("2..8, 2..12, 4..8, 4..12"), "{}", said("3..9"));
        assert!(said("5..7").ends_with("4..8"), "{}", said("5..7"));
        assert!(said("0..5").ends_with(": 0..4, 0..8"), "{}", said("0..5"));
        // The last block ends where numbers do: nothing that is proposed is refused.
        let last = said("0..4294967295");
        let proposed = last.rsplit(": ").next().unwrap_or_default().split(", ");
        assert!(proposed.clone().count() > 0 && proposed.clone().all(|text| parse_samples(text).is_ok()), "{last}");
        for text in ["", "64", "..", "4..2", "4..4", "-1..4", "0..1e3"] {
            assert!(parse_samples(text).is_err(), "{text}");
        }
    }
}
