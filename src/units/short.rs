//! Quantities as people say them: rounded, each in the unit that it is small in. What is read back is written by `format_in`.

/// A number to three significant digits: without an exponent from a thousandth to a million.
///
/// ```
/// use mie_cloud::units::short::number;
/// assert_eq!([0.0, 0.20171, 34.0, 386_071.7, 4.2e-9].map(number), ["0", "0.202", "34", "386000", "4.2e-9"]);
/// ```
pub fn number(value: f64) -> String {
    let rounded: f64 = format!("{value:.2e}").parse().unwrap_or(value);
    // No number is minus nothing.
    let rounded = rounded + 0.0;
    if rounded == 0.0 || (1e-3..1e6).contains(&rounded.abs()) { rounded.to_string() } else { format!("{rounded:e}") }
}

/// A share as percent, to two significant digits or to whole percents; beyond tenfold it says no more.
///
/// ```
/// use mie_cloud::units::short::percent;
/// assert_eq!([0.0, 7.6e-4, 0.0234, 0.99, 144.0].map(percent), ["0 %", "0.076 %", "2.3 %", "99 %", ">1000 %"]);
/// assert_eq!(percent(1e-9), "<0.001 %");
/// ```
pub fn percent(share: f64) -> String {
    match 100.0 * share {
        0.0 => "0 %".into(),
        p if p.abs() < 1e-3 => "<0.001 %".into(),
        p if p > 1000.0 => ">1000 %".into(),
        p if p.abs() < 9.95 => {
            let rounded: f64 = format!("{p:.1e}").parse().unwrap_or(p);
            format!("{rounded} %")
        }
        p => format!("{p:.0} %"),
    }
}

/// Units of length, the largest first.
const LENGTHS: [(&str, f64); 6] = [("km", 1e3), ("m", 1.0), ("cm", 1e-2), ("mm", 1e-3), ("um", 1e-6), ("nm", 1e-9)];

/// A length to three significant digits.
///
/// ```
/// use mie_cloud::units::short::length;
/// assert_eq!([0.0, 7.5e-1, 1683.1, 0.052_09, 5e-6].map(length), ["0 m", "75 cm", "1.68 km", "5.21 cm", "5 um"]);
/// ```
pub fn length(length_m: f64) -> String {
    let fits = |(_, metres): &&(&str, f64)| length_m.abs() >= 0.9995 * metres;
    match LENGTHS.iter().find(fits) {
        Some((unit, metres)) => format!("{} {unit}", number(length_m / metres)),
        None => format!("{} m", number(length_m)),
    }
}

/// A length of time.
///
/// ```
/// use mie_cloud::units::short::time;
/// assert_eq!([0.4, 59.6, 99.0, 100.0, 3600.0, 7200.0, 9e5].map(time), ["0 s", "60 s", "99 s", "2 min", "60 min", "2 h", "10 days"]);
/// ```
pub fn time(seconds: f64) -> String {
    match seconds {
        s if s < 99.5 => format!("{s:.0} s"),
        s if s < 5970.0 => format!("{:.0} min", s / 60.0),
        s if s < 172_800.0 => format!("{:.0} h", s / 3600.0),
        s => format!("{:.0} days", s / 86_400.0),
    }
}

/// A count of things in words: `1 fog box`, `2 fog boxes`.
///
/// ```
/// assert_eq!(mie_cloud::units::short::amount(1, "droplet", "droplets"), "1 droplet");
/// ```
pub fn amount(n: usize, one: &str, many: &str) -> String {
    format!("{n} {}", if n == 1 { one } else { many })
}
