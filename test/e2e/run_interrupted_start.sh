#!/usr/bin/env bash
# Ctrl-C while tulle run untangles a start that never becomes clean: a message, exit 130, nothing written; a run that was
# there before stays as it was.
set -uo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 1
faults=0
fault() { echo "fault: $*"; faults=1; }

cat >tangled.yaml <<'END'
title: tangled
time: {step: 0.01 s, frames: 2}
contact: {start_intersections: untangle, untangle_limit: 1000000}
cloth:
  - name: level
    mesh: {shape: rectangle, size: [0.4, 0.4], resolution: [9, 9]}
    pins: [{box: {min: [-1, -1, -1], max: [1, 1, 1]}}]
  - name: steep
    mesh: {shape: rectangle, size: [0.3, 0.3], resolution: [8, 8]}
    rotate: {axis: [1, 0.2, 0], angle: 80 deg}
    pins: [{box: {min: [-1, -1, -1], max: [1, 1, 1]}}]
END
mkdir kept && echo something >kept/run.json

# interrupt SIGNAL ARGUMENTS...: while it untangles
interrupt() {
    local signal=$1
    shift
    "$TULLE" run tangled.yaml --progress none "$@" >stdout 2>stderr &
    local process=$!
    sleep 1
    kill -0 $process 2>/dev/null || fault "the run ended by itself: $(cat stderr)"
    kill -s "$signal" $process
    wait $process
    local code=$?
    [ $code = 130 ] || fault "SIG$signal: exit $code, not 130"
    grep -q '^tulle run: interrupted after [0-9]* rounds of untangling; nothing was written$' stderr ||
        fault "SIG$signal: the message is: $(cat stderr)"
    [ -s stdout ] && fault "something on standard output"
}
interrupt INT -o out
[ -e out ] && fault "the output directory was made"
interrupt TERM -o kept --force
[ "$(ls kept)" = run.json ] && [ "$(cat kept/run.json)" = something ] || fault "the earlier run was touched"

[ $faults = 0 ] && echo "interrupted starts: as they should"
exit $faults
