#!/bin/sh
# Runs the Python examples of the documents as somebody would: a scene by numpy, its picture read with OpenEXR; the Khronos
# validator looks at the scene. After gltf.sh and exr.sh, which install what this needs.
# Usage: .ci/interop/python.sh [MIE-CLOUD [FOLDER]]    the program, and where those installed (default target/interop)
set -eu

root=$(cd "$(dirname "$0")/../.." && pwd)
program=${1:-$root/target/release/mie-cloud}
work=${2:-$root/target/interop}
folder=$work/python

mkdir -p "$folder"
rm -f "$folder"/*
lines=$(wc -l <"$root/examples/python/cloud.py")
[ "$lines" -le 30 ] || { echo "python.sh: cloud.py has $lines lines; the README promises thirty" >&2; exit 1; }
"$work/gltf-venv/bin/python" "$root/examples/python/cloud.py" "$folder/ring.gltf"
(cd "$work" && node --input-type=module -e '
import fs from "node:fs";
import validator from "gltf-validator";
const { issues } = await validator.validateBytes(new Uint8Array(fs.readFileSync(process.argv[1])));
issues.messages.forEach(({ code, message, pointer }) => console.log(`    ${code} at ${pointer}: ${message}`));
console.log(`cloud.py: ${issues.numErrors} errors, ${issues.numWarnings} warnings`);
process.exit(issues.numErrors + issues.numWarnings > 0 ? 1 : 0);
' "$folder/ring.gltf")
"$program" render "$folder/ring.gltf" -o "$folder/ring.exr" --resolution 96x54 --spp 4 --aov all --spectral -q
"$work/exr-venv/bin/python" "$root/examples/python/read_exr.py" "$folder/ring.exr"
