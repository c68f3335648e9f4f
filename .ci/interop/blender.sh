#!/bin/sh
# Saves a scene from Blender, renders it, and reads the picture back in Blender. Not part of .ci/run: PyPI's `bpy` is 350 MB,
# and each of its versions wants one version of Python (4.5: 3.11).
# Usage: .ci/interop/blender.sh [MIE-CLOUD [FOLDER]]    the program, and where to install and work (default target/interop)
set -eu

root=$(cd "$(dirname "$0")/../.." && pwd)
program=${1:-$root/target/release/mie-cloud}
work=${2:-$root/target/interop}
folder=$work/blender

mkdir -p "$folder"
if [ ! -x "$work/blender-venv/bin/python" ]; then
    python3 -m venv "$work/blender-venv"
    "$work/blender-venv/bin/pip" install --quiet --disable-pip-version-check bpy==4.5.15
fi
"$work/blender-venv/bin/python" "$root/examples/python/blender_scene.py" "$folder/scene.glb" >"$folder/blender.log" 2>&1
"$program" inspect "$folder/scene.glb" | tee "$folder/inspect.txt"
grep -q '500 parcels, 1 fog box$' "$folder/inspect.txt"
grep -q 'mono:r=8um' "$folder/inspect.txt"
"$program" render "$folder/scene.glb" -o "$folder/scene.exr" --resolution 64x36 --spp 4 -q
"$program" render "$folder/scene.glb" -o "$folder/layers.exr" --resolution 64x36 --spp 4 --aov all -q
"$work/blender-venv/bin/python" - "$folder" <<'PYTHON'
import sys

import bpy

folder = sys.argv[1]
plain = bpy.data.images.load(folder + "/scene.exr")
assert tuple(plain.size) == (64, 36) and plain.is_float, plain.size[:]
assert plain.colorspace_settings.name == "Linear Rec.709", plain.colorspace_settings.name
assert any(value > 0 for value in plain.pixels[:])
scene = bpy.context.scene
scene.use_nodes = True
node = scene.node_tree.nodes.new("CompositorNodeImage")
node.image = bpy.data.images.load(folder + "/layers.exr")
names = {socket.name for socket in node.outputs}
missing = {"Combined", "direct", "multiple", "background", "transmittance", "stderr"} - names
assert not missing, f"the compositor does not see {missing}"
print("Blender", bpy.app.version_string, "reads the picture and its layers")
PYTHON
