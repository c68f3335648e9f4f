#!/usr/bin/env python3
"""The same spheres by miepython and by `mie-cloud mie`: CPU seconds and differences, as a table for the documents.

Usage: python3 scripts/compare_miepython.py [MIE-CLOUD]     (needs `pip install miepython numba numpy`)

miepython runs compiled by numba, after a warm-up that is not counted; `mie-cloud mie` is timed as a whole process, its
start and the text that it prints included. Both use one thread. The cloud of many sizes is averaged over as many radii
by both: midpoints of equal steps of the cumulative cross section here, the program's own nodes there, so that the last
column also holds the difference between two quadratures.
"""
import json
import math
import os
import resource
import subprocess
import sys
import time

os.environ.setdefault("MIEPYTHON_USE_JIT", "1")
os.environ.setdefault("NUMBA_NUM_THREADS", "1")

import miepython  # noqa: E402
import numpy as np  # noqa: E402

M = 1.33 + 1e-6j
ANGLES_DEG = np.arange(0, 1801) / 10
MU = np.cos(np.radians(ANGLES_DEG))
WAVELENGTH_UM = 0.55


def sphere(x):
    """Q_ext, Q_sca, g and the phase function, sr^-1; miepython has absorption negative."""
    m = M.conjugate()
    q_ext, q_sca, _, g = miepython.efficiencies_mx(m, x)
    return q_ext, q_sca, g, miepython.i_unpolarized(m, x, MU, norm="one")


def cloud(reff_um, veff, n):
    """The mean over a gamma distribution (Hansen & Travis 1974), weighted by C_sca."""
    radii = np.linspace(0.02, 5, 20001) * reff_um
    density = radii ** ((1 - 3 * veff) / veff) * np.exp(-radii / (reff_um * veff))
    cumulative = np.cumsum(density * radii**2)
    nodes = np.interp((np.arange(n) + 0.5) / n, cumulative / cumulative[-1], radii)
    # Each node stands for the same geometric cross section: weights are efficiencies.
    extinction = scattering = asymmetry = 0.0
    phase = np.zeros_like(MU)
    for radius in nodes:
        q_ext, q_sca, g, p = sphere(2 * math.pi * radius / WAVELENGTH_UM)
        extinction, scattering, asymmetry = extinction + q_ext, scattering + q_sca, asymmetry + q_sca * g
        phase += q_sca * p
    return extinction / n, scattering / n, asymmetry / scattering, phase / scattering


def cpu_of(work):
    begun = time.process_time()
    result = work()
    return result, time.process_time() - begun


def ours(program, scatterer):
    index = f"{M.real},{M.imag}"
    command = [program, "mie", *scatterer, "--index", index, "--angles", "0:180:0.1", "--format", "json"]
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    text = subprocess.run(command, check=True, capture_output=True, text=True, env={**os.environ, "RAYON_NUM_THREADS": "1"}).stdout
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    seconds = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return json.loads(text), seconds


def row(program, name, scatterer, theirs):
    report, our_s = ours(program, scatterer)
    (q_ext, _, g, phase), their_s = cpu_of(lambda: theirs(report))
    our_q = report["q_ext"] if "q_ext" in report else report["c_ext_m2"] / report["area_m2"]
    worst = np.max(np.abs(phase / np.array(report["phase"]) - 1))
    numbers = f"{abs(q_ext / our_q - 1):.1e} | {abs(g / report['g'] - 1):.1e} | {worst:.1e}"
    print(f"| {name} | {their_s:.3g} | {our_s:.3g} | {numbers} |", flush=True)


def main():
    program = sys.argv[1] if len(sys.argv) > 1 else "target/release/mie-cloud"
    sphere(10.0)
    print(f"miepython {miepython.__version__}, numba {'on' if miepython.USE_JIT else 'off'}; 1801 angles; m = 1.33 + 1e-6 i\n")
    print("| what | miepython, CPU s | mie-cloud, CPU s | Q_ext differs by | g | phase function at worst |")
    print("|---|---|---|---|---|---|")
    for x in (10, 100, 1_000, 10_000, 100_000):
        row(program, f"sphere, x = {x:,}", ["--size-parameter", str(x)], lambda _, x=x: sphere(float(x)))
    for reff_um, veff in ((6, 0.1), (20, 0.1)):
        distribution = ["--distribution", f"gamma:reff={reff_um}um,veff={veff}", "--wavelength", "550nm"]
        name = f"gamma, {reff_um} um, veff {veff}"
        row(program, name, distribution, lambda report, r=reff_um, v=veff: cloud(r, v, report["radii"]))


if __name__ == "__main__":
    main()
