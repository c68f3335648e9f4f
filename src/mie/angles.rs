//! Scattering angles prepared for the angular recurrence: folded into the forward half, mirrored angles paired.
//!
//! Legend: `theta` scattering angle (rad); `h` = 1 - cos(theta) of the folded angle min(theta, pi - theta).

use std::f64::consts::{FRAC_PI_2, PI};

use super::MieError;

/// Two angles this close to mirror images share one recurrence: two units in the last place of pi,
/// the error that an angle near pi carries already when it comes from degrees.
const MIRROR_TOLERANCE: f64 = 2.0 * (PI - 3.141_592_653_589_792_7);

/// Folded angles are padded to a multiple of this: two vectors of AVX-512, four of AVX2.
pub(super) const TILE: usize = 16;

/// Angles at which series are evaluated, prepared once and used for any number of spheres.
///
/// Angles that come in pairs theta, pi - theta cost half.
#[derive(Clone, Debug)]
pub struct Angles {
    theta_rad: Vec<f64>,
    /// 1 - cos of each folded angle, padded with zeros to a multiple of [`TILE`].
    pub(super) h: Vec<f64>,
    /// For every angle the folded entry it reads, and from which side.
    pub(super) sources: Vec<Source>,
}

/// Where the value of an angle comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Source {
    /// The folded entry itself.
    Forward(u32),
    /// The mirror image of the folded entry.
    Backward(u32),
}

impl Angles {
    /// Prepares scattering angles in radians, each in 0 ..= pi, in any order.
    ///
    /// # Errors
    /// [`MieError::Angle`] if one is out of range or not a number.
    pub fn new(theta_rad: &[f64]) -> Result<Self, MieError> {
        if let Some(&bad) = theta_rad.iter().find(|t| !(0.0..=PI).contains(*t)) {
            return Err(MieError::Angle(bad));
        }
        let mut folded: Vec<(f64, usize)> =
            theta_rad.iter().enumerate().map(|(i, &t)| (if t <= FRAC_PI_2 { t } else { PI - t }, i)).collect();
        folded.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut h = Vec::with_capacity(theta_rad.len().next_multiple_of(TILE));
        let mut sources = vec![Source::Forward(0); theta_rad.len()];
        let mut entry_angle = f64::NEG_INFINITY;
        for (angle, i) in folded {
            let theta = theta_rad[i];
            if angle - entry_angle > MIRROR_TOLERANCE || (angle == 0.0) != (entry_angle == 0.0) {
                entry_angle = angle;
                h.push(one_minus_cos(theta));
            }
            let entry = h.len() as u32 - 1;
            sources[i] = if theta <= FRAC_PI_2 { Source::Forward(entry) } else { Source::Backward(entry) };
        }
        h.resize(h.len().next_multiple_of(TILE), 0.0);
        Ok(Self { theta_rad: theta_rad.to_vec(), h, sources })
    }

    /// The angles, rad.
    pub fn theta_rad(&self) -> &[f64] {
        &self.theta_rad
    }

    /// Number of angles.
    pub fn len(&self) -> usize {
        self.theta_rad.len()
    }

    /// Whether there are no angles.
    pub fn is_empty(&self) -> bool {
        self.theta_rad.is_empty()
    }
}

/// 1 - |cos theta| without cancellation; exactly 0 at 0 and pi.
fn one_minus_cos(theta: f64) -> f64 {
    let s = if theta <= FRAC_PI_2 {
        (0.5 * theta).sin()
    } else if theta == PI {
        0.0
    } else {
        (0.5 * theta).cos()
    };
    2.0 * s * s
}
