//! What the captions claim, each as a small test on exact numbers.

use std::fmt;

use super::exact::ExactSphere;
use super::figures::Channel;
use crate::mie::MieError;

/// A colour is strong when it is scattered this many times as much as every other.
const STRONG: f64 = 1.5;

/// Light goes evenly in all directions when neither hemisphere gets more than this many times the other. A dipole has 1.
const EVEN: f64 = 1.5;

/// A narrow forward beam holds half of the light within 15 degrees. (The paper's g = 0.9 puts 66 % there.)
const BEAM_DEG: f64 = 15.0;
const BEAM_SHARE: f64 = 0.5;

/// What a caption says, in short.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Claim {
    /// All colours go into a narrow beam, forward.
    NarrowForwardBeam,
    /// A colour is scattered strongly.
    Strong(Channel),
    /// A colour is what is seen, evenly in all directions.
    Evenly(Channel),
    /// A colour is stronger than another.
    Over { more: Channel, less: Channel },
    /// A colour is weaker than another.
    Under { less: Channel, more: Channel },
}

impl fmt::Display for Claim {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::NarrowForwardBeam => f.write_str("narrow forward beam"),
            Self::Strong(c) => write!(f, "strong {}", c.name()),
            Self::Evenly(c) => write!(f, "{} evenly in all directions", c.name()),
            Self::Over { more, less } => write!(f, "{} over {}", more.name(), less.name()),
            Self::Under { less, more } => write!(f, "{} under {}", less.name(), more.name()),
        }
    }
}

/// Whether a claim is true of exact Mie scattering, with the numbers that this rests on.
#[derive(Clone, Debug, PartialEq)]
pub struct Verdict {
    /// The answer; `None` where there is no claim.
    pub holds: Option<bool>,
    /// The numbers, in words.
    pub evidence: String,
}

impl Verdict {
    /// `yes`, `no`, or `no claim on record`.
    pub fn answer(&self) -> &'static str {
        match self.holds {
            Some(true) => "yes",
            Some(false) => "no",
            None => "no claim on record",
        }
    }
}

/// Judges a claim by the droplet's exact red, green and blue.
///
/// # Errors
/// Never in the solver's domain.
pub fn judge(claim: Option<Claim>, exact: &[ExactSphere; 3]) -> Result<Verdict, MieError> {
    let Some(claim) = claim else {
        let evidence =
            format!("Q_sca {}, hemispheres {}", three(exact, q_sca)?, three(exact, ExactSphere::hemispheres)?);
        return Ok(Verdict { holds: None, evidence });
    };
    let (holds, evidence) = match claim {
        Claim::NarrowForwardBeam => narrow_beam(exact)?,
        Claim::Strong(c) => strong(c, exact),
        Claim::Evenly(c) => evenly(c, exact)?,
        Claim::Over { more, less } | Claim::Under { less, more } => over(more, less, exact),
    };
    Ok(Verdict { holds: Some(holds), evidence })
}

/// Half of the light of every colour within 15 degrees of forward.
fn narrow_beam(exact: &[ExactSphere; 3]) -> Result<(bool, String), MieError> {
    let edge = BEAM_DEG.to_radians().cos();
    let mut least: f64 = 1.0;
    for sphere in exact {
        least = least.min(sphere.share(edge, 1.0)?);
    }
    let all = three(exact, |sphere| Ok(100.0 * sphere.share(edge, 1.0)?))?;
    let ratios = three(exact, ExactSphere::forward_over_backward)?;
    let evidence = format!("{all} % lie within {BEAM_DEG} deg of forward, p(0)/p(180) is {ratios}");
    Ok((least >= BEAM_SHARE, evidence))
}

/// Scattered 1.5 times as much as the next colour.
fn strong(c: Channel, exact: &[ExactSphere; 3]) -> (bool, String) {
    let next = strongest(exact, Some(c));
    let ratio = exact[c as usize].q_sca() / exact[next as usize].q_sca();
    (ratio >= STRONG, format!("Q_sca of {} is {} times that of {}", c.name(), short(ratio), next.name()))
}

/// The strongest colour, and as strong forward as backward.
fn evenly(c: Channel, exact: &[ExactSphere; 3]) -> Result<(bool, String), MieError> {
    let hemispheres = exact[c as usize].hemispheres()?;
    let even = hemispheres.max(1.0 / hemispheres) <= EVEN;
    let first = strongest(exact, None);
    let mut evidence = format!("{}'s hemispheres are {} to 1", c.name(), short(hemispheres));
    if first != c {
        let ratio = exact[first as usize].q_sca() / exact[c as usize].q_sca();
        evidence += &format!(", and {} has {} times its Q_sca", first.name(), short(ratio));
    }
    Ok((even && first == c, evidence))
}

/// One colour's Q_sca above another's. Without interference Q_sca falls with the wavelength, as in Rayleigh scattering.
fn over(more: Channel, less: Channel, exact: &[ExactSphere; 3]) -> (bool, String) {
    let ratio = exact[more as usize].q_sca() / exact[less as usize].q_sca();
    let [red, green, blue] = exact.each_ref().map(ExactSphere::q_sca);
    let why = if blue > green && green > red { "" } else { "; not in the order of wavelengths: interference" };
    (ratio > 1.0, format!("Q_sca of {} is {} times that of {}{why}", more.name(), short(ratio), less.name()))
}

/// The channel with the largest Q_sca, leaving one out.
fn strongest(exact: &[ExactSphere; 3], but: Option<Channel>) -> Channel {
    let others = Channel::ALL.into_iter().filter(|c| Some(*c) != but);
    let by_q = |a: &Channel, b: &Channel| exact[*a as usize].q_sca().total_cmp(&exact[*b as usize].q_sca());
    others.max_by(by_q).unwrap_or(Channel::Red)
}

fn q_sca(sphere: &ExactSphere) -> Result<f64, MieError> {
    Ok(sphere.q_sca())
}

/// A number of each colour.
fn three(exact: &[ExactSphere; 3], number: impl Fn(&ExactSphere) -> Result<f64, MieError>) -> Result<String, MieError> {
    let texts: Vec<String> = exact.iter().map(|sphere| number(sphere).map(short)).collect::<Result<_, _>>()?;
    Ok(texts.join(" "))
}

/// Two or three digits.
fn short(value: f64) -> String {
    match value {
        v if v >= 10.0 => format!("{v:.0}"),
        v if v >= 1.0 => format!("{v:.1}"),
        v => format!("{v:.2}"),
    }
}
