"""Measures how noisy one path's light in a layer is, where README's "Limits" speak of it.

    cargo build --release
    python3 scripts/layer_noise.py target/release/mie-cloud [--renders 64] [--spp 16]

Needs numpy and OpenEXR (`pip install numpy OpenEXR`). Each scene is rendered many times with seeds of its own. The noise is the standard deviation
of one sample's luminance in the layer, over the layer's mean, both over the pixels that have any of it in the mean picture; the standard error is
from the scatter between four groups of renders. Heavy tails are what makes these layers noisy, so more renders find more of it.
"""

import argparse
import subprocess
import tempfile
from pathlib import Path

import numpy as np
import OpenEXR

ROOT = Path(__file__).resolve().parent.parent
LUMINANCE = {"R": 0.2126, "G": 0.7152, "B": 0.0722}
GROUPS = 4
# A ball of 400 droplets of 5 um in 2 m; this optical depth draws each 5 cm wide.
BALL = ["--kind", "droplets", "--count", "400", "--size", "2m", "--distribution", "mono:r=5um", "--optical-depth", "0.7815"]


def run(program, *arguments):
    subprocess.run([program, *map(str, arguments)], check=True)


def luminance(path, layer):
    with OpenEXR.File(str(path), separate_channels=True) as file:
        channels = {name: channel.pixels for name, channel in file.channels().items()}
    prefix = f"{layer}." if layer else ""
    return sum(weight * np.array(channels[prefix + name], dtype=float) for name, weight in LUMINANCE.items())


def noise(layers, spp):
    """Standard deviation of one sample over the mean, of a stack of pictures of `spp` samples."""
    mean = layers.mean(axis=0)
    seen = mean > 0
    return np.sqrt(spp * layers.var(axis=0, ddof=1)[seen].mean()) / mean[seen].mean()


def measure(args, folder, scene, layer, flags):
    """Noise, its standard error, and the layer's share of the picture."""
    picture, layers, whole = folder / "picture.exr", [], []
    for seed in range(args.renders):
        sampling = ["--spp", args.spp, "--seed", seed, "--resolution", "96x54", "--aov", layer]
        run(args.program, "render", scene, "-o", picture, *sampling, *flags, "-q")
        layers.append(luminance(picture, layer))
        whole.append(luminance(picture, "").mean())
    layers = np.array(layers)
    groups = [noise(group, args.spp) for group in np.array_split(layers, GROUPS)]
    return noise(layers, args.spp), np.std(groups, ddof=1) / GROUPS**0.5, layers.mean() / np.mean(whole)


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=Path)
    parser.add_argument("--renders", type=int, default=64, help="renders of each scene")
    parser.add_argument("--spp", type=int, default=16, help="samples per pixel of each render")
    return parser.parse_args()


def main():
    args = arguments()
    print("| scene | flags | layer | its share of the picture | noise of a sample over the layer's mean |")
    print("|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        ball = folder / "ball.glb"
        run(args.program, "generate", "-o", ball, *BALL, "-q")
        for scene, title, layer, flags in [
            (ball, "400 droplets", "refraction", []),
            (ball, "400 droplets", "multiple", ["--effects", "-refraction"]),
            (ROOT / "scenes/droplet.gltf", "droplet", "air_multiple", ["--effects", "+air-multiple"]),
        ]:
            value, error, share = measure(args, folder, scene, layer, flags)
            print(f"| {title} | `{' '.join(flags)}` | {layer} | {100 * share:.1f} % | {value:.1f} ± {error:.1f} |", flush=True)


if __name__ == "__main__":
    main()
