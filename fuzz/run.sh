#!/usr/bin/env bash
# Runs the fuzzers one after the other for so many minutes each, and prints what they did:
#   fuzz/run.sh MINUTES [TARGET...]
# At the lowest priority, unless NICE says otherwise; the minutes of the table are those of the processor, in all runs so far. Crashes are left in fuzz/artifacts/TARGET, what was said in fuzz/logs/TARGET.log. It fails where there are crashes.
set -euo pipefail
cd "$(dirname "$0")"
minutes=${1:?usage: fuzz/run.sh MINUTES [TARGET...]}
shift
targets=("$@")
if [ ${#targets[@]} = 0 ]; then
    for target in fuzz_targets/*.rs; do targets+=("$(basename "$target" .rs)"); done
fi
seconds=$(awk -v minutes="$minutes" 'BEGIN { printf "%d", 60 * minutes }')
binaries="target/$(rustc -vV | sed -n 's/^host: //p')/release"
# Built binaries are used as they are where BUILT is set.
if [ -z "${BUILT:-}" ]; then nice -n 19 cargo +nightly fuzz build; fi
[ -d corpus ] || ./seeds.sh
mkdir -p logs
printf '%-10s %12s %8s %10s %8s %8s %8s\n' target executions minutes 'exec/s' edges corpus crashes
failed=0
for target in "${targets[@]}"; do
    mkdir -p "corpus/$target" "artifacts/$target"
    log="logs/$target.log"
    begun=$SECONDS
    # Memory is limited as the readers promise, with what the address sanitizer adds; a slow file is a finding. Leaks are not looked for after each file:
    # threads of a render that has ended may still be ending; what is really lost would reach the limit.
    while [ $((SECONDS - begun)) -lt "$seconds" ]; do
        before=$SECONDS
        TIMEFORMAT='spent: %U s'
        { time nice -n "${NICE:-19}" "$binaries/$target" -dict="dict/$target.dict" -artifact_prefix="artifacts/$target/" -max_len=16384 \
            -timeout=20 -rss_limit_mb=2048 -malloc_limit_mb=512 -detect_leaks=0 -max_total_time=$((seconds - SECONDS + begun)) \
            -print_final_stats=1 -close_fd_mask=1 "corpus/$target" >> "$log" 2>&1 || true; } 2>> "$log"
        # One that cannot even start ends the loop.
        [ $((SECONDS - before)) -ge 2 ] || break
    done
    executions=$(awk '/stat::number_of_executed_units/ { n += $2 } END { print n + 0 }' "$log")
    spent=$(awk '/^spent: / { s += $2 } END { print s + 0 }' "$log")
    edges=$(grep -o "cov: [0-9]*" "$log" | tail -n 1 | cut -d " " -f 2 || true)
    crashes=$(find "artifacts/$target" -type f | wc -l)
    [ "$crashes" = 0 ] || failed=1
    awk -v t="$target" -v n="$executions" -v s="$spent" -v e="${edges:-0}" -v c="$(find "corpus/$target" -type f | wc -l)" \
        -v k="$crashes" 'BEGIN { printf "%-10s %12d %8.1f %10.0f %8d %8d %8d\n", t, n, s / 60, n / (s > 0 ? s : 1), e, c, k }'
done
exit "$failed"
