#!/usr/bin/env bash
# From which side `tulle render` looks where something hides the cloth from the usual one.
set -uo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 1
faults=0
fail() { echo "$1"; faults=1; }

# make NAME OBSTACLES: a run of a rag that falls among them.
make() {
    cat >"$1.yaml" <<END
time: {step: 0.01 s, frames: 3}
cloth:
  - {name: rag, mesh: {shape: rectangle, size: [0.3, 0.3], resolution: [5, 5]}, translate: [0, 0, 0.06]}
obstacles:
  - {name: ground, mesh: {shape: plane, size: [3, 3]}}
$2
END
    "$TULLE" run "$1.yaml" -o "$1.run" --progress none >/dev/null || { echo "run of $1 fails"; exit 1; }
}
wall() { echo "  - {name: $1, mesh: {shape: box, size: [$2, $3, $4]}, translate: [$5, $6, $7]}"; }
crate=$(wall back 0.6 0.02 0.4 0 0.3 0.2; wall front 0.6 0.02 0.4 0 -0.3 0.2; wall right 0.02 0.6 0.4 0.3 0 0.2; wall left 0.02 0.6 0.4 -0.3 0 0.2)
make open ""
if [[ $("$TULLE" render open.run --size 8x8 --samples 1 2>&1) = *libembree-dev* ]]; then
    echo "skipped: built without Embree"
    exit 77
fi
make wall "$(wall plank 1.2 0.02 0.8 0 -0.3 0.4)"
make crate "$crate"
make closed "$crate
$(wall lid 0.64 0.64 0.02 0 0 0.42)"

# expect RUN PATTERN_OUT PATTERN_ERR OPTIONS...: lines of both streams; an empty pattern: no line about it.
expect() {
    local run=$1 said=$2 warned=$3
    shift 3
    "$TULLE" render "$run" --size 32x18 --samples 1 --progress none "$@" >out 2>err </dev/null || { fail "render $run $* fails: $(cat err)"; return; }
    [ "$(grep -c '^camera: ' out)" = "$([ -n "$said" ] && echo 1 || echo 0)" ] || fail "$run $*: $(grep '^camera:' out)"
    grep -q -e "$said" out || fail "$run $*: no \"$said\" in: $(cat out)"
    [ -n "$warned" ] || [ ! -s err ] || fail "$run $*: a warning without reason: $(cat err)"
    grep -q -e "$warned" err || [ -z "$warned" ] || fail "$run $*: no \"$warned\" in: $(cat err)"
}
# What stands before the cloth is looked past: beside a plank, over the sides of a crate.
expect open.run "" ""
expect wall.run 'for from the usual side "plank" hides [0-9]* % of the cloth' ""
expect crate.run '^camera: orbit=.*deg,[4-9][0-9]deg, for from the usual side "[a-z]*" hides 100 % of the cloth' ""
# One side for a series, whatever frame is asked for first; the same bytes for any number of threads.
expect crate.run '^camera: orbit=' "" --frames all -o 'side_%d.png' --threads 3
cp side_3.png all.png
expect crate.run '^camera: orbit=' "" --frame 3 -o one.png --threads 1
cmp -s one.png side_0.png && fail "frames 0 and 3 look the same"
rm side_*
expect crate.run '^camera: orbit=' "" --frames all -o 'side_%d.png' --threads 1
cmp side_3.png all.png || fail "threads change the side"
# What the user asks for stays; that no cloth is seen is said.
expect crate.run "" 'no cloth is seen: "[a-z]*" hides it' --camera orbit=-54deg,10deg
expect crate.run "" "" --camera orbit=-54deg,85deg
expect closed.run "" 'no cloth is seen: "[a-z]*" hides it; leave that out with --hide'
expect closed.run '^camera: orbit=' "" --hide lid
expect closed.run "" "" --hide rag
exit $faults
