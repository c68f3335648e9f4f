#!/usr/bin/env python3
"""Repeats every comparison with a reference and prints one table, the summary in docs/validation.md.

Usage: python3 scripts/validate.py [MIE-CLOUD] [--quick] [--write] [--only NAME]

MIE-CLOUD is target/release/mie-cloud unless given. `--quick` takes a few minutes and checks less sharply, all of it
about an hour on two cores; `--write` puts the table into docs/validation.md. Needs `pip install numpy OpenEXR miepython
numba`; a comparison whose packages are missing says so and fails.
"""
import argparse
import re
import subprocess
import sys
import time
from pathlib import Path
from typing import Callable, NamedTuple

ROOT = Path(__file__).resolve().parent.parent
BEGIN, END = "<!-- summary: scripts/validate.py --write -->", "<!-- end of the summary -->"


class Comparison(NamedTuple):
    name: str
    reference: str
    command: list[str]
    quick: list[str]
    """What replaces `command` with --quick."""
    result: Callable[[str], tuple[str, bool]]
    """From what was printed to a sentence and whether it holds."""


def last_line(out):
    line = out.strip().splitlines()[-1].replace("|z|", "abs z")
    beyond = re.search(r": (\d+) beyond", line)
    return line, beyond is not None and beyond[1] == "0"


def cubes(out):
    rows = [[cell.strip() for cell in line.strip("| ").split("|")] for line in out.splitlines() if line.startswith("| t")]
    smooth = [float(row[3]) for row in rows if "mie" not in row[0]]
    medians = [float(row[6]) for row in rows if "mie" in row[0]]
    worst = max(map(abs, smooth))
    text = f"{len(smooth)} of HG and isotropic: worst abs z of the mean {worst:.1f}"
    if medians:
        text += f"; {len(medians)} of Mie: median ratio of blocks {min(medians):.3f} to {max(medians):.3f}"
    return text, worst < 4 and all(0.95 < median < 1.05 for median in medians)


def rings(out):
    worst = max(float(found) for found in re.findall(r"largest difference ([\d.]+) pixels", out))
    return f"positions within {worst:.2f} pixels", worst <= 0.6


def miepython(out):
    rows = [line.split("|") for line in out.splitlines() if line.startswith("| sphere")]
    q_ext, g = (max(float(row[column]) for row in rows) for column in (4, 5))
    return f"{len(rows)} spheres: Q_ext within {q_ext:.0e}, g within {g:.0e}", q_ext < 1e-9


def tests(out):
    results = re.findall(r"test result: \w+\. (\d+) passed; (\d+) failed", out)
    passed, failed = (sum(int(result[k]) for result in results) for k in (0, 1))
    return f"{passed} tests hold, {failed} fail", failed == 0 and passed > 0


def comparisons(program):
    def script(name, *arguments):
        return [sys.executable, str(ROOT / "scripts" / name), program, *arguments]

    def test(*names):
        return ["cargo", "test", *(word for name in names for word in ("--test", name))]

    slabs = "discrete ordinates, checked against published tables (`tests/data/transport/slab_reference.json`)"
    mie = test("mie_reference", "mie_command")
    sizes = test("size_average", "phase_functions", "optical_tables")
    closed = test("transport", "conservation", "hard_scenes", "glow", "equivalent_clouds", "spectral_agreement", "refraction", "sun_disc")
    return [
        Comparison("slabs, radiances", slabs, script("slabs.py", "--every", "11", "--limit", "6", "--jobs", "2"),
                   script("slabs.py", "--every", "97", "--limit", "3", "--jobs", "2"), last_line),
        Comparison("slabs, fluxes", slabs, script("slabs.py", "--fluxes", "--limit", "6", "--jobs", "2"),
                   script("slabs.py", "--fluxes", "--every", "17", "--limit", "3", "--jobs", "2"), last_line),
        Comparison("fog cubes", "Mitsuba 3.9.1, `volpath` (`tests/data/transport/fog_cube_reference.json`)",
                   script("fog_cubes.py", "--spp", "64"), script("fog_cubes.py", "--spp", "16", "--only", "t1_"), cubes),
        Comparison("rings in pictures", "Mie phase functions over spectrum and observer, by a script of its own",
                   script("rings.py"), script("rings.py"), rings),
        Comparison("spheres", "miepython", script("compare_miepython.py"), script("compare_miepython.py"), miepython),
        Comparison("spheres", "arbitrary precision (`tests/data/mie`)", mie, mie, tests),
        Comparison("sizes, phase functions", "dense quadrature and closed forms", sizes, sizes, tests),
        Comparison("light", "closed forms, quadrature, energy, reciprocity, equal clouds", closed, closed, tests),
        Comparison("a paper's figures", "an independent calculation", test("paper"), test("paper"), tests),
    ]


def measure(comparison, quick):
    """The row of a comparison, and whether it holds."""
    begun = time.time()
    done = subprocess.run(comparison.quick if quick else comparison.command, cwd=ROOT, capture_output=True, text=True)
    try:
        text, holds = comparison.result(done.stdout)
    except (ValueError, IndexError):
        error = (done.stderr.strip().splitlines() or ["nothing was printed"])[-1]
        text, holds = f"failed: {error}", False
    minutes = (time.time() - begun) / 60
    return f"| {comparison.name} | {comparison.reference} | {text} | {'yes' if holds else '**no**'} | {minutes:.1f} |", holds


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program", nargs="?", default=str(ROOT / "target/release/mie-cloud"))
    parser.add_argument("--quick", action="store_true", help="fewer values, fewer samples")
    parser.add_argument("--write", action="store_true", help="puts the table into docs/validation.md")
    parser.add_argument("--only", default="", help="comparisons whose name contains this")
    args = parser.parse_args()
    program = str(Path(args.program).resolve())
    if not Path(program).exists():
        parser.error(f"there is no program {program}: run `cargo build --release` first")
    lines = ["| what | compared with | result | holds | minutes |", "|---|---|---|---|---|"]
    print("\n".join(lines), flush=True)
    every = []
    for comparison in comparisons(program):
        if args.only in comparison.name:
            line, holds = measure(comparison, args.quick)
            print(line, flush=True)
            lines.append(line)
            every.append(holds)
    lines += ["", f"Measured by `python3 scripts/validate.py{' --quick' if args.quick else ''}`."]
    if args.write and not args.only:
        document = ROOT / "docs/validation.md"
        text = document.read_text()
        head, rest = text.split(BEGIN)
        document.write_text(head + BEGIN + "\n" + "\n".join(lines) + "\n" + END + rest.split(END)[1])
    return 0 if all(every) else 1


if __name__ == "__main__":
    sys.exit(main())
