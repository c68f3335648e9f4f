//! What stands above a plot: the scatterer and its numbers, as a paper would write them.

use num_complex::Complex64;

use super::axis::power_of_ten;
use crate::study::scatterer::Scatterer;
use crate::units::format_in;

/// Two lines above a plot.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Caption {
    /// What is shown.
    pub title: String,
    /// Its numbers, in smaller letters.
    pub numbers: String,
}

impl Caption {
    /// The caption of a scatterer; `material` is the name of what it is made of, where it has one.
    pub fn new(scatterer: &Scatterer, material: Option<&str>) -> Self {
        let of = material.map_or_else(String::new, |name| format!(" of {name}"));
        let index = index(scatterer.index());
        match scatterer {
            Scatterer::Cloud(cloud) => {
                let c = cloud.average.cross_sections;
                let (ext, sca) = (short(c.c_ext_m2 * 1e12), short(c.c_sca_m2 * 1e12));
                Self {
                    title: format!("Spheres{of}, {}, λ = {}", cloud.distribution, nm(cloud.wavelength_m)),
                    numbers: format!("{index},  C_ext = {ext} µm²,  C_sca = {sca} µm²,  g = {}", short(c.g)),
                }
            }
            Scatterer::Sphere(sphere) => {
                let (x, q) = (short(sphere.series.x), sphere.series.efficiencies());
                let numbers = format!("Q_ext = {},  Q_sca = {},  g = {}", short(q.q_ext), short(q.q_sca), short(q.g));
                match sphere.dimensions {
                    None => Self { title: format!("Sphere, x = {x}, {index}"), numbers },
                    Some(d) => Self {
                        title: format!("Sphere{of}, r = {} µm, λ = {}", short(d.radius_m * 1e6), nm(d.wavelength_m)),
                        numbers: format!("x = {x},  {index},  {numbers}"),
                    },
                }
            }
        }
    }
}

fn index(m: Complex64) -> String {
    if m.im > 0.0 { format!("m = {} + {} i", short(m.re), short(m.im)) } else { format!("m = {}", short(m.re)) }
}

fn nm(wavelength_m: f64) -> String {
    format_in(wavelength_m, 1e9) + " nm"
}

/// A number with five significant digits, without zeros at the end: 1.33, 2.4612×10⁻⁹.
pub(super) fn short(value: f64) -> String {
    let rounded: f64 = format!("{value:.4e}").parse().unwrap_or(value);
    if rounded == 0.0 || (1e-3..1e6).contains(&rounded.abs()) {
        return rounded.to_string().replace('-', "−");
    }
    let scientific = format!("{rounded:e}");
    let (digits, power) = scientific.split_once('e').unwrap_or((&scientific, "0"));
    let power = power_of_ten(power.parse().unwrap_or(0.0));
    if digits == "1" { power } else { format!("{}×{power}", digits.replace('-', "−")) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn short_numbers_keep_five_digits() {
        for (value, text) in [
            (0.0, "0"),
            (1.33, "1.33"),
            (57.119866, "57.12"),
            (-0.5, "−0.5"),
            (100_000.0, "100000"),
            (1e6, "10⁶"),
            (2.46118827e-9, "2.4612×10⁻⁹"),
            (0.0123456789, "0.012346"),
        ] {
            assert_eq!(short(value), text);
        }
    }

    #[test]
    fn captions_name_size_index_and_wavelength() {
        let sphere = Scatterer::relative_sphere(10.0, Complex64::new(1.5, 0.01)).unwrap();
        let caption = Caption::new(&sphere, Some("soot"));
        assert_eq!(caption.title, "Sphere, x = 10, m = 1.5 + 0.01 i");
        assert!(caption.numbers.starts_with("Q_ext = "), "{}", caption.numbers);
    }
}
