#!/bin/sh
# Makes the scenes again, renders each with its own settings, about a minute on two cores or less, and puts previews, 640x360 at
# most, into docs/images.
# Usage: [SCENES="fog steam"] scripts/gallery.sh [MIE-CLOUD]    (default target/release/mie-cloud; needs `pip install pillow` to shrink previews)
set -eu

root=$(cd "$(dirname "$0")/.." && pwd)
program=${1:-$root/target/release/mie-cloud}
work=$root/target/gallery

[ -x "$program" ] || { echo "gallery.sh: there is no program $program: run \`cargo build --release\` first" >&2; exit 2; }
mkdir -p "$work"
(cd "$root" && cargo run --quiet --release --example shipped_scenes scenes)
for scene in ${SCENES:-fog fogbow glory corona rainbow cumulus steam drop}; do
    "$program" render "$root/scenes/$scene.gltf" -o "$work/$scene.exr" --preview "$work/$scene.png" --stats "$work/$scene.json"
    # A palette of 256 dithered colours; smaller where that takes more than 150 kB.
    python3 - "$work/$scene.png" "$root/docs/images/$scene.png" <<'PYTHON'
import os
import sys

from PIL import Image

picture = Image.open(sys.argv[1]).convert("RGB")
for size in ((640, 360), (560, 315), (480, 270), (400, 225), (320, 180)):
    if size[0] > picture.width:
        continue
    small = picture.resize(size, Image.Resampling.LANCZOS)
    # Colours are dithered where the palette is given only, and one that covers the few bright ones keeps the sun's glow smooth.
    palette = small.quantize(256, method=Image.Quantize.MAXCOVERAGE)
    small.quantize(palette=palette, dither=Image.Dither.FLOYDSTEINBERG).save(sys.argv[2], optimize=True)
    if os.path.getsize(sys.argv[2]) < 150_000:
        break
PYTHON
done
