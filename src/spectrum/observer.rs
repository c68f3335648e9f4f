//! The CIE 1931 2-degree observer.

use std::sync::LazyLock;

use super::table::WavelengthTable;

/// Luminous efficacy of radiation at the observer's peak, lm/W (CIE 015: K_m = 683.002 for the tabulated V).
pub const LUMENS_PER_WATT: f64 = 683.002;

/// Shortest wavelength that pictures are integrated over, nm.
pub const VISIBLE_MIN_NM: f64 = 380.0;

/// Longest wavelength that pictures are integrated over, nm.
pub const VISIBLE_MAX_NM: f64 = 780.0;

static OBSERVER: LazyLock<WavelengthTable<3>> =
    LazyLock::new(|| WavelengthTable::from_embedded(include_str!("../../data/cie_1931_2deg_xyz_1nm_360_830.csv")));

/// The colour-matching functions at a vacuum wavelength in nm, linear between 1 nm steps; zero outside 360-830 nm.
pub fn color_matching(wavelength_nm: f64) -> [f64; 3] {
    OBSERVER.at(wavelength_nm)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_observer_is_whole() {
        assert_eq!(OBSERVER.len(), 471);
        assert_eq!(color_matching(555.0)[1], 1.0);
        assert_eq!(color_matching(359.0), [0.0; 3]);
    }
}
