#!/usr/bin/env bash
# Formats of floats: tulle convert tells, and tulle mend refuses, where rounding leads a surface through another or itself, also where none intersects afterwards.
# Far corners of a sloped triangle are rounded by up to a millimetre, so its middle sinks past a sheet right under it.
set -uo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 1
faults=0
fault() { echo "fault: $*"; faults=1; }

plane="v 20000 0 20000.0009\nv -10000 -17320 -9999.9996\nv -10000 17320 -9999.9996\n"
sheet="v -0.01 -0.01 -0.00972\nv 0.01 -0.01 0.01028\nv -0.01 0.01 -0.00972\nv 0.01 0.01 0.01028\n"
printf "%b%bf 1 2 3\nf 4 5 6\nf 6 5 7\n" "$plane" "$sheet" >both.obj
printf "%bf 1 2 3\n" "$plane" >plane.obj
printf "%bf 1 2 3\nf 3 2 4\n" "$sheet" >sheet.obj

said="surfaces that do not intersect pass through each other when they are rounded: in frame 0 floats move vertex 0 of"
for name in out.stl out.glb out.usda out.npz out.pc2 out.mdd; do
    "$TULLE" convert both.obj $name >said 2>&1 || fault "$name: $(cat said)"
    grep -q "in 1 frames $said 'both.obj' at .* by .*, and so through itself" said || fault "$name: $(cat said)"
done
"$TULLE" convert out.glb back.obj >/dev/null || fault "out.glb does not come back"
"$TULLE" check back.obj >/dev/null || fault "the rounded mesh intersects; this test is about one that does not"
for name in out.obj out.ply out.vtp; do
    "$TULLE" convert both.obj $name >said 2>&1 || fault "$name: $(cat said)"
    grep -q "pass through" said && fault "$name has doubles: $(cat said)"
done
"$TULLE" convert both.obj double.npz --double >said 2>&1 || fault "double.npz: $(cat said)"
grep -q "pass through" said && fault "double.npz has doubles: $(cat said)"
"$TULLE" convert double.npz again.pc2 >said 2>&1 || fault "again.pc2: $(cat said)"
grep -q "$said" said || fault "a format of floats from one of doubles: $(cat said)"
"$TULLE" convert sheet.obj near.glb >said 2>&1 || fault "near.glb: $(cat said)"
grep -q "pass through" said && fault "a mesh near the origin: $(cat said)"

# A run keeps obstacles that stand still in doubles; formats of floats do not.
cat >still.yaml <<'END'
time: {step: 0.01 s, frames: 3}
gravity: [0, 0, 0]
contact: {delta_c: 0.1 mm, xi: 0.01 mm}
cloth: [{name: sheet, mesh: {file: sheet.obj}}]
obstacles: [{name: plane, mesh: {file: plane.obj}}]
END
"$TULLE" run still.yaml -o still.run --progress none >said 2>&1 || fault "the run: $(cat said)"
"$TULLE" check still.run >said || fault "the run is not clean: $(tail -n 1 said)"
"$TULLE" convert still.run still.glb >said 2>&1 || fault "still.glb: $(cat said)"
grep -q "in 4 frames $said 'plane' at .* m by .* m, and so through 'sheet'" said || fault "still.glb: $(cat said)"

# A rigid body is written as a mesh about its centre and a pose, which are rounded on their own: the slab's corners are floats in the run,
# and its upper side rises by 0.3 mm in what a reader makes of them, so that the sheet 0.16 mm over it ends up inside.
slab="v 20000 0 20000.078125\nv -10001 -17320 -10001\nv -10000 17320 -10000.0126953125\n"
slab="${slab}v 20000 0 19692.078125\nv -10001 -17320 -10309\nv -10000 17320 -10308.0126953125\n"
slab="${slab}f 3 2 1\nf 5 6 4\nf 5 4 1\nf 2 5 1\nf 6 5 2\nf 3 6 2\nf 4 6 3\nf 1 4 3\n"
printf "%b" "$slab" >slab.obj
awk 'BEGIN { for (i = 0; i < 4; i++) { x = 0.04 * (i % 2) - 0.02; y = 0.04 * int(i / 2) - 0.02
    printf "v %.9g %.9g %.9g\n", x, y, 0.02197 + 1.0000151 * x - 0.0000142 * y }; print "f 1 2 3\nf 3 2 4" }' >over.obj
cat >rigid.yaml <<'END'
time: {step: 0.01 s, frames: 1}
gravity: [0, 0, 0]
contact: {delta_c: 0.1 mm, xi: 0.01 mm}
cloth: [{name: sheet, mesh: {file: over.obj}}]
obstacles: [{name: slab, mesh: {file: slab.obj}, dynamic: {density: 1}}]
END
"$TULLE" run rigid.yaml -o rigid.run --progress none >said 2>&1 || fault "the run of the slab: $(cat said)"
for name in rigid.glb rigid.gltf rigid.usda; do
    "$TULLE" convert rigid.run $name >said 2>&1 || fault "$name: $(cat said)"
    grep -q "in 2 frames surfaces .* floats move vertex 0 of 'slab' at .* m by .* m, and so through 'sheet'" said || fault "$name: $(cat said)"
    "$TULLE" convert $name back.obj --frame 0 >/dev/null || fault "$name does not come back"
    "$TULLE" check back.obj >/dev/null || fault "$name intersects; this test is about a sheet on the other side"
done
"$TULLE" convert rigid.run rigid.npz >said 2>&1 || fault "rigid.npz: $(cat said)"
grep -q "pass through" said && fault "corners that are floats: $(cat said)"
cat >tumble.yaml <<'END'
time: {step: 0.01 s, frames: 30}
cloth: [{name: sheet, mesh: {shape: rectangle, size: [0.4, 0.4], resolution: [9, 9]}, pins: [{vertices: [0-9, 17, 18, 26, 27, 35, 36, 44, 45, 53, 54, 62, 63, 71-80]}]}]
obstacles:
  - {name: box, mesh: {shape: box, size: [0.1, 0.06, 0.04]}, rotate: [30, 40, 50], translate: [0, 0.02, 0.07], dynamic: {density: 400, spin: [9, 5, 7]}}
END
"$TULLE" run tumble.yaml -o tumble.run --progress none >said 2>&1 || fault "the box: $(cat said)"
for name in tumble.glb tumble.usda; do
    "$TULLE" convert tumble.run $name >said 2>&1 || fault "$name: $(cat said)"
    grep -q "1 move by translation and rotation" said || fault "the box is not rigid: $(cat said)"
    grep -q "pass through" said && fault "a box that turns near the origin: $(cat said)"
done

# tulle mend: the cloth is on one side of itself, and rounded on the other.
printf "%bf 1 2 3\nf 4 5 6\nf 6 5 7\n" "$plane$sheet" >both_0.obj
cp both_0.obj both_1.obj
for name in out.pc2 out.mdd out.glb out.usda out.npz; do
    rm -f $name
    "$TULLE" mend 'both_%d.obj' -o $name >said 2>&1
    code=$?
    [ $code = 2 ] || fault "mend to $name: exit $code, $(cat said)"
    grep -q "frame 0: floats move vertex 0 of 'both_%d.obj' at .* m by .* m, and so through itself; a format with doubles" said ||
        fault "mend to $name: $(cat said)"
    [ ! -e $name ] || fault "mend wrote $name"
done
for name in 'mended_%d.obj' 'mended_%d.vtp' 'mended.npz --double'; do
    # shellcheck disable=SC2086
    "$TULLE" mend 'both_%d.obj' -o $name >said 2>&1 || fault "mend to $name: $(cat said)"
    grep -q "all 2 frames are as they were given" said || fault "mend to $name: $(cat said)"
done

# A body whose node moves floats to where none are, and which --bodies-out writes anew, by floats.
python3 - <<'END' || fault "no glTF was made"
import base64, json, struct
corners = [(20000, 20000, 0), (-10000, -10000, 17320), (-10000, -10000, -17320)]
data = b"".join(struct.pack("<3f", *corner) for corner in corners)
json.dump({
    "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0, "translation": [0, 0.0004, 0]}],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
    "buffers": [{"byteLength": 36, "uri": "data:application/octet-stream;base64," + base64.b64encode(data).decode()}],
    "bufferViews": [{"buffer": 0, "byteLength": 36}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}]}, open("plane.gltf", "w"))
END
cp sheet.obj sheet_0.obj
cp sheet.obj sheet_1.obj
"$TULLE" mend 'sheet_%d.obj' --body plane.gltf -o 'hung_%d.obj' >said 2>&1 || fault "a body that is not written: $(cat said)"
rm -f hung_*.obj
"$TULLE" mend 'sheet_%d.obj' --body plane.gltf -o 'hung_%d.obj' --bodies-out met >said 2>&1 && fault "a body was rounded through the cloth"
grep -q "frame 0: floats move vertex 0 of 'plane.gltf' .*, and so through 'sheet_%d.obj'" said || fault "a body of floats: $(cat said)"
[ ! -e hung_0.obj ] && [ ! -e met ] || fault "mend wrote what is rounded through"
[ $faults = 0 ] && echo "what floats lead through each other is told"
exit $faults
