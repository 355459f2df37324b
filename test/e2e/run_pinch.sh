#!/usr/bin/env bash
# An obstacle that runs into cloth held by pins: the run stops with exit 3 and names it alone; so does one that presses a rigid body onto
# another, where to let cloth through is no help and is not advised.
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
grep -q "^trouble: the run could not go on: 'cloth0' is pinched near" stdout || { fault "trouble:"; cat stdout; }
grep -q '^trouble: none' stdout && fault "a run that failed had no trouble"
"$TULLE" info out | grep -q "trouble  *the run could not go on: 'cloth0' is pinched near" || fault "info: $("$TULLE" info out)"
"$TULLE" check out >judged || fault "judge: $(tail -n 1 judged)"

cat >pressed.yaml <<'SCENE'
time: {step: 1/90 s, duration: 0.8 s}
obstacles:
  - name: ground
    mesh: {shape: box, size: [1, 1, 0.1]}
    translate: [0, 0, -0.05]
  - name: press
    mesh: {shape: box, size: [1, 1, 0.1]}
    translate: [0, 0, 0.5]
    motion: {keyframes: [{time: 0}, {time: 1, translate: [0, 0, -0.45]}]}
  - name: die
    mesh: {shape: box, size: [0.2, 0.2, 0.2]}
    translate: [0, 0, 0.106]
    dynamic: {mass: 1 kg}
SCENE
for choice in stop release; do
    "$TULLE" run pressed.yaml -o "out_$choice" --set contact.on_pinch=$choice --progress none >stdout 2>stderr
    code=$?
    [ $code = 3 ] || fault "$choice: exit $code, not 3"
    grep -q "'die' is pinched near (.*) m at .* s, between 'ground', 'press'; give it room, .* or set on_pinch to slow$" stderr ||
        { fault "$choice:"; cat stderr; }
done
"$TULLE" run pressed.yaml -o out_slow --set contact.on_pinch=slow --progress none >stdout 2>stderr || fault "slow: $(cat stderr)"
[ $faults = 0 ] && echo "the obstacle is named"
exit $faults
