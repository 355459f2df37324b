#!/usr/bin/env bash
# What the book's first scene says to type works: the scene runs, nothing intersects, every change by --set gives a scene that
# starts; and the scenes that guide pages show are read.
set -uo pipefail
pages=${TULLE_SOURCE_DIR:-$(cd "$(dirname "$0")/../.." && pwd)}/docs
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
faults=0
fail() { echo "$*"; faults=1; }

# yaml PAGE: its first block of YAML.
yaml() { sed -n '/^```yaml$/,/^```$/p' "$pages/$1" | sed '1d; /^```$/,$d'; }

yaml start/first_scene.md >napkin.yaml
[ -s napkin.yaml ] || fail "the first scene has no YAML"
"$TULLE" run napkin.yaml -o napkin -n 5 --progress none >out 2>&1 || { fail "the first scene does not run:"; cat out; }
"$TULLE" check napkin | tail -1 | grep -qx '0 intersections in 6 frames' || fail "the first scene intersects"

changes=0
while read -r change; do
    changes=$((changes + 1))
    "$TULLE" info napkin.yaml --set "$change" >out 2>&1 || { fail "--set $change is refused:"; cat out; }
done < <(sed -n "s/^    tulle run napkin.yaml .*--set '\{0,1\}\([^']*\)'\{0,1\}\$/\1/p" "$pages/start/first_scene.md")
[ "$changes" -ge 4 ] || fail "the first scene tells of $changes changes, 4 are expected"

# Pages of the guide show parts of scenes; with a time they are whole.
yaml guide/scene.md >scene.yaml
"$TULLE" info scene.yaml >out 2>&1 || { fail "the scene of guide/scene.md is refused:"; cat out; }
# square NAME Z: a square metre of cloth with texture coordinates.
square() {
    printf 'v 0 0 %s\nv 1 0 %s\nv 1 1 %s\nv 0 1 %s\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3\nf 1/1 3/3 4/4\n' "$2" "$2" "$2" "$2" >"$1"
}
square shirt.obj 1
square dress.obj 2
square pattern.obj 0
square cape.obj 3
sed -i -e '0,/^f/s/^f/usemtl collar\nf/' shirt.obj
printf '1\n1\n2\n0.5\n' >cape.txt
parts=$(awk '/^```/ { block += /^```yaml$/; is_yaml = /^```yaml$/; next } is_yaml { print >("part_" block ".txt") } END { print block }' \
    "$pages/guide/materials.md")
scenes=0
for part in $(seq "$parts"); do
    grep -q '^cloth:' "part_$part.txt" || continue
    scenes=$((scenes + 1))
    { echo 'time: {step: 1/90 s, frames: 1}'; cat "part_$part.txt"; } >materials.yaml
    "$TULLE" info materials.yaml >out 2>&1 || { fail "scene $part of guide/materials.md is refused:"; cat out; }
done
[ "$scenes" -ge 2 ] || fail "guide/materials.md shows $scenes scenes with cloth, 2 are expected"

[ $faults = 0 ] && echo "book: the first scene runs, $changes changes and $((scenes + 1)) more scenes are read"
exit $faults
