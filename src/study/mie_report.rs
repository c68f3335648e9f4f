//! What a scatterer does to light as a list of named quantities with units: the data behind `mie-cloud mie`.

use std::f64::consts::PI;

use num_complex::Complex64;

use super::scatterer::{Cloud, Scatterer, Sphere};
use crate::mie::{MieError, ScatteringMatrix};
use crate::optics::size_average::Change;
use crate::units::format_in;

/// What the angular columns mean, for every format.
pub const NORMALIZATION: &str = "phase integrates to 1 over the sphere; dC_sca/dOmega = S11 / k^2 with k = 2 pi / \
     lambda, so phase = S11 / (k^2 C_sca), for one sphere (|S1|^2 + |S2|^2) / (2 pi x^2 Q_sca); matrix elements of a \
     distribution are means per droplet; m = n + ik with k >= 0 for absorption, time factor exp(-i omega t); \
     conventions of Bohren & Huffman 1983, eqs. 4.74-4.77; the medium is air, taken as vacuum";

/// A number, with what it is.
#[derive(Clone, Debug, PartialEq)]
pub struct Quantity {
    /// Name in files.
    pub key: &'static str,
    /// The value.
    pub value: Value,
    /// Unit; `1` for pure numbers.
    pub unit: &'static str,
    /// What it is.
    pub meaning: &'static str,
}

/// The value of a quantity.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// A number.
    Number(f64),
    /// How many.
    Count(usize),
    /// Real and imaginary part.
    Complex(Complex64),
    /// A description.
    Text(String),
    /// Several numbers with their names.
    Fields(Vec<(&'static str, f64)>),
    /// There is none: a quotient whose denominator is zero.
    Undefined,
}

/// A function of the scattering angle.
#[derive(Clone, Debug, PartialEq)]
pub struct Column {
    /// Name in files.
    pub key: &'static str,
    /// One value per angle.
    pub values: ColumnValues,
    /// Unit; `1` for pure numbers.
    pub unit: &'static str,
    /// What it is.
    pub meaning: &'static str,
}

/// The values of a column.
#[derive(Clone, Debug, PartialEq)]
pub enum ColumnValues {
    /// Numbers.
    Real(Vec<f64>),
    /// Complex numbers.
    Complex(Vec<Complex64>),
    /// There are none: nothing is scattered.
    Undefined,
}

/// Everything that is known of a scatterer.
#[derive(Clone, Debug, PartialEq)]
pub struct MieReport {
    /// Numbers that do not depend on the angle.
    pub quantities: Vec<Quantity>,
    /// Scattering angles, degrees; 0 is forward.
    pub angles_deg: Vec<f64>,
    /// Functions of the scattering angle.
    pub columns: Vec<Column>,
}

impl MieReport {
    /// The report of a scatterer at scattering angles in degrees, each in 0 ..= 180.
    ///
    /// # Errors
    /// When an angle is out of range.
    ///
    /// ```
    /// use mie_cloud::study::{MieReport, Scatterer};
    /// use num_complex::Complex64;
    ///
    /// let sphere = Scatterer::relative_sphere(10.0, Complex64::new(1.33, 0.0))?;
    /// let report = MieReport::new(&sphere, &[0.0, 90.0, 180.0])?;
    /// assert_eq!(report.columns[0].key, "phase");
    /// # Ok::<(), mie_cloud::mie::MieError>(())
    /// ```
    pub fn new(scatterer: &Scatterer, angles_deg: &[f64]) -> Result<Self, MieError> {
        let theta_rad: Vec<f64> = angles_deg.iter().map(|deg| deg.to_radians()).collect();
        let scale = scatterer.phase_scale();
        let (quantities, columns) = match scatterer {
            Scatterer::Cloud(cloud) => {
                let matrices = scatterer.matrices(&theta_rad)?;
                (cloud_quantities(cloud), matrix_columns(&matrices, scale))
            }
            Scatterer::Sphere(sphere) => {
                let (s1, s2) = sphere.amplitudes(&theta_rad)?;
                let pairs = s1.iter().zip(&s2);
                let matrices: Vec<_> = pairs.map(|(s1, s2)| ScatteringMatrix::from_amplitudes(*s1, *s2)).collect();
                let mut columns = matrix_columns(&matrices, scale);
                let amplitude = |key, values, meaning| column(key, ColumnValues::Complex(values), "1", meaning);
                columns.push(amplitude("s1", s1, "amplitude across the scattering plane"));
                columns.push(amplitude("s2", s2, "amplitude in the scattering plane"));
                (sphere_quantities(sphere), columns)
            }
        };
        Ok(Self { quantities, angles_deg: angles_deg.to_vec(), columns })
    }
}

fn matrix_columns(matrices: &[ScatteringMatrix], phase_scale: Option<f64>) -> Vec<Column> {
    let real = |element: &dyn Fn(&ScatteringMatrix) -> f64| ColumnValues::Real(matrices.iter().map(element).collect());
    let phase = phase_scale.map_or(ColumnValues::Undefined, |scale| real(&|m| m.s11 * scale));
    vec![
        column("phase", phase, "sr^-1", "phase function p"),
        column("s11", real(&|m| m.s11), "1", "(|S2|^2 + |S1|^2) / 2"),
        column("s12", real(&|m| m.s12), "1", "(|S2|^2 - |S1|^2) / 2"),
        column("s33", real(&|m| m.s33), "1", "Re(S1 S2*)"),
        column("s34", real(&|m| m.s34), "1", "Im(S2 S1*)"),
    ]
}

fn column(key: &'static str, values: ColumnValues, unit: &'static str, meaning: &'static str) -> Column {
    Column { key, values, unit, meaning }
}

fn sphere_quantities(sphere: &Sphere) -> Vec<Quantity> {
    let (x, m, q) = (sphere.series.x, sphere.series.m, sphere.series.efficiencies());
    let mut list = Vec::new();
    if let Some(d) = sphere.dimensions {
        list.push(number("radius_um", in_unit(d.radius_m, 1e6), "um", "radius"));
        list.push(wavelength(d.wavelength_m));
    }
    list.push(number("size_parameter", x, "1", "x = 2 pi r / lambda"));
    list.push(index(m));
    list.push(quantity("terms", Value::Count(q.n_terms), "1", "partial waves summed"));
    list.push(number("q_ext", q.q_ext, "1", "extinction efficiency C_ext / (pi r^2)"));
    list.push(number("q_sca", q.q_sca, "1", "scattering efficiency"));
    list.push(number("q_abs", q.q_abs, "1", "absorption efficiency"));
    list.push(number("q_back", q.q_back, "1", "radar backscattering efficiency 4 |S1(180 deg)|^2 / x^2"));
    list.push(number("q_pr", q.q_pr, "1", "radiation pressure efficiency Q_ext - g Q_sca"));
    list.push(albedo(q.q_sca, q.q_ext));
    list.push(asymmetry(q.g, q.q_sca));
    if let Some(d) = sphere.dimensions {
        let area_m2 = PI * d.radius_m * d.radius_m;
        list.extend(cross_sections([area_m2 * q.q_ext, area_m2 * q.q_sca, area_m2 * q.q_abs]));
    }
    list
}

fn cloud_quantities(cloud: &Cloud) -> Vec<Quantity> {
    let (law, average) = (cloud.distribution.law(), &cloud.average);
    let c = &average.cross_sections;
    let change = if c.c_sca_m2 > 0.0 { Value::Fields(changes(&average.change)) } else { Value::Undefined };
    let convergence = "change at the last doubling of the radii: c_ext and phase relative, g absolute";
    let mut list = vec![
        quantity("distribution", Value::Text(cloud.distribution.to_string()), "text", "size distribution by number"),
        number("radius_min_um", in_unit(cloud.distribution.r_min_m, 1e6), "um", "smallest radius"),
        number("radius_max_um", in_unit(cloud.distribution.r_max_m, 1e6), "um", "largest radius"),
        number("effective_radius_um", in_unit(law.effective_radius_m(), 1e6), "um", "mean r^3 / mean r^2"),
        number("effective_variance", law.effective_variance(), "1", "area-weighted variance of r / r_eff^2"),
        wavelength(cloud.wavelength_m),
        index(cloud.m),
        quantity("radii", Value::Count(average.ensemble.len()), "1", "radii that were averaged"),
        quantity("convergence", change, "1", convergence),
        number("area_m2", law.mean_area_m2(), "m^2", "mean geometric cross section"),
    ];
    list.extend(cross_sections([c.c_ext_m2, c.c_sca_m2, c.c_abs_m2]));
    list.push(albedo(c.c_sca_m2, c.c_ext_m2));
    list.push(asymmetry(c.g, c.c_sca_m2));
    list
}

fn changes(change: &Change) -> Vec<(&'static str, f64)> {
    vec![("c_ext", change.c_ext), ("g", change.g), ("phase_median", change.p_median), ("phase_worst", change.p_worst)]
}

fn quantity(key: &'static str, value: Value, unit: &'static str, meaning: &'static str) -> Quantity {
    Quantity { key, value, unit, meaning }
}

fn number(key: &'static str, value: f64, unit: &'static str, meaning: &'static str) -> Quantity {
    quantity(key, Value::Number(value), unit, meaning)
}

fn index(m: Complex64) -> Quantity {
    quantity("index", Value::Complex(m), "1", "refractive index n + ik")
}

fn wavelength(wavelength_m: f64) -> Quantity {
    number("wavelength_nm", in_unit(wavelength_m, 1e9), "nm", "vacuum wavelength")
}

fn cross_sections([c_ext_m2, c_sca_m2, c_abs_m2]: [f64; 3]) -> [Quantity; 3] {
    [
        number("c_ext_m2", c_ext_m2, "m^2", "extinction cross section per droplet"),
        number("c_sca_m2", c_sca_m2, "m^2", "scattering cross section per droplet"),
        number("c_abs_m2", c_abs_m2, "m^2", "absorption cross section per droplet"),
    ]
}

fn albedo(scattered: f64, removed: f64) -> Quantity {
    let value = if removed > 0.0 { Value::Number(scattered / removed) } else { Value::Undefined };
    quantity("albedo", value, "1", "single-scattering albedo, scattering / extinction")
}

fn asymmetry(g: f64, scattered: f64) -> Quantity {
    let value = if scattered > 0.0 { Value::Number(g) } else { Value::Undefined };
    quantity("g", value, "1", "asymmetry parameter, mean cosine of the scattering angle")
}

/// A value in a smaller unit, as a person would have written it: 5e-6 m are 5 um, not 4.999999999999999.
fn in_unit(value: f64, per_unit: f64) -> f64 {
    format_in(value, per_unit).parse().unwrap_or(value * per_unit)
}
