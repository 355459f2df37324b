#!/bin/sh
# Runs the tests of paper/reproduce, test_*.py beside this file. Exit code 77 where Python lacks numpy, cffi or matplotlib, and where the package is not built.
set -eu
export PYTHONPATH="$TULLE_SOURCE_DIR/paper:$TULLE_PYTHON"
python=$(sh "$TULLE_SOURCE_DIR/paper/find_python.sh" 'matplotlib, tulle') ||
    { echo "skipped: no python3 with numpy, cffi and matplotlib"; exit 77; }
PYTHONDONTWRITEBYTECODE=1 exec "$python" -m unittest discover -s "$TULLE_SOURCE_DIR/test/paper"
