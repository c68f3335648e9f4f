#!/usr/bin/env bash
# Fills fuzz/corpus: seeds and kept files as the tests make them, in addition to what fuzzers have found there.
set -euo pipefail
cd "$(dirname "$0")"
MIE_CLOUD_CORPUS="$PWD/corpus" cargo test --quiet --manifest-path ../Cargo.toml --test mutations -- --ignored --exact write_the_seeds
for target in fuzz_targets/*.rs; do
    folder="corpus/$(basename "$target" .rs)"
    printf '%-10s %4d files, %5d kB\n' "$(basename "$folder")" "$(find "$folder" -type f | wc -l)" "$(du -sk "$folder" | cut -f 1)"
done
