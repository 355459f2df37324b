#!/usr/bin/env bash
# Names in any script: a run, its files and what is made of it; names that no file may have are refused. A tab is named as
# a tab. A scene in place of a run is told to be run first.
set -uo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 1
faults=0
fault() { echo "fault: $*"; faults=1; }

cat >a.yaml <<'END'
time: {step: 1/90 s, frames: 2}
cloth:
  - {name: "赤い 布", mesh: {shape: rectangle, size: [0.2 m, 0.2 m], resolution: [4, 4]}, translate: [0, 0, 1]}
  - {name: "青い 布", mesh: {shape: rectangle, size: [0.2 m, 0.2 m], resolution: [4, 4]}, translate: [0, 0, 2]}
obstacles:
  - {name: Körper, mesh: {shape: sphere, radius: 0.1}}
  - {name: Kårper, mesh: {shape: sphere, radius: 0.1}, translate: [0, 0, -1]}
contact:
  pairs: [{between: ["赤い 布", Körper], friction: 0.4}]
END
"$TULLE" run a.yaml -o run --progress none >out 2>&1 || fault "run: $(cat out)"
files=$(cd run && LC_ALL=C ls -- *.obj *.pc2 | tr '\n' ' ')
[ "$files" = "K_rper-3.obj K_rper.obj ____-1.obj ____-1.pc2 ____.obj ____.pc2 " ] || fault "files: $files"
"$TULLE" check run >out 2>&1 || fault "check: $(cat out)"
grep -q '"name": *"赤い 布"' run/run.json || fault "run.json lacks a name"
"$TULLE" run run/scene.yaml -o again --progress none >out 2>&1 || fault "scene.yaml of the run: $(cat out)"
cmp -s run/scene.yaml again/scene.yaml || fault "scene.yaml is not read back as it was written"
"$TULLE" convert run x.usda >out 2>&1 || fault "convert: $(cat out)"
[ "$(grep -c 'def Mesh' x.usda)" = 4 ] || fault "x.usda: $(grep 'def Mesh' x.usda)"
[ "$(grep 'def Mesh' x.usda | sort -u | wc -l)" = 4 ] || fault "x.usda has one name twice"

# Names that mean devices on Windows, and points and blanks at an end.
cat >device.yaml <<'END'
time: {step: 1/90 s, frames: 1}
cloth:
  - {name: CON, mesh: {shape: rectangle, size: [0.2 m, 0.2 m], resolution: [2, 2]}, translate: [0, 0, 1]}
  - {name: con_, mesh: {shape: rectangle, size: [0.2 m, 0.2 m], resolution: [2, 2]}, translate: [0, 0, 2]}
obstacles:
  - {name: aux, mesh: {shape: box, size: [0.1, 0.1, 0.1]}, copies: {row: {count: 2, offset: [1, 0, 0]}}}
  - {name: "lpt1 .", mesh: {shape: box, size: [0.1, 0.1, 0.1]}, translate: [0, 0, -1]}
  - {name: Com7., mesh: {shape: box, size: [0.1, 0.1, 0.1]}, translate: [0, 0, -2]}
  - {name: nulls, mesh: {shape: box, size: [0.1, 0.1, 0.1]}, translate: [0, 0, -3]}
END
"$TULLE" run device.yaml -o device --progress none >out 2>&1 || fault "devices: $(cat out)"
files=$(cd device && LC_ALL=C ls -- *.obj | tr '\n' ' ')
[ "$files" = "CON_.obj Com7_..obj aux_.000.obj aux_.001.obj con_-1.obj lpt1_..obj nulls.obj " ] || fault "devices: $files"
"$TULLE" check device >out 2>&1 || fault "check: $(cat out)"

# refuse WORDS TEXT: a scene of the text is refused with the words.
refuse() {
    printf '%b' "$2" >b.yaml
    "$TULLE" info b.yaml >out 2>&1 && fault "not refused: $2"
    grep -qF -- "$1" out || fault "no \"$1\" for $2: $(cat out)"
}
for name in 'a/b' ' a' 'a ' '.a' 'a\\u200fb' 'a\\u2028b' 'a\\u00a0b' 'a:b' 'a\\tb'; do
    refuse 'b.yaml:1:20: obstacles[0].name: is ' "obstacles: [{name: \"$name\", mesh: {shape: box}}]\n" 2>/dev/null
done
refuse 'b.yaml:2:1: a tab: indent with spaces' 'time:\n\tstep: 1/90 s\n'
refuse 'b.yaml:2:3: a tab: indent with spaces' 'time:\n  \tstep: 1/90 s\n'
refuse 'b.yaml:3:1: a tab: indent with spaces' 'time:\n  step: 1/90 s\n\tframes: 3\n'
refuse 'b.yaml:2:1: a tab: indent with spaces' 'title: |\n\tabc\n'
refuse 'not valid YAML' 'time: [1\n'

# A scene where its run, or a mesh, belongs.
for words in "render a.yaml -o x.png" "check a.yaml" "convert a.yaml x.obj" "mend a.yaml -o x.obj"; do
    # shellcheck disable=SC2086
    "$TULLE" $words >out 2>&1 && fault "$words: taken"
    grep -qF 'a.yaml: is a scene, not a run: run it first: tulle run a.yaml -o DIR' out || fault "$words: $(cat out)"
done
"$TULLE" render x.usda -o x.png >out 2>&1 && fault "render of a file"
grep -qF 'x.usda: is a file, not the directory of a run' out || fault "render of a file: $(cat out)"
exit $faults
