#!/bin/sh
# Reads our OpenEXR files with PyPI's OpenEXR and OpenImageIO and compares every channel, name and attribute.
#
# usage: .ci/interop/exr.sh [FILE.exr...]
# Without files: pictures whose values follow from a formula. Files given in addition, such as rendered ones (absolute
# paths, or relative to the repository), are compared with what our own reader finds in them. Needs python3 with venv; installs pinned packages into target/.
set -eu
cd "$(dirname "$0")/../.."
folder=${CARGO_TARGET_DIR:-target}/interop
venv=$folder/exr-venv
packages='OpenEXR==3.5.3 OpenImageIO==3.2.2.0 numpy==2.4.6'

mkdir -p "$folder/exr"
if [ "$(cat "$venv/packages.txt" 2>/dev/null)" != "$packages" ]; then
    python3 -m venv --clear "$venv"
    # shellcheck disable=SC2086 # three packages, three words
    "$venv/bin/pip" install --quiet --disable-pip-version-check $packages
    echo "$packages" >"$venv/packages.txt"
fi
cargo run --quiet --example write_test_picture -- "$folder/exr"
cargo build --quiet --example picture_dump
n_given=$#
n=0
for file in "$folder"/exr/*.exr "$@"; do
    n=$((n + 1))
    dump=$folder/exr/dump-$n
    cargo run --quiet --example picture_dump -- "$file" "$dump.bin" >"$dump.json"
    set -- "$@" "$file=$dump"
done
shift "$n_given" # only the pairs FILE=DUMP are left
exec "$venv/bin/python" .ci/interop/exr_check.py "$folder/exr" "$@"
