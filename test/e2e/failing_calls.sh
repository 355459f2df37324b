#!/usr/bin/env bash
# Calls to the system that fail, once or for ever or halfway, at every place of a run, a resume, a conversion, a judgement and a picture: see
# failing_calls.py.
set -uo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
[ -f "${FAILING_CALLS:-}" ] || { echo "skipped: the library that lets calls fail was not built"; exit 77; }
python3 "$TULLE_SOURCE_DIR/test/e2e/failing_calls.py" "$work"
