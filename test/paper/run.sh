#!/bin/sh
# Runs the tests of paper/reproduce, test_*.py beside this file. Exit code 77 where Python lacks numpy or matplotlib.
set -eu
python=$(sh "$TULLE_SOURCE_DIR/paper/find_python.sh" 'numpy, matplotlib') ||
    { echo "skipped: no python3 with numpy and matplotlib"; exit 77; }
PYTHONPATH="$TULLE_SOURCE_DIR/paper" PYTHONDONTWRITEBYTECODE=1 exec "$python" -m unittest discover -s "$TULLE_SOURCE_DIR/test/paper"
