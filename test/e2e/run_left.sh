#!/usr/bin/env bash
# A start that cannot become clean: tulle run tells rounds as JSON lines, names the objects and how many pairs are left
# between them, and lists every pair on demand.
set -uo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 1
faults=0
fault() { echo "fault: $*"; faults=1; }

cat >held.yaml <<'END'
title: held
time: {step: 0.01 s, frames: 2}
contact: {start_intersections: untangle, untangle_limit: 25}
cloth:
  - name: level
    mesh: {shape: rectangle, size: [0.4, 0.4], resolution: [9, 9]}
    pins: [{box: {min: [-1, -1, -1], max: [1, 1, 1]}}]
obstacles:
  - name: post
    mesh: {shape: cylinder, radius: 0.12, height: 0.4}
    translate: [0, 0, -0.2]
END

"$TULLE" run held.yaml -o out --progress json --list-left left.csv >stdout 2>stderr
code=$?
[ $code = 2 ] || fault "exit $code, not 2"
[ -e out ] && fault "the output directory was made"
grep -q '^{"event":"untangle","round":[0-9]*,"left":[0-9]*,"intersections":[0-9]*}$' stderr || fault "no JSON line of a round"
message=$(grep -v '^{' stderr)
count=$(sed -n 's/^[^0-9]* \([0-9]*\) pairs of triangles intersect.*/\1/p' <<<"$message")
[[ "$message" == *"lines: $count of 'level' with 'post'; "*" pinned vertices lie inside an obstacle"* ]] ||
    fault "the message is: $message"
[ "$(head -1 left.csv)" = object_a,triangle_a,a0,a1,a2,object_b,triangle_b,b0,b1,b2,depth,x,y,z ] || fault "the first line is $(head -1 left.csv)"
[ "$(grep -c '^"level",[0-9]*,[0-9]*,[0-9]*,[0-9]*,"post",[0-9]*,[0-9]*,[0-9]*,[0-9]*,[0-9.e-]*,[0-9.e-]*,[0-9.e-]*,[0-9.e-]*$' left.csv)" = "$count" ] ||
    fault "$count pairs are left, the list has $(wc -l <left.csv) lines"
tail -n +2 left.csv | cut -d, -f11 | sort -grc || fault "the deepest pair is not the first"
deepest=$(sed -n 2p left.csv | cut -d, -f11)
awk -v told="$(grep -m 1 ' m deep at ' <<<"$message" | sed 's/ m deep at (.*//; s/.* //')" -v listed="$deepest" \
    'BEGIN { exit !(told > 0 && told < 1.01 * listed && told > 0.99 * listed) }' || fault "$deepest m in the list; the message is: $message"
"$TULLE" run held.yaml -o out --progress none --list-left missing/left.csv 2>stderr && fault "exit 0"
grep -q 'missing/left.csv: cannot be written' stderr || fault "nothing said of the file: $(cat stderr)"

[ $faults = 0 ] && echo "what is left: as it should"
exit $faults
