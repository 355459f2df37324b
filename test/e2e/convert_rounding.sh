#!/usr/bin/env bash
# Formats of floats: tulle convert tells where rounding leads a surface through another or itself, also where none intersects afterwards.
# Far corners of a sloped triangle are rounded by up to a millimetre, so its middle sinks past a sheet right under it.
set -uo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 1
faults=0
fault() { echo "fault: $*"; faults=1; }

plane="v 20000 0 20000.0009\nv -10000 -17320 -9999.9996\nv -10000 17320 -9999.9996\n"
sheet="v -0.005 -0.005 -0.00472\nv 0.005 -0.005 0.00528\nv -0.005 0.005 -0.00472\nv 0.005 0.005 0.00528\n"
printf "%b%bf 1 2 3\nf 4 5 6\nf 6 5 7\n" "$plane" "$sheet" >both.obj
printf "%bf 1 2 3\n" "$plane" >plane.obj
printf "%bf 1 2 3\nf 3 2 4\n" "$sheet" >sheet.obj

said="surfaces that do not intersect pass through each other where they are rounded: in frame 0 floats move vertex 0 of"
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
[ $faults = 0 ] && echo "what floats lead through each other is told"
exit $faults
