#!/usr/bin/env bash
# tulle convert: there and back between every pair of formats, frame ranges, axes, units, numbered files, subdivision,
# and what bad input, interrupts and a full disk leave behind.
set -uo pipefail
work=$(mktemp -d)
trap 'umount "$work/disk" 2>/dev/null; rm -rf "$work"' EXIT
cd "$work" || exit 1
faults=0
fault() { echo "fault: $*"; faults=1; }

# convert ARGUMENTS...: must work.
convert() {
    "$TULLE" convert "$@" >out 2>err || { fault "convert $*: exit $?"; cat err; }
}
# expect CODE PATTERN ARGUMENTS...: exit code, and a line of what is said.
expect() {
    local code=$1 pattern=$2
    shift 2
    "$TULLE" convert "$@" >out 2>err </dev/null
    local found=$?
    [ $found = "$code" ] || { fault "convert $*: exit $found, expected $code"; cat out err; }
    grep -q -e "$pattern" out err || { fault "convert $*: no \"$pattern\" in:"; cat out err; }
}
# refuse PATTERN ARGUMENTS...: exit 2, and no file is made or changed.
refuse() {
    ls -lR --time-style=full-iso >before
    expect 2 "$@"
    ls -lR --time-style=full-iso >after
    diff <(grep -v ' \(before\|after\|out\|err\)$\|^total' before) \
        <(grep -v ' \(before\|after\|out\|err\)$\|^total' after) || fault "files changed by a refused: ${*:2}"
}
# said PATTERN: the last output has such a line.
said() { grep -q -e "$1" out || { fault "no \"$1\" in:"; cat out; }; }
same() { cmp "$1" "$2" || fault "$1 and $2 differ"; }

# A bent strip; the first number has many digits, the second is tiny, no vertex lies outside of all triangles.
cat >strip.obj <<'END'
v 0.1 0.30000000000000004 -0
v 1.0000000000000002 1e-200 0.3333333333333333
v 2 -0.7 0.123456789012345
v 0.1 1.1 0.9
v 1 1.2345678901234567 1
v 2 1 -3.25
f 1 2 5
f 1 5 4
f 2 3 6
f 2 6 5
END

# ---- there and back ----
convert strip.obj start.obj # the program's own way to write it
for a in obj ply vtp; do
    convert strip.obj a.$a
    said '^  loss        none$'
    for b in obj ply vtp; do
        convert a.$a b.$b
        convert b.$b c.obj
        same start.obj c.obj
    done
done
# Float once, then the same for good. STL numbers its vertices by first use: compare from the second time on.
convert strip.obj a.stl
said '^  loss        positions are rounded to float, by [0-9.e-]* m at most$'
convert a.stl first.obj
said '^  mesh        6 vertices, 4 triangles$'
convert first.obj a.stl # from floats, its normals too
for b in obj ply vtp stl pc2; do
    mesh=()
    [ $b = pc2 ] && mesh=(--mesh first.obj)
    convert first.obj b.$b
    convert b.$b "${mesh[@]}" c.stl
    same a.stl c.stl
    convert b.$b "${mesh[@]}" c.obj
    same first.obj c.obj
    convert b.$b "${mesh[@]}" c.pc2
    convert first.obj d.pc2
    same c.pc2 d.pc2
done
for a in obj ply vtp; do
    convert strip.obj a.$a
    convert a.$a a.pc2
    convert a.pc2 --mesh strip.obj b.$a
    convert b.$a b.pc2
    same a.pc2 b.pc2
    convert a.pc2 b.$a # without triangles
    said '6 vertices, 0 triangles'
done

# What convert reads, info and check read.
"$TULLE" info a.vtp >out || fault "info of a VTP file: exit $?"
said '^  vertices  *6 (0 used by no triangle)$'
"$TULLE" check a.vtp >out || fault "check of a VTP file: exit $?"
said '^a.vtp: 0 intersections$'

# ---- axes and units ----
convert strip.obj up.obj --up y
said '^  axes        y up, from z up: (x, y, z) became (x, z, -y)$'
[ "$(sed -n 1p up.obj)" = 'v 0.1 -0 -0.30000000000000004' ] || fault "turned wrongly: $(sed -n 1p up.obj)"
convert up.obj down.obj --from-up y
same start.obj down.obj
convert up.obj down.obj --from-up y --up y
same up.obj down.obj
convert strip.obj cm.obj --units cm
said '^  units       centimetres, from metres: times 100$'
[ "$(sed -n 3p cm.obj)" = 'v 200 -70 12.3456789012345' ] || fault "scaled wrongly: $(sed -n 3p cm.obj)"
convert cm.obj back.obj --from-units cm
[ "$(sed -n 3p back.obj)" = 'v 2 -0.7 0.123456789012345' ] || fault "scaled back wrongly: $(sed -n 3p back.obj)"
convert strip.obj in.obj --from-units ft --units in
said 'times 12$'
[ "$(sed -n 6p in.obj)" = 'v 24 12 -39' ] || fault "feet became $(sed -n 6p in.obj)"

# ---- a run ----
"$TULLE" run "$TULLE_SOURCE_DIR/test/e2e/scenes/small.yaml" -o run --progress none >out || fault "the run: exit $?"
convert run whole.pc2
same run/sheet.pc2 whole.pc2
said '^  from        run run, cloth sheet$'
said '^  frames      0 to 24: 25$'
convert run/sheet.pc2 copy.pc2
same run/sheet.pc2 copy.pc2
convert run f_%04d.vtp --frames 0:24:6 --pvd f.pvd
said '^f_0000.vtp to f_0024.vtp, 5 files$'
[ "$(echo f_*.vtp)" = 'f_0000.vtp f_0006.vtp f_0012.vtp f_0018.vtp f_0024.vtp' ] || fault "files: $(echo f_*.vtp)"
grep -q 'timestep="0.1[12][0-9]*" .*file="f_0006.vtp"' f.pvd || { fault "the collection:"; cat f.pvd; }
[ "$(grep -c DataSet f.pvd)" = 5 ] || fault "the collection has other files"
convert 'f_*.vtp' every.pc2
convert run every_too.pc2 --frames ::6
same every.pc2 every_too.pc2
convert f_%04d.vtp last.obj --frame last
convert run last_too.obj --frame 24
same last.obj last_too.obj
convert run/sheet.pc2 --mesh run/sheet.obj last_too.obj --frame 24
same last.obj last_too.obj
convert f_%04d.vtp g%d.ply --frames 6:18
[ "$(echo g*.ply)" = 'g12.ply g18.ply g6.ply' ] || fault "files: $(echo g*.ply)"
convert g%d.ply h.pc2
convert run h_too.pc2 --frames 6:18:6
same h.pc2 h_too.pc2
convert run spike.pc2 --body spike
said '^ *in [0-9]* of them the body is not in the scene'
convert run box.stl --body box --frame 0
rm f_0012.vtp
refuse 'no file of number 12' f_%04d.vtp x.pc2
convert f_%04d.vtp two.pc2 --frames 0:6
said '^  frames      0 to 6 in steps of 6: 2$'
refuse 'no file of number 12' f_%04d.vtp x.pc2 --frames 0:18:6
mkdir other
convert run f_%04d.vtp --frames 0:1 --pvd other/f.pvd
grep -q "file=\"$(realpath f_0001.vtp)\"" other/f.pvd || { fault "another folder's collection:"; cat other/f.pvd; }

# ---- subdivision ----
convert run s.obj --frame 0 --subdivide 2
said '^  subdivided  2 times: 2401 vertices, 4608 triangles$'
said '^  judged      the subdivided surface does not intersect'
convert run s_%d.obj --frames 0:12:12 --subdivide 2
same s.obj s_0.obj
convert run/sheet.pc2 --mesh run/sheet.obj s_too.obj --frame 0 --subdivide 2
same s.obj s_too.obj
convert strip.obj t.obj --subdivide 0
same start.obj t.obj
# A tent with a triangle in it, through which smoothing lowers its sides.
cat >tent.obj <<'END'
v 1 0 0
v 0 1 0
v -1 0 0
v 0 -1 0
v 0 0 1
v -0.3 -0.3 0.3
v 0.3 -0.3 0.3
v 0 0.3 0.3
f 1 2 5
f 2 3 5
f 3 4 5
f 4 1 5
f 6 7 8
END
"$TULLE" check tent.obj >out || fault "the tent intersects before"
expect 0 'convert: the subdivided surface intersects in [0-9]* pair.*; the simulated surface does not intersect' \
    tent.obj t.obj --subdivide 2
said '^  judged      the subdivided surface intersects'
"$TULLE" check t.obj >out && fault "the subdivided tent does not intersect"

# ---- what is refused ----
cp strip.obj keep.obj
mkdir folder folder.obj
printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n' >broken.obj
echo odd >odd
printf '<VTKFile type="PolyData"><PolyData>' >cut.vtp
printf 'v 1e300 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n' >far.obj
head -c 100 run/sheet.pc2 >cut.pc2
refuse 'TO is missing' strip.obj
refuse 'one too many' strip.obj a b
refuse 'should end in .obj' strip.obj a.xyz
refuse 'should end in .obj' strip.obj a
refuse 'missing.obj' missing.obj x.obj
refuse 'no run.json' folder x.obj
refuse 'its format is not known' odd x.obj
refuse 'broken.obj' broken.obj x.obj
refuse 'cut.vtp:1' cut.vtp x.obj
refuse 'cut.pc2' cut.pc2 x.pc2
refuse 'one of the files that are read' strip.obj strip.obj
refuse 'one of the files that are read' run run/sheet.pc2
refuse 'one of the files that are read' run run/box.obj --frame 0
refuse 'one of the files that are read' g%d.ply 'g%01d.ply' --up y
refuse 'one of the files that are read' run/sheet.pc2 --mesh run/sheet.obj run/sheet.obj --frame 0
refuse 'folder.obj.*not a regular file' strip.obj folder.obj
refuse 'its folder' strip.obj nowhere/x.obj
refuse 'its folder is a file' strip.obj keep.obj/x.obj
refuse 'there are 25 frames' run x.obj
refuse 'frame 25 does not exist' run x.obj --frame 25
refuse 'frame 25 does not exist' run x.pc2 --frames 0:25
refuse 'should be N, A:B' run x.pc2 --frames 0-25
refuse 'ends before it begins' run x.pc2 --frames 5:3
refuse 'give one of them' run x.pc2 --frames 5:6 --frame 3
refuse 'no body "curtain"; it has sheet, ground, box' run x.pc2 --body curtain
refuse 'goes with the directory of a run' strip.obj x.obj --body sheet
refuse 'goes with a point cache' strip.obj x.obj --mesh strip.obj
refuse 'belongs to another mesh' run/sheet.pc2 x.obj --mesh strip.obj --frame 0
refuse 'STL holds triangles' run/sheet.pc2 x.stl --frame 0
refuse 'give their file by --mesh' run/sheet.pc2 x.pc2 --subdivide 1
refuse 'float cannot hold' far.obj x.stl
refuse 'float cannot hold' far.obj x.pc2
refuse 'one %d or %0Nd' run x_%s.obj
refuse 'one %d or %0Nd' run x_%n%n%n.obj
refuse 'one %d or %0Nd' g%4d.ply x.pc2
refuse 'names files that are there' run 'x_*.obj'
refuse 'has no number' run x_%d.pc2
refuse 'no file with such a name' nothing_%d.obj x.pc2
refuse 'goes with numbered VTP' run x.pc2 --pvd x.pvd
refuse 'should end in .pvd' run x_%d.vtp --pvd x.vtp
refuse 'subdivide' strip.obj x.obj --subdivide 7
refuse 'subdivide' strip.obj x.obj --subdivide -1
refuse '"x" should be' strip.obj x.obj --up x
refuse '"km" should be' strip.obj x.obj --units km
refuse 'did you mean --subdivide' strip.obj x.obj --subdivde 1
cp strip.obj q_0.obj
sed 's/f 2 6 5/f 6 5 2/' strip.obj >q_1.obj
refuse 'q_1.obj.*same vertices and triangles' q_%d.obj x.pc2
# Files that go wrong midway leave the ones before, and that is said.
expect 2 'whole and there: w_0.ply' q_%d.obj w_%d.ply
[ "$(echo w_*)" = w_0.ply ] || fault "left: $(echo w_*)"

# ---- progress ----
# JSON for programs: how many readings of frames there are, how far it is, and the end. Without it nothing is said in a short time.
has_python=1
command -v python3 >/dev/null || { has_python=0; echo "not tested: the lines of --progress json; there is no python3"; }
for ending in pc2 glb usda npz; do
    convert run "told.$ending" --body sheet --progress json
    [ $has_python = 0 ] || python3 - <<'END' || fault "progress of $ending: $(cat err)"
import json
lines = [json.loads(line) for line in open("err")]
events = [line["event"] for line in lines]
count = lines[0]["count"]
done = [line["done"] for line in lines if line["event"] == "frames"]
assert events[0] == "begin" and events[-1] == "end" and lines[-1] == {"event": "end", "state": "finished"}, events
assert set(events) == {"begin", "frames", "end"} and count > 1 and done == sorted(done) and done[-1] == count, lines
assert all(line["rest_seconds"] >= 0 and line["count"] == count for line in lines[1:-1])
END
    for kind in auto none; do
        convert run "told.$ending" --body sheet --progress $kind
        [ -s err ] && fault "--progress $kind: $(cat err)"
    done
done
convert run "told.pc2" --body sheet --progress json --subdivide 1
tail -1 err | grep -qx '{"event":"end","state":"finished"}' || fault "progress of a subdivided one: $(cat err)"
refuse '"bar" should be' run x.pc2 --progress bar
expect 2 '{"event":"end","state":"failed"}' q_%d.obj w_%d.ply --progress json
rm w_*

# ---- interrupts, full disks ----
# wait_for PATTERN: until such a file is there, so that the work has begun.
wait_for() {
    for _ in $(seq 600); do
        compgen -G "$1" >/dev/null && return
        sleep 0.05
    done
    fault "no $1 appears"
}
for i in $(seq 0 400); do cp last.obj "many_$i.obj"; done
"$TULLE" convert many_%d.obj many.pc2 --subdivide 3 >out 2>err &
wait_for 'many.pc2.*.tmp'
kill -INT $!
wait $!
code=$?
[ $code = 130 ] || fault "interrupted: exit $code"
grep -q 'nothing was written' err || { fault "interrupted: no word of it"; cat err; }
[ "$(ls | grep -c 'many.pc2')" = 0 ] || fault "interrupted: left $(ls | grep many.pc2)"
for ending in glb gltf usda npz mdd; do
    rm -f err # of the one before, which would be waited for
    "$TULLE" convert many_%d.obj "stopped.$ending" --subdivide 3 --progress json >out 2>err &
    for _ in $(seq 600); do grep -q '"event":"frames"' err && break; sleep 0.02; done
    kill -INT $!
    wait $!
    code=$?
    [ $code = 130 ] || fault "interrupted, $ending: exit $code"
    [ -z "$(compgen -G 'stopped.*')" ] || { fault "interrupted, $ending: left $(echo stopped.*)"; rm -f stopped.*; }
    tail -3 err | grep -qx '{"event":"end","state":"interrupted"}' || { fault "interrupted, $ending: progress does not end"; cat err; }
done
"$TULLE" convert many_%d.obj n_%d.vtp --subdivide 3 >out 2>err &
wait_for 'n_0.vtp'
kill -TERM $!
wait $!
code=$?
[ $code = 130 ] || fault "interrupted: exit $code"
[ "$(ls | grep -c '\.tmp$')" = 0 ] || fault "interrupted: left $(ls | grep tmp)"
for file in n_*.vtp; do
    [ -e "$file" ] || continue
    "$TULLE" convert "$file" n.obj >/dev/null || fault "interrupted: $file is not whole"
done
"$TULLE" convert strip.obj x.obj >/dev/full 2>err
[ $? = 3 ] || fault "a report onto a full disk: no exit 3"
mkdir disk
if [ "$(id -u)" = 0 ] && mount -t tmpfs -o size=32k tmpfs disk 2>/dev/null; then
    expect 3 'No space left' run disk/x.pc2 --frames 0:20
    expect 3 'No space left' s.obj disk/x.ply
    [ -z "$(ls disk)" ] || fault "a full disk holds $(ls disk)"
    expect 3 'whole and there: disk/x_0.ply to' run disk/x_%d.ply
    [ "$(ls disk | grep -c tmp)" = 0 ] || fault "a full disk holds $(ls disk)"
elif [ $faults = 0 ]; then
    echo "skipped: a small disk cannot be mounted here, so none is full; all else is as expected"
    exit 77
fi
exit $faults
