//! What the spectral sampling promises: whites, greys, several lights, convergence in the number of bands.

use std::f64::consts::PI;

use mie_cloud::spectrum::color::{BT709_LUMINANCE, apply, bt709_from_xyz};
use mie_cloud::spectrum::sun::SunSpectrum;
use mie_cloud::spectrum::{Light, SpectralMode, SpectralSampling};

fn bands(count: usize) -> SpectralSampling {
    SpectralSampling::new(SpectralMode::Bands { count }, SunSpectrum::E490)
}

fn luminance(rgb: [f64; 3]) -> f64 {
    rgb.iter().zip(BT709_LUMINANCE).map(|(channel, weight)| channel * weight).sum()
}

fn modes() -> Vec<SpectralMode> {
    let counts = [1, 2, 3, 4, 5, 7, 8, 16, 64, 400];
    let texts = ["mono:550nm", "rgb", "rgb:700nm,550nm,400nm"];
    let named = texts.into_iter().map(|text| text.parse().expect(text));
    counts.into_iter().map(|count| SpectralMode::Bands { count }).chain(named).collect()
}

#[test]
fn a_white_diffuser_has_luminance_one() {
    for count in [1, 2, 3, 8, 17, 400] {
        let sampling = bands(count);
        let rgb = sampling.to_rgb(&vec![1.0 / PI; count]);
        // The published luminance row has four digits.
        assert!((luminance(rgb) - 1.0).abs() < 2e-4, "{count}: {rgb:?}");
        assert!((sampling.luminance_weights.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        assert!(sampling.luminance_weights.iter().all(|weight| *weight > 0.0));
    }
}

#[test]
fn a_white_diffuser_has_the_colour_of_the_sun() {
    let [x, y, z] = SunSpectrum::E490.xyz();
    let expected = apply(&bt709_from_xyz(), [x / y, 1.0, z / y]);
    let found = bands(8).to_rgb(&[1.0 / PI; 8]);
    for (found, expected) in found.iter().zip(expected) {
        assert!((found - expected).abs() < 1e-6, "{found} {expected}");
    }
}

#[test]
fn energy_weights_do_not_depend_on_the_number_of_bands() {
    let sum = |count| bands(count).to_rgb(&vec![1.0; count]);
    for count in [4, 7, 8, 33, 64] {
        for (a, b) in sum(count).iter().zip(sum(400)) {
            assert!((a / b - 1.0).abs() < 1e-5, "{count}: {a} {b}");
        }
    }
}

#[test]
fn eight_bands_agree_with_sixty_four_for_a_smooth_spectrum() {
    let render = |count, spectrum: &dyn Fn(f64) -> f64| {
        let sampling = bands(count);
        let ell: Vec<f64> = sampling.wavelengths_m.iter().map(|wavelength_m| spectrum(wavelength_m * 1e9)).collect();
        sampling.to_rgb(&ell)
    };
    let haze = |nm: f64| (550.0 / nm).powi(3);
    let hump = |nm: f64| 1.0 + 0.4 * ((nm - 520.0) / 80.0).sin();
    for spectrum in [&haze as &dyn Fn(f64) -> f64, &hump] {
        for (coarse, fine) in render(8, spectrum).into_iter().zip(render(64, spectrum)) {
            assert!((coarse / fine - 1.0).abs() < 0.01, "{coarse} {fine}");
        }
    }
}

#[test]
fn grey_backgrounds_come_out_grey_in_every_mode() {
    for mode in modes() {
        for spectrum in [SunSpectrum::E490, SunSpectrum::D65, SunSpectrum::G173Direct, SunSpectrum::Equal] {
            let sampling = SpectralSampling::new(mode, spectrum);
            let ell = sampling.background_spectrum([0.7; 3]);
            assert!(ell.iter().all(|value| *value >= 0.0), "{mode}: {ell:?}");
            for channel in sampling.to_rgb(&ell) {
                assert!((channel - 0.7).abs() < 1e-12, "{mode} {spectrum}: {channel}");
            }
        }
    }
}

#[test]
fn coloured_backgrounds_come_out_as_they_are() {
    let colors = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.2, 0.5, 0.9], [1.0, 0.9, 0.1], [0.0; 3]];
    for count in [3, 4, 8, 16, 64] {
        let sampling = bands(count);
        for color in colors {
            let ell = sampling.background_spectrum(color);
            for (found, expected) in sampling.to_rgb(&ell).into_iter().zip(color) {
                assert!((found - expected).abs() < 1e-10, "bands:{count} {color:?} {found}");
            }
            // Fewer than eight bands are too wide for saturated colours without negative light.
            assert!(count < 8 || ell.iter().all(|value| *value >= 0.0), "bands:{count} {color:?} {ell:?}");
        }
    }
}

#[test]
fn a_mono_background_has_the_colours_luminance() {
    let sampling = SpectralSampling::new(SpectralMode::Mono { wavelength_m: 550e-9 }, SunSpectrum::E490);
    let [ell] = sampling.background_spectrum([0.1, 0.2, 0.3])[..] else { panic!("one wavelength") };
    assert!((ell - luminance([0.1, 0.2, 0.3])).abs() < 1e-15);
}

#[test]
fn one_reference_light_has_weight_one() {
    let light = Light { spectrum: SunSpectrum::E490, color: [1.0; 3], lux: 1e5 };
    for weight in &bands(8).light_weights(&[light], 1.0)[0] {
        assert!((weight - 1.0).abs() < 1e-12);
    }
}

#[test]
fn lights_of_other_spectra_keep_their_lux_and_take_their_colour() {
    let sampling = bands(64);
    let light = |spectrum, lux| Light { spectrum, color: [1.0; 3], lux };
    let lights = [light(SunSpectrum::E490, 3e4), light(SunSpectrum::D65, 1e4)];
    let weights = sampling.light_weights(&lights, 1.0);
    let diffuser = |weights: &[f64]| sampling.to_rgb(&weights.iter().map(|w| w / PI).collect::<Vec<_>>());
    assert!((luminance(diffuser(&weights[0])) - 0.75).abs() < 2e-4);
    for channel in diffuser(&weights[1]) {
        assert!((channel - 0.25).abs() < 2e-4, "D65 is white: {channel}");
    }
}

#[test]
fn a_lights_colour_tints_the_spectrum() {
    let sampling = bands(8);
    let red = Light { spectrum: SunSpectrum::E490, color: [1.0, 0.0, 0.0], lux: 1e5 };
    let weights = &sampling.light_weights(&[red], 1.0)[0];
    assert!(weights[0].abs() < 1e-12 && (weights[7] - 1.0).abs() < 1e-12, "{weights:?}");
    let [r, g, b] = sampling.to_rgb(weights);
    assert!(r > 4.0 * g.abs() && r > 4.0 * b.abs(), "{r} {g} {b}");
}

#[test]
fn mono_and_rgb_lights_are_scaled_to_the_brightest() {
    let lights = [([1.0; 3], 5e4), ([0.5, 1.0, 0.25], 1e5)].map(|(color, lux)| Light {
        spectrum: SunSpectrum::E490,
        color,
        lux,
    });
    let of = |text: &str| SpectralSampling::new(text.parse().expect(text), SunSpectrum::E490);
    assert_eq!(of("mono:550nm").light_weights(&lights, 2.0), [[1.0], [2.0]]);
    assert_eq!(of("rgb").light_weights(&lights, 2.0), [[1.0; 3], [1.0, 2.0, 0.5]]);
    assert_eq!(of("rgb").to_rgb(&[1.0, 2.0, 3.0]), [1.0, 2.0, 3.0]);
    assert_eq!(of("mono:550nm").to_rgb(&[2.0]), [2.0; 3]);
}

#[test]
fn darkness_is_no_division_by_zero() {
    let dark = Light { spectrum: SunSpectrum::E490, color: [1.0; 3], lux: 0.0 };
    for mode in modes() {
        let sampling = SpectralSampling::new(mode, SunSpectrum::E490);
        assert!(sampling.light_weights(&[dark], 1.0)[0].iter().all(|weight| *weight == 0.0));
    }
}

#[test]
fn representative_wavelengths_lie_in_their_bands() {
    for count in [1, 3, 8, 400] {
        let sampling = bands(count);
        for (edge, wavelength_m) in sampling.band_edges_m.windows(2).zip(&sampling.wavelengths_m) {
            assert!(edge[0] < *wavelength_m && *wavelength_m < edge[1]);
        }
    }
}
