#!/usr/bin/env bash
# tulle mend: clean animations come back to the bit; what crosses does not any more, and far from it nothing changes; starts
# that intersect, layers that change places, impacts, cloth that hangs, bodies that leave no room, axes and units, threads, errors,
# interrupts and a full disk.
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
diff -r -x x.npz mended converted || fault "a format differs from convert's"
measure archive mended/x.npz converted/x.npz
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
# With the bodies as the cloth met them all is clean, frame by frame, whatever their format; those that were not held are copied.
judge_met() { # CLOTH BODY: frames with crossings
    rm -rf judged && mkdir judged
    "$TULLE" convert "$1" 'judged/cloth_%02d.obj' --mesh sheet.obj >out 2>err || fault "convert $1: $(cat err)"
    "$TULLE" convert "$2" 'judged/body_%02d.obj' "${@:3}" >out 2>err || fault "convert $2: $(cat err)"
    [ "$(ls judged | wc -l)" = 22 ] || fault "$2: frames"
    local k
    for k in $(seq -w 0 10); do
        "$TULLE" check judged/cloth_$k.obj --obstacle judged/body_$k.obj >out || { fault "$2: frame $k"; cat out; }
    done
}
"$TULLE" convert press.pc2 'press_%02d.obj' --mesh press.obj >out || fault "the press as meshes"
for name in x.glb x.usda x.npz; do "$TULLE" convert press.pc2 $name --mesh press.obj >out || fault "the press as $name"; done
mend 1 pressed.pc2 --mesh sheet.obj --body press.pc2 --body-mesh press.obj -o pressed_out.pc2
mend 0 pressed.pc2 --mesh sheet.obj --body press.pc2 --body-mesh press.obj --body far.obj -o pressed_out.pc2 --bodies-out met --report met.csv
grep -q 'use the bodies in met: the pairs are counted with them' out || { fault "bodies to be used are not told"; cat out; }
awk -F, 'NR > 1 && $5 > 0 { after = 1 } NR > 1 && $3 > 0 { before = 1 } END { exit !(before && !after) }' met.csv ||
    fault "pairs are not counted with the bodies as they were met"
cmp far.obj met/far.obj || fault "a body that stands is not copied"
judge_met pressed_out.pc2 met/press.pc2 --mesh press.obj
for name in x.glb x.usda x.npz; do
    mend 0 pressed.pc2 --mesh sheet.obj --body $name -o pressed_out.pc2 --bodies-out met
    judge_met pressed_out.pc2 met/$name
done
mend 0 pressed.pc2 --mesh sheet.obj --body 'press_*.obj' -o pressed_out.pc2 --bodies-out met
judge_met pressed_out.pc2 'met/press_%02d.obj'
for frame in 00 01 02 10; do cmp press_$frame.obj met/press_$frame.obj || fault "frame $frame, in which nothing was held, is not copied"; done
cmp -s press_05.obj met/press_05.obj && fault "frame 05 was held, and is copied"
mend 0 clean1.pc2 --mesh layers.obj --body far.pc2 --body-mesh far.obj -o back.pc2 --bodies-out met_clean
cmp far.pc2 met_clean/far.pc2 || fault "a body that was not held is not copied"
refuse 'no --body is given' pressed.pc2 --mesh sheet.obj --bodies-out nothing
refuse 'as a body and as a body' pressed.pc2 --mesh sheet.obj --body far.obj --body ./far.obj --bodies-out nothing
refuse 'far.obj: is one of the files that are read' pressed.pc2 --mesh sheet.obj --body far.obj --bodies-out .
# Nothing is written over what is read, or twice, numbered files among them.
mkdir twins && cp far.obj twins/press_05.obj && cp press_0?.obj press_10.obj twins
"$TULLE" convert clean1.pc2 'layer_%02d.ply' --mesh layers.obj >out || fault "layers as meshes"
refuse 'press_00.obj: would be written twice, as a body and as a body' pressed.pc2 --mesh sheet.obj --body 'press_*.obj' --body 'twins/press_%02d.obj' --bodies-out nothing
refuse 'press_05.obj: would be written twice' pressed.pc2 --mesh sheet.obj --body 'press_*.obj' --body twins/press_05.obj --bodies-out nothing
refuse 'no.pc2: would be written twice, as' pressed.pc2 --mesh sheet.obj --report ./no.pc2
refuse 'layer_00.ply: is one of the files that are read' 'layer_*.ply' --colors 'layer_%02d.ply'
refuse 'it exists and is not a regular file' pressed.pc2 --mesh sheet.obj --report /dev/null
mkdir same
mend 2 pressed.pc2 --mesh sheet.obj --body 'press_*.obj' -o 'same/press_%02d.obj' --bodies-out same
grep -q 'press_00.obj: would be written twice' err || { fault "OUT among the bodies"; cat err; }
mend 2 pressed.pc2 --mesh sheet.obj --body far.obj -o same/a.pc2 --bodies-out same --report same/far.obj
mend 2 pressed.pc2 --mesh sheet.obj -o same/a.gltf --report same/a.bin
[ -z "$(ls -A same)" ] || fault "something is left: $(ls -A same)"
[ ! -e nothing ] || fault "a folder was left for nothing"
# Files whose names hold what stands for numbers, blanks and quotes.
mkdir "odd \"one's" && cp clean1.pc2 "odd \"one's/50%d.pc2" && cp layers.obj "odd \"one's/a*b c.obj" && cp far.obj "odd \"one's/far %%.obj"
mend 0 "odd \"one's/50%d.pc2" --mesh "odd \"one's/a*b c.obj" --body "odd \"one's/far %%.obj" -o "odd \"one's/back.pc2" --bodies-out "odd \"one's/met"
cmp clean1.pc2 "odd \"one's/back.pc2" || fault "by an odd name it is not as it was"
cmp far.obj "odd \"one's/met/far %%.obj" || fault "a body by an odd name is not copied"
"$TULLE" check "odd \"one's/50%d.pc2" --mesh "odd \"one's/a*b c.obj" >out || { fault "check of an odd name"; cat out; }
# Files that are replaced keep their permissions, others in the folder of the bodies stay.
mkdir old && touch old/far.obj old/table.csv old/worst.ply old/back.pc2 old/other.txt && chmod 600 old/*
mend 0 clean1.pc2 --mesh layers.obj --body far.obj -o old/back.pc2 --bodies-out old --report old/table.csv --colors old/worst.ply
[ "$(stat -c %a old/* | sort -u)" = 600 ] && [ -e old/other.txt ] || fault "permissions: $(ls -l old)"
cmp far.obj old/far.obj || fault "an older body is not replaced"
# Axes and units: the same animation by other numbers; clean ones of other units come back to the bit.
"$TULLE" convert poke.pc2 poke_cm.usda --mesh sheet.obj --units cm --up y >out || fault "a scene in centimetres"
mend 0 poke.pc2 --mesh sheet.obj --body ball.obj -o poke_out.pc2
mend 0 poke_cm.usda --body ball.obj -o poke_m.pc2 --units m
measure near poke_out.pc2 poke_m.pc2
mend 0 poke_cm.usda --body ball.obj -o poke_cm.pc2
grep -q 'departure  *at most 3\.' out || { fault "lengths are not told in the unit of the animation"; cat out; }
"$TULLE" convert poke_cm.pc2 poke_a.pc2 --mesh sheet.obj --from-units cm >out
mend 0 poke_cm.pc2 --mesh sheet.obj --from-units cm --units m -o poke_b.pc2
cmp poke_a.pc2 poke_b.pc2 || fault "a clean one is not what convert makes of it"
"$TULLE" convert clean1.pc2 clean_cm.usda --mesh layers.obj --units cm >out
mend 0 clean_cm.usda -o clean_back.usda
grep -q 'metersPerUnit = 0.01$' clean_back.usda || fault "the unit is lost"
"$TULLE" convert clean_cm.usda clean_a.pc2 >out && "$TULLE" convert clean_back.usda clean_b.pc2 >out
cmp clean_a.pc2 clean_b.pc2 || fault "centimetres do not come back to the bit"
mend 0 clean1.pc2 --mesh layers.obj --from-up y --up y -o back.pc2
cmp clean1.pc2 back.pc2 || fault "y up does not come back to the bit"
# An impact, and cloth that hangs from a tip and is drawn along: nothing stops at once, nothing trembles.
mend 0 landing.pc2 --mesh sheet.obj --body floor.obj -o landing_out.pc2 --report landing.csv
measure still landing.pc2 landing_out.pc2 landing.csv 0.0085 0.0002
mend 0 hanging.pc2 --mesh sheet.obj --body needle.obj -o hanging_out.pc2 --report hanging.csv
measure still hanging.pc2 hanging_out.pc2 hanging.csv 0.010 0.001
for name in landing hanging; do
    rm -f judged/*
    "$TULLE" convert ${name}_out.pc2 'judged/%02d.obj' --mesh sheet.obj >out
    "$TULLE" check judged/*.obj --obstacle $([ $name = landing ] && echo floor || echo needle).obj >out || { fault "$name crosses"; cat out; }
done
# A body may have triangles without area: one that is still goes without them, one that deforms has them now and then.
{ cat ball.obj; echo 'f 1 2 2'; echo 'f 1 2 3'; echo 'f 1 2 3'; } >ball_flat.obj
mend 0 poke.pc2 --mesh sheet.obj --body ball_flat.obj -o poke_flat.pc2
grep -q '^tulle mend: ball_flat.obj: 2 triangles have the same corners as others and are left out' err &&
    grep -q '^tulle mend: ball_flat.obj: 1 triangles have no area and are left out' err || { fault "what a body goes without is not told"; cat err; }
mend 0 poke.pc2 --mesh sheet.obj --body ball.obj -o poke_out.pc2
cmp poke_flat.pc2 poke_out.pc2 || fault "a triangle without area changes the result"
mend 0 poke.pc2 --mesh sheet.obj --body closing.pc2 --body-mesh closing.obj -o poke_closing.pc2
# Departures in an archive.
mend 0 hanging.pc2 --mesh sheet.obj --body needle.obj -o hanging_out.npz
measure departure hanging.pc2 hanging_out.pc2 hanging_out.npz
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
refuse '^tulle mend: .*--gap is 1e+09; in this animation it should be from .*, to 2$' poke.pc2 --mesh sheet.obj --body ball.obj --gap 1e9
refuse 'gap is 1e-09; .*rounding' poke.pc2 --mesh sheet.obj --body ball.obj --gap 1e-9
mend 2 poke.pc2 --mesh sheet.obj -o one.obj
grep -q 'is one mesh, but there are 40 frames; name numbered files' err || { fault "one mesh"; cat err; }
grep -q -e '--frame' err && fault "an option that mend does not have"
"$TULLE" mend --help | sed -n '/^options:/,$p' | tail -n +2 | grep -v -e '^  -.,' -e '^      --' -e '^                            [^ ]' &&
    fault "lines of the help out of their column"
refuse 'ending\|end in' poke.pc2 --mesh sheet.obj --colors worst.png
refuse 'cannot be written: its folder' poke.pc2 --mesh sheet.obj --colors nowhere/worst.ply
mend 2 poke.pc2 --mesh sheet.obj -o poke.pc2
grep -q 'is one of the files that are read' err || { fault "its own input"; cat err; }
mend 2 poke.pc2 --mesh sheet.obj -o nowhere/out.pc2

# After an interrupt, whenever it comes, OUT is absent or whole, and one that was there before is as it was or whole. In the foreground
# timeout sends one; a second one ends the program at once.
poke=(poke.pc2 --mesh sheet.obj --body ball.obj)
for wait in 0.02 0.1 0.2 0.3 0.5 0.8 1.2 1.6; do
    timeout --foreground --preserve-status -s INT $wait "$TULLE" mend "${poke[@]}" -o cut.pc2 --report cut.csv --bodies-out cut_bodies >out 2>err
    code=$?
    if [ $code = 0 ]; then
        cmp cut.pc2 poke_out.pc2 && cmp cut_bodies/ball.obj ball.obj || fault "one that was not interrupted is not whole"
    elif [ -e cut.pc2 ]; then
        [ $code = 130 ] && cmp cut.pc2 poke_out.pc2 && grep -q 'whole and there: cut.pc2;' err || { fault "after $wait s"; cat err; }
    else # without a word where it came before the program was up
        [ $code = 130 ] && [ ! -e cut.csv ] && [ ! -e cut_bodies ] && { [ ! -s err ] || grep -q 'nothing was written' err; } || { fault "after $wait s: $code"; cat err; }
    fi
    rm -rf cut.pc2 cut.csv cut_bodies
    cp one.pc2 old.pc2
    timeout --foreground --preserve-status -s INT $wait "$TULLE" mend "${poke[@]}" -o old.pc2 >out 2>err
    cmp -s old.pc2 one.pc2 || cmp -s old.pc2 poke_out.pc2 || fault "after $wait s an older OUT is neither as it was nor whole"
done
# While numbered files are written: each that is there is whole.
mend 0 "${poke[@]}" -o 'whole_%03d.vtp'
"$TULLE" mend "${poke[@]}" -o 'cut_%03d.vtp' >out 2>err &
while kill -0 $! 2>/dev/null && [ ! -e cut_000.vtp ]; do sleep 0.01; done
kill -INT $! 2>/dev/null
wait $!
code=$?
[ $code = 130 ] || [ $code = 0 ] || { fault "interrupted while files are written: $code"; cat err; }
for file in cut_*.vtp; do cmp "$file" "whole_${file#cut_}" || fault "$file is not whole"; done
ls -A | grep -q -e '\.tmp$' -e 'tulle-mend' && fault "something is left: $(ls -A)"
# A file that may not grow.
(ulimit -f 40 && "$TULLE" mend poke.pc2 --mesh sheet.obj --body ball.obj -o big.pc2 >out 2>err)
[ $? = 3 ] || { fault "a full disk"; cat err; }
[ ! -e big.pc2 ] || fault "a cut file"
exit $faults
