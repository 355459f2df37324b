#!/usr/bin/env bash
# tulle run refuses bad input and bad output with exit 2 and a message, and creates nothing.
set -uo pipefail
work=$(mktemp -d)
trap 'chmod -R u+w "$work"; rm -rf "$work"' EXIT
cd "$work" || exit 1
scene=$TULLE_SOURCE_DIR/test/e2e/scenes/small.yaml
faults=0
fault() { echo "fault: $*"; faults=1; }

# refuse PATTERN ARGUMENTS...: exit 2, the pattern in the message, no directory "out".
refuse() {
    local pattern=$1
    shift
    "$TULLE" run "$@" --progress none >stdout 2>stderr </dev/null
    local code=$?
    [ $code = 2 ] || fault "run $*: exit $code, expected 2"
    grep -q -e "$pattern" stderr || { fault "run $*: no \"$pattern\" in:"; cat stderr; }
    [ -s stdout ] && fault "run $*: something on standard output"
    [ -e out ] && { fault "run $*: the output directory was made"; rm -rf out; }
}

# The command line.
refuse 'SCENE.yaml is missing'
refuse 'one too many' "$scene" "$scene" -o out
refuse 'unknown option --frame; did you mean --frames' "$scene" --frame 3 -o out
refuse 'whole number from 1' "$scene" --frames 0 -o out
refuse 'from 1 to 10000000' "$scene" --frames 10000001 -o out
refuse 'whole number from 1' "$scene" --threads -3 -o out
refuse 'should be one of: auto, json, none' "$scene" -o out --progress loud
refuse 'checkpoint-every' "$scene" -o out --checkpoint-every 3m
refuse 'give one of them' "$scene" -o out --resume --force

# The scene.
refuse 'missing.yaml' missing.yaml -o out
refuse '^"": cannot be opened' '' -o out
: >empty.yaml
refuse 'empty.yaml' empty.yaml -o out
head -c 3000 /dev/urandom >garbage.yaml
refuse 'garbage.yaml' garbage.yaml -o out
head -c 400 "$scene" >cut.yaml
refuse 'cut.yaml' cut.yaml -o out
refuse 'cloth' "$scene" -o out --set cloth=
refuse 'resolution' "$scene" -o out --set 'cloth[0].mesh.resolution=[1000000, 1000000]'
refuse 'time.step' "$scene" -o out --set time.step=-0.01
refuse 'time.step' "$scene" -o out --set time.step=.nan
refuse 'area_density' "$scene" -o out --set 'cloth[0].material={area_density: -1}'
refuse 'cloth\[0\].grain: is not a direction' "$scene" -o out --set 'cloth[0].grain=[0, 0, 0]'
refuse 'size' "$scene" -o out --set 'cloth[0].mesh.size=[0, 1]'
refuse 'cloth\[0\]: .*triangle 0 has an area of .*e-2[0-9] m^2 in the rest shape' "$scene" -o out --set 'cloth[0].scale=1e-12'
refuse 'small.yaml: .*floats in files hold no cloth lower than' "$scene" -o out --set 'cloth[0].translate=[900 km, 0, 0]'
refuse 'did you mean' "$scene" -o out --set 'cloth[0].mehs=3'

# Meshes.
bad_mesh() {
    printf '%b' "$2" >bad.obj
    refuse "$1" "$scene" -o out --set "cloth[0].mesh={file: $work/bad.obj}"
}
bad_mesh 'is empty' ''
bad_mesh 'bad.obj:2:5' 'v 0 0 0\nv 1 nan 0\nv 0 1 0\nf 1 2 3\n'
bad_mesh 'bad.obj:4:7: there is no vertex 4' 'v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n'
bad_mesh 'triangle' 'v 0 0 1\nv 1 0 1\nv 0 1 1\nf 1 2 2\n'
bad_mesh 'triangle' 'v 0 0 1\nv 1 0 1\nv 2 0 1\nf 1 2 3\n'
bad_mesh 'triangle' 'v 0 0 1\nv 1 0 1\nv 0 1 1\nf 1 2 3\nf 1 2 3\n'
bad_mesh 'vert' 'v 0 0 1\nv 1 0 1\nv 0 1 1\nv 5 5 5\nf 1 2 3\n'
bad_mesh 'edge' 'v 0 0 1\nv 1 0 1\nv 0 1 1\nv 0 -1 1\nv 0 0 2\nf 1 2 3\nf 2 1 4\nf 1 2 5\n'

# A start that intersects.
refuse 'sheet' "$scene" -o out --set 'cloth[0].translate=[0, 0, 0.05]'
grep -q '^tulle run: .* pairs of triangles intersect at the start:$' stderr || fault "the first line of a start that intersects: $(cat stderr)"
[ "$(grep -c '^  [0-9.e-]* m deep at (.*(vertices [0-9, ]*)$' stderr)" = 3 ] || fault "three pairs, a line each: $(cat stderr)"
grep -q '^To mend it, .*an exception to the promise' stderr || fault "how to mend it, on a line: $(cat stderr)"

# The output.
refuse 'missing' "$scene" -o missing/out
printf x >file
refuse 'file' "$scene" -o file
mkdir full
printf precious >full/mine.txt
for option in --resume --force; do refuse 'no run' "$scene" -o full $option; done
refuse 'no run' "$scene" -o full
[ "$(ls full)" = mine.txt ] || fault "a directory that holds other things was changed"
if [ "$(id -u)" != 0 ]; then
    mkdir closed && chmod a-w closed
    refuse 'closed/out' "$scene" -o closed/out
fi

# An existing run: refused, kept when another scene is resumed, replaced by --force.
"$TULLE" run "$scene" -o run --frames 2 --progress none >stdout || fault "two frames: exit $?"
cp -r run before
refuse 'holds a run already' "$scene" -o run
refuse 'the scene was changed' "$scene" -o run --resume --set 'cloth[0].translate=[0, 0, 0.3]'
diff -r run before || fault "a refused run changed the directory"
"$TULLE" run "$scene" -o run --force --frames 1 --progress none >stdout || fault "--force: exit $?"
grep -q '^frames: 2, ' stdout || fault "--force did not replace the run"

# After --set, the line that the message names goes on.
set_height=(--set 'cloth[0].translate=[0, 0, 0.3]')
"$TULLE" run "$scene" -o run --force --frames 1 "${set_height[@]}" --progress none >stdout || fault "--set: exit $?"
refuse "as it was: tulle run 'run/scene.yaml' -o 'run' --resume;" "$scene" -o run --resume
"$TULLE" run 'run/scene.yaml' -o 'run' --resume --frames 2 --progress none >stdout || fault "the line that was told: exit $?"
grep -q '^frames: 3, ' stdout || fault "the line that was told does not go on: $(cat stdout)"

# The default directory, and what ParaView reads.
"$TULLE" run "$scene" --frames 2 --write vtp --progress none >stdout || fault "vtp: exit $?"
grep -q '^result: small.run$' stdout || fault "no default directory: $(cat stdout)"
for file in sheet.pvd box.pvd ground.pvd vtp/sheet.000002.vtp vtp/ground.vtp; do
    [ -s "small.run/$file" ] || fault "small.run/$file is missing"
done
exit $faults
