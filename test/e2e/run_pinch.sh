#!/usr/bin/env bash
# An obstacle that runs into cloth held by pins: the run stops with exit 3 and names it alone; so does one that presses a rigid body onto
# another. A scene with the word that let cloth through is refused, and the message says what to use.
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
grep -q "^trouble: the run failed: 'cloth0' is pinched near" stdout || { fault "trouble:"; cat stdout; }
grep -q '^trouble: none' stdout && fault "a run that failed had no trouble"
"$TULLE" info out | grep -q "trouble  *the run failed: 'cloth0' is pinched near" || fault "info: $("$TULLE" info out)"
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
for choice in stop lag; do
    "$TULLE" run pressed.yaml -o "out_$choice" --set contact.on_pinch=$choice --progress none >stdout 2>stderr
    code=$?
    [ $code = 3 ] || fault "$choice: exit $code, not 3"
    grep -q "'die' is pinched near (.*) m at .* s, between 'ground', 'press'; give it room, .* or set on_pinch to slow$" stderr ||
        { fault "$choice:"; cat stderr; }
done
"$TULLE" run pressed.yaml -o out_slow --set contact.on_pinch=slow --progress none >stdout 2>stderr || fault "slow: $(cat stderr)"

# A pin that drags cloth into a wall is named, whatever follows.
cat >dragged.yaml <<'SCENE'
time: {step: 1/90 s, frames: 36}
cloth:
  - name: sheet
    mesh: {shape: rectangle, size: [0.2, 0.2], resolution: [9, 9]}
    pins:
      - {nearest: [-0.1, 0.1, 0]}
      - {box: {min: [0.09, -1, -1], max: [1, 1, 1]}, keyframes: [{time: 0}, {time: 0.3, translate: [0.2, 0, 0]}]}
obstacles:
  - {name: wall, mesh: {shape: box, size: [0.1, 1, 1], resolution: [2]}, translate: [0.2, 0, 0]}
SCENE
for choice in stop lag slow; do
    "$TULLE" run dragged.yaml -o "dragged_$choice" --set contact.on_pinch=$choice --progress none >stdout 2>stderr
    grep -q "'sheet' is pinched near (.*) m at .* s, by 'wall', dragged by its pin number 1; " stderr || { fault "$choice and a pin:"; cat stderr; }
done
[ $faults = 0 ] && echo "the obstacle is named"
exit $faults
