#!/usr/bin/env bash
# tulle mend: clean animations come back to the bit; what crosses does not any more, and far from it nothing changes; starts
# that intersect, layers that change places, bodies that leave no room, threads, errors, interrupts and a full disk.
set -uo pipefail
python=/usr/bin/python3
"$python" -c 'import numpy' 2>/dev/null || { echo "skipped: no numpy"; exit 77; }
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
here=$(cd "$(dirname "$0")" && pwd)
cd "$work" || exit 1
faults=0
fault() { echo "fault: $*"; faults=1; }
"$python" "$here/mend_data.py" make || exit 1

# mend CODE ARGUMENTS...: exit code.
mend() {
    local code=$1
    shift
    "$TULLE" mend "$@" >out 2>err </dev/null
    local found=$?
    [ $found = "$code" ] || { fault "mend $*: exit $found, expected $code"; cat out err; }
}
# refuse PATTERN ARGUMENTS...: exit 2, a message, nothing is written.
refuse() {
    local pattern=$1
    shift
    rm -f no.pc2
    mend 2 "$@" -o no.pc2
    grep -q -e "$pattern" err || { fault "mend $*: no \"$pattern\" in:"; cat err; }
    [ ! -e no.pc2 ] || fault "mend $*: something was written"
}
measure() { "$python" "$here/mend_data.py" "$@" || fault "$*"; }

# Clean ones, layers 10 micrometres apart among them, come back to the bit.
for seed in 1 2 3 4; do
    mend 0 clean$seed.pc2 --mesh layers.obj -o back.pc2
    cmp clean$seed.pc2 back.pc2 || fault "clean$seed is not as it was"
done
# In every format a clean one is what convert makes of it.
mkdir mended converted
for name in x.mdd x.glb x.gltf x.usda x.npz %03d.obj %03d.vtp; do
    mend 0 clean1.pc2 --mesh layers.obj -o mended/$name
    "$TULLE" convert clean1.pc2 converted/$name --mesh layers.obj >out || fault "convert to $name"
done
diff -r mended converted || fault "a format differs from convert's"
mend 0 mended/x.glb -o mended/y.glb
"$TULLE" convert converted/x.glb converted/y.glb >out
cmp mended/y.glb converted/y.glb || fault "glTF to glTF"
mend 0 'mended/*.obj' -o mended/y.mdd
cmp mended/y.mdd mended/x.mdd || fault "numbered meshes to MDD"
# A sphere that pokes through the middle of a sheet: clean, the same for any number of threads, far away as it was.
mend 0 poke.pc2 --mesh sheet.obj --body ball.obj -o one.pc2 --reach 1 --threads 1 --report one.csv --colors worst.ply
mend 0 poke.pc2 --mesh sheet.obj --body ball.obj -o three.pc2 --reach 1 --threads 3
cmp one.pc2 three.pc2 || fault "threads change the result"
head -1 one.csv | grep -q '^frame,own_before,bodies_before,own_after,bodies_after,away,' || fault "the table's head"
awk -F, 'NR > 1 && $3 > 0 { before = 1 } NR > 1 && $5 > 0 { after = 1 } END { exit !(before && !after) }' one.csv ||
    fault "the table: crossings before, none after"
grep -q -a 'property double departure' worst.ply || fault "colours"
"$TULLE" check worst.ply --obstacle ball.obj >out || { fault "the coloured frame"; cat out; }
measure smooth poke.pc2 one.pc2
"$TULLE" convert one.pc2 one_%04d.obj --mesh sheet.obj >out || fault "frames"
"$TULLE" check one_*.obj --obstacle ball.obj >out || { fault "frames cross"; cat out; }
# A start that intersects, and two layers that change places for some frames.
mend 0 start.pc2 --mesh sheet.obj --body ball.obj -o start_out.pc2 --json
tail -1 out | grep -q '"bad_frames_after":0' || fault "a start that intersects"
mend 0 exchange.pc2 --mesh layers.obj -o exchange_out.pc2 --json
tail -1 out | grep -q '"own_after":0' || fault "layers that change places"
head -1 out | grep -q '^{"frame":0,"own_before":0,' || fault "a line for the first frame"
# A body that passes through itself with cloth in between: the cloth does not cross itself, and all says so; or it stops.
mend 1 between.pc2 --mesh sheet.obj --body jaws.pc2 --body-mesh jaws.obj -o between_out.pc2
grep -q 'pinched' out || { fault "a pinch is not told"; cat out; }
grep -q 'after  *0 pairs of the cloth with itself' out || { fault "pinched cloth crosses itself"; cat out; }
mend 3 between.pc2 --mesh sheet.obj --body jaws.pc2 --body-mesh jaws.obj -o stopped.pc2 --on-pinch stop
grep -q 'between.pc2: frame [0-9]*: ' err || { fault "where it stopped"; cat err; }
[ ! -e stopped.pc2 ] || fault "a stopped one was written"
# A vertex that jumps ends in no crossing.
mend 0 jump.pc2 --mesh sheet.obj --body ball.obj -o jump_out.pc2

refuse '\-o OUT is missing\|has no triangles' clean1.pc2
refuse 'has no triangles; give the mesh' poke.pc2
refuse 'is not finite' nan.pc2 --mesh sheet.obj
refuse 'belongs to another mesh' clean1.pc2 --mesh sheet.obj
refuse 'has 5 frames, but the cloth has' poke.pc2 --mesh sheet.obj --body short.pc2 --body-mesh sheet.obj
refuse 'body-mesh is given 1 times' poke.pc2 --mesh sheet.obj --body ball.obj --body-mesh sheet.obj
refuse 'frame 0: .*zero area' flat.pc2 --mesh sheet.obj
refuse 'inside' inside.pc2 --mesh small.obj --body ball.obj
refuse 'should be a number from' poke.pc2 --mesh sheet.obj --strength 0
refuse 'ending\|end in' poke.pc2 --mesh sheet.obj --colors worst.png
refuse 'cannot be written: its folder' poke.pc2 --mesh sheet.obj --colors nowhere/worst.ply
mend 2 poke.pc2 --mesh sheet.obj -o poke.pc2
grep -q 'is one of the files that are read' err || { fault "its own input"; cat err; }
mend 2 poke.pc2 --mesh sheet.obj -o nowhere/out.pc2

# An interrupt leaves nothing, whenever it comes. In the foreground timeout sends one; a second one ends the program at once.
for wait in 0.02 0.3; do
    timeout --foreground -s INT $wait "$TULLE" mend poke.pc2 --mesh sheet.obj --body ball.obj -o cut.pc2 --report cut.csv >out 2>err
    [ ! -e cut.pc2 ] && [ ! -e cut.csv ] || cmp -s cut.pc2 one.pc2 || fault "an interrupted one was written"
done
ls -A | grep -q -e '\.tmp$' -e 'tulle-mend' && fault "something is left: $(ls -A)"
# A file that may not grow.
(ulimit -f 40 && "$TULLE" mend poke.pc2 --mesh sheet.obj --body ball.obj -o big.pc2 >out 2>err)
[ $? = 3 ] || { fault "a full disk"; cat err; }
[ ! -e big.pc2 ] || fault "a cut file"
exit $faults
