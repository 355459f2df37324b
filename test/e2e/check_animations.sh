#!/usr/bin/env bash
# tulle check and info on animations: every format frame by frame, obstacles that move, axes and units, seams, what is refused.
set -uo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 1
faults=0
fault() { echo "fault: $*"; faults=1; }
# expect CODE PATTERN ARGUMENTS...: exit code of `tulle check ARGUMENTS`, and a line of its output.
expect() {
    local code=$1 pattern=$2
    shift 2
    "$TULLE" check "$@" >out 2>err </dev/null
    local found=$?
    [ $found = "$code" ] || { fault "check $*: exit $found, expected $code"; cat out err; }
    grep -q -e "$pattern" out err || { fault "check $*: no \"$pattern\" in:"; cat out err; }
}
last() { [ "$(tail -n 1 out)" = "$1" ] || fault "last line is \"$(tail -n 1 out)\", not \"$1\""; }
convert() { "$TULLE" convert "$@" >/dev/null || fault "convert $*"; }
said() { grep -q -e "$1" out || { fault "no \"$1\" in:"; cat out; }; }

# A square, and a spike that crosses it in the second of three frames.
printf 'v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n' >square.obj
for frame in "0 3" "1 -1" "2 3.5"; do
    read -r number height <<<"$frame"
    printf 'v 0.6 0.2 %s\nv 0.7 0.2 %s\nv 0.6 0.3 %s\nf 1 2 3\n' "$height" "$height" "$(echo "$height" | awk '{ print $1 + 2 }')" >"spike_$number.obj"
done
convert spike_%d.obj spike.pc2
convert spike_%d.obj spike.mdd --fps 10
for ending in glb gltf usda npz; do convert spike_%d.obj "spike.$ending" --fps 10; done
convert spike_%d.obj cm.usda --fps 10 --units cm --up y
convert square.obj square.glb

for spike in "spike.pc2 --mesh spike_0.obj" "spike.mdd --mesh spike_0.obj" spike.glb spike.gltf spike.usda spike.npz cm.usda spike_%d.obj 'spike_*.obj'; do
    read -ra words <<<"$spike"
    set -f
    expect 1 '^square.obj frame 1.*: 1 intersection$' square.obj --obstacle "${words[@]}"
    grep -q "^  square.obj triangle 0 and ${words[0]//\*/.} triangle 0 near (0.6[0-9.]*, 0.2[0-9.]*, 0)" out || { fault "$spike: the pair"; cat out; }
    last '1 intersections in 1 of 3 frames'
    expect 1 'frame 1' square.obj "${words[@]}" --together
    last '1 intersections in 1 of 3 frames'
    expect 0 '^square.obj frame 2' square.obj --obstacle "${words[@]}" --frames ::2
    last '0 intersections in 2 frames'
    expect 0 'frame 1' "${words[@]}"
    last '0 intersections in 3 frames'
    cp out one
    expect 0 'frame 1' "${words[@]}" --threads 1
    cmp -s one out || fault "$spike: threads change the output"
    set +f
done
# A mesh whose axes are turned meets what stands upright where it is.
expect 1 'frame 1 .*: 1 intersection' square.glb --obstacle spike.glb
expect 1 'frame 1.*: 1 intersection' square.glb --obstacle spike.pc2 --mesh spike_0.obj
expect 1 'frame 1' spike.glb --obstacle square.obj
expect 1 '"frame":1,"time":0.1,"intersections":1,"pairs":\[{"a":"square.obj","triangle_a":0,"b":"spike.npz"' square.obj --obstacle spike.npz --json
expect 1 '"frame":1,"time":null,"intersections":1' square.obj --obstacle spike.pc2 --mesh spike_0.obj --json
last '{"frames":3,"frames_with_intersections":1,"intersections":1}'
# Places are told in metres with z up, whatever the file has: of one file alone, of several, in a unit that has no name.
for number in 0 1 2; do cat square.obj <(sed 's/^f .*/f 5 6 7/' "spike_$number.obj") >"both_$number.obj"; done
for words in "glb" "usda --units cm --up y" "usda --units mm --up z" "npz"; do
    read -ra words <<<"$words"
    convert both_%d.obj "both.${words[0]}" --fps 10 "${words[@]:1}"
    expect 1 "^  both.${words[0]} triangle 0 and both.${words[0]} triangle 2 near (0.6[0-9.]*, 0.2[0-9.]*, 0)$" "both.${words[0]}"
    expect 1 '"near":\[0.6[0-9.]*,0.2[0-9.]*,0\(.0\)*\]' "both.${words[0]}" --json
    expect 1 'near (0.6[0-9.]*, 0.2[0-9.]*, 0)$' "both.${words[0]}" --obstacle square.glb
done
convert spike_%d.obj odd.usda --fps 10 --up y
sed -i 's/metersPerUnit = .*/metersPerUnit = 37/' odd.usda
expect 0 'frame 2' odd.usda
expect 2 'odd.usda: its unit is 37 m, .*--from-units of tulle convert' square.obj odd.usda --together
convert both_%d.obj odd.usda --fps 10 --up y
sed -i 's/metersPerUnit = .*/metersPerUnit = 2.5/' odd.usda
expect 1 ' near (1.[0-9.]*, 0.[0-9.]*, 0)$' odd.usda
convert spike_%d.obj odd.usda --fps 10 --up y
sed -i 's/metersPerUnit = .*/metersPerUnit = 37/' odd.usda
# Two caches, each with its mesh; a mesh beside animations.
expect 0 'frame 2' spike.pc2 spike.mdd --mesh spike_0.obj --mesh spike_0.obj
last '0 intersections in 6 frames'
expect 1 '3 frames' spike.pc2 spike.mdd --mesh spike_0.obj --mesh spike_0.obj --together
expect 0 '^square.obj: 0' square.obj spike.npz
last '0 intersections in 4 frames'

# Every frame of what Tulle simulates is clean in every format.
"$TULLE" run "$TULLE_SOURCE_DIR/test/e2e/scenes/small.yaml" -o run --progress none >/dev/null || fault "the run: exit $?"
count=$("$TULLE" check run | tail -n 1 | sed 's/.* in \([0-9]*\) frames/\1/')
for ending in pc2 mdd glb usda npz; do
    convert run "sheet.$ending" --body sheet
    case $ending in pc2 | mdd) mesh=(--mesh run/sheet.obj) ;; *) mesh=() ;; esac
    expect 0 'frame 3' "sheet.$ending" "${mesh[@]}"
    last "0 intersections in $count frames"
done
expect 0 'frame 0' sheet.glb --obstacle run/ground.obj
last "0 intersections in $count frames"

# Seams: a strip whose texture is cut along the middle edge has two vertices at each of its ends.
printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0.5\nvt 0 0\nvt 1 0\nvt 0 1\nvt 0.5 0.5\nvt 0.5 1\nvt 1 1\nf 1/1 2/2 3/3\nf 2/4 4/6 3/5\n' >seam.obj
convert seam.obj seam.glb
expect 1 '2 vertices are in the place of others; .* --weld' seam.glb
last '1 intersections in 1 of 1 frames'
expect 0 'seam.glb frame 0' seam.glb --weld
grep -q 'in the place of others' err && fault "a welded seam is told"
# What comes apart is no seam, but what stays together still is.
printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 0 0\nv 1 1 0.5\nv 0 1 0\nf 1 2 3\nf 4 5 6\n' >apart_0.obj
sed 's/v 1 0 0/v 1 0 1/; s/v 1 1 0.5/v 1 2 0.5/; 6s/.*/v 0 1.5 0/' apart_0.obj >apart_1.obj
sed 's/v 1 0 0/v 1 0 2/; s/v 1 1 0.5/v 1 2 0.5/' apart_0.obj >apart_2.obj
expect 0 'frame 0: 0' apart_%d.obj --frames 0:2:2 --weld
expect 1 'frame 0: 1' apart_%d.obj --weld
expect 1 'frame 0: 1' apart_%d.obj

# ---- tulle info ----
# info FILE: what it says of a file.
info() { "$TULLE" info "$@" >out 2>err || { fault "info $*: exit $?"; cat err; }; }
for ending in glb usda npz; do
    info "spike.$ending"
    said "^spike.$ending: animation ("
    said '^  vertices         3$'
    said '^  triangles        1$'
    said '^  frames           3, from 0 s to 0.2 s$'
    said '^  frame 2$'
    said '^  as cloth         can be used$'
done
info spike.npz
said '^  axes             z points up; a unit is 1 m$'
said '  z  3.5 .. 5.5 m$'
info spike.glb
said '^  axes             y points up; a unit is 1 m; below z points up, in metres$'
said '  z  3.5 .. 5.5 m$'
info cm.usda
said '^  axes             y points up; a unit is 0.01 m; below z points up, in metres$'
said '  z  3.5 .. 5.5 m$'
info odd.usda
said '  z  129.5 .. 203.5 m$'
info spike_%d.obj
said '^spike_%d.obj: numbered meshes$'
said '^  frames           3, numbers 0 to 2 in steps of 1$'
info square.glb
said '^  frames           1'
for file in missing.npz 'missing_%d.obj'; do
    "$TULLE" info "$file" >out 2>err
    [ $? = 2 ] || fault "info $file: exit $?"
    grep -q 'missing' err || { fault "info $file:"; cat err; }
done

# ---- what is refused ----
expect 2 'holds no triangles.*--mesh names' spike.pc2
expect 2 'belongs to another mesh' spike.pc2 --mesh square.obj
expect 2 '--mesh is given 2 times, but there are 1 point caches' spike.pc2 --mesh spike_0.obj --mesh spike_0.obj
expect 2 '--mesh is given 1 times' square.obj --mesh spike_0.obj
expect 2 'has [0-9]* frames, but' sheet.npz --obstacle spike.npz
expect 2 '--frames goes with run directories and animations' square.obj --frames 0
expect 2 '--weld goes with animations' square.obj --weld
expect 2 'has no frame\|there is no frame\|frame 7' spike.npz --frames 7
expect 2 'missing.glb' missing.glb
head -c 200 spike.npz >cut.npz
expect 2 'cut.npz' cut.npz
mv spike_1.obj spike_3.obj
expect 2 'no file of number 1' spike_%d.obj
expect 0 'frame 2' spike_%d.obj --frames 0:2:2
cp square.obj '50%done.obj'
expect 0 '^50%done.obj: 0 intersections$' '50%done.obj'
[ $faults = 0 ] && echo "animations are judged as they should"
exit $faults
