"""Compares `mie-cloud render` with the discrete-ordinate solution of plane-parallel slabs.

    cargo build --release
    python3 scripts/slabs.py target/release/mie-cloud [--every N] [--jobs 2] [--limit SECONDS] [--only TEXT]

Needs numpy and OpenEXR (`pip install numpy OpenEXR`). The reference is tests/data/transport/slab_reference.json.

Each direction is a scene of its own: a box of fog 2000 wide and 1 thick, under a narrow orthographic camera that looks
against the light's travel. A pilot picture gives the spread of paths; the picture that counts has other random numbers, and
so many samples that its standard error should be 0.4 % (0.8 % below 1e-3 and at optical depth 64), but takes about --limit
CPU seconds at most. Directions that end above 0.5 % (1 %) are compared all the same and counted as "short".

Mie slabs are compared by their means over the azimuth: eight suns in a scene, and as many scenes as the peak needs.

z is the deviation over the root of the sum of the squares of the own standard error and of 10^-agree_digits, by which the
reference may be off. The exit code is 1 when one exceeds 4.
"""

import argparse
import json
import math
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from reference_scene import DATA, copy_tables, looking, orthographic, render, write_fog

RESOLUTION = 16
PILOT_SPP = 64
# Many suns make each collision dear, few make many pictures.
SUNS_PER_SCENE = 8
FAINTEST = 1e-6
ALLOWED_Z = 4
# Allowed error of the mean over suns in place of the azimuth, for light scattered once; far below the own standard error.
AZIMUTH_TOLERANCE = 5e-4


@dataclass
class Direction:
    """One radiance of the reference: where the light travels, and the suns' azimuths that it is the mean over."""

    number: int
    case: dict
    mu: float
    reflected: bool
    azimuths: list
    expected: float
    digits: float


@dataclass
class Outcome:
    direction: Direction
    z: float
    deviation: float
    error: float
    short: bool
    seconds: float


def azimuths_for_mean(case, mu, reflected):
    """So many azimuths on a half circle that the phase function's mean over them is good."""
    if case["sun_zenith_deg"] == 0:
        return [0.0]
    table = np.loadtxt(DATA / f"{case['phase']}_angles.csv", delimiter=",")
    cos_sun, cos_view = -case["mu0"], mu if reflected else -mu
    sines = math.sqrt((1 - cos_sun**2) * (1 - cos_view**2))

    def mean(azimuths):
        cos = cos_sun * cos_view + sines * np.cos(np.radians(azimuths))
        return np.interp(np.degrees(np.arccos(np.clip(cos, -1, 1))), table[:, 0], table[:, 1]).mean()

    def midpoints(n):
        return (np.arange(n) + 0.5) * 180 / n

    exact, count = mean(midpoints(4096)), 4
    while any(abs(mean(midpoints(n)) / exact - 1) > AZIMUTH_TOLERANCE for n in (count, 2 * count)):
        count *= 2
    return list(midpoints(count))


def directions_of(case):
    """All directions of a case that are bright enough, not numbered yet."""
    for side, key in enumerate(["reflected", "transmitted_diffuse"]):
        for i, mu in enumerate(case["view_mu"]):
            if case["phase"].startswith("mie"):
                digits = case["agree_digits_azimuth_mean"][side][i]
                rows = [(None, case[f"{key}_azimuth_mean"][i], digits)]
            else:
                digits = case["agree_digits_" + key.removesuffix("_diffuse")][i]
                rows = zip(case["rel_azimuth_deg"], case[f"{key}_radiance"][i], digits)
            for azimuth, expected, digits in rows:
                if expected > FAINTEST and not (mu == 1 and azimuth):
                    yield Direction(0, case, mu, side == 0, [azimuth], expected, digits)


def write_scene(path, direction, azimuths):
    case, mu = direction.case, direction.mu
    sine = math.sqrt(1 - mu * mu)
    travel = np.array([sine, 0, mu if direction.reflected else -mu])
    zenith = math.radians(case["sun_zenith_deg"])
    suns = [
        (math.sin(zenith) * math.cos(a), math.sin(zenith) * math.sin(a), -math.cos(zenith))
        for a in np.radians(azimuths)
    ]
    write_fog(
        path,
        scale=[2000, 2000, 1],
        extinction=case["tau"],
        albedo=case["albedo"],
        phase=case["phase"],
        camera=orthographic(0.01),
        camera_matrix=looking(-travel, 10 * travel),
        suns=suns,
    )


def mean_and_error(picture):
    """All pixels see the same: their spread is the error."""
    return picture.mean(), picture.std(ddof=1) / math.sqrt(picture.size)


def draw(program, folder, direction, spp, groups, seed):
    """The mean radiance, its error and the CPU seconds, over the pictures of these groups of suns."""
    scene, picture = folder / f"{direction.number}.gltf", folder / f"{direction.number}.exr"
    results = []
    for i, azimuths in enumerate(groups):
        write_scene(scene, direction, azimuths)
        channels, seconds = render(program, scene, picture, RESOLUTION, spp, seed + i)
        results.append((*mean_and_error(channels["G"]), seconds))
    scene.unlink()
    picture.unlink()
    means, errors, seconds = np.array(results).T
    return means.mean(), np.sqrt((errors**2).sum()) / len(results), seconds.sum()


def compare(program, folder, limit, direction):
    case = direction.case
    azimuths = direction.azimuths
    if azimuths == [None]:
        azimuths = azimuths_for_mean(case, direction.mu, direction.reflected)
    count = max(1, len(azimuths) // SUNS_PER_SCENE)
    groups = [azimuths[i::count] for i in range(count)]
    target = 0.01 if direction.expected < 1e-3 or case["tau"] == 64 else 0.005
    seed = direction.number << 16
    _, error, pilot_seconds = draw(program, folder, direction, PILOT_SPP, groups[:1], seed)
    wanted = PILOT_SPP * (error / direction.expected / (0.8 * target)) ** 2
    affordable = PILOT_SPP * limit / pilot_seconds
    spp = max(PILOT_SPP, math.ceil(min(wanted, affordable) / count))
    mean, error, seconds = draw(program, folder, direction, spp, groups, seed + 1)
    deviation, error = mean / direction.expected - 1, error / direction.expected
    z = deviation / math.hypot(error, 10**-direction.digits)
    return Outcome(direction, z, deviation, error, error > target, seconds + pilot_seconds)


def print_table(outcomes, keys):
    """One row for each combination of these keys of the case."""
    names = {"tau": "depth", "sun_zenith_deg": "sun"}
    columns = ["directions", "short", "worst abs z", "rms z", "largest deviation", "its error", "CPU s"]
    print("|", " | ".join([names.get(key, key) for key in keys] + columns), "|")
    print("|" + "---|" * (len(keys) + len(columns)))
    rows = {}
    for outcome in outcomes:
        rows.setdefault(tuple(outcome.direction.case[key] for key in keys), []).append(outcome)
    for key, row in rows.items():
        z = np.array([o.z for o in row])
        worst = max(row, key=lambda o: abs(o.deviation))
        print(
            "|", " | ".join(map(str, key)), f"| {len(row)} | {sum(o.short for o in row)} | {abs(z).max():.2f} |",
            f"{np.sqrt((z**2).mean()):.2f} | {100 * worst.deviation:+.2f} % | {100 * worst.error:.2f} % |",
            f"{sum(o.seconds for o in row):.0f} |",
        )
    print()


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=Path)
    parser.add_argument("--every", type=int, default=1, help="every Nth direction, counted through all cases")
    parser.add_argument("--offset", type=int, default=0, help="the first direction's number")
    parser.add_argument("--jobs", type=int, default=1, help="pictures at a time, of one thread each")
    parser.add_argument("--limit", type=float, default=60, help="CPU seconds for one direction")
    parser.add_argument("--only", default="", help="cases whose phase function's name contains this")
    return parser.parse_args()


def main():
    args = arguments()
    cases = json.loads((DATA / "slab_reference.json").read_text())["cases"]
    every = [d for case in cases if args.only in case["phase"] for d in directions_of(case)]
    chosen = every[args.offset :: args.every]
    for number, direction in enumerate(chosen):
        direction.number = number
    with tempfile.TemporaryDirectory() as folder, ThreadPoolExecutor(args.jobs) as pool:
        copy_tables(folder)
        program = args.program.resolve()
        outcomes = []
        for outcome in pool.map(lambda d: compare(program, Path(folder), args.limit, d), chosen):
            outcomes.append(outcome)
            print(f"\r{len(outcomes)} of {len(chosen)} directions", end="", file=sys.stderr, flush=True)
        print(file=sys.stderr)
    print_table(outcomes, ["phase", "tau", "albedo", "sun_zenith_deg"])
    print("All albedos and suns:\n")
    print_table(outcomes, ["phase", "tau"])
    z = np.array([o.z for o in outcomes])
    failed = [o for o in outcomes if abs(o.z) > ALLOWED_Z]
    for outcome in failed:
        print(f"above {ALLOWED_Z}: z {outcome.z:.2f}, deviation {outcome.deviation:.4f}, {outcome.direction}")
    print(
        f"{len(outcomes)} of {len(every)} directions: {len(failed)} beyond {ALLOWED_Z} errors, "
        f"{sum(o.short for o in outcomes)} short of samples, worst |z| {abs(z).max():.2f}, "
        f"rms z {np.sqrt((z**2).mean()):.2f}, {sum(o.seconds for o in outcomes):.0f} CPU seconds"
    )
    raise SystemExit(bool(failed))


if __name__ == "__main__":
    main()
