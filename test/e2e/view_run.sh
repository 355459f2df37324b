#!/bin/bash
# Runs and meshes by the protocol of `tulle view`: view_run.py.
set -eu
. "$(dirname "$0")/view_start.bash"
"$TULLE" run "$work/sheet.yaml" -o "$work/sheet.run" --record debug --progress none >/dev/null
python3 "$(dirname "$0")/view_run.py" "$work"
