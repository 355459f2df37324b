#!/usr/bin/env bash
# Cloth that falls so far that floats cannot keep its gaps stops the run with exit 3 and says so; the
# frames up to there are clean.
set -uo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 1
cat >far.yaml <<'END'
title: falls for ever
time: {step: 0.1 s, frames: 200}
wind: {drag: 0}
cloth:
  - name: lost
    mesh: {shape: rectangle, size: [0.2, 0.2], resolution: [5, 5]}
END
"$TULLE" run far.yaml -o out --progress none >stdout 2>stderr
code=$?
[ $code = 3 ] || { echo "fault: exit $code, expected 3"; cat stderr; exit 1; }
grep -q "vertex 0 of 'lost'.*floats of the files" stderr || { echo "fault: the message is"; cat stderr; exit 1; }
"$TULLE" check out >verdict || { echo "fault: the frames are not clean"; tail -3 verdict; exit 1; }
grep -q '^0 intersections in [0-9]* frames$' verdict || { echo "fault: no verdict"; exit 1; }

# So does an obstacle whose far corners floats would move through the cloth, though the cloth is near the origin; no obstacle that
# is far from all cloth.
mkdir grow
for i in 0 1 2 3 4; do
    awk -v r="$((i * 5000 + 1)).3" 'BEGIN {
        printf "v %.12g %.12g %.12g\nv %.12g %.12g %.12g\nv %.12g %.12g %.12g\nf 1 2 3\n", 1.93 * r, 0.1 * r, 0.75 * 1.93 * r,
            -1.07 * r, 1.7 * r, -0.75 * 1.07 * r, -0.86 * r, -1.8 * r, -0.75 * 0.86 * r }' >"grow/$i.obj"
done
cat >large.yaml <<'END'
time: {step: 0.01 s, duration: 0.4 s}
gravity: [0, 0, 0]
contact: {delta_c: 0.05 mm}
cloth:
  - name: small
    mesh: {shape: rectangle, size: [0.01, 0.01], resolution: [3, 3]}
    rotate: [0, -36.8698976 deg, 0]
    translate: [0, 0, 0.05 mm]
obstacles:
  - name: growing
    motion: {sequence: {files: grow/%d.obj, first: 0, last: 4, interval: 0.1 s}}
END
"$TULLE" run large.yaml -o large --progress none >stdout 2>stderr
code=$?
[ $code = 3 ] || { echo "fault: the obstacle: exit $code, expected 3"; cat stdout stderr; exit 1; }
grep -q "frame [0-9]* cannot be kept: the files hold floats, which move vertex [0-2] of 'growing' at (.*) m by .* m, and so through 'small'" stderr ||
    { echo "fault: the message is"; cat stderr; exit 1; }
"$TULLE" check large >verdict || { echo "fault: the frames are not clean"; tail -3 verdict; exit 1; }
"$TULLE" run large.yaml -o away --progress none --set 'cloth[0].translate=[0, 0, 5]' >stdout 2>stderr || { echo "fault: far from the obstacle"; cat stderr; exit 1; }
