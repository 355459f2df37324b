#!/usr/bin/env bash
# tulle convert from every format to every other one and back, with random numbers: what each of them carries comes back.
# NPZ archives of all types, orders and methods are read.
set -uo pipefail
command -v python3 >/dev/null || { echo "skipped: there is no python3"; exit 77; }
here=$(cd "$(dirname "$0")" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 1
python3 "$here/convert_round_trips.py"
