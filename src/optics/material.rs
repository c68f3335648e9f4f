//! Materials: refractive index against wavelength.

use std::fmt;
use std::sync::{Arc, LazyLock};

use num_complex::Complex64;
use thiserror::Error;

use super::ReadText;
use super::csv::CsvError;
use super::index_table::{check_index, out_of_range};
use crate::suggest::did_you_mean;

pub use super::index_table::IndexTable;

/// What a droplet is made of.
#[derive(Clone, Debug, PartialEq)]
pub enum Material {
    /// Liquid water: at 20 C n of Daimon & Masumura (2007), k of Segelstein (1981), 205.2-1129 nm; on to 200 um n and k of
    /// Hale & Querry (1973) at 25 C, n to three decimals.
    Water,
    /// Ice Ih at 266 K: Warren & Brandt (2008); 44.3 nm to 2 m.
    Ice,
    /// The same index at every wavelength.
    Constant { n: f64, k: f64 },
    /// A table read from a file.
    Table(Arc<IndexTable>),
}

/// A material could not be read, or has no index where it is asked for.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum MaterialError {
    /// Not a material.
    #[error("`{0}` is not a material{hint}; accepted are water, ice, an index like n=1.33,k=0 and a file.csv", hint = did_you_mean(.0, ["water", "ice"]))]
    Unknown(String),
    /// The index is outside the domain of the theory.
    #[error("{of}: index n = {n}, k = {k} must have {N_MIN} <= n <= {N_MAX} and 0 <= k <= {K_MAX} (k > 0 absorbs)")]
    Index { of: String, n: f64, k: f64 },
    /// The wavelength is outside the data.
    #[error(
        "{material} has no refractive index at {wavelength_nm} nm: its data span {min_nm} to {max_nm} nm; choose a wavelength in that range or give an index like n=1.33,k=0"
    )]
    Wavelength { material: String, wavelength_nm: f64, min_nm: f64, max_nm: f64 },
    /// The file is not a numeric CSV.
    #[error(transparent)]
    Csv(#[from] CsvError),
    /// The header does not name the columns.
    #[error(
        "{0}: the header must name the columns wavelength_um (or wavelength_nm), n and k, like `wavelength_um,n,k`"
    )]
    Header(String),
    /// The wavelengths do not increase.
    #[error(
        "{file}, line {line}: wavelengths must lie from 1e-15 to 1e9 m and increase from line to line; sort the rows"
    )]
    Order { file: String, line: usize },
}

/// Domain of the refractive index, that of the Mie series.
pub(super) const N_MIN: f64 = 0.05;
pub(super) const N_MAX: f64 = 20.0;
pub(super) const K_MAX: f64 = 100.0;

/// Density of water at 20 C, kg/m^3 (CIPM formula: Tanaka et al. 2001, Metrologia 38, 301).
const WATER_KG_PER_M3: f64 = 998.2;

/// Density of ice Ih at 0 C, kg/m^3 (CRC Handbook of Chemistry and Physics).
const ICE_KG_PER_M3: f64 = 917.0;

/// Daimon & Masumura (2007) at 20.0 C: n^2 - 1 = sum a L^2 / (L^2 - b), L in um. Rows (a, b) of
/// `data/water_daimon_masumura_2007_coeffs.csv`.
const WATER_SELLMEIER: [(f64, f64); 4] = [
    (0.568402767, 0.00510182977),
    (0.172617733, 0.0182115398),
    (0.0208618958, 0.0262072235),
    (0.113074869, 10.6979275),
];

/// Where the Sellmeier formula ends, m (Daimon & Masumura 2007); it begins at 182 nm, below all data of k.
const WATER_SELLMEIER_END_M: f64 = 1129e-9;

static WATER_TABLE: LazyLock<IndexTable> =
    LazyLock::new(|| embedded("water", include_str!("../../data/water_segelstein_1981_25C.csv")));
static WATER_INFRARED: LazyLock<IndexTable> = LazyLock::new(water_infrared);
static ICE_TABLE: LazyLock<IndexTable> =
    LazyLock::new(|| embedded("ice", include_str!("../../data/ice_warren_brandt_2008_266K.csv")));

/// A table that belongs to the program; a test checks that it reads.
fn embedded(name: &str, text: &str) -> IndexTable {
    IndexTable::parse(name, text).unwrap_or_else(|_| IndexTable {
        name: name.into(),
        wavelength_m: Vec::new(),
        n: Vec::new(),
        k: Vec::new(),
    })
}

/// Water beyond the Sellmeier formula, from where that ends, so that the index has no step (of 0.0015 in n).
fn water_infrared() -> IndexTable {
    let table = embedded("water", include_str!("../../data/water_hale_querry_1973_25C.csv"));
    let beyond = table.wavelength_m.partition_point(|wavelength_m| *wavelength_m <= WATER_SELLMEIER_END_M);
    let k = WATER_TABLE.index(WATER_SELLMEIER_END_M).map_or(0.0, |m| m.im);
    let from = |first: f64, rest: &[f64]| std::iter::once(first).chain(rest[beyond..].iter().copied()).collect();
    IndexTable {
        wavelength_m: from(WATER_SELLMEIER_END_M, &table.wavelength_m),
        n: from(water_n(WATER_SELLMEIER_END_M), &table.n),
        k: from(k, &table.k),
        name: table.name,
    }
}

fn water_index(wavelength_m: f64) -> Result<Complex64, MaterialError> {
    let beyond = wavelength_m > WATER_SELLMEIER_END_M;
    let table = if beyond { &WATER_INFRARED } else { &WATER_TABLE };
    let (first_m, last_m) = (WATER_TABLE.range_m().0, WATER_INFRARED.range_m().1);
    let m = table.index(wavelength_m).map_err(|_| out_of_range("water", wavelength_m, first_m, last_m))?;
    Ok(if beyond { m } else { Complex64::new(water_n(wavelength_m), m.im) })
}

impl Material {
    /// Reads `water`, `ice`, `1.33`, `1.33,0`, `n=1.33,k=0` or the name of a CSV file.
    ///
    /// # Errors
    /// When the text is none of these, the index is out of range or the file is defective.
    ///
    /// ```
    /// use mie_cloud::optics::material::Material;
    /// let no_files = |name: &str| Err(format!("{name} may not be read"));
    /// let material = Material::parse("n=1.5,k=0.01", &no_files)?;
    /// assert_eq!(material, Material::Constant { n: 1.5, k: 0.01 });
    /// # Ok::<(), mie_cloud::optics::material::MaterialError>(())
    /// ```
    pub fn parse(text: &str, read: ReadText) -> Result<Self, MaterialError> {
        let text = text.trim();
        let file = text.strip_prefix("csv:").unwrap_or(text).trim();
        match text {
            "water" => Ok(Self::Water),
            "ice" => Ok(Self::Ice),
            _ if file.to_lowercase().ends_with(".csv") || file != text => {
                let content = read(file)
                    .map_err(|reason| CsvError::Unreadable { file: file.into(), reason: reason.to_string() })?;
                Ok(Self::Table(Arc::new(IndexTable::parse(file, &content)?)))
            }
            _ => {
                let (n, k) = parse_index(text).ok_or_else(|| MaterialError::Unknown(text.into()))?;
                check_index(text, n, k)?;
                Ok(Self::Constant { n, k })
            }
        }
    }

    /// The refractive index m = n + ik, k >= 0, at a vacuum wavelength; relative to air taken as vacuum.
    ///
    /// # Errors
    /// When the wavelength is outside the material's data.
    pub fn index(&self, wavelength_m: f64) -> Result<Complex64, MaterialError> {
        match self {
            Self::Constant { n, k } => Ok(Complex64::new(*n, *k)),
            Self::Table(table) => table.index(wavelength_m),
            Self::Ice => ICE_TABLE.index(wavelength_m),
            Self::Water => water_index(wavelength_m),
        }
    }

    /// Density for turning liquid water content into droplets, kg/m^3; materials that are neither water nor ice take
    /// water's, since a content in g/m^3 means water unless it says otherwise.
    pub fn density_kg_per_m3(&self) -> f64 {
        match self {
            Self::Ice => ICE_KG_PER_M3,
            Self::Water | Self::Constant { .. } | Self::Table(_) => WATER_KG_PER_M3,
        }
    }

    /// The material as it is written in settings.
    pub fn name(&self) -> String {
        self.to_string()
    }
}

impl fmt::Display for Material {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Water => f.write_str("water"),
            Self::Ice => f.write_str("ice"),
            Self::Constant { n, k } => write!(f, "n={n},k={k}"),
            Self::Table(table) => write!(f, "csv:{}", table.name),
        }
    }
}

/// `1.33`, `1.33,0` or `n=1.33,k=0`.
fn parse_index(text: &str) -> Option<(f64, f64)> {
    let (n, k) = text.split_once(',').unwrap_or((text, "0"));
    let number = |part: &str, key: &str| -> Option<f64> {
        let part = part.trim();
        let value = match part.split_once('=') {
            Some((found, value)) => (found.trim() == key).then_some(value)?,
            None => part,
        };
        value.trim().parse().ok()
    };
    Some((number(n, "n")?, number(k, "k")?))
}

/// Index of water by the Sellmeier formula.
fn water_n(wavelength_m: f64) -> f64 {
    let square = (wavelength_m * 1e6).powi(2);
    (1.0 + WATER_SELLMEIER.iter().map(|(a, b)| a * square / (square - b)).sum::<f64>()).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Result<Material, MaterialError> {
        Material::parse(text, &|name| match name {
            "glass.csv" => Ok("wavelength_nm,n,k\n400,1.5,1e-8\n800,1.4,1e-6\n".into()),
            "swapped.csv" => Ok("k,n,wavelength_um\n0,1.5,0.4\n0,1.4,0.8\n".into()),
            "unsorted.csv" => Ok("wavelength_nm,n,k\n400,1.5,0\n300,1.4,0\n".into()),
            "gain.csv" => Ok("wavelength_nm,n,k\n400,1.5,-1e-9\n".into()),
            "headless.csv" => Ok("400,1.5,0\n".into()),
            _ => Err("no such file".into()),
        })
    }

    #[test]
    fn water_is_that_of_the_references() -> Result<(), MaterialError> {
        // n: Daimon & Masumura evaluated independently; k: Segelstein interpolated in logarithms.
        for (nm, n, k) in [(380.0, 1.345619, 1.943e-9), (430.0, 1.341017, 1.082e-9), (780.0, 1.328961, 1.406e-7)] {
            let m = Material::Water.index(nm * 1e-9)?;
            assert!((m.re - n).abs() < 1e-6, "{nm} {m}");
            assert!((m.im / k - 1.0).abs() < 1e-3, "{nm} {m}");
        }
        Ok(())
    }

    /// Rationale: infrared clouds. Expected: what Hale & Querry (1973) print, and no step where the formula ends.
    #[test]
    fn water_goes_on_in_the_infrared() -> Result<(), MaterialError> {
        for (um, n, k) in [(3.0, 1.371, 0.272), (10.0, 1.218, 0.0508), (200.0, 2.13, 0.504)] {
            let m = Material::Water.index(um * 1e-6)?;
            assert!((m.re - n).abs() < 1e-6 && (m.im - k).abs() < 1e-6, "{um} {m}");
        }
        let [before, after] = [-1e-9, 1e-9].map(|step| Material::Water.index(WATER_SELLMEIER_END_M * (1.0 + step)));
        assert!((before? - after?).norm() < 1e-9);
        Ok(())
    }

    #[test]
    fn ice_is_that_of_the_references() -> Result<(), MaterialError> {
        let m = Material::Ice.index(780e-9)?;
        assert!((m.re - 1.3053).abs() < 1e-9 && (m.im / 1.02e-7 - 1.0).abs() < 2e-3, "{m}");
        let m = Material::Ice.index(10e-6)?;
        assert!((m.re - 1.1926).abs() < 1e-6 && (m.im - 0.05008).abs() < 1e-6, "{m}");
        Ok(())
    }

    #[test]
    fn indices_are_read_in_every_spelling() {
        for text in ["1.33", "1.33,0", "n=1.33,k=0", " n = 1.33 , k = 0 ", "n=1.33"] {
            assert_eq!(parse(text), Ok(Material::Constant { n: 1.33, k: 0.0 }), "{text}");
        }
        for material in [Material::Water, Material::Ice, Material::Constant { n: 1.5, k: 0.25 }] {
            assert_eq!(parse(&material.name()), Ok(material));
        }
    }

    #[test]
    fn tables_interpolate_and_read_back() -> Result<(), MaterialError> {
        let glass = parse("glass.csv")?;
        assert_eq!(parse(&glass.name()), Ok(glass.clone()));
        let m = glass.index(565.685_424_949_238e-9)?;
        assert!((m.im / 1e-7 - 1.0).abs() < 1e-9, "halfway in the logarithms: {m}");
        assert_eq!(glass.index(800e-9)?, Complex64::new(1.4, 1e-6));
        assert_eq!(parse("swapped.csv")?.index(400e-9)?, Complex64::new(1.5, 0.0));
        Ok(())
    }

    #[test]
    fn defects_are_refused_with_a_remedy() {
        assert!(matches!(parse("1.33,-1e-9"), Err(MaterialError::Index { .. })));
        assert!(matches!(parse("gain.csv"), Err(MaterialError::Index { .. })));
        assert!(matches!(parse("NaN"), Err(MaterialError::Index { .. })));
        assert!(matches!(parse("unsorted.csv"), Err(MaterialError::Order { line: 3, .. })));
        assert!(matches!(parse("headless.csv"), Err(MaterialError::Header(_))));
        assert!(matches!(parse("other.csv"), Err(MaterialError::Csv(CsvError::Unreadable { .. }))));
        assert!(parse("wter").unwrap_err().to_string().contains("did you mean `water`"));
    }

    #[test]
    fn wavelengths_outside_the_data_are_refused() {
        let error = Material::Water.index(1e-3).unwrap_err().to_string();
        assert!(error.contains("1000000 nm") && error.contains("205.1162 to 200000 nm"), "{error}");
        assert!(Material::Water.index(190e-9).is_err());
        assert!(Material::Ice.index(10e-9).is_err());
        assert!(Material::Ice.index(f64::NAN).is_err());
        assert!(Material::Water.index(f64::NAN).is_err());
    }
}
