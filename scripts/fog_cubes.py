"""Compares `mie-cloud render` with pictures of cubes of fog by another renderer, and measures the work for 1 % of noise.

    cargo build --release
    python3 scripts/fog_cubes.py target/release/mie-cloud [--spp 64] [--only TEXT] [--set KEY=VALUE]...

Needs numpy and OpenEXR (`pip install numpy OpenEXR`). The reference is tests/data/transport/fog_cube_reference.json (Mitsuba 3.9.1,
volpath, no Russian roulette). Columns: mean radiance, its ratio to the reference, z = deviation over both standard errors;
z of the 64 blocks of 16x16 pixels (root mean square, largest); the median ratio of the blocks; relative RMS of one path, over the
pixels that see the cube; CPU time per path; CPU seconds to 1 % in each of 256x256 pixels, and the reference's.
One thread at a time; the time includes start and tables. The exit code is 1 when the mean of a Henyey-Greenstein or isotropic cube is off by more
than 4 errors; those of the heavy-tailed Mie cubes are for reading.
"""

import argparse
import json
import tempfile
from pathlib import Path

import numpy as np
from reference_scene import DATA, copy_tables, looking, perspective, render, write_fog

RESOLUTION, BLOCKS = 128, 8
WORK_PIXELS, WORK_ERROR = 256 * 256, 0.01
ALLOWED_Z = 4


def write_scene(path, case, view):
    origin, target = np.array(view["origin"]), np.array(view["target"])
    write_fog(
        path,
        scale=[1, 1, 1],
        extinction=case["sigma_t"],
        albedo=case["albedo"],
        phase=case["phase"],
        camera=perspective(view["fov_deg"]),
        camera_matrix=looking(target - origin, origin, view["up"]),
        suns=[view["sun_travel_dir"]],
    )


def blocks(picture):
    side = RESOLUTION // BLOCKS
    return picture.reshape(BLOCKS, side, BLOCKS, side).mean((1, 3))


def compare(program, folder, case, view, spp, settings):
    """The table's row of one case, and whether its mean agrees."""
    write_scene(folder / "cube.gltf", case, view)
    channels, cpu = render(program, folder / "cube.gltf", folder / "cube.exr", RESOLUTION, spp, settings=settings)
    radiance, variance = channels["G"], channels["stderr.G"] ** 2
    error = np.sqrt(variance.sum()) / variance.size
    ratio = radiance.mean() / case["mean_radiance"]
    z = (radiance.mean() - case["mean_radiance"]) / np.hypot(error, case["mean_radiance_stderr"])
    expected, expected_error = np.array(case["block_means"]), np.array(case["block_stderr"])
    lit = expected > 0
    block_error = np.sqrt(blocks(variance)) / (RESOLUTION // BLOCKS)
    block_z = (blocks(radiance) - expected)[lit] / np.hypot(block_error, expected_error)[lit]
    median = np.median(blocks(radiance)[lit] / expected[lit])
    seen = radiance > 0
    rms = np.sqrt(variance[seen].mean() * spp) / radiance[seen].mean()
    seconds_per_path = cpu / (spp * radiance.size)
    work = (rms / WORK_ERROR) ** 2 * seconds_per_path * WORK_PIXELS
    row = (
        f"| {case['name'].removeprefix('fog_')} | {radiance.mean():.5g} | {ratio:.4f} | {z:+.2f} | "
        f"{np.sqrt((block_z**2).mean()):.2f} | {abs(block_z).max():.1f} | {median:.4f} | {rms:.2f} | "
        f"{seconds_per_path * 1e6:.2f} | {work:,.0f} | {case['cpu_s_to_1pct_at_256']:,.0f} |"
    )
    return row, abs(z) <= ALLOWED_Z or case["phase"].startswith("mie")


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=Path)
    parser.add_argument("--spp", type=int, default=64, help="paths per pixel")
    parser.add_argument("--only", default="", help="cases whose name contains this")
    parser.add_argument("--set", action="append", default=[], dest="settings", help="KEY=VALUE, as in `mie-cloud render`")
    return parser.parse_args()


def main():
    args = arguments()
    reference = json.loads((DATA / "fog_cube_reference.json").read_text())
    print(
        "| cube | mean, 1/sr | ratio | z | blocks: rms z | largest z | median ratio | rms of a path | us per path "
        "| CPU s to 1 % | reference's |"
    )
    print("|---|---|---|---|---|---|---|---|---|---|---|")
    failed = []
    with tempfile.TemporaryDirectory() as folder:
        copy_tables(folder)
        for case in reference["cases"]:
            if args.only in case["name"]:
                view = reference["views"][case["view"]]
                row, agrees = compare(args.program.resolve(), Path(folder), case, view, args.spp, args.settings)
                print(row, flush=True)
                failed += [] if agrees else [case["name"]]
    print(f"\nbeyond {ALLOWED_Z} errors: {', '.join(failed) or 'none'}")
    raise SystemExit(bool(failed))


if __name__ == "__main__":
    main()
