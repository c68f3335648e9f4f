#!/bin/sh
# Makes the scenes again, renders each with its own settings and puts previews, 640x360, into docs/images.
# Usage: scripts/gallery.sh [MIE-CLOUD]    (default target/release/mie-cloud; needs `pip install pillow` to shrink previews)
set -eu

root=$(cd "$(dirname "$0")/.." && pwd)
program=${1:-$root/target/release/mie-cloud}
work=$root/target/gallery

[ -x "$program" ] || { echo "gallery.sh: there is no program $program: run \`cargo build --release\` first" >&2; exit 2; }
mkdir -p "$work"
(cd "$root" && cargo run --quiet --release --example shipped_scenes scenes)
for scene in fogbow glory corona rainbow cumulus steam; do
    "$program" render "$root/scenes/$scene.gltf" -o "$work/$scene.exr" --preview "$work/$scene.png" --stats "$work/$scene.json"
    # The largest palette that keeps each picture below 150 kB.
    python3 - "$work/$scene.png" "$root/docs/images/$scene.png" <<'PYTHON'
import os
import sys

from PIL import Image

picture = Image.open(sys.argv[1]).convert("RGB").resize((640, 360), Image.Resampling.LANCZOS)
for colours in (256, 128, 64, 48, 32):
    dither = Image.Dither.FLOYDSTEINBERG if colours == 256 else Image.Dither.NONE
    picture.quantize(colours, dither=dither).save(sys.argv[2], optimize=True)
    if os.path.getsize(sys.argv[2]) < 150_000:
        break
PYTHON
done
