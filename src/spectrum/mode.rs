//! How the picture samples the spectrum: one wavelength, three, or bands.

use std::fmt;
use std::str::FromStr;

use thiserror::Error;

use super::sun::SunSpectrum;
use crate::suggest::did_you_mean;
use crate::units::{UnitError, format_length, parse_length_m};

/// How the picture samples the spectrum.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SpectralMode {
    /// One wavelength; R = G = B = radiance.
    Mono { wavelength_m: f64 },
    /// Three wavelengths straight into the channels.
    Rgb { wavelengths_m: [f64; 3] },
    /// Bands over 380-780 nm, weighted by the CIE 1931 observer and the sun.
    Bands { count: usize },
}

/// The wavelengths of red, green and blue where `rgb` names none, m.
pub const RGB_DEFAULT_M: [f64; 3] = [650e-9, 550e-9, 450e-9];

/// Wavelengths that are taken for such: gamma rays to the longest waves of the Earth.
const WAVELENGTHS_M: std::ops::RangeInclusive<f64> = 1e-15..=1e9;

/// Most bands that can be asked for: one per nanometre of 380-780 nm, the step of the observer's table.
pub const MAX_BANDS: usize = 400;

/// A description of wavelengths or light could not be read.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum SpectrumError {
    /// Not a spectral mode.
    #[error("`{0}` is not a spectral mode{hint}; accepted are mono:550nm, rgb, rgb:650nm,550nm,450nm and bands:8", hint = did_you_mean(.0, ["mono", "rgb", "bands"]))]
    Mode(String),
    /// A wavelength cannot be read.
    #[error("spectral mode `{mode}`: {reason}; write a wavelength like 550nm")]
    Wavelength { mode: String, reason: UnitError },
    /// A wavelength is out of range.
    #[error("spectral mode `{0}`: wavelengths must lie from 1e-15 to 1e9 m")]
    Range(String),
    /// The wrong number of wavelengths.
    #[error("spectral mode `{mode}`: {found} wavelengths where {expected} are needed")]
    WavelengthCount { mode: String, found: usize, expected: usize },
    /// The number of bands is not an integer in range.
    #[error("spectral mode `{0}`: the number of bands must be an integer from 1 to {MAX_BANDS}, like bands:8")]
    Bands(String),
    /// Not a solar spectrum.
    #[error("`{0}` is not a spectrum{hint}; accepted are e490, g173, g173-direct, d65 and equal", hint = did_you_mean(.0, SunSpectrum::ALL.map(|(_, name)| name)))]
    Sun(String),
}

impl FromStr for SpectralMode {
    type Err = SpectrumError;

    fn from_str(text: &str) -> Result<Self, SpectrumError> {
        let (kind, argument) = match text.trim().split_once(':') {
            Some((kind, argument)) => (kind.trim(), Some(argument)),
            None => (text.trim(), None),
        };
        match (kind, argument) {
            ("mono", Some(list)) => parse_wavelengths(text, list).map(|[wavelength_m]| Self::Mono { wavelength_m }),
            ("rgb", None) => Ok(Self::Rgb { wavelengths_m: RGB_DEFAULT_M }),
            ("rgb", Some(list)) => parse_wavelengths(text, list).map(|wavelengths_m| Self::Rgb { wavelengths_m }),
            ("bands", Some(count)) => match count.trim().parse() {
                Ok(count @ 1..=MAX_BANDS) => Ok(Self::Bands { count }),
                _ => Err(SpectrumError::Bands(text.into())),
            },
            ("bands", None) => Err(SpectrumError::Bands(text.into())),
            ("mono", None) => Err(SpectrumError::WavelengthCount { mode: text.into(), found: 0, expected: 1 }),
            _ => Err(SpectrumError::Mode(kind.into())),
        }
    }
}

fn parse_wavelengths<const N: usize>(mode: &str, list: &str) -> Result<[f64; N], SpectrumError> {
    let parse = |item| parse_length_m(item).map_err(|reason| SpectrumError::Wavelength { mode: mode.into(), reason });
    let wavelengths = list.split(',').map(parse).collect::<Result<Vec<f64>, _>>()?;
    if !wavelengths.iter().all(|wavelength_m| WAVELENGTHS_M.contains(wavelength_m)) {
        return Err(SpectrumError::Range(mode.into()));
    }
    let wrong_count =
        |found: Vec<f64>| SpectrumError::WavelengthCount { mode: mode.into(), found: found.len(), expected: N };
    wavelengths.try_into().map_err(wrong_count)
}

impl fmt::Display for SpectralMode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let nm = |wavelength_m: f64| format_length(wavelength_m, "nm", 1e9);
        match *self {
            Self::Mono { wavelength_m } => write!(f, "mono:{}", nm(wavelength_m)),
            Self::Rgb { wavelengths_m: [r, g, b] } => write!(f, "rgb:{},{},{}", nm(r), nm(g), nm(b)),
            Self::Bands { count } => write!(f, "bands:{count}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn modes_are_read_back() {
        for text in [
            "mono:550nm",
            "mono:10.6um",
            "mono:1.5421um",
            "rgb",
            "rgb:650nm,550nm,450nm",
            "rgb:611.3nm,0.5321um,4e-7m",
            "bands:8",
        ] {
            let mode: SpectralMode = text.parse().expect(text);
            assert_eq!(mode.to_string().parse(), Ok(mode), "{text}");
        }
        assert_eq!("mono:550nm".parse(), Ok(SpectralMode::Mono { wavelength_m: 550e-9 }));
        assert_eq!(SpectralMode::Rgb { wavelengths_m: RGB_DEFAULT_M }.to_string(), "rgb:650nm,550nm,450nm");
    }

    #[test]
    fn what_is_no_mode_is_refused_with_the_reason() {
        use SpectrumError::*;
        let error = |text: &str| text.parse::<SpectralMode>().unwrap_err();
        assert!(error("band:8").to_string().contains("did you mean `bands`"));
        assert!(matches!(error("mono"), WavelengthCount { found: 0, expected: 1, .. }));
        assert!(matches!(error("rgb:1nm,2nm"), WavelengthCount { found: 2, expected: 3, .. }));
        assert!(matches!(error("mono:550"), Wavelength { .. }));
        assert!(matches!(error("mono:0nm"), Range(_)));
        assert!(matches!(error("rgb:1e300km,1nm,1nm"), Range(_)));
        assert!(matches!(error("bands:0"), Bands(_)));
        assert!(matches!(error("bands:1e9"), Bands(_)));
    }
}
