//! The wavelengths of a picture and the linear map from their radiances to its channels.
//!
//! Legend: ell_w, radiance per unit of the light's reference irradiance at wavelength w (sr^-1); rgb = M ell.
//! In `bands` mode M_w integrates reference spectrum times colour matching over the band, to linear BT.709, times
//! pi over the whole band's Y: a white diffuser (ell = 1/pi everywhere) has luminance 1.

use std::f64::consts::PI;

use super::background::Uplift;
use super::basis;
use super::color::{BT709_LUMINANCE, apply, bt709_from_xyz};
use super::mode::SpectralMode;
use super::observer::{VISIBLE_MAX_NM, VISIBLE_MIN_NM, color_matching};
use super::sun::{SunSpectrum, integration_steps};

/// A distant light as the spectrum sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// Its spectrum.
    pub spectrum: SunSpectrum,
    /// Linear BT.709 colour; multiplies the spectrum through the basis in `bands` and the channels in `rgb`.
    pub color: [f64; 3],
    /// Illuminance before the colour, lx.
    pub lux: f64,
}

/// The wavelengths of a picture and what they contribute to its channels.
#[derive(Clone, Debug, PartialEq)]
pub struct SpectralSampling {
    mode: SpectralMode,
    reference: SunSpectrum,
    /// Vacuum wavelengths, m; the middle of each band: over all bands the errors of linear spectra cancel, which those
    /// of centroids do not (measured for wavelength^-4 in 8 bands: 1.0 % against 1.8 %).
    pub wavelengths_m: Vec<f64>,
    /// Edges of the bands, m; empty in `mono` and `rgb`.
    pub band_edges_m: Vec<f64>,
    /// What a unit of ell at each wavelength adds to R, G and B.
    pub rgb_weights: Vec<[f64; 3]>,
    /// Share of each wavelength in luminance; adds up to 1.
    pub luminance_weights: Vec<f64>,
    uplift: Uplift,
}

impl SpectralSampling {
    /// The sampling of a mode; `reference` is the spectrum that weighs the bands (the scene's sun).
    pub fn new(mode: SpectralMode, reference: SunSpectrum) -> Self {
        match mode {
            SpectralMode::Mono { wavelength_m } => {
                Self::direct(mode, reference, vec![wavelength_m], vec![[1.0; 3]], vec![1.0])
            }
            SpectralMode::Rgb { wavelengths_m } => {
                let identity = vec![[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
                Self::direct(mode, reference, wavelengths_m.to_vec(), identity, normalized(&BT709_LUMINANCE))
            }
            SpectralMode::Bands { count } => Self::bands(mode, reference, count.max(1)),
        }
    }

    /// `mono` and `rgb`: radiances go straight into the channels.
    fn direct(
        mode: SpectralMode,
        reference: SunSpectrum,
        wavelengths_m: Vec<f64>,
        rgb_weights: Vec<[f64; 3]>,
        luminance_weights: Vec<f64>,
    ) -> Self {
        let uplift = if wavelengths_m.len() == 1 { Uplift::luminance() } else { Uplift::identity() };
        Self { mode, reference, wavelengths_m, band_edges_m: Vec::new(), rgb_weights, luminance_weights, uplift }
    }

    fn bands(mode: SpectralMode, reference: SunSpectrum, count: usize) -> Self {
        let edges_nm = band_edges_nm(count);
        let bands: Vec<Band> = edges_nm.windows(2).map(|edge| Band::new(reference, edge[0], edge[1])).collect();
        let total_y: f64 = bands.iter().map(|band| band.xyz[1]).sum();
        let to_rgb = bt709_from_xyz();
        let weight = |band: &Band| apply(&to_rgb, band.xyz.map(|value| value * PI / total_y));
        let mut rgb_weights: Vec<[f64; 3]> = bands.iter().map(weight).collect();
        if count < 4 {
            make_white_gray(&mut rgb_weights);
        }
        let shares: Vec<[f64; 3]> = bands.iter().map(|band| band.shares).collect();
        Self {
            mode,
            reference,
            wavelengths_m: bands.iter().map(|band| band.middle_nm * 1e-9).collect(),
            band_edges_m: edges_nm.iter().map(|nm| nm * 1e-9).collect(),
            luminance_weights: bands.iter().map(|band| band.xyz[1] / total_y).collect(),
            uplift: Uplift::bands(&rgb_weights, &shares),
            rgb_weights,
        }
    }

    /// The mode that was sampled.
    pub fn mode(&self) -> SpectralMode {
        self.mode
    }

    /// The channels of a picture whose radiance per unit of reference irradiance is `ell`, one value per wavelength.
    pub fn to_rgb(&self, ell: &[f64]) -> [f64; 3] {
        let mut rgb = [0.0; 3];
        for (ell, weights) in ell.iter().zip(&self.rgb_weights) {
            for (channel, weight) in rgb.iter_mut().zip(weights) {
                *channel += ell * weight;
            }
        }
        rgb
    }

    /// Per light, the factor per wavelength that its ell is multiplied by before all lights are added.
    ///
    /// In `bands` a light's factor is its share of the total lux times its spectrum over the reference (both of one
    /// lux) times its colour. In `mono` and `rgb` the brightest light has `irradiance` and the others are in
    /// proportion to their lux; colour multiplies the channels of `rgb` and does nothing in `mono`.
    pub fn light_weights(&self, lights: &[Light], irradiance: f64) -> Vec<Vec<f64>> {
        let brightest = lights.iter().map(|light| light.lux).fold(0.0, f64::max);
        let total: f64 = lights.iter().map(|light| light.lux).sum();
        let share = |part: f64, whole: f64| if whole > 0.0 { part / whole } else { 0.0 };
        let weigh = |light: &Light| match self.mode {
            SpectralMode::Mono { .. } => vec![irradiance * share(light.lux, brightest)],
            SpectralMode::Rgb { .. } => {
                light.color.iter().map(|color| color * irradiance * share(light.lux, brightest)).collect()
            }
            SpectralMode::Bands { .. } => {
                let lux_share = share(light.lux, total);
                self.spectrum_ratios(light).into_iter().map(|ratio| ratio * lux_share).collect()
            }
        };
        lights.iter().map(weigh).collect()
    }

    /// What `light_weights` gives the lights' whole irradiance in `bands`, the brightest light's otherwise: 1 and `irradiance`.
    pub fn reference_irradiance(&self, irradiance: f64) -> f64 {
        if matches!(self.mode, SpectralMode::Bands { .. }) { 1.0 } else { irradiance }
    }

    /// A coloured light's spectrum over the reference, band by band; both spectra scaled to the same illuminance.
    fn spectrum_ratios(&self, light: &Light) -> Vec<f64> {
        let whole = self.reference.xyz()[1] / light.spectrum.xyz()[1];
        let ratio = |edge: &[f64]| {
            let (from_nm, to_nm) = (edge[0] * 1e9, edge[1] * 1e9);
            let shares = Band::new(light.spectrum, from_nm, to_nm).shares;
            let tint: f64 = shares.iter().zip(light.color).map(|(share, color)| share * color).sum();
            if light.spectrum == self.reference {
                return tint;
            }
            let y = |spectrum: SunSpectrum| spectrum.xyz_between(from_nm, to_nm)[1];
            tint * whole * y(light.spectrum) / y(self.reference)
        };
        self.band_edges_m.windows(2).map(ratio).collect()
    }

    /// The ell of a constant background that comes out as `rgb`: exactly for grey in every mode and for every colour
    /// in `rgb` and from three bands on; never negative where the bands can show the colour at all.
    ///
    /// In `mono` the background has the luminance of the colour.
    pub fn background_spectrum(&self, rgb: [f64; 3]) -> Vec<f64> {
        self.uplift.spectrum(&self.rgb_weights, rgb)
    }

    /// As `background_spectrum`, into a buffer of one value per wavelength; what could not but be negative is 0.
    pub fn background_spectrum_into(&self, rgb: [f64; 3], out: &mut [f64]) {
        self.uplift.spectrum_into(&self.rgb_weights, rgb, out);
        out.iter_mut().for_each(|value| *value = value.max(0.0));
    }

    /// The luminance of pixel value 1.0 in `bands` mode, cd/m^2: a white diffuser facing all lights together.
    pub fn white_luminance_cd_m2(&self, total_lux: f64) -> Option<f64> {
        matches!(self.mode, SpectralMode::Bands { .. }).then_some(total_lux / PI)
    }
}

/// What one band contributes.
struct Band {
    /// Integral of spectrum times colour matching.
    xyz: [f64; 3],
    /// Middle of the band, nm.
    middle_nm: f64,
    /// The colour basis, averaged over the light that is seen (spectrum times x + y + z).
    shares: [f64; 3],
}

impl Band {
    fn new(spectrum: SunSpectrum, from_nm: f64, to_nm: f64) -> Self {
        let steps = integration_steps(from_nm, to_nm);
        let step_nm = (to_nm - from_nm) / steps as f64;
        let (mut seen, mut shares) = (0.0, [0.0; 3]);
        for i in 0..steps {
            let nm = from_nm + (i as f64 + 0.5) * step_nm;
            let weight = spectrum.irradiance_per_nm(nm) * color_matching(nm).iter().sum::<f64>();
            seen += weight;
            for (sum, share) in shares.iter_mut().zip(basis::shares(nm)) {
                *sum += weight * share;
            }
        }
        let shares = shares.map(|sum| sum / seen);
        Self { xyz: spectrum.xyz_between(from_nm, to_nm), middle_nm: 0.5 * (from_nm + to_nm), shares }
    }
}

fn band_edges_nm(count: usize) -> Vec<f64> {
    let width = VISIBLE_MAX_NM - VISIBLE_MIN_NM;
    (0..=count).map(|i| VISIBLE_MIN_NM + width * i as f64 / count as f64).collect()
}

/// One to three bands are too few to show D65 without negative light: the channels are scaled so that white light is grey, luminance kept.
fn make_white_gray(rgb_weights: &mut [[f64; 3]]) {
    for channel in 0..3 {
        let white: f64 = rgb_weights.iter().map(|weights| weights[channel]).sum();
        rgb_weights.iter_mut().for_each(|weights| weights[channel] *= PI / white);
    }
}

fn normalized(values: &[f64]) -> Vec<f64> {
    let sum: f64 = values.iter().sum();
    values.iter().map(|value| value / sum).collect()
}
