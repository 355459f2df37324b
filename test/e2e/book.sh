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
sed -n '/^```yaml$/,/^```$/p' "$pages/guide/materials.md" | awk '/^```$/ { if (part) exit; next } /^cloth:/ { part = 1 } part' >part.yaml
[ -s part.yaml ] || fail "guide/materials.md has no scene with cloth"
{ echo 'time: {step: 1/90 s, frames: 1}'; cat part.yaml; } >materials.yaml
"$TULLE" info materials.yaml >out 2>&1 || { fail "the scene of guide/materials.md is refused:"; cat out; }

[ $faults = 0 ] && echo "book: the first scene runs, $changes changes and 2 more scenes are read"
exit $faults
