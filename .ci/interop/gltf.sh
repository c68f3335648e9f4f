#!/bin/sh
# Generates a scene of every shape, kind and form, and checks each with other people's programs: the Khronos validator
# and three.js (npm), trimesh (PyPI). Fails on any error or warning.
# Usage: .ci/interop/gltf.sh [MIE-CLOUD [FOLDER]]    the program, and where to install and work (default target/interop)
set -eu

here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../.." && pwd)
program=${1:-$root/target/release/mie-cloud}
work=${2:-$root/target/interop}

[ -x "$program" ] || { echo "gltf.sh: there is no program $program: run \`cargo build --release\` first" >&2; exit 2; }
mkdir -p "$work/gltf"
rm -f "$work"/gltf/*

# The pinned programs, installed once.
cp "$here/package.json" "$here/package-lock.json" "$here/validate-gltf.mjs" "$work/"
if ! cmp -s "$work/package-lock.json" "$work/node_modules/.installed"; then
    (cd "$work" && npm ci --silent --no-audit --no-fund)
    cp "$work/package-lock.json" "$work/node_modules/.installed"
fi
if ! cmp -s "$here/gltf-requirements.txt" "$work/gltf-venv/.installed"; then
    python3 -m venv "$work/gltf-venv"
    "$work/gltf-venv/bin/pip" install --quiet --disable-pip-version-check -r "$here/gltf-requirements.txt"
    cp "$here/gltf-requirements.txt" "$work/gltf-venv/.installed"
fi

# Every shape, kind and form in both containers; distributions and contents take turns.
cases=$work/gltf-cases.json
separator='['
make() { # NAME COUNT KIND FORM FLAGS...
    name=$1 count=$2 kind=$3 form=$4
    shift 4
    "$program" generate -o "$work/gltf/$name" --count "$count" --kind "$kind" --as "$form" --seed 7 "$@" \
        >"$work/gltf-generate.log" 2>&1 || { cat "$work/gltf-generate.log" >&2; exit 1; }
    printf '%s\n{ "file": "%s", "count": %s, "kind": "%s", "form": "%s" }' \
        "$separator" "$work/gltf/$name" "$count" "$kind" "$form" >>"$cases"
    separator=','
}
: >"$cases"
for form in points instances; do
    for kind in droplets parcels; do
        for container in glb gltf; do
            make "ball-$kind-$form.$container" 1000 $kind $form --shape ball --size 2m \
                --distribution mono:r=5um --optical-depth 2
            make "box-$kind-$form.$container" 777 $kind $form --shape box --size 300mm,0.2m,500mm \
                --distribution gamma:reff=6um,veff=0.1
            make "slab-$kind-$form.$container" 500 $kind $form --shape slab --size 2km,100m,2km \
                --distribution lognormal:rg=3um,sigma=0.4 --liquid-water 0.2g/m3
            make "cumulus-$kind-$form.$container" 1000 $kind $form --shape cumulus --size 1km \
                --distribution gamma:reff=10um,veff=0.1 --optical-depth 30
            make "puff-$kind-$form.$container" 1000 $kind $form --shape puff --size 1m,2m,1m \
                --distribution mono:r=5um --optical-depth 2
            make "droplet-$kind-$form.$container" 1 $kind $form --shape droplet --size 1m \
                --distribution mono:r=10um
        done
    done
done
printf '\n]\n' >>"$cases"

(cd "$work" && node validate-gltf.mjs "$cases")
"$work/gltf-venv/bin/python" "$here/check_gltf.py" "$cases"
