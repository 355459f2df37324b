#!/usr/bin/env bash
# The demonstration: runs a take of scenes/needles.yaml, judges every frame, makes a picture, and tells where all that lies.
# usage: demo.sh PROGRAM
#   TULLE_DEMO_FRAMES=N  frames to run (default 120)
set -euo pipefail
cd "$(dirname "$0")/.."
program=$1
result=out/demo
scene=scenes/needles.yaml
# A shorter take of the scene: a coarser sheet, the first four seconds.
frames=${TULLE_DEMO_FRAMES:-120}
changes=("cloth[0].mesh.resolution=[61, 61]")

arguments=(run "$scene" -o "$result" --frames "$frames")
for change in "${changes[@]}"; do arguments+=(--set "$change"); done
echo "tulle ${arguments[*]}"
rm -rf "$result"
mkdir -p "$(dirname "$result")"
"$program" "${arguments[@]}"

echo "tulle check $result"
verdict=$("$program" check "$result") || { echo "$verdict" | tail -5; exit 1; }

# Mean of the column total_seconds of report.csv.
step_time=$(awk -F, 'NR == 1 { for (i = 1; i <= NF; i++) if ($i == "total_seconds") column = i; next }
    column { sum += $column; steps++ } END { if (steps) printf "%.1f ms, %d steps", 1000 * sum / steps, steps }' "$result/report.csv")

# A picture of the cloth on all needles; a build without the ray tracer says so and how to get it.
still=out/demo.png
picture_frame=$((frames < 48 ? frames : 48))
echo "tulle render $result --frame $picture_frame -o $still"
if "$program" render "$result" --frame "$picture_frame" -o "$still" >/dev/null; then
    look="Picture: $still (frame $picture_frame); a film: tulle render $result -o out/demo.mp4"
else
    look="No picture was made, see above."
fi

cat <<END

The result lies in $result ($(find "$result" -type f | wc -l) files; \`tulle info $result\` lists the bodies).
To look at it
    Blender:   import cloth.obj (Forward Y, Up Z), add a Mesh Cache modifier to it: format PC2, file cloth.pc2;
               import the obstacles' OBJ files the same way, those with a .pc2 file with a Mesh Cache too
    ParaView:  run it again with --write vtp, open the .pvd files, press Apply and Play
Time per step: $step_time
$look
$(echo "$verdict" | tail -1)
END
