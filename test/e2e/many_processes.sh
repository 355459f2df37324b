#!/usr/bin/env bash
# Writers and readers of one run directory side by side, some of them killed: see many_processes.py.
set -uo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 "$TULLE_SOURCE_DIR/test/e2e/many_processes.py" "$work"
