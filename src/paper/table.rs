//! The figures' numbers as text for people and as CSV.

use std::f64::consts::PI;
use std::io::{self, Write};

use super::exact::ExactSphere;
use super::figures::{Channel, INDEX, WAVELENGTHS_NM};
use super::formulas::{Caution, Variant, efficiencies, size_parameter};
use super::study::{Column, Numbers, Study};
use crate::mie::MieError;

/// Writes one line per figure, column and colour.
///
/// # Errors
/// When `out` does not take it.
pub fn write_csv(studies: &[Study], out: &mut dyn Write) -> io::Result<()> {
    writeln!(
        out,
        "figure,diameter_nm,column,channel,wavelength_nm,x,q_sca,q_abs,g,forward_over_backward,hemispheres,effects,\
         caption,verdict,evidence"
    )?;
    for study in studies {
        for column in &study.columns {
            for channel in Channel::ALL {
                write_line(study, column, channel, out)?;
            }
        }
    }
    Ok(())
}

fn write_line(study: &Study, column: &Column, channel: Channel, out: &mut dyn Write) -> io::Result<()> {
    let Numbers { x, q_sca, q_abs, g, forward_over_backward, hemispheres } = column.numbers[channel as usize];
    let (number, d, wavelength) = (study.figure.number, study.figure.diameter_nm, WAVELENGTHS_NM[channel as usize]);
    let (method, name, effects) = (column.method.name(), channel.name(), &column.effects);
    write!(out, "{number},{d},{method},{name},{wavelength},{x},{q_sca},{q_abs},{g},{forward_over_backward},")?;
    let caption = caption(study).unwrap_or_default();
    writeln!(out, "{hemispheres},{effects},{caption},{},\"{}\"", study.verdict.answer(), study.verdict.evidence)
}

/// What the figure's caption says.
pub fn caption(study: &Study) -> Option<String> {
    study.figure.claim.map(|claim| claim.to_string())
}

/// The table for people: a block per figure, then what the whole of it shows.
///
/// # Errors
/// Never in the solver's domain.
pub fn text(studies: &[Study]) -> Result<String, MieError> {
    let head = "d (nm)      column     Q_sca                   Q_abs                   g               p(0)/p(180)";
    let mut text =
        format!("Red, green, blue: {} nm; n = {}.\n\n{head}\n", WAVELENGTHS_NM.map(short).join(", "), INDEX.re);
    for study in studies {
        for (i, column) in study.columns.iter().enumerate() {
            let d = if i == 0 { study.figure.diameter_nm.to_string() } else { String::new() };
            let of = |format: fn(&Numbers) -> String| column.numbers.each_ref().map(format).join(" ");
            let (q_sca, q_abs) =
                (of(|n| format!("{:7.4}", n.q_sca)), of(|n| format!("{:7.4}", positive_zero(n.q_abs))));
            let (g, ratio) = (of(|n| format!("{:.2}", n.g)), of(|n| format!("{:>5}", short(n.forward_over_backward))));
            text += &format!("{d:<11} {:<10} {q_sca} {q_abs} {g:>15} {ratio}\n", column.method.name());
        }
        let said = caption(study).map_or_else(String::new, |caption| format!("\"{caption}\": "));
        text += &format!("            {said}{}; {}\n\n", study.verdict.answer(), study.verdict.evidence);
    }
    text += &sensitivity()?;
    if let Some(Column { effects, .. }) = studies.first().and_then(|study| study.columns.last()) {
        text += &format!("Effects in the exact pictures: {effects}.\n");
    }
    Ok(text)
}

/// The two figures that differ by 0.6 nm, and how little theory and listing make of it.
pub fn sensitivity() -> Result<String, MieError> {
    const DIAMETERS_NM: [f64; 2] = [312.6126, 313.2132];
    let blue = WAVELENGTHS_NM[Channel::Blue as usize];
    let [before, after] = DIAMETERS_NM.map(|d| ExactSphere::new(d, blue, INDEX));
    let (before, after) = (before?, after?);
    let theta: Vec<f64> = (0..=1800).map(|tenth| f64::from(tenth) * PI / 1800.0).collect();
    let changes = before.phase(&theta)?.into_iter().zip(after.phase(&theta)?).map(|(a, b)| (b / a - 1.0).abs());
    let [listed, risen] =
        DIAMETERS_NM.map(|d| efficiencies(Variant::Listing, Caution::BeforeNan, size_parameter(d, blue), INDEX).q_sca);
    Ok(format!(
        "From {} to {} nm blue Q_sca rises by {:.2} % in exact Mie and {:.2} % in the listing; exact p changes by at most \
         {:.1} % at any angle.\n",
        DIAMETERS_NM[0],
        DIAMETERS_NM[1],
        100.0 * (after.q_sca() / before.q_sca() - 1.0),
        100.0 * (risen / listed - 1.0),
        100.0 * changes.fold(0.0, f64::max)
    ))
}

/// Rounding errors are shown as 0, not as -0.
fn positive_zero(value: f64) -> f64 {
    if value.abs() < 5e-5 { 0.0 } else { value }
}

/// Two digits below ten, none above.
pub fn short(value: f64) -> String {
    if value < 10.0 { format!("{value:.1}") } else { format!("{value:.0}") }
}
