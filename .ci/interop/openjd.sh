#!/bin/sh
# Runs farm/mie-cloud.openjd.yaml with Open Job Description's own runner (PyPI): ranges of samples as tasks, one of them cut off
# before, and the merge. The picture must have the bytes of a single run, whatever the scene is called on either machine.
# Usage: .ci/interop/openjd.sh [MIE-CLOUD [FOLDER]]    the program, and where to install (default target/interop)
set -eu

here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../.." && pwd)
program=$(realpath "${1:-$root/target/release/mie-cloud}")
work=${2:-$root/target/interop}
template=$root/farm/mie-cloud.openjd.yaml

[ -x "$program" ] || { echo "openjd.sh: there is no program $program: run \`cargo build --release\` first" >&2; exit 2; }
mkdir -p "$work"
if ! cmp -s "$here/openjd-requirements.txt" "$work/openjd-venv/.installed"; then
    python3 -m venv --clear "$work/openjd-venv"
    "$work/openjd-venv/bin/pip" install --quiet --disable-pip-version-check -r "$here/openjd-requirements.txt"
    cp "$here/openjd-requirements.txt" "$work/openjd-venv/.installed"
fi
openjd=$work/openjd-venv/bin/openjd

out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT
# Names with spaces are what breaks scripts.
mkdir "$out/parts of it"
flags='--resolution 48x27 --aov all --quiet'

# shellcheck disable=SC2086 # flags are words
(cd "$root/scenes" && "$program" render fog.gltf -o "$out/whole.exr" --preview "$out/whole.png" --spp 96 $flags)

# A task that was killed: the next attempt goes on from its checkpoint.
part="$out/parts of it/fog.part1"
# shellcheck disable=SC2086
"$program" render "$root/scenes/fog.gltf" -o "$part.exr" --samples 32..64 --checkpoint "$part.checkpoint" \
    --checkpoint-every 10ms $flags &
task=$!
while kill -0 $task 2>/dev/null && [ ! -f "$part.checkpoint" ]; do sleep 0.01; done
kill -9 $task 2>/dev/null || true
wait $task 2>/dev/null || true
[ -f "$part.checkpoint" ] || { echo "openjd.sh: the task left no checkpoint" >&2; exit 1; }

"$openjd" check "$template"
"$openjd" run "$template" -p Scene="$root/scenes/fog.gltf" -p OutputDir="$out/parts of it" -p Name=fog \
    -p Parts=0-2 -p SamplesPerPart=32 -p Program="$program" -p Flags="$flags" >"$out/log" 2>&1 ||
    { cat "$out/log" >&2; exit 1; }

cmp "$out/whole.exr" "$out/parts of it/fog.exr"
cmp "$out/whole.png" "$out/parts of it/fog.png"
if ls "$out/parts of it"/*.checkpoint 2>/dev/null; then echo "openjd.sh: a finished task left its checkpoint" >&2; exit 1; fi
echo "openjd: three tasks and a merge have the bytes of one run"
