#!/usr/bin/env bash
# tulle convert to glTF, USD, MDD and NPZ: every number against the caches of the run, what is refused, and what a full disk
# leaves behind.
set -uo pipefail
command -v python3 >/dev/null || { echo "skipped: there is no python3"; exit 77; }
here=$(cd "$(dirname "$0")" && pwd)
work=$(mktemp -d)
trap 'umount "$work/disk" 2>/dev/null; rm -rf "$work"' EXIT
cd "$work" || exit 1
faults=0
fault() { echo "fault: $*"; faults=1; }
convert() { "$TULLE" convert "$@" >out 2>err || { fault "convert $*: exit $?"; cat err; }; }
# refuse PATTERN ARGUMENTS...: exit 2, and no new file.
refuse() {
    : >after; : >before; ls >before
    "$TULLE" convert "${@:2}" >out 2>err
    local found=$?
    ls >after
    [ $found = 2 ] || fault "convert ${*:2}: exit $found, not 2"
    grep -q -e "$1" err || { fault "convert ${*:2}: no \"$1\" in:"; cat err; }
    cmp -s before after || fault "convert ${*:2} left files"
}
said() { grep -q -e "$1" out || { fault "no \"$1\" in:"; cat out; }; }

cat >scene.yaml <<'END'
time: {step: 0.01 s, frames: 8}
cloth:
  - name: sheet
    mesh: {shape: rectangle, size: [0.4, 0.4], resolution: [6, 6]}
    translate: [0, 0, 0.2]
obstacles:
  - name: floor
    mesh: {shape: plane, size: [2, 2]}
  - name: wall
    mesh: {shape: box, size: [0.1, 0.1, 0.1]}
    translate: [0, 0, 0.1]
    motion: {keyframes: [{time: 0 s}, {time: 0.1 s, translate: [0, 0, 0.02]}]}
  - name: box
    mesh: {shape: box, size: [0.1, 0.1, 0.1]}
    translate: [0, 0, 0.3]
    dynamic: {mass: 0.2 kg}
    copies: {row: {count: 2, offset: [0.15, 0.02, 0.18]}}
END
"$TULLE" run scene.yaml -o falls >out 2>&1 || { cat out; exit 1; }
for name in falls.glb falls.gltf falls.usda falls.npz; do
    convert falls $name
    said '^  bodies      5: '
done
convert falls double.npz --double
convert falls y.npz --up y
convert falls feet.usda --units ft --body sheet
convert falls sheet.mdd --body sheet
convert falls sheet.pc2 --body sheet
convert falls thin.glb --body sheet --frames 1:7:3 --interpolation step
convert falls 'one_%03d.glb' --frames 2:4:2
convert falls smooth.glb --body sheet --subdivide 1
convert falls smooth_last.ply --body sheet --subdivide 1 --frame last --up y
# Point caches into each other and back.
convert sheet.pc2 a.mdd --fps 100
cmp a.mdd sheet.mdd || fault "PC2 to MDD is not what the run gives"
# Times that the target cannot hold are told: even ones, and those that are not.
convert sheet.mdd told.pc2
said 'counts frames, without times: the first one is at 0 s, and a second has 100$'
convert sheet.mdd 'told_%d.vtp' --mesh falls/sheet.obj
said 'numbered files have no times: the first one is at 0 s'
printf "\0\0\0\3\0\0\0\1\0\0\0\0\x3d\xcc\xcc\xcd\x3f\x80\0\0" >uneven.mdd
head -c 36 /dev/zero >>uneven.mdd
convert uneven.mdd told.pc2
said 'are not even, but 0.1 s to 0.9 s apart; .mdd'
convert uneven.mdd 'told_%d.vtp' --pvd told.pvd
grep -q 'timestep="0.1' told.pvd && grep -q 'timestep="1"' told.pvd || { fault "times of the collection:"; cat told.pvd; }
# A PC2 file that begins at frame 5 and has every second one.
{ head -c 20 sheet.pc2; printf '\0\0\xa0\x40\0\0\0\x40'; tail -c +29 sheet.pc2; } >late.pc2
convert late.pc2 late.mdd --fps 10
convert late.mdd late_back.pc2
said 'the first one is at 0.5 s, and a second has 5$'
convert a.mdd b.pc2
cmp b.pc2 sheet.pc2 || fault "MDD to PC2 changed bytes"
convert sheet.mdd again.mdd
cmp again.mdd sheet.mdd || fault "MDD to MDD changed bytes"
convert a.mdd --mesh falls/sheet.obj e.glb
# glTF back into caches: the same floats, the same times.
convert e.glb f.mdd
cmp f.mdd sheet.mdd || fault "MDD to glTF to MDD changed bytes"
convert e.glb g.gltf
convert g.gltf f.pc2
cmp f.pc2 sheet.pc2 || fault "PC2 to MDD to .glb to .gltf to PC2 changed bytes"
said 'all surfaces became one mesh'
convert e.glb h.obj --frame 0
convert falls i.obj --body sheet --frame 0
cmp h.obj i.obj || fault "the mesh of a .glb is another"
# USD and NPZ back into caches: the same floats, the same times.
for name in sheet.usda sheet.npz sheet.glb; do
    convert falls $name --body sheet
    convert $name g.mdd
    cmp g.mdd sheet.mdd || fault "$name to MDD changed bytes"
done
convert falls.usda turned.glb
said 'z up: (x, y, z) became (x, z, -y)'
convert feet.usda metres.pc2
said 'metres, from feet: times 381 divided by 1250'
# A cache whose times do not rise becomes another animation with --fps.
zeros='\0\0\0\0' quarter='\x3e\x80\0\0'
printf "\0\0\0\2\0\0\0\1$zeros$zeros$quarter$quarter$zeros$quarter$quarter$quarter" >equal.mdd
convert equal.mdd equal.glb --fps 8
convert equal.glb rising.mdd
printf "\0\0\0\2\0\0\0\1$zeros\x3e\0\0\0$quarter$quarter$zeros$quarter$quarter$quarter" | cmp - rising.mdd || fault "times that do not rise, with --fps"
# MDD and animations as moving obstacles are what PC2 is; the latter bring their triangles. In glTF y points up.
for kind in pc2 mdd usda npz glb; do
    mesh='mesh: {file: falls/sheet.obj}'
    case $kind in usda | npz) mesh='' ;; glb) mesh='place: {up: y}' ;; esac
    cat >moved_$kind.yaml <<END
time: {step: 0.01 s, frames: 3}
cloth:
  - {name: top, mesh: {shape: rectangle, size: [0.2, 0.2], resolution: [4, 4]}, translate: [0, 0, 0.4]}
obstacles:
  - name: under
    $mesh
    motion: {sequence: {cache: sheet.$kind, interval: 0.01 s}}
END
    "$TULLE" run moved_$kind.yaml -o moved_$kind >out 2>&1 || { fault "a scene with $kind"; cat out; }
done
for kind in mdd usda npz glb; do
    cmp moved_pc2/under.pc2 moved_$kind/under.pc2 && cmp moved_pc2/top.pc2 moved_$kind/top.pc2 || fault "$kind moves otherwise than PC2"
done
cat >"a sheet é.obj" <<'END'
v 0 0 0
v 1 0 0
v 1 1 0.5
v 0 1 0
vt 0 0
vt 1 0
vt 1 1
vt 0.25 0.125
vt 0 1
f 1/1 2/2 3/3
f 1/4 3/3 4/5
END
convert "a sheet é.obj" seam.glb
convert "a sheet é.obj" seam.usda
convert "a sheet é.obj" seam.npz
# Frames that follow each other faster than any frame rate.
one='\x3f\x80\0\0'
printf "\0\0\0\2\0\0\0\1\0\0\0\0\x2b\x8c\xbc\xcc$one$one$one$one$one$one" >fast.mdd
convert fast.mdd fast.usda
convert fast.mdd fast.glb
convert fast.glb faster.mdd
cmp fast.mdd faster.mdd || fault "times near each other changed"
python3 "$here/convert_animations.py" || faults=1

refuse 'double is for .npz' falls x.glb --double
refuse 'interpolation is for .glb' falls x.npz --interpolation step
refuse 'fps is for formats' falls x.vtp --frame 0 --fps 3 --body sheet
refuse 'its frames have times' falls x.glb --fps 3
refuse 'its frames have times' sheet.usda x.glb --fps 3
refuse 'frame 1 is not later than frame 0; --fps gives' equal.mdd x.glb
sed 's/metersPerUnit = 1$/metersPerUnit = 0.5/' sheet.usda >half.usda
refuse 'its unit is 0.5 m, but only m' half.usda x.pc2
convert half.usda half.pc2 --from-units m
cmp half.pc2 sheet.pc2 || fault "--from-units is not what is taken"
sed 's/^\( *point3f\[\] points.timeSamples = \){/\1[/' sheet.usda >bad.usda
refuse 'bad.usda:[0-9]*:[0-9]*: ' bad.usda x.pc2
refuse 'is one of the files that are read' sheet.usda sheet.usda
refuse 'fps is "0"' sheet.pc2 x.glb --fps 0
refuse 'a point cache holds all frames' falls 'x_%d.mdd'
refuse 'is one of the files that are read' falls falls/sheet.pc2 --body sheet
refuse 'no folder/x.glb' falls 'no folder/x.glb'
refuse 'has 2 cloths\|bodies\|has no body' falls x.glb --body nobody
head -c 100 sheet.mdd >cut.mdd
refuse 'byte 100: the file ends here' cut.mdd x.pc2
head -c 7 sheet.mdd >cut.mdd
refuse 'byte 7: the file ends within the header' cut.mdd x.pc2

sed 's/"2.0"/"1.0"/' g.gltf >old.gltf
refuse 'version "1.0" of glTF' old.gltf x.pc2
sed 's/g.bin/none.bin/' g.gltf >lost.gltf
refuse 'none.bin' lost.gltf x.pc2
refuse 'is one of the files that are read' g.gltf g.gltf
# A buffer that is named a thousand times is opened and counted once.
python3 -c "
import json
text = json.load(open('g.gltf'))
text['buffers'] *= 2000
json.dump(text, open('often.gltf', 'w'))"
convert often.gltf o.pc2
cmp o.pc2 sheet.pc2 || fault "a buffer that is named often"
# Texts of many values or nodes are refused before they fill the memory.
python3 -c "
open('values.gltf', 'w').write('[' + '1,' * 8000000 + '1]')
open('nodes.gltf', 'w').write('{\"asset\": {\"version\": \"2.0\"}, \"nodes\": [' + '{\"mesh\":0},' * 1400000 + '{}]}')"
(ulimit -v 1000000; refuse 'values in 16000003 bytes of JSON text, which are too many' values.gltf x.pc2; exit $faults) || faults=1
(ulimit -v 1500000; refuse 'too many times its size' nodes.gltf x.pc2; exit $faults) || faults=1
rm values.gltf nodes.gltf
# The buffer of another name, which would be written beside x.gltf.
cp g.bin x.bin
sed 's/g\.bin/x.bin/' g.gltf >named.gltf
refuse 'x.bin: is one of the files that are read' named.gltf x.gltf
cmp g.bin x.bin || fault "a buffer that is read was written"
rm x.bin
head -c 3000 e.glb >cut.glb
refuse 'cut.glb: byte 8: should be of' cut.glb x.pc2

# A full disk: what was there stays, nothing is left behind.
mkdir disk
if mount -t tmpfs -o size=24k tmpfs disk 2>/dev/null; then
    for name in x.glb x.gltf x.usda x.npz x.mdd; do
        echo old >disk/$name
        "$TULLE" convert falls disk/$name --body sheet --subdivide 3 >out 2>err
        [ $? = 3 ] || { fault "$name on a full disk: exit $?"; cat err; }
        grep -q 'No space left' err || { fault "$name: a full disk is not told"; cat err; }
        [ "$(cat disk/$name)" = old ] || fault "$name: the old file is gone"
        [ "$(ls disk)" = $name ] || fault "$name: left behind: $(ls disk)"
        rm disk/*
    done
    umount disk
else
    echo "note: no right to mount a small disk; left out"
fi
exit $faults
