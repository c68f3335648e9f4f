//! The sun's spectral irradiance.

use std::fmt;
use std::str::FromStr;
use std::sync::LazyLock;

use super::SpectrumError;
use super::observer::{VISIBLE_MAX_NM, VISIBLE_MIN_NM, color_matching};
use super::table::WavelengthTable;

/// Which solar spectrum lights the scene in `bands` mode.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum SunSpectrum {
    /// ASTM E490-00a, extraterrestrial; 133 315 lx.
    #[default]
    E490,
    /// ASTM G173-03, extraterrestrial column.
    G173Extraterrestrial,
    /// ASTM G173-03, direct and circumsolar, air mass 1.5.
    G173Direct,
    /// CIE D65.
    D65,
    /// The same irradiance at every wavelength.
    Equal,
}

static E490: LazyLock<WavelengthTable<1>> =
    LazyLock::new(|| WavelengthTable::from_embedded(include_str!("../../data/astm_e490_00a_200_2500nm.csv")));
static G173: LazyLock<WavelengthTable<3>> =
    LazyLock::new(|| WavelengthTable::from_embedded(include_str!("../../data/astm_g173_280_4000nm.csv")));
static D65: LazyLock<WavelengthTable<1>> =
    LazyLock::new(|| WavelengthTable::from_embedded(include_str!("../../data/cie_d65_5nm.csv")));

impl SunSpectrum {
    /// All spectra with their names.
    pub const ALL: [(SunSpectrum, &'static str); 5] = [
        (SunSpectrum::E490, "e490"),
        (SunSpectrum::G173Extraterrestrial, "g173"),
        (SunSpectrum::G173Direct, "g173-direct"),
        (SunSpectrum::D65, "d65"),
        (SunSpectrum::Equal, "equal"),
    ];

    /// The name as it is written in settings.
    pub fn name(self) -> &'static str {
        Self::ALL.iter().find(|(spectrum, _)| *spectrum == self).map_or("", |(_, name)| name)
    }

    /// Irradiance at a vacuum wavelength in nm, 380-780 nm at least; W m^-2 nm^-1 for the solar spectra, relative for
    /// `D65` (100 at 560 nm) and `Equal` (1).
    pub fn irradiance_per_nm(self, wavelength_nm: f64) -> f64 {
        match self {
            Self::E490 => E490.at(wavelength_nm)[0],
            Self::G173Extraterrestrial => G173.at(wavelength_nm)[0],
            Self::G173Direct => G173.at(wavelength_nm)[2],
            Self::D65 => D65.at(wavelength_nm)[0],
            Self::Equal => 1.0,
        }
    }

    /// XYZ of the spectrum between two wavelengths in nm: the integral of irradiance times colour matching.
    pub(crate) fn xyz_between(self, from_nm: f64, to_nm: f64) -> [f64; 3] {
        let steps = integration_steps(from_nm, to_nm);
        let step_nm = (to_nm - from_nm) / steps as f64;
        let mut sum = [0.0; 3];
        for i in 0..steps {
            let nm = from_nm + (i as f64 + 0.5) * step_nm;
            let weight = self.irradiance_per_nm(nm) * step_nm;
            for (sum, value) in sum.iter_mut().zip(color_matching(nm)) {
                *sum += weight * value;
            }
        }
        sum
    }

    /// XYZ over the visible range.
    pub fn xyz(self) -> [f64; 3] {
        self.xyz_between(VISIBLE_MIN_NM, VISIBLE_MAX_NM)
    }
}

/// Midpoint steps of a quarter of the tables' 1 nm, so that the kinks of the data do not matter.
pub(crate) fn integration_steps(from_nm: f64, to_nm: f64) -> usize {
    (4.0 * (to_nm - from_nm)).ceil().max(8.0) as usize
}

impl FromStr for SunSpectrum {
    type Err = SpectrumError;

    fn from_str(text: &str) -> Result<Self, SpectrumError> {
        let found = Self::ALL.iter().find(|(_, name)| *name == text.trim());
        found.map(|(spectrum, _)| *spectrum).ok_or_else(|| SpectrumError::Sun(text.into()))
    }
}

impl fmt::Display for SunSpectrum {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

#[cfg(test)]
mod tests {
    use super::super::observer::LUMENS_PER_WATT;
    use super::*;

    #[test]
    fn the_tables_are_whole() {
        assert_eq!((E490.len(), G173.len(), D65.len()), (1366, 2002, 81));
        for (spectrum, _) in SunSpectrum::ALL {
            for nm in 380..=780 {
                assert!(spectrum.irradiance_per_nm(f64::from(nm)) > 0.0, "{spectrum} {nm}");
            }
        }
    }

    #[test]
    fn illuminances_are_those_of_the_tables() {
        let published = [(SunSpectrum::E490, 133_315.0), (SunSpectrum::G173Extraterrestrial, 133_095.0)];
        for (spectrum, lux) in published.into_iter().chain([(SunSpectrum::G173Direct, 97_139.0)]) {
            let relative = LUMENS_PER_WATT * spectrum.xyz()[1] / lux - 1.0;
            assert!(relative.abs() < 1e-3, "{spectrum}: {relative:e}");
        }
    }

    #[test]
    fn d65_has_its_published_chromaticity() {
        let [x, y, z] = SunSpectrum::D65.xyz();
        assert!((x / (x + y + z) - 0.3127).abs() < 1e-4);
        assert!((y / (x + y + z) - 0.3290).abs() < 1e-4);
    }

    #[test]
    fn names_are_read_back() {
        for (spectrum, name) in SunSpectrum::ALL {
            assert_eq!(name.parse(), Ok(spectrum));
            assert_eq!(spectrum.to_string(), name);
        }
        assert!(matches!("e940".parse::<SunSpectrum>(), Err(SpectrumError::Sun(_))));
    }
}
