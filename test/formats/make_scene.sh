#!/bin/sh
# Makes what the other programs are to open: a run with cloth, a wall, and three rigid bodies that are copies, converted to
# every format; a mesh with texture coordinates.
# usage: make_scene.sh FOLDER      TULLE: the program
set -eu
cd "$1"
cat >scene.yaml <<'END'
time: {step: 0.01 s, frames: 12}
cloth:
  - name: sheet
    mesh: {shape: rectangle, size: [0.4, 0.4], resolution: [8, 8]}
    translate: [0, 0, 0.2]
obstacles:
  - name: floor
    mesh: {shape: plane, size: [2, 2]}
  - name: box
    mesh: {shape: box, size: [0.1, 0.1, 0.1]}
    translate: [0, 0, 0.3]
    dynamic: {mass: 0.2 kg}
    copies: {row: {count: 3, offset: [0.15, 0.02, 0.18]}}
END
"$TULLE" run scene.yaml -o falls >/dev/null 2>&1
cat >seam.obj <<'END'
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
convert() { "$TULLE" convert "$@" >/dev/null; }
convert falls falls.npz
convert falls falls.glb
convert falls falls.gltf
convert falls falls_step.glb --interpolation step
convert falls 'falls_%04d.glb' --frames 6
convert falls falls.usda
convert falls sheet.glb --body sheet
convert falls sheet_thin.glb --body sheet --frames ::4
convert falls sheet.usda --body sheet
convert falls 'sheet_%04d.usda' --body sheet
convert falls sheet_up.npz --body sheet --up y
convert falls sheet.npz --body sheet
convert falls sheet.mdd --body sheet
convert falls sheet.pc2 --body sheet
convert falls sheet.obj --body sheet --frame 0
convert sheet.pc2 points.glb
convert seam.obj 'a seam é.gltf' --up z
convert seam.obj seam.usda
