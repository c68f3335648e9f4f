//! Riccati-Bessel functions of a real argument, psi_n(x) and chi_n(x), for every order that a sphere needs.
//!
//! Legend: `x` size parameter (1); `psi[n]` = x j_n(x); `chi[n]` = -x y_n(x); n = 0 ..= n_last.

/// Fills `psi` and `chi` (equal lengths, at least 2) with orders 0, 1, .. of the Riccati-Bessel functions at `x`.
///
/// chi_n grows with n and is recurred upward throughout. psi_n is recurred upward only while it does not
/// decay (n <= x) and downward from the last order beyond, theory (3). The last order must exceed x.
pub(super) fn fill_riccati(x: f64, psi: &mut [f64], chi: &mut [f64]) {
    let inv_x = 1.0 / x;
    let n_last = psi.len() - 1;
    let n_match = (x as usize).min(n_last);
    let (sin, cos) = x.sin_cos();
    (psi[0], chi[0]) = (sin, cos);
    (psi[1], chi[1]) = (sin * inv_x - cos, cos * inv_x + sin);
    recur_upward(inv_x, chi);
    recur_upward(inv_x, &mut psi[..=n_match.max(1)]);
    recur_downward(inv_x, n_match, psi);
}

/// z_{n+1} = (2n+1)/x z_n - z_{n-1} from the first two entries, theory (3).
fn recur_upward(inv_x: f64, z: &mut [f64]) {
    let (mut previous, mut current) = (z[0], z[1]);
    for (i, slot) in z.iter_mut().enumerate().skip(2) {
        let next = (2 * i - 1) as f64 * inv_x * current - previous;
        *slot = next;
        (previous, current) = (current, next);
    }
}

/// Refills psi above `n_match` downward from the last order, scaled to meet psi[n_match].
fn recur_downward(inv_x: f64, n_match: usize, psi: &mut [f64]) {
    let n_last = psi.len() - 1;
    if n_last <= n_match {
        return;
    }
    let anchor = psi[n_match];
    // Beyond the last order the ratio of neighbours is taken as constant: the error is that of truncation.
    let c = (2 * n_last + 1) as f64 * inv_x;
    let ratio = 2.0 / (c + (c * c - 4.0).max(0.0).sqrt());
    // 1e-290 leaves room for the growth to n_match: at most 1e62 over the orders used at x = 1e-6.
    let (mut above, mut current) = (1e-290 * ratio, 1e-290);
    for n in (n_match + 1..=n_last).rev() {
        psi[n] = current;
        (above, current) = (current, (2 * n + 1) as f64 * inv_x * current - above);
    }
    let scale = anchor / current;
    psi[n_match] = anchor;
    psi[n_match + 1..].iter_mut().for_each(|p| *p *= scale);
}
