#!/usr/bin/env python3
"""Makes the tables of docs/accuracy.md: what the plan leaves out, and whether the accuracy asked for is the accuracy got.

    python3 scripts/accuracy.py target/release/mie-cloud [--spp 24] [--resolution 64x36] [--only TEXT] [--targets 0.1,0.02]

Needs nothing but Python. Scenes are those of scenes/ with --set, and clouds from `mie-cloud generate`.
"""

import argparse
import json
import subprocess
import tempfile
from pathlib import Path

SCENES = Path(__file__).resolve().parent.parent / "scenes"

# Name; what is generated, or the shipped scene; flags on it.
CASES = [
    ("thin cloud", "--shape ball --size 2m --count 2000 --kind parcels --distribution gamma:reff=6um,veff=0.1 --optical-depth 0.1", []),
    ("thick cloud", "--shape cumulus --size 1km --count 2000 --kind parcels --optical-depth 20", []),
    ("magnified droplet", "droplet.gltf", []),
    ("steam with shafts", "steam.gltf", ["--effects", "-multiple"]),
    (
        "absorbing cloud",
        "--shape ball --size 2m --count 2000 --kind parcels --distribution gamma:reff=6um,veff=0.1 --optical-depth 3",
        ["--set", "droplets.material=n=1.5,k=0.05"],
    ),
    (
        "empty sky with haze",
        "--shape ball --size 2m --count 1 --kind parcels --optical-depth 1e-6",
        ["--set", "atmosphere.scattering_per_m=1e-4", "--set", "atmosphere.depth_m=5000", "--set", "atmosphere.step_m=50"],
    ),
    ("fogbow", "fogbow.gltf", []),
    (
        "night, background only",
        "--shape ball --size 2m --count 2000 --kind parcels --distribution gamma:reff=6um,veff=0.1 --optical-depth 1",
        ["--set", "background.radiance=[1,0.8,0.6]", "--set", "sun.angular_diameter_deg=0", "--effects", "-direct,-airlight,-glow"],
    ),
]


def share(difference: dict) -> str:
    """A difference in percent with its standard error, or what it is at most."""
    square, error = difference["square"], difference["square_error"]
    if square == 0 and error == 0:
        return "0"
    if square > 2 * error:
        rms = square**0.5
        return f"{100 * rms:.3g} ± {50 * error / rms:.1g} %"
    return f"below {100 * (max(square, 0) + 2 * error) ** 0.5:.2g} %"


def verdict(difference: dict, limit: float) -> str:
    """Whether a difference is within a limit, as far as noise lets it be told."""
    square, error = max(difference["square"], 0), difference["square_error"]
    if square + 2 * error <= limit**2:
        return "yes"
    return "**no**" if square - 2 * error > limit**2 else "not told"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=Path)
    parser.add_argument("--spp", default="24")
    parser.add_argument("--resolution", default="64x36")
    parser.add_argument("--only", default="")
    parser.add_argument("--targets", default="0.1,0.02")
    args = parser.parse_args()
    program, size = args.program.resolve(), ["--resolution", args.resolution, "--spp", args.spp]
    plans, targets = [], []
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "out.json"
        for name, source, flags in (case for case in CASES if args.only in case[0]):
            scene = SCENES / source
            if source.startswith("--"):
                scene = Path(folder) / "cloud.glb"
                subprocess.run([program, "generate", "-o", scene, *source.split(), "-q"], check=True)
            for target in args.targets.split(","):
                common = [scene, *flags, "--json", out, *size]
                run = [program, "bench", "effects", *common, "--accuracy", target]
                subprocess.run(run, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
                report = json.loads(out.read_text())
                off = [row["effect"] for row in report["rows"] if not row["planned"] and row["verdict"] != "by_hand" and row["change"] and row["change"]["square"]]
                missed = [row["effect"] for row in report["rows"] if row["verdict"] == "missed"]
                time = report["cpu_planned_s"] / report["cpu_everything_s"]
                plans.append(
                    f"| {name} | {100 * float(target):g} % | {', '.join(off) or 'nothing'} | {share(report['everything'])} "
                    f"| {verdict(report['everything'], float(target))} | {', '.join(missed) or 'none'} | {time:.2f} |"
                )
                print(plans[-1], flush=True)
            run = [program, "bench", "accuracy", *common, "--knobs", "target"]
            subprocess.run(run, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            for row in json.loads(out.read_text())["rows"]:
                target = float(row["setting"])
                if row["setting"] in args.targets.split(","):
                    bias = f"{100 * row['error']['bias']:+.2f} ± {100 * row['error']['bias_error']:.2f} %"
                    targets.append(
                        f"| {name} | {100 * target:g} % | {share(row['error'])} | {verdict(row['error'], 1.1 * target)} | {bias} "
                        f"| {100 * row['noise']:.2g} % | {row['spp']} | {row['cpu_s']:.2f} |"
                    )
                    print(targets[-1], flush=True)
    print("\n| scene | target | left out | difference | within the target | wrongly left out | time ratio |")
    print("|---|---|---|---|---|---|---|", *plans, sep="\n")
    print("\n| scene | asked | got | kept to a tenth | bias | noise | spp | CPU s |")
    print("|---|---|---|---|---|---|---|---|", *targets, sep="\n")


if __name__ == "__main__":
    main()
