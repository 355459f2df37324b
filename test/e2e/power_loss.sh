#!/usr/bin/env bash
# What a power failure at any moment may leave of runs and conversions: see power_loss.py.
set -uo pipefail
work=$(mktemp -d -p /dev/shm 2>/dev/null || mktemp -d) # flushes take no time there
trap 'rm -rf "$work"' EXIT
[ -f "${FAILING_CALLS:-}" ] || { echo "skipped: the library that logs calls was not built"; exit 77; }
python3 "$TULLE_SOURCE_DIR/test/e2e/power_loss.py" "$work"
