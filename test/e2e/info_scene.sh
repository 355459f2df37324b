#!/usr/bin/env bash
# `tulle info` of scene files, as text and as JSON; `tulle check --frames` of a run; the event with which a run begins.
set -uo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
faults=0
fail() { echo "$*"; faults=1; }

# expect CODE PATTERN ARGUMENTS...: exit code, and a line of either output.
expect() {
    local code=$1 pattern=$2
    shift 2
    "$TULLE" "$@" >out 2>&1
    local found=$?
    [ $found = "$code" ] || { fail "tulle $*: exit $found, expected $code"; cat out; }
    grep -Eq -- "$pattern" out || { fail "tulle $*: no \"$pattern\" in:"; cat out; }
}

cat >fall.yaml <<'END_OF_SCENE'
title: a sheet falls on a spike
time: {step: 0.02 s, steps_per_frame: 2, frames: 6}
contact: {delta_c: 2 mm}
cloth:
  - name: sheet
    mesh: {shape: rectangle, size: [0.4, 0.4], resolution: [9, 9]}
    translate: [0.02, 0.01, 0.12]
obstacles:
  - name: spike
    mesh: {shape: tetrahedron, radius: 0.05, height: 0.11}
    translate: [-0.1, 0, 0.001]
END_OF_SCENE

expect 0 'frames +6 after the start, of 2 steps of 0.02 s each' info fall.yaml
grep -q 'contact distance 2 mm' out && grep -q 'cloth  *sheet: 81 vertices, 128 triangles' out && grep -q 'obstacle  *spike: 4 vertices, 4 triangles' out ||
    { fail "info of a scene:"; cat out; }
grep -q 'damping  *the integrator adds a damping ratio of 0.063 at a period of 1 s, 0.47 at a period of 0.1 s' out &&
    grep -q 'edges of 56.4 mm, bending length 18.9 mm; edges of 9.5 mm or less fold as the fabric does, of 6.3 mm where it curves both ways' out ||
    { fail "neither damping nor fineness:"; cat out; }
grep -q '  from (-0.18, -0.19, 0.12) to (0.22, 0.21, 0.12) m$' out || { fail "no box:"; cat out; }
expect 0 'edges of 56.4 mm$' info fall.yaml --set 'gravity=[0, 0, 0]'
expect 0 '^\{"format":"tulle scene","format_version":1,"path":"fall.yaml"' info fall.yaml --json
facts='"vertices":81,"triangles":128,"mean_edge":0.05637251634420153,"bending_length":0.018941450985912975,"low":[-0.18000000000000002,-0.19,0.12],"high":[0.22,0.21000000000000002,0.12]}],"obstacles":[{"name":"spike","vertices":4,"triangles":4,"low":['
grep -qF -- "$facts" out || { fail "not $facts:"; cat out; }
damping='"time_step":0.02,"frames":6,"steps_per_frame":2,"numerical_damping":[{"period":1,"ratio":0.062'
grep -qF -- "$damping" out || { fail "not $damping:"; cat out; }
whole=$(grep -o '"scene_hash":"[0-9a-f]*"' out)
expect 0 '"vertices":25,"triangles":32' info fall.yaml --json --set 'cloth[0].mesh.resolution=[5, 5]'
[ "$(grep -o '"scene_hash":"[0-9a-f]*"' out)" != "$whole" ] || fail "another scene has the same hash"
expect 0 '"frames":9,' info fall.yaml --json --set time.frames=9
[ "$(grep -o '"scene_hash":"[0-9a-f]*"' out)" = "$whole" ] || fail "the number of frames is in the hash"

# What is wrong with a scene is told with its place; a start that intersects is refused.
expect 2 '^broken.yaml: ' info broken.yaml
sed 's/size: \[0.4, 0.4\]/sizes: 7/' fall.yaml >broken.yaml
expect 2 '^broken.yaml:6:' info broken.yaml --json
sed 's/0.12\]/0.05]/' fall.yaml >broken.yaml
expect 2 'intersect' info broken.yaml --set contact.start_intersections=refuse
expect 2 '--json and --set go with scene files' info fall.obj --json

# A run begins with the event of that name, and tells whether it goes on; its scene has the hash that info tells.
expect 0 '^\{"event":"begin","goes_on":false,"step":0,"steps":8\}$' run fall.yaml -o out.run --frames 4 --progress json
hash=$(echo "$whole" | cut -d'"' -f4)
grep -q "\"scene_hash\": *\"$hash\"" out.run/run.json || { fail "run.json has another hash than $hash"; cat out.run/run.json; }
expect 0 '^\{"event":"begin","goes_on":true,"step":8,"steps":12\}$' run fall.yaml -o out.run --resume --progress json

# Some frames of a run are judged by themselves.
expect 0 '^0 intersections in 7 frames$' check out.run
expect 0 '^0 intersections in 3 frames$' check out.run --frames 1:5:2
[ "$(grep -o 'frame [0-9]*' out | tr '\n' ' ')" = 'frame 1 frame 3 frame 5 ' ] || { fail "other frames:"; cat out; }
expect 0 '"frame":6,.*"intersections":0' check out.run -n 6 --json --threads 1
[ "$(wc -l <out)" = 2 ] || { fail "more than one frame and the sums:"; cat out; }
expect 2 'there are frames 0 to 6' check out.run --frames 7
expect 2 '--frames goes with run directories and animations' check out.run/sheet.obj --frames 1

[ $faults = 0 ] && echo "scenes and frames: all as expected"
exit $faults
