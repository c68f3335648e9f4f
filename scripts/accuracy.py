#!/usr/bin/env python3
"""Makes the tables of docs/accuracy.md: what the plan leaves out, and whether the accuracy asked for is the accuracy got.

    python3 scripts/accuracy.py target/release/mie-cloud [--only TEXT] [--target 0.05] [--targets 0.1,0.02,0.005]
                                [--limit 60] [--seeds 4] [--settings-spp 128] [--reference PICTURE]
                                [--skip-plans] [--skip-targets]

Needs nothing but Python. Scenes are those of scenes/ with --set, clouds from `mie-cloud generate`, and two that are written here.
A row that is predicted to take more than --limit processor seconds is not measured; the prediction is printed instead.
"""

import argparse
import base64
import json
import struct
import subprocess
import tempfile
from collections.abc import Iterator
from pathlib import Path

# The program takes as many samples before it looks at noise.
FEWEST_SPP = 16
SCENES = Path(__file__).resolve().parent.parent / "scenes"
BALL = "--shape ball --size 2m --count 2000 --kind parcels --distribution gamma:reff=6um,veff=0.1 --optical-depth"


def gltf(lux: float, settings: dict, *boxes: tuple[list, list, dict]) -> str:
    """A camera that looks along -Z, a sun 45 degrees high behind it, and boxes of fog: corners, and what is set of each."""
    scene = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0, 1], "extras": {"mie_cloud": settings}}],
        "nodes": [
            {"camera": 0, "name": "Camera"},
            {"rotation": [-0.38268343, 0, 0, 0.92387953], "extensions": {"KHR_lights_punctual": {"light": 0}}},
        ],
        "cameras": [{"type": "perspective", "perspective": {"yfov": 0.7, "znear": 0.1}}],
        "extensionsUsed": ["KHR_lights_punctual"],
        "extensions": {"KHR_lights_punctual": {"lights": [{"type": "directional", "intensity": lux, "name": "Sun"}]}},
    }
    for key in ("buffers", "bufferViews", "accessors", "meshes") if boxes else ():
        scene[key] = []
    for i, (low, high, fog) in enumerate(boxes):
        data = base64.b64encode(struct.pack("<6f", *low, *high)).decode()
        scene["buffers"].append({"byteLength": 24, "uri": "data:application/octet-stream;base64," + data})
        scene["bufferViews"].append({"buffer": i, "byteLength": 24})
        position = {"componentType": 5126, "type": "VEC3", "count": 2, "min": low, "max": high, "bufferView": i}
        scene["accessors"].append(position)
        scene["meshes"].append({"primitives": [{"attributes": {"POSITION": i}}], "extras": {"mie_cloud": {"kind": "fog", **fog}}})
        scene["nodes"].append({"mesh": i, "name": f"Fog {i + 1}"})
        scene["scenes"][0]["nodes"].append(2 + i)
    return json.dumps(scene)


def valley(**fog: float) -> tuple[list, list, dict]:
    """A box that fills the lower two thirds of the picture."""
    return [-15.0, -3.0, -40.0], [15.0, 6.0, -10.0], fog


def wall(**fog: float) -> tuple[list, list, dict]:
    """A box that fills the picture."""
    return [-15.0, -8.0, -40.0], [15.0, 8.0, -10.0], fog


def slats(n: int) -> list[tuple[list, list, dict]]:
    """Bars of soot above the camera, through which nothing shines: between them the sun does. Black bars do not glow."""
    soot = {"extinction_per_m": 20.0, "material": "n=1.75,k=0.44"}
    return [([2.0 * i - n, 3.0, -14.0], [2.0 * i - n + 1.4, 3.4, -4.0], soot) for i in range(n)]


HAZE = {"atmosphere": {"scattering_per_m": 1e-4, "depth_m": 5000, "step_m": 50, "phase": "hg:0.7"}}
# As cheap as they can be where finest accuracy is dear: three wavelengths whatever is asked for, and no glow of black bodies.
RGB = {"spectral": {"mode": "rgb"}}
UNLIT = {"effects": {"glow": "off"}}
# Mist by day, a mile through which things are seen.
MIST = {"scattering_per_m": 2.5e-3, "phase": "hg:0.7", "depth_m": 40, "step_m": 1}
FOG = {"distribution": "gamma:reff=6um,veff=0.1"}
SOOT = {"distribution": "lognormal:rg=0.05um,sigma=0.6", "material": "n=1.75,k=0.44"}
DARK = {"radiance": [0.02, 0.03, 0.06]}
SKY = {"radiance": [0.2, 0.3, 0.5]}
# Air at sea level scatters 1.2e-5 /m of green light (Bucholtz 1995); as far as a picture of things that are near looks through it.
CLEAN = {"scattering_per_m": 1.2e-5, "phase": "rayleigh", "depth_m": 200, "step_m": 5}
AIR = [f"atmosphere.{key}={value}" for key, value in CLEAN.items()]


def in_clean_air(**air: float) -> list[str]:
    """Flags that put a scene into clean air, of another depth or step if given."""
    settings = AIR + [f"atmosphere.{key}={value}" for key, value in air.items()]
    return [word for setting in settings for word in ("--set", setting)]


# Name; what is generated, a scene's text, or a shipped scene; flags on it. Shipped scenes switch effects off by hand so that
# their first pictures are quick: here the plan decides about all.
CASES = [
    ("thin cloud", f"{BALL} 0.1", []),
    ("thick cloud", "--shape cumulus --size 1km --count 2000 --kind parcels --optical-depth 20", []),
    ("thick fog, in rgb", gltf(1e5, {"droplets": FOG, **RGB}, wall(extinction_per_m=0.4)), []),
    ("magnified droplet", "droplet.gltf", ["--effects", "auto", "--set", "spectral.mode=rgb"]),
    ("steam with shafts", "steam.gltf", ["--effects", "auto"]),
    ("shafts between slats, in rgb", gltf(1e5, {"droplets": FOG, "atmosphere": MIST, **RGB, **UNLIT}, *slats(6)), []),
    ("absorbing cloud", f"{BALL} 3", ["--set", "droplets.material=n=1.5,k=0.05"]),
    ("empty sky with haze", gltf(1e5, HAZE), []),
    ("fogbow", "fogbow.gltf", ["--effects", "auto"]),
    ("night, background only", gltf(0.0, {"background": DARK, "droplets": FOG}, valley(extinction_per_m=0.05)), []),
    ("mist before a sky, in air", gltf(1e5, {"background": SKY, "droplets": FOG, "atmosphere": CLEAN}, valley(extinction_per_m=2e-4)), []),
    ("fog before a sky, in air", gltf(1e5, {"background": SKY, "droplets": FOG, "atmosphere": CLEAN}, valley(extinction_per_m=0.05)), []),
    ("soot before a sky, in air", gltf(1e5, {"background": SKY, "droplets": SOOT, "atmosphere": CLEAN}, valley(extinction_per_m=0.05)), []),
    ("night, in air", gltf(0.0, {"background": DARK, "droplets": FOG, "atmosphere": CLEAN}, valley(extinction_per_m=0.05)), []),
    ("fogbow, in air", "fogbow.gltf", ["--effects", "auto", *in_clean_air(depth_m=300, step_m=10)]),
    ("thin cloud, in air", f"{BALL} 0.1", in_clean_air()),
    ("cumulus before a sky, in air", "cumulus.gltf", ["--effects", "auto", *in_clean_air(depth_m=3000, step_m=50)]),
    ("drops of dew, in air", "drop.gltf", ["--effects", "auto", *in_clean_air(depth_m=2, step_m=0.1)]),
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


def ratio(race: dict | None, predicted_s: float) -> str:
    """A ratio of times with its spread over the turns; where it was not measured, what it would have taken."""
    if not race:
        return f"({predicted_s:.0f} CPU s)"
    spread = race["ratio"]
    return f"{spread['median']:.2f} ({spread['least']:.2f}..{spread['greatest']:.2f})"


class Program:
    """The program under measurement, and a folder for its reports."""

    def __init__(self, path: Path, folder: Path):
        self.path, self.out = path, folder / "out.json"

    def bench(self, *args: str) -> dict:
        run = [self.path, "bench", *args, "--json", self.out]
        subprocess.run(run, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        return json.loads(self.out.read_text())


def plan_row(program: Program, name: str, scene: Path, flags: list, args) -> tuple[str, dict]:
    """What the plan leaves out, and what that saves; and the report, from which more is predicted."""
    common = [str(scene), *flags, "--resolution", args.resolution, "--spp", args.spp, "--accuracy", args.target]
    report = program.bench("effects", *common, "--repeat", args.repeat)
    target, noise, race = float(args.target), report["noise"], report["same_samples"]
    predicted = race["everything_s"]["median"] * max((noise / target) ** 2, 1)
    timed = None
    if 2 * int(args.repeat) * predicted < args.limit:
        timed = program.bench("effects", *common, "--repeat", args.repeat, "--to-target")["to_target"]
    rows = report["rows"]
    left_out = [row for row in rows if not row["planned"] and row["verdict"] != "by_hand"]
    off = [row["effect"] for row in left_out if row["estimate"]]
    causeless = len(left_out) - len(off)
    names = ", ".join(off) or "nothing faint"
    missed = [row["effect"] for row in rows if row["verdict"] == "missed"]
    spare = [row["effect"] for row in rows if row["verdict"] == "spare" and row["estimate"] is not None]
    line = (
        f"| {name} | {names}; {causeless} | {share(report['everything'])} | {verdict(report['everything'], target)} "
        f"| {', '.join(missed) or 'none'} | {', '.join(spare) or 'none'} | {ratio(race, 0)} | {ratio(timed, predicted)} |"
    )
    return line, report


def target_rows(program: Program, name: str, scene: Path, flags: list, args) -> Iterator[str]:
    """Whether each accuracy asked for is got; what a fine one takes is predicted from the one before."""
    pilot = None
    common = [str(scene), *flags, "--resolution", args.small]
    for text in args.targets.split(","):
        target = float(text)
        # Samples go with one over the square of the target; 16 per pixel are the fewest.
        predicted = pilot and pilot["cpu_s"] * max((pilot["noise"] / target) ** 2, 1)
        if pilot and 2 * args.seeds * predicted > args.limit:
            yield f"| {name} | {100 * target:g} % | not measured | | | | | {predicted:.0f} predicted | |"
            continue
        bench = [*common, "--spp", args.settings_spp, "--knobs", "target", "--targets", text]
        bench += ["--reference", str(args.reference)] if args.reference else []
        rows = [program.bench("accuracy", *bench, "--seed", str(10 * seed))["rows"][-1] for seed in range(args.seeds)]
        pilot = row = rows[0]
        error = mean_difference([row["error"] for row in rows])
        bias = f"{100 * error['bias']:+.2f} ± {100 * error['bias_error']:.2f} %"
        yield (
            f"| {name} | {100 * target:g} % | {share(error)} | {kept(error, target, row['spp'])} | {bias} | {100 * row['noise']:.2g} % "
            f"| {row['spp']} | {row['cpu_s']:.2f} | {said(program, common, text)} |"
        )


def mean_difference(differences: list[dict]) -> dict:
    """The mean of independent differences: an error of few bright pixels is known to some 10 % from one pair of pictures."""
    n = len(differences)
    mean = {key: sum(each[key] for each in differences) / n for key in ("square", "bias")}
    of = {key: sum(each[key] ** 2 for each in differences) ** 0.5 / n for key in ("square_error", "bias_error")}
    return mean | of


def kept(error: dict, target: float, spp: int) -> str:
    """Whether an error is at most 1.1 of what was asked for, and at least 0.3 unless fewer samples cannot be."""
    if verdict(error, 1.1 * target) != "yes":
        return verdict(error, 1.1 * target)
    wasted = spp > FEWEST_SPP and error["square"] + 2 * error["square_error"] < (0.3 * target) ** 2
    return "too well" if wasted else "yes"


def said(program: Program, scene: list, target: str) -> str:
    """What `render` says of the same picture: the estimated error, and what dominates it."""
    stats = program.out.with_name("stats.json")
    picture = program.out.with_name("picture.exr")
    run = [program.path, "render", *scene, "--accuracy", target, "-o", picture, "--stats", stats, "-q"]
    subprocess.run(run, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    error = json.loads(stats.read_text())["error"]
    first = error["parts"][0] if error["parts"] else {"what": "nothing", "error": 0}
    return f"{100 * error['total']:.2g} %, {first['what']} {100 * first['error']:.2g} %"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=Path)
    parser.add_argument("--spp", default="24", help="samples per pixel of each of the two renders of the first table")
    parser.add_argument("--resolution", default="64x36", help="pictures of the first table")
    parser.add_argument("--small", default="64x36", help="pictures of the second table")
    parser.add_argument("--settings-spp", default="128", help="samples with which the second table compares settings")
    parser.add_argument("--reference", type=Path, help="a picture by --noise --aov stderr, for --only where settings cannot be told by samples")
    parser.add_argument("--only", default="")
    parser.add_argument("--target", default="0.05")
    parser.add_argument("--targets", default="0.1,0.02,0.005", help="from coarse to fine")
    parser.add_argument("--seeds", type=int, default=1, help="comparisons of each row of the second table")
    parser.add_argument("--limit", type=float, default=60)
    parser.add_argument("--repeat", default="5", help="turns of the timing")
    parser.add_argument("--skip-plans", action="store_true")
    parser.add_argument("--skip-targets", action="store_true")
    args = parser.parse_args()
    plans, targets = [], []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        program = Program(args.program.resolve(), folder)
        for name, source, flags in (case for case in CASES if args.only in case[0]):
            scene = SCENES / source
            if source.startswith("--"):
                scene = folder / "cloud.glb"
                subprocess.run([program.path, "generate", "-o", scene, *source.split(), "-q"], check=True)
            elif source.startswith("{"):
                scene = folder / "scene.gltf"
                scene.write_text(source)
            if not args.skip_plans:
                plans.append(plan_row(program, name, scene, flags, args)[0])
                print(plans[-1], flush=True)
            if not args.skip_targets:
                for row in target_rows(program, name, scene, flags, args):
                    targets.append(row)
                    print(row, flush=True)
    if plans:
        print("\n| scene | left out as faint; number without a cause | difference | within the target | wrongly left out | could be off | time, same samples | time to the target |")
        print("|---|---|---|---|---|---|---|---|", *plans, sep="\n")
    if targets:
        print("\n| scene | asked | got | kept to a tenth | bias | noise | spp | CPU s | `render` says |")
        print("|---|---|---|---|---|---|---|---|---|", *targets, sep="\n")


if __name__ == "__main__":
    main()
