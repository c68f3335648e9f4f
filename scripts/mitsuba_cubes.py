"""Renders the cubes of fog of `fog_cubes.py` with Mitsuba 3 on this machine, and measures the work for 1 % of noise.

    pip install mitsuba numpy        # 3.9.1 was measured; it needs an LLVM of its own age, for example Debian's package libllvm19, and then
    DRJIT_LIBLLVM_PATH=/usr/lib/x86_64-linux-gnu/libLLVM.so.19.1 python3 scripts/mitsuba_cubes.py [--cpu-seconds 20] [--only TEXT]

`volpath` in `llvm_ad_mono`, Mitsuba's fastest on a processor, one thread, paths of any length. Columns: mean radiance, its standard error; relative RMS of one
path over the pixels that see the cube; CPU time per path; CPU seconds to 1 % in each of 256x256 pixels. Compiling kernels is not counted.
Of heavy tails a short run sees less noise than there is: more --cpu-seconds find more work.
"""

import argparse
import json
import time
from pathlib import Path

import mitsuba as mi
import numpy as np

DATA = Path(__file__).resolve().parent.parent / "tests" / "data" / "transport"
RESOLUTION, WORK_PIXELS, WORK_ERROR = 128, 256 * 256, 0.01
# Paths per pixel of one picture: what is needed of memory goes with them.
PATHS = 16
# Mitsuba's tables are even in the cosine; 200,001 of them have 38 within the first degree, where the forward peak of these droplets is.
COSINES = 200_001


def phase(name):
    if name == "iso":
        return {"type": "isotropic"}
    if name.startswith("hg"):
        return {"type": "hg", "g": float(name[2:])}
    angles_deg, density = np.loadtxt(DATA / f"{name}_angles.csv", delimiter=",").T
    cosines = np.linspace(-1, 1, COSINES)
    even = np.interp(np.degrees(np.arccos(cosines)), angles_deg, density)
    return {"type": "tabphase", "values": ",".join(f"{p:.7g}" for p in even)}


def cube(case, view):
    camera = mi.ScalarTransform4f().look_at(view["origin"], view["target"], view["up"])
    film = {"type": "hdrfilm", "width": RESOLUTION, "height": RESOLUTION, "rfilter": {"type": "box"}}
    film |= {"pixel_format": "luminance", "component_format": "float32"}
    fog = {"type": "homogeneous", "sigma_t": float(case["sigma_t"]), "albedo": float(case["albedo"]), "phase": phase(case["phase"])}
    return mi.load_dict(
        {
            "type": "scene",
            "integrator": {"type": "volpath", "max_depth": -1, "rr_depth": 100_000},
            "camera": {"type": "perspective", "fov": view["fov_deg"], "to_world": camera, "sampler": {"type": "independent"}, "film": film},
            "sun": {"type": "directional", "direction": view["sun_travel_dir"], "irradiance": {"type": "uniform", "value": 1.0}},
            "fog": {"type": "cube", "to_world": mi.ScalarTransform4f().scale(0.5), "bsdf": {"type": "null"}, "interior": fog},
        }
    )


def measure(scene, cpu_seconds):
    """Mean and variance of one path in every pixel, and processor seconds per path."""
    mi.render(scene, spp=PATHS, seed=0).numpy()
    pictures, begun = [], time.process_time()
    while len(pictures) < 4 or time.process_time() - begun < cpu_seconds:
        pictures.append(mi.render(scene, spp=PATHS, seed=1 + len(pictures)).numpy()[:, :, 0].astype(float))
    spent = time.process_time() - begun
    n = len(pictures)
    # From sums, so that pictures need not be kept longer than they are.
    mean = sum(pictures) / n
    variance = sum((picture - mean) ** 2 for picture in pictures) / (n - 1) * PATHS
    return mean, variance, n * PATHS, spent / (n * PATHS * mean.size)


def row(case, view, cpu_seconds):
    mean, variance, paths, seconds_per_path = measure(cube(case, view), cpu_seconds)
    error = np.sqrt(variance.sum() / paths) / mean.size
    seen = mean > 0
    rms = np.sqrt(variance[seen].mean()) / mean[seen].mean()
    work = (rms / WORK_ERROR) ** 2 * seconds_per_path * WORK_PIXELS
    name = case["name"].removeprefix("fog_")
    return f"| {name} | {mean.mean():.5g} | {error:.1g} | {rms:.2f} | {1e6 * seconds_per_path:.2f} | {work:,.0f} |"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cpu-seconds", type=float, default=20, help="processor seconds for each cube")
    parser.add_argument("--only", default="", help="cases whose name contains this")
    args = parser.parse_args()
    mi.set_variant("llvm_ad_mono")
    mi.set_log_level(mi.LogLevel.Error)
    import drjit

    drjit.set_thread_count(1)
    reference = json.loads((DATA / "fog_cube_reference.json").read_text())
    print("| cube | mean, 1/sr | its error | rms of a path | us per path | CPU s to 1 % |")
    print("|---|---|---|---|---|---|")
    for case in reference["cases"]:
        if args.only in case["name"]:
            print(row(case, reference["views"][case["view"]], args.cpu_seconds), flush=True)


if __name__ == "__main__":
    main()
