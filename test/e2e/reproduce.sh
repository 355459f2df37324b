#!/usr/bin/env bash
# `tulle reproduce` over small scenes with the names of the paper's: resumes, its tables, its report, missing scenes.
set -uo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
faults=0
fail() { echo "$*"; faults=1; }

# write_scene NAME: a sheet falls on a spike.
write_scene() {
    cat >"scenes/$1.yaml" <<END_OF_SCENE
title: $1
time: {step: 0.02 s, frames: 6}
cloth:
  - name: sheet
    mesh: {shape: rectangle, size: [0.4, 0.4], resolution: [9, 9]}
    translate: [0.02, 0.01, 0.12]
obstacles:
  - name: ground
    mesh: {shape: plane, size: [2, 2]}
    friction: $2
  - name: spike
    mesh: {shape: tetrahedron, radius: 0.05, height: 0.11}
    translate: [-0.1, 0, 0.001]
    friction: $2
END_OF_SCENE
}

# expect CODE PATTERN ARGUMENTS...: exit code, and a line of either output.
expect() {
    local code=$1 pattern=$2
    shift 2
    "$TULLE" reproduce "$@" >out 2>&1
    local found=$?
    [ $found = "$code" ] || { fail "tulle reproduce $*: exit $found, expected $code"; tail -20 out; }
    [ -z "$pattern" ] || grep -Eq -- "$pattern" out || { fail "tulle reproduce $*: no \"$pattern\" in:"; tail -20 out; }
}

# columns FILE HEADER: the table's first line.
columns() { [ "$(head -n 1 "$1" 2>/dev/null)" = "$2" ] || fail "$1: its columns are $(head -n 1 "$1" 2>&1)"; }

mkdir scenes
expect 2 'no directory' all --scenes nowhere
expect 2 'did you mean "counterexamples"' counterexample --scenes scenes
expect 2 'cannot be made' counterexamples --scenes scenes -o missing/folder

# Without any scene the motions made for it are there, and what is missing is named.
expect 2 'scenes/animation_3.yaml is missing' counterexamples --scenes scenes -o bare
columns bare/counterexamples_motions.csv motion,triangles,intersections_start,intersections_end,collisions,paper_patches,paper_found,paper_missed,proven_missed
# Both are clean at both ends, collide in between, and the paper's rule misses all of it; what is proven misses nothing.
[ "$(grep -cE '^(ramp|ring),768,0,0,([0-9]+),1,0,\2,0$' bare/counterexamples_motions.csv)" = 2 ] ||
    { fail "motions:"; cat bare/counterexamples_motions.csv; }
grep -q '^r[a-z]*,768,0,0,[1-9]' bare/counterexamples_motions.csv || fail "the motions collide nowhere"

for name in example_one_low_friction rings ribbons animation_1 animation_2 animation_3 animation_4 animation_5 animation_6; do
    write_scene $name 0.02
done
write_scene example_one_high_friction 0.9

expect 0 '' counterexamples --scenes scenes -o out.d
columns out.d/counterexamples_scenes.csv run,frames,contact_distance_mm,events,paper_patches,paper_found,paper_missed,frames_with_missed,proven_missed
[ "$(wc -l <out.d/counterexamples_scenes.csv)" = 11 ] || fail "counterexamples: a scene is missing"
[ "$(cut -d, -f9 out.d/counterexamples_scenes.csv | sort -u | tr '\n' ' ')" = '0 proven_missed ' ] || fail "something proven was missed"
columns out.d/runs.csv run,state,cloth_particles,cloth_triangles,obstacle_particles,obstacle_triangles,frames,simulated_seconds,step_seconds,rescues_per_1000_contacts,bad_frames,intersections
grep -q '^rings,finished,81,128,8,6,7,0.12,' out.d/runs.csv || fail "runs.csv tells wrong sizes of rings"

# What is whole is not run or judged again; what was cut short goes on to the same state.
cp -R out.d/runs/rings whole
sed -i 's/"state": *"finished"/"state": "interrupted"/' out.d/runs/rings/run.json
expect 0 '"run":"ribbons","what":"is there"' counterexamples --scenes scenes -o out.d
grep -q '"run":"rings","what":"runs"' out || fail "a run that was cut short did not go on"
grep -q 'is judged' out && fail "a judged run was judged again"
cmp -s whole/sheet.pc2 out.d/runs/rings/sheet.pc2 || fail "the resumed run differs"

# A frame that intersects is seen.
cp -R out.d bad.d
rm bad.d/judged/rings.csv
python3 - bad.d/runs/rings/sheet.pc2 <<'END_OF_PYTHON'
import struct, sys
data = bytearray(open(sys.argv[1], "rb").read())
vertices = struct.unpack_from("<i", data, 16)[0]
offset = 32 + 12 * vertices * 6
struct.pack_into("<3f", data, offset, -0.1, 0.0, -0.5)
open(sys.argv[1], "wb").write(data)
END_OF_PYTHON
expect 0 '' counterexamples --scenes scenes -o bad.d
grep -qE '^rings,.*,1,[1-9][0-9]*$' bad.d/runs.csv || { fail "an intersecting frame was not seen"; grep rings bad.d/runs.csv; }

[ $faults = 0 ] && echo "reproduce: all as expected"
exit $faults
