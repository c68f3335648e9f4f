//! The sun's spectral irradiance.

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
