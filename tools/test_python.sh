#!/bin/sh
# The Python package over the libraries of a build directory says what the same program in C says.
# usage: test_python.sh LIBRARY_DIRECTORY HELLO_CLOTH      `make test-python` tests the package whole
set -eu
python=$(sh paper/find_python.sh 'cffi, numpy') || { echo "skipped: no python3 with cffi and numpy"; exit 77; }
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
cp -r python/tulle "$place/tulle"
"$python" python/generate.py include "$place/tulle" >/dev/null
export PYTHONPATH="$place" PYTHONDONTWRITEBYTECODE=1 TULLE_LIBRARY_PATH="$1"
"$python" examples/hello_cloth.py >"$place/python"
"$2" >"$place/c"
diff "$place/c" "$place/python"
cat "$place/python"
