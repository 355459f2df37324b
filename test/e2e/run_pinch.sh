#!/usr/bin/env bash
# An obstacle that runs into cloth held by pins: the run stops with exit 3 and names it alone.
set -uo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 1
faults=0
fault() { echo "fault: $*"; faults=1; }

cat >held.yaml <<'SCENE'
time: {step: 1/90 s, frames: 30}
cloth:
  - mesh: {shape: rectangle, size: [0.2, 0.2], resolution: [5, 5]}
    pins: [{vertices: [0-24]}]
obstacles:
  - name: rising
    mesh: {shape: box, size: [0.1, 0.1, 0.1]}
    translate: [0, 0, -0.1]
    motion: {keyframes: [{time: 0}, {time: 0.2, translate: [0, 0, 0.2]}]}
SCENE
"$TULLE" run held.yaml -o out --progress none >stdout 2>stderr
code=$?
[ $code = 3 ] || fault "exit $code, not 3"
grep -q "'cloth0' is pinched near (.*) m at .* s, by 'rising'; " stderr || { fault "message:"; cat stderr; }
"$TULLE" check out >judged || fault "judge: $(tail -n 1 judged)"
[ $faults = 0 ] && echo "the obstacle is named"
exit $faults
