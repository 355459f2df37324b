#!/bin/sh
# Makes the inputs of bench_detect: runs scenes into build/bench_inputs, unless they are there.
# Usage: bench/make_inputs.sh [TULLE [DIRECTORY]]; half an hour on two cores.
set -e
cd "$(dirname "$0")/.."
tulle=${1:-build/release/tulle}
to=${2:-build/bench_inputs}
mkdir -p "$to"

# run NAME SCENE FRAMES: a run cut short goes on where it was.
run() {
    frames=0
    [ ! -f "$to/$1/frames.csv" ] || frames=$(($(wc -l <"$to/$1/frames.csv") - 1))
    if [ "$frames" -le "$3" ]; then
        echo "$to/$1: $3 frames of $2"
        "$tulle" run "$2" -o "$to/$1" --frames "$3" --resume >"$to/$1.log" 2>&1 || {
            tail -n 5 "$to/$1.log"
            exit 1
        }
    fi
}

for kind in crumple:142 bundle:212 violent:72 wave:152 drape:102; do
    run "${kind%:*}" "scenes/bench/${kind%:*}.yaml" "${kind#*:}"
done
for scene in sphere:47 needles:47 ribbon:152 net:62; do
    run "${scene%:*}" "scenes/${scene%:*}.yaml" "${scene#*:}"
done
