//! A fixed smooth basis that spreads red, green and blue over the spectrum and adds up to one everywhere.

use std::f64::consts::FRAC_PI_2;

/// Where blue has given way to green halfway, nm: between the blue and green primaries' dominant wavelengths
/// (464 and 549 nm; CIE 015 construction from the chromaticities of BT.709).
const BLUE_GREEN_NM: f64 = 500.0;

/// Where green has given way to red halfway, nm: between the green and red primaries' dominant wavelengths
/// (549 and 611 nm).
const GREEN_RED_NM: f64 = 585.0;

/// Half the width over which one gives way to the next, nm: as wide as fits between the two crossings.
const HALF_WIDTH_NM: f64 = 40.0;

/// The shares of red, green and blue at a wavelength in nm; each in 0 ..= 1, together 1.
pub fn shares(wavelength_nm: f64) -> [f64; 3] {
    let not_blue = smooth_step((wavelength_nm - BLUE_GREEN_NM) / HALF_WIDTH_NM);
    let red = smooth_step((wavelength_nm - GREEN_RED_NM) / HALF_WIDTH_NM);
    [red, not_blue - red, 1.0 - not_blue]
}

/// Rises from 0 at -1 to 1 at +1, with a continuous slope.
fn smooth_step(t: f64) -> f64 {
    0.5 + 0.5 * (t.clamp(-1.0, 1.0) * FRAC_PI_2).sin()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_are_a_partition_of_unity() {
        for nm in 300..=900 {
            let [r, g, b] = shares(f64::from(nm));
            assert!((r + g + b - 1.0).abs() < 1e-15);
            assert!([r, g, b].iter().all(|share| (0.0..=1.0).contains(share)), "{nm}");
        }
        assert_eq!(shares(400.0), [0.0, 0.0, 1.0]);
        assert_eq!(shares(700.0), [1.0, 0.0, 0.0]);
    }
}
