#!/bin/sh
# The tests of the add-on for Blender, without a window, and in one where xvfb-run is there. TULLE names the program. Exit code 77: no Blender.
# usage: run.sh [TEST...]      a test as test_bake.Bakes.test_units
set -eu
here=$(cd "$(dirname "$0")" && pwd)
TULLE=${TULLE:-$here/../../build/release/tulle}
export TULLE
command -v blender >/dev/null || { echo "skipped: Blender is not there; Debian's package is blender"; exit 77; }
[ -x "$TULLE" ] || { echo "the program $TULLE is not there: make" >&2; exit 1; }
home=$(mktemp -d)
trap 'rm -rf "$home"' EXIT
export BLENDER_USER_RESOURCES="$home" HOME="$home" PYTHONDONTWRITEBYTECODE=1
blender -b --factory-startup --python-exit-code 1 --python "$here/run.py" -- "$@"
[ $# = 0 ] || exit 0
if command -v xvfb-run >/dev/null && command -v xauth >/dev/null; then
    xvfb-run -a -s "-screen 0 1280x940x24" \
        blender --factory-startup --enable-event-simulate --python-exit-code 1 --python "$here/window.py" -- "${TULLE_PICTURES:-}"
else
    echo "not run: the test in a window; Debian's packages are xvfb and xauth"
fi
