"""Loads generated scenes with trimesh, and compares particles, units and extent with the recipe in the file.

Usage: check_gltf.py CASES.json, as validate-gltf.mjs takes it.
"""

import base64
import json
import struct
import sys

import numpy as np
import trimesh


def read_document(path):
    """The JSON and the buffer of a GLB or embedded glTF file."""
    with open(path, "rb") as file:
        data = file.read()
    if path.endswith(".gltf"):
        document = json.loads(data)
        return document, base64.b64decode(document["buffers"][0]["uri"].split(",", 1)[1], validate=True)
    json_length = struct.unpack_from("<I", data, 12)[0]
    return json.loads(data[20 : 20 + json_length]), data[28 + json_length :]


def read_accessor(document, buffer, index):
    accessor = document["accessors"][index]
    view = document["bufferViews"][accessor["bufferView"]]
    width = {"SCALAR": 1, "VEC3": 3}[accessor["type"]]
    values = np.frombuffer(buffer, "<f4", accessor["count"] * width, view["byteOffset"])
    return values.reshape(-1, width)


def particle_attributes(document):
    node = document["nodes"][0]
    if "extensions" in node:
        attributes = node["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]
        return attributes, attributes["TRANSLATION"], attributes["SCALE"]
    attributes = document["meshes"][0]["primitives"][0]["attributes"]
    return attributes, attributes["POSITION"], attributes["_RADIUS"]


def check(case):
    """What is wrong with one file, as a list of sentences."""
    document, buffer = read_document(case["file"])
    recipe = document["asset"]["extras"]["mie_cloud_generator"]
    attributes, positions, radii = particle_attributes(document)
    positions = read_accessor(document, buffer, positions)
    radii = read_accessor(document, buffer, radii)
    counts = [document["accessors"][index]["count"] for index in attributes.values()]
    faults = []
    if set(counts) != {case["count"]}:
        faults.append(f"attributes have {counts} values, not {case['count']}")
    if not (np.isfinite(positions).all() and np.isfinite(radii).all() and (radii > 0).all()):
        faults.append("a position or radius is not a number above zero")
    scale = document["nodes"][0]["scale"][0]
    size = np.resize(recipe["size_m"], 3)
    if (np.abs(positions) * scale > 0.5 * size * (1 + 1e-6)).any():
        faults.append(f"a particle lies outside the shape of {size} m")
    if case["form"] == "points":
        faults += check_trimesh(case, positions * scale)
    return faults


def check_trimesh(case, expected):
    """trimesh knows POINTS; it shows them in metres once the node's scale is applied."""
    clouds = [g for g in trimesh.load_scene(case["file"]).dump() if isinstance(g, trimesh.PointCloud)]
    vertices = np.concatenate([cloud.vertices for cloud in clouds]) if clouds else np.zeros((0, 3))
    if vertices.shape != expected.shape:
        return [f"trimesh finds {len(vertices)} points, not {len(expected)}"]
    error = np.abs(vertices - expected).max()
    return [] if error <= 1e-6 * np.abs(expected).max() else [f"trimesh places a point {error} m away"]


def main():
    with open(sys.argv[1]) as file:
        cases = json.load(file)
    faults = [(case["file"], fault) for case in cases for fault in check(case)]
    for name, fault in faults:
        print(f"    {name}: {fault}")
    print(f"trimesh and numpy: {len(cases)} files, {len(faults)} faults")
    return 1 if faults or not cases else 0


if __name__ == "__main__":
    sys.exit(main())
