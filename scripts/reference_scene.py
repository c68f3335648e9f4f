"""Fog scenes for the reference comparisons: writes them as glTF, renders them, reads the pictures.

Not a program: `slabs.py` and `fog_cubes.py` import it. Needs numpy and OpenEXR (`pip install numpy OpenEXR`).
"""

import base64
import json
import math
import os
import shutil
import struct
import subprocess
from pathlib import Path

import numpy as np
import OpenEXR

ROOT = Path(__file__).resolve().parent.parent
DATA = ROOT / "tests" / "data" / "transport"
# Corners of the cube, and its twelve triangles.
CORNERS = [[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)]
TRIANGLES = [0, 1, 3, 0, 3, 2, 4, 6, 7, 4, 7, 5, 0, 4, 5, 0, 5, 1, 2, 3, 7, 2, 7, 6, 0, 2, 6, 0, 6, 4, 1, 5, 7, 1, 7, 3]


def phase_setting(name):
    """The setting `droplets.phase` of a phase function as the reference files name it."""
    if name == "iso":
        return "isotropic"
    return f"hg:{name[2:]}" if name.startswith("hg") else f"table:{name}_angles.csv"


def unit(vector):
    return np.asarray(vector, dtype=float) / np.linalg.norm(vector)


def looking(direction, position=(0, 0, 0), up=(0, 1, 0)):
    """Column-major matrix of a camera or sun at a place whose -Z points along a direction."""
    forward = unit(direction)
    if abs(forward @ unit(up)) > 0.9:
        up = (1, 0, 0)
    right = unit(np.cross(forward, up))
    return [*right, 0, *np.cross(right, forward), 0, *(-forward), 0, *map(float, position), 1]


def write_fog(path, *, scale, extinction, albedo, phase, camera, camera_matrix, suns, background=0):
    """A box of fog, lit by suns that travel along `suns` and together bring irradiance 1; before a uniform background."""
    positions = b"".join(struct.pack("<3f", *corner) for corner in CORNERS)
    binary = positions + struct.pack(f"<{len(TRIANGLES)}H", *TRIANGLES)
    settings = {
        "droplets": {"phase": phase_setting(phase), "albedo": albedo, "distribution": "mono:r=5um"},
        "spectral": {"mode": "mono:550nm"},
        "sun": {"irradiance": 1 / len(suns), "angular_diameter_deg": 0},
        "effects": {"sun-disc": "off"},
        "background": {"radiance": background},
        "accuracy": {"angle_tolerance": 0.001},
    }
    fog = {"kind": "fog", "extinction_per_m": extinction}
    light = {"KHR_lights_punctual": {"light": 0}}
    gltf = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": list(range(2 + len(suns))), "extras": {"mie_cloud": settings}}],
        "nodes": [{"mesh": 0, "scale": scale}, {"camera": 0, "matrix": camera_matrix}]
        + [{"matrix": looking(sun), "extensions": light} for sun in suns],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}], "extras": {"mie_cloud": fog}}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 8, "type": "VEC3", "min": [-0.5] * 3, "max": [0.5] * 3},
            {"bufferView": 1, "componentType": 5123, "count": len(TRIANGLES), "type": "SCALAR"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteLength": len(positions)},
            {"buffer": 0, "byteOffset": len(positions), "byteLength": len(binary) - len(positions)},
        ],
        "buffers": [
            {
                "byteLength": len(binary),
                "uri": "data:application/octet-stream;base64," + base64.b64encode(binary).decode(),
            }
        ],
        "cameras": [camera],
        "extensionsUsed": ["KHR_lights_punctual"],
        "extensions": {"KHR_lights_punctual": {"lights": [{"type": "directional", "intensity": 100000}]}},
    }
    Path(path).write_text(json.dumps(gltf))


def orthographic(half_width):
    size = {"xmag": half_width, "ymag": half_width, "znear": 0.01, "zfar": 100}
    return {"type": "orthographic", "orthographic": size}


def perspective(fov_deg):
    return {"type": "perspective", "perspective": {"yfov": math.radians(fov_deg), "znear": 0.01, "aspectRatio": 1}}


def copy_tables(folder):
    """Phase tables lie beside the scenes that name them."""
    for table in DATA.glob("*_angles.csv"):
        shutil.copy(table, folder)


def render(program, scene, picture, resolution, spp, seed=0, settings=(), layers="stderr"):
    """Renders with one thread and returns the channels and the CPU seconds of the process."""
    arguments = [program, "render", scene, "-o", picture, "--resolution", f"{resolution}x{resolution}"]
    arguments += ["--spp", str(spp), "--seed", str(seed), "--aov", layers]
    for setting in settings:
        arguments += ["--set", setting]
    process = subprocess.Popen([*map(str, arguments), "--threads", "1", "-q"])
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode != 0:
        raise RuntimeError(f"{program} ended with code {process.returncode} on {scene}")
    with OpenEXR.File(str(picture), separate_channels=True) as file:
        channels = {name: np.array(c.pixels, dtype=np.float64) for name, c in file.channels().items()}
    return channels, usage.ru_utime + usage.ru_stime
