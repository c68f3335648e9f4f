"""Generates hard_cases.json: spheres that are hard for Lorenz-Mie codes, in 70 digits (python 3, mpmath 1.3).

    python3 tests/data/mie/hard_cases.py > tests/data/mie/hard_cases.json

The formulas are those of Bohren & Huffman (1983): logarithmic derivatives downward, chi upward, psi upward to
n = x and by its ratio beyond. Conditions are forward differences with a relative step of 1e-25.
"""
import json
import math
import random

from mpmath import besselj, bessely, cos, findroot, mp, mpc, mpf, nstr, sin

mp.dps = 70
THETA = [0.0, 1e-4, 0.3, math.pi / 2, 2.4, 3.1, math.pi]
STEP = mpf(10) ** -25


def log_derivatives(z, n_last):
    """psi_n'(z) / psi_n(z), n = 0 .. n_last."""
    size = float(abs(z))
    derivatives, current = [None] * (n_last + 1), mpc(0)
    for n in range(int(max(n_last, size) + 12 * size ** (1 / 3)) + 60, 0, -1):
        if n <= n_last:
            derivatives[n] = current
        current = n / z - 1 / (current + n / z)
    return derivatives


def riccati(x, n_last):
    """psi_n(x) and chi_n(x), n = 0 .. n_last."""
    ratios, ratio = [None] * (n_last + 1), mpf(0)
    for n in range(n_last + 60, 0, -1):
        ratio = 1 / ((2 * n + 1) / x - ratio)
        if n <= n_last:
            ratios[n] = ratio
    psi = [sin(x), sin(x) / x - cos(x) if x >= 1 else sin(x) * ratios[1]]
    chi = [cos(x), cos(x) / x + sin(x)]
    for n in range(1, n_last):
        psi.append((2 * n + 1) / x * psi[n] - psi[n - 1] if n + 1 <= x else psi[n] * ratios[n + 1])
        chi.append((2 * n + 1) / x * chi[n] - chi[n - 1])
    return psi, chi


def coefficients(x, m):
    n_last = int(x + 10 * float(x) ** (1 / 3) + 30)
    inside, (psi, chi) = log_derivatives(m * x, n_last), riccati(x, n_last)
    a, b = [], []
    for n in range(1, n_last + 1):
        for series, slope in ((a, inside[n] / m + n / x), (b, inside[n] * m + n / x)):
            if n == n_last:
                continue
            p, q = slope * psi[n] - psi[n - 1], slope * chi[n] - chi[n - 1]
            if m.imag == 0:
                p, q = p.real, q.real
            series.append(p / (p - mpc(0, 1) * q))
    return a, b


def outputs(x, m):
    a, b = coefficients(x, m)
    orders = [(n, a[n - 1], b[n - 1]) for n in range(1, len(a) + 1)]
    ext = sum((2 * n + 1) * (an + bn).real for n, an, bn in orders)
    sca = sum((2 * n + 1) * (abs(an) ** 2 + abs(bn) ** 2) for n, an, bn in orders)
    back = sum((2 * n + 1) * (-1) ** n * (an - bn) for n, an, bn in orders)
    g = sum(mpf(2 * n + 1) / (n * (n + 1)) * (an * bn.conjugate()).real for n, an, bn in orders)
    for (n, an, bn), (_, a1, b1) in zip(orders, orders[1:]):
        g += mpf(n * (n + 2)) / (n + 1) * (an * a1.conjugate() + bn * b1.conjugate()).real
    result = {"Qext": 2 * ext / x**2, "Qsca": 2 * sca / x**2, "g": 2 * g / sca, "Qback": abs(back) ** 2 / x**2}
    result["Qabs"] = result["Qext"] - result["Qsca"] if m.imag else mpf(0)
    result["S1"], result["S2"] = zip(*(amplitudes(orders, theta) for theta in THETA))
    return result


def amplitudes(orders, theta):
    mu = mpf(-1) if theta == math.pi else cos(mpf(theta))
    s1, s2, before, pi = mpc(0), mpc(0), mpf(0), mpf(1)
    for n, a, b in orders:
        tau = n * mu * pi - (n + 1) * before
        weight = mpf(2 * n + 1) / (n * (n + 1))
        s1 += weight * (a * pi + b * tau)
        s2 += weight * (a * tau + b * pi)
        before, pi = pi, ((2 * n + 1) * mu * pi - (n + 1) * before) / n
    return s1, s2


def condition(value, shifted):
    return float(nstr(abs(shifted - value) / STEP / abs(value), 3)) if value else 0.0


def case(stratum, x, n, k):
    x_mp, m = mpf(x), mpc(n, k)
    value = outputs(x_mp, m)
    result = {"stratum": stratum, "x": x, "m_re": n, "m_im": k}
    for key in ("Qext", "Qsca", "Qabs", "Qback", "g"):
        result[key] = float(value[key])
    for key in ("S1", "S2"):
        result[key] = [[float(s.real), float(s.imag)] for s in value[key]]
    for name, shifted in (("cond_x", outputs(x_mp * (1 + STEP), m)), ("cond_m", outputs(x_mp, m * (1 + STEP)))):
        result[name] = {key: condition(value[key], shifted[key]) for key in ("Qext", "Qsca", "Qabs", "Qback", "g")}
        for key in ("S1", "S2"):
            result[name][key] = [condition(v, s) for v, s in zip(value[key], shifted[key])]
    return result


def bessel_zero(near, n, function):
    """The double closest to a zero of psi_n or chi_n."""
    return float(findroot(lambda x: function(n + mpf(1) / 2, x), (near, near * 1.001), tol=1e-40, verify=False))


def spheres(rng):
    def log_uniform(low, high):
        return math.exp(rng.uniform(math.log(low), math.log(high)))

    for _ in range(3):
        side = rng.choice([-1, 1])
        yield "small", log_uniform(1e-6, 1e-2), log_uniform(0.05, 20), log_uniform(1e-12, 100)
        yield "real", log_uniform(1e-2, 100), log_uniform(0.05, 20), 0.0
        yield "complex", log_uniform(1e-2, 100), log_uniform(0.05, 20), log_uniform(1e-12, 100)
        yield "near one", log_uniform(1e-2, 100), 1 + side * log_uniform(1e-12, 1e-2), 0.0
        yield "near one", log_uniform(1e-2, 100), 1 + side * log_uniform(1e-12, 1e-2), log_uniform(1e-12, 0.1)
        yield "optically thin", log_uniform(1e-2, 100), rng.uniform(0.05, 1), log_uniform(1e-12, 1)
        yield "metal", log_uniform(1e-6, 100), log_uniform(0.05, 0.5), log_uniform(10, 100)
        yield "weak absorption", log_uniform(1e-2, 100), log_uniform(1, 20), log_uniform(1e-14, 1e-8)
        n = rng.randint(1, 60)
        zero = bessel_zero(n + rng.uniform(3, 30), n, besselj)
        yield "zero of psi", zero, rng.choice([1 + 1e-12, 1 + 1e-8, 1.33]), 0.0
        yield "zero of psi inside", zero / 1.5, 1.5, 0.0
        yield "zero of chi", bessel_zero(n + rng.uniform(3, 30), n, bessely), rng.choice([1 + 1e-8, 1.33]), 0.0
    for x in (1e-6, 1e-3, 0.03, 1.0, 30.0):
        yield "corner", x, 0.05, 100.0
        yield "corner", x, 20.0, 100.0
        yield "corner", x, 20.0, 1e-12
        yield "corner", x, 0.05, 1e-5
        yield "plasmon", x, 0.05, math.sqrt(2)


def main():
    # One case a line.
    cases = ",\n".join(json.dumps(case(*sphere)) for sphere in spheres(random.Random(1908)))
    angles = json.dumps([{"theta_rad": theta} for theta in THETA])
    print(f'{{"angles": {angles},\n"cases": [\n{cases}\n]}}')


if __name__ == "__main__":
    main()
