#!/usr/bin/env bash
# The demonstration: runs a take of scenes/needles.yaml, judges every frame, and tells where the result lies.
# usage: demo.sh PROGRAM
#   TULLE_DEMO_DIR     where the result goes (default out/demo)
#   TULLE_DEMO_FRAMES  frames to run
set -euo pipefail
cd "$(dirname "$0")/.."
program=$1
result=${TULLE_DEMO_DIR:-out/demo}
scene=scenes/needles.yaml
# A shorter take of the scene: a coarser sheet, the first seconds. Empty FRAMES runs all of them.
frames=${TULLE_DEMO_FRAMES:-90}
changes=()

echo "tulle run $scene -o $result --frames $frames ${changes[*]/#/--set }"
rm -rf "$result"
mkdir -p "$(dirname "$result")"
arguments=()
for change in ${changes[@]+"${changes[@]}"}; do arguments+=(--set "$change"); done
"$program" run "$scene" -o "$result" --frames "$frames" --write vtp ${arguments[@]+"${arguments[@]}"}

echo "tulle check $result"
verdict=$("$program" check "$result") || { echo "$verdict" | tail -5; exit 1; }

# Mean of the column total_seconds of report.csv.
step_time=$(awk -F, 'NR == 1 { for (i = 1; i <= NF; i++) if ($i == "total_seconds") column = i; next }
    column { sum += $column; steps++ } END { if (steps) printf "%.1f ms, %d steps", 1000 * sum / steps, steps }' "$result/report.csv")

cat <<END

The result lies in $result:
$(cd "$result" && ls | sed 's/^/    /')
To look at it
    Blender:   import the cloth's OBJ (Forward Y, Up Z), add a Mesh Cache modifier, format PC2, the cloth's .pc2 file;
               import the obstacles' OBJ files the same way
    ParaView:  open the .pvd files, press play
Time per step: $step_time
$(echo "$verdict" | tail -1)
END
