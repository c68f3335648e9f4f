#!/usr/bin/env python3
"""Measures the rings in the pictures of scenes/{fogbow,glory,corona,rainbow}.gltf and compares them with Mie theory.

Each scene is rendered with its layers; `direct` over the opacity A is, in a thin cloud, the phase function seen around the
sun or the point opposite, whatever the thickness of the cloud along the way. Its radial profile (luminance, R, G and B)
is compared with the phase function that `mie-cloud mie` gives for the scene's distribution, averaged over the
spectrum as the scene's bands are: sampled every 10 nm from 380 to 780 nm, weighted with sunlight (a black body of 5772 K here,
good to a few per cent) and the CIE 1931 observer (the fits of Wyman, Sloan & Shirley 2013).

    python3 scripts/rings.py target/release/mie-cloud [SCENES...]     needs `pip install numpy OpenEXR`
"""

import json
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import OpenEXR

ROOT = Path(__file__).resolve().parent.parent

# Samples per pixel: rings are means over many pixels, and lie where four times as many put them to 0.01 degrees.
SPP = 16

# Where the rings are looked for, as angles from the sun or the point opposite, degrees: (name, low, high, extremum).
# Diffraction rings scale with the wavelength; bows do not.
SCALE = {"luminance": 1.0, "R": 1.15, "G": 1.0, "B": 0.83}
SCENES = {
    "fogbow": [("bow", 32, 43, "max"), ("dark ring", 31, 37, "min"), ("second bow", 27, 34, "max")],
    "glory": [("dark centre", 0.3, 1.2, "min"), ("first ring", 0.8, 2.2, "max"), ("second ring", 2.7, 4.2, "max")],
    "corona": [("dark ring", 2.0, 2.9, "min"), ("first ring", 2.75, 4.0, "max")],
    "rainbow": [("primary", 39, 43.5, "max"), ("secondary", 49.5, 56, "max")],
}


def observer(nm):
    """Colour matching functions x, y, z (Wyman, Sloan & Shirley 2013, equation 4)."""

    def lobe(mean, low, high):
        return np.exp(-0.5 * ((nm - mean) / np.where(nm < mean, low, high)) ** 2)

    x = 1.056 * lobe(599.8, 37.9, 31.0) + 0.362 * lobe(442.0, 16.0, 26.7) - 0.065 * lobe(501.1, 20.4, 26.2)
    y = 0.821 * lobe(568.8, 46.9, 40.5) + 0.286 * lobe(530.9, 16.3, 31.1)
    z = 1.217 * lobe(437.0, 11.8, 36.0) + 0.681 * lobe(459.0, 26.0, 13.8)
    return np.array([x, y, z])


def sunlight(nm):
    """A black body of the sun's effective temperature, relative."""
    return nm**-5.0 / np.expm1(1.438777e7 / (nm * 5772.0))


# Linear BT.709 from XYZ (ITU-R BT.709-6); luminance comes first.
RGB = np.array([[3.2406, -1.5372, -0.4986], [-0.9689, 1.8758, 0.0415], [0.0557, -0.2040, 1.0570]])
CHANNELS = ["luminance", "R", "G", "B"]


def theory(program, distribution, scattering_deg):
    """Phase function of the sunlit distribution in luminance, R, G, B; one row each."""
    low, high, step = scattering_deg
    xyz = 0.0
    for nm in np.arange(380.0, 781.0, 10.0):
        command = [program, "mie", "--distribution", distribution, "--wavelength", f"{nm}nm", "--format", "json"]
        out = subprocess.run(command + ["--angles", f"{low}:{high}:{step}"], check=True, capture_output=True, text=True)
        values = json.loads(out.stdout)
        xyz = xyz + np.outer(observer(nm) * sunlight(nm), np.array(values["phase"]))
    rgb = RGB @ xyz
    return np.array(values["angles_deg"]), np.vstack([xyz[1], rgb])


def rotate(rotation, vectors):
    """Vectors turned by a glTF quaternion x, y, z, w."""
    axis, w = np.array(rotation[:3]), rotation[3]
    return vectors + 2 * np.cross(axis, np.cross(axis, vectors) + w * vectors)


def scattering_angles(scene, width, height):
    """Scattering angle at the middle of every pixel, degrees."""
    nodes = {node["name"]: node for node in scene["nodes"] if node["name"] in ("Camera", "Sun")}
    half = np.tan(0.5 * scene["cameras"][0]["perspective"]["yfov"])
    x = ((np.arange(width) + 0.5) / width * 2 - 1) * half * width / height
    y = (1 - (np.arange(height) + 0.5) / height * 2) * half
    ways = np.stack(np.broadcast_arrays(x[None, :], y[:, None], -1.0), axis=-1)
    ways = rotate(nodes["Camera"]["rotation"], ways / np.linalg.norm(ways, axis=-1, keepdims=True))
    light = rotate(nodes["Sun"]["rotation"], np.array([0.0, 0.0, -1.0]))
    # Light that reaches the camera travels against the way that it looks.
    return np.degrees(np.arccos(np.clip(-ways @ light, -1.0, 1.0)))


def picture(program, path, folder):
    """Luminance, R, G, B of light scattered once, over the opacity; NaN where there is next to no cloud."""
    out = Path(folder) / "picture.exr"
    command = [program, "render", path, "-o", out, "--order", "1", "--spp", str(SPP), "--resolution", "960x540", "-q"]
    # A point of a sun: its disc would blur the rings, and `mie-cloud mie` knows of none.
    command += ["--set", "sun.angular_diameter_deg=0", "--aov", "direct"]
    subprocess.run([str(part) for part in command], check=True)
    with OpenEXR.File(str(out), separate_channels=True) as file:
        channels = {name: channel.pixels for name, channel in file.channels().items()}
    rgb = np.array([channels[f"direct.{name}"] for name in "RGB"], dtype=float)
    opacity = np.array(channels["A"], dtype=float)
    luminance = 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2]
    seen = opacity > 0.25 * opacity.max()
    return np.where(seen, np.vstack([luminance[None], rgb]) / np.where(seen, opacity, 1.0), np.nan)


def extremum(angles, values, low, high, kind):
    """Where a profile is largest or smallest between two angles: the vertex of the parabola through the three highest."""
    inside = np.flatnonzero((angles >= low) & (angles <= high) & np.isfinite(values))
    sign = 1.0 if kind == "max" else -1.0
    at = inside[np.argmax(sign * values[inside])]
    at = min(max(at, 1), len(values) - 2)
    before, here, after = values[at - 1 : at + 2]
    curve = before - 2 * here + after
    shift = 0.5 * (before - after) / curve if curve != 0 else 0.0
    return angles[at] + np.clip(shift, -1, 1) * (angles[1] - angles[0])


def profile(angles, values, edges):
    """Means over rings."""
    ring = np.digitize(angles.ravel(), edges) - 1
    good = np.isfinite(values.ravel()) & (ring >= 0) & (ring < len(edges) - 1)
    count = np.bincount(ring[good], minlength=len(edges) - 1)
    total = np.bincount(ring[good], weights=values.ravel()[good], minlength=len(edges) - 1)
    return np.where(count > 0, total / np.maximum(count, 1), np.nan)


def measure(program, name, folder):
    """One table row per ring and channel; returns the largest difference in pixels."""
    path = ROOT / "scenes" / f"{name}.gltf"
    scene = json.loads(path.read_text())
    values = picture(program, path, folder)
    scattering = scattering_angles(scene, values.shape[2], values.shape[1])
    off = scattering if name == "corona" else 180.0 - scattering
    pixel = np.degrees(scene["cameras"][0]["perspective"]["yfov"]) / values.shape[1]
    outer = max(ring[2] for ring in SCENES[name]) + 2 * pixel
    edges = np.arange(0.0, outer + pixel, pixel)
    middles = 0.5 * (edges[1:] + edges[:-1])
    step = pixel / 4
    distribution = scene["scenes"][0]["extras"]["mie_cloud"]["droplets"]["distribution"]
    span = (0.0, outer, step) if name == "corona" else (180.0 - outer, 180.0, step)
    angles, expected = theory(program, distribution, span)
    if name != "corona":
        angles, expected = 180.0 - angles[::-1], expected[:, ::-1]
    worst = 0.0
    for ring, low, high, kind in SCENES[name]:
        for channel, label in enumerate(CHANNELS):
            if name == "rainbow" and label == "luminance":
                continue
            scale = SCALE[label] if name in ("glory", "corona") else 1.0
            # The theory is seen in the same rings as the picture.
            seen = profile(angles, expected[channel], edges)
            wanted = extremum(middles, seen, low * scale, high * scale, kind)
            found = extremum(middles, profile(off, values[channel], edges), low * scale, high * scale, kind)
            worst = max(worst, abs(found - wanted) / pixel)
            print(f"| {name} | {ring} | {label} | {wanted:.2f} | {found:.2f} | {found - wanted:+.2f} | {pixel:.3f} |")
    return worst


def main():
    program = str(Path(sys.argv[1]).resolve())
    print("| scene | ring | channel | Mie theory, deg | picture, deg | difference | pixel, deg |")
    print("|---|---|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        worst = {name: measure(program, name, folder) for name in sys.argv[2:] or SCENES}
    for name, pixels in worst.items():
        print(f"{name}: largest difference {pixels:.2f} pixels")


if __name__ == "__main__":
    main()
