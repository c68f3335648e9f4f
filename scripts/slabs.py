"""Compares `mie-cloud render` with the discrete-ordinate solution of plane-parallel slabs.

    cargo build --release
    python3 scripts/slabs.py target/release/mie-cloud --results target/slabs.jsonl --jobs 2            # radiances
    python3 scripts/slabs.py target/release/mie-cloud --results target/slabs.jsonl --jobs 2 --fluxes   # fluxes

Needs numpy and OpenEXR (`pip install numpy OpenEXR`). The reference is tests/data/transport/slab_reference.json; what is
compared, and how it is rendered, is in slab_quantities.py.

A pilot picture gives the spread of paths; pictures with other random numbers follow, each with so many samples as the errors
before it call for, until the standard error of all but the pilot is at the target (0.5 %; 1 % for what is below 1e-3 and at
optical depth 64) or --limit CPU seconds are spent. What ends above the target is compared all the same
and counted as "short". `render --noise` would stop at the first lucky picture: rare bright paths that have not come yet
are missing from its noise too.

Each result is a line of the file of --results. What the same program has measured with the same settings is not measured
again, unless it was short and there is more time now: an interrupted run goes on where it stopped. The quantities
come in an order that mixes cheap and dear ones, so that the estimated time can be believed after a few dozen.

z is the deviation over the root of the sum of the squares of the own standard error and of 10^-agree_digits, by which the
reference may be off. The exit code is 1 when one exceeds 4.
"""

import argparse
import hashlib
import json
import math
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor, as_completed
from pathlib import Path

import numpy as np
from reference_scene import copy_tables
from slab_quantities import Studio, fluxes, load_cases, radiances

PILOT_SPP = {"albedo": 4, "transmittance": 4}
OTHER_PILOT_SPP = 64
ALLOWED_Z = 4
# No picture takes more than this many times the samples of all before it: a pilot that missed the bright paths is
# corrected before the time is gone.
GROWTH = 16
ROUNDS = 8
# More samples than are needed by the estimate, so that most need no further picture.
MARGIN = 1.2


def pooled(pictures):
    """Mean and standard error of independent pictures (samples, mean, error), weighed by their samples."""
    samples, means, errors = np.array(pictures, dtype=float).T
    share = samples / samples.sum()
    return share @ means, math.sqrt(((share * errors) ** 2).sum())


def measure(studio, limit, quantity):
    """One result as it is stored."""
    pilot_spp = PILOT_SPP.get(quantity.kind, OTHER_PILOT_SPP)
    target = quantity.target * quantity.expected
    _, error, seconds = studio.draw(quantity, pilot_spp, quantity.seed)
    pictures, spent, per_sample, samples = [], seconds, seconds / pilot_spp, pilot_spp
    for number in range(1, ROUNDS + 1):
        # An error of zero is that of a pilot that saw nothing, or of a quantity without noise.
        wanted = MARGIN * samples * (error / target) ** 2 - (samples if pictures else 0)
        affordable = (limit - spent) / per_sample
        spp = max(pilot_spp, math.ceil(min(wanted, affordable, GROWTH * samples)))
        mean, error, seconds = studio.draw(quantity, spp, quantity.seed + (number << 12))
        pictures.append((spp, mean, error))
        (mean, error), samples = pooled(pictures), sum(picture[0] for picture in pictures)
        spent, per_sample = spent + seconds, seconds / spp
        if error <= target or spent >= limit:
            break
    return {
        "key": quantity.key,
        "mean": mean,
        "error": error,
        "samples": samples,
        "seconds": round(spent, 3),
        "limit": limit,
    }


class Results:
    """The file of results: one JSON object in a line, the last one of a key counts."""

    def __init__(self, path, program, settings):
        self.path = path
        self.origin = {"program": hashlib.sha256(program.read_bytes()).hexdigest()[:16], "settings": sorted(settings)}
        self.by_key = {}
        if path and path.exists():
            for line in path.read_text().splitlines():
                self.take(line)

    def take(self, line):
        """An interrupted run may have left half a line."""
        try:
            result = json.loads(line)
        except json.JSONDecodeError:
            return
        if all(result.get(name) == value for name, value in self.origin.items()):
            self.by_key[result["key"]] = result

    def add(self, result):
        self.by_key[result["key"]] = result
        if self.path:
            with self.path.open("a") as file:
                file.write(json.dumps({**result, **self.origin}) + "\n")

    def is_done(self, quantity, limit):
        result = self.by_key.get(quantity.key)
        return result is not None and (not is_short(quantity, result) or result["limit"] >= limit)


def is_short(quantity, result):
    return result["error"] > quantity.target * quantity.expected


def measure_all(studio, results, quantities, args):
    """Measures what is not known yet, in an order without order, and says how long it will take."""
    missing = sorted((q for q in quantities if not results.is_done(q, args.limit)), key=lambda q: q.seed)
    print(f"{len(quantities) - len(missing)} of {len(quantities)} are known", file=sys.stderr)
    start, spent = time.monotonic(), 0.0
    with ThreadPoolExecutor(args.jobs) as pool:
        futures = [pool.submit(measure, studio, args.limit, quantity) for quantity in missing]
        try:
            for done, future in enumerate(as_completed(futures), 1):
                result = future.result()
                results.add(result)
                spent += result["seconds"]
                left = (time.monotonic() - start) * (len(missing) - done) / done
                print(
                    f"\r{done} of {len(missing)}: {spent:.0f} CPU s, about {spent * len(missing) / done:.0f} in all, "
                    f"{left / 60:.0f} minutes left ",
                    end="", file=sys.stderr, flush=True,
                )
        except KeyboardInterrupt:
            pool.shutdown(cancel_futures=True)
            raise
    print(file=sys.stderr)


def rows_of(quantities, results):
    """z, deviation, its error, whether it is short and the CPU seconds of every quantity."""
    for quantity in quantities:
        result = results.by_key[quantity.key]
        deviation, error = result["mean"] / quantity.expected - 1, result["error"] / quantity.expected
        z = deviation / math.hypot(error, 10**-quantity.digits)
        yield {
            "quantity": quantity, "z": z, "deviation": deviation, "error": error,
            "short": is_short(quantity, result), "seconds": result["seconds"],
        }


def print_table(rows, keys):
    """One line for each combination of these keys of the case, the phase first; `kind` is the quantity's own."""
    names = {"tau": "depth", "sun_zenith_deg": "sun"}
    columns = ["values", "short", "worst abs z", "rms z", "largest deviation", "its error", "CPU s"]
    print("|", " | ".join([names.get(key, key) for key in keys] + columns), "|")
    print("|" + "---|" * (len(keys) + len(columns)))
    groups = {}
    for row in rows:
        quantity = row["quantity"]
        key = tuple(quantity.kind if key == "kind" else quantity.case[key] for key in keys)
        groups.setdefault(key, []).append(row)
    phases = list(dict.fromkeys(row["quantity"].case["phase"] for row in rows))
    for key, group in sorted(groups.items(), key=lambda item: (phases.index(item[0][0]), item[0][1:])):
        z = np.array([row["z"] for row in group])
        worst = max(group, key=lambda row: abs(row["deviation"]))
        print(
            "|", " | ".join(map(str, key)), f"| {len(group)} | {sum(row['short'] for row in group)} | {abs(z).max():.2f} |",
            f"{np.sqrt((z**2).mean()):.2f} | {100 * worst['deviation']:+.2f} % | {100 * worst['error']:.2f} % |",
            f"{sum(row['seconds'] for row in group):.0f} |",
        )
    print()


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=Path)
    parser.add_argument("--fluxes", action="store_true", help="fluxes of every slab instead of radiances")
    parser.add_argument("--results", type=Path, help="file of results to go on with, one JSON object in a line")
    parser.add_argument("--every", type=int, default=1, help="every Nth quantity, counted through all cases")
    parser.add_argument("--offset", type=int, default=0, help="the first one's number")
    parser.add_argument("--jobs", type=int, default=1, help="pictures at a time, of one thread each")
    parser.add_argument("--limit", type=float, default=60, help="CPU seconds for one quantity")
    parser.add_argument("--only", default="", help="quantities whose name contains this: mie_r5_550/8/ or /reflected/")
    parser.add_argument("--set", action="append", default=[], dest="settings", help="KEY=VALUE, as in `mie-cloud render`")
    parser.add_argument("--cases", action="store_true", help="prints a line for every slab too")
    return parser.parse_args()


def main():
    args = arguments()
    every = [q for q in (fluxes if args.fluxes else radiances)(load_cases()) if args.only in q.key]
    chosen = every[args.offset :: args.every]
    program = args.program.resolve()
    results = Results(args.results, program, args.settings)
    with tempfile.TemporaryDirectory() as folder:
        copy_tables(folder)
        measure_all(Studio(program, Path(folder), args.settings), results, chosen, args)
    rows = list(rows_of(chosen, results))
    if args.cases:
        print_table(rows, ["phase", "tau", "albedo", "sun_zenith_deg"])
    print_table(rows, ["phase", "tau", "kind"] if args.fluxes else ["phase", "tau"])
    z = np.array([row["z"] for row in rows])
    failed = [row for row in rows if abs(row["z"]) > ALLOWED_Z]
    for row in failed:
        quantity = row["quantity"]
        print(f"above {ALLOWED_Z}: z {row['z']:.2f}, deviation {row['deviation']:.4f} of {quantity.expected}, {quantity.key}")
    print(
        f"{len(rows)} of {len(every)} {'fluxes' if args.fluxes else 'directions'}: {len(failed)} beyond {ALLOWED_Z} errors, "
        f"{sum(row['short'] for row in rows)} short of samples, worst |z| {abs(z).max():.2f}, "
        f"rms z {np.sqrt((z**2).mean()):.2f}, {sum(row['seconds'] for row in rows):.0f} CPU seconds"
    )
    raise SystemExit(bool(failed))


if __name__ == "__main__":
    main()
