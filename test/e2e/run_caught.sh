#!/usr/bin/env bash
# Cloth that is caught: pairs that intersect at the start, or when an obstacle appears, are told of where they are ignored. Where they
# are refused in mid-run the run stops with exit 3, says when, advises only what helps, and keeps its last state.
set -uo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 1
faults=0
fault() { echo "fault: $*"; faults=1; }

cat >late.yaml <<'END'
title: late
time: {step: 0.01 s, steps_per_frame: 1, frames: 8}
cloth:
  - {name: sheet, mesh: {shape: rectangle, size: [0.3, 0.3], resolution: [7, 7]}, translate: [0, 0, 0.5]}
obstacles:
  - {name: late, mesh: {shape: box, size: [0.1, 0.1, 0.1]}, translate: [0.1, 0, 0.5], appears: 0.035}
END

# stops PATTERN SETTING...: exit 3 after four steps.
stops() {
    local pattern=$1
    shift
    rm -rf out
    "$TULLE" run late.yaml -o out --progress none "$@" >stdout 2>stderr
    local code=$?
    [ $code = 3 ] || fault "$*: exit $code, not 3"
    grep -q -e "$pattern" stderr || fault "$*: the message is: $(cat stderr)"
    grep -q 'untangle' stderr && fault "$*: untangling does not help"
    grep -q 'stopped after step 4;' stderr || fault "$*: not after step 4: $(cat stderr)"
    "$TULLE" info out | grep -q '^out: run, failed' || fault "$*: info does not say failed"
    [ -s out/checkpoint.bin ] || fault "$*: no checkpoint"
}
stops "intersect at 0.04 s, when 'late' appears:\$"
stops "^To mend it, let it appear elsewhere"
stops "intersect at 0.04 s, when 'late' appears:\$" --set contact.start_intersections=untangle
stops "'sheet' lies inside 'late' when one of them appears or comes free at 0.04 s " --set 'obstacles[0].mesh.size=[1, 1, 1]'

"$TULLE" run late.yaml -o ignored --progress none --set contact.start_intersections=ignore >stdout 2>stderr || fault "ignored: exit $?"
grep -q "^tulle run: 'sheet' is caught at 0.04 s in 'late'" stderr || fault "ignored: $(cat stderr)"
grep -q '^caught: [1-9][0-9]* pairs of triangles intersect still' stdout || fault "ignored: $(cat stdout)"

"$TULLE" run late.yaml -o start --progress none --set contact.start_intersections=ignore --set 'obstacles[0].appears=0' >stdout 2>stderr ||
    fault "ignored at the start: exit $?"
[ "$(grep -c '^tulle run: [1-9][0-9]* pairs of triangles intersect at the start and are let be' stderr)" = 1 ] || fault "at the start: $(cat stderr)"
grep -q '"message": "[1-9][0-9]* pairs of triangles intersect at the start' start/run.json || fault "run.json: $(grep message start/run.json)"
grep -q '^caught: ' stdout || fault "at the start: $(cat stdout)"

[ $faults = 0 ] && echo "caught cloth: as it should"
exit $faults
