//! Spherical Bessel functions of real argument for the paper's formulas: j_n and y_n by recurrences that keep their digits.

/// Orders by which the downward run starts above the last one that is wanted: below the turning point two solutions part
/// by a factor of more than 2 per order, so the start is forgotten to far below rounding.
const RUN_UP: usize = 100;

/// j_n(z) and y_n(z) for n = 0 ..= `last`.
#[derive(Clone, Debug)]
pub struct Bessel {
    /// j_n(z); what is below the range of a double is 0.
    pub j: Vec<f64>,
    /// y_n(z); what is above the range of a double is infinite, and orders beyond that are NaN.
    pub y: Vec<f64>,
}

impl Bessel {
    /// The functions at `z` > 0 up to order `last`.
    pub fn new(last: usize, z: f64) -> Self {
        Self { j: first_kind(last, z), y: second_kind(last, z) }
    }
}

/// f_{n+1} = (2n+1)/z f_n - f_{n-1}, theory (3), from orders 0 and 1 up to `last`.
fn upward(first: [f64; 2], last: usize, z: f64) -> Vec<f64> {
    let mut f = Vec::with_capacity(last + 2);
    let (mut below, mut here) = (first[0], first[1]);
    for n in 0..=last {
        f.push(below);
        (below, here) = (here, (2 * n + 3) as f64 / z * here - below);
    }
    f
}

/// y_n grows with n, so that running upward is stable at every order.
fn second_kind(last: usize, z: f64) -> Vec<f64> {
    let (sin, cos) = z.sin_cos();
    upward([-cos / z, -cos / (z * z) - sin / z], last, z)
}

/// j_n is run upward while n <= z, where it does not decay, and from there on by the ratios j_n / j_{n-1}, which are run
/// downward: 1 / ratio_n = (2n+1)/z - ratio_{n+1}.
fn first_kind(last: usize, z: f64) -> Vec<f64> {
    let (sin, cos) = z.sin_cos();
    let turn = (z as usize).min(last);
    let mut j = upward([sin / z, sin / (z * z) - cos / z], turn, z);
    let mut ratios = Vec::with_capacity(last - turn);
    let mut ratio = 0.0;
    for n in (turn + 1..=last + RUN_UP).rev() {
        ratio = 1.0 / ((2 * n + 1) as f64 / z - ratio);
        if n <= last {
            ratios.push(ratio);
        }
    }
    let mut here = j.last().copied().unwrap_or_default();
    for ratio in ratios.into_iter().rev() {
        here *= ratio;
        j.push(here);
    }
    j
}

#[cfg(test)]
mod tests {
    use super::*;

    /// j_n y_{n-1} - j_{n-1} y_n = 1/z^2 (Abramowitz & Stegun 1964, 10.1.31) holds only where both are right.
    #[test]
    fn the_wronskian_holds_at_every_order() {
        for z in [0.07, 0.9, 3.0, std::f64::consts::PI, 17.3, 99.5, 250.0, 1330.0] {
            let f = Bessel::new(100, z);
            assert_eq!((f.j.len(), f.y.len()), (101, 101));
            for n in 1..=100 {
                let wronskian = z * z * (f.j[n] * f.y[n - 1] - f.j[n - 1] * f.y[n]);
                assert!((wronskian - 1.0).abs() < 1e-11, "z = {z}, n = {n}: {wronskian}");
            }
        }
    }

    /// Closed form of j_2 (Abramowitz & Stegun 1964, 10.1.11).
    #[test]
    fn the_second_order_has_its_closed_form() {
        for z in [1.0_f64, 4.0, 30.0] {
            let j2 = (3.0 / z.powi(3) - 1.0 / z) * z.sin() - 3.0 / (z * z) * z.cos();
            assert!((Bessel::new(2, z).j[2] - j2).abs() < 1e-15);
        }
    }
}
