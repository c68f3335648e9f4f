//! The names by which spectra are stored in OpenEXR.
//!
//! Layout: Fichet, Pacanowski and Wilkie 2021, "An OpenEXR Layout for Spectral Images", JCGT 10(3): radiance at one
//! wavelength is a channel `S0.<wavelength>nm` with a comma before the decimals, beside plain R, G, B.

use super::picture::{Attribute, Channel, Picture};

/// Value of the attribute `spectralLayoutVersion`.
pub const LAYOUT_VERSION: &str = "1.0";

/// Unit of absolute spectral radiance, as the attribute `emissiveUnits` writes it. Renders are relative to the suns' irradiance: sr^-1.
pub const SPECTRAL_RADIANCE: &str = "W.m^-2.sr^-1.nm^-1";

/// Name of the unpolarised radiance channel at a wavelength in nanometres, with six decimals as the authors' library
/// writes it (`EXRSpectralImage::getEmissiveChannelName`).
///
/// ```
/// assert_eq!(mie_cloud::image::spectral::channel_name(550.0), "S0.550,000000nm");
/// ```
pub fn channel_name(wavelength_nm: f64) -> String {
    let number = format!("{wavelength_nm:.6}").replace('.', ",");
    format!("S0.{number}nm")
}

/// The wavelength in nanometres of a radiance channel, `None` for any other channel.
pub fn wavelength_nm(channel_name: &str) -> Option<f64> {
    let number = channel_name.strip_prefix("S0.")?.strip_suffix("nm")?;
    if !number.starts_with(|first: char| first.is_ascii_digit() || first == ',') || number.contains('.') {
        return None;
    }
    number.replacen(',', ".", 1).parse().ok()
}

/// Adds a radiance channel per wavelength and the attributes that the layout asks for.
///
/// `planes` pairs a wavelength in nanometres with one value per pixel; `units` is [`SPECTRAL_RADIANCE`], or what else
/// the values are in.
pub fn add_spectrum(picture: &mut Picture, planes: impl IntoIterator<Item = (f64, Vec<f32>)>, units: &str) {
    picture.channels.extend(channels(planes));
    picture.record("emissiveUnits", Attribute::Text(units.into()));
    picture.record("spectralLayoutVersion", Attribute::Text(LAYOUT_VERSION.into()));
}

/// One radiance channel per wavelength in nanometres.
pub fn channels(planes: impl IntoIterator<Item = (f64, Vec<f32>)>) -> Vec<Channel> {
    planes.into_iter().map(|(wavelength, values)| Channel { name: channel_name(wavelength), values }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_follow_the_layout_and_are_read_back() {
        for (wavelength, name) in
            [(380.0, "S0.380,000000nm"), (412.5, "S0.412,500000nm"), (1000.25, "S0.1000,250000nm")]
        {
            assert_eq!(channel_name(wavelength), name);
            assert_eq!(wavelength_nm(name), Some(wavelength));
        }
        assert_eq!(wavelength_nm("S0.550nm"), Some(550.0));
        for other in ["R", "S1.550,0nm", "S0.nm", "S0.5.5nm", "S0.-5,0nm", "T.550,0nm", "S0.infnm"] {
            assert_eq!(wavelength_nm(other), None, "{other}");
        }
    }

    #[test]
    fn the_layout_is_announced() {
        let mut picture = Picture::new(1, 1);
        add_spectrum(&mut picture, [(450.0, vec![1.0]), (650.0, vec![2.0])], SPECTRAL_RADIANCE);
        assert_eq!(picture.channel("S0.650,000000nm"), Some(&[2.0_f32][..]));
        assert_eq!(picture.attribute("spectralLayoutVersion"), Some(&Attribute::Text("1.0".into())));
    }
}
