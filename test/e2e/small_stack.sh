#!/usr/bin/env bash
# The program works within a stack of 64 KiB, as some systems give to a process or a thread.
set -uo pipefail
grep -q -a -e __asan_init -e __tsan_init -e __msan_init -e __gcov_ "$TULLE" && { echo "skipped: instrumented code needs more stack"; exit 77; }
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 1
faults=0
ulimit -s 64 || { echo "skipped: the stack cannot be limited"; exit 77; }
expect() {
    local wanted=$1
    shift
    "$TULLE" "$@" >said 2>&1
    local code=$?
    [ $code = "$wanted" ] || { echo "fault: tulle $*: exit $code, not $wanted"; tail -n 3 said; faults=1; }
}
expect 0 run "$TULLE_SOURCE_DIR/test/e2e/scenes/small.yaml" -n 4 -o small.run --record debug --progress none
expect 0 run "$TULLE_SOURCE_DIR/test/e2e/scenes/small.yaml" -n 6 -o small.run --record debug --resume --progress none
expect 0 check small.run
expect 0 info small.run
expect 0 convert small.run small.glb
expect 0 convert small.run small.usda --body sheet --subdivide 1
expect 0 check small.glb
expect 0 mend small.glb -o mended.npz --strength 0.5
grep -q "without Embree" <("$TULLE" render small.run --size 8x8 --samples 1 2>&1) || expect 0 render small.run --size 8x8 --samples 1 -o small.png
[ $faults = 0 ] && echo "64 KiB are enough"
exit $faults
