#!/bin/sh
# The Python package of a build directory says what the same program in C says. `make test-python` tests it whole.
# usage: test_python.sh PYTHON PACKAGE_DIRECTORY HELLO_CLOTH
set -eu
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
PYTHONPATH="$2" PYTHONDONTWRITEBYTECODE=1 "$1" examples/hello_cloth.py >"$place/python"
"$3" >"$place/c"
diff "$place/c" "$place/python"
cat "$place/python"
