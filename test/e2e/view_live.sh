#!/bin/bash
# A live scene by its protocol: run, hold, move, change, rewind, save, repeat to the same bits; editing: view_live.py.
set -eu
. "$(dirname "$0")/view_start.bash"
python3 "$(dirname "$0")/view_live.py" "$work"
