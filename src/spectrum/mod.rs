//! Wavelengths and colour: the observer, the sun, the bands, linear BT.709.

pub mod sun;

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
